"""Colours on the surface say what the body does there, with a scale in units."""

from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.blender.test_overlay import SCREEN, SIZE, halves, on_screen, overlay, region, viewport  # noqa: F401


@pytest.fixture
def colours(bpy: ModuleType) -> ModuleType:
    from bl_ext.user_default.dimple.addon import surface_colours

    return surface_colours


@pytest.fixture
def colour_map(bpy: ModuleType) -> ModuleType:
    from bl_ext.user_default.dimple.addon import colour_map

    return colour_map


def lightness(colours: np.ndarray) -> np.ndarray:
    """Return CIE lightness L* of sRGB colours (n, 3)."""
    linear = np.where(colours > 0.04045, ((colours + 0.055) / 1.055) ** 2.4, colours / 12.92)
    y = linear @ np.array([0.2126, 0.7152, 0.0722])
    return np.where(y > 0.008856, 116 * np.cbrt(y) - 16, 903.3 * y)


def test_a_higher_number_has_a_lighter_colour_in_even_steps(colour_map: ModuleType) -> None:
    light = lightness(colour_map.table())
    assert (np.diff(light) > 0).all() and light[0] < 40 and light[-1] > 85
    steps = np.diff(light[::16])
    assert steps.max() < 2 * steps.min(), "no step looks larger than another"
    signed = lightness(colour_map.table(signed=True))
    assert signed.argmax() in (127, 128) and abs(signed[0] - signed[-1]) < 5


def test_a_scale_holds_still_until_what_it_shows_leaves_it(colours: ModuleType) -> None:
    colours._scales.clear()

    def ends(value: float) -> tuple[float, float]:
        return colours.scale_of("depth", [SimpleNamespace(values=np.array([0.0, -value]))])

    assert [ends(value) for value in (7.0, 5.0, 2.5)] == [(0.0, 8.0)] * 3
    assert ends(8.1) == (0.0, 10.0) and ends(2.0) == (0.0, 2.0) and ends(0.0) == (0.0, pytest.approx(0.1))
    assert colours.scale_of("stretch", [SimpleNamespace(values=np.array([3.0, -7.0]))]) == (-8.0, 8.0)


def pressed(bpy: ModuleType) -> Any:
    """Return the entry of the one session, pressed 15 mm deep from above."""
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import sessions

    (entry,) = sessions.sessions.values()
    for depth in (0.0, 0.015):
        entry.session.set_fingers([Finger((0.0, 0.0, 0.0825 + 0.02 - depth), 0.02)])
        entry.session.step(0.05)
    return entry


def looking_down(bpy: ModuleType) -> Any:
    from mathutils import Matrix

    return SimpleNamespace(view_matrix=Matrix.Identity(4))


def test_the_surface_is_drawn_in_the_colours_of_the_scale(
    bpy: ModuleType, colours: ModuleType, halves: Any  # noqa: F811
) -> None:
    entry = pressed(bpy)
    for name in ("pressure", "depth", "stretch"):
        seen_in_colours(bpy, colours, halves, entry, name)
    before = colours.made(halves.session_uid, entry, name)
    entry.session.step(0.05)
    assert colours.made(halves.session_uid, entry, name) is not before, "the next frame has colors of its own"


def seen_in_colours(bpy: ModuleType, colours: ModuleType, halves: Any, entry: Any, name: str) -> None:  # noqa: F811
    """Check what is drawn of one quantity."""
    import gpu

    each = colours.made(halves.session_uid, entry, name)
    assert len(each.values) == len(each.positions) and each.positions.max() == pytest.approx(1.0, abs=0.05)
    assert colours.made(halves.session_uid, entry, name) is each, "computed once a frame"
    assert each.positions.flags.c_contiguous and each.triangles.flags.c_contiguous, "Blender reads the bare memory"
    colours._scales.clear()
    ends = colours.scale_of(name, [each])
    assert ends[0] <= each.values.min() + 1e-9 or name == "depth"
    assert each.values.max() <= ends[1] * (1 + 1e-9)
    if not hasattr(gpu, "init"):
        return  # this Blender cannot draw without a window; 5.2 can
    gpu.init()
    from bl_ext.user_default.dimple.addon import colour_map

    flat = colours.Coloured(*each[:5], np.full(len(each.values), 0.75 * ends[1]))
    picture = on_screen(lambda _: None, lambda _: colours.draw_coloured(flat, ends, looking_down(bpy)))
    seen = picture[:, :, :3] / 255.0
    body = np.abs(seen - 0.2).max(axis=2) > 0.03
    assert body.mean() > 0.02, "it is seen"
    ratio = seen[body] / colour_map.coloured(np.array([0.75 * ends[1]]), ends, name in colours.SIGNED)
    assert (ratio.max(axis=1) < 1.02).all() and (ratio.min(axis=1) > 1 - colours.SHADE - 0.02).all(), "but for shade"
    covered = body[body.any(axis=1)][:, body.any(axis=0)]
    assert covered.mean() > 0.6, "without holes"


def test_the_scale_names_quantity_and_unit_and_shows_all_colours(
    bpy: ModuleType, colours: ModuleType, colour_map: ModuleType, overlay: ModuleType,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    import gpu

    if not hasattr(gpu, "init"):
        pytest.skip("this Blender cannot draw without a window; 5.2 can")
    gpu.init()
    canvas, written = overlay.canvas, []
    write = canvas.write
    monkeypatch.setattr(canvas, "write", lambda text, *rest: written.append(text) or write(text, *rest))
    free = overlay.Room(16.0, 32.0, 624.0, 384.0)
    picture = on_screen(lambda screen: colours.draw_scale("depth", (0.0, 20.0), free, screen))
    assert written == ["Depth (mm)", "0", "10", "20"]
    for colour in colour_map.table()[::64]:
        assert (np.abs(picture[:, :, :3] / 255.0 - colour).max(axis=2) < 0.03).sum() > 5, colour


def test_where_overlays_are_off_nothing_is_coloured_and_nothing_computed(
    bpy: ModuleType, colours: ModuleType, halves: Any, monkeypatch: pytest.MonkeyPatch  # noqa: F811
) -> None:
    drawn: list[str] = []
    for name in ("made", "draw_coloured", "draw_scale"):
        monkeypatch.setattr(colours, name, lambda *_, name=name: drawn.append(name))
    context = viewport(bpy, region=region("WINDOW", 0, 0, 1280, 800), region_data=None)
    monkeypatch.setattr(colours, "bpy", SimpleNamespace(context=context))
    monkeypatch.setattr(colours, "scale_of", lambda *_: (0.0, 1.0))
    bpy.context.scene.dimple.show_field = "DEPTH"
    colours._scales["depth"] = 1.0
    for shown, expected in ((False, []), (True, ["made", "draw_coloured", "draw_scale"])):
        context.space_data.overlay.show_overlays = shown
        colours.draw_surfaces()
        colours.draw_scales()
        assert drawn == expected
