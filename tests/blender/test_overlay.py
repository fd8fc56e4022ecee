"""What is drawn over the viewport agrees with the frame, and nothing is drawn when nothing runs."""

import itertools
import json
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

SIZE = (640, 400)
SCREEN = SimpleNamespace(width=SIZE[0], height=SIZE[1], scale=1.0, line=2.0)


def viewport(bpy: ModuleType, **context: Any) -> Any:
    """Return the context of a 3D viewport, which background Blender does not have."""
    system = SimpleNamespace(ui_scale=1.5, pixel_size=2.0)
    return SimpleNamespace(**{
        "scene": bpy.context.scene, "object": None, "region": region("WINDOW", 0, 0, *SIZE),
        "area": SimpleNamespace(regions=[]), "preferences": SimpleNamespace(system=system),
        "space_data": SimpleNamespace(
            overlay=SimpleNamespace(show_overlays=True, show_text=True), region_quadviews=[], show_region_ui=False
        ), **context,
    })  # fmt: skip


def region(kind: str, x: int, y: int, width: int, height: int, tab: str = "") -> Any:
    return SimpleNamespace(type=kind, x=x, y=y, width=width, height=height, active_panel_category=tab)


@pytest.fixture
def overlay(bpy: ModuleType) -> ModuleType:
    from bl_ext.user_default.dimple.addon import overlay

    return overlay


@pytest.fixture
def shapes(bpy: ModuleType) -> ModuleType:
    from bl_ext.user_default.dimple.addon import shapes

    return shapes


@pytest.fixture
def entry(bpy: ModuleType) -> Any:
    """A session as the overlay sees it: a fingertip 12 mm in a body that is twelve times as large in the scene."""
    from bl_ext.user_default.dimple.core.everyday_presets import OBJECTS
    from bl_ext.user_default.dimple.core.session import Finger

    material = next(each.material for each in OBJECTS if each.name == "object_2_vinyl_air")
    frame = SimpleNamespace(
        finger_forces=np.array([(0.0, 0.0, 7.4)]), pushes=np.array([7.4]), depths=np.array([0.012]),
        materials=(0,), pressure=812.0, time=1.25, volume=0.0044, rest_volume=0.0045,
        substeps=12, steps=33, cost=0.011, note="",
    )  # fmt: skip
    return SimpleNamespace(
        link=SimpleNamespace(slots=(0,), scale=1 / 12), frame=frame, refused="",
        fingers=(Finger((0.0, 0.0, 0.05), 0.01), None, None),
        session=SimpleNamespace(
            clock=SimpleNamespace(tick=1e-3), contact_note="", held_note="", fingers=(Finger((0.0, 0.0, 0.05), 0.02),),
            law=lambda index, depths: [1.5 * material.law(depth) for depth in depths],
            model=SimpleNamespace(materials=(material,), notes=("An open mesh.",))
        ),
        to_world=lambda point: tuple(12 * c for c in point),
    )  # fmt: skip


def test_without_a_session_nothing_is_drawn_and_gpu_is_not_asked(
    overlay: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("gpu", "blf"):
        monkeypatch.setitem(sys.modules, name, None)  # an import of it fails
    overlay.draw_bodies()
    overlay.draw_numbers()


def test_force_and_depth_stand_first_and_the_read_out_carries_every_other_number_with_its_unit(entry: Any) -> None:
    from bl_ext.user_default.dimple.addon import readout

    assert readout.rows(entry.frame) == [("Force 1", "7.40 N"), ("Depth 1", "12.00 mm")]
    assert readout.more_rows(entry.frame, 1e-3) == [
        ("Pressure", "0.812 kPa"), ("Volume", "4400.0 cm³"), ("Change of Volume", "-2.22%"), ("Time", "1.250 s"),
        ("Real Time", "100%"),
    ]  # fmt: skip
    slow = SimpleNamespace(**{**vars(entry.frame), "steps": 3, "depths": [-0.01], "pushes": [0.0]})
    assert readout.real_time(slow, 1e-3) == ("Real Time", "27%"), "a computer too slow for real time says so"
    assert readout.rows(slow) == [("Force 1", "0.00 N"), ("Depth 1", "0.00 mm")], "what is below stays in its place"


def test_the_curve_behind_the_chart_is_the_law_of_the_core(shapes: ModuleType, entry: Any) -> None:
    hollow = entry.session.model.materials[0]
    solid = replace(hollow, fill="solid", indenter=type(hollow.indenter)(shape="sphere", radius=0.01))
    for material, depths in itertools.product((hollow, solid), (0.5, 1.0, 3.0)):
        deepest = depths * material.x0
        curve = shapes.law_curve((material.K1, material.K2, material.x0, material.power), deepest)
        assert curve[0] == (0, 0) and curve[-1][0] == pytest.approx(deepest)
        for depth, force in curve:
            assert force == pytest.approx(material.law(depth), abs=1e-12)


def test_the_chart_of_a_calibration_shows_the_measured_points_and_leaves_their_colours(
    overlay: ModuleType, empty_file: ModuleType
) -> None:
    import gpu

    bpy = empty_file
    assert overlay.force_chart.calibrated_curves(bpy.context) is None
    sample = Path(__file__).parents[2] / "blend_samples" / "calibration" / "object_2_vinyl_air.csv"
    bpy.ops.dimple.calibrate(filepath=str(sample))
    curves = overlay.force_chart.calibrated_curves(bpy.context)
    assert len(curves.measured) > 50 and curves.law[0] == pytest.approx(611, rel=0.01)
    K1, K2, x0, _ = curves.law
    for depth, force in curves.measured:  # the sample has 1 % of 51.5 N of noise on the law
        assert abs(force - (K1 * min(depth, x0) + K2 * max(depth - x0, 0))) < 5 * 0.515
    low, high = curves.band
    for (depth, least), (_, most) in zip(low[1:], high[1:], strict=True):
        law = K1 * min(depth, x0) + K2 * max(depth - x0, 0)
        assert 0.9 * law < least < law < most < 1.1 * law, "the sample gives the law to a few percent"
    bpy.context.scene.dimple.show_chart = False
    assert overlay.force_chart.calibrated_curves(bpy.context) is None
    if not hasattr(gpu, "init"):
        pytest.skip("this Blender cannot draw without a window; 5.2 can")
    gpu.init()

    def draw(screen: Any) -> None:
        overlay.force_chart.draw_curves(curves, (20.0, 20.0), screen)

    picture = on_screen(draw)
    chart = overlay.force_chart
    for colour in (chart.LAW, chart.MEASURED):
        seen = abs(picture[:, :, :3] / 255.0 - colour[:3]).max(axis=2) < 0.12
        assert seen.sum() > 20, colour


def test_a_session_is_drawn_only_where_overlays_are_switched_on(
    bpy: ModuleType, overlay: ModuleType, halves: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(overlay, "draw_fingers", lambda *_: drawn.append("fingers"))
    monkeypatch.setattr(overlay.force_chart, "draw_curves", lambda *_: drawn.append("curves") or 0.0)
    monkeypatch.setattr(overlay, "draw_rows", lambda *_, **__: drawn.append("rows") or 0.0)
    context = viewport(bpy, region=region("WINDOW", 0, 0, 1280, 800))
    monkeypatch.setattr(overlay, "bpy", SimpleNamespace(context=context))
    for shown, expected in ((False, []), (True, ["fingers", "curves", "rows"])):
        context.space_data.overlay.show_overlays = shown
        overlay.draw_bodies()
        overlay.draw_numbers()
        assert drawn == expected


def test_of_several_bodies_those_that_are_pressed_have_a_chart(
    bpy: ModuleType, overlay: ModuleType, entry: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    resting = SimpleNamespace(frame=SimpleNamespace(depths=[-0.01, 0.0]))
    still, hit = ("Still", resting), ("Hit", entry)
    for shown, expected in (([still], ["Still"]), ([still, still], []), ([still, hit], ["Hit"])):
        drawn: list[str] = []
        monkeypatch.setattr(overlay, "shown_bodies", lambda _, shown=shown: shown)
        monkeypatch.setattr(overlay.force_chart, "pressed_curves", lambda body, _: body)
        monkeypatch.setattr(overlay.force_chart, "draw_curves", lambda body, *_, drawn=drawn: drawn.append(body) or 0.0)
        monkeypatch.setattr(overlay, "draw_rows", lambda *_, **__: 0.0)
        context = viewport(bpy, region=region("WINDOW", 0, 0, 1280, 800))
        monkeypatch.setattr(overlay, "bpy", SimpleNamespace(context=context))
        overlay.draw_numbers()
        assert drawn == expected


@pytest.fixture
def halves(empty_file: ModuleType) -> Any:
    """A cube with a physical size of 165 mm, soft but for its top, and a session on it."""
    from bl_ext.user_default.dimple.operators.press import sessions

    bpy = empty_file
    bpy.ops.mesh.primitive_cube_add()
    body = bpy.context.object
    for name, stiffness in (("Unused", 3.0), ("Soft", 0.5), ("Hard", 2.0)):
        body.data.materials.append(bpy.data.materials.new(name))
        body.data.materials[-1].dimple.K1 = stiffness
    for polygon in body.data.polygons:
        polygon.material_index = 2 if polygon.normal.z > 0.5 else 1
    body.dimple.size_mode = "CUSTOM"
    sessions.start(body, bpy.context)
    yield body
    sessions.stop_all()


def test_the_chart_shows_the_law_and_the_measurement_of_the_material_that_is_pressed(
    bpy: ModuleType, overlay: ModuleType, halves: Any
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import sessions

    for name, force in (("Unused", 1.0), ("Soft", 2.0), ("Hard", 3.0)):
        bpy.data.materials[name].dimple.calibration = json.dumps({"points": [[1.0, force]], "contact": 0, "tare": 0})
    (entry,) = sessions.sessions.values()
    for index, K1 in ((1, 500.0), (2, 2000.0)):
        halves.active_material_index = index
        law = overlay.force_chart.pressed_curves(halves, entry).law
        assert law[0] == K1, "nothing is pressed: of the active material"
    reach = 0.0825 + 0.010 - 0.002
    for place, K1, force in (((0.0, 0.0, reach), 2000.0, 3.0), ((reach, 0.0, 0.0), 500.0, 2.0)):
        entry.session.set_fingers([])  # or the fingertip would be dragged through the cube
        entry.session.set_fingers([None, Finger(place, 0.010)])
        entry.session.step(0.002)
        curves = overlay.force_chart.pressed_curves(halves, entry)
        assert curves.law[0] == K1 and curves.measured == [(0.001, force)]
        depth, push = curves.fingertip
        assert push == pytest.approx(K1 * depth) and depth > 0.001 and not curves.here, "it is on the law"


def test_the_chart_draws_what_acts_here_and_calls_another_tips_curve_a_prediction(
    bpy: ModuleType, overlay: ModuleType, halves: Any
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import follow_settings, sessions

    (entry,) = sessions.sessions.values()
    halves.vertex_groups.new(name="Hard").add(range(8), 0.0, "REPLACE")
    for radius, painted, name, times in ((0.010, False, "", 1), (0.020, False, "Predicted for 20 mm", None),
                                         (0.010, True, "As Painted", 4)):  # fmt: skip
        halves.dimple.softness_group = "Hard" if painted else ""
        follow_settings.follow(bpy.context, halves, entry)
        entry.session.set_fingers([])
        entry.session.step(1.0)  # for the dent of the one before to come back
        entry.session.set_fingers([Finger((0.0, 0.0, 0.0825 + radius - 0.002), radius)])
        entry.session.step(0.002)
        curves = overlay.force_chart.pressed_curves(halves, entry)
        assert curves.name == name and bool(curves.here) == bool(name)
        depth, push = curves.fingertip
        if name:
            predicted = np.interp(depth, *zip(*curves.here, strict=True))
            assert push == pytest.approx(predicted, rel=0.01), "the fingertip is on it"
        if times:
            assert push == pytest.approx(times * 2000 * depth, rel=1e-3)
        else:
            assert push > 1.02 * 2000 * depth, "it is the wider"


def test_over_the_viewport_stand_warnings_and_no_notes(
    overlay: ModuleType, entry: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.reporting import Note

    entry.session.model.notes += (Note("It is simulated finer."),)
    written = lines_of(overlay, monkeypatch)
    overlay.draw_rows(SimpleNamespace(name="Ball"), entry, overlay.Room(0.0, 0.0, *SIZE), 1.0)
    texts = [text for text, _, _ in written]
    assert "An open mesh." in texts and "It is simulated finer." not in texts


def test_numbers_are_written_as_the_theme_writes_on_what_sets_them_off(bpy: ModuleType, overlay: ModuleType) -> None:
    space, canvas = bpy.context.preferences.themes[0].view_3d.space, overlay.canvas
    before = tuple(space.text_hi)
    try:
        for light in (1.0, 0.0):
            space.text_hi = [light] * 3
            assert canvas.ink()[:3] == canvas.faint()[:3] == (light,) * 3
            assert canvas.paper()[:3] == (1 - light,) * 3
    finally:
        space.text_hi = before


def test_an_arrow_points_along_the_force_and_a_stronger_one_is_longer(shapes: ModuleType) -> None:
    assert shapes.arrow((0, 0, 0), (0, 0, 0), 1) == []
    lengths = []
    for newtons in (0.5, 1.0, 4.0, 1e9):
        start, tip = shapes.arrow((1.0, 2.0, 3.0), (0.0, -newtons, 0.0), 0.1)[0]
        assert start == pytest.approx((1.0, 1.9, 3.0)) and tip[0] == 1.0 and tip[2] == 3.0
        lengths.append(start[1] - tip[1])
    assert lengths[0] < lengths[1] < lengths[2] < lengths[3] == pytest.approx(0.1 * shapes.ARROW_LONGEST)


def test_a_fingertip_is_drawn_as_large_as_it_is(shapes: ModuleType) -> None:
    centre, radius = (0.0, 0.0, 0.6), 0.12
    from_front = ((1.0, 0.0, 0.0, 0.3), (0.0, 0.0, 1.0, 0.2))
    points = [point for line in shapes.outline(centre, radius, from_front) for point in line]
    assert [math.dist(point, centre) for point in points] == pytest.approx([radius] * len(points))
    for axis, reach in enumerate((radius, 0.0, radius)):
        assert max(point[axis] for point in points) == pytest.approx(centre[axis] + reach)


def test_the_chart_the_numbers_and_the_fingertip_leave_their_colours(
    overlay: ModuleType, entry: Any, bpy: ModuleType
) -> None:
    import gpu

    if not hasattr(gpu, "init"):
        pytest.skip("this Blender cannot draw without a window; 5.2 can")
    gpu.init()
    picture = drawn(overlay, entry)
    for colour in (overlay.FINGERTIP, overlay.FORCE, overlay.force_chart.LAW, overlay.canvas.ink()):
        seen = abs(picture[:, :, :3] / 255.0 - colour[:3]).max(axis=2) < 0.12
        assert seen.sum() > 20, colour


def drawn(overlay: ModuleType, entry: Any) -> Any:
    """Draw a session into a picture (height, width, 4) of bytes."""

    def draw(screen: Any) -> None:
        body = SimpleNamespace(name="Ball", material_slots=())
        end = overlay.force_chart.draw_curves(overlay.force_chart.pressed_curves(body, entry), (20.0, 20.0), screen)
        overlay.draw_rows(body, entry, overlay.Room(20.0, end + 16, *SIZE), 1.0)

    return on_screen(draw, lambda screen: overlay.draw_fingers(entry, screen))


def on_screen(
    draw: Callable[[Any], None], draw_in_scene: Callable[[Any], None] | None = None, *, screen: Any = SCREEN
) -> Any:
    """Draw into a picture (height, width, 4) of bytes: in the scene, then on top of it in pixels."""
    import gpu
    from mathutils import Matrix

    target = gpu.types.GPUOffScreen(*SIZE)
    with target.bind(), gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        buffer = gpu.state.active_framebuffer_get()
        buffer.clear(color=(0.2, 0.2, 0.2, 1.0), depth=1.0)
        gpu.matrix.load_matrix(Matrix.Rotation(math.radians(-70), 4, "X"))
        gpu.matrix.load_projection_matrix(Matrix.Diagonal((1 / 1.6, 1, 0.1, 1)))
        if draw_in_scene:
            draw_in_scene(screen)
        gpu.matrix.load_matrix(Matrix.Identity(4))
        to_screen = Matrix.Translation((-1, -1, 0)) @ Matrix.Diagonal((2 / SIZE[0], 2 / SIZE[1], 0.1, 1))
        gpu.matrix.load_projection_matrix(to_screen)
        draw(screen)
        pixels = buffer.read_color(0, 0, *SIZE, 4, 0, "UBYTE")
    target.free()
    pixels.dimensions = SIZE[0] * SIZE[1] * 4
    return np.array(pixels, np.uint8).reshape(SIZE[1], SIZE[0], 4)


def lines_of(overlay: ModuleType, monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, float, float]]:
    """Return what is written from now on: text and where it ends, to the right and above."""
    written: list[tuple[str, float, float]] = []

    def write(text: str, at: Any, scale: float, _colour: Any = None) -> float:
        written.append((text, at[0] + 7 * scale * len(text), at[1] + overlay.LINE_HEIGHT * scale))
        return 7 * scale * len(text)

    for name in ("draw_lines", "draw_filled"):
        monkeypatch.setattr(overlay.canvas, name, lambda *_: None)
    monkeypatch.setattr(overlay.canvas, "write", write)
    monkeypatch.setattr(overlay.canvas, "width", lambda text, scale: 7 * scale * len(text))
    return written


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_numbers_and_chart_stay_clear_of_header_toolbar_and_sidebar(
    bpy: ModuleType, overlay: ModuleType, halves: Any, monkeypatch: pytest.MonkeyPatch, scale: float
) -> None:
    written = lines_of(overlay, monkeypatch)
    around = [
        region("TOOLS", 0, 0, 60, SIZE[1]), region("UI", SIZE[0] - 200, 0, 200, SIZE[1], "Item"),
        region("HEADER", 0, SIZE[1] - 30, SIZE[0], 30), region("TOOL_HEADER", 0, SIZE[1] - 60, SIZE[0], 30),
    ]  # fmt: skip
    context = viewport(bpy, area=SimpleNamespace(regions=around))
    context.preferences.system.ui_scale = scale
    monkeypatch.setattr(overlay, "bpy", SimpleNamespace(context=context))
    overlay.draw_numbers()
    blenders = 3 * overlay.LINE_HEIGHT * scale  # its own words below the header
    assert len(written) > 2 and all(top <= SIZE[1] - 60 - blenders for _, _, top in written)
    chart = any(text.endswith(" mm") and ":" not in text for text, _, _ in written)  # its axis
    assert chart == (scale == 1.0), "at twice the scale there is no room for the chart beside the sidebar"


def test_of_four_views_one_has_the_numbers(
    bpy: ModuleType, overlay: ModuleType, halves: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = lines_of(overlay, monkeypatch)
    views = [region("WINDOW", x, y, 320, 200) for x in (0, 321) for y in (0, 201)]
    seen = []
    for view in views:
        context = viewport(bpy, region=view, area=SimpleNamespace(regions=views))
        context.space_data.region_quadviews = [1, 2, 3]
        monkeypatch.setattr(overlay, "bpy", SimpleNamespace(context=context))
        overlay.draw_numbers()
        seen.append(bool(written))
        written.clear()
    assert seen == [False, False, False, True]


def test_a_pause_and_a_slow_blender_are_said_beside_the_numbers(
    bpy: ModuleType, overlay: ModuleType, halves: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    monkeypatch.setattr(overlay, "runs", [SimpleNamespace(paused=True)])
    monkeypatch.setattr(haptic_fingertips, "connections", [SimpleNamespace(slow=True)])
    written = lines_of(overlay, monkeypatch)
    monkeypatch.setattr(overlay, "bpy", SimpleNamespace(context=viewport(bpy, object=halves)))
    overlay.draw_numbers()
    texts = " ".join(text for text, _, _ in written)
    assert all(each in texts for each in ("Paused", "Blender draws too slowly", "Force 1"))
