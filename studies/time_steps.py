"""How the force of a press depends on the length of the time steps: as many as a session takes, three and ten times."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from core.body.model import build_model
from core.material import PRESETS
from core.mesh.refine import is_coarse, refine
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.session import Finger, Session

from .primitives import PRIMITIVES, Shape

TIMES = (1, 3, 10)
SHAPES = ("default cube", "UV sphere 32 x 16", "ico sphere 3")
DEPTHS = (0.005, 0.010, 0.015, 0.020, 0.025)  # [m]
SPEEDS = (0.010, 0.040)  # [m/s]
TIP = 0.010  # [m]
ASIDE = (0.0013, 0.0007)  # [m] from the middle, where no vertex and no edge is
SETTLING, LISTENING = 0.25, 0.05  # [s]


def rows() -> Iterator[dict[str, object]]:
    """Yield a row for each press; shake: how fast the skin still moves at the end, in steps as a session takes."""
    for shape in SHAPES:
        for preset in PRESETS:
            mesh = as_simulated(PRIMITIVES[shape](), preset.size)
            model = build_model(mesh, [preset.material], pinned=base_vertices(mesh))
            for speed in SPEEDS:
                found = [list(_pressed(Session(model), speed, times)) for times in TIMES]
                for depth, *each in zip(DEPTHS, *found, strict=True):
                    forces = {f"force_{t}x_n": round(force, 4) for t, (force, _) in zip(TIMES, each, strict=True)}
                    finest = each[-1][0]
                    off = {f"off_{t}x_percent": round(100 * (force / finest - 1), 2)
                           for t, (force, _) in zip(TIMES[:-1], each, strict=False)}  # fmt: skip
                    yield {
                        "shape": shape, "object": preset.name, "vertices": len(model.mass), "mm_s": round(1e3 * speed),
                        "depth_mm": 1e3 * depth, **forces, **off, "shake_mm_s": round(1e3 * each[0][1], 1),
                    }  # fmt: skip


def as_simulated(made: Shape, size: float) -> Mesh:
    """Return a shape of a size [m], cut finer as a session does it."""
    points, faces = made
    points = points * (size / np.ptp(points, axis=0).max())
    if is_coarse(points, faces, TIP):
        finer = refine(points, faces, np.zeros(len(faces), np.int64), TIP)
        points, faces = finer.at_vertices(points), finer.triangles
    return mesh_from_triangles(points, faces)


def _pressed(session: Session, speed: float, times: int) -> Iterator[tuple[float, float]]:
    """Press to each depth in turn and hold; yield the force [N] and the fastest vertex [m/s]."""
    top, at = float(session.model.mesh.rest_positions[:, 2].max()) + TIP, 0.0
    session.substeps *= times
    session.set_fingers([Finger((*ASIDE, top), TIP)])
    session.step(session.clock.tick)
    for depth in DEPTHS:
        session.set_fingers([Finger((*ASIDE, top - depth), TIP)])
        session.step((depth - at) / speed)
        session.step(SETTLING)
        frame, at = session.step(LISTENING), depth
        yield float(frame.finger_forces[0, 2]), float(np.abs(session.body.velocities()).max())
