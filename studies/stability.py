"""Where methods blow up: time step against stiffness, with the bound that theory gives.

The body is linearised at rest, y' = J y. A method multiplies y by a matrix G(J dt) each step and is stable while no
eigenvalue of G leaves the unit circle. A cell of the map is

    blown up      its deformation (rigid motion apart) is not finite, or grew beyond BLOWN times that of the start
    inaccurate    at some step it is off the exact motion of the linear body by over INACCURATE of the start
    stable        neither
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.base import TICK, Floats
from core.body.model import Model, build_model
from studies.reference.laws import State, initial_state, rigid_velocity

from .methods.registry import METHODS
from .motion import move, right_hand_side
from .scenes import BALL, BALL_RADIUS, ball

BLOWN = 3.0
INACCURATE = 0.1
SWINGS = 2.0  # periods of the slowest mode a cell runs for, within these numbers of steps
STEPS = {"explicit": (64, 128), "implicit": (6, 8), "sweeping": (16, 32)}
BOUNDARY_STEPS = 400  # within which a step that is too long must blow up
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
    label: "stable", "inaccurate" or "blown up".
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
    measured: where the method itself blows up [s]; NaN where it was not sought.
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
    """Return the largest dt [s] at which the method itself does not blow up, sought near a guess."""
    return _crossing(lambda dt: blows_up(method, model, dt), guess / 1.5, guess * 1.5, halvings=HALVINGS)


def blows_up(method: str, model: Model, dt: float) -> bool:
    """Tell whether a method blows up at a step dt [s]."""
    steps = BOUNDARY_STEPS * (SLOW_GROWTH if method == "explicit_euler" else 1)
    run = cell(method, model, linearised(model), 0.0, dt, steps=steps, each=steps // BOUNDARY_SAMPLES)
    return run.label == "blown up"


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
    exact = _exponential(jacobian * (each * dt))
    for _ in range(math.ceil(steps / each)):
        move(model, state, method, seconds=each * dt, steps=each)
        u = exact @ u
        moved = state.positions - rest
        deformed = moved - rigid_velocity(model.mass, rest, moved)
        if not float(np.linalg.norm(deformed)) < BLOWN * size:
            return Cell(method=method, k=k, dt=dt, label="blown up", error=math.inf)
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


def _exponential(matrix: Floats) -> Floats:
    """Return exp(matrix) by scaling, a Taylor series and squaring."""
    halvings = max(0, math.ceil(math.log2(max(float(np.abs(matrix).sum(axis=1).max()), 1e-9))) + 2)
    small = matrix / 2**halvings
    term = total = np.eye(len(matrix))
    for i in range(1, 14):
        term = term @ small / i
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total
