"""Colours for numbers: as far apart to the eye as the numbers are, and lighter the higher, so that grey says it too.

The colours run evenly through the space OKLab (Ottosson 2020), in which equal steps look equal.
"""

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

STEPS = 256
# lightness, chroma and hue [degrees] of evenly spaced colours
RISING = ((0.44, 0.09, 275.0), (0.56, 0.11, 235.0), (0.68, 0.12, 180.0), (0.81, 0.16, 130.0), (0.95, 0.17, 105.0))
SIGNED = ((0.45, 0.16, 255.0), (0.70, 0.10, 235.0), (0.95, 0.0, 0.0), (0.75, 0.12, 55.0), (0.48, 0.16, 30.0))


def table(signed: bool = False) -> "np.ndarray":
    """Return the colours (STEPS, 3) of a scale as sRGB, from its low end to its high one.

    Args:
        signed: the middle is 0, and both ends are dark.
    """
    import numpy as np

    corners = []
    for light, chroma, hue in SIGNED if signed else RISING:
        corners.append((light, chroma * math.cos(math.radians(hue)), chroma * math.sin(math.radians(hue))))
    at = np.linspace(0, len(corners) - 1, STEPS)
    light, a, b = (np.interp(at, range(len(corners)), column) for column in zip(*corners, strict=True))
    return _srgb(light, a, b)


def _srgb(light: "np.ndarray", a: "np.ndarray", b: "np.ndarray") -> "np.ndarray":
    """Return colours (n, 3) of OKLab as sRGB."""
    import numpy as np

    long = (light + 0.3963377774 * a + 0.2158037573 * b) ** 3
    middle = (light - 0.1055613458 * a - 0.0638541728 * b) ** 3
    short = (light - 0.0894841775 * a - 1.2914855480 * b) ** 3
    linear = np.stack([
        4.0767416621 * long - 3.3077115913 * middle + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * middle - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * middle + 1.7076147010 * short,
    ], axis=1).clip(0, 1)  # fmt: skip
    return np.where(linear > 0.0031308, 1.055 * linear ** (1 / 2.4) - 0.055, 12.92 * linear)


def coloured(values: "np.ndarray", ends: tuple[float, float], signed: bool = False) -> "np.ndarray":
    """Return the colour (n, 3) of each value on a scale with these ends."""
    import numpy as np

    low, high = ends
    share = (np.asarray(values) - low) / max(high - low, 1e-30)
    return table(signed)[(share * (STEPS - 1)).round().clip(0, STEPS - 1).astype(int)]
