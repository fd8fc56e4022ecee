"""The paper's literal equations against the consistent laws: volume and force as a fingertip goes down."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.base import TICK
from core.body import pressure
from core.material import PRESETS
from core.mesh.surface import base_vertices

from .reference import paper
from .reference.path import FingerPath
from .scenes import FINGERTIP, cube, poke, poke_cube

DEPTH, SECONDS, FRAMES = 0.024, 0.25, 25  # [m], in [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """One moment of a press.

    laws: "consistent" or "paper".
    depth: of the fingertip [m].
    volume_ratio: volume over that at rest.
    force: on the fingertip [N].
    law_force: K(x) of Eq. (1) [N].
    """

    laws: str
    depth: float
    volume_ratio: float
    force: float
    law_force: float


def presses(*, cells: int) -> Iterator[Sample]:
    """Press Object 3 down to DEPTH in a quarter of a second by both; stop where the paper's blows up."""
    law = PRESETS[2].material.law
    for frame in poke(poke_cube(cells), depth=DEPTH, frame_rate=FRAMES / SECONDS, seconds=SECONDS):
        yield Sample(
            laws="consistent", depth=float(frame.depths[0]), volume_ratio=frame.volume / frame.rest_volume,
            force=float(frame.finger_forces[0, 2]), law_force=law(float(frame.depths[0])),
        )  # fmt: skip
    yield from literal_press(cells)


def literal_press(cells: int) -> Iterator[Sample]:
    """Press Object 3 by the paper's equations, tick by tick: Eq. (1) takes the depth at which one begins."""
    mesh, material = cube(cells, PRESETS[2].size), PRESETS[2].material
    model = paper.literal_model(mesh, [material], pinned=base_vertices(mesh))
    state, substeps = paper.at_rest(model), model.substeps(TICK)
    whole, each = round(SECONDS / TICK), round(SECONDS / TICK / FRAMES)
    for first in range(0, whole, each):
        impulse = 0.0
        for tick in range(first, first + each):
            down = DEPTH * np.array([tick, tick + 1]) / whole
            state.inner_force = paper.inner_force(material, [down[0]])
            centres = np.stack([0 * down, 0 * down, PRESETS[2].size / 2 + FINGERTIP - down], axis=1)[None]
            path = FingerPath(centres=centres, radii=np.array([FINGERTIP]))
            impulse += float(paper.run(model, state, path, tick=TICK, substeps=substeps)[0, 2])
        if not np.isfinite(state.positions).all():
            return
        volume = pressure.volume(model.pressure, state.positions)
        yield Sample(
            laws="paper", depth=float(down[1]), volume_ratio=volume / mesh.volume, force=impulse / (each * TICK),
            law_force=paper.inner_force(material, [float(down[1])]),
        )  # fmt: skip
