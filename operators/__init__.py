"""The operators: short steps from Blender to the session of the core, and back, a folder for each job.

Only `bridge` reads and writes mesh arrays. In `press`, `sessions` holds what runs, `showing` puts it on its objects and
`live_step` steps it. Nothing heavy is imported here: numpy, trimesh and the core come with the first poke.
"""

from collections.abc import Callable
from types import ModuleType

import bpy

from . import bug_report
from .animate import bake, fingertips
from .calibrate import apply_preset, apply_result, by_hand, from_file, material_file, measure, paint_softness
from .device import connect_device
from .experiment import blind_trial
from .export import command_line, export_dialog
from .press import handlers, make_soft, play, poke, progress, record

PARTS = (
    bug_report, make_soft, progress, poke, play, record, bake, export_dialog, apply_preset, fingertips, from_file,
    by_hand, apply_result, material_file, paint_softness, measure, connect_device, blind_trial, command_line, handlers,
)  # fmt: skip


def register() -> None:
    for part in PARTS:
        _registered(part)[0]()


def unregister() -> None:
    """End what runs, then unregister the operators."""
    for part in reversed(PARTS):
        _registered(part)[1]()


def _registered(part: ModuleType) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return what registers a module and takes it back: its own functions, else those of its operators."""
    if hasattr(part, "register"):
        return part.register, part.unregister
    return bpy.utils.register_classes_factory(
        [each for name, each in vars(part).items() if name.startswith("DIMPLE_OT_")]
    )
