"""The preconditions of operators, with sentences that say what is missing, and the base class of operators."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import bpy

from ...core.errors import DimpleError
from ..reporting import LOG, say
from ..translation import tip_
from . import fingertip_objects, modal_runs, sessions

LARGEST = 1e9  # largest magnitude of a number that an operator accepts
Need = Callable[..., bool]  # a precondition; it takes an operator and a context


class Declared:
    """Base of an operator that declares its preconditions in `needs` and acts in `run(context)`."""

    needs: ClassVar[tuple[Need, ...]] = ()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether all preconditions are met; the first that is not says why."""
        return all(need(cls, context) for need in cls.needs)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Run the operator, report a DimpleError, and log any other exception."""
        try:
            return self.trying(self.run, context) or {"FINISHED"}
        except Exception:
            LOG.exception(self.bl_idname)
            raise

    def trying(self, call: Callable[..., Any], *given: Any) -> Any:
        """Return the result of a call; if it raises a DimpleError, report it and cancel the operator."""
        try:
            return call(*given)
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}


def need(is_met: Callable[[bpy.types.Context], object], sentence: str) -> Need:
    """Return a precondition on the context that shows a sentence if it is not met."""
    return lambda operator, context=None: bool(is_met(context)) or refuse(operator, sentence)


def refuse(operator: type, sentence: str) -> bool:
    """Say why an operator cannot be used now; return False. Blender does not translate such messages: `tip_` does."""
    operator.poll_message_set(tip_, sentence)
    return False


def check_numbers(operator: bpy.types.Operator, *names: str) -> None:
    """Raise a DimpleError if a numeric property of an operator is huge or not a number."""
    for name in names:
        value = getattr(operator, name)
        if not all(abs(each) <= LARGEST for each in ([value] if isinstance(value, float) else value)):
            label = name.replace("_", " ").capitalize()
            raise DimpleError("{label} must be a number from -1e9 to 1e9.", label=label)


in_object_mode = need(lambda context: context.mode == "OBJECT", "Go back to Object Mode first")
needs_mesh = need(lambda context: context.object and context.object.type == "MESH", "Select a mesh first")
is_free = need(lambda _: not modal_runs.at_work(), "A bake or a virtual press is running; Esc cancels it")
can_be_pressed = need(
    lambda context: context.object and context.object.type == "MESH"
    and context.object not in sessions.fingertip_objects(context.scene),
    "Select the mesh to press",
)  # fmt: skip


def is_own(operator: type, context: bpy.types.Context) -> bool:
    """Return whether the active object and its material belong to this file, so that their settings are saved."""
    body = context.object
    if body.override_library:
        return refuse(operator, "Settings of a library override would not be saved: make the object local first")
    if body.library or body.data.library:
        return refuse(operator, "The object is linked from another file: make it local first")
    if body.active_material and body.active_material.library:
        return refuse(operator, "The material is linked from another file: make it local first")
    return True


def has_free_fingertips(operator: type, scene: bpy.types.Scene, count: int) -> bool:
    """Return whether at least `count` fingertips are not in use."""
    if len(fingertip_objects.free(scene)) < count:
        return refuse(operator, "All three fingertips are in use; clear one of their slots first")
    return True
