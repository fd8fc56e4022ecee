"""An object and the session that moves it: what live presses, bakes and scripts have in common."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import bpy

from ...core.errors import DimpleError
from ...core.messages import about

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Self

    import numpy as np

    from ...core.background_work import Parts
    from ...core.session import Session
    from ...core.session.frame import Frame
    from ..bridge.body_model import Settings
    from ..bridge.scene_objects import ObjectLink, Singles


@dataclass(slots=True, kw_only=True, eq=False)
class ObjectBody:
    """An object and the session that moves it; the object itself is only read."""

    link: ObjectLink  # the object at rest
    session: Session  # what moves it
    settings: Settings  # of the panels, as the session has them
    matrix: np.ndarray  # (4, 4) of the object when it was last stepped
    rest: Singles  # (N, 3) its shape at rest then
    triangles: np.ndarray  # (t, 3) of the vertices of the final mesh, outward
    _offsets: tuple[tuple[object, ...], Singles] | None = None  # the last ones, and what they are of

    @classmethod
    def from_object(cls, obj: bpy.types.Object) -> Self:
        """Return the body of a mesh object, with its materials and settings, at rest.

        Raises:
            DimpleError: it cannot be pressed, with the reason and what to do.
        """
        from ...core.background_work import at_once

        return at_once(cls.opening(bpy.context, obj))[0]

    @classmethod
    def opening(cls, context: bpy.types.Context, obj: bpy.types.Object) -> Parts:
        """Read an object, plan how it is simulated and make its session, in parts; change nothing.

        Returns:
            The body, and sentences for the artist.

        Raises:
            DimpleError: it cannot be pressed, with the reason and what to do.
        """
        from ...core.mesh.surface import input_vertices
        from ...core.session import Session
        from ..bridge import scene_objects, timeline
        from ..bridge.body_model import settings_of
        from . import object_plan

        link, model = yield from scene_objects.reading_body(context, obj)
        proxy = yield from object_plan.planning_for(context.scene, obj, model)
        session = yield 0.9, partial(Session, model, proxy=proxy, tick=timeline.tick_s(context.scene))
        body = cls(
            link=link, session=session, settings=settings_of(context.scene, obj), matrix=link.matrix, rest=link.rest,
            triangles=input_vertices(model.mesh)[model.mesh.triangles],
        )  # fmt: skip
        return body, [about(obj.name, note) for note in model.notes]

    @property
    def name(self) -> str:
        """Return the name of the object."""
        return self.link.name

    @property
    def obj(self) -> bpy.types.Object:
        """Return the object.

        Raises:
            DimpleError: it is gone.
        """
        from ..bridge import scene_objects

        obj = scene_objects.find(self.link.uid, self.name)
        if obj is None:
            raise DimpleError('"{name}" is gone.', name=self.name)
        return obj

    @property
    def frame(self) -> Frame:
        """Return the last frame of the session."""
        return self.session.frame

    @property
    def force(self) -> float:
        """Return the force on all fingertips [N]."""
        return float(sum(self.frame.pushes))

    @property
    def depth(self) -> float:
        """Return how deep the deepest fingertip is [m]."""
        return float(max(self.frame.depths, default=0.0))

    def positions(self) -> np.ndarray:
        """Return where the vertices (N, 3) of the final mesh are in the scene [scene units]."""
        return self.session.positions() / self.link.scale

    def offsets(self) -> Singles:
        """Return how far (N, 3) the vertices are from the shape at rest, in the space of the object: the same array as
        long as nothing moves.
        """
        from ..bridge import scene_objects

        now = self.link, self.matrix, self.rest, self.session.positions()  # each is another object where it changes
        if self._offsets is None or any(a is not b for a, b in zip(now, self._offsets[0], strict=True)):
            self._offsets = now, scene_objects.offsets_of(*now)
        return self._offsets[1]

    def to_world(self, point: Sequence[float]) -> tuple[float, float, float]:
        """Return a point of the session [m] in the scene."""
        x, y, z = (float(c) / self.link.scale for c in point)
        return x, y, z

    def follow(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Move the pins to where the object is now, and the shape at rest to where its rig has bent it.

        Raises:
            DimpleError: the object is flat, or its modifiers give other vertices than they did.
        """
        import numpy as np

        from ..bridge import final_mesh, object_link

        now, rest = np.array(obj.matrix_world), final_mesh.rest_now(context, obj, self.link, self.rest)
        if rest is self.rest and np.array_equal(now, self.matrix):
            return
        object_link.check_matrix(self.name, now)
        there = object_link.to_physical(self.link.scale, now, rest)
        self.session.set_pins(there)
        if rest is not self.rest or self.session.model.rigged or final_mesh.is_stretched(now, self.matrix):
            self.session.set_rest(there)
        self.matrix, self.rest = now, rest
