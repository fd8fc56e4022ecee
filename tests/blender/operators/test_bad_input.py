"""Bad input gets a plain sentence and harms nothing."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
NAN = float("nan")
QUICK: dict[str, Any] = {"depth_mm": 5.0, "press_s": 0.02, "hold_s": 0.0, "release_s": 0.0}

Refused = Callable[..., None]


@pytest.fixture
def refused(coordinates: Callable[[Any], bytes], bpy: ModuleType) -> Refused:
    """Return a function that checks that poke, play and bake refuse an object in a sentence, and leave it as it was."""
    from bl_ext.user_default.dimple.operators.press import modal_runs, sessions

    def check(obj: Any, words: str) -> None:
        before, data = coordinates(obj), obj.data
        attributes, modifiers = set(obj.data.attributes.keys()), len(obj.modifiers)
        verbs = (
            lambda: bpy.ops.dimple.poke(**QUICK),
            bpy.ops.dimple.play,
            lambda: bpy.ops.dimple.bake(frame_end=3),
        )
        for verb in verbs:
            with pytest.raises(RuntimeError, match=words) as caught:
                verb()
            assert "Traceback" not in str(caught.value)
            assert not sessions.sessions and not modal_runs.runs
            assert coordinates(obj) == before and obj.data == data
            assert set(obj.data.attributes.keys()) == attributes and len(obj.modifiers) == modifiers

    return check


@pytest.fixture
def works(coordinates: Callable[[Any], bytes], bpy: ModuleType) -> Callable[[Any], None]:
    """Return a function that checks that a mesh can be pressed, and is put back bit for bit."""

    def check(obj: Any) -> None:
        before, attributes = coordinates(obj), list(obj.data.attributes.keys())
        assert bpy.ops.dimple.poke(keep=False, **QUICK) == {"FINISHED"}
        assert coordinates(obj) == before and list(obj.data.attributes.keys()) == attributes

    return check


@pytest.mark.parametrize(
    ("points", "faces", "words"),
    [
        ([], [], "no faces"),
        (CUBE, [], "no faces"),
        ([(0, 0, 0)] * 3, [(0, 1, 2)], "at the same point"),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)], "no area"),
        ([*CUBE[:7], (NAN, 0, 0)], FACES, "vertex 7 has a coordinate that is not a number"),
        ([*CUBE[:7], (0, float("inf"), 0)], FACES, "not a number"),
    ],
    ids=["empty", "only vertices", "one point", "a line", "NaN", "infinite"],
)
def test_a_mesh_without_a_surface_is_refused(
    add: Callable[..., Any], refused: Refused, points: Any, faces: Any, words: str
) -> None:
    refused(add(points, faces), words)


SOUP = [CUBE[i] for face in FACES for i in face]
SOUP_FACES = [tuple(range(4 * i, 4 * i + 4)) for i in range(6)]


@pytest.mark.parametrize(
    ("points", "faces"),
    [
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]),
        (CUBE, FACES[:5]),
        ([*CUBE, CUBE[0], CUBE[0]], [*FACES, (0, 8, 9)]),
        ([*CUBE, (5, 5, 5)], FACES),
        ([*CUBE, (2, 2, 0)], [*FACES, (0, 1, 8)]),
        (SOUP, SOUP_FACES),
    ],
    ids=["one triangle", "open", "zero-area face", "loose vertex", "non-manifold edge", "soup"],
)
def test_a_broken_mesh_is_pressed_as_well_as_it_can(
    add: Callable[..., Any], works: Callable[[Any], None], points: Any, faces: Any
) -> None:
    works(add(points, faces))


@pytest.mark.parametrize("name", ["K1", "K2", "x0", "k", "mass_kg", "density"])
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_constants_that_mean_nothing_are_refused_by_name(
    bpy: ModuleType, add: Callable[..., Any], refused: Refused, name: str, value: float
) -> None:
    obj = add()
    material = bpy.data.materials.new("Jelly")
    obj.data.materials.append(material)
    material.dimple.mass_from = "MASS" if name == "mass_kg" else "DENSITY"
    setattr(material.dimple, name, value)
    word = {"mass_kg": "mass", "density": "density"}.get(name, name)
    refused(obj, f'"Jelly".*{word}.*greater than 0')


def test_a_material_no_face_uses_may_be_anything(
    bpy: ModuleType, add: Callable[..., Any], works: Callable[[Any], None]
) -> None:
    obj = add()
    for name in ("Used", "Unused"):
        obj.data.materials.append(bpy.data.materials.new(name))
    bpy.data.materials["Unused"].dimple.K1 = 0
    works(obj)


@pytest.mark.parametrize("scale", [(0, 1, 1), (0, 0, 0)])
def test_a_scale_of_zero_is_refused(add: Callable[..., Any], refused: Refused, scale: Any) -> None:
    obj = add()
    obj.scale = scale
    refused(obj, "scale of 0")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"pin_group": "Neck"}, 'no vertex group "Neck"'),
        ({"softness_group": "Soft"}, 'no vertex group "Soft"'),
    ],
)
def test_a_vertex_group_that_does_not_exist_is_named(
    add: Callable[..., Any], refused: Refused, settings: dict[str, str], words: str
) -> None:
    obj = add()
    for name, value in settings.items():
        setattr(obj.dimple, name, value)
    refused(obj, words)


def test_pins_that_hold_nothing_are_refused(add: Callable[..., Any], refused: Refused) -> None:
    obj = add()
    obj.vertex_groups.new(name="Neck").add([0, 1], 0.4, "ADD")
    obj.dimple.pin_group = "Neck"
    refused(obj, "weight of 0.5")


NOT_MESHES: dict[str, tuple[str, dict[str, Any]]] = {
    "a light": ("light_add", {"type": "POINT"}),
    "a camera": ("camera_add", {}),
    "an empty": ("empty_add", {}),
    "an armature": ("armature_add", {}),
    "a metaball": ("metaball_add", {}),
    "a speaker": ("speaker_add", {}),
    "a grease pencil": ("grease_pencil_add", {"type": "EMPTY"}),
    "a lattice": ("add", {"type": "LATTICE"}),
    "a collection instance": ("collection_instance_add", {"collection": "Cakes"}),
}


@pytest.mark.parametrize("kind", NOT_MESHES)
def test_what_has_no_mesh_is_refused_in_a_sentence(bpy: ModuleType, empty_file: ModuleType, kind: str) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    bpy.context.scene.collection.children.link(bpy.data.collections.new("Cakes"))
    name, given = NOT_MESHES[kind]
    getattr(bpy.ops.object, name)(**given)
    for verb in (lambda: bpy.ops.dimple.poke(**QUICK), bpy.ops.dimple.play, lambda: bpy.ops.dimple.bake(frame_end=3)):
        with pytest.raises(RuntimeError, match=r"not a mesh\. ") as caught:
            verb()
        assert "Traceback" not in str(caught.value) and not sessions.sessions


@pytest.mark.parametrize("value", [NAN, float("inf"), 1e30])
@pytest.mark.parametrize(
    ("verb", "name"),
    [
        ("play", "seconds"), ("poke", "press_s"), ("poke", "hold_s"), ("poke", "release_s"), ("poke", "depth_mm"),
        ("poke", "radius_mm"), ("poke", "location"), ("poke", "direction"),
    ],
)  # fmt: skip
def test_a_number_that_is_none_is_refused_by_name(
    bpy: ModuleType, add: Callable[..., Any], coordinates: Callable[[Any], bytes], verb: str, name: str, value: float
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    obj = add()
    before = coordinates(obj)
    given = {**(QUICK if verb == "poke" else {}), name: (0, value, 0) if name in ("location", "direction") else value}
    with pytest.raises(RuntimeError, match=f"{name.replace('_', ' ').capitalize()} must be a number") as caught:
        getattr(bpy.ops.dimple, verb)(**given)
    assert "Traceback" not in str(caught.value) and not sessions.sessions and coordinates(obj) == before


def test_a_fingertip_that_alone_is_selected_is_said(bpy: ModuleType, add: Callable[..., Any]) -> None:
    body, tip = add(), add()
    bpy.context.scene.dimple.finger_1 = tip
    body.select_set(False)
    with pytest.raises(RuntimeError, match="Only a fingertip is selected"):
        bpy.ops.dimple.poke(**QUICK)
    assert bpy.context.object == tip


def test_nothing_selected_is_said(bpy: ModuleType, empty_file: ModuleType) -> None:
    with pytest.raises(RuntimeError, match="Nothing is selected"):
        bpy.ops.dimple.poke()


def test_edit_mode_is_refused_before_anything(bpy: ModuleType, add: Callable[..., Any]) -> None:
    add()
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Object Mode"):
        bpy.ops.dimple.poke()
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_bad_object_does_not_keep_a_good_one_from_being_pressed(
    bpy: ModuleType, add: Callable[..., Any], shown: Callable[[Any], Any]
) -> None:
    bad, good = add(CUBE, [], "Bad"), add(name="Good")
    bad.select_set(True)
    before = shown(good).tobytes()
    assert bpy.ops.dimple.poke(keep=True, **QUICK) == {"FINISHED"}
    assert shown(good).tobytes() != before


def test_a_press_that_meets_no_surface_is_said(
    bpy: ModuleType, add: Callable[..., Any], coordinates: Callable[[Any], bytes]
) -> None:
    obj = add()
    before = coordinates(obj)
    with pytest.raises(RuntimeError, match="No surface lies"):
        bpy.ops.dimple.poke(location=(9, 9, 9), direction=(0, 0, -1), **QUICK)
    assert coordinates(obj) == before


def test_a_cache_folder_that_cannot_be_made_is_said_and_nothing_changes(
    bpy: ModuleType, add: Callable[..., Any], tmp_path: Any
) -> None:
    obj = add()
    (tmp_path / "file").write_text("")
    bpy.context.scene.dimple.cache_dir = str(tmp_path / "file" / "folder")
    with pytest.raises(RuntimeError, match="[Cc]ache folder"):
        bpy.ops.dimple.bake(frame_end=3)
    assert not obj.modifiers


def test_a_press_that_would_go_through_the_body_is_refused(
    bpy: ModuleType, add: Callable[..., Any], coordinates: Callable[[Any], bytes]
) -> None:
    obj = add()
    before = coordinates(obj)
    with pytest.raises(RuntimeError, match="165 mm across, so a press of 1e.09 mm would go through it"):
        bpy.ops.dimple.poke(**{**QUICK, "depth_mm": 1e9})
    assert coordinates(obj) == before


def test_a_size_that_is_too_large_or_a_mesh_that_is_too_small_is_called_so(
    bpy: ModuleType, add: Callable[..., Any]
) -> None:
    obj = add()
    obj.dimple.size_mm = 1e30
    with pytest.raises(RuntimeError, match=r"a Custom Size of 1e\+30 mm is too large"):
        bpy.ops.dimple.poke(**QUICK)
    obj.dimple.size_mode = "REAL"
    obj.scale = (5e-7,) * 3
    with pytest.raises(RuntimeError, match="only 0.001 mm across: give it a Custom Size"):
        bpy.ops.dimple.play(seconds=0.01)


def test_a_preset_for_what_is_linked_is_refused_for_it_would_be_lost(
    bpy: ModuleType, add: Callable[..., Any], tmp_path: Any
) -> None:
    obj, path = add(), str(tmp_path / "library.blend")
    obj.active_material = bpy.data.materials.new("Linked")
    bpy.data.libraries.write(path, {obj})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Body"]
    linked = bpy.data.objects["Body"]
    bpy.context.collection.objects.link(linked)
    bpy.context.view_layer.objects.active = linked
    with pytest.raises(RuntimeError, match="The object is linked from another file"):
        bpy.ops.dimple.open_material(filepath="soft.dimple")
    own = add(name="Own")
    own.active_material = bpy.data.materials["Linked"]
    with pytest.raises(RuntimeError, match="The material is linked from another file"):
        bpy.ops.dimple.open_material(filepath="soft.dimple")


def test_a_library_override_is_called_so(bpy: ModuleType, add: Any, tmp_path: Path) -> None:
    obj, path = add(), str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {obj})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Body"]
    own = bpy.data.objects["Body"].override_create()
    bpy.context.collection.objects.link(own)
    bpy.context.view_layer.objects.active = own
    with pytest.raises(RuntimeError, match="Settings of a library override would not be saved"):
        bpy.ops.dimple.make_soft()
