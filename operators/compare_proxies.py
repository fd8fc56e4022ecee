"""Compare proxies of one object with its full mesh, show cost and errors of each, and use one of them."""

import json
import math

import bpy
from bpy.props import IntProperty

from . import modal_runs, polls, sessions
from .messages import say
from .names import Op
from .working import Working

SIZES = 7  # proxies that are compared
FINEST = 4000  # vertices of the largest one
FEWEST = 100  # vertices of the smallest one
PRESSES = 4  # the error scatters more from press to press than from one size of proxy to the next


class DIMPLE_OT_compare_proxies(Working, bpy.types.Operator):
    """Press proxies of the active object virtually, of several sizes, and chart their cost against their error"""

    bl_idname = Op.COMPARE_PROXIES
    bl_label = "Compare Proxies"
    bl_options = {"UNDO"}
    verb, stopped = "Comparing", "The comparison was stopped; nothing has changed"

    presses: IntProperty(
        name="Presses", description="Number of places that are pressed; more take longer and are more reliable",
        default=PRESSES, min=1, soft_max=6,
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, a mesh, and no other task."""
        return polls.can_press(cls, context)

    def _open(self, context: bpy.types.Context) -> modal_runs.ModalRun:
        return modal_runs.open_run(context, "compare", "Comparing: Esc cancels", interval=0.01)

    def _begin(self, context: bpy.types.Context):
        """Return the steps; live sessions end first, for a body is pressed from rest."""
        from ..core.reduction.benchmark import choose_presses, compare_proxies
        from ..core.reduction.proxy import check, most_of
        from . import bridge

        sessions.stop_all()
        link, model = bridge.read_body(context, context.object)
        check(model)
        self._link, self._found = link, []
        radius = context.scene.dimple.finger_radius_mm / 1e3
        presses = choose_presses(model, radius, self.presses)
        return self._steps_of(compare_proxies(model, presses, proxy_sizes(most_of(model))))

    def _steps_of(self, steps):
        for share, found in steps:
            if found:
                self._found.append(found)
            yield min(share, 0.999)

    def _finished(self, context: bpy.types.Context) -> set[str]:
        """Keep the outcomes with the object, and show them."""
        from . import bridge

        obj = bridge.find(self._link.uid, self._link.name)
        if obj is None:
            return self._failed("The object is gone, so nothing was kept.")
        good = [each for each in self._found if not each.note and math.isfinite(each.cost)]
        obj.dimple.comparison = json.dumps(
            {"depends_on": depends_on(context.scene, obj), "variants": [as_row(each) for each in good]}
        )
        context.window_manager.dimple.show_comparison = True
        for each in self._found:
            if each.note:
                say(self, {"INFO"}, f"A proxy of {each.asked} vertices: {each.note}")
        say(self, {"INFO"}, f"Compared {len(good)} variants of {obj.name}")
        modal_runs.redraw()
        return {"FINISHED"}


class DIMPLE_OT_apply_proxy(bpy.types.Operator):
    """Simulate the active object with this proxy from now on"""

    bl_idname = Op.APPLY_PROXY
    bl_label = "Use This"
    bl_options = {"REGISTER", "UNDO"}

    vertices: IntProperty(name="Vertices", description="Of the proxy; 0 is the full mesh", default=0, min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a mesh."""
        return polls.needs_mesh(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set what is simulated; a running session ends, for it simulates something else."""
        sessions.stop(context.object.session_uid)
        settings = context.object.dimple
        settings.simulated = "PROXY" if self.vertices else "MESH"
        if self.vertices:
            settings.proxy_vertices = self.vertices
        return {"FINISHED"}


def proxy_sizes(most: int) -> list[int]:
    """Return the numbers of vertices to compare, on a mesh whose proxies have at most `most`."""
    most = min(most, FINEST)
    if most < FEWEST:
        return []
    growth = (most / FEWEST) ** (1 / (SIZES - 1))
    return sorted({round(FEWEST * growth**k) for k in range(SIZES)})


def depends_on(scene: bpy.types.Scene, obj: bpy.types.Object) -> str:
    """Return a text of everything that a comparison depends on: when it differs, the comparison is out of date.

    Panels ask at each redraw, so only settings count: a sculpted shape or a painted weight is not noticed.
    """
    materials = [slot.material.dimple.to_params() for slot in obj.material_slots if slot.material]
    sizes = (len(obj.data.vertices), *obj.scale, scene.unit_settings.scale_length, scene.dimple.finger_radius_mm)
    return repr((*sizes, obj.dimple.to_params(), materials))


def as_row(outcome) -> dict:
    """Return an outcome as it is kept: cost [s] per second, error [mm], error of the force as a share."""
    return {
        "asked": outcome.asked, "vertices": outcome.vertices, "steps": outcome.steps,
        "cost": outcome.cost, "error": 1e3 * outcome.error, "force_error": outcome.force_error,
    }  # fmt: skip


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_compare_proxies, DIMPLE_OT_apply_proxy])
