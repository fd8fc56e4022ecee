"""Equations (1) to (10) of the paper, one by one, against arithmetic written out in plain Python.

Source: Sakama, Tanaka and Araki, Haptic Rendering for Virtual Object in Cyber Space.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.body.springs import build_springs
from core.material import FINGERTIP, Material
from core.mesh.surface import mesh_from_triangles
from studies.meshes.simple import cube_triangles
from studies.paper_objects import PRESETS
from studies.reference import paper
from studies.reference.paper import surface_stretch, surface_tension
from studies.reference.path import FingerPath
from tests.bodies import TETRAHEDRON, ball

Vector = Sequence[float]
NOBODY = FingerPath(centres=np.zeros((0, 2, 3)), radii=np.zeros(0))
SHAPES = {"tetrahedron": TETRAHEDRON, "ball": ball(0), "cube": cube_triangles(2, 1.0)}


def minus(a: Vector, b: Vector) -> list[float]:
    return [p - q for p, q in zip(a, b, strict=True)]


def cross(a: Vector, b: Vector) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def length(a: Vector) -> float:
    return math.sqrt(sum(p * p for p in a))


def area(points: Sequence[Vector], face: Sequence[int]) -> float:
    a, b, c = (points[i] for i in face)
    return length(cross(minus(b, a), minus(c, a))) / 2


class Pressed:
    """Hold a disturbed shape as plain lists beside the arrays under test."""

    def __init__(self, name: str) -> None:
        self.mesh = mesh_from_triangles(*SHAPES[name])
        self.rest = self.mesh.rest_positions.tolist()
        rng = np.random.default_rng(2)
        self.x = (self.mesh.rest_positions + rng.normal(0, 0.1, self.mesh.rest_positions.shape)).T
        self.points = self.x.T.tolist()
        self.faces = self.mesh.triangles.tolist()


@pytest.fixture(params=SHAPES)
def pressed(request: pytest.FixtureRequest) -> Pressed:
    return Pressed(request.param)


@pytest.mark.parametrize("preset", PRESETS, ids=lambda p: p.name)
@pytest.mark.parametrize("depth_mm", [0.0, 1.0, 13.7, 16.3, 20.0, 36.3, 45.0])
def test_eq_1_the_force_inside_is_the_two_piece_law_of_the_depth(preset: object, depth_mm: float) -> None:
    table = {"object_1_nylon_air": (0.59, 2.24, 36.3), "object_2_vinyl_air": (0.61, 7.23, 16.3)}
    k1, k2, x0 = table.get(preset.name, (0.62, 9.13, 13.7))  # type: ignore[attr-defined]
    wanted = k1 * depth_mm if depth_mm <= x0 else k1 * x0 + k2 * (depth_mm - x0)
    assert preset.material.law(depth_mm / 1000) == pytest.approx(wanted)  # type: ignore[attr-defined]


def test_eq_1_is_that_of_a_solid_too() -> None:
    """The power law of a solid is none of the paper's."""
    material = replace(PRESETS[2].material, fill="solid", indenter=FINGERTIP)
    assert paper.inner_force(material, [0.003]) == pytest.approx(0.003 * material.K1)


def test_eq_1_the_forces_of_all_contacts_add_up() -> None:
    material = replace(PRESETS[2].material, K1=700.0, x0=0.004)
    found = paper.inner_force(material, (0.003, 0.006, 0.001))
    assert found == pytest.approx(700 * 0.003 + (700 * 0.004 + 9130 * 0.002) + 700 * 0.001)


def test_eq_2_pressure_is_force_over_contact_area(pressed: Pressed) -> None:
    contact = [0, 2]
    third_parts = [area(pressed.points, f) / 3 for f in pressed.faces for corner in f if corner in contact]
    found = paper.contact_area(np.array(contact), pressed.mesh.triangles, pressed.x)
    assert found == pytest.approx(sum(third_parts))
    assert paper.inner_pressure(6.2, found) == pytest.approx(6.2 / sum(third_parts))
    assert paper.contact_area(np.zeros(0, int), pressed.mesh.triangles, pressed.x) == 0
    assert paper.inner_pressure(6.2, 0.0) == 0


def test_eq_3_every_vertex_gets_the_same_share_of_the_pressure_along_its_normal(pressed: Pressed) -> None:
    pressure, rest_area = 123.0, sum(area(pressed.rest, f) for f in pressed.faces)
    found = paper.pressure_force(pressure, pressed.mesh.triangles, pressed.x, rest_area)
    for i in range(len(pressed.points)):
        total = [0.0, 0.0, 0.0]
        for face in pressed.faces:
            if i in face:
                a, b, c = (pressed.points[j] for j in face)
                normal = cross(minus(b, a), minus(c, a))
                total = [t + n / length(normal) for t, n in zip(total, normal, strict=True)]
        wanted = [pressure * rest_area / len(pressed.points) * t / length(total) for t in total]
        assert found[:, i] == pytest.approx(wanted)


def neighbours(faces: list[list[int]], i: int) -> set[int]:
    return {j for f in faces if i in f for j in f} - {i}


def test_eq_4_a_spring_pulls_by_its_stretch_over_its_rest_length(pressed: Pressed) -> None:
    k = 54_800.0
    law = build_springs(pressed.mesh, np.full(len(pressed.mesh.springs), k), np.zeros(len(pressed.mesh.springs)))
    found = paper.spring_force(law, pressed.x)
    for i, here in enumerate(pressed.points):
        wanted = [0.0, 0.0, 0.0]
        for j in neighbours(pressed.faces, i):
            arm, rest = minus(pressed.points[j], here), length(minus(pressed.rest[j], pressed.rest[i]))
            wanted = [w + a / rest * k * (length(arm) - rest) for w, a in zip(wanted, arm, strict=True)]
        assert found[:, i] == pytest.approx(wanted)


def test_eq_5_the_force_on_a_vertex_is_pressure_and_springs_and_nothing_else(pressed: Pressed) -> None:
    material = Material(K1=600, K2=2000, x0=0.01, k=300, mass=0.5, damping_ratio=0.9)
    model = paper.literal_model(pressed.mesh, [material])
    state = paper.at_rest(model)
    state.positions[:] = pressed.x
    state.velocities[:] = 1.0  # must not matter: the paper damps nothing
    state.inner_force, state.contact = 5.0, np.array([1])
    pressure = 5.0 / paper.contact_area(state.contact, pressed.mesh.triangles, pressed.x)
    wanted = paper.spring_force(model.springs, pressed.x) + paper.pressure_force(
        pressure, pressed.mesh.triangles, pressed.x, sum(area(pressed.rest, f) for f in pressed.faces)
    )
    np.testing.assert_allclose(paper.forces(model, state), wanted, rtol=1e-12, atol=1e-12 * np.abs(wanted).max())
    assert state.pressure == pytest.approx(pressure)
    assert (model.springs.stiffness == 300).all()  # k as it is in the table, on every edge


def test_eqs_6_to_8_a_step_is_acceleration_then_velocity_then_position(pressed: Pressed) -> None:
    material = Material(K1=600, K2=2000, x0=0.01, k=300, mass=0.5)
    model = paper.literal_model(pressed.mesh, [material])
    state = paper.at_rest(model)
    state.positions[:] = pressed.x
    state.velocities[:] = np.random.default_rng(3).normal(size=pressed.x.shape)
    x, v, f, dt = pressed.x.copy(), state.velocities.copy(), paper.forces(model, state), 2e-4
    paper.run(model, state, NOBODY, tick=dt, substeps=1)
    for i in range(x.shape[1]):
        for c in range(3):
            a = f[c, i] / model.mass[i]
            new_v = a * dt + v[c, i]
            new_x = new_v * dt + x[c, i]
            assert state.velocities[c, i] == pytest.approx(new_v)
            assert state.positions[c, i] == pytest.approx(new_x)


@pytest.mark.parametrize(("force", "depth", "span"), [(21.4, 0.0363, 0.05), (9.94, 0.0163, 0.165), (6.2, 0.01, 0.165)])
def test_eq_9_surface_tension(force: float, depth: float, span: float) -> None:
    wanted = force * depth / (2 * math.sqrt((span / 2) ** 2 + depth**2))
    assert surface_tension(force, depth, span) == pytest.approx(wanted)


def test_eq_10_surface_stretch() -> None:
    assert surface_stretch(4.0, 0.165, 2e-5, 3e6) == pytest.approx(4.0 * 0.165 / (2 * 2e-5 * 3e6))
