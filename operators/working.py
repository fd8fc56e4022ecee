"""What takes more than a second: at once from a script, else between Blender's events, with the time left."""

import time

import bpy

from ..core.messages import Message
from . import modal_runs, sessions
from .messages import duration, say
from .translation import translated

SLICE_S = 0.1  # between two looks at the keyboard
READY = 0.05  # of a bake, for getting ready: how long that takes does not tell how long the frames will


def show_share(context: bpy.types.Context, verb: str, share: float) -> None:
    """Show in the status bar how far something is whose time is not known."""
    said = Message("{verb} {share:.0%} | Esc: cancel", verb=Message(verb), share=share)
    context.workspace.status_text_set(translated(said))


class Working:
    """Give an operator its `execute`, `invoke`, `modal` and `cancel`.

    The operator brings:

    _begin(context): the steps, a generator of the share that is done; closing it undoes what is half done.
    _open(context): the ModalRun.
    _finished(context): what follows the last step.
    verb: what the status bar says it does.
    stopped: the message after Esc.
    ready: the share after which the time left is known.
    """

    ready = 0.0
    _run = None  # while it asks for a file nothing runs yet

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Work in one go."""
        from ..core.base import DimpleError

        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            for share in self._begin(context):
                manager.progress_update(share)
            return self._finished(context)
        except DimpleError as error:
            return self._failed(str(error))
        finally:
            manager.progress_end()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Work with a progress bar, between Blender's own events."""
        from ..core.base import DimpleError

        try:
            self._steps = self._begin(context)
        except DimpleError as error:
            return self._failed(str(error))
        self._run = self._open(context)
        self._run.leave = self._leave
        self._began = time.perf_counter()
        context.window_manager.modal_handler_add(self)
        context.window_manager.progress_begin(0, 1)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Work a little; nothing else may change the scene meanwhile."""
        from ..core.base import DimpleError

        if self._run.closed:
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            sessions.disarm()
            modal_runs.close_run(self._run)
            say(self, {"INFO"}, self.stopped)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            with sessions.ending_on_error():
                share = self._work()
                if share < 1:
                    self._show(context, share)
                    return {"RUNNING_MODAL"}
                modal_runs.close_run(self._run)
                return self._finished(context)
        except DimpleError as error:
            return self._failed(str(error))

    def cancel(self, _context: bpy.types.Context) -> None:
        """Leave when Blender ends the operator: the window closes, another file is loaded."""
        if self._run is not None:
            modal_runs.close_run(self._run)

    def _work(self) -> float:
        """Work for a moment; return the share that is done, 1 when all is."""
        until = time.perf_counter() + SLICE_S
        while (share := next(self._steps, 1.0)) < 1 and time.perf_counter() < until:
            pass
        return share

    def _show(self, context: bpy.types.Context, share: float) -> None:
        context.window_manager.progress_update(share)
        if share <= self.ready:
            self._began = time.perf_counter()
            show_share(context, self.verb, share)
            return
        left = (time.perf_counter() - self._began) * (1 - share) / (share - self.ready)
        said = "{verb} {share:.0%}, {time} left | Esc: cancel"
        said = Message(said, verb=Message(self.verb), share=share, time=duration(left))
        context.workspace.status_text_set(translated(said))

    def _leave(self) -> None:
        self._steps.close()
        bpy.context.window_manager.progress_end()

    def _failed(self, why: str) -> set[str]:
        say(self, {"ERROR"}, why)
        return {"CANCELLED"}
