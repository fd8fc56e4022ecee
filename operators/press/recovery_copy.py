"""A recovery copy while a body is live: Blender's own autosave waits as long as a modal operator runs.

Source: Blender's issue 77825. The copy is written when Blender would have written its own, to the same file, so File >
Recover > Auto Save finds it. The handlers put every mesh at rest for it. It has the path of the copy: after a recovery
the file must be saved again.
"""

import os
import time
from pathlib import Path

import bpy

from ...core.messages import Message
from . import modal_runs


def save_when_due(run: modal_runs.ModalRun) -> list[str]:
    """Write the copy at the interval of Blender's preferences, if autosave is on there.

    Returns:
        Sentences for the artist: why it could not be written.
    """
    settings = bpy.context.preferences.filepaths
    due = run.saved_at + 60 * settings.auto_save_time
    if not settings.use_auto_save_temporary_files or time.monotonic() < due:
        return []
    run.saved_at = time.monotonic()
    copy = path()
    written = copy.with_name(f"dimple_{copy.name}")
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(written), copy=True, check_existing=False)
        os.replace(written, copy)  # the last copy is there until this one is whole
    except (OSError, RuntimeError) as error:
        return [Message("The recovery copy could not be written, so save the file yourself: {error}", error=error)]
    return []


def path() -> Path:
    """Return where Blender would write its autosave."""
    stem = Path(bpy.data.filepath).stem
    name = f"{stem}_{os.getpid()}" if stem else f"{os.getpid()}"
    return Path(bpy.app.tempdir).parent / f"{name}_autosave.blend"
