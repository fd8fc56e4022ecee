"""Cells on a fine surface, and what its vertices follow, as the native core makes them."""

from __future__ import annotations

import numpy as np

from core.base import Bools, Floats, Ints, Shorts
from core.constants import FOLLOWED, LANES
from core.reduction.binding import WHOLE


def farthest_first(places: Floats, taken: int, least: float, most: int) -> Ints:
    """Choose points one by one, each the farthest from all chosen before.

    Args:
        places: (n, 6) [m].
        taken: how many of the first were chosen before.
        least: square of a distance that is too near [m2].
        most: to choose.
    """
    chosen: list[int] = []
    near = np.full(len(places), np.inf)
    for place in places[:taken]:
        np.minimum(near, ((places - place) ** 2).sum(axis=1), out=near)
    while len(near) and len(chosen) < most and near[at := int(near.argmax())] > least:
        chosen.append(at)
        np.minimum(near, ((places - places[at]) ** 2).sum(axis=1), out=near)
    return np.array(chosen, np.int64)


def spread_cells(ends: Ints, place: Floats, seeds: Ints) -> tuple[Ints, Bools]:
    """Return the seed (n,) each vertex belongs to by now, -1 where none spreads to.

    In rounds: what changed in the last one offers its cell to its neighbours, and each takes the nearest seed if that
    is nearer than its own; of two as near, the first.

    Args:
        ends: (m, 2) edges.

    Returns:
        The cells, and whether (n,) its cell joins each vertex to its seed.
    """
    i, j = np.concatenate([ends, ends[:, ::-1]]).T
    cells, away = np.full(len(place), -1), np.full(len(place), np.inf)
    cells[seeds], away[seeds] = np.arange(len(seeds)), 0.0
    changed = cells >= 0
    while changed.any():
        new = changed[i] & (cells[i] != cells[j])
        end, offered = j[new], cells[i[new]]
        distance = ((place[end] - place[seeds[offered]]) ** 2).sum(axis=1)
        order = np.lexsort((offered, distance, end))
        end, first = np.unique(end[order], return_index=True)
        nearest, offered = distance[order][first], offered[order][first]
        better = nearest < away[end]
        cells[end[better]], away[end[better]] = offered[better], nearest[better]
        changed = np.zeros(len(place), bool)
        changed[end[better]] = True
    joined, same = np.zeros(len(place), bool), cells[i] == cells[j]
    joined[seeds], i, j = True, i[same], j[same]
    while (reached := joined[i] & ~joined[j]).any():
        joined[j[reached]] = True
    return cells, joined


def nearest_seeds(place: Floats, seeds: Ints, cells: Ints, around: Ints) -> tuple[Ints, Shorts, Shorts]:
    """List the nearest of the seeds round the cell of each vertex, and their weights.

    Args:
        around: (m, w) seeds round each cell, the rest of a row -1.

    Returns:
        first (g + 1,), followed (p,) and weights (p, 8) of a `Binding`.
    """
    n, width = len(place), around.shape[1]
    followed, weights = np.empty((n, FOLLOWED), np.int64), np.empty((n, FOLLOWED), np.uint16)
    for part in np.array_split(np.arange(n), n * width // 1_000_000 + 1):
        ring = around[cells[part]]
        distance = ((place[part, None] - place[seeds[ring]]) ** 2).sum(axis=2)
        distance[ring < 0] = np.inf
        near = distance.argsort(axis=1, kind="stable")[:, : FOLLOWED + 1]
        away = np.take_along_axis(distance, near, axis=1)
        bound = np.where(np.isfinite(away), away, -np.inf).max(axis=1, keepdims=True) * (1 + 1e-9)
        share = np.where(np.isfinite(away), np.maximum(1 - away / np.maximum(bound, 1e-30), 0) ** 2, 0.0)[:, :-1]
        share[:, 0] += 1e-30
        followed[part] = np.take_along_axis(ring, near, axis=1)[:, :-1]
        parts = (share / sum(share.T)[:, None] * WHOLE).astype(np.uint16)
        parts[:, 0] += (WHOLE - parts.sum(axis=1, dtype=np.int64)).astype(np.uint16)  # the sum is exact
        weights[part] = parts
    eight, lane = np.divmod(np.arange(n), LANES)
    there = followed >= 0
    pairs, entry = np.unique(((eight << 16)[:, None] + followed)[there], return_inverse=True)
    listed = np.zeros((len(pairs), LANES), np.uint16)
    listed[entry, np.broadcast_to(lane[:, None], there.shape)[there]] = weights[there]
    first = np.searchsorted(pairs, np.arange(-(-n // LANES) + 1) << 16)
    return first, (pairs & 0xFFFF).astype(np.uint16), listed
