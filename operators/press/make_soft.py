"""Make Soft: give a mesh everything that it needs to be pressed, in one click, without changing the mesh itself."""

import bpy

from ...core.errors import DimpleError
from ...core.material import DEFAULT_MATERIAL
from ...core.message import Message, about, in_a_row
from ..bridge.material_presets import material_of
from ..bridge.sizing import USUAL_MM, fit, settle_size, size_of
from ..names import Op
from ..reporting import gathered, report, say
from . import polls, sessions
from .progress import LARGE

PRESSABLE = {"MESH", "CURVE", "SURFACE", "META", "FONT"}  # types other than meshes are converted
TEXT_DEPTH = 0.15  # [size of the characters] half of the depth that flat text gets
PIN = "Pin"  # name of the vertex group that pins a body unless another is chosen


class DIMPLE_OT_make_soft(polls.Declared, bpy.types.Operator):
    """Make the selected meshes soft and ready to press, with a material, a real size and pins"""

    bl_idname = Op.MAKE_SOFT
    bl_label = "Make Soft"
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode,
        polls.need(lambda context: context.object and context.object.type in PRESSABLE, "Select a mesh first"),
        polls.is_own, polls.is_free,
    )  # fmt: skip

    def run(self, context: bpy.types.Context) -> None:
        """Set up every selected mesh; report each one that cannot be pressed, and leave it unchanged."""
        from . import live_step, poke_input

        done, soft, wrong, noted = [], [], [], []
        for obj in [each for each in live_step.candidates(context) if each.type in PRESSABLE]:
            try:
                if obj.type != "MESH":
                    obj, sentence = convert(context, obj)
                    done.append(sentence)
                sentence, notes = make_soft(context, obj)
                soft.append(sentence)
                noted += notes
            except DimpleError as error:
                wrong.append(str(error))
        if not (done or soft):
            raise DimpleError(in_a_row(gathered(wrong)))
        report(self, [*wrong, *noted])
        poke_input.choose_tool(context)
        if len(soft) > 1:
            soft = [Message("{count} meshes are soft. Press them with the left mouse button.", count=len(soft))]
        say(self, {"INFO"}, *done, *soft)


def make_soft(context: bpy.types.Context, obj: bpy.types.Object) -> tuple[str, list[str]]:
    """Make a mesh a soft body; return a sentence on the result, and notes on the mesh.

    A large mesh is prepared at its first press, with the progress shown.

    Raises:
        DimpleError: the mesh cannot be pressed; only its material and settings may have been set.
    """
    from ...core.everyday_presets import OBJECTS
    from ..bridge import scene_objects
    from .object_body import ObjectBody

    scene_objects.check(obj)
    scene_objects.check_writable(obj)
    if sessions.get(obj):
        raise DimpleError('"{name}" is already being pressed.', name=obj.name)
    settings = material_of(obj, "Soft").dimple
    preset = next((each for each in OBJECTS if each.name == obj.dimple.material), None)  # with these constants
    if preset and not (settings.provenance or settings.id_data.library):
        settings.provenance = preset.provenance
    settle_size(context.scene, obj)
    fit(context.scene, obj)
    size = size_of(context.scene, obj)
    for given in {slot.material for slot in obj.material_slots if slot.material}:
        own = given.users == 1 and not (given.library or given.override_library)
        if own and size > 0 and not given.dimple.is_property_set("spread_mm"):
            given.dimple.spread_mm = 1e3 * DEFAULT_MATERIAL.spread * size / USUAL_MM
    if not obj.dimple.pin_group and PIN in obj.vertex_groups:
        obj.dimple.pin_group = PIN
    obj.dimple.enabled = True
    said = Message(
        '"{name}" is soft: "{material}", {size} across. Press it with the left mouse button.',
        name=obj.name, material=obj.active_material.name, size=f"{size:.3g} mm"
    )  # fmt: skip
    if len(obj.data.vertices) > LARGE:
        return said, []
    model = ObjectBody.from_object(obj).session.model  # planned now, so that the first press begins at once
    return said, [about(obj.name, note) for note in model.notes]


def convert(context: bpy.types.Context, obj: bpy.types.Object) -> tuple[bpy.types.Object, str]:
    """Convert a text, curve, surface or metaball to the mesh that it shows; flat text is given a depth.

    Returns:
        The mesh object (a new one in place of a metaball), and a sentence on it.

    Raises:
        DimpleError: the object has no faces; it is unchanged.
    """
    deepened, name, replaced = False, obj.name, obj.type == "META"
    if obj.type == "FONT" and not obj.data.extrude and not obj.data.bevel_depth:  # else all vertices are on a border
        obj.data.extrude, deepened = TEXT_DEPTH * obj.data.size, True
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    faces = len(shown.to_mesh().polygons)
    shown.to_mesh_clear()
    if not faces:
        if deepened:
            obj.data.extrude = 0.0
        raise DimpleError(
            '"{name}" has no faces, so there is no surface to press. Extrude or bevel it first.', name=name
        )
    with context.temp_override(object=obj, active_object=obj, selected_objects=[obj], selected_editable_objects=[obj]):
        bpy.ops.object.convert(target="MESH")
    made = context.view_layer.objects.active if replaced else obj  # Blender removes a metaball
    made.name = name
    what = '"{name}" was extruded and converted to a mesh.' if deepened else '"{name}" was converted to a mesh.'
    return made, Message(what, name=made.name)
