"""Constants of the model that are identified without being asked for: on every mesh, for every material, once."""

import itertools
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest

LONGEST_S = 60.0  # in the background, after which something must be wrong


@pytest.fixture
def asked(bpy: ModuleType, forgetful: Any, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The materials that are identified from here on, by a Blender that knows none."""
    from bl_ext.user_default.dimple.operators import identified

    real, materials = identified.identification, []

    def counted(mesh: Any, material: Any, *given: Any) -> Iterator[Any]:
        materials.append(material)
        return real(mesh, material, *given)

    monkeypatch.setattr(identified, "identification", counted)
    monkeypatch.setattr(identified, "_known", {})
    return materials


@pytest.fixture
def window(bpy: ModuleType, asked: list[Any], monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The identifications of a Blender that has a window: they are made in its background."""
    from bl_ext.user_default.dimple.operators import bridge_model, identified

    class App:
        background = False

    class Window:
        app = App

        def __getattr__(self, name: str) -> Any:
            return getattr(bpy, name)

    monkeypatch.setattr(bridge_model, "bpy", Window())
    yield identified
    identified.stop()
    assert not bpy.app.timers.is_registered(identified._go_on) and identified.progress() is None


@pytest.fixture
def endless(window: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Identifications in the background that come to no end by themselves."""
    monkeypatch.setattr(window, "identification", lambda *_: itertools.repeat(0.25))
    return window


def idle(window: Any) -> None:
    """Let Blender be idle until nothing is left to identify."""
    until = time.monotonic() + LONGEST_S
    while (pause := window._go_on()) is not None:
        assert time.monotonic() < until
        time.sleep(pause)


def read(bpy: ModuleType, obj: Any, **how: str) -> tuple[Any, str]:
    """Return the constants of the model of an object's first material, and what is noted."""
    from bl_ext.user_default.dimple.operators import bridge

    _, model = bridge.read_body(bpy.context, obj, **how)
    return model.materials[0].constants, " ".join(model.notes)


def give(settings: Any) -> None:
    settings.kappa1, settings.kappa2, settings.d0, settings.membrane_scale = 1.0, 9.0, 16.0, 0.01


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("K1", 0.5), ("K1", 0.6101), ("K2", 5.0), ("x0", 10.0), ("k", 4.0), ("spread_mm", 10.0), ("tip", "POINT"),
        ("tip_radius_mm", 3.0), ("fill", "LIQUID"),
    ],
)  # fmt: skip
def test_after_a_change_of_what_was_measured_the_body_runs_with_constants_identified_for_it(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any], name: str, value: Any
) -> None:
    from bl_ext.user_default.dimple.operators import calibration, indentation

    give(vinyl)
    record = {**indentation.described(indentation.set_up(bpy.context, cube, "TOP", 8.0)), "points": [[1.0, 0.6]]}
    vinyl.identification = json.dumps(record)
    before = getattr(vinyl, name)
    setattr(vinyl, name, before)
    vinyl.friction = vinyl.damping_ratio = 0.3
    vinyl.pressure_kpa = 5.0
    assert read(bpy, cube)[0].kappa1 == pytest.approx(1e6), "nothing that matters has changed"
    assert calibration.changed(vinyl) == [] and calibration.identification(vinyl)["points"] and not asked
    setattr(vinyl, name, value)
    constants, notes = read(bpy, cube)
    assert constants.kappa1 != pytest.approx(1e6) and "closed form" not in notes
    wanted, (material,) = vinyl.to_params(), asked
    for each in ("K1", "K2", "x0", "k", "spread", "indenter", "fill"):
        assert getattr(material, each) == wanted[each]
    assert calibration.changed(vinyl) == [name] and calibration.identification(vinyl) == {}
    assert read(bpy, cube)[0] == constants and len(asked) == 1
    setattr(vinyl, name, before)
    assert read(bpy, cube)[0].kappa1 == pytest.approx(1e6), "those of the material hold again"


def test_a_mesh_and_a_material_are_identified_once_and_remembered_by_another_blender(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import identified

    constants, _ = read(bpy, cube)
    twin = cube.copy()
    bpy.context.collection.objects.link(twin)
    vinyl.mass_kg, vinyl.damping_ratio = 3.0, 1.0
    assert constants and read(bpy, twin)[0] == constants and len(asked) == 1
    monkeypatch.setattr(identified, "_known", {})
    assert read(bpy, cube)[0] == constants and len(asked) == 1
    assert vinyl.kappa1 == 0 and vinyl.identification == "", "nothing is written into the material"
    cube.dimple.size_mm = 80
    assert read(bpy, cube)[0] != constants and len(asked) == 2


def test_where_no_constants_follow_the_law_the_closed_form_does_and_a_note_says_so(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import identified

    real = identified.identification

    def hopeless(*given: Any) -> Iterator[Any]:
        found = yield from real(*given)
        return replace(found, simulated=1.5 * found.wanted)

    monkeypatch.setattr(identified, "identification", hopeless)
    for _ in range(2):
        constants, notes = read(bpy, cube)
        assert constants is None
        assert "estimate in closed form. No constants of the model follow the measured law" in notes
    assert len(asked) == 1


def test_a_place_that_cannot_be_pressed_leaves_the_closed_form_and_the_note_says_why(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    cube.vertex_groups.new(name="All").add(list(range(98)), 1.0, "ADD")
    cube.dimple.pinned, cube.dimple.pin_group, vinyl.tip = "GROUP", "All", "PUNCH"
    constants, notes = read(bpy, cube)
    assert constants is None and "estimate in closed form. The tip stands on vertices that are pinned" in notes
    assert not asked


def test_model_constants_without_a_record_hold(bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]) -> None:
    """A script may set them; what they depend on is its own matter."""
    give(vinyl)
    vinyl.K1 = 0.5
    assert read(bpy, cube)[0].kappa1 == pytest.approx(1e6) and not asked
    vinyl.identification = json.dumps({"object": "Cube", "size": 165.0})  # of an earlier version: without a fingerprint
    assert read(bpy, cube)[0].kappa1 != pytest.approx(1e6) and len(asked) == 1


def test_constants_of_another_mesh_or_size_are_not_used(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    bpy.ops.dimple.identify(depth_mm=8)
    own, _ = read(bpy, cube)
    cube.location, cube.rotation_euler = (3, 1, 2), (0, 0, 1)
    assert read(bpy, cube)[0] == own and not asked, "it may stand elsewhere"
    cube.dimple.size_mm = 80
    other, _ = read(bpy, cube)
    assert other.kappa1 != own.kappa1 and len(asked) == 1


def keyframe(settings: Any, name: str, *values: float) -> None:
    for frame, value in enumerate(values, 1):
        setattr(settings, name, value)
        settings.keyframe_insert(name, frame=frame)


def test_a_keyframed_material_is_identified_at_both_ends_of_its_keyframes(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    keyframe(vinyl, "K1", 0.3, 1.2)
    found = []
    for frame in (1, 2):
        bpy.context.scene.frame_set(frame)
        found.append(read(bpy, cube, identify="WAIT")[0])
    assert sorted(each.K1 for each in asked) == pytest.approx([300, 1200]) and len(found[0].pieces) > 5
    assert {each.K2 for each in asked} == {vinyl.to_params()["K2"]} and found[0] != found[1]


def test_keyframes_follow_the_constants_that_a_material_keeps(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    bpy.ops.dimple.identify(depth_mm=8)
    own, _ = read(bpy, cube)
    asked.clear()
    keyframe(vinyl, "K1", vinyl.K1, 2 * vinyl.K1)
    assert read(bpy, cube)[0].kappa1 == pytest.approx(2 * own.kappa1) and not asked
    bpy.context.scene.frame_set(1)
    assert read(bpy, cube)[0] == own


def test_where_another_fill_is_keyframed_the_closed_form_follows_it(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    vinyl.keyframe_insert("fill", frame=1)
    assert read(bpy, cube)[0] is None and read(bpy, cube, identify="WAIT")[0] is None and not asked


def test_a_driven_constant_is_followed_by_the_closed_form(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    vinyl.driver_add("K1").driver.expression = "0.6"
    assert read(bpy, cube, identify="WAIT")[0] is None and not asked


def test_until_a_change_is_identified_what_was_found_before_is_rescaled(
    bpy: ModuleType, vinyl: Any, cube: Any, window: Any, asked: list[Any]
) -> None:
    before, _ = read(bpy, cube, identify="WAIT")
    vinyl.K1 *= 1.5
    assert read(bpy, cube)[0].kappa1 == pytest.approx(1.5 * before.kappa1) and len(asked) == 1
    idle(window)
    assert len(asked) == 2 and read(bpy, cube)[0].kappa1 != pytest.approx(1.5 * before.kappa1, rel=1e-6)
    cube.dimple.size_mm = 80
    assert read(bpy, cube)[0] is None, "what was found for another size says nothing"


def test_a_pressure_that_is_keyframed_leaves_the_constants_that_were_identified_without(
    bpy: ModuleType, vinyl: Any, cube: Any, asked: list[Any]
) -> None:
    own, _ = read(bpy, cube)
    asked.clear()
    vinyl.pressure_kpa = 5.0
    vinyl.keyframe_insert("pressure_kpa", frame=1)
    assert own is not None and read(bpy, cube)[0] == own and not asked


def test_in_a_window_a_running_body_takes_over_what_the_background_has_found(
    bpy: ModuleType, vinyl: Any, cube: Any, window: Any, asked: list[Any], sessions: Any, shown: Any
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators import live

    def step(seconds: float) -> list[str]:
        return live.advance(bpy.context, seconds, pressed={entry.link.uid: entry.session.fingers})

    def constants() -> Any:
        return entry.session.model.materials[0].constants

    entry, _ = sessions.start(cube, bpy.context)
    try:
        entry.session.set_fingers([Finger((0.0, 0.0, entry.link.scale + 0.01), 0.02)])
        step(0.1)
        assert constants() is None and entry.frame.depths[0] > 0.005, "it runs with the closed form meanwhile"
        revision = window.revision
        assert bpy.app.timers.is_registered(window._go_on) and window.progress() == 0
        idle(window)
        assert window.revision == revision + 1 and window.progress() is None
        before = shown(cube)
        assert step(0.0) == []
        np.testing.assert_allclose(shown(cube), before, atol=1e-6, err_msg="it jumped")
        found = read(bpy, cube)[0]
        assert found is not None and constants() == found
        step(0.2)
        assert entry.frame.finite and not entry.frame.note and constants() == found
    finally:
        sessions.stop_all()
    assert len(asked) == 1


def test_what_the_background_finds_is_nothing_to_undo(bpy: ModuleType, vinyl: Any, window: Any, hand: Any) -> None:
    """What came before a poke stays, so Ctrl Z passes only where a setting was changed meanwhile."""
    poke = hand("poke")
    poke.invoke()
    idle(window)
    poke.ticks(2)
    assert poke.send("Z", ctrl=True) == {"RUNNING_MODAL"}
    vinyl.K1 = 3.0
    poke.ticks(1)
    assert poke.send("Z", ctrl=True) == {"PASS_THROUGH"}
    poke.send("ESC")


def test_a_bake_does_not_wait_for_the_background(
    bpy: ModuleType, vinyl: Any, cube: Any, window: Any, asked: list[Any]
) -> None:
    revision = window.revision
    assert read(bpy, cube)[0] is None
    found, _ = read(bpy, cube, identify="WAIT")
    assert found is not None and found == read(bpy, cube)[0] and window.revision == revision, "that is no news"
    idle(window)
    assert found == read(bpy, cube)[0] and window.revision == revision + 1, "for who has asked before"


def test_a_slider_that_is_dragged_drops_what_the_same_body_asked_for_before(
    bpy: ModuleType, endless: Any, ball: Callable[..., Any]
) -> None:
    bodies = [ball("One"), ball("Two")]
    for at, obj in enumerate(bodies):
        obj.location.x = 3 * at
        obj.data.materials.append(bpy.data.materials.new(obj.name))
        assert read(bpy, obj)[0] is None
    first, other = endless._jobs.values()
    for K1 in (0.7, 0.8):
        bodies[0].active_material.dimple.K1 = K1
        read(bpy, bodies[0])
    read(bpy, bodies[0])
    jobs = list(endless._jobs.values())
    assert len(jobs) == 2 and jobs[0] is other and jobs[1] is not first
    until = time.monotonic() + LONGEST_S
    while other.share == 0:
        assert endless._go_on() is not None and time.monotonic() < until
        time.sleep(endless.LOOK_S)
    assert (other.share, jobs[1].share, first.share) == (0.25, 0, 0)
    assert first.dropped and not other.dropped


def test_what_two_bodies_ask_for_goes_on_for_the_one_that_still_does(
    bpy: ModuleType, endless: Any, ball: Callable[..., Any]
) -> None:
    bodies = [ball("One"), ball("Two")]
    for obj in bodies:
        obj.data.materials.append(bpy.data.materials.new(obj.name))
        read(bpy, obj)
    (shared,) = endless._jobs.values()
    for obj, asked_for in zip(bodies, (True, False), strict=True):
        obj.active_material.dimple.K1 = 0.7
        read(bpy, obj)
        assert (endless._jobs.get(shared.name) is shared) is asked_for
