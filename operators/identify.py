"""Find model constants with which the selected body, pressed by the measuring tip, answers as was measured."""

import json
from datetime import date

import bpy
from bpy.props import EnumProperty, FloatProperty

from . import calibration, modal_runs, polls, sessions
from .messages import say
from .names import PLACES, Op
from .working import Working

HOPELESS = 3  # times the just-noticeable difference, at half of the depths: then the estimate is no worse
_NOTHING = "Nothing was written: use a finer mesh, or press elsewhere."


class DIMPLE_OT_identify(Working, bpy.types.Operator):
    """Find model constants with which a virtual press of the active object reproduces its measurement"""

    bl_idname = Op.IDENTIFY
    bl_label = "Identify"
    bl_options = {"UNDO"}
    verb, stopped = "Identifying", "The identification was stopped; the material is as it was"

    place: EnumProperty(name="Press At", description="Where the tip presses", items=PLACES)
    depth_mm: FloatProperty(
        name="Depth (mm)", description="Depth up to which the constants are fitted; 0 is the measured depth",
        default=0.0, min=0.0, soft_max=200.0,
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, a mesh with a material, and nothing else at work."""
        return polls.can_measure(cls, context)

    def _open(self, context: bpy.types.Context) -> modal_runs.ModalRun:
        return modal_runs.open_run(context, "identify", "Identifying: Esc cancels", interval=0.01)

    def _begin(self, context: bpy.types.Context):
        """Return the steps; a body is at rest before it is pressed."""
        from . import indentation

        sessions.stop_all()
        self._bench = indentation.set_up(
            context, context.object, place_of(self, context), self.depth_mm, identify="NO"
        )
        return self._steps_of(self._bench)

    def _steps_of(self, bench):
        from ..core.calibration import cache
        from ..core.calibration.identify import identification
        from .identified import own_folder

        site, given = bench.site, (bench.mesh, bench.material, bench.indenter)
        where = site.point, site.inward, site.under, site.pinned
        folder, name = own_folder("identified"), cache.key(*given, bench.deepest, *where)
        self._found, self._anew = cache.recall(folder, name), None
        if self._found is None:
            self._found = yield from identification(*given, site, bench.deepest)
            self._anew = folder, name

    def _finished(self, context: bpy.types.Context) -> set[str]:
        """Write the constants, and how they were found."""
        import numpy as np

        from ..core.base import DimpleError
        from ..core.calibration import cache
        from ..core.calibration.identify import NOTICEABLE_FORCE
        from . import indentation

        found, bench = self._found, self._bench
        if np.median(found.off) > HOPELESS * max(NOTICEABLE_FORCE):
            raise DimpleError(" ".join(
                [f"No model constants make this body reproduce the measurement. {found.notes[-1]}", _NOTHING]
            ))  # fmt: skip
        settings, constants = indentation.find_material(bench.uid).dimple, found.material.constants
        settings.kappa1, settings.kappa2 = constants.kappa1 / 1e6, constants.kappa2 / 1e6
        settings.d0, settings.membrane_scale = constants.d0 * 1e3, constants.membrane_scale
        record = indentation.described(bench) | {
            "date": date.today().isoformat(), "rms": found.rms,
            "force_off": float(found.off.max()), "deepest": 1e3 * float(found.depths[-1]),
            "volume_change": found.volume_change, "noticeable": NOTICEABLE_FORCE,
            "tension": constants.tension, "pieces": constants.pieces,
            "notes": [*found.notes, *bench.notes],
            "points": calibration.thinned(1e3 * found.depths, found.simulated, calibration.SIMULATED),
        }  # fmt: skip
        settings.identification = json.dumps(record, ensure_ascii=False)
        for note in record["notes"]:
            say(self, {"INFO" if found.worst <= 1 else "WARNING"}, note)
        if self._anew is not None:
            try:
                cache.remember(*self._anew, found)
            except DimpleError as error:
                say(self, {"WARNING"}, (
                    f"The result could not be stored, so it will be computed again next time: {error}"
                ))  # fmt: skip
        return {"FINISHED"}


def place_of(operator: bpy.types.Operator, context: bpy.types.Context) -> str:
    """Return where an operator presses: as its own property says, else as the scene's does."""
    return operator.place if operator.properties.is_property_set("place") else context.scene.dimple.tip_place


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_identify])
