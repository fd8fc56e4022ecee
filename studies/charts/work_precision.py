"""The price of precision: what an error costs with each method, scene by scene, and the cheapest method for each."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from scipy.integrate import solve_ivp

from core.base import TICK, Floats
from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import Mesh, base_vertices
from studies.files import aligned, new_figure, read_csv, save_picture, write_csv
from studies.methods import native as native_method
from studies.methods.motion import relative_error, right_hand_side
from studies.methods.registry import METHODS
from studies.paper_objects import PRESETS
from studies.reference.laws import State, initial_state
from studies.reference.path import FingerPath
from studies.scenes import BALL, FINGERTIP, ball, cube, oscillator, twisted_ball, whole_skin

LABELS = {name: method.label for name, method in METHODS.items()} | {"native": "Dimple: semi-implicit Euler in C"}
COLORS = dict(zip(LABELS, [*map("C{}".format, range(9)), "black"], strict=True))
MARKERS = dict(zip(LABELS, "ov^sDPX*p+", strict=True))
RING: dict[str, Any] = {"color": "goldenrod", "marker": "o", "ms": 12, "mfc": "none", "mew": 2, "ls": ""}
EXACT = 1e-9  # an error below that of the reference says nothing

NATIVE = "native"  # semi-implicit Euler in C, double precision: what the language alone gains
RUINED = 1.0  # an error as large as the motion itself says nothing more
DECADES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # bounds on the error, the columns of the table
# number of steps over that at the stability limit of semi-implicit Euler
EXPLICIT_STEPS = (1.02, 1.2, 1.5, 2.0, 4.0, 8.0, 16.0)
IMPLICIT_STEPS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
SWEEPING_STEPS = (0.1, 0.25, 0.5, 1.0, 2.0)
STEPS = {"explicit": EXPLICIT_STEPS, "implicit": IMPLICIT_STEPS, "sweeping": SWEEPING_STEPS}
ALIKE = 1.15  # costs within this factor count as equal
SHORT = 1.0  # [s] a run shorter than this is timed again
FINE = 512  # steps of our own reference over the limit; doubling those changes it by under 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A scene to run.

    name: in tables.
    label: in charts.
    model: the body.
    start: its state at the start.
    seconds: how long it runs [s].
    depth: that the fingertip reaches at half time [m], 0 without a fingertip.
    """

    name: str
    label: str
    model: Model
    start: State
    seconds: float
    depth: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One run.

    case: name of the scene.
    method: name in METHODS, or NATIVE.
    steps: taken.
    error: of the positions, over the motion.
    cost: processor time [s].
    unsolved: steps that found no solution.
    """

    case: str
    method: str
    steps: int
    error: float
    cost: float
    unsolved: int


def cases(*, quick: bool) -> list[Case]:
    """Return the scenes; the quick ones are smaller and shorter."""
    swing, swing_start = oscillator(damping_ratio=0.1)
    free, free_start = twisted_ball(1 if quick else 2, amount=0.3)
    nylon = PRESETS[0]
    # an odd number of cells: a vertex right under a frictionless fingertip may slip to either side
    round_mesh, stiff_mesh = ball(1 if quick else 2), cube(5, nylon.size)
    found = [
        Case(name="oscillator", label="breathing triangle", model=swing, start=swing_start, seconds=0.04),
        Case(name="free_ball", label="twisted ball, free", model=free, start=free_start, seconds=0.01),
        _poke("poke_ball", "poked liquid ball", round_mesh, BALL, 0.02 if quick else 0.05),
        _poke("stiff_nylon", "poked nylon cube", stiff_mesh, nylon.material, 0.015 if quick else 0.06),
    ]
    if quick:
        return found
    water = PRESETS[2]
    return [
        *found,
        _poke("whole_skin", "the same, all of k in the skin", stiff_mesh, nylon.material, 0.005, whole_skin),
        _poke("poke_cube", "poked cube of vinyl and water", cube(5, water.size), water.material, 0.06),
    ]


def points(case: Case, *, quick: bool = False) -> Iterator[Point]:
    """Run every method in numpy over its range of steps, and the native core."""
    wanted = exact(case)
    for name in (*METHODS, NATIVE):
        _advance(case, name, 2)  # what is prepared once for a body is no part of a step's cost
        shares = STEPS["explicit" if name == NATIVE else METHODS[name].kind]
        if quick:
            shares = shares[1:-1:2] if case.depth else shares[:-1:2]
        elif case.depth:
            # contact leaves first order only: the finest runs say nothing new, and implicit ones take minutes
            shares = shares[:-2] if name in METHODS and METHODS[name].kind == "implicit" else shares[:-1]
        wanted_steps = {max(2, math.ceil(share * _limit_steps(case))) for share in shares}
        for steps in sorted({math.prod(_ticks(case, steps)) for steps in wanted_steps}):
            yield run(case, name, steps, wanted, repeats=1 if quick else 3)


def exact(case: Case) -> Floats:
    """Return the positions (3, n) at the end: by SciPy's DOP853, or in contact by very small steps of our own."""
    if case.depth:
        return _advance(case, NATIVE, math.ceil(FINE * _limit_steps(case))).positions
    y = np.concatenate([case.start.positions.ravel(), case.start.velocities.ravel()])
    slope = right_hand_side(case.model)
    answer = solve_ivp(slope, (0, case.seconds), y, method="DOP853", rtol=1e-10, atol=1e-13)
    return np.asarray(answer.y[: case.start.positions.size, -1]).reshape(3, -1)


def run(case: Case, method: str, steps: int, wanted: Floats, *, repeats: int = 1) -> Point:
    """Run a case by about so many steps, a short one several times: the least time counts."""
    costs: list[float] = []
    while not costs or len(costs) < repeats and sum(costs) < SHORT:
        started = time.process_time()
        with np.errstate(all="ignore"):
            state = _advance(case, method, steps)
        costs.append(time.process_time() - started)
    cost = min(costs)
    error = relative_error(state.positions, wanted, case.start.positions)
    taken = math.prod(_ticks(case, steps))
    return Point(
        case=case.name, method=method, steps=taken, error=error if error < RUINED else math.inf, cost=cost,
        unsolved=state.unsolved,
    )  # fmt: skip


def front(points: Sequence[Point]) -> dict[float, Point | None]:
    """Return, for each error bound, the cheapest run in numpy that meets it: methods are compared in one language.

    Of runs that cost nearly the same the most accurate one counts.
    """
    found: dict[float, Point | None] = {}
    for bound in DECADES:
        good = [p for p in points if p.error <= bound and not p.unsolved and p.method != NATIVE]
        least = min((p.cost for p in good), default=0.0)
        found[bound] = min((p for p in good if p.cost <= ALIKE * least), key=lambda p: p.error, default=None)
    return found


def _poke(
    name: str, label: str, mesh: Mesh, material: Material, seconds: float,
    made: Callable[[Mesh, Material], Model] | None = None,
) -> Case:  # fmt: skip
    """Return a press without friction, which only some of the methods have."""
    smooth = replace(material, friction=0.0)
    model = made(mesh, smooth) if made else build_model(mesh, [smooth], pinned=base_vertices(mesh))
    return Case(name=name, label=label, model=model, start=initial_state(model), seconds=seconds, depth=mesh.size / 16)


def _limit_steps(case: Case) -> float:
    return case.seconds * case.model.substeps(0.02) / 0.02


def _ticks(case: Case, steps: int) -> tuple[int, int]:
    """Return ticks, over which a fingertip moves straight, and substeps of each."""
    ticks = min(steps, max(8, round(case.seconds / TICK))) if case.depth else 1
    return ticks, round(steps / ticks)


def _advance(case: Case, method: str, steps: int) -> State:
    """Return the state at the end."""
    state, run_method = copy.deepcopy(case.start), native_method.run if method == NATIVE else METHODS[method].run
    ticks, substeps = _ticks(case, steps)
    tick = case.seconds / ticks
    if not case.depth:
        no_fingers = FingerPath(centres=np.zeros((0, ticks + 1, 3)), radii=np.zeros(0))
        run_method(case.model, state, no_fingers, tick=tick, substeps=substeps)
        return state
    down = np.minimum(np.arange(ticks + 1) / ticks * 2, 1) * case.depth
    centres = np.zeros((1, ticks + 1, 3))
    centres[0, :, 2] = case.model.mesh.rest_positions[:, 2].max() + FINGERTIP - down
    path = FingerPath(centres=centres, radii=np.array([FINGERTIP]))
    run_method(case.model, state, path, tick=tick, substeps=substeps)
    return state


def measure(out: Path, quick: bool) -> None:
    """Write work_precision.csv, and fronts.csv: the cheapest method for each error."""
    found = [point for case in cases(quick=quick) for point in points(case, quick=quick)]
    write_csv(
        out / "work_precision.csv", ("scene", "method", "steps", "relative_error", "cpu_s", "unsolved_steps"),
        ((p.case, p.method, p.steps, p.error, p.cost, p.unsolved) for p in found),
    )  # fmt: skip
    write_csv(
        out / "fronts.csv", ("scene", "error_at_most", "method", "steps", "relative_error", "cpu_ms"),
        ((p.case, bound, p.method, p.steps, f"{p.error:.3g}", f"{1e3 * p.cost:.3g}")
         for case in dict.fromkeys(p.case for p in found)
         for bound, p in front([each for each in found if each.case == case]).items() if p),
    )  # fmt: skip


def kept(path: Path) -> dict[str, list[Point]]:
    """Return the runs in a table, by scene."""
    found: dict[str, list[Point]] = {}
    for row in read_csv(path):
        found.setdefault(row["scene"], []).append(Point(
            case=row["scene"], method=row["method"], steps=int(row["steps"]), error=float(row["relative_error"]),
            cost=float(row["cpu_s"]), unsolved=int(row["unsolved_steps"]),
        ))  # fmt: skip
    return found


def draw(out: Path) -> None:
    """Draw a panel for each scene: cost against error, with the cheapest points ringed; print the cheapest methods."""
    found = kept(out / "work_precision.csv")
    best = {scene: {bound: p for bound, p in front(some).items() if p} for scene, some in found.items()}
    chosen = {p.method for some in best.values() for p in some.values()}
    scenes = [case for case in cases(quick=len(found) < 6) if case.name in found]
    figure = new_figure(11.1, 8.4)
    grid = figure.subplots(2, math.ceil(len(scenes) / 2))
    for case, axes in zip(scenes, grid.flat, strict=True):
        draw_panel(axes, case, found[case.name], list(best[case.name].values()), chosen)
    handles = [line(name, name in chosen, label=label) for name, label in LABELS.items()]
    handles.append(Line2D([], [], **RING, label="the cheapest in numpy for its error"))
    handles.append(Line2D([], [], color="black", marker="x", ls="", label="some steps have no solution"))
    figure.legend(handles=handles, loc="outside lower center", frameon=False, ncols=4)
    for axes in grid[-1]:
        axes.set_xlabel("error of the positions / motion (exact: right)")
    for axes in grid[:, 0]:
        axes.set_ylabel("processor time [s] (fast: below)")
    figure.suptitle(
        "The price of precision: under a fingertip, semi-implicit Euler is the cheapest for an error of 0.1 %.\n"
        "The black line is the same method in C, all others are in numpy; dashed lines are nowhere the cheapest",
        fontsize=11,
    )  # fmt: skip
    save_picture(figure, out / "work_precision.png")
    lines = [("scene", *(f"<= {bound:.0e}" for bound in DECADES), "in C")]
    for scene, some in best.items():
        both = [next(p.cost for p in found[scene] if p.method == name) for name in ("semi_implicit", NATIVE)]
        cheapest = [f"{some[b].method} {1e3 * some[b].cost:.0f} ms" if b in some else "-" for b in DECADES]
        lines.append((scene, *cheapest, f"{both[0] / both[1]:.0f} times faster"))
    print("\nThe cheapest method in numpy for each error; semi-implicit Euler in C\n" + aligned(lines), flush=True)


def draw_panel(axes: Axes, case: Case, found: list[Point], best: list[Point], chosen: set[str]) -> None:
    """Draw cost against error on one scene."""
    for name in LABELS:
        good = [p for p in found if p.method == name and math.isfinite(p.error)]
        if good:
            axes.add_line(line(name, name in chosen, [max(p.error, EXACT) for p in good], [p.cost for p in good]))
    axes.plot([max(p.error, EXACT) for p in best], [p.cost for p in best], **RING)
    odd = [p for p in found if p.unsolved and math.isfinite(p.error)]
    axes.plot([p.error for p in odd], [p.cost for p in odd], "x", color="black", ms=6)
    how = f"fingertip {1e3 * case.depth:.0f} mm down" if case.depth else "nothing touches it"
    axes.set(xscale="log", yscale="log")
    axes.set_title(f"{case.label}\n{case.model.mass.size} vertices, {1e3 * case.seconds:.0f} ms, {how}", fontsize=9)
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.autoscale_view()
    axes.invert_xaxis()


def line(name: str, chosen: bool, x: Sequence[float] = (), y: Sequence[float] = (), label: str = "") -> Line2D:
    """Return the line of a method, bold if the method is the cheapest for some error or is the native core."""
    bold = chosen or name == NATIVE
    return Line2D(
        x, y, color=COLORS[name], marker=MARKERS[name], ms=5, lw=1.8 if bold else 1.0, ls="-" if bold else "--",
        alpha=1.0 if bold else 0.6, label=label,
    )  # fmt: skip
