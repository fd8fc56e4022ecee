"""Call the native core at random, by itself in a process: `fuzz.py SEED`. Every array is longer than what is told."""

import ctypes
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from core import native

CALLS = 4000
N = 6  # vertices of the bodies that are whole from the start
ROOM = 4096  # elements of every array
WILD = np.array([0.0, -1.0, 1e-3, 1e30, -1e300, 1e-310, np.nan, np.inf, -np.inf])
FAR = (-1, -(2**31), 2**31 - 1, 2**40, -(2**62), 2**62)


def argument(letter: str, rng: np.random.Generator, handles: list[int]) -> Any:
    """Return a value for a letter of native.ARGUMENTS: mostly one that goes deep, sometimes a wild one."""
    odd = rng.random() < 0.04
    match letter:
        case "b":
            return int(rng.integers(0, 2**63)) if odd else handles[rng.integers(len(handles))]
        case "o" | "p":
            return ctypes.byref(ctypes.c_int64())
        case "i":
            few = rng.choice([32, 64]) if rng.random() < 0.3 else rng.integers(4)
            return int(rng.integers(-5, 99) if odd else few)
        case "n":
            return FAR[rng.integers(len(FAR))] if odd else N if rng.random() < 0.6 else int(rng.integers(0, 12))
        case "d":
            return float(rng.choice(WILD)) if odd else float(rng.uniform(0, 1))
        case "U":
            return rng.integers(0, 2, ROOM).astype(np.uint8)
    if odd:
        return None
    if letter == "I":
        return rng.integers(-2 if rng.random() < 0.1 else 0, N, ROOM)
    values = rng.uniform(0, 1, ROOM) * 10.0 ** rng.integers(-6, 7)
    if rng.random() < 0.1:
        values[rng.integers(0, ROOM, 300)] = rng.choice(WILD)
    return values


def main(seed: int) -> None:
    named = os.environ.get("DIMPLE_LIBRARY")
    if named:
        native.use(native.load(Path(named)))
    rng = np.random.default_rng(seed)
    model, state, path = native.small_press()
    bodies = [native.Body(native.library(), model, bits) for bits in (32, 64)]
    for body in bodies:
        native.run_body(body, model, state, path, tick=1e-3, substeps=2)
    handles, codes, names = [body.handle.value for body in bodies], dict[int, int](), list(native.ARGUMENTS)
    for _ in range(CALLS):
        name = names[rng.integers(len(names))]
        values = [argument(letter, rng, handles) for letter in native.ARGUMENTS[name]]
        if name == "dm_step" and 0 <= values[1] < 2**31 and 0 <= values[2] < 2**31:
            values[1], values[2] = values[1] % 8, values[2] % 8  # what is allowed but takes long
        made = ctypes.c_uint64()
        if name == "dm_create":
            values[0] = ctypes.byref(made)
        arrays = [v.ctypes.data if isinstance(v, np.ndarray) else v for v in values]
        code = getattr(native.library(), name)(*arrays)
        codes[code] = codes.get(code, 0) + 1
        if made.value:
            handles.append(made.value)
        if name == "dm_free" and code == 0:  # another whole one in its place
            bodies.append(native.Body(native.library(), model, 32))
            handles[handles.index(values[0])] = bodies[-1].handle.value
    print(f"{CALLS} calls: {codes}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
