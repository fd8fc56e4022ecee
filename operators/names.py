"""The names of the operators, in one place: buttons, keys, scripts and tests call them by these."""

from enum import StrEnum


class Op(StrEnum):
    """List every `bpy.ops` name of the extension that does something to a body."""

    POKE = "dimple.poke"
    PLAY = "dimple.play"
    RESET = "dimple.reset"
    RECORD = "dimple.record"
    BAKE = "dimple.bake"
    UNBAKE = "dimple.unbake"
    APPLY_PRESET = "dimple.apply_preset"
    ADD_FINGERTIP = "dimple.add_fingertip"
