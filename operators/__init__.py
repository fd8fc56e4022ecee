"""The operators: short steps from Blender to the session of the core, and back.

bridge, bridge_write and final_mesh alone read and write mesh arrays. sessions holds what runs, showing puts it on its
objects, live steps it. Nothing heavy is imported here: numpy, trimesh and the core come with the first poke.
"""

from . import (
    add_fingertip,
    apply_preset,
    bake,
    bug_report,
    calibrate,
    calibrate_apply,
    command_line,
    device,
    experiment,
    export,
    handlers,
    key_press,
    make_soft,
    measure,
    play,
    poke,
    record,
    softness,
    start,
    twins,
)

PARTS = (
    bug_report, make_soft, start, poke, play, record, bake, export, apply_preset, add_fingertip, key_press, calibrate,
    calibrate_apply, softness, measure, twins, device, experiment, command_line,
    handlers,
)  # fmt: skip


def register() -> None:
    for part in PARTS:
        part.register()


def unregister() -> None:
    """End what runs, then unregister the operators."""
    for part in reversed(PARTS):
        part.unregister()
