"""How a method changes energy: the breathing triangle without damping, over many steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from core.body.model import Model
from studies.methods.motion import move
from studies.reference.energy import stored
from studies.reference.laws import State
from studies.scenes import oscillator


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """The energy over time.

    method: name in METHODS.
    phases: (m,) omega t.
    ratios: (m,) energy over that at the start.
    """

    method: str
    phases: tuple[float, ...]
    ratios: tuple[float, ...]


def energy(model: Model, state: State) -> float:
    """Return potential and kinetic energy [J], gravity left out."""
    return stored(model, state.positions, state.pose) + float((state.velocities**2).sum(axis=0) @ model.mass) / 2


def energy_trace(method: str, *, omega_dt: float, steps: int, samples: int = 100) -> Trace:
    """Run a method without damping and sample the energy."""
    model, state = oscillator(damping_ratio=0.0, stretch=0.05)
    state.pose = (np.eye(3), np.zeros(3))  # it only breathes: the pose of its shape at rest is constant
    start, each = energy(model, state), max(1, steps // samples)
    dt = omega_dt / breathing_frequency(model)
    phases, ratios = [0.0], [1.0]
    for i in range(1, steps // each + 1):
        move(model, state, method, seconds=each * dt, steps=each)
        phases.append(i * each * omega_dt)
        ratios.append(energy(model, state) / start)
        if not ratios[-1] < 1e6:
            break
    return Trace(method=method, phases=tuple(phases), ratios=tuple(ratios))


def breathing_frequency(model: Model) -> float:
    """Return omega [1/s] of the breathing triangle."""
    k = 3 * float(model.springs.stiffness[0] + model.matching.tension[0]) + float(model.matching.k1[0])
    return math.sqrt(k / float(model.mass[0]))


def artificial_damping(trace: Trace) -> float:
    """Return the damping ratio that loses energy as a trace does: E ~ exp(-2 z omega t); negative where it gains."""
    phases, ratios = np.array(trace.phases), np.array(trace.ratios)
    alive = (ratios > 1e-8) & np.isfinite(ratios)
    return -float(np.polyfit(phases[alive], np.log(ratios[alive]), 1)[0]) / 2


def backward_euler_damping(omega_dt: float) -> float:
    """Return the damping ratio of backward Euler in theory: a step divides the energy by 1 + (omega dt)^2."""
    return math.log1p(omega_dt**2) / (2 * omega_dt)
