"""The numpy twin of scenes: bodies and colliders stepped together, so that nothing passes through anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.base import Bools, Floats, Ints
from core.native.motion import Motion
from core.native.scene import Collider, ColliderMotion, Crossings, SceneFrame, Way

from . import touching
from .bounds import Bounds, beyond, bounds_of, is_allowed, left_of, moved, renewed, settle, way_of
from .constants import BOUND, LEAST_WAY, OFFSET, PUSH_TIME, QUERY_REACH, ROUNDING, STALE, TOO_NEAR
from .crossing import crossing_vertices, find_crossings
from .islands import let_sleep, woken
from .proximity import Pairs, find_pairs, join_surfaces, touching_distance
from .rolling import Turning, resist
from .twin import Call, Twin
from .twin_props import Props, leave


@dataclass(frozen=True, slots=True)
class Run:
    """The pairs of two surfaces, found by a search of some reach; used: their relative displacement since then [m]."""

    surfaces: tuple[int, int]
    pairs: Pairs
    reach: float
    used: float


class TwinScene:
    """Bodies and colliders that numpy steps; what it does is said in `native.Scene`.

    A vertex that is beyond several planes is put onto them in another order than there, so that it ends elsewhere
    within its bounds: from the first such tick on the two differ visibly. No collider is let go of that pulls skin too
    far.
    """

    def __init__(
        self,
        bodies: Sequence[Twin],
        colliders: Sequence[Collider],
        *,
        itself: Sequence[bool],
        offsets: Sequence[float] = (),
    ) -> None:
        self._bodies, self._itself = list(bodies), list(itself)
        self._here = [np.array(collider.positions, np.float64) for collider in colliders]
        rests = [body.model.mesh.rest_positions for body in bodies] + [x.T for x in self._here]
        faces = [body.model.mesh.triangles for body in bodies] + [collider.triangles for collider in colliders]
        s = self._surfaces = join_surfaces(rests, faces)
        starts = np.cumsum([0, *map(len, rests)])
        self._part = [slice(a, b) for a, b in zip(starts[:-1], starts[1:], strict=True)]
        self._frictions = [np.full(x.shape[1], c.friction) for x, c in zip(self._here, colliders, strict=True)]
        self._edge, held = s.edge[: len(bodies)].min(), np.array(offsets or [0.0] * len(bodies))
        held = np.where(held > 0, held, OFFSET * s.edge[: len(bodies)])
        self._offsets = np.concatenate([held, np.full(len(colliders), held.min())])
        largest = np.sort(self._offsets)[::-1]
        self._props = Props(len(bodies), colliders)
        skins = np.sort(self._props.skins)[::-1]
        own = float(self._offsets[: len(bodies)].max())
        self._touch = max(2 * own, float(largest[:2].sum()), float(skins[:2].sum()))
        self._free = np.array([prop is not None for prop in self._props.of]) | (np.arange(len(rests)) < len(bodies))
        self._rates = [np.zeros_like(x) for x in self._here]
        sizes = [body.model.mesh.size for body in bodies]
        sizes += [2 * prop.radius if prop else 0.0 for prop in self._props.of[len(bodies) :]]
        self._sizes = TOO_NEAR * np.array(sizes)
        self._turning: list[Turning | None] = [b.turning if b.model.free else None for b in bodies]
        self._turning += [None] * len(colliders)
        self._share, self._late = np.ones(len(self._part)), np.zeros(len(self._part))
        self._ends = [x.copy() for x in self._here]  # where colliders were to be at the end of the last tick
        self._due, self._wakes, self._approach = True, True, 0.0
        self._runs: list[Run] = []
        self._placed: set[int] = set()  # surfaces that were put elsewhere since the last query
        self._looks, self._looked, self._near = True, self._positions(), np.zeros(0, np.int64)
        self._sum = np.zeros((0, 3))  # impulses of the meetings since they were listed [N s]
        self._known = [(body.model, body.positions()) for body in bodies]
        self._left_out = np.zeros(len(s.of_vertex), bool)  # of self contact
        itself_alone = [[k == i and meets for k, meets in enumerate(itself)] for i in range(len(bodies))]
        none, nothing = np.zeros_like(self._free), self._left_out
        self.left_out = [find_crossings(s, self._positions(), none, each, nothing) for each in itself_alone]
        for i in np.flatnonzero(self._itself).tolist():
            self._left_out[crossing_vertices(s, self._positions(), i)] = True

    def crossings(self) -> Crossings:
        """Return what passes through each other now."""
        self._due, self._runs = True, []
        return find_crossings(self._surfaces, self._positions(), self._free, self._itself, self._left_out)

    def set_collider(self, index: int, positions: Floats) -> None:
        """Put a collider at positions (3, m) [m] at once."""
        self._here[index], self._due = np.array(positions, np.float64), True
        self._placed.add(len(self._bodies) + index)
        self._rates[index][:] = 0
        self._ends[index] = self._here[index].copy()
        self._props.wake(len(self._bodies) + index)

    def collider(self, index: int) -> Floats:
        """Return where a collider is (3, m) [m]."""
        return self._here[index].copy()

    def step(
        self, motions: Sequence[Motion], ways: Sequence[Way], first: float, last: float
    ) -> SceneFrame:
        """Run the ticks of motions, one for each body."""
        self._tick, self._dt = motions[0].tick, motions[0].tick / motions[0].substeps
        for i, (body, (model, x), turning) in enumerate(zip(self._bodies, self._known, self._turning, strict=False)):
            changed = body.model is not model or not np.array_equal(body.state.positions, x)
            self._due |= changed
            if changed:
                self._placed.add(i)
            if changed and turning:
                turning.kept, turning.moment = np.zeros(3), np.zeros(3)
        self._queries = self._most_touching = self._truncated = 0
        self._taken = 0.0
        self._impulses = np.zeros((len(self._part), 6))
        self._given = np.zeros((len(self._surfaces.of_vertex), 3))
        if self._props.take(ways, self._here, self._rates):
            self._due, self._runs = True, []
        calls = [body.begin(motion) for body, motion in zip(self._bodies, motions, strict=True)]
        for body in self._bodies:
            body.meets = True
        count, done = motions[0].ticks, 0
        while done < count and all(call.finite for call in calls):
            share = first + (done / (count - 1) * (last - first) if count > 1 else 0.0)
            self._run_tick(calls, ways, share)
            done += 1
        self._props.leave()
        if len(self._sum):
            self._sum_meetings()
        self._known = [(body.model, body.positions()) for body in self._bodies]
        frames = tuple(body.end(call) for body, call in zip(self._bodies, calls, strict=True))
        return SceneFrame(
            frames, done, self._queries, self._most_touching, self._truncated, self._taken,
            self._impulses[:, :3], self._impulses[:, 3:],
            self._given[: self._part[len(self._bodies) - 1].stop], self._late, np.zeros(len(self._part), bool),
            np.zeros((len(self._part), 3)),
        )  # fmt: skip

    def _run_tick(self, calls: Sequence[Call], ways: Sequence[Way], share: float) -> None:
        substeps = calls[0].motion.substeps
        touches = [body.begin_tick(call) for body, call in zip(self._bodies, calls, strict=True)]
        self._aims = [
            way.start + share * (way.end - way.start) if isinstance(way, ColliderMotion) else None for way in ways
        ]
        self._pace, self._part_of_way = [1.0] * len(ways), [1.0] * len(ways)
        for i, aim in enumerate(self._aims):
            if not self._props.of[len(self._bodies) + i] and (aim is None or np.array_equal(aim, self._here[i])):
                self._aims[i], self._rates[i][:] = None, 0
            elif aim is not None:
                pairs = ((aim, self._ends[i]), (self._ends[i], self._here[i]), (aim, self._here[i]))
                led, late, left = (float(np.linalg.norm(a - b, axis=0).max()) for a, b in pairs)
                self._pace[i] = min(1.0, (led + late * self._tick / PUSH_TIME) / left) if late > 0 else 1.0
                self._ends[i] = aim
        awake = bool(self._moving().any())
        if awake:
            self._set_approach()
            self._wakes = True
        for step in range(substeps if awake else 0):
            if self._due:
                self._query()
            self._begin_contact()
            for i in woken(self._moving(), self._asleep(), self._sides(), self._free) if self._wakes else ():
                if prop := self._props.of[i]:
                    prop.asleep, prop.quiet = False, 0.0
                    continue
                self._bodies[i].wake(calls[i])
                touches[i] = self._bodies[i].near(calls[i])
            self._wakes = False
            self._props.begin(self._last, self._dt)
            for body, call, near in zip(self._bodies, calls, touches, strict=True):
                if not body.rest.asleep:
                    body.substep(call, near, substeps - 1 - step)
            with np.errstate(all="ignore"):  # the frame says when it has blown up
                self._was = [x.copy() for x in self._here]
                self._lead_colliders(step, substeps)
                self._move_props()
                self._resolve()
                self._keep_apart()
        for i, aim in enumerate(self._aims, len(self._bodies)):
            late = 0.0 if aim is None else np.linalg.norm(aim - self._here[i - len(self._bodies)], axis=0).max()
            self._late[i] = late
        for body, call in zip(self._bodies, calls, strict=True):
            body.end_tick(call)
        for _, prop in self._props.awake:
            prop.watch(self._tick)
        if all(call.finite for call in calls):
            self._let_sleep(calls)

    def _let_sleep(self, calls: Sequence[Call]) -> None:
        rested = [body.rest.rested for body in self._bodies]
        rested += [prop is not None and prop.rested for prop in self._props.of[len(self._bodies) :]]
        for i in let_sleep(self._moving(), np.array(rested), self._sides(), self._free) if any(rested) else ():
            if prop := self._props.of[i]:
                prop.asleep, prop.rested = True, False
            else:
                self._bodies[i].fall_asleep(calls[i])

    def _asleep(self) -> Bools:
        """Return which surfaces (k,) sleep."""
        props = self._props.of[len(self._bodies) :]
        return np.array([b.rest.asleep for b in self._bodies] + [p is not None and p.asleep for p in props])

    def _moving(self) -> Bools:
        """Return which surfaces (k,) move: what is awake, and colliders that are led."""
        led = np.array([False] * len(self._bodies) + [aim is not None for aim in self._aims])
        return np.where(self._free, ~self._asleep(), led)

    def _sides(self) -> Ints:
        """Return the surfaces (m, 2) of all that may touch."""
        standing = np.array([support.surfaces for support in self._props.supports], np.int64).reshape(-1, 2)
        return np.concatenate([self._surfaces.of_vertex[self._meetings.at[:, [0, 3]]], standing])

    def _positions(self) -> Floats:
        parts = [body.state.positions.T for body in self._bodies] + [x.T for x in self._here]
        return np.concatenate(parts)

    def _velocities(self) -> Floats:
        parts = [body.state.velocities.T for body in self._bodies] + [rate.T for rate in self._rates]
        return np.concatenate(parts)

    def _set_approach(self) -> None:
        """Set how much farther than they touch things are looked at [m]: they come nearer before the next look."""
        soft, fastest = [float(np.sqrt((b.state.velocities**2).sum(axis=0).max())) for b in self._bodies], [0.0]
        for here, aim in zip(self._here, self._aims, strict=True):
            if aim is not None:
                fastest.append(float(np.sqrt(((aim - here) ** 2).sum(axis=0).max())) / self._tick)
        for _, prop in self._props.awake:
            assert prop.fall
            fastest.append(prop.speed() + float(np.linalg.norm(prop.fall.gravity)) * self._tick)
        self._fastest_rigid, self._fastest = max(fastest), max(*soft, *fastest)
        least = self._touch + 3 * self._fastest * self._dt
        if not least <= self._approach <= 4 * least:
            self._approach, self._looks = self._touch + 6 * self._fastest * self._dt, True

    def _query(self) -> None:
        s, x, count, bodies = self._surfaces, self._positions(), len(self._part), len(self._bodies)
        lows, highs = (np.array([pick(x[part], axis=0) for part in self._part]) for pick in (np.min, np.max))
        slack, stale, runs, kept = np.full(count, np.inf), np.full(count, np.inf), [], self._kept(x)
        for i in range(count):
            for j in range(i, count):
                if not (i < bodies and self._itself[i] if i == j else self._free[i] or self._free[j]):
                    continue
                reach, run = self._reach_of(i, j), kept.get((i, j))
                apart = -1.0 if i == j else float(np.maximum(lows[j] - highs[i], lows[i] - highs[j]).max())
                if run is None and apart <= reach:
                    run = Run((i, j), self._searched(i, j, x, reach), reach, 0.0)
                far, way = apart, apart / 4
                if run:
                    runs.append(run)
                    far = run.reach - run.used
                    way = STALE * (far - self._touch) / 2
                for k in (i, j):
                    slack[k], stale[k] = min(slack[k], BOUND * far / 2), min(stale[k], way)
        pairs = _joined([run.pairs for run in runs])
        self._bounds: Bounds = bounds_of(x, slack[s.of_vertex], pairs)
        self._runs, self._placed, self._stale = runs, set(), stale
        self._touches = touching_distance(s, pairs, self._offsets, self._props.skins, bodies)
        order = touching.order_of(pairs, s)
        order = order[pairs.weight[order] > 0]
        self._candidates, self._touches = _picked(pairs, order), self._touches[order]
        self._near, self._looks = np.unique(pairs.at), True
        self._due, self._queries = False, self._queries + 1

    def _reach_of(self, i: int, j: int) -> float:
        """Return how far pairs of two surfaces are searched [m]: so far that rigid surfaces need not stop."""
        least = QUERY_REACH * max(self._touch, 2 * OFFSET * self._edge)
        soft = max(i, j) < len(self._bodies)
        return least if soft else max(least, self._touch + 3 * self._fastest_rigid * self._dt)

    def _next_way(self) -> float:
        """Return how far anything may move in the next substep [m]; speeds were measured as the tick began."""
        return self._fastest * self._dt / BOUND

    def _searched(self, i: int, j: int, x: Floats, reach: float) -> Pairs:
        """Return the pairs of two surfaces at x (n, 3) [m] that are nearer than the reach."""
        closest = float(max(self._sizes[i], self._sizes[j]))
        found = find_pairs(self._surfaces, x, i, j, reach=reach, closest=closest, bodies=len(self._bodies))
        return found if i != j else _picked(found, np.flatnonzero(self._left_out[found.at].sum(axis=1) == 0))

    def _kept(self, x: Floats) -> dict[tuple[int, int], Run]:
        """Return the pairs of surfaces that have hardly moved relative to each other since they were searched."""
        kept, start = dict[tuple[int, int], Run](), 0
        if not self._runs:
            return kept
        ways = [x[part] - self._bounds.before[part] for part in self._part]
        means = [way.mean(axis=0) for way in ways]
        bent = [float(np.linalg.norm(way - mean, axis=1).max()) for way, mean in zip(ways, means, strict=True)]
        for run in self._runs:
            (i, j), stop = run.surfaces, start + len(run.pairs.gap)
            way = bent[i] + bent[j] + float(np.linalg.norm(means[i] - means[j]))
            pairs, start = _picked(self._bounds.pairs, np.arange(start, stop)), stop
            if self._placed & {i, j} or run.reach < self._reach_of(i, j):
                continue
            left = run.reach - run.used - way
            if run.used + way < STALE * (run.reach - self._touch) / 2 and BOUND * left / 2 >= self._next_way():
                kept[i, j] = Run((i, j), replace(pairs, gap=pairs.gap - way), run.reach, run.used + way)
        return kept

    def _lead_colliders(self, step: int, substeps: int) -> None:
        """Let colliders go on their way in a substep; what was held back tries twice as much."""
        self._tried = np.ones(len(self._part))
        for i, aim in enumerate(self._aims):
            if aim is not None:
                self._share[len(self._bodies) + i] = min(1.0, 2 * max(self._share[len(self._bodies) + i], LEAST_WAY))
                self._tried[len(self._bodies) + i] = self._share[len(self._bodies) + i]
                self._part_of_way[i] = self._pace[i] / (substeps - self._pace[i] * step)
                self._go(len(self._bodies) + i)

    def _move_props(self) -> None:
        """Resolve what props touch but soft bodies, and let them go their way."""
        touching = self._props.resolve(self._velocities(), self._dt, self._impulses)
        self._most_touching = max(self._most_touching, touching)
        for i, _ in self._props.awake:
            self._share[i] = 1.0
            self._go(i)

    def _go(self, i: int) -> None:
        """Put a collider or a prop where its share of its way ends."""
        own, share = i - len(self._bodies), float(self._share[i])
        was, aim, prop = self._was[own], self._aims[own], self._props.of[i]
        if share == 0:
            self._here[own] = was.copy()
        elif prop:
            centre, turn = prop.pose(self._dt, share)
            self._here[own] = np.ascontiguousarray((prop.what.shape.arms @ turn.T + centre).T)
        elif aim is not None:
            self._here[own] = was + share * self._part_of_way[own] * (aim - was)
        self._rates[own] = (self._here[own] - was) / self._dt

    def _begin_contact(self) -> None:
        """Before a substep: note where everything is, and look again where that has moved."""
        self._last = self._positions()
        self._looks = self._looks or bool(
            ((self._last[self._near] - self._looked[self._near]) ** 2).sum(axis=1).max(initial=0)
            > (self._touch / 2) ** 2
        )
        if not self._looks:
            return
        bodies, led = self._bodies, [np.zeros(x.shape[1]) for x in self._here]
        friction = np.concatenate([body.model.friction for body in bodies] + self._frictions)
        self._inverse_mass = np.concatenate([body.model.inverse_mass for body in bodies] + led)
        self._looked, self._looks, self._wakes = self._last, False, True
        if len(self._sum):
            self._sum_meetings()
        soft = (self._surfaces.of_vertex[self._candidates.at] < len(bodies)).any(axis=1)
        for which, inverse_mass in ((soft, self._inverse_mass), (~soft, np.ones_like(self._inverse_mass))):
            met = touching.look(
                self._surfaces, _picked(self._candidates, np.flatnonzero(which)), self._touches[which], friction,
                self._last, inverse_mass, self._approach,
            )  # fmt: skip
            if which is soft:
                self._meetings, self._sum = met, np.zeros((len(met.gap), 3))
            else:
                self._props.note(met, self._surfaces)

    def _resolve(self) -> None:
        meetings = self._meetings = touching.measured(self._meetings, self._last, self._inverse_mass)
        sides, sleeps = self._surfaces.of_vertex[meetings.at[:, [0, 3]]], self._asleep()
        if not len(meetings.gap):
            resist(self._turning, sides, meetings.gap, self._dt, sleeps)
            self._props.answer(sides, meetings.point, meetings.normal)
            return
        asleep = sleeps[sides[:, 0]] | sleeps[sides[:, 1]]
        v, out, passed, active = touching.resolve(
            meetings, self._last - self._looked, self._velocities(), self._inverse_mass, self._dt, asleep,
            self._touch,
        )
        changed = np.unique(meetings.at[active])
        for body, part in zip(self._bodies, self._part, strict=False):
            own = changed[(changed >= part.start) & (changed < part.stop)]
            own = own[self._inverse_mass[own] > 0]
            state, rows = body.state, own - part.start
            state.positions[:, rows] += self._dt * (v[own].T - state.velocities[:, rows]) + out[own].T
            state.velocities[:, rows] = v[own].T
        resist(self._turning, sides, np.einsum("mc,mc->m", passed, meetings.normal), self._dt, sleeps)
        self._props.answer(sides, meetings.point, passed)
        self._sum += passed
        self._most_touching = max(self._most_touching, int((passed != 0).any(axis=1).sum()))

    def _sum_meetings(self) -> None:
        """Add up what the meetings passed since they were listed, by where they are now."""
        m, passed = self._meetings, self._sum
        sides, given = self._surfaces.of_vertex[m.at[:, [0, 3]]], np.column_stack([passed, np.cross(m.point, passed)])
        np.add.at(self._given, m.at, m.weights[:, :, None] * passed[:, None])
        np.add.at(self._impulses, sides[:, 0], given)
        np.subtract.at(self._impulses, sides[:, 1], given)
        self._sum = np.zeros_like(passed)

    def _keep_apart(self) -> None:
        """Keep skin ahead of all that has moved; where it cannot get away, what is rigid goes half of its way."""
        bodies, stuck = len(self._bodies), {-1}  # of surfaces that skin cannot get away from
        while stuck:
            stuck = self._watch_ways()
            b = self._bounds = moved(self._bounds, self._positions(), self._last)
            left = left_of(b, self._positions())
            rigid = np.asarray(b.pairs.rigid.all(axis=1))
            for row in np.flatnonzero((left < 0).any(axis=1) & rigid).tolist():
                stuck |= set(self._surfaces.of_vertex[b.pairs.at[row]].tolist())
            for vertex in np.unique(b.pairs.at[(left < 0) & ~rigid[:, None]]).tolist():
                stuck |= self._settle(vertex)
            stuck = {i for i in stuck if i >= bodies and self._share[i] > 0 and self._is_moving(i)}
            for i in stuck:
                self._share[i] = self._share[i] / 2 if self._share[i] > LEAST_WAY * self._tried[i] else 0.0
                self._go(i)
        for i, prop in self._props.awake:
            self._truncated += self._share[i] < 1
            self._taken += (1 - self._share[i]) * prop.what.shape.mass * float(np.linalg.norm(prop.state.velocity))
            leave(prop, float(self._share[i]), self._dt)
        x = self._positions()
        spent = np.flatnonzero(left_of(self._bounds, x).min(axis=1, initial=np.inf) < self._bounds.pairs.keep)
        if len(spent):
            self._bounds = renewed(self._bounds, spent, x, self._sizes[self._surfaces.of_vertex])

    def _is_moving(self, i: int) -> bool:
        prop = self._props.of[i]
        return not prop.asleep if prop else self._aims[i - len(self._bodies)] is not None

    def _watch_ways(self) -> set[int]:
        """Note how far all have gone since the query; return the rigid surfaces that would go too far."""
        stuck, x, b = set[int](), self._positions(), self._bounds
        for i, part in enumerate(self._part):
            ways = np.linalg.norm(x[part] - b.before[part], axis=1)
            for vertex in (part.start + np.flatnonzero(~(ways <= b.slack[part]))).tolist():
                stuck |= self._settle(vertex) if i < len(self._bodies) else {i}
        gone = np.linalg.norm(self._positions() - b.before, axis=1)
        for part, stale in zip(self._part, self._stale, strict=True):
            farthest, least = float(gone[part].max()), float(b.slack[part].min())
            self._due |= farthest > stale or farthest + self._next_way() > least
        return stuck

    def _settle(self, vertex: int) -> set[int]:
        """Bring a vertex of a body to where it may be; return the surfaces that it cannot get away from."""
        index = int(self._surfaces.of_vertex[vertex])
        body, x, b = self._bodies[index], self._positions(), self._bounds
        was = np.concatenate([self._last[: self._part[len(self._bodies) - 1].stop], *(w.T for w in self._was)])
        planes = [row for row in beyond(b, vertex, x[vertex]) if b.pairs.rigid[row].any()]
        way = way_of(b, planes[0], x, was) if planes else None
        own, last = vertex - self._part[index].start, self._last[vertex]
        pinned = not body.model.inverse_mass[own] > 0
        margin = ROUNDING * body.model.mesh.size
        at, allowed = settle(b, vertex, x[vertex], last, None if pinned else way, margin)
        if pinned and np.linalg.norm(at - last) > np.linalg.norm(x[vertex] - last):  # it is not pushed
            at, allowed = last, is_allowed(b, vertex, last)
        back = at - x[vertex]
        back = back / max(float(np.linalg.norm(back)), 1e-300)
        velocity = body.state.velocities[:, own]
        change = max(0.0 if way is None else float(way @ back) / self._dt, 0.0) - float(velocity @ back)
        if change > 0:
            body.state.velocities[:, own] = velocity + change * back
            self._taken += 0.0 if pinned else change / float(body.model.inverse_mass[own])
        body.state.positions[:, own] = at
        self._truncated += 1
        self._due |= body.rest.asleep
        rows = np.zeros(0, np.int64) if allowed else beyond(b, vertex, at)
        return set(self._surfaces.of_vertex[b.pairs.at[rows][:, [0, 3]]].ravel().tolist())


def _joined(found: Sequence[Pairs]) -> Pairs:
    if not found:
        none, whole = np.zeros(0), np.zeros(0, np.int64)
        return Pairs(
            at=whole.reshape(0, 4), ones=whole, part=whole.reshape(0, 2), rigid=np.zeros((0, 2), bool),
            normal=none.reshape(0, 3), level=none, keep=none, gap=none, weight=none,
        )  # fmt: skip
    return Pairs(**{name: np.concatenate([getattr(p, name) for p in found]) for name in Pairs.__slots__})


def _picked(pairs: Pairs, which: np.ndarray) -> Pairs:
    return Pairs(**{name: getattr(pairs, name)[which] for name in Pairs.__slots__})
