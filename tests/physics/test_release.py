"""What is pressed and let go comes back to rest; what stays is a crease that nothing holds."""

import json
from pathlib import Path

import numpy as np
import pytest

from core.body.model import build_model
from core.material import Material
from core.mesh.surface import base_vertices
from studies.__main__ import main
from studies.body.release import flipped, place_at, release, residual, run_mesh
from studies.meshes.bodies import DOUGH, GEL, VINYL, head
from studies.meshes.primitives import HARD, PRIMITIVES
from studies.meshes.simple import SIZE, grid, icosphere, sized

FINGERTIP = 0.015  # [m]


@pytest.mark.parametrize("material", [VINYL, GEL, DOUGH], ids=["vinyl", "gel", "dough"])
def test_a_pressed_head_returns_to_rest(material: Material) -> None:
    """At eight places, 30 percent of its smallest side deep: springs alone keep a crease at one or another."""
    mesh = head(9, SIZE)
    model, rng = build_model(mesh, [material], pinned=base_vertices(mesh)), np.random.default_rng(0)
    for vertex in rng.choice(np.flatnonzero(~model.pinned), 8):
        one = release(model, place_at(mesh, int(vertex)), "press", FINGERTIP, mesh="head", material="")
        assert one.force > 1 and one.back and not one.flipped, vertex
        assert one.kinetic < 1e-9  # [J] it does not ring on


@pytest.mark.parametrize("name", ["default cube", "UV sphere 16 x 8", "cylinder", "cone", "grid 10 x 10"])
def test_a_primitive_of_blender_returns_to_rest_however_it_is_pressed(name: str) -> None:
    mesh = sized(*PRIMITIVES[name]())
    materials = [("vinyl", VINYL), ("gel", GEL), ("dough", DOUGH)]
    for one in run_mesh(name, mesh, materials, ["press", "drag", "pinch", "free"]):
        assert one.back and not one.flipped, one


@pytest.mark.parametrize("name", ["two balls that pass through each other", "letter"])
def test_a_mesh_that_is_hard_to_simulate_returns_to_rest(name: str) -> None:
    materials = [("vinyl", VINYL), ("gel", GEL), ("dough", DOUGH)]
    for one in run_mesh(name, sized(*HARD[name]()), materials, ["press", "drag"]):
        assert one.back and not one.flipped, one


def test_what_has_only_moved_as_a_whole_has_come_back() -> None:
    mesh = sized(*icosphere(1))
    model = build_model(mesh, [VINYL])
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    x = turn @ model.matching.rest + np.array([[1.0], [2], [3]])
    assert residual(model, x) < 1e-12
    x[0, 0] += 0.01
    assert residual(model, x) == pytest.approx(0.01 / SIZE, rel=0.1)


def test_a_face_turned_over_is_seen_and_a_turned_body_has_none() -> None:
    mesh = sized(*grid(6, 6))
    x = mesh.rest_positions.copy()
    assert flipped(mesh, x.T) == 0 and flipped(mesh, (x @ np.diag([-1.0, 1, -1])).T) == 0
    middle = int((x**2).sum(axis=1).argmin())
    x[middle] += 1.5 * SIZE / 6 * np.array([1.0, 0.5, 0])
    assert flipped(mesh, x.T) > 0


def test_the_command_sums_up_as_json(tmp_path: Path) -> None:
    assert main(["release", "--only", "ico sphere 3", "--json", str(tmp_path / "sum.json")]) == 0
    found = json.loads((tmp_path / "sum.json").read_text("utf-8"))
    assert found["meshes"] == 1 and found["presses"] == len(found["rows"]) == 3 and found["not_back"] == 0
