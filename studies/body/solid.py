"""`dev.py core solid`: rubber pressed by a rigid tip, by finite elements: the referee of a dent's shape and force.

Axisymmetric, without friction, nearly incompressible; the elements are in `solid_elements`. Contact is a force >= 0
against a gap >= 0 at each node of the skin, along the tip's normal: each Newton step solves that complementarity
problem exactly.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import nnls
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import SuperLU, splu

from core.base import Floats, Ints
from studies.body.solid_elements import Solid
from studies.body.solid_mesh import SHAPES, half_section
from studies.files import write_csv

POISSON = 0.49
LAWS = ("linear", "neo-hookean")
STEP_TOLERANCE = 1e-7  # [m] the last Newton step moves nothing further; what it leaves is far smaller
NEWTON_STEPS = 25
SMALLEST_STEP = 2e-5  # [m] of depth: with a smaller one the press has failed


@dataclass(frozen=True, slots=True)
class Tip:
    """A rigid tip on a shaft as wide: a ball, or a flat punch with a rounded edge.

    radius: of the shaft [m].
    edge: radius of its rounding [m]; as large as radius for a ball.
    """

    radius: float
    edge: float

    def gap(self, r: Floats, z: Floats, depth: float) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the distance of points from the tip [m], its normal (r, z), and the normal's curvature [1/m]."""
        flat = self.radius - self.edge
        beside, under = np.maximum(r - flat, 0), np.minimum(z - (self.edge - depth), 0)
        inside = (beside == 0) & (under == 0)  # deeper than the rounding: pushed down
        length = np.where(inside, 1.0, np.hypot(beside, under))
        normal_z = np.where(inside, -1.0, under / length)
        round_edge = (beside > 0) & (under < 0) if flat > 0 else under < 0
        reached = np.where(inside, self.edge - depth - z, length)
        return reached - self.edge, beside / length, normal_z, np.where(round_edge, 1 / length, 0.0)


def ball_tip(radius: float) -> Tip:
    return Tip(radius, radius)


DEPTHS = np.array([0.25, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12.5, 15, 17.5, 20]) * 1e-3  # [m]
TIPS = {"ball 10 mm": ball_tip(0.010), "ball 20 mm": ball_tip(0.020), "punch 5 mm": Tip(0.005, 0.0005)}
STANDARD = 3.0  # [N] at 5 mm of the ball of 10 mm: Young's modulus is chosen for it
DENTS = (5e-3, 10e-3, 20e-3)  # [m] depths whose dents are written
SHOWN = (1, 5, 10, 20)  # [mm] depths whose forces are printed


@dataclass(frozen=True, slots=True)
class SolidPress:
    """What a solid answers to a press.

    depth: (n,) [m].
    force: (n,) [N] of the tip; in units of the Young's modulus where that is 1 Pa.
    volume: (n,) change over the volume at rest.
    r, z: (k,) the skin at rest from the touched place outwards [m].
    u_r, u_z: (n, k) its displacement [m].
    """

    depth: Floats
    force: Floats
    volume: Floats
    r: Floats
    z: Floats
    u_r: Floats
    u_z: Floats

    def skin(self, depth: float) -> Floats:
        """Return the skin at a depth [m]: place at rest and displacement (k, 4) [mm], r and z of each."""
        row = int(np.argmin(np.abs(self.depth - depth)))
        return 1e3 * np.stack([self.r, self.z, self.u_r[row], self.u_z[row]], axis=1)


def press_solid(
    shape: str,
    tip: Tip,
    depths: Floats,
    *,
    law: str = "neo-hookean",
    poisson: float = POISSON,
    refine: float = 1.0,
) -> SolidPress:
    """Press a ball or a block along its axis, from above, to each of the depths in turn; Young's modulus is 1 Pa.

    "linear": Hooke's law with small strains, the tip against the skin's heights as in the theory of Hertz and Sneddon.
    "neo-hookean": W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (J - 1)^2, whose small strains are the same; the tip touches
    the displaced skin along its normal.

    Args:
        shape: "ball" or "block".
        tip: what presses.
        depths: (n,) growing [m].
        refine: elements along each side over those of the usual mesh.

    Raises:
        ArithmeticError: no equilibrium was found.
    """
    smooth = tip.edge == tip.radius
    finest, growth = (tip.radius / 40, 1.08) if smooth else (tip.edge, 1.0)
    reach = 1.75 * tip.radius
    solid = Solid(half_section(shape, reach, finest, growth, refine), poisson, reach)
    found = _press_linear(solid, tip, depths) if law == "linear" else _press(solid, tip, depths)
    states = np.array([state for state, _ in found])
    return SolidPress(
        depth=np.asarray(depths, dtype=float), force=np.array([force for _, force in found]),
        volume=np.array([solid.swollen(state) for state in states]), r=solid.rest[0], z=solid.rest[1],
        u_r=states[:, solid.nodes[0]], u_z=states[:, solid.nodes[1]],
    )  # fmt: skip


def _press_linear(solid: Solid, tip: Tip, depths: Floats) -> list[tuple[Floats, float]]:
    """Return displacement and force at each depth: the skin's compliance once, then a complementarity problem each."""
    r, z = solid.rest[:, solid.touch]
    under, reached = solid.touch[r < tip.radius], r < tip.radius
    loads = np.zeros((solid.u.N, len(under)))
    loads[solid.nodes[1, under], np.arange(len(under))] = -1
    moved = np.zeros_like(loads)
    moved[solid.free] = _factor(solid.stiffness(np.zeros(solid.u.N)), solid.free).solve(loads[solid.free])
    lowest = tip.edge - np.sqrt(tip.edge**2 - np.maximum(r[reached] - (tip.radius - tip.edge), 0) ** 2)
    found = []
    for depth in depths:
        load = complementary(loads.T @ moved, lowest - depth - z[reached])
        if load is None:
            raise ArithmeticError("the body has no stiffness")
        found.append((moved @ load, 2 * np.pi * float(load.sum())))
    return found


def _press(solid: Solid, tip: Tip, depths: Floats) -> list[tuple[Floats, float]]:
    """Return displacement and force at each depth, reached in smaller steps where it must be."""
    state, load, now, step, found = np.zeros(solid.u.N), np.zeros(len(solid.touch)), 0.0, float("inf"), []
    for depth in depths:
        while now < depth:
            step = min(step, depth - now)
            to = depth if step >= depth - now else now + step
            answer = _equilibrium(solid, tip, state, load, to)
            if answer is None:
                step /= 2
                if step < SMALLEST_STEP:
                    raise ArithmeticError(f"no equilibrium was found beyond a depth of {1e3 * now:.2f} mm")
                continue
            state, load, force = answer
            now, step = to, 1.5 * step
        found.append((state, force))
    return found


def _equilibrium(
    solid: Solid, tip: Tip, state: Floats, load: Floats, depth: float
) -> tuple[Floats, Floats, float] | None:
    """Return state, load and force by Newton with the contact solved in each step; None: none was found."""
    free = solid.free
    for _ in range(NEWTON_STEPS):
        try:
            stiffness = solid.stiffness(state)
        except FloatingPointError:
            return None
        gaps, slopes, curvature = contact(solid, tip, state, load, depth)
        # a pressed skin may buckle but for the tip: springs to the tip where it touches make the matrix definite, and
        # change nothing where the gaps end closed
        springs = np.where(load > 0, 10 * stiffness.diagonal()[solid.nodes[1, solid.touch]], 0.0)
        columns = np.column_stack([slopes.toarray(), -solid.stress(state) - slopes @ (springs * gaps)])
        answer = np.zeros_like(columns)
        held = stiffness - curvature + slopes @ diags(springs) @ slopes.T
        answer[free] = _factor(held, free).solve(columns[free])
        new = complementary(slopes.T @ answer[:, :-1], gaps + slopes.T @ answer[:, -1])
        if new is None:
            return None
        move = answer[:, :-1] @ new + answer[:, -1]
        largest = float(np.abs(move).max())
        if not np.isfinite(largest):
            return None
        state, load = state + move, new
        if largest < STEP_TOLERANCE:
            return state, load, -2 * np.pi * float((slopes @ load)[solid.nodes[1]].sum())
    return None


def contact(solid: Solid, tip: Tip, state: Floats, load: Floats, depth: float) -> tuple[Floats, csr_matrix, csr_matrix]:
    """Return the gaps (m,), their derivatives (n, m), and their curvature times the load, summed (n, n)."""
    m, at = len(solid.touch), solid.nodes[:, solid.touch]
    r, z = solid.rest[:, solid.touch] + state[at]
    gap, *normal, curved = tip.gap(r, z, depth)
    wide, column = (len(state), m), np.tile(np.arange(m), 2)
    slopes = csr_matrix((np.concatenate(normal), (at.reshape(-1), column)), wide)
    across = csr_matrix((np.concatenate([normal[1], -normal[0]]), (at.reshape(-1), column)), wide)
    return gap, slopes, across @ diags(curved * load) @ across.T


def _factor(matrix: csr_matrix, free: Ints) -> SuperLU:
    symmetric = {"SymmetricMode": True}  # less fill: 3 times faster
    return splu(matrix[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=symmetric)


def complementary(compliance: Floats, gaps: Floats) -> Floats | None:
    """Return loads >= 0 with gaps + compliance @ loads >= 0, one of each pair 0; None: not positive definite."""
    try:
        factor = np.linalg.cholesky((compliance + compliance.T) / 2)
        return np.asarray(nnls(factor.T, -np.linalg.solve(factor, gaps), maxiter=30 * len(gaps))[0])
    except (np.linalg.LinAlgError, RuntimeError):
        return None


def press_all() -> dict[tuple[str, str, str], SolidPress]:
    """Return every shape under every law and tip; forces [N] of the Young's modulus that gives the standard force."""
    presses = {}
    for shape in SHAPES:
        for law in LAWS:
            young = 0.0
            for name, tip in TIPS.items():
                if name.startswith("punch") and law != "linear":
                    continue  # minutes for one curve, as the skin wraps the edge
                press = press_solid(shape, tip, DEPTHS, law=law)
                young = young or STANDARD / float(np.interp(5e-3, DEPTHS, press.force))
                presses[shape, law, name] = replace(press, force=young * press.force)
                shown = " ".join(f"{np.interp(1e-3 * x, DEPTHS, presses[shape, law, name].force):7.2f}" for x in SHOWN)
                print(f"{shape:<6}{law:<12}{name:<11} {shown} N, volume {100 * press.volume[-1]:+.3f} %", flush=True)
    return presses


def add_solid(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_solid)
    command.add_argument("--out", type=Path, default=Path("build/solid"), metavar="DIR", help="where the results go")


def run_solid(options: argparse.Namespace) -> int:
    """Press, print a line for each curve; write the forces, and the dents at every other node of the skin."""
    print(f"body, law, tip: force at {', '.join(map(str, SHOWN))} mm; change of volume at the last")
    presses = press_all()
    options.out.mkdir(parents=True, exist_ok=True)
    write_csv(
        options.out / "solid_force.csv", ("body", "law", "tip", "depth_mm", "force_n", "volume_change"),
        ((*case, f"{1e3 * depth:g}", f"{force:.5g}", f"{volume:.3g}") for case, press in presses.items()
         for depth, force, volume in zip(press.depth, press.force, press.volume, strict=True)),
    )  # fmt: skip
    write_csv(
        options.out / "solid_dent.csv", ("body", "law", "tip", "depth_mm", "r_mm", "z_mm", "u_r_mm", "u_z_mm"),
        ((*case, f"{1e3 * depth:g}", *(f"{value + 0:.3f}" for value in values)) for case, press in presses.items()
         for depth in DENTS for values in press.skin(depth)[::2]),
    )  # fmt: skip
    return 0
