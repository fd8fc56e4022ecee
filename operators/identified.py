"""Identification by itself: what a body runs with is identified on its mesh, in a thread beside Blender.

A result is kept under a name made of mesh, material and tip, in memory and in a folder of Blender's, so it is found
once. Until it is there the body runs with what it had, rescaled, or with the closed form; then `revision` changes, and
what runs takes it over. In the background of a command line, and for a bake, there is nobody to wait for: it is found
at once.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ..core.base import DimpleError
from ..core.calibration import cache
from ..core.calibration.identify import Identification, identification
from ..core.calibration.place import measuring_site

if TYPE_CHECKING:
    from ..core.base import Bools
    from ..core.body.model import Model
    from ..core.material import Material, ModelConstants
    from ..core.mesh.surface import Mesh
    from ..core.reduction.proxy import Proxy

HEAVY = 8000  # vertices: where a larger mesh moves itself it is identified on a proxy
PROXY = 2500  # vertices of that
FINE = 0.6  # of a round tip's radius: a proxy that is coarser answers it otherwise
HOPELESS = 0.24  # of the force, at half of the depths: then the closed form is no worse
LOOK_S = 0.005  # between two looks at the thread
PAUSE_S = 0.04  # before it begins: the body is given the estimate first, and a number that is dragged changes again
TURN_S = 5e-4  # for which the thread keeps Blender's waiting each time that both want Python


@dataclass(slots=True, kw_only=True)
class Job:
    """One identification under way.

    name: what it is kept under.
    owners: the bodies and their slots that ask for it.
    begin: looks at Blender and returns what identifies in a thread,
    due: not before this time [s].
    share: that is done.
    found: what the thread comes to, None until it is started.
    dropped: nobody asks for it any more.
    """

    name: str
    owners: set[tuple[int, int]]
    begin: Callable[[Job], Callable[[], Identification]]
    due: float = field(default_factory=lambda: time.monotonic() + PAUSE_S)
    share: float = 0.0
    found: Future[Identification] | None = None
    dropped: bool = False


Shape = tuple[int, float, float]  # vertices, area [m2] and volume [m3] of a mesh

_PACKAGE = __package__.rpartition(".")[0]

# looks at Blender and returns what chooses the proxy of an object on a mesh, given how its model is built: `planning`
# adds itself
choosing: list[Callable[[int, Mesh, Callable[[], Model]], Callable[[], Proxy | None]]] = []
_usual_turn = sys.getswitchinterval()
revision = 0  # changes with every result of the background
_known: dict[str, Identification | str] = {}  # or the sentence that says why there is none
_jobs: dict[str, Job] = {}  # under way, by name
_latest: dict[tuple[int, int], tuple[Shape, Material]] = {}  # what each body and slot had last, and on which mesh


def model_constants(
    owner: tuple[int, int], mesh: Mesh, material: Material, deepest: float, *, pinned: Bools | None, wait: bool
) -> tuple[ModelConstants | None, str]:
    """Return the model constants of a material on a mesh, None for the closed form, and a note.

    Args:
        owner: session_uid of the object and the slot of its material.
        deepest: depth [m] down to which they are to hold.
        pinned: (N,) input vertices; None where the base is.
        wait: find them now, however long it takes.
    """
    name = cache.key(mesh, material, material.indenter, deepest, *(() if pinned is None else (pinned,)))
    if name not in _known and (kept := cache.recall(own_folder("identified"), name)) is not None:
        _known[name] = kept
    if name not in _known:
        job = Job(name=name, owners={owner}, begin=partial(_beginning, owner[0], mesh, material, pinned, deepest))
        if not wait:
            _start(job)
            return None, ""
        _keep(name, job.begin(job))
    found = _known[name]
    if isinstance(found, str):
        return None, f"The force is an estimate in closed form. {found}"
    _latest[owner] = _shape(mesh), found.material
    return found.material.constants, ""


def latest(owner: tuple[int, int], mesh: Mesh) -> Material | None:
    """Return what was identified last for a body and a slot of its, None where that was on another mesh."""
    shape, material = _latest.get(owner, (None, None))
    return material if shape == _shape(mesh) else None


def _shape(mesh: Mesh) -> Shape:
    return len(mesh.rest_positions), float(mesh.triangle_areas.sum()), mesh.volume


def progress() -> float | None:
    """Return the share that is done of what is being identified, None where nothing is."""
    return min((job.share for job in _jobs.values()), default=None)


def stop() -> None:
    """Let go of what is being identified."""
    for job in _jobs.values():
        job.dropped = True
    _jobs.clear()
    sys.setswitchinterval(_usual_turn)
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)


def _beginning(
    uid: int, mesh: Mesh, material: Material, pinned: Bools | None, deepest: float, job: Job
) -> Callable[[], Identification]:
    """Return what identifies on what moves: the mesh, or its proxy. That is the core's alone, so a thread may call it.
    """
    from ..core.body.model import build_model
    from ..core.mesh.surface import base_vertices
    from ..core.reduction.proxy import build_proxy, mean_spacing

    def model() -> Model:
        materials = [material] * (int(mesh.triangle_material.max()) + 1)
        return build_model(mesh, materials, pinned=base_vertices(mesh) if pinned is None else pinned)

    def moving() -> tuple[Mesh, Bools | None]:
        with contextlib.suppress(DimpleError):  # no proxy of it can be made: so it takes longer
            proxy = next((choose() for choose in chosen), None)
            sphere, fine = material.indenter.shape == "sphere", FINE * material.indenter.radius
            if proxy is None and len(mesh.rest_positions) > HEAVY and not (sphere and mean_spacing(mesh, PROXY) > fine):
                proxy = build_proxy(model(), PROXY)
            if proxy:
                return proxy.model.mesh, proxy.model.pinned
        return mesh, pinned

    def find() -> Identification:
        on, pins = moving()
        site = measuring_site(on, material, deepest, pinned=pins)
        steps = identification(on, material, material.indenter, site, deepest)
        while not job.dropped:
            try:
                job.share = next(steps)
            except StopIteration as end:
                found: Identification = end.value
                return found
        raise DimpleError

    chosen = [choose(uid, mesh, model) for choose in choosing]
    return find


def _start(job: Job) -> None:
    for other in [other for other in _jobs.values() if other.name != job.name]:
        other.owners -= job.owners
        if not other.owners:
            other.dropped = True
            del _jobs[other.name]  # of constants that are being dragged only the last count
    if job.name in _jobs:
        _jobs[job.name].owners |= job.owners
        return
    _jobs[job.name] = job
    if not bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.register(_go_on, persistent=True)


def _go_on() -> float | None:
    """Have a thread find what was asked for first, and keep what it has found; a timer of Blender's."""
    global revision
    job = next(iter(_jobs.values()), None)
    if job and job.found is None and time.monotonic() >= job.due:
        sys.setswitchinterval(TURN_S)
        pool = ThreadPoolExecutor(1)
        job.found = pool.submit(job.begin(job))
        pool.shutdown(wait=False)
    elif job and job.found and job.found.done():
        _keep(job.name, job.found.result)
        _jobs.pop(job.name, None)
        revision += 1
    if not _jobs:
        sys.setswitchinterval(_usual_turn)
    return LOOK_S if _jobs else None


def _keep(name: str, find: Callable[[], Identification]) -> None:
    """Keep what is found, or why nothing is."""
    import numpy as np

    try:
        found = find()
    except DimpleError as error:
        _known[name] = str(error)
        return
    hopeless = np.median(found.off) > HOPELESS
    _known[name] = "No constants of the model follow the measured law." if hopeless else found
    if not hopeless:
        with contextlib.suppress(DimpleError):  # it is found again another time
            cache.remember(own_folder("identified"), name, found)


def own_folder(name: str) -> Path:
    """Return a folder that Blender keeps for the extension; it may be missing."""
    if _PACKAGE.startswith("bl_ext."):
        return Path(bpy.utils.extension_path_user(_PACKAGE, path=name))
    return Path(bpy.app.tempdir)
