"""How long an export will take: a few frames of the bodies themselves are simulated and written, and timed.

What was measured is kept for as long as Blender runs, by body and format. A simulated frame costs up to three times as
much where a body is pressed hard as where it rests, so the time of a simulation is known no better than that,
and that of a few seconds of writing within a factor of two.
"""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ..core.base import DimpleError
from ..core.recording import PointCache
from . import baking, final_mesh
from .clip import Clip
from .export_plan import ExportPlan, check_choice, unplayed
from .formats import FORMATS
from .working import READY

FEW, MANY = 5, 20  # frames that are written to see what a frame costs
SIMULATED_S = 0.5  # for which a body is simulated
SIMULATED = ""  # in place of the format where the time is that of the simulation
MOVED = np.float32(1e-3)  # of the size in each frame: exporters leave out what stands still
_known: dict[tuple[int, int, str, bool], Cost] = {}


class Cost(NamedTuple):
    """What takes time [s]: once, and for each frame."""

    once: float
    frame: float


def measure(context: bpy.types.Context, plan: ExportPlan) -> None:
    """Measure what is not known yet of an export; what cannot be measured stays unknown.

    Raises:
        DimpleError: the plan makes no sense.
    """
    check_choice(plan)
    simulated = unplayed(plan)
    for obj in plan.objects:
        for each in [*([SIMULATED] if obj in simulated else []), *plan.formats]:
            key = _key(obj, each, plan.normals)
            if key in _known:
                continue
            with contextlib.suppress(DimpleError, OSError), tempfile.TemporaryDirectory(prefix="dimple-") as folder:
                if each:
                    _known[key] = _written(context, obj, each, plan.normals, Path(folder))
                else:
                    _known[key] = _simulated(context, obj, plan.first, Path(folder))


def seconds(plan: ExportPlan) -> float | None:
    """Return about how long an export takes [s], None before that was measured."""
    known = parts(plan, unplayed(plan))
    return sum(map(sum, known)) if known else None


def parts(plan: ExportPlan, simulated: list[bpy.types.Object]) -> tuple[list[float], list[float]] | None:
    """Return the time [s] of simulating each of some objects, and of writing each format of each object of a plan.

    Returns:
        None where something was not measured.
    """
    begin, frames = plan.first if plan.begin is None else plan.begin, plan.last - plan.first + 1
    keys = frames if plan.key_error else -(-frames // plan.step)
    try:
        first = [_total(_known[_key(obj, SIMULATED, plan.normals)], plan.last - begin + 1) for obj in simulated]
        then = [
            _total(_known[_key(obj, each, plan.normals)], keys if FORMATS[each].keyed else frames)
            for obj in plan.objects
            for each in plan.formats
        ]
    except KeyError:
        return None
    return first, then


def _key(obj: bpy.types.Object, each: str, normals: bool) -> tuple[int, int, str, bool]:
    return obj.session_uid, len(obj.data.vertices), each, normals and each != SIMULATED


def _total(cost: Cost, frames: int) -> float:
    return cost.once + cost.frame * frames


def _simulated(context: bpy.types.Context, obj: bpy.types.Object, first: int, folder: Path) -> Cost:
    plan = baking.BakePlan(objects=[obj], first=first, last=first + 1000, target="FILES", folder=folder)
    with contextlib.closing(baking.simulate(context, plan, [])) as steps:
        _get_ready(steps)  # the first time, it is decided how the body is simulated
    began, frames = time.perf_counter(), 0
    with contextlib.closing(baking.simulate(context, plan, [])) as steps:
        _get_ready(steps)
        ready = time.perf_counter()
        while time.perf_counter() < ready + SIMULATED_S:
            next(steps)
            frames += 1
        frame = (time.perf_counter() - ready) / frames
    return Cost(max(ready - began - frame, 0.0), frame)


def _get_ready(steps: Iterator[float]) -> None:
    """Run a simulation until its first frame."""
    while next(steps) <= READY:
        pass


def _written(context: bpy.types.Context, obj: bpy.types.Object, each: str, normals: bool, folder: Path) -> Cost:
    rest = final_mesh.read(context, obj, baked=False)
    # the first time, Blender loads what it needs
    once = min(_timed(context, obj, rest, 1, each, normals, folder / name) for name in ("loading", "one"))
    for frames in (FEW, MANY):
        took = _timed(context, obj, rest, frames, each, normals, folder / str(frames))
        if took > 2 * once:  # else what a frame costs is lost in what the file costs
            break
    frame = max(took - once, 0.0) / (frames - 1)
    return Cost(max(once - frame, 0.0), frame)


def _timed(
    context: bpy.types.Context, obj: bpy.types.Object, rest: final_mesh.Final, frames: int, each: str, normals: bool,
    folder: Path,
) -> float:
    """Return the time [s] of writing a body that grows in some frames."""
    folder.mkdir()
    offsets = rest.points * (MOVED * np.arange(frames, dtype=np.float32)[:, None, None])
    with PointCache(folder / "cache.pc2", len(rest.points)) as cache:
        for each_frame in offsets:
            cache.append(each_frame)
    clip = Clip(
        obj=obj, plays=(cache.path, 1, rest.cuts), samples=rest.points + offsets, first=1, last=frames, normals=normals
    )
    began = time.perf_counter()
    for _ in FORMATS[each].write(context, clip, folder / f"written{FORMATS[each].ending}"):
        pass
    return time.perf_counter() - began
