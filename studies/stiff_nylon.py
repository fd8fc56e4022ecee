"""The stiff cube of nylon on a fine mesh: which method, or which proxy, runs it live and within the tolerance.

The fingertip goes 10 mm down in 0.12 s and stays for 0.04 s, without friction, which only some of the methods have.
Compared is the skin at SAMPLES moments, of which the worst counts. The reference is the product's own method in double
precision with FINE times its steps. The budget is the planner's, and so is one of the variants.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from core.base import TICK, Floats, Singles
from core.body.model import Model
from core.body.model import build_model as build
from core.material import PRESETS
from core.mesh.surface import Mesh, base_vertices
from core.reduction.binding import carry
from core.reduction.proxy import Proxy, build_proxy
from core.reduction.proxy_rule import BUDGET, plan
from studies.reference.laws import initial_state

from .methods import native as native_method
from .methods.registry import METHODS, Run
from .presses import dent_error
from .reference.path import FingerPath
from .scenes import FINGERTIP, cube, whole_skin

DEPTH = 0.010  # [m]
DOWN, TICKS = 120, 160
SAMPLES = 8
TOLERANCE = 0.5e-3  # [m] between the surfaces, over the dent
FINE = 4  # steps of the reference over the product's
PROXIES = (300, 600, 1200, 2500, 4000)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How a variant did.

    variant: "mesh", "proxy", "planner" (what it chooses), or "reference".
    method: name in METHODS.
    backend: "numpy" or "native".
    vertices: simulated.
    dt: time step [s].
    surface: error between the surfaces in the dent, at the worst moment [m].
    farthest: largest error of a vertex [m].
    cost: processor time per simulated second.
    unsolved: steps that found no solution.
    """

    variant: str
    method: str
    backend: str
    vertices: int
    dt: float
    surface: float
    farthest: float
    cost: float
    unsolved: int

    @property
    def within(self) -> bool:
        """Return whether the tolerance is met."""
        return self.surface <= TOLERANCE

    @property
    def live(self) -> bool:
        """Return whether it stays within the budget of the viewport."""
        return self.cost <= BUDGET


Pressed = tuple[list[Floats], float, int]  # skins (n, 3) [m], cost [s], unsolved


def nylon(cells: int, *, whole: bool) -> Model:
    """Return Object 1 on its base; whole: with all of k in its skin, which makes it far stiffer than it measured."""
    mesh, material = cube(cells, PRESETS[0].size), replace(PRESETS[0].material, friction=0.0)
    return whole_skin(mesh, material) if whole else build(mesh, [material], pinned=base_vertices(mesh))


def outcomes(cells: int, *, whole: bool, slow: bool) -> Iterator[Outcome]:
    """Press the cube with every variant.

    Args:
        cells: squares along an edge.
        whole: with all of k in the skin.
        slow: XPBD with smaller substeps too, half a minute on a fine mesh.
    """
    model = nylon(cells, whole=whole)
    fast: Run = partial(native_method.run, bits=32)
    exact: Run = native_method.run
    substeps, n = model.substeps(TICK), len(model.mass)
    wanted = pressed(model, exact, FINE * substeps)

    def outcome(variant: str, method: str, backend: str, vertices: int, dt: float, found: Pressed) -> Outcome:
        surface, farthest = errors(model.mesh, found[0], wanted[0])
        return Outcome(
            variant=variant, method=method, backend=backend, vertices=vertices, dt=dt, surface=surface,
            farthest=farthest, cost=found[1] / (TICKS * TICK), unsolved=found[2],
        )  # fmt: skip

    # how accurate the reference itself is: the fold of a wrinkling skin is uncertain
    half = pressed(model, exact, FINE // 2 * substeps)
    yield outcome("reference", "semi_implicit", "native", n, TICK / substeps / (FINE // 2), half)
    taken = plan(model, radius=FINGERTIP).proxy
    yield outcome(
        "mesh" if taken else "planner", "semi_implicit", "native", n, TICK / substeps, pressed(model, fast, substeps)
    )
    proxies = [("proxy", build_proxy(model, size)) for size in PROXIES if size <= n / 2]
    for variant, proxy in [("planner", taken), *proxies] if taken else proxies:
        few = proxy.model.substeps(TICK)
        found = _proxy_pressed(proxy, fast, few)
        yield outcome(variant, "semi_implicit", "native", len(proxy.seeds), TICK / few, found)
    for method, steps in (("vertex_block_descent", 1), ("xpbd", 8), ("xpbd", 32))[: 3 if slow else 2]:
        yield outcome("mesh", method, "numpy", n, TICK / steps, pressed(model, METHODS[method].run, steps))


def _proxy_pressed(proxy: Proxy, run: Run, substeps: int) -> Pressed:
    return pressed(proxy.model, run, substeps, show=partial(carry, proxy.binding))


def errors(mesh: Mesh, skins: Sequence[Floats], wanted: Sequence[Floats]) -> tuple[float, float]:
    """Return the error between the surfaces in the dent, and of the farthest vertex [m].

    The worst moment counts. Both are inf where a vertex is ever off by more than the size of the body.
    """
    apart = [a - b for a, b in zip(skins, wanted, strict=True)]
    farthest = max(float(np.sqrt((d**2).sum(axis=1)).max()) for d in apart)
    if not all(np.isfinite(d).all() for d in apart) or farthest > mesh.size:
        return np.inf, np.inf
    surface = max(dent_error(mesh, skin, goal) for skin, goal in zip(skins, wanted, strict=True))
    return surface, farthest


def pressed(
    model: Model,
    run: Run,
    substeps: int,
    *,
    show: Callable[[Floats], Floats | Singles] = np.transpose,
) -> Pressed:
    """Press a body and sample it SAMPLES times."""
    state = copy.deepcopy(initial_state(model))
    z = float(state.positions[2].max()) + FINGERTIP - DEPTH * np.minimum(np.arange(TICKS + 1) / DOWN, 1)
    centres = np.stack([0 * z, 0 * z, z], axis=1)[None]
    piece, skins, cost = TICKS // SAMPLES, [], 0.0
    for i in range(SAMPLES):
        path = FingerPath(centres=centres[:, i * piece : (i + 1) * piece + 1], radii=np.array([FINGERTIP]))
        started = time.process_time()
        with np.errstate(all="ignore"):
            run(model, state, path, tick=TICK, substeps=substeps)
            skins.append(np.array(show(state.positions), np.float64))
        cost += time.process_time() - started
    return skins, cost, state.unsolved
