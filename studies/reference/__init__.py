"""The reference: what the native core does, in numpy, to be read and tested against.

twin (a body) and twin_scene (bodies that meet) step by semi_implicit; fingertip is its force, ticks, path and rest,
contact and facets are of the skin under it, touching, proximity, bounds, crossing, islands and rolling of what meets,
falling and twin_props of props, cells and carry of proxies. The laws are those of `core.body`.

A method is `run(model, state, path, *, tick, substeps) -> impulses`; those that lost are in studies/methods.
"""

from __future__ import annotations

from core import native
from core.body.model import Model
from core.native import Body

from .twin import Twin


def create(model: Model, *, surface: Model | None = None, backend: str = "native") -> Body | Twin:
    """Return a body of the product, or its twin where the backend is "numpy"; see `core.native.create`."""
    if backend == "numpy":
        return Twin(model, surface=surface)
    return native.create(model, surface=surface, backend=backend)
