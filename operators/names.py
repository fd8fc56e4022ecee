"""Names in one place: of the operators, and of what they leave in a file."""

from enum import StrEnum

REST = ".dimple_rest"  # attribute that carries the rest shape; a leading dot is Blender's way to keep it out of sight
LIVE_KEY = "Dimple"  # the shape key that shows a running session
KEPT_KEY = "Pressed"  # what it is called when its shape is kept
BAKED_KEY = "Dimple Frame "  # the keys of a bake are called so, with the number of the frame
CACHE = "Dimple"  # modifiers that play a bake are called so


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
