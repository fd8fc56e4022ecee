"""Find the first touch on a loading stroke, and the force the load cell shows before it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats
from .segments import two_pieces
from .strokes import roughness

_SHARES = (0.10, 0.05, 0.025, 0.0125)  # of the force: windows in which the press begins as a straight line
_CLEAR = 5.0  # times the noise: a force that is no longer the load cell's own
_SURE = 3.5  # standard errors
_ROWS = 6
_HOLDS = 2.0  # times the noise: residuals of a law that holds
_HARMLESS = 0.02  # of the range of depth: touches that differ by less
_CLEARLY = 0.8  # a hinge with this share of a parabola's residuals, or the reverse, is clear
_DECISIVE = 12.0  # twice the gain in log likelihood that settles the rest


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """Hold the depth [m] of the first touch, the force there [N], whether rows came before; a note and a doubt."""

    depth: float
    tare: float
    seen: bool
    note: str
    doubt: str = ""


def find_touch(depth: Floats, force: Floats) -> Touch:
    """Find the first touch of a loading stroke (n,) [m], [N] whose force grows with depth."""
    noise = roughness(force)
    rest = float(np.median(force[: max(3, min(20, len(force) // 50))]))
    span = float(force.max() - rest)
    first = _already_touching(depth, force, rest, noise)
    for share in _SHARES:
        level = rest + max(2 * _CLEAR * noise, share * span)
        end = max(_sustained(force > level), _sustained(force > rest + _CLEAR * noise) + _ROWS)
        x, f = depth[:end], force[:end]
        pieces = two_pieces(x, f, left="level")
        if pieces is None or not _is_hinge(x, pieces.join, noise, pieces.slope2):
            continue
        before = x < pieces.join
        bent = _bent_residual(x, f)
        if pieces.residual * _CLEARLY > bent or not _is_level(x[before], f[before], noise):
            continue
        seen = Touch(
            depth=pieces.join, tare=pieces.offset, seen=True,
            note=f"First touch at {1e3 * pieces.join:.3f} mm of the file; {pieces.offset:+.4g} N before it is no load.",
        )  # fmt: skip
        if pieces.residual < _CLEARLY * bent:
            return seen
        misfit = {touch: _misfit(depth, force, touch) for touch in (seen, first)}
        best, other = sorted((seen, first), key=misfit.__getitem__)
        settled = len(depth) * np.log(max(misfit[other], 1e-300) / max(misfit[best], 1e-300)) > _DECISIVE
        if misfit[best] > len(depth) * (_HOLDS * noise) ** 2:  # the law does not hold: it cannot tell them apart
            best, other, settled = first, seen, False
        if settled or abs(best.depth - other.depth) < _HARMLESS * np.ptp(depth):
            return best
        doubt = (
            f"The noise hides the first touch: it was taken at {1e3 * best.depth:.3g} mm, but "
            f"{1e3 * other.depth:.3g} mm is possible. If you know it, give it with --contact-mm."
        )
        return replace(best, doubt=doubt)
    return first


def _misfit(depth: Floats, force: Floats, touch: Touch) -> float:
    """Return the sum of squared residuals of the two-piece law from a touch on."""
    x, f = depth - touch.depth, force - touch.tare
    pieces = two_pieces(x[x > 0], f[x > 0], left="origin")
    return float((f[x <= 0] ** 2).sum()) + (pieces.residual if pieces else np.inf)


def _already_touching(depth: Floats, force: Floats, rest: float, noise: float) -> Touch:
    """Return the touch of a file that begins in contact: at depth 0, or where the first rows point back to."""
    span, first = float(np.ptp(depth)), float(depth[0])
    if abs(first) < 0.02 * span:
        return Touch(depth=0.0, tare=0.0, seen=False, note="The file begins at the touch: depth 0 as the file has it.")
    end = max(_sustained(force > rest + 0.1 * (force.max() - rest)), 2 * _ROWS)
    slope, _ = np.polyfit(depth[:end] - first, force[:end], 1)
    back = rest / slope if slope > 0 and abs(rest) > _CLEAR * noise else 0.0
    note = f"The file begins in contact; the touch is taken at {1e3 * (first - back):.3f} mm."
    return Touch(depth=first - back, tare=0.0, seen=False, note=note)


def _sustained(above: np.ndarray) -> int:
    """Return the first row from which three in a row are above, else the number of rows."""
    three = above[:-2] & above[1:-1] & above[2:]
    return int(three.argmax()) if three.any() else len(above)


def _is_level(x: Floats, f: Floats, noise: float) -> bool:
    """Tell whether the force before a hinge neither rises nor falls by more than chance or a little drift."""
    if len(x) < 3 or np.ptp(x) == 0:
        return True
    centred = x - x.mean()
    slope = float(centred @ f / (centred @ centred))
    scatter = f - f.mean() - slope * centred
    error = np.sqrt(scatter @ scatter / max(len(x) - 2, 1) / (centred @ centred))
    return abs(slope) < _SURE * error or abs(slope) * float(np.ptp(x)) < noise


def _bent_residual(x: Floats, f: Floats) -> float:
    """Return the sum of squared residuals of a parabola: of a curve that bends from the first row on."""
    u = (x - x.mean()) / (np.ptp(x) or 1.0)
    design = np.stack([np.ones_like(u), u, u * u], axis=1)
    return float(((f - design @ np.linalg.lstsq(design, f, rcond=None)[0]) ** 2).sum())


def _is_hinge(x: Floats, join: float, noise: float, slope: float) -> bool:
    """Tell whether the rows before a hinge are enough to know it is not the first row."""
    before, after = x[x < join], x[x >= join]
    if len(before) < 3 or slope <= 0:
        return False
    error = noise / slope * np.sqrt(1 / len(before) + 1 / max(len(after), 1))
    return join - float(x[0]) > _SURE * error
