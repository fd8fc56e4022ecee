"""Constants that are changed in the panels while a body runs act on it, and undo takes them back."""

import threading
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

FRAME_S = 1 / 60


@pytest.fixture
def entry(bpy: ModuleType, sessions: Any, vinyl: Any, cube: Any) -> Any:
    """The session of the vinyl cube, pressed 10 mm deep by a fingertip as the one that measured it, which rests."""
    from bl_ext.user_default.dimple.core.session import Finger

    body, _ = sessions.start(cube, bpy.context)
    top = body.link.scale
    for depth in (0.0, 0.01):
        step(bpy, 0.05, Finger((0.0, 0.0, top + 0.01 - depth), 0.01))
    step(bpy, 0.3)
    yield body
    sessions.stop_all()


def step(bpy: ModuleType, seconds: float = FRAME_S, finger: Any = None) -> list[str]:
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    messages = []
    for uid, body in list(sessions.sessions.items()):
        fingers = (finger,) if finger else body.session.fingers
        messages += live_step.advance(bpy.context, seconds, pressed={uid: fingers})
    return messages


def force(body: Any) -> float:
    return float(np.linalg.norm(body.frame.finger_forces[0]))


def test_k1_is_changed_while_the_fingertip_rests(bpy: ModuleType, entry: Any, vinyl: Any) -> None:
    first = force(entry)
    for K1, times in ((3.0, 3.0 / 0.61), (0.61, 1.0)):
        vinyl.K1 = K1
        assert step(bpy) == []
        assert force(entry) == pytest.approx(times * first, rel=1e-3), "one frame later"
        step(bpy, 0.5)
        assert force(entry) == pytest.approx(times * first, rel=1e-3), "and from then on"


def of_material(name: str, value: Any) -> Callable[[ModuleType], None]:
    return lambda bpy: setattr(bpy.context.object.active_material.dimple, name, value)


def of_body(name: str, value: Any) -> Callable[[ModuleType], None]:
    return lambda bpy: setattr(bpy.context.object.dimple, name, value)


def of_map(name: str) -> Callable[[ModuleType], None]:
    def paint(bpy: ModuleType) -> None:
        obj = bpy.context.object
        obj.vertex_groups.new(name="Painted").add(range(len(obj.data.vertices) // 2), 0.8, "REPLACE")
        setattr(obj.dimple, f"{name}_group", "Painted")

    return paint


def of_scene(name: str) -> Callable[[ModuleType], None]:
    return lambda bpy: setattr(bpy.context.scene.dimple, name, True)


# each changes its setting, and tells whether it has arrived in the model
CHANGES: dict[str, tuple[Callable[[ModuleType], None], Callable[[Any], bool]]] = {
    "K2": (of_material("K2", 3.0), lambda model: model.materials[0].K2 == 3000),
    "x0": (of_material("x0", 5.0), lambda model: model.materials[0].x0 == 0.005),
    "k": (of_material("k", 2.0), lambda model: model.materials[0].k == 2000),
    "mass": (of_material("mass_kg", 0.5), lambda model: abs(model.mass.sum() - 0.5) < 1e-9),
    "density": (of_material("mass_from", "DENSITY"), lambda model: model.materials[0].density == 100),
    "damping": (of_material("damping_ratio", 1.0), lambda model: model.materials[0].damping_ratio == 1),
    "friction": (of_material("friction", 0.0), lambda model: not model.friction.any()),
    "fill": (of_material("fill", "NONE"), lambda model: model.pressure.fill == "none"),
    "pressure": (of_material("pressure_kpa", 2.5), lambda model: model.pressure.rest_pressure == 2500),
    "spread": (of_material("spread_mm", 30.0), lambda model: model.materials[0].spread == 0.03),
    "softness map": (of_map("softness"), lambda model: np.ptp(model.maps.stiffer) > 0.1),
    "knee map": (of_map("knee"), lambda model: np.ptp(model.maps.deeper) > 0.1),
    "spread map": (of_map("spread"), lambda model: np.ptp(model.maps.wider) > 0.1),
    "gravity": (of_scene("use_gravity"), lambda model: model.gravity[2] < -9),
    "ground": (of_scene("use_ground"), lambda model: model.ground is not None),
    "pins": (of_body("pinned", False), lambda model: not model.pinned.any()),
    "size": (of_body("size_mm", 330.0), lambda model: model.mesh.size > 0.32),
}


@pytest.mark.parametrize("name", CHANGES)
def test_every_setting_of_a_body_acts_within_a_frame_and_comes_back_by_undo(
    bpy: ModuleType, entry: Any, cube: Any, name: str
) -> None:
    change, arrived = CHANGES[name]
    name_of, shown = cube.name, seen(cube)
    bpy.ops.ed.undo_push(message="Before")
    change(bpy)
    bpy.ops.ed.undo_push(message="Change")
    assert not arrived(entry.session.model)
    assert step(bpy, 0.0) == [] and arrived(entry.session.model)
    np.testing.assert_allclose(seen(cube), shown, atol=1e-6, err_msg="it has jumped")
    step(bpy)
    assert entry.frame.finite and not entry.frame.note
    bpy.ops.ed.undo()
    cube = bpy.data.objects[name_of]
    step(bpy)
    assert not arrived(entry.session.model), "undo takes it back"


def seen(obj: Any) -> np.ndarray:
    import bpy

    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    numbers = np.empty(3 * len(evaluated.vertices), np.float32)
    evaluated.vertices.foreach_get("co", numbers)
    return numbers.reshape(-1, 3)


def test_a_constant_that_cannot_be_is_refused_in_words_and_the_old_one_goes_on(
    bpy: ModuleType, entry: Any, vinyl: Any
) -> None:
    first = force(entry)
    vinyl.K1 = 0.0
    messages = step(bpy)
    assert len(messages) == 1 and "K1 must be greater than 0" in messages[0] and "keeps its old settings" in messages[0]
    assert step(bpy) == [] and entry.refused == messages[0], "it is said once, and shown as long as it is so"
    assert force(entry) == pytest.approx(first, rel=0.01)
    vinyl.K1 = 0.61
    step(bpy)
    assert not entry.refused


@pytest.fixture
def windowed(bpy: ModuleType, monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """A Blender that has a window, where every body is large; models are made once the event is set."""
    from bl_ext.user_default.dimple.core.body import model
    from bl_ext.user_default.dimple.operators.press import follow_settings

    real, may_go_on = model.build_model, threading.Event()

    class App:
        background = False

    class Window:
        app = App

        def __getattr__(self, name: str) -> Any:
            return getattr(bpy, name)

    def waits(*given: Any, **named: Any) -> Any:
        assert may_go_on.wait(60)
        return real(*given, **named)

    monkeypatch.setattr(model, "build_model", waits)
    monkeypatch.setattr(follow_settings, "bpy", Window())
    monkeypatch.setattr(follow_settings, "LARGE", 0)
    return may_go_on


def settle(bpy: ModuleType, body: Any) -> list[str]:
    """Step until no change is under way; return what was said."""
    messages, until = [], time.monotonic() + 60
    while body.change is not None and time.monotonic() < until:
        messages += step(bpy)
        time.sleep(0.001)
    assert body.change is None
    return messages


def test_a_large_body_runs_on_while_its_constants_are_prepared_and_the_last_choice_holds(
    bpy: ModuleType, entry: Any, vinyl: Any, windowed: threading.Event
) -> None:
    first, at = force(entry), entry.frame.time
    for K1 in (2.0, 3.0):  # a slider that is dragged
        vinyl.K1 = K1
        assert step(bpy) == [] and entry.change is not None
    assert force(entry) == pytest.approx(first, rel=1e-3) and entry.frame.time > at, "it goes on as it was"
    windowed.set()
    assert settle(bpy, entry) == [] and entry.session.model.materials[0].K1 == pytest.approx(2000)
    step(bpy)
    settle(bpy, entry)
    assert entry.session.model.materials[0].K1 == pytest.approx(3000)
    step(bpy)
    assert force(entry) == pytest.approx(3.0 / 0.61 * first, rel=1e-3)


def test_what_a_large_body_cannot_be_is_refused_and_one_that_ends_meanwhile_is_let_go(
    bpy: ModuleType, entry: Any, vinyl: Any, cube: Any, sessions: Any, windowed: threading.Event
) -> None:
    before = entry.session.model
    windowed.set()
    vinyl.mass_from, vinyl.mass_kg, vinyl.K2 = "MASS", 1e-9, 1e5
    (refused,) = [*step(bpy), *settle(bpy, entry)]
    assert "Until then the body keeps its old settings" in refused and entry.session.model is before
    windowed.clear()
    vinyl.mass_kg, vinyl.K2 = 0.2, 7.23
    step(bpy)
    vinyl.K1 = 3.0
    step(bpy)
    sessions.stop_all()
    windowed.set()
    assert sessions.get(cube) is None


def test_another_choice_of_what_is_simulated_is_taken_while_it_runs(bpy: ModuleType, ball: Any, sessions: Any) -> None:
    obj = ball(subdivisions=4)
    bpy.context.scene.dimple.use_gravity = True
    body, _ = sessions.start(obj, bpy.context)
    step(bpy, 0.05)
    assert body.session.proxy is None
    obj.dimple.simulated, obj.dimple.proxy_vertices = "PROXY", 300
    before = seen(obj)
    step(bpy, 0.001)
    assert body.session.proxy is not None and body.frame.time == pytest.approx(0.051)
    assert np.abs(seen(obj) - before).max() < 2e-3
    sessions.stop_all()


def test_undo_passes_for_whatever_was_changed_in_a_panel_and_not_for_what_a_key_chose(
    bpy: ModuleType, hand: Any, ball: Any
) -> None:
    obj, poke = ball(), hand("poke")
    poke.invoke()
    poke.ticks(2)
    poke.send("TWO")
    poke.ticks(2)
    assert poke.send("Z", ctrl=True) == {"RUNNING_MODAL"}
    changes = [(obj.dimple, "collider_friction", 0.1), (obj.dimple, "prop_mass_kg", 3.0)]
    changes += [(bpy.context.scene.dimple, name, 3.0) for name in ("finger_radius_mm", "press_force_n")]
    for settings, name, value in changes:
        before = getattr(settings, name)
        setattr(settings, name, value)
        poke.ticks(1)
        assert poke.send("Z", ctrl=True) == {"PASS_THROUGH"}, name
        setattr(settings, name, before)
        poke.ticks(1)
        assert poke.send("Z", ctrl=True) == {"RUNNING_MODAL"}, "what was done before stays"
    poke.send("ESC")


def test_another_size_lifts_the_fingertip_of_a_poke(bpy: ModuleType, hand: Any, ball: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    obj, poke = ball(), hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(20)
    body = sessions.get(obj)
    assert body.frame.depths[0] > 0.01
    obj.dimple.size_mm = 40.0
    poke.ticks(60)
    assert body.session.model.mesh.size == pytest.approx(0.04) and not body.frame.depths.any()
    assert np.abs(seen(obj) - body.link.rest).max() < 0.05, "it has sprung back"
    poke.send("ESC")


def test_softness_is_painted_while_the_fingertip_rests(bpy: ModuleType, entry: Any, cube: Any) -> None:
    group = cube.vertex_groups.new(name="Soft")
    everywhere = list(range(len(cube.data.vertices)))
    group.add(everywhere, 0.5, "REPLACE")
    cube.dimple.softness_group = "Soft"
    step(bpy)
    before = force(entry)
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    try:
        group = cube.vertex_groups["Soft"]
        assert step(bpy) == [] and entry.frame.time > 0, "the session goes on"
        group.add(everywhere, 1.0, "REPLACE")
        for _ in range(3):
            step(bpy, 0.1)
        assert force(entry) == pytest.approx(before / 4, rel=0.01), "four times softer"
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
    assert step(bpy) == []


def test_a_map_may_be_an_attribute(bpy: ModuleType, entry: Any, cube: Any) -> None:
    values = cube.data.attributes.new("soft", "FLOAT", "POINT")
    cube.dimple.softness_group = "soft"
    values.data.foreach_set("value", [1.0] * len(cube.data.vertices))
    before = entry.session.model.matching.k1.sum()
    step(bpy)
    assert entry.session.model.matching.k1.sum() == pytest.approx(before / 4) and not entry.refused
    cube.dimple.softness_group = ""


def test_a_poke_lets_the_brush_have_the_mouse(bpy: ModuleType, hand: Any, ball: Any) -> None:
    obj, poke = ball(), hand("poke")
    poke.invoke()
    obj.vertex_groups.new(name="Soft")
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    try:
        for kind in ("LEFTMOUSE", "MOUSEMOVE", "F", "ONE"):
            assert poke.send(kind) == {"PASS_THROUGH"}
        assert poke.ticks(3) == {"PASS_THROUGH"}
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
    assert poke.send("ESC") == {"CANCELLED"}


def test_what_plays_follows_a_keyframe_when_the_frame_changes(bpy: ModuleType, entry: Any, vinyl: Any) -> None:
    for frame, value in ((1, 0.61), (10, 3.0)):
        vinyl.K1 = value
        vinyl.keyframe_insert("K1", frame=frame)
    bpy.context.scene.frame_set(10)
    step(bpy)
    assert entry.session.model.materials[0].K1 == 3000 and not entry.frame.note
    bpy.context.scene.frame_set(1)
    step(bpy)
    assert entry.session.model.materials[0].K1 == 610


def test_a_material_that_is_deleted_while_it_acts_is_said(
    bpy: ModuleType, vinyl: Any, cube: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    vinyl.K1 = 2.0
    bpy.ops.dimple.play(seconds=0.01)
    bpy.data.materials.remove(cube.active_material)
    bpy.ops.dimple.play(seconds=0.01)
    assert "a material was removed: the constants of a new one act in its place" in capfd.readouterr().out
    bpy.ops.dimple.reset()
