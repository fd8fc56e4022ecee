"""What once broke in a window: it goes on or ends, with a true sentence, and leaves nothing behind."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.point_cache import cache_of

MANY = 50
OURS = ".Dimple"


def left_over(bpy: ModuleType) -> list[str]:
    """Return the names of everything in the file that shows a press."""
    data = (*bpy.data.objects, *bpy.data.meshes, *bpy.data.node_groups)
    return [each.name for each in data if each.name.startswith(OURS)]


def balls(bpy: ModuleType, count: int) -> list[Any]:
    """Add balls of 642 vertices, each with a mesh of its own, and select them."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    first = bpy.context.object
    made = [first]
    for k in range(1, count):
        obj = first.copy()
        obj.data, obj.location.x = first.data.copy(), 3.0 * k
        bpy.context.collection.objects.link(obj)
        obj.select_set(True)
        made.append(obj)
    return made


def counted(monkeypatch: pytest.MonkeyPatch, calls: Counter[str], module: Any, name: str) -> None:
    """Count the calls of a function of a module."""
    real = getattr(module, name)
    monkeypatch.setattr(module, name, lambda *given, **named: calls.update([name]) or real(*given, **named))


@pytest.mark.once
def test_of_fifty_bodies_pressed_at_once_each_is_prepared_once(
    bpy: ModuleType, empty_file: ModuleType, hand: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.reduction import proxy
    from bl_ext.user_default.dimple.operators.bridge import scene_objects
    from bl_ext.user_default.dimple.operators.press import progress, sessions

    bodies, calls, poke = balls(bpy, MANY), Counter[str](), hand("poke")
    for module, name in ((scene_objects, "_mesh"), (proxy, "build_proxy")):
        counted(monkeypatch, calls, module, name)
    monkeypatch.setattr(progress, "LARGE", 1e9)  # at once, not between Blender's events
    assert poke.invoke() == {"RUNNING_MODAL"}
    assert len(sessions.sessions) == len(bodies) == calls["_mesh"] and calls["build_proxy"] <= len(bodies)
    said = [text for _, text in poke.reports]
    assert said and f"{MANY} bodies: 2 m across as modelled" in said[-1] and len(said[-1]) < 1000
    poke.send("ESC")


@pytest.mark.parametrize("name", ["poke", "play"])
def test_a_start_that_fails_leaves_nothing_behind(
    bpy: ModuleType, empty_file: ModuleType, sessions: Any, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    from bl_ext.user_default.dimple.operators.bridge import offset

    add, bodies = offset.add, balls(bpy, 2)

    def failing(body: Any, *how: Any) -> Any:
        modifier = add(body, *how)
        if body == bodies[1]:
            raise RuntimeError("No more modifiers")
        return modifier

    monkeypatch.setattr(offset, "add", failing)
    with pytest.raises(RuntimeError, match="No more modifiers"):
        getattr(bpy.ops.dimple, name)()
    assert not sessions.sessions and not left_over(bpy)
    assert not any(body.modifiers or body.dimple.is_property_set("size_mode") for body in bodies[1:])
    assert not any(body.modifiers for body in bodies)


def test_what_carries_a_press_is_deleted_and_the_session_goes_on(
    bpy: ModuleType, sessions: Any, playing: Any, rest: bytes, shown: Callable[[Any], Any]
) -> None:
    obj = playing()
    bpy.data.objects.remove(bpy.data.objects[".Dimple Carrier"])
    bpy.ops.dimple.play(seconds=0.05)
    assert shown(obj).tobytes() != rest and sessions.sessions
    bpy.ops.dimple.reset()
    assert shown(obj).tobytes() == rest and not left_over(bpy)


@pytest.mark.parametrize("how", ["paste", "scene", "paste after it", "kept"])
def test_a_copy_of_a_live_body_leaves_nothing_of_ours_in_a_saved_file(
    bpy: ModuleType, sessions: Any, playing: Any, tmp_path: Path, how: str
) -> None:
    playing()
    if how == "scene":
        bpy.ops.scene.new(type="FULL_COPY")
    else:
        if how == "kept":
            sessions.stop_all(restore=False)
        bpy.ops.view3d.copybuffer()
        if how == "paste after it":
            bpy.ops.dimple.reset()
        bpy.ops.view3d.pastebuffer()
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    sessions.stop_all()
    bpy.ops.wm.open_mainfile(filepath=path)
    carriers = [obj for obj in bpy.data.objects if obj.name.startswith(OURS)]
    assert not any(obj.users_collection for obj in carriers), "none of them is in a scene"
    assert len(left_over(bpy)) == (2 * 3 if how == "kept" else 0), "a group, a carrier and its mesh"


def test_the_material_that_is_chosen_replaces_the_constants_of_the_one_that_is_there(
    bpy: ModuleType, ball: Any
) -> None:
    obj = ball(subdivisions=4)
    obj.active_material = bpy.data.materials.new("Own")
    bpy.ops.dimple.apply_preset(preset="object_3_vinyl_water")
    assert obj.active_material.name == "Own" and obj.active_material.dimple.fill == "LIQUID"
    obj.active_material.dimple.K1 = 2.0
    bpy.ops.dimple.make_soft()
    assert obj.active_material.dimple.K1 == 2.0, "who chooses nothing keeps what there is"


def test_a_surface_that_a_modifier_makes_alone_is_pressed(
    bpy: ModuleType, add: Any, shown: Callable[[Any], Any]
) -> None:
    obj = add(faces=[])
    group = bpy.data.node_groups.new("Cube", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube, result = group.nodes.new("GeometryNodeMeshCube"), group.nodes.new("NodeGroupOutput")
    group.links.new(cube.outputs[0], result.inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = group
    bpy.ops.dimple.poke(depth_mm=10.0, press_s=0.1, hold_s=0.1, release_s=0.0, keep=True)
    assert shown(obj)[:, 2].min() == -0.5 and not len(obj.data.polygons)


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


def test_what_of_a_scene_does_not_act_is_said(
    bpy: ModuleType, scene: Any, ball: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    obj = ball()
    bpy.ops.dimple.add_fingertip()
    scene.dimple.finger_1.hide_viewport = True
    bpy.ops.object.effector_add(type="WIND")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.ops.dimple.bake(frame_start=1, frame_end=2)
    Path(cache_of(obj).filepath).unlink()
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.ops.dimple.play(seconds=0.01)
    said = capfd.readouterr().out
    assert "is disabled in the viewport, so it does not move" in said
    assert "other force fields of the scene do not act on the body" in said
    assert 'The file that "Dimple" plays is gone: bake again.' in said
    bpy.ops.dimple.reset()


def test_a_material_that_is_deleted_while_it_acts_is_said(
    bpy: ModuleType, vinyl: Any, cube: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    vinyl.K1 = 2.0
    bpy.ops.dimple.play(seconds=0.01)
    bpy.data.materials.remove(cube.active_material)
    bpy.ops.dimple.play(seconds=0.01)
    assert "a material is gone: the constants of a new one act in its place" in capfd.readouterr().out
    bpy.ops.dimple.reset()


def test_over_a_hidden_body_nothing_is_drawn(
    bpy: ModuleType, sessions: Any, playing: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import canvas, overlay

    obj = playing()
    monkeypatch.setattr(canvas, "overlays_shown", lambda _: True)
    for hidden in (False, True):
        obj.hide_set(hidden)
        assert bool(overlay.shown_bodies(bpy.context)) is not hidden
    sessions.stop_all()


def test_a_frame_in_which_a_body_rests_is_that_before_it(
    bpy: ModuleType, scene: Any, ball: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core import fields
    from bl_ext.user_default.dimple.operators.bridge import scene_objects

    obj, calls = ball(), Counter[str]()
    counted(monkeypatch, calls, fields, "energies")
    counted(monkeypatch, calls, scene_objects, "offsets_of")
    bpy.ops.dimple.bake(frame_start=1, frame_end=80)
    assert calls.total() < 40, "it falls asleep within 20 frames"
    lines = Path(cache_of(obj).filepath).with_suffix(".csv").read_text().splitlines()
    resting = {line.split(",", 2)[2].rsplit(",", 1)[0] for line in lines[40:]}
    assert len(lines) == 81 and len(resting) == 1, "but for frame, time and steps"
