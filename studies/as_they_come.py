"""The force on a fingertip beside the measured law, on Blender's primitives as they come: cut finer, identified."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from core.base import Floats
from core.body.model import build_model
from core.calibration.identify import identification
from core.calibration.indent import Site, find_site
from core.calibration.place import measuring_site
from core.material import DEFAULT_MATERIAL, FINGERTIP
from core.mesh.surface import base_vertices
from core.session import Finger, Session
from core.steps import result_of

from .primitives import PRIMITIVES, SIZE
from .time_steps import as_simulated

Place = tuple[float, float, float]

DOWN, IN = (0.0, 0.0, -1.0), (-1.0, -0.2, 0.0)
POLE, BESIDE, BETWEEN, SIDE = (0.0, 0.0, 1.0), (0.06, 0.02, 1.0), (1.0, 0.2, 1.0), (1.0, 0.2, 0.0)
ROUND = {name: ((x, y, z), (-x, -y, -z)) for name, (x, y, z) in
         (("pole", POLE), ("beside it", BESIDE), ("between", BETWEEN), ("equator", SIDE))}  # fmt: skip
FLAT = {"middle": (POLE, DOWN), "beside it": (BESIDE, DOWN), "anywhere": ((-0.42, 0.31, 1.0), DOWN)}
# places in halves of the size, each with the way in
PLACES: dict[str, dict[str, tuple[Place, Place]]] = {
    **{f"UV sphere {name}": ROUND for name in ("32 x 16", "64 x 32", "16 x 8")},
    **{f"ico sphere {subdivisions}": ROUND for subdivisions in (2, 3, 4)},
    "default cube": FLAT,
    "plane": FLAT,
    "cylinder": {**FLAT, "flank": (SIDE, IN)},
    "cone": {"flank": ((0.5, 0.1, 0.0), (-1.0, -0.2, -0.5)), "edge of it": ((0.5, 0.0, 0.0), (-1.0, 0.0, -0.5))},
    "torus 48 x 12": {"top": ((0.8, 0.14, 0.2), DOWN), "outside": ((1.0, 0.17, 0.0), IN)},
}
DEPTHS = (0.005, 0.010, DEFAULT_MATERIAL.x0)  # [m]
SPEED, HELD, LISTENING = 0.08, 0.25, 0.05  # [m/s], [s], [s]


def rows() -> Iterator[dict[str, object]]:
    """Yield a row for each place: the force at each depth [N], and over the law."""
    for shape, places in PLACES.items():
        mesh = as_simulated(PRIMITIVES[shape](), SIZE)
        site = measuring_site(mesh, DEFAULT_MATERIAL, 1.5 * DEFAULT_MATERIAL.x0)
        steps = identification(mesh, DEFAULT_MATERIAL, FINGERTIP, site, 1.5 * DEFAULT_MATERIAL.x0)
        session = Session(build_model(mesh, [result_of(steps).material], pinned=base_vertices(mesh)))
        for place, (at, way) in places.items():
            above = (np.array(at) * SIZE / 2).tolist()
            forces = dict(_pressed(session, find_site(mesh, FINGERTIP, above=above, inward=way)))
            yield {
                "shape": shape, "vertices": len(mesh.rest_positions), "place": place,
                **{f"n_{1e3 * depth:g}_mm": round(force, 2) for depth, force in forces.items()},
                **{f"law_{1e3 * depth:g}_mm": round(force / DEFAULT_MATERIAL.law(depth), 3)
                   for depth, force in forces.items()},
            }  # fmt: skip


def _pressed(session: Session, site: Site) -> Iterator[tuple[float, float]]:
    """Press to each depth [m] in turn and hold; yield it and the force [N]."""
    def put(depth: float, seconds: float) -> Floats:
        x, y, z = (site.point + (depth - FINGERTIP.radius) * site.inward).tolist()
        session.set_fingers([Finger((x, y, z), FINGERTIP.radius)])
        return np.asarray(session.step(seconds).finger_forces)

    session.reset()
    before = 0.0
    put(before, session.clock.tick)
    for depth in DEPTHS:
        put(depth, (depth - before) / SPEED)
        put(depth, HELD)
        before = depth
        yield depth, -float(put(depth, LISTENING)[0] @ site.inward)
