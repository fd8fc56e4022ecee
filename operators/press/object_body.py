"""An object and the session that simulates it: the common base of live presses, bakes and scripts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import bpy

from ...core.errors import DimpleError
from ...core.message import about

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Self

    import numpy as np

    from ...core.background_work import Parts
    from ...core.session import Session
    from ...core.session.frame import Frame
    from ..bridge.body_model import Settings
    from ..bridge.object_link import ObjectLink, Singles


@dataclass(slots=True, kw_only=True, eq=False)
class ObjectBody:
    """An object and the session that simulates it; the object itself is only read."""

    link: ObjectLink  # the object at rest
    session: Session  # simulates it
    settings: Settings  # the settings of the panels that the session uses
    matrix: np.ndarray  # (4, 4) matrix of the object when the pins were last moved
    rest: Singles  # (N, 3) shape at rest at that time
    triangles: np.ndarray  # (t, 3) vertices of the final mesh, facing outward
    _offsets: tuple[tuple[object, ...], Singles] | None = None  # the last offsets, preceded by their inputs

    @classmethod
    def from_object(cls, obj: bpy.types.Object) -> Self:
        """Return the body of a mesh object, with its materials and settings, at rest.

        Raises:
            DimpleError: the object cannot be pressed, with the reason and what to do.
        """
        from ...core.background_work import at_once

        return at_once(cls.opening(bpy.context, obj))[0]

    @classmethod
    def opening(cls, context: bpy.types.Context, obj: bpy.types.Object) -> Parts:
        """Read an object, choose between mesh and proxy and make its session, in parts, without changing the object.

        Returns:
            The body, and sentences for the artist.

        Raises:
            DimpleError: the object cannot be pressed, with the reason and what to do.
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
            DimpleError: the object is gone.
        """
        from ..bridge import object_link

        obj = object_link.find(self.link.uid, self.name)
        if obj is None:
            raise DimpleError('"{name}" is gone.', name=self.name)
        return obj

    @property
    def frame(self) -> Frame:
        """Return the last frame of the session."""
        return self.session.frame

    @property
    def force(self) -> float:
        """Return the sum of the normal forces on all fingertips [N]."""
        return float(sum(self.frame.pushes))

    @property
    def depth(self) -> float:
        """Return the depth of the deepest fingertip [m]."""
        return float(max(self.frame.depths, default=0.0))

    def positions(self) -> np.ndarray:
        """Return the positions (N, 3) of the vertices of the final mesh in the scene [scene units]."""
        return self.session.positions() / self.link.scale

    def offsets(self) -> Singles:
        """Return the offsets (N, 3) of the vertices from the shape at rest in object space; the same array object is
        returned as long as nothing moves.
        """
        from ..bridge import object_link

        now = self.link, self.matrix, self.rest, self.session.positions()  # a change makes a new object
        if self._offsets is None or any(a is not b for a, b in zip(now, self._offsets[0], strict=True)):
            self._offsets = now, object_link.offsets_of(*now)
        return self._offsets[1]

    def to_world(self, point: Sequence[float]) -> tuple[float, float, float]:
        """Return the location in the scene [scene units] of a point of the session [m]."""
        x, y, z = (float(c) / self.link.scale for c in point)
        return x, y, z

    def follow(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Move the pins along with the object, and bend the shape at rest as its rig does.

        Raises:
            DimpleError: the object is scaled flat, or its modifiers have changed its vertices.
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
