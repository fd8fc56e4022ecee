"""Every property, operator and icon that the panels name exists in this Blender."""

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

SAMPLE = Path(__file__).parents[2] / "blend_samples" / "calibration" / "object_2_vinyl_air.csv"


class Layout:
    """A replacement for a panel's layout, which background Blender does not have; it records what is drawn."""

    def __init__(self, bpy: ModuleType, drawn: list[str]) -> None:
        self.__dict__.update(bpy=bpy, drawn=drawn)
        self.__dict__["icons"] = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items

    def note(self, text: str, options: dict[str, Any]) -> None:
        assert options.get("icon", "NONE") in self.icons
        accepted = {"text", "icon", "translate", "slider", "depress", "heading", "align", "factor", "expand", "index"}
        assert options.keys() <= accepted, options
        self.drawn.append(text)

    def row(self, **options: Any) -> "Layout":
        self.note("", options)
        return self

    column = box = split = row

    def label(self, **options: Any) -> None:
        self.note(options["text"], options)

    progress = label

    def prop(self, data: Any, name: str, **options: Any) -> None:
        assert name in data.bl_rna.properties, name
        self.note(f"{data.bl_rna.identifier}.{name}", options)

    def template_icon_view(self, data: Any, name: str, **options: Any) -> None:
        assert options.keys() <= {"show_labels", "scale", "scale_popup"}
        self.prop(data, name)

    def prop_search(self, data: Any, name: str, source: Any, among: str, **options: Any) -> None:
        assert among in source.bl_rna.properties
        self.prop(data, name, **options)

    def operator(self, idname: str, **options: Any) -> Any:
        module, _, name = idname.partition(".")
        kind = getattr(getattr(self.bpy.ops, module), name).get_rna_type()
        self.note(idname, options)
        button = SimpleNamespace()
        self.drawn.append(button)  # its properties are set after this returns
        button.allowed = set(kind.properties.keys())
        return button

    def popover(self, **options: Any) -> None:
        assert hasattr(self.bpy.types, options["panel"])


def panels(bpy: ModuleType) -> Iterator[type]:
    for name in dir(bpy.types):
        if name.startswith("DIMPLE_PT_") and name != "DIMPLE_PT_material_presets":
            yield getattr(bpy.types, name)


def draw(bpy: ModuleType, panel: type, **context: Any) -> list[str]:
    """Draw a panel and return what it shows."""
    here = {name: getattr(bpy.context, name) for name in ("scene", "window_manager")}
    here |= {"object": None, "material": None, "region": SimpleNamespace(width=400)}
    here |= {"space_data": SimpleNamespace(active_operator=None), "area": SimpleNamespace(as_pointer=lambda: 1)}
    here["preferences"] = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))  # 0 in the background
    shown = SimpleNamespace(**{**here, **context})
    drawn: list[Any] = []
    this = SimpleNamespace(layout=Layout(bpy, drawn))
    if hasattr(panel, "poll") and not panel.poll(shown):
        return []
    for name in ("draw_header", "draw_header_preset", "draw"):
        if name in panel.__dict__:
            panel.__dict__[name](this, shown)
    for button in (each for each in drawn if isinstance(each, SimpleNamespace)):
        assert set(vars(button)) - {"allowed"} <= button.allowed
    return [each for each in drawn if isinstance(each, str)]


@pytest.fixture
def body(empty_file: ModuleType) -> Any:
    """A cube with a material."""
    bpy = empty_file
    bpy.ops.mesh.primitive_cube_add()
    made = bpy.context.object
    made.data.materials.append(bpy.data.materials.new("Skin"))
    return made


def test_every_panel_draws_on_a_mesh_on_nothing_and_on_a_curve(bpy: ModuleType, body: Any) -> None:
    curve = bpy.data.objects.new("Curve", bpy.data.curves.new("Curve", "CURVE"))
    found = list(panels(bpy))
    assert len(found) >= 11
    places = ({}, {"object": body, "material": body.active_material}, {"object": curve})
    drawn = {panel.__name__ for panel in found for place in places if draw(bpy, panel, **place)}
    # for something that runs, a calibration, below, and a file browser
    waiting = {"state", "calibration_notes", "still_warning"}
    assert drawn == {panel.__name__ for panel in found} - {f"DIMPLE_PT_{name}" for name in waiting}


def test_a_running_session_shows_force_depth_pressure_and_volume_with_units(bpy: ModuleType, body: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    body.dimple.size_mode = "CUSTOM"
    entry, _ = sessions.start(body, bpy.context)
    try:
        from bl_ext.user_default.dimple.core.session import Finger

        entry.session.set_fingers([Finger((0.0, 0.0, 0.0875), 0.01)])
        entry.session.step(0.01)
        rows = " ".join(draw(bpy, bpy.types.DIMPLE_PT_readout, object=body))
        for unit in (" N", " mm", " kPa", " cm³"):
            assert unit in rows, rows
    finally:
        sessions.stop_all()
    assert "Nothing is being pressed" in draw(bpy, bpy.types.DIMPLE_PT_readout, object=body)


@pytest.mark.parametrize("shape, said", [("CUBE", True), ("EMPTY", False)])
def test_a_mesh_as_a_fingertip_is_said_to_press_as_a_ball(bpy: ModuleType, shape: str, said: bool) -> None:
    mesh = bpy.data.meshes.new("Knuckle") if shape == "CUBE" else None
    bpy.context.scene.dimple.finger_1 = bpy.data.objects.new("Knuckle", mesh)
    drawn = draw(bpy, bpy.types.DIMPLE_PT_fingertips)
    assert (" ".join(drawn).find("presses like a ball of the tool's radius, whatever its shape") > 0) == said


def test_a_calibration_shows_its_constants_with_errors_and_the_just_noticeable_difference(
    bpy: ModuleType, body: Any
) -> None:
    panel = bpy.types.DIMPLE_PT_calibration
    assert "dimple.calibrate" in " ".join(draw(bpy, panel, object=body))
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE), length_mm=165)
    pending = draw(bpy, panel, object=body)
    for text in (
        "K1",
        "0.6106 ± 0.0073 N/mm",
        "7.225 ± 0.070 N/mm",
        "16.317 ± 0.039 mm",
        "1.0% of full scale",
        "6% – 8%",
    ):
        assert text in pending, text
    assert "k, Force Balance" in pending and "dimple.apply_calibration" in pending
    words = " ".join(draw(bpy, bpy.types.DIMPLE_PT_calibration_notes, object=body))
    assert "assumed to carry all of the force" in words
    bpy.ops.dimple.apply_calibration()
    assert [text for text in pending if "±" in text] == [
        text for text in draw(bpy, panel, object=body) if "±" in text
    ], "the material shows what it was given"
    before = " ".join(draw(bpy, panel, object=body))
    body.active_material.dimple.K1 = 2.0
    edited = "The constants were edited and no longer match their source."
    assert edited not in before and edited in " ".join(draw(bpy, panel, object=body))
    assert edited in " ".join(draw(bpy, bpy.types.DIMPLE_PT_material, material=body.active_material))


def test_the_plan_is_shown_with_its_reason(bpy: ModuleType, body: Any) -> None:
    settings, panel = body.dimple, bpy.types.DIMPLE_PT_reduction
    assert "DIMPLE_PG_object.simulated" in draw(bpy, panel, object=body)
    settings.plan_reason = "The full mesh runs live: 8 vertices at 1 steps per millisecond."
    assert "8 vertices at 1 steps per millisecond." in " ".join(draw(bpy, panel, object=body))


def test_the_sidebar_is_in_the_order_of_work_and_the_laboratory_is_closed(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon import panels

    first = [panel for panel in panels._SIDEBAR if not hasattr(panel, "bl_parent_id")]
    assert [panel.bl_label for panel in first] == [
        "Press", "Material", "Fingertips", "Animate", "Display", "Calibration", "Haptic Device", "Sensory Comparison"
    ]  # fmt: skip
    assert not any("DEFAULT_CLOSED" in getattr(panel, "bl_options", ()) for panel in first[:4])
    children = [panel for panel in panels._SIDEBAR if panel not in first]
    assert all("DEFAULT_CLOSED" in getattr(panel, "bl_options", ()) for panel in [*first[4:], *children])


def test_what_is_open_says_softness_and_the_constants_are_folded_away(bpy: ModuleType, body: Any) -> None:
    shown = " ".join(draw(bpy, bpy.types.DIMPLE_PT_object_material, object=body))
    assert "DIMPLE_PG_object.material" in shown and "DIMPLE_PG_material.softness_mm" in shown
    folded = " ".join(draw(bpy, bpy.types.DIMPLE_PT_object_constants, object=body))
    for name in ("K1", "K2", "x0", "damping_ratio"):
        assert f"DIMPLE_PG_material.{name}" not in shown and f"DIMPLE_PG_material.{name}" in folded


def test_a_mesh_without_a_material_is_offered_the_pictures_too(bpy: ModuleType, empty_file: ModuleType) -> None:
    bare = bpy.data.objects.new("Bare", bpy.data.meshes.new("Bare"))
    drawn = draw(bpy, bpy.types.DIMPLE_PT_object_material, object=bare)
    assert "DIMPLE_PG_object.material" in drawn and "DIMPLE_PG_material.softness_mm" not in drawn
    assert draw(bpy, bpy.types.DIMPLE_PT_object_constants, object=bare) == []


def test_sentences_are_broken_where_a_sidebar_ends(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators.reporting import wrapped

    assert wrapped("The body is held by its rim", 12) == ["The body is", "held by its", "rim"]
    assert wrapped("A residual of 63 N at 20 mm", 16) == ["A residual of", "63 N at 20 mm"]
    assert wrapped("押したいメッシュ", 8) == ["押したい", "メッシュ"]
    assert wrapped("左で押します。Enter で残す", 12) == ["左で押しま", "す。Enter で", "残す"]
    assert wrapped("", 8) == [""]
