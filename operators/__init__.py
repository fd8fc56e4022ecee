"""The operators, which connect Blender to the sessions of the core; each job has a folder.

Only `bridge` reads and writes mesh arrays. In `press`, `sessions` holds the live sessions, `showing` shows them on
their objects and `live_step` steps them. Nothing heavy is imported here: numpy, trimesh and the core are imported with
the first poke.
"""

from collections.abc import Callable
from types import ModuleType

import bpy

from . import bug_report
from .animate import bake_operators, fingertips
from .calibrate import apply_result, by_hand, from_file, material_file, measure, paint_softness
from .device import connect_device
from .experiment import blind_trial
from .export import command_line, export_dialog
from .press import handlers, make_soft, play, poke, progress

PARTS = (
    bug_report, make_soft, progress, poke, play, bake_operators, export_dialog, fingertips, from_file,
    by_hand, apply_result, material_file, paint_softness, measure, connect_device, blind_trial, command_line, handlers,
)  # fmt: skip


def register() -> None:
    for part in PARTS:
        registration(part)[0]()


def unregister() -> None:
    """End everything that runs, then unregister the operators."""
    for part in reversed(PARTS):
        registration(part)[1]()


def registration(part: ModuleType) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return the functions that register and unregister a module: its own, else those of its classes."""
    ours = [each for name, each in vars(part).items() if name.startswith("DIMPLE_")]
    on, off = bpy.utils.register_classes_factory([each for each in ours if each.__module__ == part.__name__])
    return getattr(part, "register", on), getattr(part, "unregister", off)
