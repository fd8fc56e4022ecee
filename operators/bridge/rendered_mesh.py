"""The final mesh of an object in a render, if it differs from the viewport's, and the transfer of offsets to it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from ..names import PRESS
from . import press_modifier
from .final_mesh import Final, cuts_of, evaluated, points_of, triangles_of
from .press_modifier import Shown, new_carrier

if TYPE_CHECKING:
    from .object_link import Singles


def shown(
    context: bpy.types.Context, body: bpy.types.Object, count: int, cuts: int
) -> list[tuple[Shown, Carried | None]]:
    """Return how to show the final mesh of an object in the viewport and, if that differs, in a render, each with the
    transfer of the viewport's offsets to it, None for the viewport.

    Args:
        count: number of offsets, one for each vertex of the viewport's mesh after subdivision.
        cuts: number of subdivisions of the viewport's mesh, unless it has that number of vertices already.
    """
    given = len(evaluated(context, body).vertices)
    cuts = 0 if given == count else cuts
    with as_rendered(body):
        mesh = evaluated(context, body)
        rendered, there = len(mesh.vertices), None
        if rendered != given:
            there = _final(context, body, rendered, cuts_of(context, body, mesh))
    carried = _carried(_final(context, body, given, cuts), there.points) if there else None
    found: list[tuple[Shown, Carried | None]] = [(Shown(given, cuts, new_carrier(count)), None)]
    if there and carried:
        found.append((Shown(rendered, there.cuts, new_carrier(len(carried.corners))), carried))
    return found


class Carried(NamedTuple):
    """The transfer of offsets to the vertices of another mesh: each vertex follows the nearest triangle."""

    corners: np.ndarray  # (M, 3) vertices of the nearest triangle
    shares: np.ndarray  # (M, 3) barycentric weights of these vertices

    def carry(self, offsets: Singles) -> Singles:
        """Return the offsets (M, 3) of the other mesh for offsets (N, 3) of the first one."""
        return np.einsum("mc,mcd->md", self.shares, offsets[self.corners])


def _carried(final: Final, points: Singles) -> Carried:
    """Return the transfer of offsets of a final mesh to other points (M, 3) on or near it."""
    from mathutils.bvhtree import BVHTree

    tree = BVHTree.FromPolygons(final.points.tolist(), final.triangles.tolist())
    nearest = [tree.find_nearest(point)[::2] for point in points.tolist()]
    at, number = np.array([[*place] for place, _ in nearest]), np.array([each for _, each in nearest])
    corners = final.triangles[number]
    a, b, c = final.points[corners].astype(np.float64).transpose(1, 0, 2)
    whole = np.cross(b - a, c - a)
    parts = [np.cross(v - u, at - u) for u, v in ((b, c), (c, a), (a, b))]
    shares = np.stack([(each * whole).sum(axis=1) for each in parts], axis=1)
    total = shares.sum(axis=1)
    flat = total <= 0
    shares[flat], total[flat] = (1, 0, 0), 1
    return Carried(corners, np.asarray(shares / total[:, None], np.float32))


def _final(context: bpy.types.Context, body: bpy.types.Object, given: int, cuts: int) -> Final:
    press_modifier.add(body, "Dimple Press", PRESS, [Shown(given, cuts, new_carrier())])
    try:
        mesh = evaluated(context, body)
        return Final(points_of(mesh), *triangles_of(mesh), cuts)
    finally:
        press_modifier.remove(body, PRESS)


@contextmanager
def as_rendered(body: bpy.types.Object) -> Iterator[None]:
    """Make the viewport evaluate an object as a render does, within the context."""
    before = [(each, each.show_viewport, getattr(each, "levels", None)) for each in body.modifiers]
    try:
        for each, was_shown, level in before:
            if each.show_render != was_shown:
                each.show_viewport = each.show_render
            if hasattr(each, "render_levels") and each.render_levels != level:
                each.levels = each.render_levels
        yield
    finally:
        for each, was_shown, level in before:
            if each.show_viewport != was_shown:
                each.show_viewport = was_shown
            if level is not None and each.levels != level:
                each.levels = level
