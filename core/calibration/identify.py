"""Model constants such that a simulated press with the measuring tip answers K(x) of the material on its mesh.

A flat tip goes down once (`descent`); a round tip needs all of the bed's law at once (`inversion`). The tension and the
factor on k are those of the closed form: one curve does not tell them.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..body.estimate import estimate
from ..material import Indenter, Material, ModelConstants
from ..mesh.surface import Mesh
from ..steps import as_share
from .descent import found_slopes, piece_by_piece
from .indent import CLEAR, Site, Station, gives_way, going_down, set_up
from .inversion import DEPTHS, SWEEPS, inverted, piece_ends

AT = 0.6  # of the knee: where the closed form is scaled to the measured force; a round tip makes it start too softly
FARTHEST = 10.0  # times the closed form: the most it is scaled
SCALED, SCALED_ROUND = 0.05, 0.015  # of the work is to scale the closed form, by a flat tip and by a round one
USUAL = 2.5  # slopes are tried for a piece where a tip is finer than the mesh: so much of the work is ahead
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
    find = _all_at_once if indenter.shape == "sphere" else piece_by_piece
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
        begun = USUAL * len(ends) / (USUAL * len(ends) + SWEEPS[1] * DEPTHS)
        found, _ = yield from found_slopes(mesh, material, first, site, ends, (0.0, begun))
        slopes = np.append(found, np.full(len(ends) - len(found), found[-1]))
    return (yield from inverted(mesh, material, first, site, ends, slopes, begun))


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
