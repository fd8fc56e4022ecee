"""Sessions in contact with each other, themselves and colliders: stepped together, so that nothing passes through.

A session without contact does not use this module and has none of its cost.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from .. import native
from ..base import DimpleError, Floats
from ..constants import MAX_STEPS, SLACK
from ..message import Message, in_a_row
from ..native import motion
from ..native.scene import Collider as Collider
from ..native.scene import ColliderMotion, Crossings, SceneFrame, Way
from ..session import Session, step_all
from .props import prop_of


class Held(NamedTuple):
    """A collider that could not follow its prescribed motion in a step.

    late: its distance behind that motion [m].
    torn: whether it pulled the skin too far, was let go, and is not yet apart from it.
    """

    name: str
    late: float
    torn: bool
    said: Message


class World:
    """Sessions, colliders and props that are stepped together.

    parts: results of the native calls in the last step.
    held: the colliders that could not follow their prescribed motion in the last step.
    notes: for each session, what is left out of its self contact, for the artist, or "".
    props: the colliders that fall, by their index.
    gravity: acceleration of props (3,) [m/s2]; may be changed between steps, as may
    ground: height [m] of the plane that props land on, or None; a prop that starts below it sinks no further.

    Args:
        sessions: all with the same tick and backend.
        colliders: at their current positions.
        masses: masses of the colliders [kg], None for one whose motion is prescribed. By default no collider falls.
        itself: whether each body has self contact. Faces that pass through each other at the start are left out of it.
        names: names of the bodies, then of the colliders, for messages.

    Raises:
        DimpleError: ticks or backends differ, a prop has no mass or faces, or surfaces intersect (which and where).
    """

    def __init__(
        self,
        sessions: Sequence[Session],
        colliders: Sequence[Collider] = (),
        *,
        masses: Sequence[float | None] = (),
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        ground: float | None = None,
        itself: Sequence[bool] | None = None,
        names: Sequence[str] = (),
    ) -> None:
        self.sessions, self.colliders = list(sessions), list(colliders)
        self.gravity, self.ground = np.array(gravity, np.float64), ground
        self.props = {i: prop_of(colliders[i], mass, sessions) for i, mass in enumerate(masses) if mass is not None}
        for i, prop in self.props.items():
            self.colliders[i] = colliders[i]._replace(positions=prop.positions(), falling=prop.falling)
        self._itself = list(itself) if itself is not None else [False] * len(self.sessions)
        self._names = [*names, *(f"{i + 1}" for i in range(len(names), len(self.sessions) + len(self.colliders)))]
        if len({(session.clock.tick, session.backend) for session in self.sessions}) > 1:
            raise DimpleError("Bodies that collide must use the same backend and the same tick.")
        self._at = [np.array(collider.positions, np.float64) for collider in self.colliders]
        self._ends: list[Floats | None] = [None] * len(self.colliders)
        self.parts, self.held = list[SceneFrame](), list[Held]()
        self._make()
        self.check()

    def check(self) -> None:
        """Raise a DimpleError if two surfaces intersect."""
        found = self._scene.crossings()
        if found.pairs:
            first, second = (self._names[i] for i in found.surfaces)
            where = _where(found.place)
            if min(found.surfaces) >= len(self.sessions):
                raise DimpleError(
                    'A falling object must not touch other colliders at the start: "{first}" and "{second}" '
                    "intersect at ({where}) mm ({pairs} pairs of faces in all). Move them apart.",
                    first=first, second=second, where=where, pairs=found.pairs
                )  # fmt: skip
            raise DimpleError(
                '"{first}" and "{second}" intersect at ({where}) mm ({pairs} pairs of faces in all). Move them apart.',
                first=first, second=second, where=where, pairs=found.pairs
            )  # fmt: skip

    def set_colliders(self, ends: Sequence[Floats | None]) -> None:
        """Set the position (m, 3) [m] of each collider at the end of the next step; None leaves it unchanged.

        Raises:
            DimpleError: the number of vertices has changed, or a position is not a number.
        """
        for i, end in enumerate(ends):
            if end is None:
                continue
            if np.shape(end) != self._at[i].T.shape or not np.isfinite(end).all():
                name = self._names[len(self.sessions) + i]
                raise DimpleError(
                    'The number of vertices of collider "{name}" has changed since the start, or a coordinate is not '
                    "a number. Reset, and start again.",
                    name=name,
                )
            self._ends[i] = np.ascontiguousarray(np.asarray(end, np.float64).T)

    def target(self, index: int) -> Floats:
        """Return the last position (m, 3) [m] that was set for a collider as the end of a step."""
        end = self._ends[index]
        return (self._at[index] if end is None else end).T

    def collider(self, index: int) -> Floats:
        """Return the position (m, 3) [m] of a collider: behind its prescribed motion if a body blocks it."""
        return self._scene.collider(index).T

    def step(self, dt: float, *, budget: float | None = None) -> None:
        """Advance all sessions by dt [s] in whole ticks; their frames hold the results.

        Args:
            budget: wall time [s] that only the first tick may exceed; simulated time then lags behind.
        """
        if any(session.body is not body for session, body in zip(self.sessions, self._bodies, strict=True)):
            self._make()
        self.parts = []
        step_all(self.sessions, [dt] * len(self.sessions), budget=budget, together=self._run)
        done, left = sum(part.ticks for part in self.parts), min(session.due for session in self.sessions)
        self._arrive(done / (done + left) if left else 1.0)
        self.held = self._find_held() if self.parts else self.held
        note = in_a_row([held.said for held in self.held])
        for session in self.sessions:
            session.held_note = note

    def _find_held(self) -> list[Held]:
        """Return the colliders that are visibly behind their prescribed motion, or were let go."""
        found, seen = [], SLACK * min(session.body.model.mesh.size for session in self.sessions)
        for i, name in enumerate(self._names):
            torn, late = any(part.torn[i] for part in self.parts), float(self.parts[-1].late[i])
            if not torn and late <= seen:
                continue
            where = _where(self.parts[-1].places[i])
            if torn:
                said = Message(
                    'Collider "{name}" pulled the skin at ({where}) mm farther than the size of the body, so it was '
                    "let go. It passes through the body until they are apart.",
                    name=name, where=where
                )  # fmt: skip
            else:
                said = Message(
                    'Collider "{name}" is held back by {late} mm: the skin at ({where}) mm has no room to move.',
                    name=name, late=f"{1e3 * late:.1f}", where=where
                )  # fmt: skip
            found.append(Held(name, late, torn, said))
        return found

    def _make(self) -> None:
        """Make the scene from the current bodies of the sessions, and wake them: their supports may have changed."""
        for session in self.sessions:
            session.wake()
        self._bodies = [session.body for session in self.sessions]
        now = [collider._replace(positions=at) for collider, at in zip(self.colliders, self._at, strict=True)]
        offsets = [session.proxy.offset if session.proxy else 0.0 for session in self.sessions]
        self._scene = native.Scene(self._bodies, now, native.library(), itself=self._itself, offsets=offsets)
        self.notes = [_left_out(found) if found.pairs else "" for found in self._scene.left_out]

    def _run(self, sessions: Sequence[Session], at_once: int) -> tuple[Sequence[motion.Frame], int]:
        """Run all sessions for some ticks of the current step; return their frames and the number of ticks."""
        substeps = max(session.substeps for session in sessions)
        done, left = sum(part.ticks for part in self.parts), min(session.due for session in sessions)
        ticks = min([left, at_once, MAX_STEPS // substeps - 1, *(session.most for session in sessions)])
        ways = [self._way(i) for i in range(len(self._at))]
        motions = [session.next_motion(ticks, substeps=substeps) for session in sessions]
        whole = done + left
        part = self._scene.step(motions, ways, (done + 1) / whole, (done + ticks) / whole)
        self.parts.append(part)
        ends = np.cumsum([len(session.body.model.mass) for session in sessions])
        for session, frame, given in zip(sessions, part.frames, np.split(part.given, ends), strict=False):
            if frame.moved:
                session.rest_shape.meet(given, frame.ticks * session.clock.tick)
        if not all(frame.finite for frame in part.frames):
            for i, at in enumerate(self._at):
                self._scene.set_collider(i, at)
        for i, prop in self.props.items():
            self._at[i] = prop.positions()
        return part.frames, ticks

    def _way(self, index: int) -> Way:
        """Return the motion of a collider in the step."""
        if index in self.props:
            return self.props[index].way(self.gravity, self.ground)
        end = self._ends[index]
        return None if end is None else ColliderMotion(self._at[index], end)

    def _arrive(self, share: float) -> None:
        """Move the prescribed positions of the colliders on by the fraction of the step that was done."""
        for i, end in enumerate(self._ends):
            if end is not None:
                self._at[i] = end if share >= 1 else self._at[i] + share * (end - self._at[i])
                self._ends[i] = None if share >= 1 else end


def drop_proxies(
    sessions: Sequence[Session], colliders: Sequence[Collider], names: Sequence[str]
) -> list[str]:
    """Use the full mesh of each body whose proxy intersects something, as the mesh may not; return a note for each.

    Args:
        colliders, names: as for a World.
    """
    notes = [""] * len(sessions)
    while any(session.proxy for session in sessions):
        bodies = [session.body for session in sessions]
        found = native.Scene(bodies, colliders, native.library(), itself=[False] * len(bodies)).crossings()
        pair = [i for i in found.surfaces if i < len(sessions)] if found.pairs else []
        proxied = [i for i in pair if sessions[i].proxy]
        if not proxied:
            break
        for i in proxied:
            sessions[i].change(sessions[i].model, proxy=None)
            other = names[next(j for j in found.surfaces if j != i)]
            notes[i] = Message(
                'Its proxy would intersect "{other}" at the start, so the full mesh is simulated.', other=other
            )
    return notes


def _where(place: Iterable[float]) -> str:
    return ", ".join(f"{1e3 * c:.1f}" for c in place)


def _left_out(found: Crossings) -> str:
    return Message(
        "The mesh passes through itself at ({where}) mm: {pairs} pairs of faces and their neighbors are left out of "
        "Self Contact.",
        where=_where(found.place), pairs=found.pairs
    )  # fmt: skip
