"""The interface for scripts: a body that can be pressed, released and baked without a window.

    from bl_ext.user_default.dimple import Body

    body = Body.from_object(bpy.data.objects["Suzanne"])
    body.press(depth=0.015)
    print(body.force)
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace

import bpy

from ..core.base import DimpleError
from ..core.constants import MAX_FINGERTIPS
from ..core.message import about
from ..core.poke import Kind, PokeEvent, PokeState, fingers, on_event
from .animate import bake_to_files
from .bridge import final_mesh
from .press import scripted_press, sessions
from .press.object_body import ObjectBody


@dataclass(slots=True, kw_only=True, eq=False)
class Body(ObjectBody):
    """A soft body controlled by a script; its object does not change until it is baked."""

    poke: PokeState | None = None  # the fingertips that `press` has added

    def press(
        self, at: Sequence[float] | None = None, depth: float = 0.015, *, force: float = 0.0,
        direction: Sequence[float] = (0.0, 0.0, 0.0), radius: float = 0.0, seconds: float = 0.25, finger: int = 1,
    ) -> None:
        """Press with a fingertip, which stays in until `release`.

        Args:
            at: place of the press [scene units]; None: the top of the body.
            depth: depth of the press [m].
            force: force of the press [N], instead of a depth; 0: press to the depth.
            direction: in which the fingertip moves; 0: straight into the surface.
            radius: of the fingertip [m]; 0: that of the scene.
            seconds: duration of the press until the depth or force is reached [s].
            finger: 1, 2 or 3.

        Raises:
            DimpleError: no surface lies along the direction, or the depth exceeds the size of the body.
        """
        if not 1 <= finger <= MAX_FINGERTIPS:
            raise DimpleError("There is no fingertip {finger}: choose 1, 2 or 3.", finger=finger)
        state = PokeState(
            radius=radius or bpy.context.scene.dimple.finger_radius_mm / 1e3, depth=depth, force=force,
            by_force=force > 0, press_s=seconds, active=finger - 1,
            tips=self.poke.tips if self.poke else (None,) * MAX_FINGERTIPS,
        )  # fmt: skip
        self.poke = scripted_press.pressed({self.link.uid: self}, state, at, direction)
        self.step(seconds)

    def release(self, *, seconds: float = 0.25) -> None:
        """Move the fingertip of the last press out of the body."""
        if self.poke:
            self.poke = on_event(replace(self.poke, release_s=seconds), PokeEvent(kind=Kind.RELEASE))
        self.step(seconds)

    def step(self, seconds: float) -> None:
        """Simulate a time [s], in frames of the scene.

        Raises:
            DimpleError: the simulation blew up, or the object cannot be followed.
        """
        obj = self.obj
        with ExitStack() as shown:
            if self.link.shaped:
                shown.enter_context(final_mesh.attached(bpy.context, obj, self.link.cuts))
            self.follow(bpy.context, obj)
        for step_s, poke in scripted_press.frames(bpy.context.scene, self.poke, seconds):
            self.poke = poke
            if poke:
                self.session.set_fingers(fingers(poke, self.link.uid))
            if self.session.step(step_s).note:
                raise DimpleError(about(self.name, self.frame.note))

    def bake(self, first: int | None = None, last: int | None = None) -> list[str]:
        """Bake the object over frames of the scene, pressed by keyframed fingertip objects.

        Args:
            first, last: frames; None: those of the scene.

        Returns:
            Sentences for the artist.

        Raises:
            DimpleError: the object cannot be baked; nothing has changed.
        """
        sessions.stop_all()  # a bake starts at rest
        scene, messages = bpy.context.scene, list[str]()
        plan = bake_to_files.BakePlan(
            objects=[self.obj], first=scene.frame_start if first is None else first,
            last=scene.frame_end if last is None else last,
        )  # fmt: skip
        for _ in bake_to_files.bake(bpy.context, plan, messages):
            pass
        return messages
