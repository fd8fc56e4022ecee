"""Identification by itself: what a body runs with is identified on its mesh, in the background of the window.

A result is kept under a name made of mesh, material and tip, in memory and in a folder of Blender's, so it is found
once. Until it is there the body runs with the closed form; then `revision` changes, and what runs takes it over. In
the background of a command line, and for a bake, there is nobody to wait for: it is found at once.
"""

from __future__ import annotations

import threading
from collections.abc import Generator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy

from ..core.base import DimpleError
from ..core.calibration import cache
from ..core.calibration.identify import Identification, identification
from ..core.calibration.indent import Site, find_site
from .output import own_folder

if TYPE_CHECKING:
    from ..core.base import Bools
    from ..core.material import Material, ModelConstants
    from ..core.mesh.surface import Mesh

HEAVY = 6000  # vertices: a larger mesh is identified on a proxy
PROXY = 2500  # vertices of that
HOPELESS = 0.24  # of the force, at half of the depths: then the closed form is no worse
LOOK_S = 0.1  # between two looks at what the background has found


@dataclass(slots=True, kw_only=True)
class Job:
    """One identification in the background.

    name: what it is kept under.
    owners: the bodies and their slots that ask for it.
    steps: of the identification.
    share: that is done.
    found: the result.
    why_not: why there is none, "" otherwise.
    dropped: nobody asks for it any more.
    """

    name: str
    owners: set[tuple[int, int]]
    steps: Generator[float, None, Identification]
    share: float = 0.0
    found: Identification | None = None
    why_not: str = ""
    dropped: bool = False
    over: threading.Event = field(default_factory=threading.Event)


revision = 0  # changes with every result of the background
_known: dict[str, Identification | None] = {}
_jobs: dict[str, Job] = {}  # under way, by name


def model_constants(
    owner: tuple[int, int], mesh: Mesh, material: Material, deepest: float, *, held: Bools | None, wait: bool
) -> tuple[ModelConstants | None, str]:
    """Return the model constants of a material on a mesh, None for the closed form, and a note.

    Args:
        owner: session_uid of the object and the slot of its material; of what it asks for only the last counts.
        deepest: depth [m] down to which they are to hold.
        held: (N,) pinned input vertices; None where the base is.
        wait: find them now, however long it takes.
    """
    try:
        site = find_site(mesh, material.indenter, held=held)
    except DimpleError as error:
        return None, f"The force is an estimate in closed form. {error}"
    name = cache.key(mesh, material, material.indenter, site, deepest)
    if name not in _known and (kept := cache.recall(own_folder("identified"), name)) is not None:
        _known[name] = kept
    if name not in _known:
        if not wait:
            _start(Job(name=name, owners={owner}, steps=_steps(mesh, material, site, deepest)))
            return None, ""
        _finish(_work(Job(name=name, owners={owner}, steps=_steps(mesh, material, site, deepest))))
    found = _known[name]
    if found is None:
        return None, "The force is an estimate in closed form: no constants of the model follow the measured law."
    return found.material.constants, ""


def progress() -> float | None:
    """Return the share that is done of what is being identified, None where nothing is."""
    return min((job.share for job in _jobs.values()), default=None)


def _steps(mesh: Mesh, material: Material, site: Site, deepest: float) -> Generator[float, None, Identification]:
    """Identify on the mesh, or on a proxy of a heavy one."""
    if len(mesh.rest_positions) > HEAVY:
        from ..core.body.model import build_model
        from ..core.reduction.proxy import build_proxy

        materials = [material] * (int(mesh.triangle_material.max()) + 1)
        try:
            mesh = build_proxy(build_model(mesh, materials), PROXY).model.mesh
            site = find_site(mesh, material.indenter, above=site.point.tolist(), inward=site.inward.tolist())
        except DimpleError:  # no proxy of it can be made: so it takes longer
            pass
    return (yield from identification(mesh, material, material.indenter, site, deepest))


def _start(job: Job) -> None:
    for other in [other for other in _jobs.values() if other.name != job.name]:
        other.owners -= job.owners
        if not other.owners:
            other.dropped = True
            del _jobs[other.name]
    if job.name in _jobs:
        _jobs[job.name].owners |= job.owners
        return
    _jobs[job.name] = job
    threading.Thread(target=_work, args=(job,), daemon=True).start()
    if not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=LOOK_S, persistent=True)


def _work(job: Job) -> Job:
    """Run an identification to its end; in a thread this touches nothing of Blender's."""
    try:
        while not job.dropped:
            job.share = next(job.steps)
    except StopIteration as end:
        job.found = end.value
    except DimpleError as error:
        job.why_not = str(error)
    finally:
        job.over.set()
    return job


def _finish(job: Job) -> None:
    """Keep what was found."""
    import numpy as np

    found = job.found
    if found is not None and np.median(found.off) > HOPELESS:
        found = None
    _known[job.name] = found
    if found is not None:
        try:
            cache.remember(own_folder("identified"), job.name, found)
        except DimpleError:  # it is found again another time
            pass


def _look() -> float | None:
    """Take over what the background has found; a timer of Blender's."""
    from . import sessions

    global revision
    for job in [job for job in _jobs.values() if job.over.is_set()]:
        del _jobs[job.name]
        _finish(job)
        revision += 1
    sessions.redraw()
    return LOOK_S if _jobs else None
