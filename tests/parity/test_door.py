"""What the door of the native core lets in: nothing that could crash Blender."""

import ctypes
import os
import re
import subprocess
import sys
import weakref
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core import native
from core.base import DimpleError, Floats
from core.body.model import Model
from core.constants import FACTORS
from core.mesh.surface import mesh_from_triangles
from core.native import first_use
from core.native.body import CFrame, CMotion, CTouch, Fingertip
from core.native.carry import CBinding
from core.native.cells import CCells
from core.native.definition import Arrays, BodyDef, Constants, define
from core.native.motion import Motion
from core.native.scene import CColliderMotion, ColliderDef, CProp
from core.reduction import binding
from core.session import Session
from studies.motions import straight
from tests.bodies import TETRAHEDRON, after
from tests.parity.cases import CASES, TICK, build, run
from tools.native import SOURCES, shared_constants

HERE = Path(__file__).parent
SIZE, INDEX, NUMBER, OPTION = 1, 2, 3, 5  # dimple.h
HEADER = (SOURCES / "dimple.h").read_text()
STRUCTURES = {
    "dm_constants": Constants, "dm_body_def": BodyDef, "dm_fingertip": Fingertip,
    "dm_motion": CMotion, "dm_touch": CTouch, "dm_frame": CFrame, "dm_binding": CBinding, "dm_cells": CCells,
    "dm_collider_def": ColliderDef, "dm_prop": CProp, "dm_collider_motion": CColliderMotion,
}  # fmt: skip
C_TYPES = {"double": "c_double", "int64_t": "c_int64", "int32_t": "c_int32"}


def declared(name: str) -> list[tuple[str, str]]:
    """Return the fields of a structure in dimple.h: name, and type as ctypes writes it."""
    code = re.sub(r"/\*.*?\*/", "", HEADER, flags=re.DOTALL)
    found = re.search(r"typedef struct \{([^{}]*)\} " + name + ";", code)
    assert found, name
    fields = []
    for kind, names in re.findall(r"\s*((?:const )?\w+)\s+([^;]+);", found[1]):
        for each in names.split(","):
            label, _, count = each.strip().lstrip("*").partition("[")
            plain = "c_void_p" if "*" in each else C_TYPES.get(kind, kind)
            size = count.rstrip("]").replace("DM_MAX_FINGERTIPS", "3")
            fields.append((label, f"{plain}[{size}]" if size else plain))
    return fields


def in_python(structure: type[ctypes.Structure]) -> list[tuple[str, str]]:
    """Return the fields of a structure in core/native: name, and type."""
    names = {made: name for name, made in STRUCTURES.items()}

    def word(kind: Any) -> str:
        if hasattr(kind, "_length_"):
            return f"{word(kind._type_)}[{kind._length_}]"
        plain = ("c_void_p", "c_double", "c_int64", "c_int32")
        return names.get(kind) or next(name for name in plain if getattr(ctypes, name) is kind)

    return [(name.rstrip("_"), word(kind)) for name, kind, *_ in structure._fields_]


@pytest.mark.parametrize("name", STRUCTURES)
def test_python_and_c_lay_a_structure_out_alike(name: str) -> None:
    assert in_python(STRUCTURES[name]) == declared(name)


def test_the_constants_that_c_and_python_share_are_those_of_cs_page() -> None:
    assert (SOURCES.parent / "constants.py").read_text() == shared_constants()


def code_of(call: Callable[[], Any]) -> int:
    """Return the code of a call that must be refused."""
    with pytest.raises(native.NativeError) as caught:
        call()
    return caught.value.code


def created(change: Callable[[BodyDef], None], bits: int = 32, instruction_set: int = native.BEST) -> int:
    """Return the code of creating a sound body whose definition was changed."""
    sound, _, _ = build(CASES["liquid"])
    with Arrays() as arrays:
        definition = define(native.library(), sound, sound, arrays)
        change(definition)
        handle = ctypes.c_void_p()
        code = native.library().dm_create(ctypes.byref(handle), ctypes.byref(definition), bits, instruction_set)
        native.library().dm_destroy(handle)
        assert bool(handle) == (code == 0)
    return int(code)


@pytest.fixture
def body() -> native.Body:
    sound, _, _ = build(CASES["liquid"])
    return native.Body(sound, native.library())


def test_a_sound_definition_is_taken() -> None:
    assert created(lambda definition: None) == 0


@pytest.mark.parametrize("count", ["vertices", "springs", "irregular", "triangles", "fans", "cap_edges", "width"])
@pytest.mark.parametrize("wrong", [-1, 2**40])
def test_a_count_beyond_all_measure_is_refused(count: str, wrong: int) -> None:
    assert created(lambda definition: setattr(definition, count, wrong)) == SIZE


@pytest.mark.parametrize("array", ["rest", "ring", "ring_spring", "ends", "rest_length", "corners", "surface_rest"])
def test_an_array_that_is_missing_is_refused(array: str) -> None:
    assert created(lambda definition: setattr(definition, array, None)) == SIZE


@pytest.mark.parametrize("array", ["ring", "ends", "corners", "surface_corners", "surface_material"])
@pytest.mark.parametrize("wrong", [-1, 10**6, 2**40])
def test_vertices_springs_and_materials_that_do_not_exist_are_refused(array: str, wrong: int) -> None:
    bad = np.full(20_000, wrong)
    assert created(lambda definition: setattr(definition, array, bad.ctypes.data)) == INDEX


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, -1.0])
def test_constants_that_are_none_are_refused(body: native.Body, wrong: float) -> None:
    for name in ("mass", "inverse_mass", "friction"):
        broken = np.array(getattr(body.model, name))
        broken[7] = wrong
        changed = replace(body.model, **{name: broken})
        if name != "mass":
            assert code_of(lambda: body.set_constants(changed)) == NUMBER  # noqa: B023
            assert code_of(lambda: native.Body(changed, native.library())) == NUMBER  # noqa: B023
    stiffness = np.array(body.model.springs.stiffness)
    stiffness[3] = wrong
    changed = replace(body.model, springs=replace(body.model.springs, stiffness=stiffness))
    assert code_of(lambda: body.set_constants(changed)) == NUMBER
    for power in (wrong, 0.5):  # a law begins with the power 1 at the least
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Model, "laws", [(*law[:3], power, *law[4:]) for law in body.model.laws])
            assert code_of(lambda: body.set_constants(body.model)) == NUMBER


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_state_and_a_motion_with_numbers_that_are_none_are_refused(body: native.Body, bad: float) -> None:
    x = body.model.matching.rest.copy()
    broken = x.copy()
    broken[1, 7] = bad
    assert code_of(lambda: body.set_state(broken)) == NUMBER
    assert code_of(lambda: body.set_state(x, broken)) == NUMBER
    assert code_of(lambda: body.step(Motion(1, 1, bad))) == NUMBER
    tip = straight((0.0, 0.0, 1.0), (0.0, 0.0, 0.9), ticks=1, radius=0.1)
    for broken_tip in (
        tip._replace(start=(0.0, bad, 0.0)), tip._replace(last=(bad, 0.0, 0.0)), tip._replace(radius=bad),
        tip._replace(radius=1e-310), tip._replace(force=bad), tip._replace(inward=(bad, 0.0, 0.0)),
        tip._replace(factors=(np.full((1, FACTORS), bad), 1.0)), tip._replace(factors=(np.ones((1, FACTORS)), bad)),
    ):  # fmt: skip
        assert code_of(lambda: body.step(Motion(1, 1, TICK, (broken_tip,)))) == NUMBER  # noqa: B023
    assert body.step(Motion(1, 1, TICK)).finite, "what was refused has done nothing"


def test_a_state_or_constants_of_another_body_are_refused(body: native.Body) -> None:
    with pytest.raises(native.NativeError, match="shape"):
        body.set_state(np.zeros((3, 5)))
    with pytest.raises(native.NativeError, match="another mesh"):
        body.set_constants(build(CASES["free"])[0])
    moving = build(CASES["moving pins"])[2]
    assert moving.pins
    with pytest.raises(native.NativeError, match="pins"):
        body.step(moving._replace(pins=moving.pins._replace(end=moving.pins.end[:, :3])))


def test_steps_beyond_all_measure_are_refused(body: native.Body) -> None:
    for count, substeps in ((-1, 1), (1, 0), (2**40, 1), (1, 2**62), (2**31, 2**33)):
        assert code_of(lambda: body.step(Motion(count, substeps, 1e-3))) == SIZE  # noqa: B023


def test_the_law_is_asked_for_at_depths_and_fingertips_that_are(body: native.Body) -> None:
    depths = np.array([0.0, 0.001])
    assert (body.law(0, depths) == 0).all(), "none is down"
    assert code_of(lambda: body.law(3, depths)) == INDEX
    assert code_of(lambda: body.law(0, np.array([np.nan]))) == NUMBER


def test_an_unknown_precision_or_fill_is_refused() -> None:
    assert created(lambda definition: None, bits=16) == OPTION
    assert created(lambda definition: None, instruction_set=9) == OPTION
    assert created(lambda definition: setattr(definition.constants, "fill", 9)) == OPTION


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(DimpleError, match="backend"):
        Session(build(CASES["liquid"])[0], backend="gpu")


def test_a_null_body_is_refused_by_every_call() -> None:
    library, x = native.library(), np.zeros(3)
    assert library.dm_step(None, ctypes.byref(CMotion()), ctypes.byref(CFrame())) == SIZE
    assert library.dm_set_state(None, x.ctypes.data, None) == SIZE
    assert library.dm_get_state(None, x.ctypes.data, None) == SIZE
    assert library.dm_get_law(None, 0, None, 0.0, 1, x.ctypes.data, x.ctypes.data) == SIZE
    assert library.dm_set_constants(None, ctypes.byref(Constants())) == SIZE
    library.dm_destroy(None)


def bound_to_four() -> native.Binding:
    """Return what binds nine points, the first four the corners of a tetrahedron, to these corners."""
    points = np.random.default_rng(0).normal(size=(9, 3))
    points[:4] = TETRAHEDRON[0]
    coarse = mesh_from_triangles(*TETRAHEDRON)
    return binding.bind(points, coarse, np.hstack([points, 0 * points]), np.arange(4), np.arange(9) % 4)


def test_a_binding_to_what_is_not_there_is_refused() -> None:
    whole, x = bound_to_four(), np.zeros((3, 4))
    assert native.carry(native.library(), whole, x)[0].shape == (9, 3)

    def code(positions: Floats, **others: Any) -> int:
        return code_of(lambda: native.carry(native.library(), replace(whole, **others), positions))

    for name in ("followed", "starts", "first", "corners", "arms"):
        values = getattr(whole, name)
        assert code(x, **{name: values + values.dtype.type(4)}) == INDEX, name
    assert code(x, first=whole.first[::-1]) == code(x, starts=whole.starts[::-1]) == INDEX
    for name in ("first", "weights", "places", "starts", "spread", "upright", "corners", "arms", "centre"):
        with pytest.raises(native.NativeError, match="size"):
            native.carry(native.library(), replace(whole, **{name: getattr(whole, name)[..., :-1]}), x)
    with pytest.raises(native.NativeError, match="size"):
        native.carry(native.library(), whole, x[:, :3])
    room = x.ctypes.data
    assert native.library().dm_carry(ctypes.byref(CBinding()), room, room, room) == SIZE
    assert native.library().dm_carry(None, room, room, room) == SIZE


def test_cells_of_what_is_not_there_are_refused() -> None:
    library, place, seeds = native.library(), np.random.default_rng(0).normal(size=(4, 6)), np.array([0, 3])
    ends, around, none = np.array([[0, 1], [1, 2], [2, 3]]), np.array([[0, 1], [1, -1]]), np.zeros(1)
    cells, joined = native.grow_cells(library, ends, place, seeds)
    assert joined.all() and cells[0] == 0 and cells[3] == 1
    assert native.follow_cells(library, place, seeds, cells, around)[1].tolist() == [0, 1]
    for wrong in ((ends + 1, seeds), (ends, seeds + 1), (ends, seeds - 1)):
        with pytest.raises(native.NativeError, match="index"):
            native.grow_cells(library, wrong[0], place, wrong[1])
    for wrong in ((cells - 1, around), (cells, around + 1), (cells, around - 1)):
        with pytest.raises(native.NativeError, match="index"):
            native.follow_cells(library, place, seeds, *wrong)
    assert library.dm_grow_cells(ctypes.byref(CCells()), none.ctypes.data, none.ctypes.data) == SIZE
    assert library.dm_follow_cells(None, none.ctypes.data, 1, *(none.ctypes.data,) * 4) == SIZE


def test_triangles_on_points_that_are_not_there_are_not_flipped() -> None:
    library, points, corners = native.library(), np.eye(3), np.array([[0, 1, 2]])
    assert (native.flip_edges(library, points, corners) == corners).all()
    for wrong in (corners + 1, corners - 1, [[0, 1, 0]]):
        with pytest.raises(native.NativeError, match="index"):
            native.flip_edges(library, points, wrong)
    assert library.dm_flip_edges(0, None, 0, None) == library.dm_flip_edges(3, points.ctypes.data, -1, None) == SIZE


def test_a_body_is_freed_with_its_object(monkeypatch: pytest.MonkeyPatch) -> None:
    import gc

    freed: list[int] = []
    library = native.library()
    monkeypatch.setattr(weakref, "finalize", lambda owner, free, handle: freed.append(handle))
    made = native.Body(build(CASES["liquid"])[0], native.library())
    assert freed == [made.handle.value]
    library.dm_destroy(freed[0])
    monkeypatch.undo()
    kept = native.Body(build(CASES["liquid"])[0], native.library())
    alive = weakref.ref(kept)
    del kept
    gc.collect()
    assert alive() is None


def test_the_extremes_of_a_run_are_taken(body: native.Body) -> None:
    """No ticks, no fingers, a fingertip larger than the body with the body inside."""
    sound, velocities, _ = build(CASES["liquid"])
    before = body.positions()
    assert body.step(Motion(0, 1, TICK)).touches == ()
    np.testing.assert_array_equal(body.positions(), before)
    huge = straight((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), ticks=2, radius=1.0)
    run(body, velocities, Motion(2, 2, TICK, (huge,)))


SANITIZED = "DIMPLE_LIBRARY" in os.environ  # where a bad access is seen, and more seeds are worth their time


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=[pytest.mark.slow] * (seed > SANITIZED)) for seed in range(4)]
)
def test_random_calls_never_end_the_process(seed: int) -> None:
    done = subprocess.run([sys.executable, HERE / "fuzz.py", str(seed)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "calls" in done.stdout


@pytest.fixture
def unloaded(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library as it is before its first use."""
    good = Path(native.library()._name)
    monkeypatch.setattr(native, "_loaded", [])
    monkeypatch.setattr(native, "places", lambda: [good])


@pytest.mark.usefixtures("unloaded")
@pytest.mark.parametrize(
    ("where", "name", "value", "reason"),
    [
        (native, "places", lambda: [HERE / "nothing"], "no compiled core for"),
        (native, "places", lambda: [Path(__file__)], "was refused"),  # no library at all
        (native, "ABI", 999, rf"was refused \(it has version {native.ABI}, not 999\)"),
        (first_use, "ROUNDING", 1e-12, r"was refused \(its check is off by"),
    ],
    ids=["missing", "broken", "another version", "wrong at its first use"],
)
def test_without_a_library_that_is_good_a_session_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, where: Any, name: str, value: Any, reason: str
) -> None:
    monkeypatch.setattr(where, name, value)
    with pytest.raises(DimpleError, match=f"{reason}.*Install the zip"):
        Session(build(CASES["liquid"])[0])


@pytest.mark.usefixtures("unloaded")
def test_a_library_is_tested_at_its_first_use() -> None:
    assert np.isfinite(after(Session(build(CASES["liquid"])[0]), 2e-3)).all()
