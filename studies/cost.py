"""The cost of a step as the mesh grows: every method in numpy, and the native core, in one run."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from core.base import TICK

from .methods import native as native_method
from .methods.registry import METHODS, Run
from .reference.path import FingerPath
from .scenes import twisted_ball

NATIVE = "native"
LEAST = 2  # steps timed one by one, of which the median counts
SECONDS = 0.05  # or as many as fit into this


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """The cost of one step.

    method: name in METHODS, or NATIVE.
    vertices: of the ball.
    dt: size of the step [s].
    seconds: processor time of the step [s].
    """

    method: str
    vertices: int
    dt: float
    seconds: float


def costs(methods: Sequence[str], subdivisions: Sequence[int]) -> Iterator[Cost]:
    """Step a twisted ball in the air: explicit methods at the product's own step, the others a tick at a time.

    Args:
        methods: names in METHODS, or NATIVE.
        subdivisions: of the ball, each of four times the vertices.
    """
    for name in methods:
        for count in subdivisions:
            yield _cost(name, count)


def slope(found: Sequence[Cost], method: str) -> float:
    """Return the power of the number of vertices that the cost of a method's step grows with, by least squares."""
    mine = [c for c in found if c.method == method]
    return float(np.polyfit(np.log([c.vertices for c in mine]), np.log([c.seconds for c in mine]), 1)[0])


def _cost(name: str, subdivisions: int) -> Cost:
    run: Run = partial(native_method.run, bits=32) if name == NATIVE else METHODS[name].run
    model, start = twisted_ball(subdivisions, amount=0.3)
    explicit = name == NATIVE or METHODS[name].kind == "explicit"
    dt = TICK / model.substeps(TICK) if explicit else TICK
    many = 10 if name == NATIVE else 1  # a step in C is too short for the clock
    no_fingers = FingerPath(centres=np.zeros((0, 2, 3)), radii=np.zeros(0))
    run(model, copy.deepcopy(start), no_fingers, tick=dt, substeps=1)  # prepares what is made once
    times: list[float] = []
    while len(times) < LEAST or sum(times) < SECONDS:
        state = copy.deepcopy(start)
        started = time.process_time()
        run(model, state, no_fingers, tick=many * dt, substeps=many)
        times.append(time.process_time() - started)
    return Cost(method=name, vertices=len(model.mass), dt=dt, seconds=float(np.median(times)) / many)
