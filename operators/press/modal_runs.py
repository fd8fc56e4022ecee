"""The modal operators that drive the sessions: each has a timer and a text in the status bar.

Whatever ends a session from outside (a file is loaded, the extension is switched off, an undo takes the object away)
also closes what drives it.

Blender's own autosave waits as long as a modal operator runs (issue 77825), so a recovery copy is written when it would
have written its own, to the same file: File > Recover > Auto Save finds it. The handlers put every mesh at rest for it.
It has the path of the copy: after a recovery the file must be saved again.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from ...core.messages import Message
from ..translation import tip_

STATUS_S = 0.5  # [s] between two times that a text is set: an undo, a field that is typed into and a brush clear it


@dataclass(slots=True, kw_only=True, eq=False)
class ModalRun:
    """A modal operator that drives the sessions."""

    kind: str  # "poke", "play", or another of what nothing may disturb
    timer: bpy.types.Timer | None  # what wakes it
    shown: str = ""  # text in the status bar
    shown_at: float = 0.0  # when it was set last [s]
    paused: bool = False  # time stands still
    closed: bool = False  # it has ended
    step_s: float = 0.002  # simulated time that the next step asks for [s]; it falls when the computer lags
    saved_at: float = field(default_factory=time.monotonic)  # when the last recovery copy was due [s]
    leave: Callable[[], None] | None = None  # called when the run is closed, by whomever


runs: list[ModalRun] = []


def at_work() -> bool:
    """Tell whether something runs that nothing may disturb; Esc cancels it."""
    return any(run.kind not in ("poke", "play") for run in runs)


def open_run(context: bpy.types.Context, kind: str, state: str = "", *, interval: float = 1 / 60) -> ModalRun:
    """Register a modal operator, give it a timer and show its state; an earlier one that drives the sessions is closed.
    """
    for run in list(runs):
        close_run(run)
    manager = context.window_manager
    run = ModalRun(kind=kind, timer=manager.event_timer_add(interval, window=context.window))
    runs.append(run)
    if state:
        show_status(context, run, tip_(state))
    return run


def show_status(context: bpy.types.Context, run: ModalRun, text: str) -> None:
    """Show a text in the status bar, of whichever workspace is shown now."""
    now = time.monotonic()
    if run.shown != text or now > run.shown_at + STATUS_S:
        context.workspace.status_text_set(text)
        run.shown, run.shown_at = text, now


def clear_status() -> None:
    """Take our text out of the status bar of every workspace: it may have been shown in several.

    That needs a window, and the context's may be the one that is being closed: Blender ends with that.
    """
    for window in bpy.context.window_manager.windows[:1]:
        with bpy.context.temp_override(window=window):
            for workspace in bpy.data.workspaces:
                with bpy.context.temp_override(workspace=workspace):  # a window beside it would win
                    workspace.status_text_set(None)


def close_run(run: ModalRun) -> None:
    """Take timer and status text of a modal operator away; closing twice does nothing."""
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
    """Write the copy at the interval of Blender's preferences, if autosave is on there.

    Returns:
        Sentences for the artist: why it could not be written.
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
        os.replace(written, copy)  # the last copy is there until this one is whole
    except (OSError, RuntimeError) as error:
        return [Message("The recovery copy could not be written, so save the file yourself: {error}", error=error)]
    return []


def recovery_path() -> Path:
    """Return where Blender would write its autosave."""
    stem = Path(bpy.data.filepath).stem
    name = f"{stem}_{os.getpid()}" if stem else f"{os.getpid()}"
    return Path(bpy.app.tempdir).parent / f"{name}_autosave.blend"
