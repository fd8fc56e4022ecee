"""Handlers of Blender's load, save and undo events: no session outlives its file, and no saved file shows a press."""


from itertools import chain

import bpy

from ..names import OURS
from . import last_press, sessions, showing


@bpy.app.handlers.persistent
def _rescue(*_: object) -> None:
    """Restore objects that show a press without a session; check names first, to avoid a needless heavy import."""
    if any(each.name.startswith(OURS) for each in chain(bpy.data.node_groups, bpy.data.objects, bpy.data.meshes)):
        from ..bridge import write_back

        write_back.rescue(sessions.sessions)


@bpy.app.handlers.persistent
def _on_load_pre(*_: object) -> None:
    sessions.stop_all()
    last_press.presses.clear()


@bpy.app.handlers.persistent
def _on_save_pre(*_: object) -> None:
    if sessions.sessions:
        showing.rest_all()
    _rescue()


@bpy.app.handlers.persistent
def _on_save_post(*_: object) -> None:
    showing.show_all()


@bpy.app.handlers.persistent
def _on_undo_pre(*_: object) -> None:
    """Remove the modifiers that show the sessions: undo steps do not include them, and undoing would leave pointers to
    freed modifier data, which crash Blender.
    """
    if sessions.sessions:
        showing.rest_all()


@bpy.app.handlers.persistent
def _on_undo(*_: object) -> None:
    """Continue the sessions whose objects still exist; restore objects that an undo brought back in a pressed state."""
    sessions.disarm()  # an undo may suddenly put a surface under a fingertip of the haptic device
    if sessions.sessions:
        from ..bridge import object_link, write_back

        for uid, body in list(sessions.sessions.items()):
            obj = object_link.find(uid, body.name)
            if obj is None or not write_back.is_intact(obj, body.link):
                sessions.stop(uid, undoing=True)
        showing.show_all()
    _rescue()


_HANDLERS = {
    "load_pre": _on_load_pre,
    "load_post": _rescue,
    "blend_import_post": _rescue,
    "save_pre": _on_save_pre,
    "save_post": _on_save_post,
    "save_post_fail": _on_save_post,
    "undo_pre": _on_undo_pre,
    "undo_post": _on_undo,
    "redo_pre": _on_undo_pre,
    "redo_post": _on_undo,
}


def register() -> None:
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """End everything that runs and stop listening."""
    sessions.stop_all()
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
