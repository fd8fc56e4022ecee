"""The same press gives the same bits: again, on another body, and in double precision on every instruction set.

The numbers that go in are rounded to 20 bits, so that they are the same on every machine; then so are the results,
and a hash that changes says that the arithmetic did. Change it here when that was meant.

numpy has hashes for held bodies on x86-64: the same with numpy 1.26 and 2.3, with AVX-512, AVX2 and neither. It has
none for free bodies: their rigid fit is a product of matrices, whose order of summation OpenBLAS chooses for the
processor (four of its kernels gave four hashes). The double-precision hashes hold on NEON too (seen under qemu).
Single precision has none there: that core fuses otherwise than AVX2's, and no arm64 machine was at hand to take one
from.
"""

import dataclasses
import hashlib
import os
import platform
from typing import Any

import numpy as np
import pytest

from core import native
from core.base import Floats
from core.body.model import Model
from core.solver import semi_implicit
from studies.methods.registry import Run
from tests.parity.cases import CASES, TICK, build

GOLDEN = {
    ("liquid", 32, "SSE2"): "0ff0bed1730b9cdef7ae77a630c122f66ab41951f82e03667de584e27b4a30a9",
    ("liquid", 32, "AVX2"): "0b66306a970fe10440e8a85a351f1f2943f60dc437c926244d16ea721b91bef3",
    ("liquid", 64, ""): "84f9cd01ad226d55f7b50bde8dffdd21e82e249bf47bba5da8c476d5bbb88532",
    ("free on the ground", 32, "SSE2"): "5dffe752a7066bafca4b2d3ae7148fee092e5d3aebd504452dd7e03f2cb89d9c",
    ("free on the ground", 32, "AVX2"): "b4a00a012439a024758b20a81c4ef772c63103a515eae9a65deb2ea28a054a49",
    ("free on the ground", 64, ""): "cb099b66618cb908a9488c0db1eddf5cab74ed13e539d6e97243c7cb3e1c9300",
}
NUMPY = {
    "liquid": "79c01a61122beca7bb96e2657b7f406eecd74de57602b88ec34487749b9418b8",
    "paper laws": "21262bca61fe22ee55cbdabb6850b336c0bac99b341a4ba2a9f017d8f0a59d6d",
}


def rounded(value: Any) -> Any:
    """Round every number inside a model to 20 bits."""
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        mantissa, exponent = np.frexp(value)
        return np.ldexp(np.rint(mantissa * 2**20), exponent - 20)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: rounded(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return dataclasses.replace(value, **fields)
    return float(rounded(np.array(value))) if isinstance(value, float) else value


def trajectory(model: Model, name: str, run: Run) -> str:
    _, state, path = build(CASES[name])
    state.positions, centres = rounded(state.positions), rounded(path.centres)
    hashed = hashlib.sha256()
    for t in range(path.centres.shape[1] - 1):
        piece = dataclasses.replace(path, centres=centres[:, t : t + 2], radii=rounded(path.radii))
        impulses = run(model, state, piece, tick=TICK, substeps=8)
        hashed.update(state.positions.tobytes() + state.velocities.tobytes() + impulses.tobytes())
    return hashed.hexdigest()


def on(bits: int, instruction_set: int) -> Run:
    """Return a stepper of a body of its own."""

    def run(model: Model, state: Any, path: Any, *, tick: float, substeps: int) -> Floats:
        body = native.Body(native.library(), model, bits, instruction_set)
        return native.run_body(body, model, state, path, tick=tick, substeps=substeps)

    return run


@pytest.mark.parametrize("run", [native.run, native.run64, semi_implicit.run], ids=["f32", "f64", "numpy"])
@pytest.mark.parametrize("name", ["liquid", "free on the ground", "lifted by three"])
def test_the_same_press_gives_the_same_bits(name: str, run: Run) -> None:
    model, _, _ = build(CASES[name])
    assert trajectory(model, name, run) == trajectory(model, name, run)


@pytest.mark.parametrize("name", ["liquid", "free", "crumpled", "bend springs"])
def test_every_instruction_set_gives_the_same_bits_in_double_precision(name: str) -> None:
    if not native.instructions(native.AVX2):
        pytest.skip("this machine has only one")
    model, _, _ = build(CASES[name])
    assert trajectory(model, name, on(64, native.BASE)) == trajectory(model, name, on(64, native.AVX2))


@pytest.mark.parametrize(("name", "bits", "instructions"), GOLDEN)
def test_the_bits_are_those_they_have_always_been(name: str, bits: int, instructions: str) -> None:
    chosen = native.AVX2 if instructions == "AVX2" else native.BASE
    if instructions not in ("", native.instructions(chosen)):
        pytest.skip(f"this machine has no {instructions}")
    if instructions == "AVX2" and "DIMPLE_LIBRARY" in os.environ:
        pytest.skip("another compiler fuses otherwise")
    model, _, _ = build(CASES[name])
    assert trajectory(rounded(model), name, on(bits, chosen)) == GOLDEN[name, bits, instructions]


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="taken on x86-64")
@pytest.mark.parametrize("name", NUMPY)
def test_numpys_bits_on_a_held_body_are_those_they_have_always_been(name: str) -> None:
    model, _, _ = build(CASES[name])
    assert trajectory(rounded(model), name, semi_implicit.run) == NUMPY[name]
