"""The modes of Dimple's bodies beside those of solid finite elements: frequencies, and the sag under their weight.

The elements are quadratic tetrahedra of scikit-fem, which share nothing with the lattice of core/body/lattice.py.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse.linalg import eigsh, spsolve
from skfem import Basis, BilinearForm, ElementTetP2, ElementVector, LinearForm, MeshHex, MeshTet
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

from core.base import Floats
from core.body.lattice import POISSON
from core.body.modes import Modes, modes_of
from core.mesh.surface import mesh_from_triangles
from studies.files import write_csv

GRAVITY = 9.81  # [m/s2]
SOFT = {"Ecoflex 00-10": (55e3, 1040.0), "jelly": (6.5e3, 1020.0)}  # Young's modulus [Pa] and density [kg/m3]
Pinned = Callable[[Floats], Any]


class Body(NamedTuple):
    """A body in tetrahedra, and which of its points (3, n) are pinned."""

    solid: MeshTet
    pinned: Pinned | None


def bodies(fine: float = 1.0) -> dict[str, Body]:
    """Return what is compared, pinned at a base, free, or with a bone; fine: elements along each side."""
    block = MeshTet.init_tensor(*(np.linspace(0, side, round(fine * n) + 1) for side, n in BLOCK))
    ball = MeshTet.init_ball(3 if fine >= 1 else 2).scaled(BALL)
    base = -BALL + 0.1 * 2 * BALL
    return {
        "block": Body(block, lambda x: x[2] < 1e-9),
        "block, free": Body(block, None),
        "ball": Body(ball, lambda x: (np.linalg.norm(x, axis=0) > 0.97 * BALL) & (x[2] <= base + 1e-9)),
        "ball, free": Body(ball, None),
        "limb with a bone": Body(limb(round(3 * fine), round(16 * fine), round(8 * fine)), lambda x: in_bone(x)),
    }


BALL = 0.0825  # [m] radius
BLOCK = (0.12, 8), (0.08, 5), (0.06, 4)  # [m] sides, and elements along each
BONE, LIMB, LONG = 0.015, 0.05, 0.3  # [m] radii and length


def in_bone(x: Floats) -> Any:
    return np.hypot(x[0], x[1]) < BONE + 1e-4


def limb(across: int, around: int, along: int) -> MeshTet:
    """Return a tube of flesh about a bone."""
    made = MeshHex.init_tensor(
        np.linspace(BONE, LIMB, across + 1), np.linspace(0, 2 * np.pi, around + 1), np.linspace(0, LONG, along + 1)
    )
    r, turn, z = made.p
    places = np.round(np.stack([r * np.cos(turn), r * np.sin(turn), z]), 9) + 0.0
    points, number = np.unique(places, axis=1, return_inverse=True)
    return MeshHex(points, number.ravel()[made.t]).to_meshtet()


def by_elements(body: Body, most: int = 3) -> tuple[Floats, Floats]:
    """Return the first angular frequencies of a body of Young's modulus 1 Pa and density 1 kg/m3 [rad/s], and how far
    (3,) it sags under an acceleration of 1 m/s2 along each axis, 0 where it is free [m].
    """
    space = Basis(body.solid, ElementVector(ElementTetP2()), intorder=4)
    stiff = linear_elasticity(*lame_parameters(1.0, POISSON)).assemble(space)
    mass = BilinearForm(lambda u, v, _: dot(u, v)).assemble(space)
    held = np.flatnonzero(body.pinned(space.doflocs)) if body.pinned else np.empty(0, int)
    free = np.setdiff1d(np.arange(space.N), held)
    stiff, mass = stiff[free][:, free], mass[free][:, free]
    rigid = 0 if body.pinned else 6
    squares = np.sort(eigsh(stiff, k=most + rigid, M=mass, sigma=-1.0 if rigid else 0.0)[0])[rigid:]
    sags = np.zeros(3)
    for axis in range(3) if body.pinned else ():
        load = LinearForm(lambda v, _, axis=axis: v[axis]).assemble(space)[free]
        sags[axis] = np.abs(spsolve(stiff.tocsc(), load)).max()
    return np.sqrt(np.abs(squares)), sags


def by_lattice(body: Body, most: int = 3) -> tuple[Floats, Floats]:
    """Return the same of the lattice."""
    outer = body.solid.facets[:, body.solid.boundary_facets()]
    used, corners = np.unique(outer, return_inverse=True)
    mesh = mesh_from_triangles(*halved(body.solid.p[:, used].T, corners.reshape(outer.shape).T))
    at = mesh.rest_positions
    held = body.pinned(at.T).astype(float) if body.pinned else np.zeros(len(at))
    modes = modes_of(mesh, held)
    assert modes
    return modes.rates[:most], np.array([sag(modes, axis) for axis in range(3)])


def sag(modes: Modes, axis: int) -> float:
    """Return how far a body sags, where most, under an acceleration of 1 m/s2 along an axis [m]."""
    moved = np.einsum("k,kmc->mc", modes.shapes[..., axis] @ modes.volume / modes.rates**2, modes.shapes)
    carried = np.einsum("nc,ncd->nd", modes.shares, moved[modes.nodes])
    return float(np.abs(carried).max())


def halved(points: Floats, triangles: Any) -> tuple[Floats, Any]:
    """Return a surface with each triangle cut in four: what is simulated is finer than these elements."""
    from trimesh.remesh import subdivide

    finer, cut = subdivide(points, triangles)
    return finer, cut


def add_modes(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    command.set_defaults(run=run_modes)
    command.add_argument("--csv", type=Path, metavar="OUT", help="write the table")


def run_modes(options: argparse.Namespace) -> int:
    """Print frequencies and sags of each body in each soft material, beside the elements'."""
    rows = []
    for name, body in bodies().items():
        ours, theirs = by_lattice(body), by_elements(body)
        for material, (young, density) in SOFT.items():
            hertz = math.sqrt(young / density) / (2 * math.pi)
            sag = 1e3 * density * GRAVITY / young
            rows.append([name, material, *np.round(hertz * ours[0], 2), *np.round(hertz * theirs[0], 2),
                         *np.round(sag * ours[1], 2), *np.round(sag * theirs[1], 2)])  # fmt: skip
            print(f"{name}, {material}: {words(hertz * ours[0])} Hz, elements {words(hertz * theirs[0])}", flush=True)
            if body.pinned:
                print(f"  under 1 g {words(sag * ours[1])} mm, elements {words(sag * theirs[1])}", flush=True)
    if options.csv:
        head = [f"{what} {i}, {whose}" for what, whose in HEADS for i in (1, 2, 3)]
        write_csv(options.csv, ["body", "material", *head], rows)
    return 0


HEADS = ("Hz", "lattice"), ("Hz", "elements"), ("mm", "lattice"), ("mm", "elements")


def words(values: Floats) -> str:
    """Return numbers in a row."""
    return " ".join(f"{value:.3g}" for value in values)
