"""The shape at rest of an object, frame by frame: what shape keys and the modifiers before a press make of its mesh.

Part of the bridge: with `bridge`, `bridge_write` and `offset` the only toucher of mesh arrays.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from . import offset
from .names import BAKED_KEY
from .object_link import check_matrix, get_points, places
from .stack import is_shaped, place_in_stack

if TYPE_CHECKING:
    from ..core.session import Session
    from .object_link import Floats, ObjectLink, Singles

class RestShape(NamedTuple):
    """The shape at rest of an object now.

    points: (N, 3) its coordinates.
    shaped: keys or modifiers make it of the coordinates of the mesh.
    follows: it can be read at every frame.
    note: "" or a sentence for the artist.
    """

    points: Singles
    shaped: bool
    follows: bool = True
    note: str = ""


@contextmanager
def unbaked(body: bpy.types.Object) -> Iterator[None]:
    """Mute the shape keys of an earlier bake for a while."""
    keys = body.data.shape_keys.key_blocks if body.data.shape_keys else ()
    names = [key.name for key in keys if key.name.startswith(BAKED_KEY) and not key.mute]
    for name in names:
        keys[name].mute = True
    try:
        yield
    finally:
        keys = body.data.shape_keys.key_blocks if names and body.data.shape_keys else {}
        for name in names:
            if name in keys:
                keys[name].mute = False


def read(context: bpy.types.Context, body: bpy.types.Object, *, baked: bool = True) -> RestShape:
    """Return the shape at rest of an object now; change nothing.

    Args:
        baked: take the shape keys of an earlier bake as part of it.
    """
    own = get_points(body.data.attributes["position"].data, len(body.data.vertices), "vector")
    if not is_shaped(body):
        return RestShape(own, False)
    with offset.attached(body), ExitStack() as hidden:
        if not baked:
            hidden.enter_context(unbaked(body))
        given = offset.read_rest(body, context.evaluated_depsgraph_get())
        after = [each for each in body.modifiers[place_in_stack(body) + 1 :] if each.show_viewport]
        for modifier in after:
            modifier.show_viewport = False
            hidden.callback(setattr, modifier, "show_viewport", True)
        rest = offset.read_rest(body, context.evaluated_depsgraph_get()) if after else given
    if rest is None:  # it is not evaluated: hidden, or in no view layer
        return RestShape(own, True, False)
    if given is None or not np.array_equal(given, rest):
        return RestShape(
            rest, True, False,
            f'The modifier "{after[0].name}" reorders vertices, so the shape at rest is that of this frame. '
            "To let it follow the rig, switch that modifier off in the viewport.",
        )  # fmt: skip
    return RestShape(rest, True)


def lead(
    context: bpy.types.Context, obj: bpy.types.Object, link: ObjectLink, session: Session, matrix: Floats, rest: Singles
) -> tuple[Floats, Singles]:
    """Let pins and the shape at rest of a session go where its object and its rig have gone.

    Args:
        matrix: (4, 4) of the object before.
        rest: (N, 3) its shape at rest before.

    Returns:
        Both as they are now.

    Raises:
        DimpleError: the object is flat.
    """
    now, shape = np.array(obj.matrix_world), rest
    if link.follows and is_shaped(obj):
        read_now = offset.read_rest(obj, context.evaluated_depsgraph_get())
        if read_now is not None and len(read_now) == len(rest) and not np.array_equal(read_now, rest):
            shape = read_now
    if shape is rest and np.array_equal(now, matrix):
        return matrix, rest
    check_matrix(obj.name, now)
    there = places(link, now, shape)
    session.set_pins(there)
    if shape is not rest or session.model.rigged:
        session.set_rest(there)
    return now, shape
