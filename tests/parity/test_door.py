"""What the door of the native core lets in: nothing that could crash Blender."""

import ctypes
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core import native
from core.native import NativeError
from core.session import Session
from core.solver.path import FingerPath
from tests.bodies import after
from tests.native_core import missing
from tests.parity.cases import CASES, TICK, build

HERE = Path(__file__).parent
HANDLE, SIZE, INDEX, NUMBER, ORDER, OPTION = 1, 3, 4, 5, 7, 8  # dimple.h


def refused(name: str, *values: Any) -> int:
    """Return the code of a call that must be refused."""
    with pytest.raises(NativeError) as caught:
        native.call(name, *values)
    return caught.value.code


@pytest.fixture
def body() -> native.Body:
    model, _, _ = build(CASES["liquid"])
    return native.Body(native.library(), model, 32)


@pytest.mark.parametrize("handle", [0, 1, 4096, 2**63, 2**64 - 1])
def test_a_handle_that_never_was_is_refused(handle: int) -> None:
    n, one = 4, np.ones(12)
    assert refused("dm_read", handle, n, one, one, None) == HANDLE
    assert refused("dm_step", handle, 1, 1, 1e-3, 0, None, None, None) == HANDLE
    assert refused("dm_free", handle) == HANDLE


def test_a_freed_body_is_refused_even_when_its_place_is_taken_again() -> None:
    model, state, _ = build(CASES["liquid"])
    first = native.Body(native.library(), model, 64)
    native.call("dm_free", first.handle)
    others = [native.Body(native.library(), model, 64) for _ in range(20)]
    assert refused("dm_step", first.handle, 1, 1, 1e-3, 0, None, None, None) == HANDLE
    assert refused("dm_free", first.handle) == HANDLE
    assert len({other.handle.value for other in others}) == 20


def test_a_body_of_another_size_is_refused(body: native.Body) -> None:
    small = np.zeros((3, 5))
    assert refused("dm_set_state", body.handle, 5, small, small, None, None) == SIZE
    for size in (-1, 0, body.n + 1):
        assert refused("dm_read", body.handle, size, small, small, None) == SIZE
        assert refused("dm_read_contact", body.handle, size, np.zeros(5, int), ctypes.byref(ctypes.c_int64())) == SIZE
    assert refused("dm_set_matter", body.handle, -1, small, small, small) == SIZE
    assert refused("dm_set_faces", body.handle, -3, None) == SIZE
    assert refused("dm_set_faces", body.handle, 3, None) == SIZE


def test_vertices_that_do_not_exist_are_refused(body: native.Body) -> None:
    for bad in (-1, body.n, 2**40):
        assert refused("dm_set_faces", body.handle, 1, np.array([[0, 1, bad]])) == INDEX
        assert refused("dm_set_contact", body.handle, 0.0, 1, np.array([bad])) == INDEX
        ring = np.full((1, 4), bad)
        created = ctypes.byref(ctypes.c_uint64())
        assert refused("dm_create", created, 32, native.BEST, 4, np.zeros((3, 4)), 1, ring, 0 * ring) == INDEX


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_are_refused(body: native.Body, bad: float) -> None:
    x = np.zeros((3, body.n))
    broken = x.copy()
    broken[1, 7] = bad
    assert refused("dm_set_state", body.handle, body.n, broken, x, None, None) == NUMBER
    assert refused("dm_set_state", body.handle, body.n, x, broken, None, None) == NUMBER
    assert refused("dm_set_state", body.handle, body.n, x, x, np.full(12, bad), None) == NUMBER
    assert refused("dm_set_state", body.handle, body.n, x, x, np.zeros(12), np.full(12, bad)) == NUMBER
    assert refused("dm_step", body.handle, 1, 1, bad, 0, None, None, None) == NUMBER
    centres, radii = np.full((1, 2, 3), bad), np.ones(1)
    assert refused("dm_step", body.handle, 1, 1, 1e-3, 1, centres, radii, np.zeros((1, 3))) == NUMBER
    assert refused("dm_fit_rotation", np.full(9, bad), np.zeros(9)) == NUMBER


def test_steps_beyond_all_measure_are_refused(body: native.Body) -> None:
    for ticks, substeps in ((-1, 1), (1, 0), (2**40, 1), (1, 2**62), (2**31, 2**33)):
        assert refused("dm_step", body.handle, ticks, substeps, 1e-3, 0, None, None, None) == SIZE
    assert refused("dm_step", body.handle, 1, 1, 1e-3, 4, None, None, None) == SIZE


def test_a_body_is_not_stepped_before_it_is_whole() -> None:
    handle = ctypes.c_uint64()
    native.call("dm_create", ctypes.byref(handle), 32, native.BEST, 3, np.eye(3), 0, None, None)
    assert refused("dm_step", handle, 1, 1, 1e-3, 0, None, None, None) == ORDER
    assert refused("dm_set_state", handle, 3, np.eye(3), np.eye(3), None, None) == ORDER
    assert refused("dm_read", handle, 3, np.eye(3), np.eye(3), None) == ORDER
    native.call("dm_free", handle)


def test_an_unknown_precision_fill_or_law_set_is_refused(body: native.Body) -> None:
    made = ctypes.byref(ctypes.c_uint64())
    assert refused("dm_create", made, 16, native.BEST, 3, np.eye(3), 0, None, None) == OPTION
    assert refused("dm_create", made, 32, 9, 3, np.eye(3), 0, None, None) == OPTION
    assert refused("dm_set_fill", body.handle, 9, 1.0, 0, None, 0, None, None) == OPTION
    assert refused("dm_set_world", body.handle, 9, 1.0, np.zeros(3), 0.0) == OPTION


def test_a_body_goes_with_its_model() -> None:
    import gc

    model, state, path = build(CASES["liquid"])
    native.run(model, state, path, tick=TICK, substeps=1)
    handle = native.body_of(model, 32).handle.value
    del model
    gc.collect()
    assert refused("dm_free", handle) == HANDLE


def test_the_extremes_of_a_run_are_taken(body: native.Body) -> None:
    """No ticks, no fingers, a fingertip larger than the body with the body inside."""
    model, state, path = build(CASES["liquid"])
    still = FingerPath(centres=np.zeros((0, 1, 3)), radii=np.zeros(0))
    before = state.positions.copy()
    assert native.run(model, state, still, tick=TICK, substeps=1).shape == (0, 3)
    np.testing.assert_allclose(state.positions, before, atol=1e-8)
    huge = FingerPath(centres=np.zeros((1, 3, 3)), radii=np.array([1.0]))
    native.run(model, state, huge, tick=TICK, substeps=2)


@pytest.mark.parametrize("seed", range(4))
def test_random_calls_never_end_the_process(seed: int) -> None:
    done = subprocess.run([sys.executable, HERE / "fuzz.py", str(seed)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "calls" in done.stdout


@pytest.fixture
def unloaded(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The library as it is before its first use."""
    good = Path(native.library()._name)
    monkeypatch.setattr(native, "_loaded", [])
    monkeypatch.setattr(native, "places", lambda: [good])
    native.why_not.cache_clear()
    yield
    monkeypatch.undo()
    native.why_not.cache_clear()


@pytest.mark.usefixtures("unloaded")
@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("places", lambda: [HERE / "nothing"], "has no native core for this machine"),
        ("places", lambda: [Path(__file__)], "was refused"),  # no library at all
        ("ABI", 999, f"was refused (it has version {native.ABI}, not 999)"),
        ("AGREEMENT", 1e-12, "was refused (it differs from numpy by"),
        ("LIBRARY", native.LIBRARY, ""),
    ],
    ids=["missing", "broken", "another version", "wrong at its first use", "whole"],
)
def test_a_library_that_is_no_good_leaves_numpy_and_a_reason(
    monkeypatch: pytest.MonkeyPatch, name: str, value: Any, reason: str
) -> None:
    monkeypatch.setattr(native, name, value)
    session = Session(build(CASES["liquid"])[0])
    assert session.backend == ("numpy" if reason else "native")
    assert reason in session.backend_note and ("Runs on numpy" in session.backend_note) == bool(reason)
    assert np.isfinite(after(session, 2e-3)).all()


@pytest.mark.parametrize(("ci", "compiler", "outcome"), [
    ("true", True, pytest.fail.Exception), ("true", False, pytest.skip.Exception), ("", True, pytest.skip.Exception),
])  # fmt: skip
def test_where_ci_has_a_compiler_a_missing_core_fails_the_tests(
    ci: str, compiler: bool, outcome: type[BaseException], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("CI", ci)
    monkeypatch.setattr("tools.native.ZIG", tmp_path)
    if compiler:
        (tmp_path / "ziglang").mkdir()
    with pytest.raises(outcome, match="not compiled"):
        missing("not compiled")
