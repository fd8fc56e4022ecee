"""Find the first touch on a loading stroke, and the force the load cell shows before it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .fit import Fit, fit_law, independent_rows
from .parameters import Free
from .question import Candidate, Question, Undecided
from .segments import two_pieces
from .strokes import roughness

_SHARES = (0.10, 0.05, 0.025, 0.0125)  # of the force: windows in which the press begins as a straight line
_CLEAR = 5.0  # times the noise: a force that is no longer the load cell's own
_SURE = 3.5  # standard errors
_ROWS = 6
_FEW = 3  # rows
_RISE = 0.01  # of the range of force: a preload that changes less
_TRAVEL = 0.05  # of the range of depth: a force over less of it may be a preload
_STANDS = 0.005  # of the depth of a window: travel that is none
_BOUNDED = 0.5  # of the range of depth: a touch whose interval reaches farther is not determined
_FITS = 2.0  # times the noise: residuals of a law that fits
_HARMLESS = 0.02  # of the range of depth: touches that differ by less
_CLEARLY = 0.8  # a hinge with this share of a parabola's residuals, or the reverse, is clear
_DECISIVE = 12.0  # twice the gain in log likelihood that settles which touch it was
_LIKELY = 4.0  # and that makes another one as likely
_NOTICEABLE = 0.05  # of a constant: less is below what can be felt
_STARTS = np.geomspace(0.01, 0.7, 20)  # of the range of depth: where a touch may hide
_NEARER = np.linspace(0.8, 1.25, 10)
_ENOUGH = 1000  # rows to compare touches by


Reading = Callable[[float], float]  # what the file calls a depth [m], in mm


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstTouch:
    """The first touch of a press.

    depth: where it is [m].
    tare: the force there [N].
    free: which of both are estimates; see fit_law.
    """

    depth: float
    tare: float
    free: Free


def find_touch(depth: Floats, force: Floats) -> FirstTouch:
    """Find the first touch of a loading stroke (n,) [m], [N] whose force grows with depth."""
    noise = roughness(force)
    rest = float(np.median(force[: max(3, min(20, len(force) // 50))]))
    span = float(force.max() - rest)
    for share in _SHARES:
        level = rest + max(2 * _CLEAR * noise, share * span)
        end = max(_sustained(force > level), _sustained(force > rest + _CLEAR * noise) + _ROWS)
        x, f = depth[:end], force[:end]
        pieces = two_pieces(x, f, left="level")
        if pieces is None or not _is_hinge(x, pieces.join, noise, pieces.slope2):
            continue
        before = x < pieces.join
        loaded = pieces.offset > max(_CLEAR * noise, _RISE * span)
        if loaded and pieces.join - depth[0] < _TRAVEL * np.ptp(depth):
            continue  # too little travel to know that what is on the cell is no preload
        if pieces.residual < _CLEARLY * _bent_residual(x, f) and _is_level(x[before], f[before], noise):
            return FirstTouch(depth=pieces.join, tare=pieces.offset, free=("contact", "tare"))
    return _already_touching(depth, force, rest, noise)


def settle(depth: Floats, force: Floats, free: Free, reading: Reading) -> tuple[Fit, str]:
    """Fit the law with the touch as it was found, or as the whole curve would rather have it.

    Where the noise hides the touch, or the file begins with a force on the cell, several readings answer the curve as
    well. Then the fit comes with a message about what they change; where none is more likely, it is asked. A touch
    before the file begins, or one that nothing determines, is asked too.

    Args:
        depth: (n,) [m] from the touch that was found.  force: (n,) [N].  free: see fit_law.
        reading: what the file calls a depth [mm], for the messages.

    Returns:
        the fit, its contact from depth 0, and a message where the touch is uncertain, else "".

    Raises:
        Undecided: whether the press began before the file, or the load cell was not tared.
    """
    first, span = float(depth[0]), float(np.ptp(depth))
    loaded, pressed_before = _preload(depth, force) if len(free) < 2 else (0.0, 0.0)
    begins = first - pressed_before
    nearly = pressed_before <= _HARMLESS * span or abs(reading(begins)) < 1e3 * _HARMLESS * span  # or the file's own 0
    if pressed_before > 0 and nearly:
        fit, doubt = _read(depth, force, begins, ("contact",))[0], ""
        if abs(fit.contact.value - begins) > _HARMLESS * span:  # the law does not hold near the touch
            fit, _ = _read(depth, force, begins, ())
        return fit, doubt
    fit, doubt = _likeliest(depth, force, free, reading, loaded > 0)
    contact = fit.contact
    asked = pressed_before > 0 and "tare" not in fit.parameters.free
    if asked or contact.value < first - _HARMLESS * span or contact.half_width > _BOUNDED * span:
        before = begins if pressed_before > 0 else first - min(max(first - contact.value, 0.0), span)
        raise Undecided(_begun(reading(first), reading(before), loaded or float(np.median(force[:_FEW]))))
    return fit, doubt


def _preload(depth: Floats, force: Floats) -> tuple[float, float]:
    """Return the force [N] with which a stroke begins and how far it was pressed by then [m]; 0, 0 for none."""
    first, span = float(np.median(force[:_FEW])), float(np.ptp(force))
    end = max(_sustained(force > first + _SHARES[0] * span), max(_FEW, min(2 * _FEW, len(force) // 4)))
    x, f = depth[:end] - depth[0], force[:end]
    if np.ptp(x) == 0:
        return 0.0, 0.0
    slope, loaded = np.polyfit(x, f, 1)
    residual = float(np.std(f - loaded - slope * x, ddof=2))
    error = residual * math.sqrt(1 / len(x) + x.mean() ** 2 / ((x - x.mean()) ** 2).sum())
    if loaded < max(_SURE * error, _RISE * span) or slope <= 0:
        return 0.0, 0.0
    return float(loaded), float(loaded / slope)


def _likeliest(depth: Floats, force: Floats, free: Free, reading: Reading, loaded_before: bool) -> tuple[Fit, str]:
    """Return the fit with the likeliest touch, and a message where another is nearly as likely."""
    found = fit_law(depth, force, free=free)
    if len(free) == 2:
        return found, _drift(found, depth, force)
    step = -(-len(depth) // _ENOUGH)
    x, f = depth[::step], force[::step]
    first, span = float(x[0]), float(np.ptp(x))
    readings = [_try(x, f, first, (name,)) for name in ("tare", "contact")]
    readings.append(_try(x, f, _likely_touch(x, f), ("contact", "tare")))
    if None in readings:  # too few rows to compare
        return found, ""
    untared, begun, hinge = (each for each in readings if each is not None)
    if free:  # steps from where the file begins may end before the touch
        again = _try(depth, force, hinge[0].contact.value, free)
        found = min(found, *([again[0]] if again else []), key=lambda fit: _loss(fit, x, f))
    late = begun[0].contact.value - first  # travel before the touch
    loss, least = _loss(found, x, f), min(untared[1], hinge[1], *([begun[1]] if late > 0 else []))
    if least > len(x) * (_FITS * roughness(f)) ** 2:  # the law does not fit: it cannot tell touches apart
        return found, _drift(found, depth, force)
    count = independent_rows(len(x), hinge[0].correlation)

    def gain(one: tuple[Fit, float]) -> float:
        return count * math.log(max(loss, 1e-300) / max(one[1], 1e-300))

    loaded, price = untared[0].tare, math.log(len(x))
    unsure = -late > max(_SURE * begun[0].contact.error, _HARMLESS * span)
    # depth 0 of a file is a touch, and a force where it begins a preload, until the curve decides against it
    doubtful = 0.0 if free and not loaded_before else _DECISIVE + price
    if gain(hinge) > price + max(gain(untared), 0.0) + doubtful:
        settled, _ = _read(depth, force, hinge[0].contact.value, ("contact", "tare"))
        return settled, _drift(settled, depth, force)
    if not free and late > _SURE * begun[0].contact.error and gain(begun) > price + doubtful:
        settled, _ = _read(depth, force, begun[0].contact.value, ("contact",))  # too few rows before for a hinge
        return settled, ""
    if loaded < 0 and gain(untared) > price + doubtful:  # what is pressed does not pull
        settled, _ = _read(depth, force, first, ("tare",))
        return settled, Message(
            "The force is {loaded:.3g} N where the file begins: it was taken for no load.", loaded=loaded
        )
    if unsure and (free or gain(untared) > _DECISIVE + price):
        raise Undecided(_begun(reading(first), reading(begun[0].contact.value), loaded))
    if gain(hinge) > _LIKELY and _differs(found, hinge[0]):
        return found, _hidden(reading, found, hinge[0])
    return found, ""


def _hidden(reading: Reading, found: Fit, other: Fit) -> str:
    return Message(
        "The noise hides the first touch.\nIt was taken at {touch:.3g} mm, but {other:.3g} mm is as likely, with K1 "
        "{K1} N/mm and x0 {x0} mm.",
        touch=reading(found.contact.value), other=reading(other.contact.value), K1=other.K1.text(1e3),
        x0=other.x0.text(1e-3)
    )  # fmt: skip


def _drift(fit: Fit, depth: Floats, force: Floats) -> str:
    """Return a message about how much the force changes before the touch, "" where it does not."""
    before = depth < fit.contact.value
    x, f = depth[before], force[before]
    if len(x) < _ROWS or _is_level(x, f, roughness(force)):
        return ""
    slope = float(np.polyfit(x, f, 1)[0])
    return Message(
        "The force changes by {change:+.2g} N before the touch.\nThe load cell drifts, and the slopes are off by "
        "{per_mm:+.2g} N/mm, or the touch is earlier.",
        change=slope * float(np.ptp(x)), per_mm=slope / 1e3
    )  # fmt: skip


def _likely_touch(x: Floats, f: Floats) -> float:
    """Return the depth [m] from which on two pieces answer the rows best, and before which the force is level."""

    def loss(touch: float) -> float:
        before = x < touch
        if before.sum() < _ROWS:
            return math.inf
        tare = float(f[before].mean())
        pieces = two_pieces(x[~before] - touch, f[~before] - tare, left="origin")
        return float(((f[before] - tare) ** 2).sum()) + (pieces.residual if pieces else math.inf)

    best = min((float(x[0] + share * np.ptp(x)) for share in _STARTS), key=loss)
    return min((float(x[0] + share * (best - x[0])) for share in _NEARER), key=loss)  # a fit does not stray far


def _read(x: Floats, f: Floats, start: float, free: Free) -> tuple[Fit, float]:
    """Fit with the touch near a depth and return the fit, its contact from depth 0, and its squared residuals."""
    fit = fit_law(x - start, f, free=free)
    fit = replace(fit, contact=replace(fit.contact, value=start + fit.contact.value))
    return fit, _loss(fit, x, f)


def _try(x: Floats, f: Floats, start: float, free: Free) -> tuple[Fit, float] | None:
    """Do as _read; None where too few rows lie beyond the touch."""
    try:
        return _read(x, f, start, free)
    except DimpleError:
        return None


def _loss(fit: Fit, x: Floats, f: Floats) -> float:
    return float(((f - fit.tare - fit.law(x - fit.contact.value)) ** 2).sum())


def _differs(one: Fit, other: Fit) -> bool:
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("K1", "x0")]
    return any(abs(a.value - b.value) > max(_NOTICEABLE * abs(a.value), a.half_width) for a, b in pairs)


def _begun(first: float, before: float, loaded: float) -> Question:
    """Ask for the touch of a press that begins loaded [N] at a reading [mm]."""
    return Question(
        name="contact_mm",
        text=Message(
            "The force is {loaded:.3g} N where the file begins, at {first:.4g} mm. At which depth was the first touch?",
            loaded=loaded,
            first=first,
        ),
        candidates=(
            Candidate(value=f"{before:.6g}", label="before the file begins: the object was pressed already"),
            Candidate(value=f"{first:.6g}", label="where the file begins: the load cell was not tared"),
        ),
        default=f"{before:.6g}",
    )


def _already_touching(depth: Floats, force: Floats, rest: float, noise: float) -> FirstTouch:
    """Return the touch of a file that begins in contact: at depth 0, or where the first rows point back to."""
    span, first = float(np.ptp(depth)), float(depth[0])
    if abs(first) < 0.02 * span:
        return FirstTouch(depth=0.0, tare=0.0, free=())
    end = max(_sustained(force > rest + 0.1 * (force.max() - rest)), 2 * _ROWS)
    slope, _ = np.polyfit(depth[:end] - first, force[:end], 1)
    back = rest / slope if slope > 0 and abs(rest) > _CLEAR * noise else 0.0
    return FirstTouch(depth=first - back, tare=0.0, free=("contact",))


def _sustained(above: np.ndarray) -> int:
    """Return the first row from which three in a row are above, else the number of rows."""
    three = above[:-2] & above[1:-1] & above[2:]
    return int(three.argmax()) if three.any() else len(above)


def _is_level(x: Floats, f: Floats, noise: float) -> bool:
    """Return whether the force before a hinge neither rises nor falls by more than chance or a little drift."""
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
    """Return whether the rows before a hinge are enough to know it is not the first row."""
    before, after = x[x < join], x[x >= join]
    if len(np.unique(before)) < _FEW or join - x[0] < _STANDS * np.ptp(x) or slope <= 0:
        return False  # rows of one depth are a preload
    error = noise / slope * np.sqrt(1 / len(before) + 1 / max(len(after), 1))
    return join - float(x[0]) > _SURE * error
