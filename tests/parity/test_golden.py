"""The same press gives the same bits: again, on another body of the same model, and on every instruction set.

The numbers that go in are rounded to 20 bits, so that they are the same on every machine; then so are the results,
and a hash that changes says that the arithmetic did. Change it here when that was meant.
"""

import dataclasses
import hashlib
from typing import Any

import numpy as np
import pytest

from core import native
from core.base import Floats
from core.integrators import semi_implicit
from core.integrators.methods import Run
from core.model import Model
from tests.parity.cases import CASES, TICK, build

GOLDEN = {
    ("liquid", 32): "567479c6c7fa129a56cbf2a75ae5a7da86c554ca7c2e5e2e40c3d4a114186222",
    ("liquid", 64): "08fbc4f3ffc1cde1aebf9b2bf63ecc73f462a956f6c292839788d5d77c23dc5d",
    ("free on the ground", 32): "8e1b60d6410676ecd955630f2bded24cf5fa42ad27b3e15236544941daa4ca18",
    ("free on the ground", 64): "2ba65d2624433894024b61e63adad535664d21409436489ee446d5ae482bbebe",
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


@pytest.mark.parametrize("bits", [32, 64])
@pytest.mark.parametrize("name", ["liquid", "free", "crumpled", "bend springs"])
def test_every_instruction_set_gives_the_same_bits(name: str, bits: int) -> None:
    if not native.instructions(native.AVX2):
        pytest.skip("this machine has only one")
    model, _, _ = build(CASES[name])
    assert trajectory(model, name, on(bits, native.BASE)) == trajectory(model, name, on(bits, native.AVX2))


@pytest.mark.parametrize(("name", "bits"), GOLDEN)
def test_the_bits_are_those_they_have_always_been(name: str, bits: int) -> None:
    model, _, _ = build(CASES[name])
    assert trajectory(rounded(model), name, on(bits, native.BEST)) == GOLDEN[name, bits]
