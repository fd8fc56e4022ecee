"""Compare proxies of one object with its own mesh, show what each costs and how far off it is, and take one."""

import json
import math

import bpy
from bpy.props import IntProperty

from . import polls, sessions
from .names import Op
from .working import Working

SIZES = 7  # proxies that are compared
FINEST = 4000  # vertices of the largest one
FEWEST = 100  # vertices of the smallest one
PRESSES = 4  # one more or less says more than the next size of proxy would


class DIMPLE_OT_compare_methods(Working, bpy.types.Operator):
    """Press the active object virtually on proxies of several sizes, and chart their cost against their error"""

    bl_idname = Op.COMPARE_METHODS
    bl_label = "Compare Methods"
    bl_options = {"UNDO"}
    verb, stopped = "Comparing", "The comparison was stopped; nothing has changed"

    presses: IntProperty(
        name="Presses", description="How many places are pressed: more take longer and tell more",
        default=PRESSES, min=1, soft_max=6,
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, a mesh, and nothing else at work."""
        return polls.can_press(cls, context)

    def _open(self, context: bpy.types.Context) -> sessions.ModalRun:
        return sessions.open_run(context, "compare", "Comparing: Esc cancels", interval=0.01)

    def _begin(self, context: bpy.types.Context):
        """Return the steps; a body is at rest before it is pressed."""
        from ..core.reduction.benchmark import choose_presses, compare
        from ..core.reduction.proxy import check, most_of
        from . import bridge

        sessions.stop_all()
        link, model = bridge.read_body(context, context.object)
        check(model)
        self._link, self._found = link, []
        radius = context.scene.dimple.finger_radius_mm / 1e3
        presses = choose_presses(model, radius, self.presses)
        return self._steps_of(compare(model, presses, proxy_sizes(most_of(model))))

    def _steps_of(self, steps):
        for share, found in steps:
            if found:
                self._found.append(found)
            yield min(share, 0.999)

    def _finished(self, context: bpy.types.Context) -> set[str]:
        """Keep what was found with the object, and show it."""
        from . import bridge

        obj = bridge.find(self._link.uid, self._link.name)
        if obj is None:
            return self._failed("The object is gone, so nothing was kept.")
        good = [each for each in self._found if not each.note and math.isfinite(each.cost)]
        obj.dimple.comparison = json.dumps(
            {"holds_for": holds_for(context.scene, obj), "variants": [as_row(each) for each in good]}
        )
        context.window_manager.dimple.show_comparison = True
        for each in self._found:
            if each.note:
                self.report({"INFO"}, f"A proxy of {each.asked} vertices: {each.note}")
        self.report({"INFO"}, f"Compared {len(good)} variants of {obj.name}")
        sessions.redraw()
        return {"FINISHED"}


class DIMPLE_OT_apply_method(bpy.types.Operator):
    """Simulate the active object this way from now on"""

    bl_idname = Op.APPLY_METHOD
    bl_label = "Use This"
    bl_options = {"REGISTER", "UNDO"}

    vertices: IntProperty(name="Vertices", description="Of the stand-in; 0 is the mesh itself", default=0, min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a mesh."""
        return polls.needs_mesh(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set what moves; what runs ends, for it moves something else."""
        sessions.stop(context.object.session_uid)
        settings = context.object.dimple
        settings.moves = "STAND_IN" if self.vertices else "MESH"
        if self.vertices:
            settings.stand_in_vertices = self.vertices
        return {"FINISHED"}


def proxy_sizes(most: int) -> list[int]:
    """Return the numbers of vertices that are compared on a mesh whose proxies have at most so many."""
    most = min(most, FINEST)
    if most < FEWEST:
        return []
    growth = (most / FEWEST) ** (1 / (SIZES - 1))
    return sorted({round(FEWEST * growth**k) for k in range(SIZES)})


def holds_for(scene: bpy.types.Scene, obj: bpy.types.Object) -> str:
    """Return what a comparison depends on, as a text that is another when any of it is.

    Panels ask at each redraw, so a shape that is sculpted or a weight that is painted is not seen.
    """
    materials = [slot.material.dimple.to_params() for slot in obj.material_slots if slot.material]
    sizes = (len(obj.data.vertices), *obj.scale, scene.unit_settings.scale_length, scene.dimple.finger_radius_mm)
    return repr((*sizes, obj.dimple.to_params(), materials))


def as_row(found) -> dict:
    """Return an outcome for the chart: cost [s] a second, error [mm], force error as a share."""
    return {
        "asked": found.asked, "vertices": found.vertices, "steps": found.steps,
        "cost": found.cost, "error": 1e3 * found.error, "force_error": found.force_error,
    }  # fmt: skip


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_compare_methods, DIMPLE_OT_apply_method])
