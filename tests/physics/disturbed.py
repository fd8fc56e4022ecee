"""Shapes turned, moved and disturbed at random, and derivatives by differences: for the tests of laws and systems."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from core.base import Floats
from core.mesh.surface import Mesh
from studies.meshes.simple import cube_triangles
from tests.bodies import ball, fan, hemisphere, joined, walled_box

Value = TypeVar("Value", Floats, float)

SHAPES = {
    "ball": ball(1), "cube": cube_triangles(2, 1.0), "capped": hemisphere(8, 4), "wall inside": walled_box(),
    "wide fan": fan(),
    "two balls": joined(ball(0), (0.5 * ball(0)[0] + [2, 0, 0], ball(0)[1])),
    "tube": (lambda p, f: (p, f[np.abs(p[f][:, :, 2]).min(axis=1) < 0.49]))(*cube_triangles(3, 1.0)),
    "half open": (lambda p, f: (p, f[3:]))(*ball(1)),
}  # fmt: skip


def turn(rng: np.random.Generator) -> Floats:
    """Return a rotation (3, 3) at random."""
    found = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return found * np.linalg.det(found)


def disturbed(mesh: Mesh, rng: np.random.Generator, amount: float = 0.05) -> Floats:
    """Return positions (3, n) turned, moved and disturbed at random."""
    x = turn(rng) @ mesh.rest_positions.T + rng.normal(0, 3, (3, 1))
    return x + rng.normal(0, amount, x.shape)


def difference(f: Callable[[Floats], Value], x: Floats, u: Floats, step: float = 1e-5) -> Value:
    """Return the derivative of f along u by central differences of fourth order."""
    h = step * u
    return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * step)
