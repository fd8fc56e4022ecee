"""The bed's law that makes a round tip answer a measured curve: Gauss-Newton, its derivative from the press itself.

A round tip touches more as it sinks in, so its force at one depth depends on the bed's law at every displacement up to
there, and a sharp knee asks for a law that jumps and then hardly grows: on a bed of springs alone it is F' / 2 pi R (an
Abel inversion). The law is in pieces of slopes s_m. The energy E of the body at rest obeys F = dE/dx, and where it
is at rest dE/ds_m is that of the displacements as they are (Hellmann, Feynman), so that one press gives all of

    dF(x)/ds_m = d/dx (sum over vertices of area times the integral of clip(t - start_m, 0, width_m) from 0 to |u|)

Slopes are kept from falling below 0, where the bed would let go, and from so steep that a step in time would suffer.
Where a press comes out worse than the best, its change is tried again, damped more (Levenberg, Marquardt).

Most presses are on a body that is as fine only where the tip is. It answers within some tenths of a percent of full
scale of what the whole body does, which has the last word.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats, sums_at
from ..body.model import Model, with_bed
from ..material import Material, ModelConstants
from ..mesh.surface import Mesh
from ..session import Session
from ..steps import as_share
from .indent import Site, Station, going_down, put_back, set_up
from .least_squares import bounded

DEPTHS = 24  # of a press
SWEEPS, WORK = (5, 9), 6e7  # presses, from and to, and steps of vertices after which there are no more
GOOD, GOOD_WORST = 0.01, 0.05  # RMS and largest error over full scale that need no better law
NEARLY, FAILURES = 1.5, 2  # times that: where so many presses in a row come out no better, there are no more
TICKS = 14  # of a depth
LEFT = 0.98  # share of what is off that the derivative would leave: no more is to be had
LIGHT = 0.05  # of full scale, added to each force: an error weighs as the root of its share of the force and of all
# what is good for full scale asks little of the knee, which a round tip makes round: where it is off by more than this
# share of its force it weighs so many times as much, in so many more presses (fewer after a smaller body's)
KNEE_OFF, KNEE, KNEE_SWEEPS = 0.05, 2.0, (1, 2)
KNEE_FAR = 0.12  # a knee that was farther off is taken as near as it comes, a nearer one only within KNEE_OFF
KNEE_PART = 0.25  # of the work
SMALL = 0.3  # of the work is on a body of fewer vertices
# shares of the knee where pieces end, dense where the law must jump (at the touch, for little touches there, and at the
# knee), and of what is left beyond it; all of them shares of the deepest where no knee is reached
BEFORE = (0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.7, 0.85, 0.94, 1.0)
BEYOND = (0.06, 0.14, 0.25, 0.4, 0.6, 0.8, 1.0)
# times what the tension makes a vertex as stiff as: then a step in time is at most half as long; or, on coarse meshes,
# times the closed form's slope, whichever is more
STEEPEST, STEEPEST_COARSE = 3.0, 2.5
LEAST = 0.2  # of the closed form, the first slope: the body must not become too light to be pressed
DAMPED, MORE, LESS = 0.03, 10.0, 0.5  # share of a slope that counts as much as one of full scale; times it next
TINY = 1e-6  # of the closed form, any other slope: the pieces of a law are stiff enough to be told apart
UNMOVED = 1e-3  # of the deepest: a vertex that moved less stores nothing


@dataclass(frozen=True, slots=True)
class _Search:
    """What is looked for.

    material: measured.
    site: where it was.
    ends: (m,) of the pieces [m].
    least, steepest: (m,) slopes [N/m3].
    kappa1: of the closed form [N/m3].
    """

    material: Material
    site: Site
    ends: Floats
    least: Floats
    steepest: Floats
    kappa1: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sweep:
    """A press to all depths with one law.

    slopes: (m,) [N/m3] of the pieces.
    stations: where it rests.
    off: (n,) force missed at each depth over what weighs as much there, 1 or more where there is no rest.
    gains: (k, m) change of the force with each slope [m3/N], over the same, at the k stations.
    """

    slopes: Floats
    stations: list[Station]
    off: Floats
    gains: Floats


def inverted(
    mesh: Mesh, material: Material, first: ModelConstants, site: Site, ends: Floats, slopes: Floats, begun: float
) -> Generator[float, None, tuple[ModelConstants, list[Station]]]:
    """Find the bed's law in steps of one rest each.

    Args:
        material: K1, K2, x0 measured with its indenter.
        first: constants whose tension and factor on k stay.
        ends: (m,) displacements [m] where pieces of the law end, the last of them the depth to be pressed to.
        slopes: (m,) of the pieces [N/m3] to begin with.
        begun: share of the whole that was done before.

    Yields:
        the share of the whole that is done.

    Returns:
        the constants, and the press with them, which ends early where no rest was found.
    """
    session = set_up(mesh, replace(material, constants=replace(first, pieces=())), material.indenter, site)
    area, kappa1 = session.model.matching.k1 / first.kappa1, first.kappa1
    least = np.where(ends == ends[0], LEAST, TINY) * kappa1
    steepest = max(STEEPEST * pulled(session.model, area), STEEPEST_COARSE * max(kappa1, first.kappa2))
    search, most, enough = _Search(material, site, ends, least, np.maximum(steepest, least), kappa1), SWEEPS[1], 1.0
    for_knee = KNEE_SWEEPS[1]
    again = KNEE_PART * (1 - begun)
    best = yield from _best(search, session, area, slopes, most, enough, (begun, 1 - begun - again))
    best = yield from _with_its_knee(search, session, area, best, for_knee, (1 - again, again))
    return bed_in_pieces(first, ends, best.slopes), best.stations


def _best(
    search: _Search, session: Session, area: Floats, slopes: Floats, most: int, enough: float,
    share: tuple[float, float],
) -> Generator[float, None, _Sweep]:
    """Press a body until it follows the measured law or comes no nearer, and return the best press.

    Args:
        area: (n,) of the vertices [m2].
        slopes: (m,) of the pieces [N/m3] to begin with.
        most: presses.
        enough: times what is good, that needs no better law.
        share: of the whole, before and by these presses.
    """
    best, failed, damped = None, 0, DAMPED
    each = len(area) * session.substeps * DEPTHS * TICKS * (1 + len(search.site.others))
    sweeps = min(max(round(WORK / each), SWEEPS[0]), most)
    for sweep in range(sweeps):
        part = share[0] + share[1] * sweep / sweeps, share[1] / sweeps
        found = yield from _swept(session, area, search, np.clip(slopes, search.least, search.steepest), part)
        if best is None or found.off @ found.off < best.off @ best.off:
            best, failed, damped = found, 0, damped * (1.0 if best is None else LESS)
        else:
            failed, damped = failed + 1, damped * MORE
        if not best.stations or _is_good(best, search.material, NEARLY if failed >= FAILURES else enough):
            break
        slopes, left = _improved(best, search, damped)
        if left > LEFT and damped <= DAMPED:
            break
    assert best
    return best


def _with_its_knee(
    search: _Search, session: Session, area: Floats, best: _Sweep, most: int, share: tuple[float, float]
) -> Generator[float, None, _Sweep]:
    """Press a body a few times more where it misses the force at the knee; return what meets it, or the best so far.

    Args:
        area: (n,) of the vertices [m2].
        best: press so far.
        most: presses.
        share: of the whole, before and by these presses.
    """
    material, found, damped = search.material, best, DAMPED
    for sweep in range(most):
        if len(found.stations) < DEPTHS or _meets_its_knee(found, material):
            break
        weighs = np.where(np.arange(DEPTHS) == _nearest(found, material.x0), KNEE, 1.0)
        heavier = replace(found, off=found.off * weighs, gains=found.gains * weighs[:, None])
        part = share[0] + share[1] * sweep / most, share[1] / most
        tried = yield from _swept(session, area, search, _improved(heavier, search, damped)[0], part)
        stays_good = _is_good(tried, material, 1.0) or not _is_good(best, material, 1.0)
        if stays_good and np.linalg.norm(tried.off * weighs) < np.linalg.norm(heavier.off):
            found, damped = tried, damped * LESS
        else:
            damped *= MORE
    return found if _meets_its_knee(found, material) or not _meets_its_knee(best, material, KNEE_FAR) else best


def _meets_its_knee(sweep: _Sweep, material: Material, off: float = KNEE_OFF) -> bool:
    """Tell whether a press is complete and off by no more than a share of the force at the station nearest the knee."""
    if len(sweep.stations) < DEPTHS:
        return False
    station = sweep.stations[_nearest(sweep, material.x0)]
    return abs(station.force / material.law(station.depth) - 1) <= off


def _nearest(sweep: _Sweep, depth: float) -> int:
    """Return which station of a press is nearest to a depth [m]."""
    return int(np.abs([station.depth - depth for station in sweep.stations]).argmin())


def bed_in_pieces(first: ModelConstants, ends: Floats, slopes: Floats) -> ModelConstants:
    """Return the constants of a bed's law whose pieces end at displacements (m,) [m]; 0 to begin with is just above."""
    slopes = np.maximum(slopes, TINY * first.kappa1)
    pieces = tuple(zip(ends[: len(slopes) - 1].tolist(), np.diff(slopes).tolist(), strict=True))
    return replace(first, kappa1=float(slopes[0]), kappa2=float(slopes[0]), pieces=pieces)


def piece_ends(x0: float, deepest: float) -> Floats:
    """Return the displacements (m,) [m] at which the pieces of a round tip's bed end; one is the measured knee."""
    if deepest <= 1.02 * x0:
        return deepest * np.array(BEFORE)
    return np.concatenate([x0 * np.array(BEFORE), x0 + (deepest - x0) * np.array(BEYOND)])


def _swept(
    session: Session, area: Floats, search: _Search, slopes: Floats, share: tuple[float, float]
) -> Generator[float, None, _Sweep]:
    """Press with a law of slopes (m,).

    Args:
        share: of the whole, before and by this press.
    """
    material, site, ends = search.material, search.site, search.ends
    knees, more = np.repeat(ends[:-1, None], len(area), axis=1), np.diff(slopes)[:, None] * area
    session.change(with_bed(session.model, slopes[0] * area, knees, more))
    depths, sites = ends[-1] * np.arange(1, DEPTHS + 1) / DEPTHS, (site, *site.others)
    presses = []
    for at, each in enumerate(sites):
        part = share[1] / len(sites)
        presses.append((yield from as_share(_pressed(session, material, each, depths), share[0] + at * part, part)))
    reached = min(map(len, presses))
    forces = np.mean([[station.force for station in press[:reached]] for press in presses], axis=0)
    stations = [replace(station, force=force) for station, force in zip(presses[0], forces.tolist(), strict=False)]
    wanted = np.array([material.law(depth) for depth in depths.tolist()])
    weighs = np.sqrt(wanted.max() * (LIGHT * wanted.max() + wanted))
    off, gains = wanted / weighs, np.zeros((0, len(slopes)))
    if reached:
        off[:reached] = (forces - wanted[:reached]) / weighs[:reached]
        stored = [[0 * slopes, *(_stored(session.model, area, ends, s) for s in press[:reached])] for press in presses]
        gains = np.gradient(np.mean(stored, axis=0), np.append(0.0, depths[:reached]), axis=0)[1:]
    return _Sweep(slopes=slopes, stations=stations, off=off, gains=gains / weighs[:reached, None])


def _pressed(session: Session, material: Material, site: Site, depths: Floats) -> Generator[float, None, list[Station]]:
    """Press a body from rest to each depth in turn and return where it rests, as far as it does."""
    put_back(session, material.indenter, site)
    stations: list[Station] = []
    before, each = 0.0, 1 / (len(depths) + 1)
    for k, depth in enumerate(depths.tolist()):
        station = yield from as_share(going_down(session, material.indenter, site, before, depth), k * each, each)
        yield (k + 1) * each
        if not station.found:
            break
        stations.append(station)
        before = depth
    return stations


def _is_good(sweep: _Sweep, material: Material, times: float) -> bool:
    """Tell whether a press follows the measured law as well as is asked for, or nearly, by so many times as much."""
    if len(sweep.stations) < DEPTHS:
        return False
    off = np.array([station.force - material.law(station.depth) for station in sweep.stations])
    off /= material.law(sweep.stations[-1].depth)
    return bool(np.sqrt((off**2).mean()) < times * GOOD and np.abs(off).max() < times * GOOD_WORST)


def _stored(model: Model, area: Floats, ends: Floats, station: Station) -> Floats:
    """Return the energy (m,) that a body at rest stores per slope of each piece [m5]."""
    d = np.sqrt(((station.positions - model.matching.rest) ** 2).sum(axis=0))
    dent = d > UNMOVED * ends[-1]
    beyond = np.maximum(d[dent] - np.append(0.0, ends)[:, None], 0)
    return -np.diff(beyond**2 @ area[dent]) / 2


def pulled(model: Model, area: Floats) -> float:
    """Return how stiff the tension makes a vertex, over its area: the median [N/m3]."""
    ends = model.matching.pairs
    stiffness = 2 * sums_at(ends.ravel(), np.repeat(model.matching.tension, 2), len(area))
    return float(np.median(stiffness[area > 0] / area[area > 0]))


def _improved(sweep: _Sweep, search: _Search, damped: float) -> tuple[Floats, float]:
    """Return the slopes (m,) that would make up for what a press is off, and the share of it that would be left."""
    scale = search.kappa1 + sweep.slopes
    missed, gains = -sweep.off[: len(sweep.stations)], sweep.gains * scale
    low, high = (search.least - sweep.slopes) / scale, (search.steepest - sweep.slopes) / scale
    more = bounded(gains, missed, low, high, damped)
    return sweep.slopes + scale * more, float(np.linalg.norm(gains @ more - missed) / np.linalg.norm(missed))
