"""Make Soft: everything that a bare mesh needs to be pressed, in one click; what changes the mesh itself is asked."""

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from . import polls, sessions
from .mesh_faults import Faults, faults, repair
from .messages import report, say
from .names import POKE_TOOL, Op
from .sizing import scale_of, settle_size
from .start import LARGE

if TYPE_CHECKING:
    import numpy as np

# edges [fingertip radii]: up to the first a dent is the fingertip's own; up to the second a press by force is as deep
# on a vertex as beside it, within 5 %, so it is cut that fine where so many vertices do
SHOWN, PRESSED, LIVE = 1.1, 0.55, 8_000
PRESSABLE = {"MESH", "CURVE", "SURFACE", "META", "FONT"}  # what is no mesh is converted to one
MOST_VERTICES = 40_000  # of a mesh that is subdivided
ROUNDS, EVEN = 7, 1.001  # of cutting edges; by less than that all are as long
TEXT_DEPTH = 0.15  # of the size of its characters: half of the depth that flat text gets


_items: list[tuple[str, str, str]] = []  # Blender does not keep the strings of a list that a function returns


def presets(_operator: bpy.types.Operator, _context: bpy.types.Context) -> list[tuple[str, str, str]]:
    """Return the known objects: identifier, name and source."""
    from ..core.everyday import EVERYDAY
    from ..core.material import PRESETS

    if not _items:
        _items.extend((each.name, each.label, each.provenance) for each in (*PRESETS, *EVERYDAY))
    return _items


class DIMPLE_OT_make_soft(bpy.types.Operator):
    """Make the selected meshes soft bodies, ready to be pressed: material, real size, pins, and what is simulated"""

    bl_idname = Op.MAKE_SOFT
    bl_label = "Make Soft"
    bl_options = {"REGISTER", "UNDO"}

    preset: EnumProperty(
        name="Material", description="Known object whose constants a mesh without a material gets",
        items=presets, default=1,
    )  # fmt: skip
    subdivide: BoolProperty(
        name="Subdivide", description="Cut edges that are longer than the fingertip is wide, which changes the mesh"
    )
    repair: BoolProperty(
        name="Repair", description="Weld doubled vertices, delete loose ones and turn faces outward, in the mesh itself"
    )
    faults: StringProperty(name="Faults", options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode and a mesh of this file."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode first")
        if context.object is None or context.object.type not in PRESSABLE:
            return polls.refuse(cls, "Select a mesh first")
        return polls.is_own(cls, context.object) and polls.is_free(cls)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask only where the mesh itself should be changed."""
        from . import live

        meshes = [obj for obj in live.candidates(context) if obj.type == "MESH"]
        self.subdivide = any(is_coarse(context, obj) for obj in meshes)
        found = [f for obj in meshes if not is_shared(obj) and any(f := faults(obj))]
        self.faults = words(Faults(*map(sum, zip(*found, strict=True)))) if found else ""
        self.repair = bool(found)
        if self.subdivide or self.repair:
            return context.window_manager.invoke_props_dialog(self, width=380)
        return self.execute(context)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the material, and what is offered, and why."""
        column = self.layout.column()
        column.prop(self, "preset")
        if self.subdivide or not self.faults:
            column.label(text="Edges are longer than the fingertip is wide.", icon="INFO")
            column.label(text="A bake shows the dent only where the mesh is cut finer.", icon="BLANK1")
        column.prop(self, "subdivide")
        if self.faults:
            column.label(text=self.faults, icon="INFO")
        column.prop(self, "repair")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set up every selected mesh; one that cannot be pressed is said and left as it was."""
        from ..core.base import DimpleError
        from . import live

        done, wrong, noted = [], [], []
        try:
            bodies = [obj for obj in live.candidates(context) if obj.type in PRESSABLE]
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        for obj in bodies:
            try:
                if obj.type != "MESH":
                    done.append(convert(context, obj))
                if self.repair and not is_shared(obj) and any(repaired := repair(obj)):
                    done.append(f'"{obj.name}" was repaired. {words(repaired)}')
                sentence, notes = make_soft(context, obj, self.preset, subdivide=self.subdivide)
                done.append(sentence)
                noted += notes
            except DimpleError as error:
                wrong.append(str(error))
        if not done:
            say(self, {"ERROR"}, " ".join(wrong))
            return {"CANCELLED"}
        report(self, [*wrong, *noted])
        choose_tool(context)
        say(self, {"INFO"}, " ".join(done))
        return {"FINISHED"}


def words(found: Faults) -> str:
    """Return the faults of meshes in words."""
    return (
        f"Doubled vertices: {found.doubled}. Loose vertices: {found.loose}. Faces that look inward: {found.inward}."
    )


def is_shared(obj: bpy.types.Object) -> bool:
    """Tell whether to change a mesh would change more than this object, or unmake its shape keys."""
    return bool(obj.data.shape_keys) or obj.data.users > 1


def make_soft(
    context: bpy.types.Context, obj: bpy.types.Object, preset: str, *, subdivide: bool
) -> tuple[str, list[str]]:
    """Make a mesh a soft body; return a sentence on what it is now, and notes on what was found.

    A large one is prepared when it is pressed first, with its progress shown.

    Raises:
        DimpleError: it cannot be pressed; only its material and settings may have been set.
    """
    from ..core.base import DimpleError
    from . import bridge, planning

    bridge.check(obj)
    bridge.check_writable(obj)
    if sessions.get(obj):
        raise DimpleError(f'"{obj.name}" is being pressed already.')
    if obj.active_material is None:
        with context.temp_override(object=obj, active_object=obj):
            bpy.ops.dimple.apply_preset(preset=preset)
    settle_size(context.scene, obj)
    obj.dimple.enabled = True
    if subdivide and is_coarse(context, obj):
        if is_shared(obj):
            raise DimpleError(
                f'"{obj.name}" has shape keys or shares its mesh, so it is not cut finer: subdivide it yourself.'
            )
        radius = context.scene.dimple.finger_radius_mm / 1e3 / scale_of(context.scene, obj)
        refine(obj, radius)
    if len(obj.data.vertices) > LARGE:
        return f'"{obj.name}" is soft: "{obj.active_material.name}". It is prepared when you press it first.', []
    _, model = bridge.read_body(context, obj)
    planning.proxy_for(context.scene, obj, model)  # so that the first press begins at once
    size, notes = f"{1e3 * model.mesh.size:.3g} mm", [type(note)(f'"{obj.name}": {note}') for note in model.notes]
    said = f'"{obj.name}" is soft: "{obj.active_material.name}", {size} across. Press it with the left mouse button.'
    return said, notes


def convert(context: bpy.types.Context, obj: bpy.types.Object) -> str:
    """Turn a text, a curve or a metaball into the mesh that it shows, flat text with a depth; return a sentence on it.

    Raises:
        DimpleError: it shows no faces; it was left as it was.
    """
    from ..core.base import DimpleError

    given = ""
    if obj.type == "FONT" and not obj.data.extrude and not obj.data.bevel_depth:  # flat characters are all rim
        obj.data.extrude, given = TEXT_DEPTH * obj.data.size, "given a depth and "
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    faces = len(shown.to_mesh().polygons)
    shown.to_mesh_clear()
    if not faces:
        raise DimpleError(
            f'"{obj.name}" has no faces, so there is no surface to press. Give it depth or a bevel first.'
        )
    with context.temp_override(object=obj, active_object=obj, selected_objects=[obj], selected_editable_objects=[obj]):
        bpy.ops.object.convert(target="MESH")
    return f'"{obj.name}" was {given}converted to a mesh.'


def is_coarse(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Tell whether the edges of a mesh are longer than the fingertip is wide, at the size it has or will get."""
    import numpy as np

    lengths, scale = edge_lengths(obj.data), scale_of(context.scene, obj)
    return bool(len(lengths)) and float(np.median(lengths)) * scale > 2 * context.scene.dimple.finger_radius_mm / 1e3


def edge_lengths(mesh: bpy.types.Mesh) -> "np.ndarray":
    """Return the length (e,) of every edge in units of the mesh."""
    import numpy as np

    points, ends = np.empty(3 * len(mesh.vertices), np.float32), np.empty(2 * len(mesh.edges), np.int32)
    mesh.vertices.foreach_get("co", points)
    mesh.edges.foreach_get("vertices", ends)
    pairs = points.reshape(-1, 3)[ends.reshape(-1, 2)]
    return np.linalg.norm(pairs[:, 0] - pairs[:, 1], axis=1)


def refine(obj: bpy.types.Object, radius: float) -> None:
    """Cut the edges of a mesh in even parts until none is too long for a fingertip of a radius [units of the mesh]."""
    import bmesh

    made = bmesh.new()
    try:
        made.from_mesh(obj.data)
        area = sum(face.calc_area() for face in made.faces)
        longest = max(PRESSED * radius, min(SHOWN * radius, (area / LIVE) ** 0.5), (area / MOST_VERTICES) ** 0.5)
        for _ in range(ROUNDS):
            long = [edge for edge in made.edges if edge.calc_length() > EVEN * longest]
            cuts = math.ceil(min((edge.calc_length() for edge in long), default=0.0) / longest) - 1
            if not long or len(made.verts) + cuts * len(long) > MOST_VERTICES:
                break
            bmesh.ops.subdivide_edges(made, edges=long, cuts=cuts, use_grid_fill=True)
        made.to_mesh(obj.data)
    finally:
        made.free()
    obj.data.update()


def choose_tool(context: bpy.types.Context) -> None:
    """Make the poke the tool of the viewport, where there is one."""
    if context.area and context.area.type == "VIEW_3D" and context.window:
        bpy.ops.wm.tool_set_by_id(name=POKE_TOOL)


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_make_soft])
