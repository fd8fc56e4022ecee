"""Turn a press into animation, and back."""

import bpy

from ...core.message import Message
from ..names import BAKED_PRESS, Op
from ..press import fingertip_objects, polls, sessions
from ..press.progress import READY, FrameRange, Working
from ..reporting import say


class DIMPLE_OT_bake(FrameRange, Working, bpy.types.Operator):
    """Simulate bodies over a range of frames."""

    bl_idname = Op.BAKE
    bl_label = "Bake"
    bl_description = (
        "Turn the keyframed presses on the selected bodies into an animation. A mesh that is too heavy is simulated "
        "by a proxy, as in a live press; Full Mesh in Physics > Dimple bakes every vertex. Bake again after changes "
        "of material or settings"
    )
    bl_options = {"UNDO"}
    verb, stopped = "Baking", "The bake was cancelled; nothing has changed"
    ready = READY

    needs = polls.in_object_mode, polls.is_free

    def _begin(self, context: bpy.types.Context):
        """Return the steps of the bake; live sessions end first, because a bake starts at rest."""
        from ..press import live_step
        from . import bake_to_files

        sessions.stop_all()
        scene = context.scene
        objects = live_step.candidates(context)
        self._messages: list[str] = []
        self._count = len(objects)
        first, last = self._frames(scene)
        plan = bake_to_files.BakePlan(objects=objects, first=first, last=last)
        return bake_to_files.bake(context, plan, self._messages)

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        return self._done(Message("Baked objects: {count}", count=self._count), self._messages)


def _may_play(context: bpy.types.Context) -> bool:
    """Return whether a mesh is selected, or a fingertip that presses one."""
    chosen = (fingertip_objects.body_of(obj, context.scene) for obj in (*context.selected_objects, context.object))
    return any(obj.type == "MESH" for obj in chosen if obj)


class DIMPLE_OT_unbake(polls.Declared, bpy.types.Operator):
    """Remove bakes from the selected objects; their files stay on the disk"""

    bl_idname = Op.UNBAKE
    bl_label = "Remove Bake"
    bl_options = {"REGISTER", "UNDO"}

    needs = polls.in_object_mode, polls.need(_may_play, "Select a mesh first")

    def run(self, context: bpy.types.Context) -> None:
        from ..bridge import press_modifier
        from ..press import live_step

        meshes = [obj for obj in live_step.candidates(context) if obj.type == "MESH"]
        if not sum(press_modifier.remove(obj, BAKED_PRESS) for obj in meshes):
            say(self, {"WARNING"}, "The selected objects have no bake")
