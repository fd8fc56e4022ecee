"""Show the running sessions on their objects, hide them temporarily, and end those whose objects were edited."""

from __future__ import annotations

import bpy

from ...core.message import Message
from . import sessions


def end_changed(view_layer: bpy.types.ViewLayer | None = None) -> list[str]:
    """End the sessions whose object is gone or was edited; the edit is kept.

    Duplicates of live bodies are put at rest before anyone can edit them.

    Args:
        view_layer: an object that is not in this view layer counts as gone.

    Returns:
        Sentences for the artist.
    """
    from ..bridge import object_link, write_back

    messages = []
    for uid, body in list(sessions.sessions.items()):
        obj = object_link.find(uid, body.name)
        if obj is None or (view_layer and obj.name not in view_layer.objects):
            messages.append(Message('"{name}" is gone, so its session has ended.', name=body.name))
            sessions.stop(uid)
        elif not write_back.is_intact(obj, body.link):
            messages.append(Message(
                '"{name}" was edited while it was pressed, so its session has ended. The edit is kept.', name=obj.name
            ))  # fmt: skip
            sessions.stop(uid)
    _rest_duplicates()
    return messages


def _rest_duplicates() -> None:
    """Put duplicates of live bodies at rest; search only if the number of objects has changed."""
    count = len(bpy.data.objects)
    if any(body.objects != count for body in sessions.sessions.values()):
        from ..bridge import write_back

        write_back.rescue(sessions.sessions)
        for body in sessions.sessions.values():
            body.objects = count


def show(obj: bpy.types.Object, body: sessions.LiveBody) -> None:
    """Show the current offsets of a session on its object, unless they are shown already (the body sleeps)."""
    from ..bridge import press_modifier

    offsets = body.offsets()
    if offsets is not body.shown:
        press_modifier.show(obj, offsets)
        body.shown = offsets


def rest_all() -> None:
    """Hide the sessions before Blender saves or undoes; they continue afterwards."""
    from ..bridge import write_back
    from . import props

    end_changed()
    props.put_back(forget=False)
    write_back.rescue(())


def show_all() -> None:
    """Show every session again."""
    from ..bridge import final_mesh, object_link, write_back
    from . import props

    for world in sessions.worlds:
        props.show(world)
    for uid, body in sessions.sessions.items():
        obj = object_link.find(uid, body.name)
        if obj and write_back.is_intact(obj, body.link):
            final_mesh.attach(bpy.context, obj, body.link.cuts)
            body.shown = None
            show(obj, body)
