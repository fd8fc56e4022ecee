"""What Blender reports: files are loaded and saved, steps are undone. No session outlives its file, and no file shows a
press.
"""


from itertools import chain

import bpy

from ..names import OURS
from . import last_press, sessions, showing


@bpy.app.handlers.persistent
def _rescue(*_: object) -> None:
    """Put objects right that were caught pressed; look first, so that nothing heavy is loaded for nothing."""
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
    """Remove the modifiers that show the sessions: an undo step does not know them, and would leave modifier data
    that is gone, which ends Blender.
    """
    if sessions.sessions:
        showing.rest_all()


@bpy.app.handlers.persistent
def _on_undo(*_: object) -> None:
    """Go on where the object is still there; an undo may bring back objects that it caught pressed."""
    sessions.disarm()  # it may put anything under a fingertip of the haptic device at once
    if sessions.sessions:
        from ..bridge import scene_objects, write_back

        for uid, body in list(sessions.sessions.items()):
            obj = scene_objects.find(uid, body.name)
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
