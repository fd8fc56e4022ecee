"""Two perceptually uniform colour maps: RISING gets lighter, so that it also reads in grey; SIGNED is lightest at 0.

Their steps are equal in the colour space OKLab (Ottosson 2020), in which equal distances look equal.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

STEPS = 256
# sRGB colours at even steps from the low end to the high end; the middle of SIGNED is 0, and both of its ends are dark
RISING = (
    "444d84 40598e 3a6597 2f71a1 1c7eab 198ba8 1797a4 16a4a0 18b09b "
    "4aba90 6ac383 85cc73 9ed55f b8dd5e d0e55d e8ed5c fff45a"
)
SIGNED = (
    "0052ab 1168b5 2c7ec0 4493ca 5aa8d4 82badb a7cce2 cbdde8 eeeeee "
    "efd9cc eec4a9 ebaf86 e89961 d87e4f c7643f b6492f a52b1e"
)


def table(signed: bool = False) -> "np.ndarray":
    """Return the colours (STEPS, 3) of a scale as sRGB, from its low end to its high end."""
    import numpy as np

    colours = np.array([list(bytes.fromhex(each)) for each in (SIGNED if signed else RISING).split()]) / 255
    at = np.linspace(0, len(colours) - 1, STEPS)
    return np.stack([np.interp(at, range(len(colours)), column) for column in colours.T], axis=1)


def coloured(values: "np.ndarray", ends: tuple[float, float], signed: bool = False) -> "np.ndarray":
    """Return the colour (n, 3) of each value on a scale with these ends."""
    import numpy as np

    low, high = ends
    share = (np.asarray(values) - low) / max(high - low, 1e-30)
    return table(signed)[(share * (STEPS - 1)).round().clip(0, STEPS - 1).astype(int)]
