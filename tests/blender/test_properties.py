"""What Blender stores: units, defaults, several materials, and what is kept in the file."""

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = "bl_ext.user_default.dimple"


@pytest.fixture
def material(empty_file: ModuleType) -> Any:
    """The settings of a new material."""
    return empty_file.data.materials.new("Skin").dimple


def core(name: str) -> ModuleType:
    import importlib

    return importlib.import_module(f"{ROOT}.core.{name}")


def test_a_new_material_is_the_second_object_of_the_paper(material: Any) -> None:
    assert material.to_params() == {
        "K1": 610.0, "K2": 7230.0, "k": 9200.0, "x0": 0.0163, "density": 100.0,
        "damping_ratio": 0.2, "friction": 0.5, "fill": "air", "pressure": 0.0, "spread": 0.012,
        "indenter": core("material").Indenter(shape="sphere", radius=0.010),
    }  # fmt: skip
    assert material.provenance == ""


def test_a_new_object_is_switched_off_and_as_large_as_it_is_modelled(empty_file: ModuleType) -> None:
    body = empty_file.data.objects.new("Body", empty_file.data.meshes.new("Body"))
    assert not body.dimple.enabled
    assert body.dimple.to_params() == {
        "pinned": "", "softness_group": "", "knee_group": "",
        "spread_group": "", "size": None, "sway": None,
    }  # fmt: skip
    body.dimple.size_mode = "CUSTOM"
    assert body.dimple.to_params()["size"] == 0.165


def test_what_is_typed_is_what_is_computed(material: Any) -> None:
    """Blender stores 32 bits: 0.59 comes back as 0.5899999737."""
    for number in (0.59, 2.24, 54.8, 9.13, 0.001, 1234.567):
        material.K1 = number
        assert material.to_params()["K1"] == pytest.approx(number * 1e3, rel=1e-15)


def test_every_fill_is_one_the_core_knows(empty_file: ModuleType, material: Any) -> None:
    fills = [item.identifier.lower() for item in material.bl_rna.properties["fill"].enum_items]
    assert tuple(fills) == tuple(core("fills").FILLS)


@pytest.mark.parametrize("name", ["K1", "K2", "k", "x0", "density"])
def test_a_constant_of_zero_is_reported_in_the_panel_and_a_negative_one_cannot_be_typed(
    material: Any, name: str
) -> None:
    from bl_ext.user_default.dimple.addon import materials

    assert materials.wrong_with(material) == []
    setattr(material, name, -1.0)
    assert getattr(material, name) == 0.0
    (sentence,) = materials.wrong_with(material)
    assert "greater than 0" in sentence


def test_constants_changed_by_hand_no_longer_pass_for_measured(material: Any) -> None:
    material.K1 = 4.0
    assert not material.edited, "typed in, not measured"
    material.provenance = "Table 2"
    material.friction = 0.9
    assert not material.edited, "friction was not measured"
    material.K1 = 5.0
    assert material.edited and material.provenance == "Table 2"
    material.provenance = "Table 3"
    assert not material.edited, "a preset sets the source last"
    material.softness_mm = 4.0
    assert material.edited, "which sets K1"


def test_a_soft_body_is_not_offered_as_a_fingertip(empty_file: ModuleType) -> None:
    scene = empty_file.context.scene
    for slot in ("finger_1", "finger_2", "finger_3"):
        setattr(scene.dimple, slot, empty_file.data.objects.new("Tip", None))
    assert len({scene.dimple.finger_1, scene.dimple.finger_2, scene.dimple.finger_3}) == 3
    from bl_ext.user_default.dimple.addon import properties

    body = empty_file.data.objects.new("Body", empty_file.data.meshes.new("Body"))
    assert properties._is_fingertip(scene.dimple, body)
    body.dimple.enabled = True
    assert not properties._is_fingertip(scene.dimple, body)


def test_settings_are_kept_in_the_file(empty_file: ModuleType, tmp_path: Path) -> None:
    body = empty_file.data.objects.new("Body", empty_file.data.meshes.new("Body"))
    empty_file.context.collection.objects.link(body)
    body.data.materials.append(empty_file.data.materials.new("Skin"))
    body.dimple.enabled, body.dimple.pin_group = True, "Neck"
    body.data.materials[0].dimple.x0 = 36.3
    empty_file.context.scene.dimple.finger_1 = body
    path = str(tmp_path / "kept.blend")
    empty_file.ops.wm.save_as_mainfile(filepath=path)
    empty_file.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    empty_file.ops.wm.open_mainfile(filepath=path)
    body = empty_file.data.objects["Body"]
    assert body.dimple.enabled and body.dimple.pin_group == "Neck"
    assert body.data.materials[0].dimple.to_params()["x0"] == 0.0363
    assert empty_file.context.scene.dimple.finger_1 == body


def test_a_file_from_before_solids_has_the_fill_it_had(material: Any) -> None:
    """A file keeps the number of a choice."""
    numbers = {item.identifier: item.value for item in material.bl_rna.properties["fill"].enum_items}
    assert numbers == {"AIR": 0, "LIQUID": 1, "NONE": 2, "SOLID": 3}
    material.fill = "SOLID"
    assert material.to_params()["fill"] == "solid"


def test_softness_is_read_from_the_constants_and_typed_it_scales_them(material: Any) -> None:
    assert material.softness_mm == pytest.approx(5 / 0.61, rel=1e-5)
    knee, ratio = material.x0, material.K2 / material.K1
    material.softness_mm = 4.0
    assert material.softness_mm == pytest.approx(4.0, rel=1e-5) and material.K1 == pytest.approx(1.25)
    assert material.x0 == knee and material.K2 / material.K1 == pytest.approx(ratio, rel=1e-5)
    material.softness_mm = -1.0
    assert material.softness_mm == pytest.approx(0.01, rel=1e-4), "no less than the least"
    material.K1 = 0.0
    assert material.softness_mm == 0.0
    material.softness_mm = 5.0
    assert material.K1 == 0.0, "what is no law is not scaled"


def test_the_material_in_use_is_marked_until_its_constants_are_ones_own(empty_file: ModuleType) -> None:
    body = empty_file.data.objects.new("Body", empty_file.data.meshes.new("Body"))
    assert body.dimple.material == "object_2_vinyl_air", "what it gets"
    for preset in core("everyday_presets").OBJECTS:
        body.dimple.material = preset.name
        assert body.dimple.material == preset.name, preset.name
        assert body.active_material.dimple.provenance == preset.provenance
        assert body.dimple.enabled and body.dimple.to_params()["size"] == pytest.approx(preset.size)
    body.dimple.material = "OWN"
    assert body.dimple.material == preset.name, "there is nothing to give"
    body.active_material.dimple.softness_mm = 3.0
    assert body.dimple.material == "OWN"
    assert len(empty_file.data.materials) == 1


def test_every_material_has_a_picture_of_its_own(empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon import material_choice

    names = {path.stem for path in material_choice.PICTURES.glob("*.webp")}
    assert names == {preset.name for preset in core("everyday_presets").OBJECTS}
    items = material_choice.choices(None, None)
    assert [name for name, *_ in items[:-1]] == [preset.name for preset in core("everyday_presets").OBJECTS]
    pictures = [material_choice._pictures[0][name] for name, *_ in items[:-1]]
    assert all(tuple(picture.image_size) == (256, 256) for picture in pictures)
    assert len({tuple(picture.image_pixels) for picture in pictures}) == len(pictures)
    assert sum(path.stat().st_size for path in material_choice.PICTURES.iterdir()) < 150_000


def test_the_fingertip_follows_the_size_of_a_material_that_is_chosen(empty_file: ModuleType) -> None:
    empty_file.ops.mesh.primitive_cube_add()
    body, settings = empty_file.context.object, empty_file.context.scene.dimple
    body.dimple.material = "pillow"
    large = settings.finger_radius_mm
    body.dimple.material = "marshmallow"
    assert settings.finger_radius_mm < large / 5
