"""The gizmo of a fingertip object: an arrow to move it along its axis, a ring to move it, a circle for its radius."""

import bpy
from mathutils import Matrix

from ..operators.press.modal_runs import runs
from ..operators.press.sessions import fingertip_objects

COLOR, LIT = (0.2, 0.6, 1.0), (1.0, 1.0, 1.0)
HANDLE = 0.15  # size of the ring, relative to Blender's default gizmo


class DIMPLE_GGT_fingertip(bpy.types.GizmoGroup):
    """Move the active fingertip, and change its radius."""

    bl_idname = "DIMPLE_GGT_fingertip"
    bl_label = "Fingertip"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Show the gizmo on a selected fingertip, unless a poke uses the mouse."""
        tip = context.object
        return bool(
            tip and context.mode == "OBJECT" and tip.select_get() and tip in fingertip_objects(context.scene)
            and not any(run.kind == "poke" for run in runs)
        )  # fmt: skip

    def setup(self, context: bpy.types.Context) -> None:
        """Make the parts; each starts one of Blender's own operators, so undo, typed numbers and snapping work."""
        self._arrow = self._part("GIZMO_GT_arrow_3d", "transform.translate", constraint_axis=(False, False, True),
                                 orient_type="LOCAL")  # fmt: skip
        self._ring = self._part("GIZMO_GT_move_3d", "transform.translate")
        self._ring.draw_options, self._ring.scale_basis = {"ALIGN_VIEW"}, HANDLE
        self._circle = self._part("GIZMO_GT_dial_3d", "transform.resize")
        self._circle.use_draw_scale = False
        self.draw_prepare(context)

    def _part(self, kind: str, verb: str, **settings: object) -> bpy.types.Gizmo:
        part = self.gizmos.new(kind)
        part.color, part.color_highlight, part.alpha, part.alpha_highlight = COLOR, LIT, 0.7, 1.0
        operator = part.target_set_operator(verb)
        for name, value in {**settings, "release_confirm": True}.items():
            setattr(operator, name, value)
        return part

    def draw_prepare(self, context: bpy.types.Context) -> None:
        """Place the parts at the fingertip: the arrow on its outer side, the circle facing the viewer."""
        tip, view = context.object, context.region_data
        if tip is None or view is None:
            return
        place, turn, _ = tip.matrix_world.decompose()
        radius = tip.empty_display_size * tip.matrix_world.median_scale
        self._ring.matrix_basis = Matrix.Translation(place)
        self._arrow.matrix_basis = (
            Matrix.Translation(place) @ turn.to_matrix().to_4x4() @ Matrix.Translation((0, 0, radius))
        )
        facing = view.view_matrix.to_3x3().inverted().to_4x4()
        self._circle.matrix_basis = Matrix.Translation(place) @ facing @ Matrix.Scale(radius, 4)
