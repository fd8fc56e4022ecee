"""Presses that compare proxies of one body: what each costs, and how far it is from the full mesh.

The fingertip goes down in 0.15 s and stays there for 0.1 s; positions and forces are compared at the end of that.
"""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from ..base import TICK, DimpleError, Floats, Ints, Singles
from ..body.model import Model
from ..mesh.curve import along_curve
from ..mesh.surface import Mesh
from ..native import Body, create
from ..solver.motion import FingertipMotion, Motion
from .binding import carry
from .cells import vertex_normals
from .proxy import Proxy, build_proxy

DOWN, HOLD, MEAN = 0.15, 0.1, 0.05  # [s]; the force is the mean over the last part of the hold
DEPTH = 0.5  # of the fingertip's radius
DENT = 0.1  # of the largest displacement: vertices that move more belong to the dent
BESIDE_PINS = 2.0  # fingertip radii: nearer to a pinned vertex, a press meets the pins rather than the body
DRAWN = 10  # candidates for each place that is taken: those beside pinned vertices are rejected
_Result = TypeVar("_Result")


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchmarkPress:
    """One press of the benchmark.

    at: (3,) the point of the surface where the fingertip touches [m].
    outward: (3,) unit normal of the surface there.
    radius: of the fingertip [m].
    depth: how far the fingertip goes in [m].
    """

    at: Floats
    outward: Floats
    radius: float
    depth: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Cost and errors of one variant of a body, the full mesh or a proxy, over all presses.

    asked: vertices the proxy was requested with, 0 for the full mesh.
    vertices: simulated vertices.
    steps: per tick.
    cost: processor time [s] per simulated second.
    error: root-mean-square distance of the surface from that of the full mesh, over the dents [m].
    force_error: root-mean-square error of the force over the root-mean-square force.
    note: why there is no result, "" where there is one.
    """

    asked: int = 0
    vertices: int = 0
    steps: int = 0
    cost: float = math.inf
    error: float = math.inf
    force_error: float = math.inf
    note: str = ""


@dataclass(slots=True, kw_only=True)
class PressResult:
    """The end of a press.

    positions: (3, n) [m].
    force: mean force on the fingertip along the normal [N].
    cost: processor time [s].
    """

    positions: Floats = field(default_factory=lambda: np.zeros((3, 0)))
    force: float = 0.0
    cost: float = 0.0


def choose_presses(model: Model, radius: float, count: int, *, seed: int = 0) -> list[BenchmarkPress]:
    """Choose places for presses at random: evenly over the free surface, away from pinned vertices.

    A space-filling curve orders all vertices so that neighbours follow one another. It is cut into equal parts, and
    one press is drawn from each.

    Args:
        radius: of the fingertip [m].
        count: of presses; fewer come back where not so many vertices are free.

    Raises:
        DimpleError: every vertex is pinned.

    Source: stratified sampling in Morton order; scatters less from seed to seed than independent draws.
    """
    mesh, rng = model.mesh, np.random.default_rng(seed)
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    share = np.where(~model.pinned & (np.abs(normals).sum(axis=1) > 0), mesh.vertex_areas, 0.0)
    if not share.sum() > 0:
        raise DimpleError("No part of the surface is free to be pressed. Pin fewer vertices.")
    order = np.argsort(along_curve(mesh.rest_positions), kind="stable")
    drawn = order[_strata(share[order], DRAWN * count, rng)]
    pinned = mesh.rest_positions[model.pinned & ~mesh.loose]
    away = np.array([_distance(pinned, mesh.rest_positions[v]) > BESIDE_PINS * radius for v in drawn])
    chosen = drawn[_strata((away if away.any() else ~away).astype(float), count, rng)]
    depth = min(DEPTH * radius, mesh.size / 8)
    places = dict.fromkeys(chosen.tolist())  # fewer where not so many are free
    return [BenchmarkPress(at=mesh.rest_positions[v], outward=normals[v], radius=radius, depth=depth) for v in places]


def _strata(share: Floats, count: int, rng: np.random.Generator) -> Ints:
    """Draw one index from each of `count` parts of equal share."""
    total = np.cumsum(share)
    return np.searchsorted(total, total[-1] * (np.arange(count) + rng.random(count)) / count, side="right")


def _distance(points: Floats, place: Floats) -> float:
    return float(np.sqrt(((points - place) ** 2).sum(axis=1).min())) if len(points) else math.inf


def press_body(
    body: Body, press: BenchmarkPress, *, substeps: int, chunk: int = 10
) -> Iterator[tuple[float, PressResult]]:
    """Press a body; yield the share that is done and the result so far after every `chunk` ticks."""
    ticks, last = round((DOWN + HOLD) / TICK), round(MEAN / TICK)
    down = np.minimum(np.arange(0, ticks + 1, chunk) * TICK / DOWN, 1) * press.depth
    centres = [(press.at + press.outward * (press.radius - depth)).tolist() for depth in down]
    done, impulse = PressResult(positions=body.positions()), 0.0
    for part, (start, end) in enumerate(zip(centres, centres[1:], strict=False), 1):
        tip = FingertipMotion.straight(start, end, ticks=chunk, radius=press.radius, fresh=part == 1)
        started = time.process_time()
        frame = body.step(Motion(chunk, substeps, TICK, (tip,)))
        done.cost += time.process_time() - started
        if not frame.finite or not frame.touches[0]:
            done.positions = np.full_like(done.positions, np.nan)
            yield part * chunk / ticks, done
            return
        if part * chunk > ticks - last:
            impulse += float(np.array(frame.touches[0].impulse) @ press.outward)
        done.force = impulse / MEAN
        if part == len(centres) - 1:
            done.positions = body.positions()
        yield part * chunk / ticks, done


def compare_proxies(
    model: Model, presses: Sequence[BenchmarkPress], sizes: Sequence[int]
) -> Iterator[tuple[float, Outcome | None]]:
    """Compare proxies of the given numbers of vertices with the full mesh.

    Yields:
        The share that is done, and an outcome whenever one is known; the first is that of the full mesh.
    """
    # the time left is estimated from the work: vertices x steps
    works = [_work_of(model, 0), *(_work_of(model, size) for size in sizes)]
    total, done = sum(works), works[0]
    goal, first = yield from _as_share(press_mesh(model, presses), 0.0, done / total)
    yield done / total, first
    for size, work in zip(sizes, works[1:], strict=True):
        found = yield from _as_share(try_proxy(model, presses, goal, size), done / total, work / total)
        done += work
        yield done / total, found


def press_mesh(
    model: Model, presses: Sequence[BenchmarkPress]
) -> Generator[float, None, tuple[list[PressResult], Outcome]]:
    """Press the full mesh; yield the share that is done, return the results and the outcome."""
    _, steps, goal = yield from press_variant(model, presses, 0)
    return goal, outcome_of(model, 0, None, steps, goal, goal)


def try_proxy(
    model: Model, presses: Sequence[BenchmarkPress], goal: Sequence[PressResult], vertices: int
) -> Generator[float, None, Outcome]:
    """Compare one proxy with the results of the full mesh; yield the share that is done, return its outcome."""
    try:
        proxy, steps, ends = yield from press_variant(model, presses, vertices)
    except DimpleError as error:  # there is no proxy of this size
        return Outcome(asked=vertices, note=str(error))
    return outcome_of(model, vertices, proxy, steps, ends, goal)


def press_variant(
    model: Model, presses: Sequence[BenchmarkPress], vertices: int
) -> Generator[float, None, tuple[Proxy | None, int, list[PressResult]]]:
    """Press a proxy of the given number of vertices, or the full mesh for 0; without a pressure: dents are from rest.

    Yields:
        The share that is done.

    Returns:
        The proxy (None for the full mesh), its steps per tick, and the results of the presses.

    Raises:
        DimpleError: no proxy of this size can be made.
    """
    proxy = build_proxy(model, vertices) if vertices else None
    moves = proxy.model if proxy else model
    limp = replace(moves, pressure=replace(moves.pressure, rest_pressure=0.0))
    steps, ends, body = moves.substeps(TICK), [], create(limp)
    for k, press in enumerate(presses):
        ends.append(PressResult())
        body.set_state(moves.matching.rest)
        for part, ends[k] in press_body(body, press, substeps=steps):
            yield (k + part) / len(presses)
    return proxy, steps, ends


def _as_share(
    steps: Generator[float, None, _Result], done: float, share: float
) -> Generator[tuple[float, None], None, _Result]:
    """Run a part of the work, yielding its progress as a share of the whole."""
    while True:
        try:
            part = next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found
        yield done + share * part, None


def outcome_of(
    model: Model, asked: int, proxy: Proxy | None, steps: int, ends: Sequence[PressResult], goal: Sequence[PressResult]
) -> Outcome:
    """Compare the results of the presses with those of the full mesh."""
    mesh, squares = model.mesh, []
    for end, wanted in zip(ends, goal, strict=True):
        skin = carry(proxy.binding, end.positions) if proxy else end.positions.T
        squares.append(dent_error(mesh, skin, wanted.positions.T) ** 2)
    forces, wanted_forces = (np.array([p.force for p in group]) for group in (ends, goal))
    error = math.sqrt(np.mean(squares))
    seconds = (DOWN + HOLD) * len(ends)
    outcome = Outcome(
        asked=asked, vertices=ends[0].positions.shape[1], steps=steps, cost=sum(p.cost for p in ends) / seconds,
        error=error, force_error=float(np.linalg.norm(forces - wanted_forces) / np.linalg.norm(wanted_forces)),
    )  # fmt: skip
    return outcome if math.isfinite(error) else Outcome(asked=asked, steps=steps, note="the simulation became unstable")


def dent_error(mesh: Mesh, skin: Floats | Singles, wanted: Floats) -> float:
    """Return the root-mean-square distance [m] between two surfaces (n, 3) [m], along the normal, over the dent.

    Sliding along the surface cannot be seen, so only the normal part counts. The dent is where vertices move by DENT
    of the largest displacement or more: all others would lower the mean.
    """
    moved = np.sqrt(((wanted - mesh.rest_positions) ** 2).sum(axis=1))
    dent = moved > DENT * moved.max()
    along = ((skin - wanted) * vertex_normals(mesh.triangles, wanted)).sum(axis=1)[dent]
    return float(np.sqrt((along**2).mean()))


def _work_of(model: Model, vertices: int) -> float:
    """Estimate the work of a variant: vertices x steps; the steps grow with the root of the vertices."""
    n = len(model.mass)
    return (vertices or n) * model.substeps(TICK) * math.sqrt((vertices or n) / n)
