"""The stability map: where methods diverge, time step against stiffness, with the bound that theory gives.

The body is linearised at rest, y' = J y. A method multiplies y by a matrix G(J dt) each step and is stable while no
eigenvalue of G leaves the unit circle. A cell of the map is

    diverged      its deformation (rigid motion apart) is not finite, or grew beyond DIVERGED times that of the start
    inaccurate    at some step it is off the exact motion of the linear body by over INACCURATE of the start
    stable        neither
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.linalg import expm

from core.base import TICK, Floats
from core.body.model import Model, build_model
from studies.files import new_figure, read_csv, save_picture, write_csv
from studies.methods.motion import move, right_hand_side
from studies.methods.registry import METHODS
from studies.reference.laws import State, initial_state, rigid_velocity
from studies.scenes import BALL, BALL_RADIUS, ball

DIVERGED = 3.0
INACCURATE = 0.1
SWINGS = 2.0  # periods of the slowest mode a cell runs for, within these numbers of steps
STEPS = {"explicit": (64, 128), "implicit": (6, 8), "sweeping": (16, 32)}
BOUNDARY_STEPS = 400  # within which a step that is too long must diverge
SLOW_GROWTH = 4  # times as many for explicit Euler
BOUNDARY_SAMPLES = 4
HALVINGS = 6  # of the range from guess / 1.5 to 1.5 guess: the boundary is known to 0.6 %
ON_CIRCLE = 1e-6  # rounding moves the eigenvalues of rigid motions off the circle by the root of machine precision


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One run of the map.

    method: name in METHODS.
    k: surface spring constant [N/m].
    dt: time step [s].
    label: "stable", "inaccurate" or "diverged".
    error: of the positions over the displacement at the start.
    """

    method: str
    k: float
    dt: float
    label: str
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """The largest stable time step of an explicit method at one stiffness.

    method: name in METHODS.
    k: surface spring constant [N/m].
    theory: by the eigenvalues of a step [s].
    measured: where the method itself diverges [s]; NaN where it was not sought.
    product: the step that a session takes, by semi-implicit Euler [s].
    """

    method: str
    k: float
    theory: float
    measured: float
    product: float


def small_body(k: float) -> Model:
    """Return a free hollow ball of 12 vertices with a surface spring constant k [N/m].

    Shape matching is as stiff as the skin, K1 follows k, and has no knee: the map is of a linear body. Hollow, because
    a fill has no damping of its own and explicit Euler would then have no stable step at all.
    """
    slope = BALL.K1 * k / BALL.k
    return build_model(ball(0), [replace(BALL, k=k, K1=slope, K2=slope, fill="none")])


def shaken(model: Model) -> State:
    """Return the body slightly squeezed, with a fifth of noise so that every mode is excited."""
    state = initial_state(model)
    squeeze = state.positions * np.array([[1.0], [-0.5], [-0.5]])
    noise = np.random.default_rng(1).standard_normal(squeeze.shape)
    noise *= 0.2 * np.linalg.norm(squeeze) / np.linalg.norm(noise)
    # small enough for the laws to be linear
    state.positions += 1e-4 * (squeeze + noise)
    return state


def linearised(model: Model) -> Floats:
    """Return J (6 n, 6 n) of y' = J y about rest, by central differences."""
    slope, rest = right_hand_side(model), initial_state(model)
    y = np.concatenate([rest.positions.ravel(), rest.velocities.ravel()])
    eps = 1e-6 * BALL_RADIUS
    columns = [(slope(0, y + eps * e) - slope(0, y - eps * e)) / (2 * eps) for e in np.eye(len(y))]
    return np.stack(columns, axis=1)


def growth(method: str, jacobian: Floats, dt: float) -> float:
    """Return the largest factor by which a step of an explicit method multiplies a mode."""
    z = jacobian * dt
    half = len(z) // 2
    one, zero = np.eye(half), np.zeros((half, half))
    k, c = z[half:, :half], z[half:, half:]  # dt times d(acceleration)/dx and /dv
    if method == "explicit_euler":
        step = np.eye(2 * half) + z
    elif method == "rk4":
        step = np.eye(2 * half) + z @ (
            np.eye(2 * half) + z @ (np.eye(2 * half) + z @ (np.eye(2 * half) + z / 4) / 3) / 2
        )
    elif method == "semi_implicit":
        kick = np.hstack([k, one + c])
        step = np.vstack([np.hstack([one, zero]) + dt * kick, kick])
    elif method == "velocity_verlet":
        # on (x, v, dt a): x1 = x + dt (v + dt a / 2), a1 = a(x1, v + dt a), v1 = v + dt (a + a1) / 2
        drift = np.hstack([one, dt * one, dt / 2 * one])
        after = k @ drift + c @ np.hstack([zero, one, one])
        step = np.vstack([drift, np.hstack([zero, one, one / 2]) + after / 2, after])
    else:
        raise KeyError(method)
    return float(np.abs(np.linalg.eigvals(step)).max())


def bound(method: str, jacobian: Floats) -> float:
    """Return the largest stable dt [s] of an explicit method on a linear body."""
    omega = float(np.abs(np.linalg.eigvals(jacobian)).max())
    return _crossing(lambda dt: growth(method, jacobian, dt) > 1 + ON_CIRCLE, 1e-2 / omega, 4 / omega)


def measured_boundary(method: str, model: Model, guess: float) -> float:
    """Return the largest dt [s] at which the method itself does not diverge, sought near a guess."""
    return _crossing(lambda dt: diverges(method, model, dt), guess / 1.5, guess * 1.5, halvings=HALVINGS)


def diverges(method: str, model: Model, dt: float) -> bool:
    """Tell whether a method diverges at a step dt [s]."""
    steps = BOUNDARY_STEPS * (SLOW_GROWTH if method == "explicit_euler" else 1)
    run = cell(method, model, linearised(model), 0.0, dt, steps=steps, each=steps // BOUNDARY_SAMPLES)
    return run.label == "diverged"


def cell(
    method: str, model: Model, jacobian: Floats, k: float, dt: float, *, steps: int | None = None, each: int = 1
) -> Cell:
    """Run one cell of the map; look at the body after every `each` steps."""
    if steps is None:
        least, most = STEPS[METHODS[method].kind]
        omega = np.abs(np.linalg.eigvals(jacobian))
        slowest = float(omega[omega > 1e-2 * omega.max()].min())
        steps = min(max(math.ceil(SWINGS * 2 * math.pi / slowest / dt), least), most)
    state, rest = shaken(model), initial_state(model).positions
    u = np.concatenate([(state.positions - rest).ravel(), state.velocities.ravel()])
    size, worst = float(np.linalg.norm(u)), 0.0
    exact = np.asarray(expm(jacobian * (each * dt)))
    for _ in range(math.ceil(steps / each)):
        move(model, state, method, seconds=each * dt, steps=each)
        u = exact @ u
        moved = state.positions - rest
        deformed = moved - rigid_velocity(model.mass, rest, moved)
        if not float(np.linalg.norm(deformed)) < DIVERGED * size:
            return Cell(method=method, k=k, dt=dt, label="diverged", error=math.inf)
        worst = max(worst, float(np.linalg.norm(moved.ravel() - u[: moved.size])) / size)
    return Cell(method=method, k=k, dt=dt, label="inaccurate" if worst > INACCURATE else "stable", error=worst)


def stability_map(
    methods: Sequence[str], stiffness: Sequence[float], steps: Sequence[float], *, sought: Sequence[float] = ()
) -> Iterator[Cell | Bound]:
    """Yield every cell, and for explicit methods the bound at every stiffness.

    Args:
        sought: stiffnesses at which the boundary is measured too.
    """
    for k in stiffness:
        model = small_body(k)
        jacobian = linearised(model)
        for method in methods:
            if METHODS[method].kind == "explicit":
                theory = bound(method, jacobian)
                measured = measured_boundary(method, model, theory) if k in sought else math.nan
                product = TICK / model.substeps(TICK)
                yield Bound(method=method, k=k, theory=theory, measured=measured, product=product)
            for dt in steps:
                yield cell(method, model, jacobian, k, dt)


def _crossing(beyond: Callable[[float], bool], low: float, high: float, *, halvings: int = 10) -> float:
    """Return where a test turns true, by bisection on a logarithmic scale."""
    for _ in range(halvings):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return math.sqrt(low * high)


LABELS = ("stable", "inaccurate", "diverged")
BOUNDS = ("k_n_per_m", "bound_dt_s", "measured_dt_s", "product_dt_s")
COLOURS = ("#b7dcc3", "#f2b134", "#a4303f")  # they differ in lightness, for color-blind readers


def measure(out: Path, quick: bool) -> None:
    """Write stability.csv and stability_bounds.csv."""
    stiffness = np.logspace(0.8, 4.8, 3 if quick else 9).tolist()
    steps = np.logspace(-4, -1, 4 if quick else 13).tolist()
    found = list(stability_map(list(METHODS), stiffness, steps, sought=stiffness[-1:] if quick else stiffness[::2]))
    write_csv(
        out / "stability.csv", ("method", "k_n_per_m", "dt_s", "label", "error"),
        ((c.method, c.k, c.dt, c.label, c.error) for c in found if isinstance(c, Cell)),
    )  # fmt: skip
    write_csv(
        out / "stability_bounds.csv", ("method", *BOUNDS),
        ((b.method, b.k, b.theory, b.measured, b.product) for b in found if isinstance(b, Bound)),
    )  # fmt: skip


def draw(out: Path) -> None:
    """Draw a map for each method, with its limits where it has one."""
    cells, bounds = read_csv(out / "stability.csv"), read_csv(out / "stability_bounds.csv")
    stiffness, steps = (sorted({float(cell[name]) for cell in cells}) for name in ("k_n_per_m", "dt_s"))
    labels = {(c["method"], float(c["k_n_per_m"]), float(c["dt_s"])): LABELS.index(c["label"]) for c in cells}
    figure = new_figure(10, 9.6)
    grid = figure.subplots(3, 3, sharex=True, sharey=True)
    for (name, method), axes in zip(METHODS.items(), grid.flat, strict=True):
        codes = [[labels[name, k, dt] for k in stiffness] for dt in steps]
        axes.pcolormesh(
            edges(np.array(stiffness)), edges(np.array(steps)), codes, cmap=ListedColormap(COLOURS), vmin=-0.5,
            vmax=2.5, edgecolors="white", lw=0.3,
        )  # fmt: skip
        axes.set(xscale="log", yscale="log", title=method.label)
        axes.minorticks_off()
        mine = [b for b in bounds if b["method"] == name]
        k, theory, measured, product = ([float(b[column]) for b in mine] for column in BOUNDS)
        axes.plot(k, theory, "k-", lw=1.8)
        axes.plot(k, measured, "o", mfc="white", mec="black", ms=5)
        if name == "semi_implicit":
            axes.plot(k, product, "k:", lw=1.6)
    for below, left in zip(grid[-1], grid[:, 0], strict=True):
        below.set_xlabel("surface spring constant k [N/m]")
        left.set_ylabel("time step [s]")
    keys: list[Patch | Line2D] = [Patch(color=c, label=label) for c, label in zip(COLOURS, LABELS, strict=True)]
    keys.append(Line2D([], [], color="black", lw=1.8, label="limit in theory"))
    keys.append(Line2D([], [], color="black", ls="", marker="o", mfc="white", ms=5, label="limit measured"))
    keys.append(Line2D([], [], color="black", ls=":", lw=1.6, label="step that Dimple takes"))
    figure.legend(handles=keys, loc="outside lower center", ncols=6, frameon=False)
    figure.suptitle(
        "Explicit methods diverge beyond the step that theory gives; the other five never do, but lose accuracy.\n"
        f"A shaken ball of 12 vertices. Diverged: deformed by over {DIVERGED:.0f} times its deformation at the start; "
        f"inaccurate: off by over {100 * INACCURATE:.0f} % of it.\nGreen at the top right: a step so long that the "
        "damped body is at rest after it", fontsize=10,
    )  # fmt: skip
    save_picture(figure, out / "stability.png")


def edges(centres: Floats) -> Floats:
    """Return the borders of cells round centres on a logarithmic scale."""
    ratio = math.sqrt(centres[1] / centres[0])
    return np.append(centres / ratio, centres[-1] * ratio)
