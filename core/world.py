"""Several sessions that meet each other, themselves and colliders: stepped together, so that nothing passes through.

A session alone, with nothing to meet, needs none of this and pays nothing for it.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from . import native
from .apart import pressed_clear, way_out
from .base import DimpleError, Floats
from .crowd import is_spent, ticks_that_fit
from .messages import Message
from .session import Session
from .solver.motion import MAX_STEPS
from .solver.scene import LEAVES_OUT, ColliderMotion, Crossings, SceneFrame, Way
from .solver.scene import Collider as Collider


class Meeting(NamedTuple):
    """What came of contact in a step.

    touching: the most pairs that touched.
    truncated: times that a vertex was held back from passing through something.
    taken: momentum that this took [N s].
    held_back: the farthest that a collider was behind its way [m].
    forces: on each surface, mean over the step (k, 3) [N]: bodies, then colliders; 0 from what sleeps.
    queries: of who is near whom.
    moments: of the forces about the origin (k, 3) [N m].
    """

    touching: int = 0
    truncated: int = 0
    taken: float = 0.0
    held_back: float = 0.0
    forces: Floats = np.zeros((0, 3))
    queries: int = 0
    moments: Floats = np.zeros((0, 3))


class World:
    """Step sessions together.

    notes: for each session, "" or what is left out of its self contact, for the artist.

    Args:
        sessions: of one tick and one precision.
        colliders: where they are now.
        itself: whether each body meets itself too.
        apart: whether each body is moved out of what it intersects at the start; what is pinned stays. Where it passes
            through itself, those faces are left out of self contact.
        names: of the bodies, then of the colliders, for messages.

    Raises:
        DimpleError: something passes through something else, with what and where.
    """

    def __init__(
        self,
        sessions: Sequence[Session],
        colliders: Sequence[Collider] = (),
        *,
        itself: Sequence[bool] | None = None,
        apart: Sequence[bool] | None = None,
        names: Sequence[str] = (),
    ) -> None:
        self.sessions, self.colliders = list(sessions), list(colliders)
        self._itself = list(itself) if itself is not None else [False] * len(self.sessions)
        self._apart = list(apart) if apart is not None else [False] * len(self.sessions)
        self._names = [*names, *(f"{i + 1}" for i in range(len(names), len(self.sessions) + len(self.colliders)))]
        if len({(session.clock.tick, session.backend) for session in self.sessions}) > 1:
            raise DimpleError("Bodies that meet must be stepped by the same backend, with the same tick.")
        self._at = [np.array(collider.positions, np.float64) for collider in self.colliders]
        self._ends: list[Floats | None] = [None] * len(self.colliders)
        self.meeting = Meeting()
        self._make()
        self._move_apart()
        self.check()

    def check(self) -> None:
        """Raise a DimpleError when something passes through something else."""
        found = self._scene.crossings()
        if found.pairs:
            first, second = (self._names[i] for i in found.surfaces)
            where = _where(found)
            if first == second:
                raise DimpleError(
                    '"{first}" passes through itself at ({where}) mm, {pairs} pairs of faces in all. Repair the mesh '
                    "there, switch off Self Contact in Physics > Dimple > Contact, or switch on Move Apart there, "
                    "which leaves these faces out of it.",
                    first=first, where=where, pairs=found.pairs
                )  # fmt: skip
            if min(found.surfaces) >= len(self.sessions):
                raise DimpleError(
                    'What falls must be clear of other colliders: "{first}" and "{second}" intersect at ({where}) '
                    "mm, {pairs} pairs of faces in all. Move them apart.",
                    first=first, second=second, where=where, pairs=found.pairs
                )  # fmt: skip
            raise DimpleError(
                '"{first}" and "{second}" intersect at ({where}) mm, {pairs} pairs of faces in all. Move them apart, '
                "or switch on Move Apart for a body that has room.",
                first=first, second=second, where=where, pairs=found.pairs
            )  # fmt: skip

    def set_colliders(self, ends: Sequence[Floats | None]) -> None:
        """Say where each collider (m, 3) [m] is to be at the end of the next step; None lets it rest.

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        for i, end in enumerate(ends):
            if end is None:
                continue
            if np.shape(end) != self._at[i].T.shape or not np.isfinite(end).all():
                name = self._names[len(self.sessions) + i]
                raise DimpleError(
                    'Collider "{name}" has another number of vertices than at the start, or a coordinate that is '
                    "not a number. Reset, and start again.",
                    name=name,
                )
            self._ends[i] = np.ascontiguousarray(np.asarray(end, np.float64).T)

    def target(self, index: int) -> Floats:
        """Return where a collider (m, 3) [m] is to be at the end of the step that was asked for last."""
        end = self._ends[index]
        return (self._at[index] if end is None else end).T

    def collider(self, index: int) -> Floats:
        """Return where a collider (m, 3) [m] is: behind its way where a body cannot get out of it."""
        return self._scene.collider(index).T

    def step(self, dt: float, *, budget: float | None = None) -> Meeting:
        """Advance all sessions by dt [s] in whole ticks; their frames show it.

        Args:
            budget: wall time [s] that only a first tick may exceed; what is not done lags behind.
        """
        if any(session.body is not body for session, body in zip(self.sessions, self._bodies, strict=True)):
            self._make()
        started, early, parts = time.perf_counter(), False, []
        for session in self.sessions:
            session.begin(dt)
        substeps = max(session.substeps for session in self.sessions)
        most = min([MAX_STEPS // substeps - 1, *(session.most for session in self.sessions)])
        whole, share, spent = min(session.due for session in self.sessions), 0, 0.0
        while share < whole:
            ticks = min(whole - share, most, ticks_that_fit(share, spent, budget))
            parts.append(self._run(ticks, substeps, share, whole))
            share += ticks
            results = [s.take(f) for s, f in zip(self.sessions, parts[-1].frames, strict=True)]
            if not all(results):
                self._place()
                break
            spent = time.perf_counter() - started
            early = share < whole and is_spent(share, spent, budget)
            if early:
                break
        self._arrive(share / whole if early else 1.0)
        for session in self.sessions:
            session.finish(early=early)
        self.meeting = _sum(parts, max(share, 1) * self.sessions[0].clock.tick)
        return self.meeting

    def reset(self) -> None:
        """Put all bodies and colliders back to where they were at the start."""
        for session in self.sessions:
            session.reset()
        self._at = [np.array(collider.positions, np.float64) for collider in self.colliders]
        self._ends, self.meeting = [None] * len(self.colliders), Meeting()
        self._place()
        self._move_apart()

    def _move_apart(self) -> None:
        """Move bodies out of what they intersect, the one that goes least first, where that is wanted."""
        for _ in range(4 * len(self.sessions) + 4):
            found = self._scene.crossings()
            pair = [i for i in found.surfaces if i < len(self.sessions)]
            if not found.pairs or found.surfaces[0] == found.surfaces[1]:
                return
            clear = [(i, self._cleared(i, [other for other in pair if other != i])) for i in pair if self._apart[i]]
            places = [(self._bodies[i], x) for i, x in clear if x is not None]
            if not places:
                return
            body, x = min(places, key=lambda each: float(np.abs(each[1] - each[0].positions()).max()))
            body.set_state(x, body.velocities())

    def _cleared(self, index: int, others: Sequence[int]) -> Floats | None:
        """Return where a body (3, n) [m] is clear of some other bodies and all colliders, None where nowhere."""
        body, bodies = self._bodies[index], [self._bodies[i] for i in others]
        at = [Collider(other.positions(), other.model.mesh.triangles) for other in bodies]
        at += [c._replace(positions=x) for c, x in zip(self.colliders, self._at, strict=True)]
        triangles = body.model.mesh.triangles
        if not body.model.free:
            return pressed_clear(body, body.model.pinned, triangles, at)
        way = way_out(body, body.positions().T, triangles, at)
        return None if way is None else body.positions() + way[:, None]

    def _make(self) -> None:
        """Make what steps, of the bodies that the sessions have now; what slept may rest on something else."""
        for session in self.sessions:
            session.wake()
        self._bodies = [session.body for session in self.sessions]
        now = [collider._replace(positions=at) for collider, at in zip(self.colliders, self._at, strict=True)]
        itself = [int(meets) for meets in self._itself]
        notes = [""] * len(itself)
        for i, body in enumerate(self._bodies):
            if itself[i] and self._apart[i]:
                found = native.Scene([body], (), native.library(), itself=[True]).crossings()
                if found.pairs:
                    itself[i], notes[i] = LEAVES_OUT, _left_out(found)
        offsets = [session.proxy.offset if session.proxy else 0.0 for session in self.sessions]
        self._scene = native.Scene(self._bodies, now, native.library(), itself=itself, offsets=offsets)
        self.notes = notes

    def _place(self) -> None:
        for i, at in enumerate(self._at):
            self._scene.set_collider(i, at)

    def _run(self, ticks: int, substeps: int, done: int, whole: int) -> SceneFrame:
        ways = [self._way(i) for i in range(len(self._at))]
        motions = [session.next_motion(ticks, substeps=substeps) for session in self.sessions]
        return self._scene.step(motions, ways, (done + 1) / whole, (done + ticks) / whole)

    def _way(self, index: int) -> Way:
        """Return the way of a collider in the step."""
        end = self._ends[index]
        return None if end is None else ColliderMotion(self._at[index], end)

    def _arrive(self, share: float) -> None:
        """Note where on their ways the colliders are to be now."""
        for i, end in enumerate(self._ends):
            if end is not None:
                self._at[i] = end if share >= 1 else self._at[i] + share * (end - self._at[i])
                self._ends[i] = None if share >= 1 else end


def drop_proxies(
    sessions: Sequence[Session], colliders: Sequence[Collider], apart: Sequence[bool], names: Sequence[str]
) -> list[str]:
    """Simulate bodies in full whose proxies intersect something, for their meshes may not; return a note for each.

    Those that are to be moved apart keep their proxies.

    Args:
        colliders, apart, names: as for a World.
    """
    notes = [""] * len(sessions)
    while any(session.proxy for session in sessions):
        bodies = [session.body for session in sessions]
        found = native.Scene(bodies, colliders, native.library(), itself=[0] * len(bodies)).crossings()
        pair = [i for i in found.surfaces if i < len(sessions)] if found.pairs else []
        proxied = [i for i in pair if sessions[i].proxy]
        if not proxied or any(apart[i] for i in pair):
            break
        for i in proxied:
            sessions[i].change(sessions[i].model, proxy=None)
            other = names[next(j for j in found.surfaces if j != i)]
            notes[i] = Message(
                'Its proxy would intersect "{other}" at the start, so the full mesh is simulated.', other=other
            )
    return notes


def _where(found: Crossings) -> str:
    return ", ".join(f"{1e3 * c:.1f}" for c in found.place)


def _left_out(found: Crossings) -> str:
    return Message(
        "The mesh passes through itself at ({where}) mm: {pairs} pairs of faces, and those beside them, are left out "
        "of Self Contact.",
        where=_where(found), pairs=found.pairs
    )  # fmt: skip


def _sum(parts: Sequence[SceneFrame], seconds: float) -> Meeting:
    if not parts:
        return Meeting()
    impulses, moments = parts[0].impulses, parts[0].moments
    for part in parts[1:]:
        impulses, moments = impulses + part.impulses, moments + part.moments
    return Meeting(
        max(part.touching for part in parts), sum(part.truncated for part in parts),
        sum(part.taken for part in parts), max(part.held_back for part in parts),
        impulses / seconds, sum(part.queries for part in parts), moments / seconds,
    )  # fmt: skip
