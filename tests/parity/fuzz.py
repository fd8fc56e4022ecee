"""Call the native core at random, by itself in a process: `fuzz.py SEED`. Every array is longer than its count."""

import ctypes
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from core import native
from core.native.body import CFrame, CMotion
from core.native.carry import CBinding
from core.native.cells import CCells
from core.native.definition import BodyDef, Constants
from core.native.scene import CColliderMotion, CCrossings, ColliderDef, CProp, CSceneFrame

CALLS = 4000
BODIES = 12
NAMES = ("create", "set_constants", "set_state", "get_state", "step", "carry", "scene", "scene_step", "scene_find",
         "scene_set", "scene_get", "cells")  # fmt: skip
SHARES = (0.25, 0.08, 0.08, 0.05, 0.17, 0.05, 0.1, 0.12, 0.02, 0.02, 0.02, 0.04)
SCENES = 6
ROOM = 4096  # elements of every array
WILD = np.array([0.0, -1.0, 1e-3, 1e30, -1e300, 1e-310, np.nan, np.inf, -np.inf])
FAR = (-1, -(2**31), 2**31 - 1, 2**40, -(2**62), 2**62)
INDICES = {"ring", "ring_spring", "ends", "irregular_spring", "corners", "fan", "cap_edge", "cap_hole",
           "surface_corners", "surface_material", "seed", "cells",
           "around"}  # fmt: skip
BYTES = {"loose", "irregular_end"}


class Fuzzer:
    """Random definitions, constants and motions, mostly such that they go deep."""

    def __init__(self, seed: int) -> None:
        self.rng, self.kept = np.random.default_rng(seed), list[Any]()

    def array(self, name: str, n: int) -> int | None:
        """Return the address of a random array, sometimes null."""
        rng = self.rng
        if rng.random() < 0.02:
            return None
        if name in BYTES:
            made: Any = rng.integers(0, 2, ROOM).astype(np.uint8)
        elif name in INDICES:
            wild = rng.random() < 0.03
            made = rng.integers(-2 if wild else 0, n + (2 if wild else 0), ROOM)
            made = np.where(rng.random(ROOM) < 0.2, -1, made) if name == "ring_spring" else made
        else:
            made = rng.uniform(0, 1, ROOM) * 10.0 ** rng.integers(-6, 7)
            if rng.random() < 0.05:
                made[rng.integers(0, ROOM, 300)] = rng.choice(WILD)
        self.kept.append(made)
        return int(made.ctypes.data)

    def fill(self, structure: ctypes.Structure, n: int) -> ctypes.Structure:
        """Give every field of a structure a random value."""
        rng = self.rng
        for name, kind, *_ in structure._fields_:
            odd = rng.random() < 0.02
            if kind is ctypes.c_void_p:
                setattr(structure, name, self.array(name, n))
            elif kind is ctypes.c_double:
                setattr(structure, name, float(rng.choice(WILD)) if odd else float(rng.uniform(0, 1)))
            elif kind in (ctypes.c_int64, ctypes.c_int32):
                few = int(rng.integers(0, 3 if kind is ctypes.c_int32 else 8))
                far = int(rng.choice(FAR[:3] if kind is ctypes.c_int32 else FAR))
                setattr(structure, name, far if odd else few)
            else:
                parts = getattr(structure, name)
                if isinstance(parts, ctypes.Structure):
                    self.fill(parts, n)
                else:
                    for i, part in enumerate(parts):
                        if isinstance(part, ctypes.Structure):
                            self.fill(part, n)
                        else:
                            parts[i] = float(rng.choice(WILD)) if odd else float(rng.uniform(-1, 1))
        return structure

    def definition(self) -> BodyDef:
        """Return a random body."""
        definition, n = BodyDef(), int(self.rng.integers(1, 12))
        self.fill(definition, n)
        if self.rng.random() < 0.95:
            definition.vertices = definition.surface_vertices = n
            definition.springs, definition.constants.materials = max(definition.springs, n), n + 2
        return definition

    def binding(self) -> CBinding:
        """Return a random surface that follows a proxy, mostly one that is carried."""
        made, n, rng = CBinding(), int(self.rng.integers(1, 8)), self.rng
        self.fill(made, n)
        if rng.random() < 0.9:
            made.vertices, made.seeds, each = int(rng.integers(0, 30)), n, int(rng.integers(0, 5))
            made.entries, made.arms = each * -(-made.vertices // 8), each * n
            starts = each * np.arange(ROOM)
            self.kept += [starts, followed := rng.integers(0, n, ROOM).astype(np.uint16)]
            made.first = made.starts = starts.ctypes.data
            made.followed = followed.ctypes.data
        return made

    def motion(self) -> CMotion:
        """Return a random motion, none that is allowed but takes long."""
        motion = CMotion()
        self.fill(motion, 4)
        if 0 <= motion.ticks < 2**31 and 0 <= motion.substeps < 2**31:
            motion.ticks, motion.substeps = motion.ticks % 8, motion.substeps % 8 + 1
        if self.rng.random() < 0.5:
            motion.pins_from = motion.pins_to = None
        return motion

    def collider(self) -> ColliderDef:
        """Return a random mesh that bodies meet, mostly one that is taken."""
        made, n = ColliderDef(), int(self.rng.integers(1, 12))
        self.fill(made, n)
        if self.rng.random() < 0.95:
            made.vertices, made.triangles = n, self.rng.integers(0, 12)
        return made


def check(frame: CFrame) -> None:
    """Fail where a number that is none has come into a force."""
    for touch in frame.touches:
        numbers = [*touch.force, *touch.impulse, touch.slope]
        assert np.isfinite(numbers).all(), numbers


class Scenes:
    """Scenes of living bodies: each of its bodies lives until it is freed, and is in no other one."""

    def __init__(self, fuzzer: Fuzzer) -> None:
        self.fuzzer, self.rng = fuzzer, fuzzer.rng
        self.alive: list[tuple[ctypes.c_void_p, list[ctypes.c_void_p], int]] = []

    def create(self, bodies: list[ctypes.c_void_p]) -> int:
        """Make a scene of some bodies, which then belong to it."""
        rng, handle = self.rng, ctypes.c_void_p()
        some = [bodies.pop(int(rng.integers(len(bodies)))) for _ in range(min(len(bodies), int(rng.integers(1, 4))))]
        handles = (ctypes.c_void_p * 4)(*(body.value for body in some))
        count = int(rng.integers(0, 3)) if rng.random() < 0.98 else int(rng.choice(FAR))
        colliders = (ColliderDef * 3)(*(self.fuzzer.collider() for _ in range(3)))
        flags = (ctypes.c_uint8 * 4)(*rng.integers(0, 2, 4).tolist())
        held = (ctypes.c_double * 4)(*(rng.choice([0.0, 1e-3, -1.0], 4, p=[0.6, 0.38, 0.02])))
        create, out = native.library().dm_scene_create, (CCrossings * 4)()
        code = int(create(ctypes.byref(handle), len(some), handles, flags, held, count, colliders, out))
        if code:
            bodies += some
        else:
            self.alive.append((handle, some, count))
            while len(self.alive) > SCENES:
                self.free()
        return code

    def free(self) -> None:
        """Free the oldest scene, and then its bodies."""
        handle, bodies, _ = self.alive.pop(0)
        native.library().dm_scene_destroy(handle)
        for body in bodies:
            native.library().dm_destroy(body)

    def call(self, name: str) -> int:
        """Step a random scene, look for crossings in it, or lead a collider."""
        rng, library, address = self.rng, native.library(), ctypes.byref
        none = (None, [None], 1)
        handle, bodies, count = self.alive[rng.integers(len(self.alive))] if self.alive else none
        handle = handle if rng.random() < 0.98 else None
        which = int(rng.integers(-1, 4))
        if name == "scene_find":
            return int(library.dm_scene_find_crossings(handle, address(CCrossings())))
        if name == "scene_set":
            return int(library.dm_scene_set_collider(handle, which, self.fuzzer.array("positions", 8)))
        if name == "scene_get":
            room = np.empty(ROOM)
            return int(library.dm_scene_get_collider(handle, which, room.ctypes.data))
        motions = (CMotion * len(bodies))(*(self.fuzzer.motion() for _ in bodies))
        for motion in motions if rng.random() < 0.95 else ():
            motion.ticks, motion.substeps, motion.tick = motions[0].ticks, motions[0].substeps, motions[0].tick
        ways = (CColliderMotion * max(count, 1))()
        for way in ways:
            if rng.random() < 0.5:
                way.from_, way.to = self.fuzzer.array("positions", 8), self.fuzzer.array("positions", 8)
            if rng.random() < 0.5:
                self.fuzzer.kept.append(prop := CProp())
                self.fuzzer.fill(prop, 1)
                way.prop = ctypes.addressof(prop)
        frames, first, last = (CFrame * len(bodies))(), *rng.uniform(0, 1, 2).tolist()
        out, passed, given = address(CSceneFrame()), self.fuzzer.array("passed", 8), self.fuzzer.array("given", 8)
        code = int(library.dm_scene_step(handle, motions, ways, first, last, frames, out, passed, given))
        for frame in frames:
            check(frame)
        return code


def main(seed: int) -> None:
    named = os.environ.get("DIMPLE_LIBRARY")
    if named:
        native._loaded.append(native.load(Path(named)))
    fuzzer, library, codes = Fuzzer(seed), native.library(), dict[str, dict[int, int]]()
    rng, bodies, scenes = fuzzer.rng, list[ctypes.c_void_p](), Scenes(fuzzer)
    address = ctypes.byref
    for _ in range(CALLS):
        name = str(rng.choice(NAMES, p=SHARES))
        living = bodies + [body for _, own, _ in scenes.alive for body in own]
        body = living[rng.integers(len(living))] if living and rng.random() < 0.98 else None
        if name == "create":
            handle = ctypes.c_void_p()
            bits = int(rng.choice([32, 64, 16], p=[0.49, 0.49, 0.02]))
            code = library.dm_create(address(handle), address(fuzzer.definition()), bits, int(rng.integers(0, 3)))
            bodies += [handle] if code == 0 else []
            while len(bodies) > BODIES:
                library.dm_destroy(bodies.pop(0))
        elif name == "scene":
            code = scenes.create(bodies)
        elif name.startswith("scene_"):
            code = scenes.call(name)
        elif name == "set_constants":
            constants = Constants()
            fuzzer.fill(constants, 8)
            constants.materials = 20
            code = library.dm_set_constants(body, address(constants))
        elif name == "carry":
            room = (fuzzer.array(a, 8) for a in ("positions", "motions", "skin"))
            code = library.dm_carry(address(fuzzer.binding()), *room)
        elif name == "cells":
            cells, around, joined, *lists = (
                fuzzer.array(a, 6) for a in ("cells", "around", "joined", "first", "followed", "weights")
            )
            surface = address(fuzzer.fill(CCells(), 6))
            width = int(fuzzer.rng.integers(-1, 9))
            code = library.dm_follow_cells(surface, cells, width, around, *lists)
            code = max(code, library.dm_grow_cells(surface, cells, joined))
            points, corners = fuzzer.array("positions", 6), fuzzer.array("corners", 6)
            code = max(code, library.dm_flip_edges(int(fuzzer.rng.integers(-1, 9)), points, 2, corners))
        elif name == "step":
            code = library.dm_step(body, address(fuzzer.motion()), address(frame := CFrame()))
            check(frame)
        else:
            x, v = (fuzzer.array(a, 8) for a in ("positions", "velocities"))
            code = getattr(library, f"dm_{name}")(body, x, v)
        fuzzer.kept.clear()
        found = codes.setdefault(name, {})
        found[code] = found.get(code, 0) + 1
    print(f"{CALLS} calls: {codes}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
