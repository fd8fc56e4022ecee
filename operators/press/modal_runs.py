"""The modal operators that drive the sessions: each has a timer and a text in the status bar.

Whatever ends a session from outside (loading a file, disabling the extension, an undo that removes the object) also
closes the operator that drives it.

Blender's own autosave waits while a modal operator runs (issue 77825). So a recovery copy is written here at the same
intervals to the same file, and File > Recover > Auto Save finds it. The handlers put every mesh at rest for the copy.
A recovered file has the path of the copy, so it must be saved again under its own name.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from ...core.message import Message

STATUS_S = 0.5  # [s] interval at which the text is set again, because undo, text fields and brushes clear it


@dataclass(slots=True, kw_only=True, eq=False)
class ModalRun:
    """A modal operator that drives the sessions."""

    kind: str  # "poke", "play", or that of a task that must not be interrupted
    timer: bpy.types.Timer | None  # sends the operator its timer events
    shown: str = ""  # text in the status bar
    shown_at: float = 0.0  # time at which the text was last set [s]
    paused: bool = False  # simulated time stands still
    closed: bool = False  # the operator has ended
    step_s: float = 0.002  # longest simulated time of the next step [s]; it shrinks when the computer lags
    saved_at: float = field(default_factory=time.monotonic)  # time at which the last recovery copy was due [s]
    leave: Callable[[], None] | None = None  # called when the run is closed, whatever closes it
    follows: bool = False  # the timeline plays, and the timer was renewed since


runs: list[ModalRun] = []


def at_work() -> bool:
    """Return whether a task runs that must not be interrupted, such as a bake; Esc cancels it."""
    return any(run.kind not in ("poke", "play") for run in runs)


def open_run(context: bpy.types.Context, kind: str, *, interval: float = 1 / 60) -> ModalRun:
    """Register a modal operator and give it a timer; the run of an earlier operator is closed."""
    for run in list(runs):
        close_run(run)
    manager = context.window_manager
    run = ModalRun(kind=kind, timer=manager.event_timer_add(interval, window=context.window))
    runs.append(run)
    return run


def follow_timeline(context: bpy.types.Context, run: ModalRun, playing: bool) -> None:
    """Renew the timer of a run when the timeline begins to play.

    Timers fire in the order in which they were added. Blender then changes the frame before the run steps, so that it
    draws the step of that frame.
    """
    if playing and not run.follows and run.timer:
        manager, interval = context.window_manager, run.timer.time_step
        manager.event_timer_remove(run.timer)
        run.timer = manager.event_timer_add(interval, window=context.window)
    run.follows = playing


def show_status(context: bpy.types.Context, run: ModalRun, text: str) -> None:
    """Show a text in the status bar of the current workspace."""
    now = time.monotonic()
    if run.shown != text or now > run.shown_at + STATUS_S:
        context.workspace.status_text_set(text)
        run.shown, run.shown_at = text, now


def clear_status() -> None:
    """Remove our text from the status bar of every workspace, as it may have been shown in several.

    This needs a window. The context's window may be the one that is closing, which would crash Blender.
    """
    for window in bpy.context.window_manager.windows[:1]:
        with bpy.context.temp_override(window=window):
            for workspace in bpy.data.workspaces:
                with bpy.context.temp_override(workspace=workspace):  # given together, the window's workspace would win
                    workspace.status_text_set(None)


def close_run(run: ModalRun) -> None:
    """Remove the timer and the status text of a modal operator; closing it twice does nothing."""
    if run.closed:
        return
    run.closed = True
    runs.remove(run)
    if run.timer:
        bpy.context.window_manager.event_timer_remove(run.timer)
        run.timer = None
    clear_status()
    redraw()
    if run.leave:
        run.leave()


def redraw() -> None:
    """Ask every viewport to redraw."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def save_when_due(run: ModalRun) -> list[str]:
    """Write the recovery copy if it is due by the autosave settings of Blender's preferences.

    Returns:
        Sentences for the artist: why the copy could not be written.
    """
    settings = bpy.context.preferences.filepaths
    due = run.saved_at + 60 * settings.auto_save_time
    if not settings.use_auto_save_temporary_files or time.monotonic() < due:
        return []
    run.saved_at = time.monotonic()
    copy = recovery_path()
    written = copy.with_name(f"dimple_{copy.name}")
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(written), copy=True, check_existing=False)
        os.replace(written, copy)  # the previous copy stays until the new one is complete
    except (OSError, RuntimeError) as error:
        return [Message("The recovery copy could not be written, so save the file yourself: {error}", error=error)]
    return []


def recovery_path() -> Path:
    """Return the path to which Blender would write its autosave."""
    stem = Path(bpy.data.filepath).stem
    name = f"{stem}_{os.getpid()}" if stem else f"{os.getpid()}"
    return Path(bpy.app.tempdir).parent / f"{name}_autosave.blend"
