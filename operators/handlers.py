"""What Blender reports: files are loaded and saved, steps are undone. No session outlives its file, and no file or
undo step is left with a pressed mesh.
"""

import sys

import bpy

from . import sessions, showing
from .names import LIVE_KEY, REST


def _rescue() -> None:
    """Put meshes right that were caught pressed; look first, so that nothing heavy is loaded for nothing."""
    for mesh in bpy.data.meshes:
        keys = mesh.shape_keys
        if REST in mesh.attributes or (keys and LIVE_KEY in keys.key_blocks):
            from . import bridge_write

            bridge_write.rescue(sessions.sessions)
            return


@bpy.app.handlers.persistent
def _on_load_pre(*_: object) -> None:
    sessions.stop_all()


@bpy.app.handlers.persistent
def _on_load_post(*_: object) -> None:
    _rescue()


@bpy.app.handlers.persistent
def _on_save_pre(*_: object) -> None:
    showing.rest_all(for_file=True)


@bpy.app.handlers.persistent
def _on_save_post(*_: object) -> None:
    showing.show_all()


def _goes_on(obj: bpy.types.Object, body: sessions.LiveBody) -> bool:
    """Tell whether an undo has left a session the mesh and the rest shape that it was started with."""
    from . import bridge, bridge_write

    if not bridge_write.is_showable(obj, body.link, body.borrowed):
        return False
    return bool(obj.data.shape_keys) or bool((bridge.rest_coordinates(obj) == body.link.rest).all())


@bpy.app.handlers.persistent
def _on_undo(*_: object) -> None:
    """Go on where the object is still there; an undo may bring back meshes that it caught pressed."""
    sessions.disarm()  # it may put anything under a fingertip of the haptic device at once
    for run in sessions.runs:
        run.shown = ("", "")  # an undo takes the text of the status bar away
    if sessions.sessions:
        from . import bridge

        for uid, body in list(sessions.sessions.items()):
            obj = bridge.find(uid, body.name)
            if obj is None or not _goes_on(obj, body):
                sessions.stop(uid, undoing=True)
        showing.show_all()
    _rescue()


_HANDLERS = {
    "load_pre": _on_load_pre,
    "load_post": _on_load_post,
    "save_pre": _on_save_pre,
    "save_post": _on_save_post,
    "save_post_fail": _on_save_post,
    "undo_post": _on_undo,
    "redo_post": _on_undo,
}


def register() -> None:
    """Listen to Blender."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """End everything that runs and stop listening."""
    sessions.stop_all()
    if identified := sys.modules.get(f"{__package__}.identified"):  # with the core: not before it was needed
        identified.stop()
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
