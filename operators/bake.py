"""Turn a press into animation, and back."""

import bpy
from bpy.props import EnumProperty, IntProperty

from ..core.messages import Message
from . import fingertip_objects, modal_runs, polls, sessions
from .messages import conclude, say
from .names import Op
from .working import READY, Working

TARGETS = (
    ("MESH_CACHE", "Mesh Cache", "A file that the object plays; to undo it, remove the modifier"),
    ("SHAPE_KEYS", "Shape Keys", "Keyframed shape keys, which every exporter understands"),
)


class DIMPLE_OT_bake(Working, bpy.types.Operator):
    """Simulate bodies over a range of frames."""

    bl_idname = Op.BAKE
    bl_label = "Bake"
    bl_description = (
        "Simulate the selected bodies over a range of frames, pressed by the keyframed fingertip objects. "
        "As in a live press, a proxy is simulated where the mesh is too heavy. "
        "Full Mesh in Physics > Dimple bakes every vertex"
    )
    bl_options = {"UNDO"}
    verb, stopped = "Baking", "The bake was cancelled; nothing has changed"
    ready = READY

    target: EnumProperty(name="Target", description="What the bake becomes", items=TARGETS)
    frame_start: IntProperty(name="First Frame", description="By default the scene's first frame", default=1)
    frame_end: IntProperty(name="Last Frame", description="By default the scene's last frame", default=250)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, and no other bake."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode to bake")
        return polls.is_free(cls)

    def _open(self, context: bpy.types.Context) -> modal_runs.ModalRun:
        return modal_runs.open_run(context, "bake", "Baking: Esc cancels", interval=0.01)

    def _begin(self, context: bpy.types.Context):
        """Return the steps of the bake; live sessions end first, for a bake starts at rest."""
        from . import baking, live

        sessions.stop_all()
        given, scene = self.properties.is_property_set, context.scene
        objects = live.candidates(context)
        self._messages: list[str] = []
        if not any(sessions.fingertip_objects(scene)):
            self._messages.append("There is no fingertip, so nothing presses: Fingertips > Add Fingertip adds one.")
        self._count = len(objects)
        plan = baking.BakePlan(
            objects=objects,
            first=self.frame_start if given("frame_start") else scene.frame_start,
            last=self.frame_end if given("frame_end") else scene.frame_end,
            target=self.target,
            step=scene.dimple.shape_key_step,
        )
        return baking.bake(context, plan, self._messages)

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        conclude(self, Message("Baked objects: {count}", count=self._count), self._messages)
        return {"FINISHED"}


class DIMPLE_OT_unbake(bpy.types.Operator):
    """Remove bakes and recordings from the selected objects; their files stay on the disk"""

    bl_idname = Op.UNBAKE
    bl_label = "Remove Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode and a mesh."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode first")
        chosen = (fingertip_objects.body_of(obj, context.scene) for obj in (*context.selected_objects, context.object))
        if not any(obj.type == "MESH" for obj in chosen if obj):
            return polls.refuse(cls, "Select a mesh first")
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Take modifiers and keys off."""
        from ..core.base import DimpleError
        from . import cache_files, live, shape_keys

        removed = 0
        try:
            meshes = [obj for obj in live.candidates(context) if obj.type == "MESH"]
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        for obj in meshes:
            removed += bool(cache_files.detach_cache(obj)) + bool(shape_keys.remove(obj))
        if not removed:
            say(self, {"WARNING"}, "There was no bake on the selected objects")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_bake, DIMPLE_OT_unbake])
