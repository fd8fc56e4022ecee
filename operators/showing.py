"""Show the running sessions on their objects, put those at rest for a moment, and end the ones that were edited."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy

from . import sessions

if TYPE_CHECKING:
    from .bridge import Singles


def end_changed(view_layer: bpy.types.ViewLayer | None = None) -> list[str]:
    """End the sessions whose object is gone, or was edited since it was shown: the edit is kept.

    Duplicates of live bodies are put at rest, before anybody edits them.

    Args:
        view_layer: an object that is not in it counts as gone.

    Returns:
        Sentences for the artist.
    """
    from . import bridge, bridge_write

    messages = []
    for uid, body in list(sessions.sessions.items()):
        obj = bridge.find(uid, body.name)
        if obj is None or (view_layer and obj.name not in view_layer.objects):
            messages += [f'"{body.name}" is gone, so its session has ended.', *sessions.stop(uid)]
        elif not bridge_write.is_intact(obj, body.link, body.borrowed, body.shown):
            words = f'"{obj.name}" was edited while it was pressed, so its session has ended. The edit is kept.'
            messages += [words, *sessions.stop(uid)]
    _rest_duplicates()
    return messages


def _rest_duplicates() -> None:
    """Put duplicates of live bodies at rest; look only when there are other meshes than before."""
    count = len(bpy.data.meshes)
    if any(body.meshes != count for body in sessions.sessions.values()):
        from . import bridge_write

        bridge_write.rescue(sessions.sessions)
        for body in sessions.sessions.values():
            body.meshes = count


def show(obj: bpy.types.Object, body: sessions.LiveBody) -> Singles:
    """Show a session on its object; return the coordinates (N, 3)."""
    from . import bridge, bridge_write

    local = bridge.to_local(body.link, body.matrix, body.session.positions())
    body.shown = bridge_write.show(obj, body.link, local)
    return local


def rest_all(*, for_file: bool = False) -> None:
    """Put every object back as it was; the sessions go on, but for those whose object was edited."""
    from . import bridge, bridge_write, props

    end_changed()
    props.put_back(forget=False)
    bridge_write.rescue(sessions.sessions)
    for uid, body in sessions.sessions.items():
        if obj := bridge.find(uid, body.name):
            bridge_write.pause(obj, body.link, body.borrowed, for_file=for_file)


def show_all() -> None:
    """Show every session again, after its mesh was put at rest."""
    from . import bridge, bridge_write, props

    for world in sessions.worlds:
        props.show(world)
    for uid, body in sessions.sessions.items():
        if obj := bridge.find(uid, body.name):
            bridge_write.resume(obj, body.borrowed)
            if bridge_write.is_showable(obj, body.link, body.borrowed):
                show(obj, body)


@contextmanager
def at_rest() -> Iterator[None]:
    """Put every mesh at rest for a moment: what Blender saves or remembers for undo is never a pressed shape."""
    if not sessions.sessions:
        yield
        return
    rest_all()
    try:
        yield
    finally:
        show_all()
