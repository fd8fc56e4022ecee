"""Mending a broken surface: soup is welded, neighbours are made to face the same way, closed parts face outward."""

from __future__ import annotations

from collections import deque
from itertools import product

import numpy as np

from ..base import Bools, Floats, Ints, sums_at


def connected(pairs: Ints, n: int) -> Ints:
    """Return for each of n things the lowest (n,) it is joined to through pairs (m, 2)."""
    label = np.arange(n)
    while len(pairs):
        low = np.minimum(label[pairs[:, 0]], label[pairs[:, 1]])
        before = label.copy()
        # the labels themselves are joined too, so that long chains take few rounds
        for end in (label[pairs[:, 0]], label[pairs[:, 1]], pairs[:, 0], pairs[:, 1]):
            np.minimum.at(label, end, low)
        label = label[label]
        if (label == before).all():
            break
    return label


def weld(positions: Floats, cell: float) -> tuple[Ints, Ints]:
    """Find the vertices that lie in one place: always nearer than half a cell [m], never farther than a few.

    Returns:
        one vertex of each place (n,), and the place of every vertex (N,).
    """
    import trimesh

    pairs = []
    # near points may lie on two sides of a grid line, but not of both of two grids half a cell apart
    for shift in product((0.0, 0.5), repeat=3):
        first, place = trimesh.grouping.unique_rows(np.floor(positions / cell + shift).astype(np.int64))
        mate = first[place]
        moved = np.flatnonzero(mate != np.arange(len(mate)))
        pairs.append(np.stack([mate[moved], moved], axis=1))
    label = connected(np.concatenate(pairs), len(positions))
    kept, source = np.unique(label, return_inverse=True)
    return kept, source


def agreeing(faces: Ints, adjacency: Ints) -> Ints:
    """Turn faces (t, 3) so that neighbours agree (walk from face to face); most of each part stay as they were."""
    neighbours: list[list[int]] = [[] for _ in faces]
    for a, b in adjacency:
        neighbours[a].append(int(b))
        neighbours[b].append(int(a))
    turned, seen = faces.copy(), np.zeros(len(faces), bool)
    for start in range(len(faces)):
        if seen[start]:
            continue
        seen[start], queue, part = True, deque([start]), [start]
        while queue:
            here = queue.popleft()
            edges = {(int(turned[here, c]), int(turned[here, (c + 1) % 3])) for c in range(3)}
            for there in neighbours[here]:
                if not seen[there]:
                    a, b, c = (int(v) for v in turned[there])
                    if edges & {(a, b), (b, c), (c, a)}:
                        turned[there] = (c, b, a)
                    seen[there] = True
                    queue.append(there)
                    part.append(there)
        if 2 * (turned[part] != faces[part]).any(axis=1).sum() > len(part):
            turned[part] = turned[part][:, ::-1]
    return turned


def inward_parts(positions: Floats, faces: Ints, adjacency: Ints, mended: Bools) -> Bools:
    """Tell which faces (t,) belong to parts turned inside out; a part facing inward inside another is a cavity.

    Args:
        mended: (t,) was turned by `agreeing`; of open parts only those that hold such faces are judged.
    """
    inward = np.zeros(len(faces), bool)
    names, label = np.unique(connected(adjacency, len(faces)), return_inverse=True)
    count, corners = np.bincount(label), positions[faces]
    mean = np.stack([sums_at(label, corners[:, :, c].mean(axis=1), len(names)) / count for c in range(3)], axis=1)
    volume = sums_at(label, np.linalg.det(corners - mean[label][:, None]), len(names))
    for part in np.flatnonzero(volume < 0):
        mine = label == part
        if _balanced(faces[mine]) or mended[mine].any():
            inward[mine] = not _inside(corners[~mine], corners[mine][0, 0])
    return inward


def _balanced(faces: Ints) -> bool:
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    n = int(faces.max()) + 1
    return bool((np.sort(halves @ [n, 1]) == np.sort(halves @ [1, n])).all())


def _inside(triangles: Floats, point: Floats) -> bool:
    """Tell whether triangles (t, 3, 3) wind round a point (3,). Source: van Oosterom and Strackee, 1983."""
    r = triangles - point
    length = np.linalg.norm(r, axis=2)
    a, b, c = r[:, 0], r[:, 1], r[:, 2]
    below = length.prod(axis=1) + sum(
        (p * q).sum(axis=1) * length[:, k] for p, q, k in ((a, b, 2), (b, c, 0), (c, a, 1))
    )
    return abs(2 * np.arctan2(np.linalg.det(r), below).sum()) > 2 * np.pi
