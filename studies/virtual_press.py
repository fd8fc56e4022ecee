"""Identification and virtual press without Blender: run to the end instead of in steps between events."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from core.base import Floats
from core.calibration.identify import Identification, identification
from core.calibration.indent import ROWS, Site, press_rows
from core.material import Indenter, Material
from core.mesh.surface import Mesh


def identify(
    mesh: Mesh,
    material: Material,
    indenter: Indenter,
    site: Site,
    deepest: float,
    *,
    progress: Callable[[float], None] | None = None,
) -> Identification:
    """Run `identification` to its end.

    Args:
        mesh: in the size of the real object [m].
        material: K1, K2, x0 as measured with the indenter.
        deepest: depth [m] down to which the constants must hold.
        progress: called with the share that is done.

    Raises:
        DimpleError: the body cannot be pressed.
    """
    steps = identification(mesh, material, indenter, site, deepest)
    while True:
        try:
            share = next(steps)
        except StopIteration as end:
            found: Identification = end.value
            return found
        if progress is not None:
            progress(share)


def press_curve(
    mesh: Mesh, material: Material, indenter: Indenter, site: Site, deepest: float, *, rows: int = ROWS
) -> tuple[Floats, Floats]:
    """Return depth (n,) [m] and force (n,) [N] of a virtual press to a depth [m]; see `press_rows`."""
    depth, force = np.array(list(press_rows(mesh, material, indenter, site, deepest, rows=rows))).T
    return depth, force
