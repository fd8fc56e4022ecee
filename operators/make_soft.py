"""Make Soft: everything that a bare mesh needs to be pressed, in one click; the mesh itself stays as it is."""


import bpy
from bpy.props import BoolProperty, EnumProperty

from ..core.messages import Message, about
from . import polls, sessions
from .mesh_faults import Faults, repair
from .messages import gathered, report, say
from .names import Op
from .sizing import fit, settle_size
from .start import LARGE

PRESSABLE = {"MESH", "CURVE", "SURFACE", "META", "FONT"}  # what is no mesh is converted to one
TEXT_DEPTH = 0.15  # of the size of its characters: half of the depth that flat text gets


FIRST = "object_2_vinyl_air"  # number 0 of the list, and so its default
Item = tuple[str, str, str, str, int]
_items: list[Item] = []  # Blender does not keep the strings of a list that a function returns


def presets(_operator: bpy.types.Operator, _context: bpy.types.Context) -> list[Item]:
    """Return the known objects, from soft to hard: identifier, name, source and number."""
    from ..core.everyday import OBJECTS

    if not _items:
        numbers = {name: i for i, name in enumerate([FIRST, *(each.name for each in OBJECTS if each.name != FIRST)])}
        _items.extend((each.name, each.label, each.provenance, "NONE", numbers[each.name]) for each in OBJECTS)
    return _items


class DIMPLE_OT_make_soft(bpy.types.Operator):
    """Make the selected meshes soft bodies, ready to be pressed: material, real size, pins, and what is simulated"""

    bl_idname = Op.MAKE_SOFT
    bl_label = "Make Soft"
    bl_options = {"REGISTER", "UNDO"}

    preset: EnumProperty(
        name="Material",
        description="Object whose constants the material gets; unchosen, only a mesh without one gets it",
        items=presets, default=0, options={"SKIP_SAVE"},  # kept, it would be chosen by nobody
    )  # fmt: skip
    repair: BoolProperty(
        name="Repair", options={"SKIP_SAVE"},
        description="Weld doubled vertices, delete loose ones and turn faces outward, in the mesh itself",
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode and a mesh of this file."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode first")
        if context.object is None or context.object.type not in PRESSABLE:
            return polls.refuse(cls, "Select a mesh first")
        return polls.is_own(cls, context.object) and polls.is_free(cls)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set up every selected mesh; one that cannot be pressed is said and left as it was."""
        from ..core.base import DimpleError
        from . import live, pointer

        done, soft, wrong, noted = [], [], [], []
        try:
            bodies = [obj for obj in live.candidates(context) if obj.type in PRESSABLE]
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        for chosen in bodies:
            obj = chosen
            try:
                if obj.type != "MESH":
                    obj, sentence = convert(context, obj)
                    done.append(sentence)
                if self.repair and not is_shared(obj) and any(repaired := repair(obj)):
                    done += [Message('"{name}" was repaired.', name=obj.name), words(repaired)]
                chosen = self.properties.is_property_set("preset")
                sentence, notes = make_soft(context, obj, self.preset, chosen=chosen)
                soft.append(sentence)
                noted += notes
            except DimpleError as error:
                wrong.append(str(error))
        if not (done or soft):
            say(self, {"ERROR"}, *gathered(wrong))
            return {"CANCELLED"}
        report(self, [*wrong, *noted])
        pointer.choose_tool(context)
        if len(soft) > 1:
            soft = [Message("{count} meshes are soft. Press them with the left mouse button.", count=len(soft))]
        say(self, {"INFO"}, *done, *soft)
        return {"FINISHED"}


def words(found: Faults) -> str:
    """Return the faults of meshes in words."""
    return Message(
        "Doubled vertices: {doubled}. Loose vertices: {loose}. Faces that look inward: {inward}.",
        doubled=found.doubled, loose=found.loose, inward=found.inward
    )  # fmt: skip


def is_shared(obj: bpy.types.Object) -> bool:
    """Tell whether to change a mesh would change more than this object, or unmake its shape keys."""
    return bool(obj.data.shape_keys) or obj.data.users > 1


def make_soft(
    context: bpy.types.Context, obj: bpy.types.Object, preset: str, *, chosen: bool
) -> tuple[str, list[str]]:
    """Make a mesh a soft body; return a sentence on what it is now, and notes on what was found.

    A large one is prepared when it is pressed first, with its progress shown.

    Args:
        chosen: it gets the preset whether it has a material or not.

    Raises:
        DimpleError: it cannot be pressed; only its material and settings may have been set.
    """
    from ..core.base import DimpleError
    from . import bridge, planning

    bridge.check(obj)
    bridge.check_writable(obj)
    if sessions.get(obj):
        raise DimpleError('"{name}" is being pressed already.', name=obj.name)
    if chosen and obj.active_material and obj.active_material.library:
        raise DimpleError('The material of "{name}" is linked from another file. Make it local first.', name=obj.name)
    if chosen or obj.active_material is None:
        with context.temp_override(object=obj, active_object=obj):
            bpy.ops.dimple.apply_preset(preset=preset)
    settle_size(context.scene, obj)
    fit(context.scene, obj)
    obj.dimple.enabled = True
    if len(obj.data.vertices) > LARGE:
        return Message(
            '"{name}" is soft: "{material}". It is prepared when you press it first.',
            name=obj.name,
            material=obj.active_material.name,
        ), []
    _, model = bridge.read_body(context, obj)
    planning.proxy_for(context.scene, obj, model)  # so that the first press begins at once
    size, notes = f"{1e3 * model.mesh.size:.3g} mm", [about(obj.name, note) for note in model.notes]
    said = Message(
        '"{name}" is soft: "{material}", {size} across. Press it with the left mouse button.',
        name=obj.name, material=obj.active_material.name, size=size
    )  # fmt: skip
    return said, notes


def convert(context: bpy.types.Context, obj: bpy.types.Object) -> tuple[bpy.types.Object, str]:
    """Turn a text, a curve or a metaball into the mesh that it shows, flat text with a depth.

    Returns:
        The mesh object, which takes the place of a metaball, and a sentence on it.

    Raises:
        DimpleError: it shows no faces; it was left as it was.
    """
    from ..core.base import DimpleError

    deepened, name, replaced = False, obj.name, obj.type == "META"
    if obj.type == "FONT" and not obj.data.extrude and not obj.data.bevel_depth:  # flat characters are all rim
        obj.data.extrude, deepened = TEXT_DEPTH * obj.data.size, True
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    faces = len(shown.to_mesh().polygons)
    shown.to_mesh_clear()
    if not faces:
        if deepened:
            obj.data.extrude = 0.0
        raise DimpleError(
            '"{name}" has no faces, so there is no surface to press. Give it depth or a bevel first.', name=name
        )
    with context.temp_override(object=obj, active_object=obj, selected_objects=[obj], selected_editable_objects=[obj]):
        bpy.ops.object.convert(target="MESH")
    made = context.view_layer.objects.active if replaced else obj  # Blender removes a metaball
    made.name = name
    what = '"{name}" was given a depth and converted to a mesh.' if deepened else '"{name}" was converted to a mesh.'
    return made, Message(what, name=made.name)


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_make_soft])
