"""Turn a press into animation, and back."""

import time

import bpy
from bpy.props import EnumProperty, IntProperty

from . import sessions
from .names import Op

SLICE_S = 0.1  # a bake works so long between two looks at the keyboard

TARGETS = (
    ("MESH_CACHE", "Mesh Cache", "A file the object plays; taking the modifier off is enough to undo it"),
    ("SHAPE_KEYS", "Shape Keys", "Keyframed shape keys, which every exporter understands"),
)


class DIMPLE_OT_bake(bpy.types.Operator):
    """Simulate the selected bodies over a range of frames, pressed by the keyframed fingertip objects"""

    bl_idname = Op.BAKE
    bl_label = "Bake"
    bl_options = {"UNDO"}

    target: EnumProperty(name="Target", description="What the bake becomes", items=TARGETS)
    frame_start: IntProperty(name="First Frame", description="By default the scene's first frame", default=1)
    frame_end: IntProperty(name="Last Frame", description="By default the scene's last frame", default=250)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, and no other bake."""
        if context.mode != "OBJECT":
            cls.poll_message_set("Go back to Object Mode to bake")
            return False
        if any(run.kind == "bake" for run in sessions.runs):
            cls.poll_message_set("A bake is running; Esc cancels it")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Bake in one go."""
        from ..core.base import DimpleError

        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            for share in self._begin(context):
                manager.progress_update(share)
        except DimpleError as error:
            return self._failed(str(error))
        finally:
            manager.progress_end()
        return self._finished()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Bake with a progress bar, between Blender's own events."""
        from ..core.base import DimpleError

        try:
            self._steps = self._begin(context)
        except DimpleError as error:
            return self._failed(str(error))
        self._run = sessions.open_run(context, "bake", "Baking: Esc cancels", interval=0.01)
        self._run.leave = self._leave
        self._began = time.perf_counter()
        context.window_manager.modal_handler_add(self)
        context.window_manager.progress_begin(0, 1)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Bake a little; nothing else may change the scene meanwhile."""
        from ..core.base import DimpleError

        if self._run.closed:
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            sessions.close_run(self._run)
            self.report({"INFO"}, "The bake was cancelled; nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            with sessions.ending_on_error():
                share = self._work()
        except DimpleError as error:
            return self._failed(str(error))
        if share < 1:
            self._show(context, share)
            return {"RUNNING_MODAL"}
        sessions.close_run(self._run)
        return self._finished()

    def cancel(self, _context: bpy.types.Context) -> None:
        """Leave when Blender ends the operator: the window closes, another file is loaded."""
        sessions.close_run(self._run)

    def _work(self) -> float:
        """Bake for a moment; return the share that is done, 1 when all is."""
        until = time.perf_counter() + SLICE_S
        while (share := next(self._steps, 1.0)) < 1 and time.perf_counter() < until:
            pass
        return share

    def _show(self, context: bpy.types.Context, share: float) -> None:
        left = (time.perf_counter() - self._began) * (1 / share - 1)
        context.window_manager.progress_update(share)
        context.workspace.status_text_set(f"Baking {share:.0%}, {left:.0f} s left | Esc: cancel")

    def _begin(self, context: bpy.types.Context):
        """Return the steps of the bake; live sessions end first, for a bake starts at rest."""
        from . import baking, live

        sessions.stop_all()
        given, scene = self.properties.is_property_set, context.scene
        objects = live.candidates(context)
        self._said: list[str] = []
        self._what = f"{len(objects)} object{'s' if len(objects) > 1 else ''}"
        plan = baking.Plan(
            objects=objects,
            first=self.frame_start if given("frame_start") else scene.frame_start,
            last=self.frame_end if given("frame_end") else scene.frame_end,
            target=self.target,
            step=scene.dimple.shape_key_step,
        )
        return baking.bake(context, plan, self._said)

    def _leave(self) -> None:
        """Close the steps: an unfinished bake takes its files away."""
        self._steps.close()
        bpy.context.window_manager.progress_end()

    def _finished(self) -> set[str]:
        for sentence in self._said:
            self.report({"WARNING"}, sentence)
        self.report({"INFO"}, f"Baked {self._what}")
        return {"FINISHED"}

    def _failed(self, why: str) -> set[str]:
        self.report({"ERROR"}, why)
        return {"CANCELLED"}


class DIMPLE_OT_unbake(bpy.types.Operator):
    """Take bakes and recordings off the selected objects; their files stay on the disk"""

    bl_idname = Op.UNBAKE
    bl_label = "Remove Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode and a mesh."""
        if context.mode != "OBJECT":
            cls.poll_message_set("Go back to Object Mode first")
            return False
        if not any(obj.type == "MESH" for obj in (*context.selected_objects, context.object) if obj):
            cls.poll_message_set("Select a mesh first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Take modifiers and keys off."""
        from ..core.base import DimpleError
        from . import live, output, shape_keys

        removed = 0
        try:
            meshes = [obj for obj in live.candidates(context) if obj.type == "MESH"]
        except DimpleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for obj in meshes:
            removed += bool(output.detach_cache(obj)) + bool(shape_keys.remove(obj))
        if not removed:
            self.report({"WARNING"}, "There was no bake on the selected objects")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_bake, DIMPLE_OT_unbake])
