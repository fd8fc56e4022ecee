"""Judge the guarantee: nothing passes through anything. `python3 dev.py contact [--quick] [--json FILE] [SCENE...]`

The referee is the PyPI package ipctk (development only), which looks for intersections after every tick; a winding
number tells whether a body has been swallowed. A prop touches with its surface moved inwards by the distance that is
kept, and the referee sees that surface; how deep the visible prop overlaps others is measured at the end of each start.
Then colliders and pins rest, and the remaining motion of the skin is measured.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from core.base import Floats, Ints
from core.session import Session
from core.world import World
from studies.contact.cost import measure_cost
from studies.contact.meeting import meeting_of
from studies.contact.scenes import SCENES, Played
from studies.files import write_json
from studies.reference.facets import nearest_on_triangles

STARTS, QUICK_STARTS = 10, 1
RESTS, WATCHED = 100, 50  # ticks with colliders and pins at rest, and the last of them, which are measured
PROBE = "import ipctk, numpy; f = numpy.array([[0, 1, 2]]); ipctk.CollisionMesh(numpy.eye(3), ipctk.edges(f), f)"
MISSING = (
    "The referee, ipctk, does not run. python3 dev.py installs it; if its build for one Python asks for another "
    "processor than this one, use the other Python: --blender 4.5."
)


class Referee:
    """Look for intersections between the surfaces of a world, with another library's code."""

    def __init__(self, played: Played) -> None:
        import ipctk  # type: ignore[import-not-found]

        world = played.world
        faces = [session.body.model.mesh.triangles for session in world.sessions]
        faces += [collider.triangles for collider in world.colliders]
        counts = [len(session.body.model.mesh.rest_positions) for session in world.sessions]
        counts += [collider.positions.shape[1] for collider in world.colliders]
        starts = np.cumsum([0, *counts])
        self._world, self.bodies = world, len(world.sessions)
        self.parts = [slice(a, b) for a, b in zip(starts[:-1], starts[1:], strict=True)]
        self.faces = faces
        every = np.concatenate([f + start for f, start in zip(faces, starts, strict=False)]).astype(np.int32)
        self._mesh = ipctk.CollisionMesh(self.positions(), ipctk.edges(every), every)
        # colliders go where they are led, through each other too; a prop is stiff
        patches = np.arange(starts[-1])
        patches[starts[self.bodies] :] = starts[self.bodies]
        for i, collider in enumerate(world.colliders, self.bodies):
            if collider.falling:
                patches[self.parts[i]] = starts[i] + 1
        self._mesh.can_collide = ipctk.make_vertex_patches_filter(patches.astype(np.int32))
        self._count = ipctk.has_intersections

    def positions(self) -> Floats:
        """Return where all vertices (n, 3) [m] are."""
        world = self._world
        parts = [session.body.positions().T for session in world.sessions]
        return np.concatenate([*parts, *(world.collider(i) for i in range(len(world.colliders)))])

    def intersects(self) -> bool:
        """Tell whether anything passes through anything."""
        return bool(self._count(self._mesh, self.positions()))

    def swallowed(self) -> int:
        """Return how many bodies have a vertex inside another closed surface."""
        x, found = self.positions(), 0
        for i in range(self.bodies):
            points = x[self.parts[i]][:: max(len(x[self.parts[i]]) // 60, 1)]
            for j, part in enumerate(self.parts):
                if i != j and _closed(self.faces[j]) and (np.abs(winding(points, x[part], self.faces[j])) > 0.5).any():
                    found += 1
                    break
        return found

    def overlap(self) -> float:
        """Return how deep [m] a prop as it is seen reaches into a closed surface, or another into it, at most."""
        world, x = self._world, self.positions()
        shapes = [x[part] for part in self.parts]
        props = []
        for i, collider in enumerate(world.colliders):
            if world.props and collider.falling:
                state = world.props[i].state
                shapes[self.bodies + i] = collider.falling.seen @ state.turn.T + state.centre
                props.append(self.bodies + i)
        pairs = [pair for i in props for j in range(len(shapes)) if i != j for pair in ((i, j), (j, i))]
        return max((depth(shapes[i], shapes[j], self.faces[j]) for i, j in pairs), default=0.0)


def depth(points: Floats, x: Floats, faces: Ints) -> float:
    """Return how deep [m] the deepest of points (p, 3) lies inside a surface, 0 where it is open."""
    if not _closed(faces):
        return 0.0
    most, corners = 0.0, x[faces].transpose(2, 0, 1)
    for point in points[np.abs(winding(points, x, faces)) > 0.5]:
        nearest = np.einsum("ctk,tk->ct", corners, nearest_on_triangles(corners, point))
        most = max(most, float(np.linalg.norm(nearest - point[:, None], axis=0).min()))
    return most


def winding(points: Floats, x: Floats, faces: Ints) -> Floats:
    """Return the winding number (p,) of a surface round points (p, 3). Source: van Oosterom and Strackee 1983."""
    a, b, c = (x[faces[:, k]] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    dots = [np.einsum("pfc,pfc->pf", u, v) for u, v in ((a, b), (b, c), (c, a))]
    whole = np.einsum("pfc,pfc->pf", a, np.cross(b, c))
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    total: Floats = np.arctan2(whole, below).sum(axis=1) / (2 * np.pi)
    return total


def judge(name: str, starts: int) -> dict[str, Any]:
    """Play a scene from several starts and return what came of it."""
    found = dict.fromkeys(("intersections", "swallowed"), 0)
    spent, alone, overlap = list[float](), list[float](), 0.0
    finite, taken, truncated, ticks, held_back, touching = True, 0.0, 0, 0, 0.0, 0
    trembling = list[float]()
    for start in range(starts):
        played = SCENES[name](np.random.default_rng(start))
        referee, world = Referee(played), played.world
        count = played.ticks
        for tick in range(count):
            at = (tick + 1) / count
            world.set_colliders([lead and lead(at) for lead in played.colliders])
            for session, lead in zip(world.sessions, played.pins, strict=True):
                if lead:
                    session.set_pins(lead(at))
            began = time.process_time()
            world.step(world.sessions[0].clock.tick)
            spent.append(time.process_time() - began)
            meeting = meeting_of(world)
            taken, truncated = taken + meeting.taken, truncated + meeting.truncated
            held_back, touching = max(held_back, meeting.held_back), max(touching, meeting.touching)
            finite = finite and all(session.frame.finite for session in world.sessions)
            found["intersections"] += referee.intersects()
        found["swallowed"] += referee.swallowed()
        overlap = max(overlap, referee.overlap())
        trembling.append(trembling_of(world))
        ticks += count
        alone += _alone(world.sessions, count)
    return {
        "name": name, "starts": starts, "ticks": ticks, **found, "finite": finite,
        "cost_ratio": round(median(spent) / median(alone), 2), "median_ms": round(1e3 * median(spent), 3),
        "momentum_taken": taken, "truncated": truncated,
        "trembling_mm": round(1e3 * median(trembling), 4), "held_back_mm": 1e3 * held_back,
        "touching": touching, "overlap_mm": 1e3 * overlap,
    }  # fmt: skip


def trembling_of(world: World) -> float:
    """Return the largest motion of a vertex in a tick [m], by the median, with colliders and pins at rest."""
    before, most = list[Floats](), list[float]()
    for _ in range(RESTS):
        world.step(world.sessions[0].clock.tick)
        now = [session.body.positions().copy() for session in world.sessions]
        ways = (np.linalg.norm(a - b, axis=0).max() for a, b in zip(now, before or now, strict=True))
        most.append(float(max(ways)))
        before = now
    return median(most[-WATCHED:])


def _alone(sessions: list[Session], ticks: int) -> list[float]:
    """Return the processor time [s] that the bodies take alone in each tick, none of them asleep."""
    spent = [0.0] * ticks
    for session in sessions:
        session.reset()
        for tick in range(ticks):
            session.body.set_state(session.body.positions(), session.body.velocities())  # it wakes
            began = time.process_time()
            session.step(session.clock.tick)
            spent[tick] += time.process_time() - began
    return spent


def _closed(faces: Ints) -> bool:
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return bool((np.unique(sides, axis=0, return_counts=True)[1] == 2).all())


def add_contact(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_contact)
    command.add_argument("--quick", action="store_true", help="one start of each scene")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the results")
    command.add_argument("scenes", nargs="*", choices=[*SCENES, []], metavar="SCENE", help=", ".join(SCENES))


def run_contact(options: argparse.Namespace) -> int:
    """Judge the scenes and return the exit code: 0 only if nothing passed through anything."""
    if subprocess.run([sys.executable, "-c", PROBE], check=False, capture_output=True).returncode:
        print(MISSING, file=sys.stderr)
        return 1
    rows = []
    print(
        "scene                 starts  ticks  intersections  swallowed  finite  cost  tick [ms]"
        "  taken [N s]  held back [mm]  trembling [mm]  props overlap [mm]"
    )
    for name in options.scenes or SCENES:
        row = judge(name, QUICK_STARTS if options.quick else STARTS)
        rows.append(row)
        print(
            f"{name:21} {row['starts']:6} {row['ticks']:6} {row['intersections']:14} {row['swallowed']:10}"
            f"  {'yes' if row['finite'] else 'NO':6} {row['cost_ratio']:5.1f} {row['median_ms']:10.3f}"
            f" {row['momentum_taken']:12.3g} {row['held_back_mm']:14.2f} {row['trembling_mm']:15.4f}"
            f" {row['overlap_mm']:20.3f}",
            flush=True,
        )
    found: dict[str, Any] = {"scenes": rows}
    if not options.scenes:
        found["cost"] = measure_cost()
        for case, cost in found["cost"].items():
            print(f"{case:22}", ", ".join(f"{name} {value}" for name, value in cost.items()))
    if options.json:
        write_json(options.json, found)
    return 0 if all(not row["intersections"] and not row["swallowed"] and row["finite"] for row in rows) else 1
