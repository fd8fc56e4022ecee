"""The log, and Copy Report, which copies the data for a bug report to the clipboard."""

import logging
import platform
from collections import deque

import bpy

from ..core.errors import DimpleError
from ..core.message import read
from .names import Op
from .press import polls
from .reporting import LOG, say

KEPT = 40  # log entries in a report: enough for some presses, and the last error with its traceback


class Memory(logging.Handler):
    """Keep the last entries of the log."""

    entries: deque[str] = deque(maxlen=KEPT)

    def emit(self, record: logging.LogRecord) -> None:
        """Add an entry."""
        self.entries.append(self.format(record))


MEMORY = Memory(logging.INFO)
MEMORY.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))


class DIMPLE_OT_copy_report(polls.Declared, bpy.types.Operator):
    """Copy versions, the platform and the latest messages and errors, to paste into a bug report"""

    bl_idname = Op.COPY_REPORT
    bl_label = "Copy Report"

    def run(self, context: bpy.types.Context) -> None:
        from ..core import native
        from .bridge import bake_files

        try:
            core = f"ABI {native.ABI}, {native.instructions()}"
        except DimpleError as error:
            core = str(error)
        bodies = [f"{obj.name}: {read(obj.dimple.plan_reason)}" for obj in context.scene.objects if obj.dimple.enabled]
        versions = f"Dimple {bake_files.version()}, Blender {bpy.app.version_string}, {platform.platform()}"
        context.window_manager.clipboard = "\n".join([versions, f"Core: {core}", *bodies, *MEMORY.entries])
        say(self, {"INFO"}, "The report is on the clipboard")


def register() -> None:
    LOG.setLevel(logging.INFO)
    LOG.addHandler(MEMORY)
    bpy.utils.register_class(DIMPLE_OT_copy_report)


def unregister() -> None:
    bpy.utils.unregister_class(DIMPLE_OT_copy_report)
    LOG.removeHandler(MEMORY)
