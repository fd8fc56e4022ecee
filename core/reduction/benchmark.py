"""Presses that compare proxies of one body: what each costs, and how far it is from the mesh itself.

A press goes down in 0.15 s and holds for 0.1 s; judged is the end of the hold.
"""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from ..base import TICK, DimpleError, Floats, Ints
from ..body.model import Model
from ..mesh.surface import Mesh
from ..solver.backend import Body, create
from ..solver.motion import FingertipMotion, Motion
from .cells import vertex_normals
from .proxy import Proxy, build_proxy, carry, contact_radius

DOWN, HOLD, MEAN = 0.15, 0.1, 0.05  # [s]; the force is the mean over the last part of the hold
DEPTH = 0.5  # of the fingertip's radius
DENT = 0.1  # of the largest motion: what moves more belongs to the dent
BESIDE_PINS = 2.0  # fingertip radii: nearer to what is held a press meets the pins rather than the body
DRAWN = 10  # places for one that is taken: those beside what is held are passed over
GRID = 10  # bits a coordinate: the curve that places are spread along passes 2^30 boxes
_Result = TypeVar("_Result")


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """Hold a press: where it meets the surface (3,) [m], which way is out (3,), radius and depth [m]."""

    at: Floats
    outward: Floats
    radius: float
    depth: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Compare one variant of a body, the mesh itself or a proxy, with the mesh itself over the presses.

    asked: vertices the proxy was built for, 0 for the mesh itself.
    vertices: that moved.
    steps: a tick.
    cost: processor time for a second [s].
    error: between the surfaces over the dents, root of the mean square [m].
    force_error: root of the mean square over that of the forces.
    note: "" or why there is no result.
    """

    asked: int = 0
    vertices: int = 0
    steps: int = 0
    cost: float = math.inf
    error: float = math.inf
    force_error: float = math.inf
    note: str = ""


@dataclass(slots=True, kw_only=True)
class Pressed:
    """Hold the end of a press: positions (3, n) [m], force [N] and processor time [s]."""

    positions: Floats = field(default_factory=lambda: np.zeros((3, 0)))
    force: float = 0.0
    cost: float = 0.0


def choose_presses(model: Model, radius: float, count: int, *, seed: int = 0) -> list[Press]:
    """Choose places for presses at random, evenly over the surface that is free, away from what is held.

    A curve passes through all places, near ones one after another; one press is drawn from each equal part of it.
    Source: stratified sampling in Morton's order; scatters less from seed to seed than places drawn one by one.

    Raises:
        DimpleError: everything is held.
    """
    mesh, rng = model.mesh, np.random.default_rng(seed)
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    share = np.where(~model.held & (np.abs(normals).sum(axis=1) > 0), mesh.vertex_areas, 0.0)
    if not share.sum() > 0:
        raise DimpleError("Nothing of the surface is free to be pressed. Hold less of it.")
    order = np.argsort(_along_curve(mesh.rest_positions), kind="stable")
    drawn = order[_strata(share[order], DRAWN * count, rng)]
    held = mesh.rest_positions[model.held & ~mesh.loose]
    away = np.array([_distance(held, mesh.rest_positions[v]) > BESIDE_PINS * radius for v in drawn])
    chosen = drawn[_strata((away if away.any() else ~away).astype(float), count, rng)]
    depth = min(DEPTH * radius, mesh.size / 8)
    places = dict.fromkeys(chosen.tolist())  # fewer where not so many are free
    return [Press(at=mesh.rest_positions[v], outward=normals[v], radius=radius, depth=depth) for v in places]


def _strata(share: Floats, count: int, rng: np.random.Generator) -> Ints:
    """Draw one index from each of so many parts of equal share."""
    total = np.cumsum(share)
    return np.searchsorted(total, total[-1] * (np.arange(count) + rng.random(count)) / count, side="right")


def _along_curve(places: Floats) -> Ints:
    """Return where places (n, 3) lie along a curve through all boxes of a grid. Source: Morton."""
    boxes = (places - places.min(axis=0)) * ((2**GRID - 1) / max(float(np.ptp(places, axis=0).max()), 1e-30))
    bits = boxes.astype(np.int64)[:, :, None] >> np.arange(GRID) & 1
    along: Ints = (bits << 3 * np.arange(GRID) + np.arange(3)[:, None]).sum(axis=(1, 2))
    return along


def _distance(points: Floats, place: Floats) -> float:
    return float(np.sqrt(((points - place) ** 2).sum(axis=1).min())) if len(points) else math.inf


def press_body(
    body: Body, press: Press, *, radius: float, substeps: int, chunk: int = 10
) -> Iterator[tuple[float, Pressed]]:
    """Press a body; yield the share that is done and the state so far after every few ticks.

    Args:
        radius: of the sphere that meets it [m].
    """
    ticks, last = round((DOWN + HOLD) / TICK), round(MEAN / TICK)
    down = np.minimum(np.arange(0, ticks + 1, chunk) * TICK / DOWN, 1) * press.depth
    centres = [(press.at + press.outward * (press.radius - depth)).tolist() for depth in down]
    done, impulse = Pressed(positions=body.positions()), 0.0
    for part, (start, end) in enumerate(zip(centres, centres[1:], strict=False), 1):
        tip = FingertipMotion.straight(start, end, ticks=chunk, radius=radius, fresh=part == 1)
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


def compare(model: Model, presses: Sequence[Press], sizes: Sequence[int]) -> Iterator[tuple[float, Outcome | None]]:
    """Compare proxies of so many vertices with the mesh itself.

    Yields:
        the share that is done, and an outcome whenever one is known. The first is that of the mesh.
    """
    # what is left is known by the work: vertices x steps
    works = [_work_of(model, 0), *(_work_of(model, size) for size in sizes)]
    total, done = sum(works), works[0]
    goal, first = yield from _as_share(press_mesh(model, presses), 0.0, done / total)
    yield done / total, first
    for size, work in zip(sizes, works[1:], strict=True):
        found = yield from _as_share(try_proxy(model, presses, goal, size), done / total, work / total)
        done += work
        yield done / total, found


def press_mesh(model: Model, presses: Sequence[Press]) -> Generator[float, None, tuple[list[Pressed], Outcome]]:
    """Press the mesh itself, stepped by the paper's method; yield the share that is done, return ends and outcome."""
    _, steps, goal = yield from press_variant(model, presses, 0)
    return goal, judge(model, 0, None, steps, goal, goal)


def try_proxy(
    model: Model, presses: Sequence[Press], goal: Sequence[Pressed], vertices: int
) -> Generator[float, None, Outcome]:
    """Compare one proxy with what the mesh itself came to; yield the share that is done, return its outcome."""
    try:
        proxy, steps, ends = yield from press_variant(model, presses, vertices)
    except DimpleError as error:  # no proxy of this size
        return Outcome(asked=vertices, note=str(error))
    return judge(model, vertices, proxy, steps, ends, goal)


def press_variant(
    model: Model, presses: Sequence[Press], vertices: int
) -> Generator[float, None, tuple[Proxy | None, int, list[Pressed]]]:
    """Press a proxy of so many vertices, or the mesh itself for 0.

    Yields:
        the share that is done.

    Returns:
        the proxy, its steps a tick, and the ends of the presses.

    Raises:
        DimpleError: no proxy of this size can be made.
    """
    proxy = build_proxy(model, vertices) if vertices else None
    moves = proxy.model if proxy else model
    steps, ends, body = moves.substeps(TICK), [], create(moves)
    for k, press in enumerate(presses):
        ends.append(Pressed())
        radius = contact_radius(proxy, press.radius) if proxy else press.radius
        body.set_state(moves.matching.rest)
        for part, ends[k] in press_body(body, press, radius=radius, substeps=steps):
            yield (k + part) / len(presses)
    return proxy, steps, ends


def end_of(steps: Generator[float, None, _Result]) -> _Result:
    """Return what comes at the end of steps, taken in one go."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found


def _as_share(
    steps: Generator[float, None, _Result], done: float, share: float
) -> Generator[tuple[float, None], None, _Result]:
    """Pass a part of the work on as a share of the whole."""
    while True:
        try:
            part = next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found
        yield done + share * part, None


def judge(
    model: Model, asked: int, proxy: Proxy | None, steps: int, ends: Sequence[Pressed], goal: Sequence[Pressed]
) -> Outcome:
    """Compare the ends of presses with what they should be."""
    mesh, squares = model.mesh, []
    for end, wanted in zip(ends, goal, strict=True):
        x = carry(proxy, end.positions).T if proxy else end.positions
        squares.append(dent_error(mesh, x.T, wanted.positions.T) ** 2)
    forces, wanted_forces = (np.array([p.force for p in group]) for group in (ends, goal))
    error = math.sqrt(np.mean(squares))
    seconds = (DOWN + HOLD) * len(ends)
    outcome = Outcome(
        asked=asked, vertices=ends[0].positions.shape[1], steps=steps, cost=sum(p.cost for p in ends) / seconds,
        error=error, force_error=float(np.linalg.norm(forces - wanted_forces) / np.linalg.norm(wanted_forces)),
    )  # fmt: skip
    return outcome if math.isfinite(error) else Outcome(asked=asked, steps=steps, note="it blew up")


def dent_error(mesh: Mesh, skin: Floats, wanted: Floats) -> float:
    """Return how far a skin (n, 3) [m] is off the wanted one: along the normal, over what moved by DENT of the most.

    Source: root of the mean square; what slides along the skin is not seen, and what stands still would flatter.
    """
    moved = np.sqrt(((wanted - mesh.rest_positions) ** 2).sum(axis=1))
    dent = moved > DENT * moved.max()
    along = ((skin - wanted) * vertex_normals(mesh.triangles, wanted)).sum(axis=1)[dent]
    return float(np.sqrt((along**2).mean()))


def _work_of(model: Model, vertices: int) -> float:
    """Return about how much work a variant is: vertices x steps; the steps go with the root of the vertices."""
    n = len(model.mass)
    return (vertices or n) * model.substeps(TICK) * math.sqrt((vertices or n) / n)
