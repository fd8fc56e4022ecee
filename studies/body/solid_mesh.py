"""Half sections of a solid ball and a block, finest where a fingertip presses: meshes for `studies.body.solid`.

The axis of the press is r = 0, the touched place is the origin and the body lies below it (z < 0).
"""

from __future__ import annotations

import numpy as np
from skfem import MeshQuad

from core.base import Floats, Ints

BALL_RADIUS = 0.080  # [m]
BALL_PINNED = 0.1  # share of its height
BLOCK_EDGE = 0.165  # [m] of a cube; computed as a cylinder of the same height and area
SHAPES = ("ball", "block")
OUTER_GROWTH = 1.2  # size of a ring over that of the ring inside it


def half_section(shape: str, patch: float, finest: float, growth: float, refine: float = 1.0) -> MeshQuad:
    """Return quadrilaterals (r, z) [m]: a patch at the touched place, and rings round it out to the other faces.

    The ball ends in the plane below which it is pinned.

    Args:
        shape: "ball" or "block".
        patch: how far the fine part reaches along and below the surface [m].
        finest: size of the element at the touched place [m].
        growth: size of an element over that of its inner neighbour in the patch.
        refine: elements along each side over those of the usual mesh.
    """
    steps = graded(patch, finest / refine, growth ** (1 / refine))
    if shape == "ball":
        radius, floor = BALL_RADIUS, -2 * BALL_RADIUS * (1 - BALL_PINNED)
        edge_angle = np.pi - np.arccos(1 - 2 * BALL_PINNED)
        corner = radius * np.sin(edge_angle)
        angle, down = steps / radius, radius - steps
        fine = np.stack([np.outer(np.sin(angle), down), np.outer(np.cos(angle), down) - radius], axis=-1)
        side = np.linspace([corner, floor], [corner / 2, floor], len(steps))
        base = np.linspace([0.0, floor], [corner / 2, floor], len(steps))
    elif shape == "block":
        wide, floor = BLOCK_EDGE / np.sqrt(np.pi), -BLOCK_EDGE
        fine = np.stack(np.meshgrid(steps, -steps, indexing="ij"), axis=-1)
        side = np.linspace([wide, 0.0], [wide, floor], len(steps))
        base = np.linspace([0.0, floor], [wide, floor], len(steps))
    else:
        raise ValueError(f"unknown shape {shape!r}: {', '.join(SHAPES)}")
    way = graded(1.0, float(steps[-1] - steps[-2]) / abs(floor), OUTER_GROWTH ** (1 / refine))
    right, below = ruled(fine[-1], side, way), ruled(fine[:, -1], base, way)
    if shape == "ball":  # its uppermost ray follows the skin; the others bend with it, less and less
        angles = angle[-1] + way * (edge_angle - angle[-1])
        skin = radius * np.stack([np.sin(angles), np.cos(angles) - 1], axis=-1)
        right += np.linspace(1, 0, len(steps))[:, None, None] * (skin - right[0])
    return joined([fine, right.swapaxes(0, 1), below])  # each turned the same way


def graded(length: float, first: float, growth: float) -> Floats:
    """Return places from 0 to a length in steps that grow by a factor, the first near `first`."""
    n = length / first if growth == 1 else np.log1p(length * (growth - 1) / first) / np.log(growth)
    places = np.concatenate([[0.0], np.cumsum(growth ** np.arange(max(2, round(n))))])
    return places * (length / places[-1])


def ruled(inner: Floats, outer: Floats, way: Floats) -> Floats:
    """Return (n, k, 2) points on straight lines from inner (n, 2) to outer (n, 2) at the shares (k,)."""
    return inner[:, None] + way[:, None] * (outer - inner)[:, None]


def joined(blocks: list[Floats]) -> MeshQuad:
    """Return one mesh of blocks of points (n, k, 2) whose touching points are the same."""
    quads: list[Ints] = []
    start = 0
    for block in blocks:
        n, k = block.shape[:2]
        index = start + np.arange(n * k).reshape(n, k)
        quads.append(np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]).reshape(4, -1))
        start += n * k
    points = np.concatenate([block.reshape(-1, 2) for block in blocks])
    _, first, same = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return MeshQuad(points[first].T.copy(), same.reshape(-1)[np.concatenate(quads, axis=1)])
