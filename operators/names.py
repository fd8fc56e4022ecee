"""Names in one place: of the operators, and of what they leave in a file."""

from enum import StrEnum

REST = ".dimple_rest"  # attribute that carries the rest shape; a leading dot is Blender's way to keep it out of sight
LIVE_KEY = "Dimple"  # the shape key that shows a running session
KEPT_KEY = "Pressed"  # what it is called when its shape is kept
BAKED_KEY = "Dimple Frame "  # the keys of a bake are called so, with the number of the frame
CACHE = "Dimple"  # modifiers that play a bake are called so
CACHES_OFF = "dimple_caches_off"  # custom property of an object: names of those that are switched off while it is live
DEAD_MAN = "LEFT_SHIFT"  # the haptic device has force only while this key is held

# what measured a material: identifiers are the core's, in capitals
TIPS = (
    ("POINT", "Point", "Something small that touches at a point, as in the paper"),
    ("PUNCH", "Flat Punch", "A flat, round face that goes in as one"),
    ("SPHERE", "Ball", "A round tip, like a fingertip"),
)
PLACES = (
    ("TOP", "Top Middle", "Straight down on the middle of the body"),
    ("CURSOR", "3D Cursor", "Straight into the surface, where the 3D cursor is nearest to it"),
)


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
    CALIBRATE = "dimple.calibrate"
    APPLY_CALIBRATION = "dimple.apply_calibration"
    DISCARD_CALIBRATION = "dimple.discard_calibration"
    IDENTIFY = "dimple.identify"
    MEASURE = "dimple.measure"
    COMPARE_METHODS = "dimple.compare_methods"
    APPLY_METHOD = "dimple.apply_method"
    CONNECT_DEVICE = "dimple.connect_device"
    ARM_DEVICE = "dimple.arm_device"
    DISARM_DEVICE = "dimple.disarm_device"
    CENTRE_DEVICE = "dimple.centre_device"
