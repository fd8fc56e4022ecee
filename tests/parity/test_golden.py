"""The same press gives the bits it has always given, and in double precision the same on every instruction set.

The numbers that go in are rounded to 20 bits, so that they are the same on every machine; then so are the results,
and a hash that changes says that the arithmetic did. Change it here when that was meant.

numpy has none: OpenBLAS chooses the order of a sum for the processor, so that the reference has other last digits on
another one. The double-precision hashes hold on NEON too (seen under qemu). Single precision has none there: that core
fuses otherwise than AVX2's, and no arm64 machine was at hand to take one from.
"""

import dataclasses
import hashlib
import os
from typing import Any

import numpy as np
import pytest

from core import native
from core.body.model import Model
from core.native import Body
from core.native.motion import FingertipMotion
from studies.motions import straight
from tests.parity.cases import CASES, build

GOLDEN = {
    ("liquid", 32, "SSE2"): "dcbe888cbd8d777d35cf05904e1b48a1bcc507fb063795d2e9ee8fcba9aec047",
    ("liquid", 32, "AVX2"): "11fc31c2096e83e8ab381a60eecea332f0fd58cffa9654b7c9b3710f9a278127",
    ("liquid", 64, ""): "e900e76883e307e4a56588ebb820add4b2fb5b11b60949675194244e58476cb1",
    ("free on the ground", 32, "SSE2"): "51f9c1a49e7f1799da29e681aba6f57767388a67ba7a9e9c8ecfbe32854eae4f",
    ("free on the ground", 32, "AVX2"): "dbe9b7d146535e42dbac5d82e16b1ab5fe5c62dc614001d81840ed939defca79",
    ("free on the ground", 64, ""): "f249680cc2394960fdf51dcbaee3e256f479284c5fe98292c76812fefe90522d",
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
    return straight(start, end, ticks=1, radius=radius, fresh=tick == 0)


@pytest.mark.parametrize("name", ["liquid", "free", "crumpled", "moving pins"])
def test_every_instruction_set_gives_the_same_bits_in_double_precision(name: str) -> None:
    if not native.instructions(native.AVX2):
        pytest.skip("this machine has only one")
    model, _, _ = build(CASES[name])
    library = native.library()
    base, avx2 = (native.Body(model, library, bits=64, instruction_set=which) for which in (native.BASE, native.AVX2))
    assert trajectory(model, name, base) == trajectory(model, name, avx2)


@pytest.mark.parametrize(("name", "bits", "instructions"), GOLDEN)
def test_the_bits_are_those_they_have_always_been(name: str, bits: int, instructions: str) -> None:
    chosen = native.AVX2 if instructions == "AVX2" else native.BASE
    if instructions not in ("", native.instructions(chosen)):
        pytest.skip(f"this machine has no {instructions}")
    if instructions == "AVX2" and "DIMPLE_LIBRARY" in os.environ:
        pytest.skip("another compiler fuses otherwise")
    model = rounded(build(CASES[name])[0])
    body = native.Body(model, native.library(), bits=bits, instruction_set=chosen)
    assert trajectory(model, name, body) == GOLDEN[name, bits, instructions]
