"""Model constants such that a simulated press with the measuring tip answers K(x) of the material on its mesh.

A flat tip goes down once. No vertex is displaced farther than the tip is deep, so the force at one depth depends on the
bed's law up to there only, and grows with its slope on the last piece: piece by piece that slope is found by which the
force is the measured one. A round tip needs all of the law at once (`inversion`). The tension and the factor on k are
those of the closed form: one curve does not tell them.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..body.estimate import estimate
from ..body.model import Model
from ..material import Indenter, Material, ModelConstants
from ..mesh.surface import Mesh
from ..session import Session
from ..steps import as_share
from .indent import CLEAR, Site, Station, gives_way, going_down, set_up
from .inversion import DEPTHS, SWEEPS, bed_in_pieces, inverted, piece_ends

AT = 0.6  # of the knee: where the closed form is scaled to the measured force; a round tip makes it start too softly
FARTHEST = 10.0  # times the closed form: the most it is scaled
KNOTS = (0.15, 0.3, 0.5, 0.75, 1.0)  # of the knee of the measured law: where pieces end,
BEYOND = 6  # and how many there are beyond it
SCALED, SCALED_ROUND = 0.05, 0.015  # of the work is to scale the closed form, by a flat tip and by a round one
TRIALS = 4  # slopes that are tried for a piece
USUAL, USUAL_ROUND = 1.7, 2.5  # of them are needed, by a flat tip and by a round one: so much of the work is ahead
CLOSE = 2e-3  # of the force: near enough
GROWTH = 2.5  # power of the depth with which the energy of a piece grows, about
# times the slope of the closed form: good for most; what is tried where the force at the deepest is then too small
STEEPEST, STEEPER = 2.5, 6.0
NEAR = 0.03  # of the measured force, at the deepest
ALLOWED = 0.10  # of the force, or
ALLOWED_FORCE = 0.3  # [N] whichever is more: what a depth may be off
WEAK = 0.02  # of full scale: what a depth of a weak press may be off
NEARLY_CLEAR = 0.9  # of the depth that is clear: so much is pressed where one depth is to be the knee
NOTICEABLE_FORCE = (0.06, 0.08)  # just-noticeable difference of a force, as a share of it: from, to


@dataclass(frozen=True, slots=True, kw_only=True)
class Identification:
    """Model constants that were identified, and how well the press with them follows the measured law.

    material: with the constants.
    depths: (m,) of the press that checks them [m].
    wanted: (m,) forces of the law there [N].
    simulated: (m,) forces of the simulated press there [N].
    rms: RMS error as a share of full scale.
    worst: largest error over what is allowed at its depth.
    volume_change: largest, as a share.
    stopped: "" or why the press ends before the depth asked for.
    notes: messages for the artist.
    """

    material: Material
    depths: Floats
    wanted: Floats
    simulated: Floats
    rms: float
    worst: float
    volume_change: float
    stopped: str
    notes: tuple[str, ...]

    @property
    def off(self) -> Floats:
        """Return the error (m,) of each force as a share of the force wanted there."""
        return np.abs(self.simulated / self.wanted - 1)


def identification(
    mesh: Mesh, material: Material, indenter: Indenter, site: Site, deepest: float
) -> Generator[float, None, Identification]:
    """Identify model constants in steps of one rest each, for a timer.

    Args:
        mesh: in the size of the real object [m].
        material: K1, K2, x0 measured with the indenter; its constants are ignored.
        indenter: the tip that measured.
        site: where it presses.
        deepest: depth [m] down to which the constants must hold.

    Yields:
        the share that is done.

    Returns:
        what was found.

    Raises:
        DimpleError: the body cannot be simulated.
    """
    measured = replace(material, constants=None, indenter=indenter)
    deep, stopped = _deepest(deepest, site, material.x0)
    done = SCALED_ROUND if indenter.shape == "sphere" else SCALED
    bed, given = measured, 0.0
    if material.fill == "solid" and indenter.shape != "sphere":
        bed, given = _below_its_skin(measured, mesh.size)
        deep -= given * material.law(deep)
    first = yield from as_share(_scaled(mesh, bed, site, AT * min(bed.x0, deep)), 0.0, done)
    find = _all_at_once if indenter.shape == "sphere" else _piece_by_piece
    constants, stations = yield from as_share(find(mesh, bed, first, site, deep), done, 1 - done)
    stations = [replace(station, depth=station.depth + given * station.force) for station in stations]
    if len(stations) < DEPTHS:
        depth = stations[-1].depth if stations else 0.0
        stopped = f"Deeper than {1e3 * depth:.3g} mm the simulated body finds no rest."
    wanted = np.array([material.law(station.depth) for station in stations])
    return _judged(replace(measured, constants=constants), stations, wanted, stopped)


def _below_its_skin(material: Material, size: float) -> tuple[Material, float]:
    """Return what a flat tip would measure on the bed of a solid alone, and how far its skin gives way [m/N].

    In series with the skin, the two slopes and the knee of the measured law are those of the bed again, changed.
    """
    given = gives_way(material, material.indenter, size)
    K1, K2 = (k / (1 - given * k) for k in (material.K1, material.K2))
    return replace(material, K1=K1, K2=K2, x0=material.x0 * (1 - given * material.K1), fill="liquid"), given


def _all_at_once(
    mesh: Mesh, material: Material, first: ModelConstants, site: Site, deepest: float
) -> Generator[float, None, tuple[ModelConstants, list[Station]]]:
    """Find the bed's law under a round tip, and press with it; begin with the closed form where that may do.

    A tip finer than the mesh presses a vertex or three, as a flat one does: then the law is found piece by piece first.
    """
    ends, begun = piece_ends(material.x0, deepest), 0.0
    slopes = np.where(ends <= material.x0, first.kappa1, max(first.kappa1, first.kappa2))
    if np.median(mesh.rest_lengths) > material.indenter.radius:
        begun = USUAL_ROUND * len(ends) / (USUAL_ROUND * len(ends) + SWEEPS[1] * DEPTHS)
        found, _ = yield from _found_slopes(mesh, material, first, site, ends, STEEPEST, (0.0, begun))
        slopes = np.append(found, np.full(len(ends) - len(found), found[-1]))
    return (yield from inverted(mesh, material, first, site, ends, slopes, begun))


def _piece_by_piece(
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
        found.append((yield from _found_slopes(mesh, material, first, site, knots, steepest, (before, done))))
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


def _scaled(mesh: Mesh, material: Material, site: Site, depth: float) -> Generator[float, None, ModelConstants]:
    """Return the closed form, scaled so that a press to a depth [m] answers the measured force on this mesh."""
    first = estimate(material, mesh.size)
    first = replace(first, tension=first.kappa1 * material.spread**2)
    session = set_up(mesh, replace(material, constants=first), material.indenter, site)
    yield 0.2
    station = yield from as_share(going_down(session, material.indenter, site, 0.0, depth), 0.2, 0.7)
    yield 0.9
    if not (station.found and station.force > 0):
        return first
    scale = min(max(material.law(depth) / station.force, 1 / FARTHEST), FARTHEST)
    return replace(
        first, kappa1=scale * first.kappa1, kappa2=scale * first.kappa2, tension=scale * (first.tension or 0.0)
    )


def _found_slopes(
    mesh: Mesh,
    material: Material,
    first: ModelConstants,
    site: Site,
    knots: Floats,
    steepest: float,
    share: tuple[float, float],
) -> Generator[float, None, tuple[Floats, float]]:
    """Find the slopes (m,) [N/m3] of the bed's law on the pieces that end at the knots (m,) [m].

    Args:
        steepest: times the slope of the closed form.
        share: of the identification, from and to.

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


def _judged(material: Material, stations: list[Station], wanted: Floats, stopped: str) -> Identification:
    simulated = np.array([station.force for station in stations])
    allowed = np.maximum(ALLOWED * wanted, min(ALLOWED_FORCE, WEAK * float(wanted.max(initial=0.0))))
    errors, depths = (simulated - wanted) / allowed, np.array([station.depth for station in stations])
    if len(stations) < 2:
        raise DimpleError("The simulated body finds no rest under the tip. Use a finer or simpler mesh.")
    assert material.constants
    notes = _scale_message(material.constants), stopped, _miss_message(depths, wanted, simulated, errors, material)
    return Identification(
        material=material, depths=depths, wanted=wanted, simulated=simulated,
        rms=float(np.sqrt(((simulated - wanted) ** 2).mean()) / wanted.max()), worst=float(np.abs(errors).max()),
        volume_change=max(abs(station.volume_change) for station in stations), stopped=stopped,
        notes=tuple(filter(None, notes)),
    )  # fmt: skip


def _scale_message(constants: ModelConstants) -> str:
    """Return a message about what the factor on k means."""
    scale = constants.membrane_scale
    if scale > 0.99:
        return "The springs of the surface keep their own k."
    return (
        f"k is taken at {100 * scale:.2g} % of its value: springs as stiff would answer far more than was measured, "
        "and buckle. Shape matching carries the rest."
    )


def _deepest(deepest: float, site: Site, x0: float) -> tuple[float, str]:
    """Return how deep [m] is pressed, and why no deeper, or "".

    On a body of thin parts it is so deep that one depth is the knee, unless much would be left out.
    """
    clear = CLEAR * site.thickness
    if deepest <= clear:
        return deepest, ""
    at_knee = DEPTHS * x0 / math.ceil(DEPTHS * x0 / clear)
    return at_knee if site.others and x0 < clear and at_knee >= NEARLY_CLEAR * clear else clear, (
        f"Deeper than {1e3 * clear:.3g} mm the tip would meet the far side of the object, "
        f"which is {1e3 * site.thickness:.3g} mm thick there."
    )


def _miss_message(depths: Floats, wanted: Floats, simulated: Floats, errors: Floats, material: Material) -> str:
    """Return a message about where the simulated press is off by more than allowed, "" where it is nowhere."""
    at = int(np.abs(errors).argmax())
    if abs(errors[at]) <= 1:
        return ""
    there = f"{simulated[at]:.3g} N instead of {wanted[at]:.3g} N"
    round_tip = material.indenter.shape == "sphere"
    why = " A round tip touches more as it sinks in, so it rounds the knee." if round_tip else ""
    return f"The simulated press is off the most at {1e3 * depths[at]:.3g} mm: {there}.{why}"
