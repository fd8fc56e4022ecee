"""The names of all operators, and of all data that they leave in a file."""

from enum import StrEnum

# prefixes of our data's names: node groups that show a running session, a kept press or a bake, and the objects and
# meshes that hold their offsets; Blender hides data whose name begins with a dot
OURS = ".Dimple "
PRESS, KEPT_PRESS, BAKED_PRESS, CARRIER = ".Dimple Press", ".Dimple Kept", ".Dimple Bake", ".Dimple Carrier"
REST = ".dimple_rest"  # attribute of the evaluated mesh: its shape at rest in this frame
KEPT = "Pressed"  # name of the modifier that keeps a press
CACHE = "Dimple"  # name of the modifier that plays a bake
CACHES_OFF = "dimple_caches_off"  # custom property of an object: the names of its bakes that are off while it is live
PAINTING = "WEIGHT_PAINT"  # besides Object Mode, the only mode in which a simulation continues, with the new weights
POKE_TOOL = "dimple.poke_tool"  # identifier of the tool in the toolbar
DEAD_MAN = "LEFT_SHIFT"  # the haptic device has force only while this key is held

# shapes of the tip that measured a material; identifiers as in the core, in capitals
TIPS = (
    ("POINT", "Point", "A small tip that touches at a point, as in the paper"),
    ("PUNCH", "Flat Punch", "A flat, round face"),
    ("SPHERE", "Ball", "A round tip, like a fingertip"),
)
# properties that can be painted on a body: name, label of the vertex group, and meaning of its weights
MAPS = (
    ("softness", "Softness Group", "softness: 0.5 is as measured, 1 is four times softer, 0 is four times stiffer"),
    ("knee", "Knee Group", "how deep the soft part reaches: 0.5 is x0, 1 is twice and 0.25 is half of that"),
    ("spread", "Spread Group", "how far a dent reaches: 0.5 is the spread, 1 is twice and 0.25 is half of that"),
)
PLACES = (
    ("TOP", "Top", "Press straight down on the middle"),
    ("CURSOR", "3D Cursor", "Press straight into the surface at the point nearest to the 3D cursor"),
)


class Op(StrEnum):
    """The `bpy.ops` names of the extension."""

    COPY_REPORT = "dimple.copy_report"
    MAKE_SOFT = "dimple.make_soft"
    START = "dimple.start"
    POKE = "dimple.poke"
    PLAY = "dimple.play"
    RESET = "dimple.reset"
    BAKE = "dimple.bake"
    UNBAKE = "dimple.unbake"
    EXPORT = "dimple.export_animation"
    ADD_FINGERTIP = "dimple.add_fingertip"
    KEY_PRESS = "dimple.key_press"
    CALIBRATE = "dimple.calibrate"
    CALIBRATE_BY_HAND = "dimple.calibrate_by_hand"
    PASTE_TABLE = "dimple.paste_table"
    SOFTNESS_FROM_POKES = "dimple.softness_from_pokes"
    APPLY_CALIBRATION = "dimple.apply_calibration"
    DISCARD_CALIBRATION = "dimple.discard_calibration"
    SAVE_MATERIAL = "dimple.save_material"
    OPEN_MATERIAL = "dimple.open_material"
    MEASURE = "dimple.measure"
    CONNECT_DEVICE = "dimple.connect_device"
    ARM_DEVICE = "dimple.arm_device"
    DISARM_DEVICE = "dimple.disarm_device"
    CENTRE_DEVICE = "dimple.centre_device"
    OPEN_EXPERIMENT = "dimple.open_experiment"
    CONTINUE_EXPERIMENT = "dimple.continue_experiment"
    ANSWER_TRIAL = "dimple.answer_trial"
    STOP_EXPERIMENT = "dimple.stop_experiment"
