"""Make Soft: everything that a bare mesh needs to be pressed, in one click; what changes the mesh itself is asked."""

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, StringProperty

from . import polls, sessions
from .messages import report, say
from .names import POKE_TOOL, Op
from .sizing import scale_of, settle_size

if TYPE_CHECKING:
    import numpy as np

# edges [fingertip radii]: up to the first a dent is the fingertip's own; up to the second a press by force is as deep
# on a vertex as beside it, within 5 %, so it is cut that fine where so many vertices do
SHOWN, PRESSED, LIVE = 1.1, 0.55, 8_000
PRESSABLE = {"MESH", "CURVE", "SURFACE", "META", "FONT"}  # what is no mesh is converted to one
MOST_VERTICES = 40_000  # of a mesh that is subdivided
ROUNDS, EVEN = 7, 1.001  # of cutting edges; by less than that all are as long
TEXT_DEPTH = 0.15  # of the size of its characters: half of the depth that flat text gets


class DIMPLE_OT_make_soft(bpy.types.Operator):
    """Make the selected meshes soft bodies, ready to be pressed: material, real size, pins, and what is simulated"""

    bl_idname = Op.MAKE_SOFT
    bl_label = "Make Soft"
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(
        name="Preset", description="Measured object whose constants a mesh without a material gets",
        default="object_2_vinyl_air",
    )  # fmt: skip
    subdivide: BoolProperty(
        name="Subdivide", description="Cut edges that are longer than the fingertip is wide, which changes the mesh"
    )

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

        self.subdivide = any(is_coarse(context, obj) for obj in live.candidates(context) if obj.type == "MESH")
        if self.subdivide:
            return context.window_manager.invoke_props_dialog(self, width=380)
        return self.execute(context)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw what is offered, and why."""
        column = self.layout.column()
        column.label(text="The edges are longer than the fingertip is wide.", icon="INFO")
        column.label(text="It would show no dent. The mesh can be cut finer, in even parts.", icon="BLANK1")
        column.prop(self, "subdivide")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set up every selected mesh; one that cannot be pressed is said and left as it was."""
        from ..core.base import DimpleError
        from . import live

        done, wrong = [], []
        try:
            bodies = [obj for obj in live.candidates(context) if obj.type in PRESSABLE]
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        for obj in bodies:
            try:
                if obj.type != "MESH":
                    done.append(convert(context, obj))
                done.append(make_soft(context, obj, self.preset, subdivide=self.subdivide))
            except DimpleError as error:
                wrong.append(str(error))
        if not done:
            say(self, {"ERROR"}, " ".join(wrong))
            return {"CANCELLED"}
        report(self, wrong)
        choose_tool(context)
        say(self, {"INFO"}, " ".join(done))
        return {"FINISHED"}


def make_soft(context: bpy.types.Context, obj: bpy.types.Object, preset: str, *, subdivide: bool) -> str:
    """Make a mesh a soft body; return a sentence on what it is now.

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
        if obj.data.shape_keys or obj.data.users > 1:
            raise DimpleError(
                f'"{obj.name}" has shape keys or shares its mesh, so it is not cut finer: subdivide it yourself.'
            )
        radius = context.scene.dimple.finger_radius_mm / 1e3 / scale_of(context.scene, obj)
        refine(obj, radius)
    _, model = bridge.read_body(context, obj)
    planning.proxy_for(context.scene, obj, model)  # so that the first press begins at once
    size = f"{1e3 * model.mesh.size:.3g} mm"
    return f'"{obj.name}" is soft: "{obj.active_material.name}", {size} across. Press it with the left mouse button.'


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
