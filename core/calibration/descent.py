"""The bed's law that makes a flat tip answer a measured curve: one descent, piece by piece.

No vertex is displaced farther than the tip is deep, so the force at one depth depends on the bed's law up to there
only, and grows with its slope on the last piece: piece by piece that slope is found by which the force is the measured
one.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from ..base import Floats
from ..body.model import Model
from ..material import Material, ModelConstants
from ..mesh.surface import Mesh
from ..session import Session
from ..steps import as_share
from .indent import Site, Station, going_down, set_up
from .inversion import DEPTHS, bed_in_pieces

KNOTS = (0.15, 0.3, 0.5, 0.75, 1.0)  # of the knee of the measured law: where pieces end,
BEYOND = 6  # and how many there are beyond it
TRIALS = 4  # slopes that are tried for a piece
USUAL = 1.7  # of them are needed: so much of the work is ahead
CLOSE = 2e-3  # of the force: near enough
GROWTH = 2.5  # power of the depth with which the energy of a piece grows, about
# times the slope of the closed form: good for most; what is tried where the force at the deepest is then too small
STEEPEST, STEEPER = 2.5, 6.0
NEAR = 0.03  # of the measured force, at the deepest


def piece_by_piece(
    mesh: Mesh, material: Material, first: ModelConstants, site: Site, deepest: float
) -> Generator[float, None, tuple[ModelConstants, list[Station]]]:
    """Find the bed's law under a flat tip, and press with it; yield the share that is done."""
    knots = _knots(material.x0, deepest)
    found: list[tuple[Floats, float]] = []  # slopes, and the force at the deepest over the measured one
    done = 0.0
    steepest: float | None = STEEPEST
    while steepest is not None:
        tried = USUAL * len(knots)
        ahead = tried / (tried + DEPTHS)  # of what is left, if nothing has to be tried again
        before, done = done, done + (1 - done) * ahead
        found.append((yield from found_slopes(mesh, material, first, site, knots, (before, done), steepest)))
        again = len(found) == 1 and deepest > material.x0 and found[0][1] < 1 - NEAR
        steepest = STEEPER if again else None
    constants = bed_in_pieces(first, knots, min(found, key=lambda each: abs(each[1] - 1))[0])
    stations: list[Station] = []
    session, before = set_up(mesh, replace(material, constants=constants), material.indenter, site), 0.0
    each = (1 - done) / (DEPTHS + 1)
    for k, depth in enumerate((deepest * np.arange(1, DEPTHS + 1) / DEPTHS).tolist()):
        yield done + k * each
        steps = going_down(session, material.indenter, site, before, depth)
        station = yield from as_share(steps, done + k * each, each)
        if not station.found:
            break
        stations.append(station)
        before = depth
    return constants, stations


def found_slopes(
    mesh: Mesh,
    material: Material,
    first: ModelConstants,
    site: Site,
    knots: Floats,
    share: tuple[float, float],
    steepest: float = STEEPEST,
) -> Generator[float, None, tuple[Floats, float]]:
    """Find the slopes (m,) [N/m3] of the bed's law on the pieces that end at the knots (m,) [m].

    Args:
        share: of the identification, from and to.
        steepest: times the slope of the closed form.

    Returns:
        the slopes, and the force at the last knot over the measured one.
    """
    steepest *= max(first.kappa1, first.kappa2)
    slopes = np.append(first.kappa1, np.full(len(knots) - 1, steepest))  # so its steps are short enough for all of it
    constants = bed_in_pieces(first, knots, slopes)
    session = set_up(mesh, replace(material, constants=constants), material.indenter, site)
    model, area = session.model, session.model.matching.k1 / first.kappa1
    before = 0.0
    for m, knot in enumerate(knots.tolist()):
        wanted, start = material.law(knot), knots[m - 1] if m else 0.0
        slopes[m:] = slopes[m - 1] if m else first.kappa1
        tried: list[tuple[float, float]] = []
        for trial in range(TRIALS):
            _set_slopes(session, model, area, slopes)
            so_far, part = m + 1 - 0.5**trial, 0.5 ** (trial + 1)
            each = (share[1] - share[0]) / len(knots)
            steps = going_down(session, material.indenter, site, before, knot)
            station = yield from as_share(steps, share[0] + each * so_far, each * part)
            yield share[0] + each * (so_far + part)
            before = knot
            if not station.found:
                return slopes[: max(m, 1)], 0.0
            off = station.force - wanted
            tried.append((slopes[m], off))
            if abs(off) <= CLOSE * wanted:
                break
            gain = _gain(model, area, station, start)
            if len(tried) > 1 and tried[-2][0] != tried[-1][0]:
                secant = (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
                gain = secant if secant > 0.2 * gain else gain
            slopes[m:] = min(max(slopes[m] - off / max(gain, 1e-30), 0.0), steepest)
            if slopes[m] == tried[-1][0]:
                break
    return slopes, station.force / wanted


def _set_slopes(session: Session, model: Model, area: Floats, slopes: Floats) -> None:
    """Give the bed of a body, (n,) areas [m2], a law of these slopes; its steps stay short enough for all of them."""
    k1 = slopes[0] * area
    law = replace(model.matching, k1=k1, k2=k1, more=np.diff(slopes)[:, None] * area)
    session.change(replace(model, matching=law))


def _gain(model: Model, area: Floats, station: Station, start: float) -> float:
    """Return by how much the force grows with the slope beyond a displacement [m], about [m2 m].

    The energy E at rest obeys F = dE/dx, so dF/ds = d/dx (dE/ds) with the body left where it is (Hellmann, Feynman).
    """
    d = np.sqrt(((station.positions - model.matching.rest) ** 2).sum(axis=0))
    stored = float(area @ np.maximum(d - start, 0) ** 2) / 2
    return GROWTH * stored / (station.depth - start)


def _knots(x0: float, deepest: float) -> Floats:
    """Return the displacements (m,) [m] at which the pieces of the bed's law end: one is the measured knee."""
    if deepest <= x0 * KNOTS[0]:
        return np.array([deepest])
    knots = x0 * np.array(KNOTS)
    if deepest <= x0:
        return np.append(knots[knots < 0.99 * deepest], deepest)
    return np.concatenate([knots, x0 + (deepest - x0) * np.arange(1, BEYOND + 1) / BEYOND])
