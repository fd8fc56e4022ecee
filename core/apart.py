"""How a body that intersects others gets clear of them: as a whole by the shortest way, without turning, or, where it
is pinned, pressed flat towards its pins.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from . import native
from .base import Bools, Floats, Ints
from .solver.scene import Collider

STEPS = 64  # of the body's size: the first of a way
HALVINGS = 7  # of the last step, to find where it gets clear
FARTHEST = 4.0  # of the body's size
MARGIN = 0.1  # of the mean edge: the distance that it is left with
FLATTEST = 0.8  # of what stands out from the pins, is pressed away at most


def way_out(body: native.Body, x: Floats, triangles: Ints, others: Sequence[Collider]) -> Floats | None:
    """Return the shortest of some ways (3,) [m] that bring a body clear of all others, None where none does.

    Args:
        body: that is to go, at x (n, 3) [m].
        triangles: (t, 3) of it.
        others: where they are.
    """
    scene = native.Scene([body], others, native.library(), itself=[False])

    def is_clear(way: Floats) -> bool:
        for index, other in enumerate(others):
            scene.set_collider(index, other.positions - way[:, None])
        if scene.crossings().pairs:
            return False
        return not any(_is_inside(x, other.positions.T - way, other.triangles, triangles) for other in others)

    size, middle = float(np.ptp(x, axis=0).max()), x.mean(axis=0)
    directions = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    for other in others:
        away = middle - other.positions.mean(axis=1)
        if np.linalg.norm(away) > 1e-6 * size:
            directions.append(away / np.linalg.norm(away))
    margin = MARGIN * float(np.linalg.norm(x[triangles[:, 0]] - x[triangles[:, 1]], axis=1).mean())
    best, least = None, FARTHEST * size
    for direction in directions:
        length = _length(is_clear, direction, size / STEPS, least)
        if length is not None and length < least:
            least = length
            best = (length + margin if is_clear((length + margin) * direction) else length) * direction
    return best


def pressed_clear(body: native.Body, pinned: Bools, triangles: Ints, others: Sequence[Collider]) -> Floats | None:
    """Return where a body (3, n) [m] is clear of all others: what stands out from its pins on one side is pressed flat
    evenly, so that nothing passes through anything there; None where that does not help.

    Args:
        pinned: (n,) vertices; they stay.
        triangles, others: as in `way_out`.
    """
    scene = native.Scene([body], others, native.library(), itself=[False])
    x, speed = body.positions(), body.velocities()
    best, least = None, np.inf
    margin = MARGIN * float(np.linalg.norm(x[:, triangles[:, 0]] - x[:, triangles[:, 1]], axis=0).mean())
    for direction in (sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)):
        out = np.maximum(direction @ x - (direction @ x[:, pinned]).max(initial=-np.inf), 0.0)
        height = float(out.max())
        if not margin < height < np.inf:
            continue

        def is_clear(way: Floats, out: Floats = out, height: float = height) -> bool:
            share = float(np.linalg.norm(way)) / height
            if share > FLATTEST:
                return False
            y = x - way[:, None] * (out / height)
            body.set_state(y, speed)
            return not scene.crossings().pairs and not any(
                _is_inside(y.T, other.positions.T, other.triangles, triangles) for other in others
            )

        length = _length(is_clear, direction, height / STEPS, min(least, FLATTEST * height))
        if length is not None and length < least:
            least, length = length, length + margin if is_clear((length + margin) * direction) else length
            best = x - length * direction[:, None] * (out / height)
    body.set_state(x, speed)
    return best


def _length(is_clear: Callable[[Floats], bool], direction: Floats, first: float, most: float) -> float | None:
    """Return how far it is in a direction to where it is clear, None where that is farther than `most`."""
    low, high = 0.0, first
    while not is_clear(high * direction):
        if high >= most:
            return None
        low, high = high, min(2 * high, most)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if is_clear(middle * direction) else (middle, high)
    return high


def _is_inside(x: Floats, y: Floats, faces: Ints, own_faces: Ints) -> bool:
    """Tell whether one of two surfaces that do not intersect is inside the other."""
    return abs(_winding(x[0], y, faces)) > 0.5 or abs(_winding(y[0], x, own_faces)) > 0.5


def _winding(point: Floats, x: Floats, faces: Ints) -> float:
    """Return how often a surface goes round a point. Source: van Oosterom and Strackee 1983."""
    a, b, c = (x[faces[:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    dots = [np.einsum("fc,fc->f", u, v) for u, v in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return float(np.arctan2(np.einsum("fc,fc->f", a, np.cross(b, c)), below).sum() / (2 * np.pi))
