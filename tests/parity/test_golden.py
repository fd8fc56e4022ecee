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
from core.body.model import Model
from core.solver.backend import Body, create
from core.solver.motion import FingertipMotion
from tests.parity.cases import CASES, build

GOLDEN = {
    ("liquid", 32, "SSE2"): "0ff0bed1730b9cdef7ae77a630c122f66ab41951f82e03667de584e27b4a30a9",
    ("liquid", 32, "AVX2"): "0b66306a970fe10440e8a85a351f1f2943f60dc437c926244d16ea721b91bef3",
    ("liquid", 64, ""): "84f9cd01ad226d55f7b50bde8dffdd21e82e249bf47bba5da8c476d5bbb88532",
    ("free on the ground", 32, "SSE2"): "5dffe752a7066bafca4b2d3ae7148fee092e5d3aebd504452dd7e03f2cb89d9c",
    ("free on the ground", 32, "AVX2"): "b4a00a012439a024758b20a81c4ef772c63103a515eae9a65deb2ea28a054a49",
    ("free on the ground", 64, ""): "f34bea7a1bab4f971864a965431655ed573df655e20b44ceb8581649fa5b66a0",
}
NUMPY = {
    "liquid": "79c01a61122beca7bb96e2657b7f406eecd74de57602b88ec34487749b9418b8",
    "paper laws": "a87b4efa3f7e43bcc7759376b793bb124f2a9272398ed5a8b7cd48881ebbb856",
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


def trajectory(model: Model, name: str, body: Body) -> str:
    _, velocities, motion = build(CASES[name])
    body.set_state(rounded(model.matching.rest), velocities)
    hashed = hashlib.sha256()
    for tick in range(motion.ticks):
        tips = tuple(_at(tip, tick, motion.ticks) for tip in motion.fingertips if tip)
        frame = body.step(motion._replace(ticks=1, substeps=8, fingertips=tips))
        impulses = np.array([touch.impulse for touch in frame.touches if touch])
        hashed.update(body.positions().tobytes() + body.velocities().tobytes() + impulses.tobytes())
    return hashed.hexdigest()


def _at(tip: FingertipMotion, tick: int, ticks: int) -> FingertipMotion:
    """Return the way of a fingertip in one tick, in rounded numbers."""
    start, end = (
        rounded(np.array(tip.start) + (np.array(tip.last) - tip.start) * at / ticks).tolist() for at in (tick, tick + 1)
    )
    radius = float(rounded(np.array(tip.radius)))
    return FingertipMotion.straight(start, end, ticks=1, radius=radius, fresh=tick == 0)


@pytest.mark.parametrize("backend", ["native", "native64", "numpy"])
@pytest.mark.parametrize("name", ["liquid", "free on the ground", "lifted by three"])
def test_the_same_press_gives_the_same_bits(name: str, backend: str) -> None:
    model, _, _ = build(CASES[name])
    first, second = (trajectory(model, name, create(model, backend=backend)) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("name", ["liquid", "free", "crumpled", "moving pins"])
def test_every_instruction_set_gives_the_same_bits_in_double_precision(name: str) -> None:
    if not native.instructions(native.AVX2):
        pytest.skip("this machine has only one")
    model, _, _ = build(CASES[name])
    base, avx2 = (native.Body(model, bits=64, instruction_set=which) for which in (native.BASE, native.AVX2))
    assert trajectory(model, name, base) == trajectory(model, name, avx2)


@pytest.mark.parametrize(("name", "bits", "instructions"), GOLDEN)
def test_the_bits_are_those_they_have_always_been(name: str, bits: int, instructions: str) -> None:
    chosen = native.AVX2 if instructions == "AVX2" else native.BASE
    if instructions not in ("", native.instructions(chosen)):
        pytest.skip(f"this machine has no {instructions}")
    if instructions == "AVX2" and "DIMPLE_LIBRARY" in os.environ:
        pytest.skip("another compiler fuses otherwise")
    model = rounded(build(CASES[name])[0])
    body = native.Body(model, bits=bits, instruction_set=chosen)
    assert trajectory(model, name, body) == GOLDEN[name, bits, instructions]


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="taken on x86-64")
@pytest.mark.parametrize("name", NUMPY)
def test_numpys_bits_on_a_held_body_are_those_they_have_always_been(name: str) -> None:
    model, _, _ = build(CASES[name])
    model = rounded(model)
    assert trajectory(model, name, create(model, backend="numpy")) == NUMPY[name]
