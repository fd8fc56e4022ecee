"""The definition of a body: a mesh, the constants of its laws, and what holds it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..base import STIFFEST, Bools, DimpleError, Floats, mean_of_pairs, sums_at
from ..constants import EXACT, ROUNDING
from ..fills import FILLS
from ..material import Material
from ..mesh.surface import Mesh, spans_a_plane
from ..message import Message
from ..other_tip import layer
from . import frequency_bounds, pressure, springs
from .maps import Maps, painted
from .on_mesh import constants_on, mass_on
from .pressure import Pressure
from .rigid import fill_momentum
from .shape_matching import ShapeMatching, tension_force
from .springs import Springs
from .time_step import MAX_SUBSTEPS, longest_step

_ALL_PINS = "Every vertex is pinned, so nothing can move. Switch Pinned off, pin fewer vertices or subdivide the mesh."
SMALL = 1e-3  # [m] a smaller body was most likely modelled in other units


class Sways(NamedTuple):
    """How a body sways.

    amount: fraction of the displacement that is shown, 0 to 1.
    frequency: of the first mode [Hz]; 0: follows from the material.
    damping: damping ratio; 1 is critical.
    held: (n,) how firmly each vertex is pinned, 0 to 1.
    bones: (b, 2, 3) ends of the bones inside the body that hold it [m], None without a rig.
    gravity: (3,) under which the modelled shape is at rest [m/s2].
    """

    amount: float
    frequency: float
    damping: float
    held: Floats
    bones: Floats | None
    gravity: Floats


@dataclass(frozen=True, kw_only=True)
class Model:
    """A mesh with its laws.

    mesh: the surface at rest.
    materials: one for each index in mesh.triangle_material.
    mass: (n,) [kg].
    inverse_mass: (n,) [1/kg], 0 where pinned.
    pinned: (n,) pinned by the artist, or part of no face.
    friction: (n,) coefficient.
    compliance: (n,) of the skin under a fingertip [m/N], 0 for a hard skin.
    springs, pressure, matching: the laws with their parameters.
    gravity: (3,) [m/s2].
    ground: height of a plane [m], or None.
    fill_momentum: angular momentum of the fill over that of the skin (3, 3), in the shape at rest; 0 but in a solid
        without pins.
    omega_squared: bound on the highest angular frequency squared [1/s2].
    decay: bound on the highest damping rate [1/s].
    notes: messages for the artist.
    maps: factors from the painted maps, None where they are unknown.
    rigged: whether something else (a rig) places the shape at rest, so that it follows neither the body nor its pins.
    sway: None for a body that does not sway.
    """

    mesh: Mesh
    materials: tuple[Material, ...]
    mass: Floats
    inverse_mass: Floats
    pinned: Bools
    friction: Floats
    compliance: Floats
    springs: Springs
    pressure: Pressure
    matching: ShapeMatching
    gravity: Floats
    ground: float | None
    fill_momentum: Floats
    omega_squared: float
    decay: float
    notes: tuple[str, ...]
    maps: Maps | None = None
    rigged: bool = False
    sway: Sways | None = None

    @property
    def laws(self) -> list[tuple[float, ...]]:
        """Return the law of each material at a fingertip, in the order of dimple.h."""
        size = self.mesh.size
        return [
            (m.K1, m.K2, m.x0, m.power, m.friction, m.damping_ratio, layer(m, size)) for m in self.materials
        ]

    @cached_property
    def free(self) -> bool:
        """Whether the shape at rest follows the body rather than its pins."""
        pinned = self.mesh.rest_positions[self.pinned & ~self.mesh.loose]
        return not self.rigged and not spans_a_plane(pinned, self.mesh.size)

    def substeps(self, tick: float) -> int:
        """Return how many explicit steps a tick [s] needs.

        Raises:
            DimpleError: it needs more than a body that runs live may have.
        """
        limit = longest_step(self.omega_squared, self.decay, free=self.free)
        if not tick <= MAX_SUBSTEPS * limit:
            todo = Message("Raise its mass, lower k, K2 or the pressure, or use a coarser mesh.")
            if self.mesh.size < SMALL:
                size = f"{1e3 * self.mesh.size:.3g} mm"
                todo = Message("The body is only {size} across: give it a Custom Size in Physics > Dimple.", size=size)
            raise DimpleError(
                "The material is so stiff or light on this mesh that a millisecond needs over {most} steps. {todo}",
                most=MAX_SUBSTEPS, todo=todo
            )  # fmt: skip
        return math.ceil(tick / limit)


def build_model(
    mesh: Mesh,
    materials: Sequence[Material],
    *,
    pinned: Bools | Floats | None = None,
    softness: Floats | None = None,
    knee: Floats | None = None,
    spread: Floats | None = None,
    gravity: Sequence[float] = (0.0, 0.0, 0.0),
    ground: float | None = None,
    rigged: bool = False,
    sway: tuple[float, float, float, Sequence[float]] | None = None,
    bones: Floats | None = None,
) -> Model:
    """Build a body from a mesh and its materials.

    Args:
        materials: one for each index in mesh.triangle_material.
        pinned: (N,) pinned input vertices, as booleans or weights. A weight of 0.5 or more pins; of a body that sways
            only a weight of 1 does, and smaller ones hold it partly.
        softness, knee, spread: painted values of the input vertices (N,); 0.5 means as measured, see `maps`.
        gravity: (3,) [m/s2].
        ground: height [m] of the ground plane.
        rigged: see `Model`.
        sway: amount, frequency, damping and gravity, see `Sways`. Only a body with a volume that pins or a rig hold
            can sway. Its skin then has no weight, because the modelled shape is at rest under that gravity.
        bones: (b, 2, 3) see `Sways`.

    Raises:
        DimpleError: a material is missing, or a map has the wrong length.
    """
    if not np.isfinite(gravity).all() or np.shape(gravity) != (3,) or not math.isfinite(ground or 0.0):
        raise DimpleError("Gravity must be three numbers, and the height of the ground one number.")
    if not materials or mesh.triangle_material.max() >= len(materials) or mesh.triangle_material.min() < 0:
        raise DimpleError("A face uses a material slot that is empty. Assign a material to it.")
    held = _on_vertices(mesh, pinned, "pins", 0.0)
    sways = None
    if sway and mesh.pressurable and (rigged or held.any()):
        amount, frequency, damping, down = sway
        sways = Sways(amount, frequency, damping, held, bones, np.asarray(down, np.float64))
        gravity, rigged = (0.0, 0.0, 0.0), True
    pinned_here = mesh.loose | (held >= (1 - ROUNDING if sways else 0.5))
    maps = painted(*(
        _on_vertices(mesh, values, Message("{name} map", name=Message(name)), 0.5)
        for name, values in (("softness", softness), ("knee", knee), ("spread", spread))
    ))  # fmt: skip
    fill, rest_pressure = _fill(mesh, materials)
    ground, sunk = _ground(mesh, pinned_here, ground)
    model = assemble(
        mesh, materials, mass=mass_on(mesh, materials), pinned=pinned_here, fill=fill, rest_pressure=rest_pressure,
        gravity=gravity, ground=ground, notes=sunk, **constants_on(mesh, materials, maps),
    )  # fmt: skip
    return replace(model, maps=maps, rigged=rigged, sway=sways)


def assemble(
    mesh: Mesh,
    materials: Sequence[Material],
    *,
    mass: Floats,
    pinned: Bools,
    friction: Floats,
    compliance: Floats,
    damping: Floats,
    stiffness: Floats,
    k1: Floats,
    k2: Floats,
    d0: Floats,
    tension: Floats,
    fill: str,
    rest_pressure: float,
    gravity: Sequence[float] | Floats,
    ground: float | None,
    notes: tuple[str, ...] = (),
) -> Model:
    """Build a model from constants of the vertices and edges.

    Args:
        mass [kg], friction, compliance [m/N], damping (a ratio), k1, k2 [N/m], d0 [m]: (n,) of the vertices.
        stiffness, tension: (m,) of the edges [N/m].
        rest_pressure: gauge pressure of the fill in the shape at rest [Pa].
    """
    n, ends = len(mass), mesh.springs
    met = 2 * sums_at(ends.ravel(), np.repeat(tension, 2), n) + np.maximum(k1, k2)
    mass = _even_out(mass, 2 * sums_at(ends.ravel(), np.repeat(stiffness, 2), n) + met, ~mesh.loose)
    i, j = ends.T
    reduced = mass[i] * mass[j] / (mass[i] + mass[j])
    dashpots = 2 * mean_of_pairs(damping, ends) * np.sqrt(stiffness * reduced)
    inverse_mass = np.where(pinned, 0.0, 1 / mass)

    membrane, rest = springs.build_springs(mesh, stiffness, dashpots), np.array(mesh.rest_positions.T, order="C")
    shape = ShapeMatching(
        rest=rest, k1=k1, k2=k2, d0=d0, damping=2 * damping * np.sqrt(k1 * mass),
        mass=np.where(mesh.loose, EXACT * mass, mass), pairs=ends, tension=tension,
        pull=tension_force(ends, tension, rest),
    )  # fmt: skip
    inside = pressure.build_pressure(mesh, fill, rest_pressure)
    turns = FILLS[inside.fill].elastic and not (pinned & ~mesh.loose).any()
    return Model(
        mesh=mesh, materials=tuple(materials), mass=mass, inverse_mass=inverse_mass, pinned=pinned,
        friction=friction, compliance=compliance, springs=membrane, pressure=inside, matching=shape,
        gravity=np.asarray(gravity, np.float64), ground=ground,
        fill_momentum=fill_momentum(mesh, shape.mass) if turns else np.zeros((3, 3)),
        omega_squared=frequency_bounds.of_body(
            mesh, stiffness + tension, np.maximum(k1, k2), inverse_mass, inside, FILLS[inside.fill].reserve
        ),
        decay=frequency_bounds.of_edges(mesh, dashpots, shape.damping, inverse_mass),
        notes=mesh.notes + notes + ((_ALL_PINS,) if pinned.all() else ()),
    )  # fmt: skip


def _ground(mesh: Mesh, pinned: Bools, ground: float | None) -> tuple[float | None, tuple[str, ...]]:
    """Return the height of the ground, lowered for a body that starts below it and would be ejected, and a note."""
    heights = mesh.rest_positions[~pinned & ~mesh.loose, 2]
    if ground is None or not len(heights) or heights.min() >= ground - ROUNDING * mesh.size:
        return ground, ()
    lowest = float(heights.min())
    return lowest, (Message(
        "The body starts {depth:.3g} mm below the ground, so the ground is lowered for this body. Move it up to let "
        "it fall.",
        depth=1e3 * (ground - lowest)
    ),)  # fmt: skip


def _even_out(mass: Floats, stiffness: Floats, used: Bools) -> Floats:
    """Move mass to the vertices that are stiff for their mass, so that slivers do not set the time step.

    The total mass is unchanged, and so is an even mesh. On scans and modelled heads less than one percent of the mass
    moves (tests/unit/test_model.py), which saves two thirds of the steps. Known as selective mass scaling.
    """
    wanted = np.maximum(mass, stiffness / (STIFFEST * float(np.median((stiffness / mass)[used]))))
    return wanted * (mass[used].sum() / wanted[used].sum())


def _fill(mesh: Mesh, materials: Sequence[Material]) -> tuple[str, float]:
    """Return the fill and the pressure of the material that covers the largest area."""
    most = materials[int(sums_at(mesh.triangle_material, mesh.triangle_areas, len(materials)).argmax())]
    return most.fill, most.pressure


def _on_vertices(mesh: Mesh, values: Bools | Floats | None, name: str, default: float) -> Floats:
    if values is None:
        return np.full(len(mesh.rest_positions), default)
    values = np.asarray(values, np.float64)
    if values.shape != mesh.source.shape:
        raise DimpleError(
            "The {name} must have one value for each of the {vertices} vertices.",
            name=Message(name), vertices=len(mesh.source)
        )  # fmt: skip
    if not np.isfinite(values).all():
        raise DimpleError("Some values of the {name} are not numbers.", name=Message(name))
    total = sums_at(mesh.source, values, len(mesh.rest_positions))
    return total / np.bincount(mesh.source, minlength=len(mesh.rest_positions))
