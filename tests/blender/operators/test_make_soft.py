"""Make Soft takes a bare mesh to its first press, and changes the mesh itself only when asked."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Bits = Callable[[Any], bytes]
TIP, FORCE = 0.01, 15.0  # [m], [N]
PRESS: dict[str, Any] = {"force_n": 4.0, "press_s": 0.1, "hold_s": 0.2, "release_s": 0.0, "keep": True}


@pytest.fixture
def bare(bpy: ModuleType, empty_file: ModuleType) -> Any:
    """Blender's default cube, two metres wide and without a material."""
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


def test_a_bare_cube_is_ready_for_its_first_press(bpy: ModuleType, bare: Any) -> None:
    assert bpy.ops.dimple.make_soft(subdivide=True) == {"FINISHED"}
    settings = bare.active_material.dimple
    assert settings.K1 == pytest.approx(0.61) and "Hosei" in settings.provenance
    assert bare.dimple.enabled and bare.dimple.size_mode == "CUSTOM" and bare.dimple.size_mm == 165
    assert 500 < len(bare.data.vertices) < 8000 and bare.dimple.plan_key, "it is planned already"
    edges = [np.subtract(*(bare.data.vertices[i].co for i in edge.vertices)) for edge in bare.data.edges]
    assert np.linalg.norm(edges, axis=1).max() * 0.165 / 2 <= 0.55 * TIP * 1.001, "a press by force is right anywhere"
    areas = [face.area for face in bare.data.polygons]
    assert min(areas) > 0.99 * max(areas), "a length that comes out even is cut once"
    top = max(vertex.co.z for vertex in bare.data.vertices)
    bpy.ops.dimple.poke(**PRESS)
    heights = np.array([vertex.co.z for vertex in bare.data.vertices])
    assert heights[np.hypot(*np.array([v.co.xy for v in bare.data.vertices]).T) < 0.1].min() < top - 0.02


@pytest.mark.once
@pytest.mark.parametrize("K1", [pytest.param(0.3, marks=pytest.mark.slow), 3.0])
def test_a_press_by_force_is_as_deep_as_the_law_says_on_a_vertex_and_beside_it(
    bpy: ModuleType, bare: Any, sessions: Any, K1: float
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators import live

    bpy.ops.dimple.make_soft(subdivide=True)
    body, _ = sessions.start(bare, bpy.context)
    bare.active_material.dimple.K1 = K1
    live.advance(bpy.context, 1e-3)
    law, mesh = body.session.model.materials[0].law, body.session.model.mesh
    edge = float(np.median(mesh.rest_lengths))
    for aside in ((0.0, 0.0), (0.5, 0.0), (0.5, 0.5)):  # of an edge: on a vertex, an edge and a face
        at = (edge * aside[0], edge * aside[1], mesh.size / 2 + TIP)
        for force, seconds in ((0.0, 0.3), (FORCE, 1.0)):
            body.session.set_fingers([Finger(at, TIP, force)])
            body.session.step(seconds)
        assert law(0.95 * body.frame.depths[0]) < FORCE < law(1.05 * body.frame.depths[0]), (aside, body.frame)
    sessions.stop_all()


def test_the_mesh_is_cut_only_when_asked_and_keeps_its_shape(
    bpy: ModuleType, bare: Any, coordinates: Bits
) -> None:
    before = coordinates(bare)
    bare.active_material = bpy.data.materials.new("Own")
    bare.dimple.size_mode, bare.dimple.size_mm = "CUSTOM", 60.0  # soon planned
    bpy.ops.dimple.make_soft()
    assert coordinates(bare) == before
    bpy.ops.dimple.make_soft(subdivide=True)
    numbers = np.frombuffer(coordinates(bare), np.float32).reshape(-1, 3)
    assert np.abs(numbers).max(axis=1) == pytest.approx(np.ones(len(numbers)))


@pytest.mark.parametrize(("primitive", "size"), [("uv_sphere", 0.3), ("uv_sphere", 1.0), ("torus", 1.0)])
def test_a_mesh_is_cut_when_asked_wherever_its_simulation_would_be(
    bpy: ModuleType, empty_file: ModuleType, primitive: str, size: float, capfd: pytest.CaptureFixture[str]
) -> None:
    """A ball of 0.6 m is asked for at that size, and then the material makes it one of 165 mm."""
    getattr(bpy.ops.mesh, f"primitive_{primitive}_add")()
    body = bpy.context.object
    body.scale = (size, size, size)
    bpy.context.view_layer.update()
    before = len(body.data.vertices)
    bpy.ops.dimple.make_soft()
    assert "A bake needs the mesh itself as fine" in capfd.readouterr().out and len(body.data.vertices) == before
    bpy.ops.dimple.make_soft(subdivide=True)
    assert "A bake needs the mesh itself as fine" not in capfd.readouterr().out and len(body.data.vertices) > 3 * before


def test_it_asks_before_it_cuts_and_only_then(bpy: ModuleType, bare: Any, ball: Any) -> None:
    from types import SimpleNamespace

    from bl_ext.user_default.dimple.operators import make_soft

    asked: list[Any] = []
    operator = SimpleNamespace(subdivide=False, repair=False, faults="", execute=lambda _context: {"FINISHED"})
    invoke = make_soft.DIMPLE_OT_make_soft.invoke
    manager = SimpleNamespace(invoke_props_dialog=lambda each, width: asked.append(each) or {"RUNNING_MODAL"})

    def context() -> Any:
        current = bpy.context
        return SimpleNamespace(
            window_manager=manager, scene=current.scene, object=current.object,
            selected_objects=current.selected_objects,
        )  # fmt: skip

    assert invoke(operator, context(), None) == {"RUNNING_MODAL"} and asked == [operator] and operator.subdivide
    assert bare.dimple.size_mode == "REAL", "asking changes nothing"
    ball(subdivisions=3).dimple.enabled = True  # of 642: a press on it is simulated finer
    assert invoke(operator, context(), None) == {"RUNNING_MODAL"} and len(asked) == 2 and operator.subdivide
    ball(subdivisions=5)
    assert invoke(operator, context(), None) == {"FINISHED"} and len(asked) == 2 and not operator.subdivide


def test_a_cylinder_is_cut_where_its_faces_are_wide_and_its_edges_short(
    bpy: ModuleType, empty_file: ModuleType
) -> None:
    from bl_ext.user_default.dimple.operators import cutting

    bpy.ops.mesh.primitive_cylinder_add()
    cylinder = bpy.context.object
    volume = sum(face.area * face.center.dot(face.normal) for face in cylinder.data.polygons)
    assert cutting.is_coarse(bpy.context, cylinder)
    bpy.ops.dimple.make_soft(subdivide=True)
    mesh, units_m = cylinder.data, 0.165 / 2
    ends = [[mesh.vertices[i].co for i in edge.vertices] for edge in mesh.edges]
    longest, shortest = (each((a - b).length for a, b in ends) * units_m for each in (max, min))
    assert longest < 0.9 * TIP and shortest > 0.2 * TIP and mesh.uv_layers
    top = [loop for face in mesh.polygons if face.normal.z > 0.99 for loop in face.loop_indices]
    spots = np.array([mesh.vertices[mesh.loops[loop].vertex_index].co.xy for loop in top])
    picture = np.array([mesh.uv_layers[0].data[loop].uv for loop in top])
    assert picture == pytest.approx(0.25 + 0.24 * spots, abs=1e-4), "the picture on the top is where it was"
    assert sum(face.area * face.center.dot(face.normal) for face in mesh.polygons) == pytest.approx(volume, rel=1e-5)
    bpy.ops.dimple.poke(depth_mm=8.0, press_s=0.1, hold_s=0.1, release_s=0.0, keep=True)
    assert min(v.co.z for v in mesh.vertices if v.co.z > 0.5) < 1.0 - 0.9 * 0.008 / units_m, "the top shows the dent"


@pytest.mark.parametrize("name", ["ico_sphere", "monkey", "uv_sphere"])
def test_what_is_cut_has_no_face_without_area(bpy: ModuleType, empty_file: ModuleType, name: str) -> None:
    """Edges of an icosphere are of two lengths: cut in unequal numbers they had 600 such faces, in twice the mesh."""
    getattr(bpy.ops.mesh, f"primitive_{name}_add")()
    mesh = bpy.context.object.data
    assert bpy.ops.dimple.make_soft(subdivide=True) == {"FINISHED"}
    mesh.calc_loop_triangles()
    points = np.array([vertex.co for vertex in mesh.vertices])
    corners = points[np.array([triangle.vertices for triangle in mesh.loop_triangles])]
    edges = corners - np.roll(corners, 1, axis=1)
    doubled = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    height = doubled / np.linalg.norm(edges, axis=2).max(axis=1) ** 2
    assert height.min() > 0.02 and len(points) < 6000


@pytest.mark.parametrize("scale", [(1.0, 1.0, 3.0), (1.0, 0.05, 1.0), (-1.0, -2.0, -0.5)])
def test_a_cube_that_is_scaled_unevenly_is_cut_at_the_size_it_has(
    bpy: ModuleType, bare: Any, scale: tuple[float, float, float], capfd: pytest.CaptureFixture[str]
) -> None:
    bare.scale = scale
    bpy.context.view_layer.update()
    bpy.ops.dimple.make_soft(subdivide=True)
    assert "too few" not in capfd.readouterr().out
    corners = {tuple(vertex.co) for vertex in bare.data.vertices[:8]}
    assert corners == {(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)}, "no vertex there was has moved"
    units_m = 0.165 / max(bare.dimensions)
    points = np.array([vertex.co for vertex in bare.data.vertices]) * np.abs(scale) * units_m
    ends = np.array([edge.vertices for edge in bare.data.edges])
    assert np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1).max() < 0.56 * TIP


def test_a_linked_duplicate_becomes_soft_and_is_not_cut(
    bpy: ModuleType, bare: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    other = bare.copy()
    bpy.context.collection.objects.link(other)
    assert bpy.ops.dimple.make_soft(subdivide=True) == {"FINISHED"}
    assert bare.dimple.enabled and len(bare.data.vertices) == 8 and "shares its mesh" in capfd.readouterr().out


def test_a_metaball_becomes_a_body_under_its_own_name(bpy: ModuleType, empty_file: ModuleType) -> None:
    bpy.ops.object.metaball_add()
    name = bpy.context.object.name
    assert bpy.ops.dimple.make_soft() == {"FINISHED"}
    assert bpy.context.object.name == name and bpy.context.object.type == "MESH" and bpy.context.object.dimple.enabled


def test_a_text_without_characters_is_refused_and_stays_flat(bpy: ModuleType, empty_file: ModuleType) -> None:
    bpy.ops.object.text_add()
    bpy.context.object.data.body = ""
    with pytest.raises(RuntimeError, match="has no faces"):
        bpy.ops.dimple.make_soft()
    assert bpy.context.object.type == "FONT" and bpy.context.object.data.extrude == 0.0


def test_what_the_artist_has_set_is_left_as_it_is(bpy: ModuleType, ball: Any) -> None:
    obj = ball(subdivisions=4)
    obj.active_material = bpy.data.materials.new("Own")
    obj.active_material.dimple.K1 = 2.0
    obj.dimple.enabled, obj.dimple.size_mm = True, 90.0
    bpy.ops.dimple.make_soft()
    assert obj.active_material.name == "Own" and obj.active_material.dimple.K1 == 2.0 and obj.dimple.size_mm == 90.0


def test_what_cannot_be_pressed_is_said(bpy: ModuleType, add: Any) -> None:
    add(faces=[])
    with pytest.raises(RuntimeError, match="has no faces"):
        bpy.ops.dimple.make_soft()


def broken(bpy: ModuleType) -> Any:
    """Return a ball with a doubled vertex, a loose one, a face that looks inward and a hole."""
    import bmesh

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=0.05)
    obj, made = bpy.context.object, bmesh.new()
    made.from_mesh(obj.data)
    made.faces.ensure_lookup_table()
    bmesh.ops.delete(made, geom=[made.faces[100]], context="FACES_ONLY")
    made.faces.ensure_lookup_table()
    made.faces[7].normal_flip()
    face = made.faces[300]
    bmesh.ops.split(made, geom=[face])
    made.verts.new((0.0, 0.0, 0.3))
    made.to_mesh(obj.data)
    made.free()
    return obj


def test_a_broken_mesh_is_repaired_where_the_artist_agrees_and_what_is_left_is_said(
    bpy: ModuleType, empty_file: ModuleType, coordinates: Bits, capfd: pytest.CaptureFixture[str]
) -> None:
    from bl_ext.user_default.dimple.operators import mesh_faults

    obj = broken(bpy)
    found = mesh_faults.faults(obj)
    assert found == (3, 1, 1)
    before = coordinates(obj)
    bpy.ops.dimple.make_soft()
    assert coordinates(obj) == before, "nothing is repaired unasked"
    assert "Holes closed for the pressure only: 1." in capfd.readouterr().out
    bpy.ops.dimple.make_soft(repair=True)
    assert len(obj.data.vertices) == 642 and mesh_faults.faults(obj) == (0, 0, 0)
    said = capfd.readouterr().out
    assert "Doubled vertices: 3. Loose vertices: 1. Faces that look inward: 1." in said


def test_whatever_is_wrong_with_a_sheet_most_of_its_faces_say_which_side_is_outward(
    bpy: ModuleType, empty_file: ModuleType
) -> None:
    from bl_ext.user_default.dimple.operators import mesh_faults

    bpy.ops.mesh.primitive_grid_add(x_subdivisions=10, y_subdivisions=10)
    sheet = bpy.context.object
    for polygon in sheet.data.polygons:
        polygon.flip() if polygon.index in (3, 50) else None
    sheet.data.update()
    assert mesh_faults.repair(sheet).inward == 2
    assert all(polygon.normal.z > 0.99 for polygon in sheet.data.polygons)


def test_a_preset_is_chosen_by_its_name(bpy: ModuleType, bare: Any) -> None:
    choices = bpy.ops.dimple.make_soft.get_rna_type().properties["preset"]
    assert choices.type == "ENUM"
    bpy.ops.dimple.make_soft(preset="object_3_vinyl_water", subdivide=True)
    assert bare.active_material.dimple.fill == "LIQUID"


def test_undo_takes_all_of_it_back(bpy: ModuleType, bare: Any, coordinates: Bits) -> None:
    before = coordinates(bare)
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.dimple.make_soft(subdivide=True)
    bpy.ops.ed.undo_push(message="Make Soft")
    bpy.ops.ed.undo()
    cube = bpy.data.objects["Cube"]
    assert coordinates(cube) == before and cube.active_material is None and not cube.dimple.enabled
