"""Bodies and motions on which the native core must do what numpy does."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from core.base import Floats
from core.body.model import Model, build_model
from core.material import FINGERTIP, Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.native import Body
from core.native.motion import FingertipMotion, Frame, Motion, PinMotion
from studies.motions import straight
from studies.paper_objects import PRESETS
from tests.bodies import REAL, ball, fan, hemisphere, joined, real, sheet, soup, walled_box

SOFT = Material(K1=610, K2=7230, x0=0.0163, k=600, mass=0.2, fill="liquid")
SIZE = 0.16
TICK = 1e-3


@dataclass(frozen=True, kw_only=True)
class Case:
    """Describe a body and what happens to it.

    hold: "base" or "free".  fingers: how many press.  thrown: start with random velocities.
    moved: pins move, and with them the shape at rest.
    options: of build_model.
    """

    shape: Callable[[], tuple[Floats, Any]]
    material: Material = SOFT
    hold: str = "base"
    fingers: int = 1
    thrown: bool = False
    moved: bool = False
    ticks: int = 20
    options: dict[str, Any] = field(default_factory=dict)


def crumpled() -> tuple[Floats, Any]:
    points, faces = ball(2)
    return points * np.random.default_rng(3).uniform(0.7, 1.3, (len(points), 1)), faces


def needles() -> tuple[Floats, Any]:
    points, faces = ball(2)
    return points * (1.0, 0.02, 1.0), faces


def tangle(seed: int) -> tuple[Floats, Any]:
    """Return triangles between random points: edges of many faces, points of none, faces twice and without area."""
    rng = np.random.default_rng(seed)
    points, faces = rng.normal(size=(24, 3)), rng.integers(0, 20, (40, 3))
    points[faces[0, 2]] = points[faces[0, :2]].mean(axis=0)
    return points, np.concatenate([faces, faces[:4], faces[4:8, ::-1], faces[8:10, [0, 1, 0]]])


def with_loose() -> tuple[Floats, Any]:
    points, faces = ball(1)
    return np.concatenate([points, [[3.0, 3, 3]]]), faces


WHOLE = {
    "liquid": Case(shape=lambda: ball(2)),
    "air": Case(shape=lambda: ball(2), material=replace(SOFT, fill="air")),
    "pumped air": Case(shape=lambda: ball(2), material=replace(SOFT, fill="air", pressure=2e4), hold="free"),
    "drawn liquid": Case(shape=lambda: ball(2), material=replace(SOFT, pressure=-2e4)),
    "solid": Case(shape=lambda: ball(2), material=replace(SOFT, fill="solid", indenter=FINGERTIP), fingers=2),
    "solid, beyond its knee": Case(
        shape=lambda: ball(2), material=replace(SOFT, fill="solid", x0=1e-3, indenter=FINGERTIP)
    ),
    "no fill": Case(shape=lambda: ball(2), material=replace(SOFT, fill="none")),
    "beyond its knee": Case(shape=lambda: ball(2), material=replace(SOFT, x0=1e-3)),
    "free": Case(shape=lambda: ball(2), hold="free", thrown=True),
    "free solid": Case(
        shape=lambda: (ball(2)[0] * (1, 0.7, 0.4), ball(2)[1]), hold="free", thrown=True, fingers=2,
        material=replace(SOFT, fill="solid", indenter=FINGERTIP),
    ),
    "free on the ground": Case(shape=lambda: ball(2), hold="free", options={"ground": -0.5, "gravity": (0, 0, -9.81)}),
    "in slices": Case(shape=lambda: ball(4), hold="free", ticks=4, options={"ground": -0.5, "gravity": (0, 0, -9.81)}),
    "lifted by three": Case(shape=lambda: ball(2), hold="free", fingers=3, options={"gravity": (1, 0, -9.81)}),
    "moving pins": Case(shape=lambda: ball(2), moved=True, thrown=True),
    "slippery": Case(shape=lambda: ball(2), material=replace(SOFT, friction=0.0)),
    "undamped": Case(shape=lambda: ball(2), material=replace(SOFT, damping_ratio=0.0), thrown=True),
    "soft in places": Case(shape=lambda: ball(2), options={"softness": "random"}),
    "measured cube": Case(shape=lambda: ball(2), material=PRESETS[2].material),
    "one eighth of a group": Case(shape=lambda: ball(0), thrown=True),
}
DEGENERATE = {
    "a hole": Case(shape=hemisphere, ticks=12),  # later a corner of the skin slides or holds by the last digit
    "a sheet": Case(shape=sheet, thrown=True),
    "a free sheet": Case(shape=sheet, hold="free", thrown=True),
    "a flat body": Case(shape=needles, hold="free", thrown=True),
    "a wide fan": Case(shape=fan),
    "three walls at an edge": Case(shape=walled_box, hold="free", thrown=True),
    "soup": Case(shape=lambda: soup(ball(1))),
    "crumpled": Case(shape=crumpled, thrown=True),
    "two bodies": Case(shape=lambda: joined(ball(1), (ball(1)[0] + (3, 0, 0), ball(1)[1])), hold="free", thrown=True),
    "a loose vertex": Case(shape=with_loose, hold="free", options={"gravity": (0, 0, -9.81)}),
    "one triangle": Case(shape=lambda: (np.eye(3), np.array([[0, 1, 2]])), hold="free", thrown=True),
    "tangle 1": Case(shape=lambda: tangle(1), thrown=True, ticks=2),
    "tangle 2": Case(shape=lambda: tangle(2), hold="free", thrown=True, fingers=3, ticks=2),
    "tangle 3": Case(shape=lambda: tangle(3), options={"gravity": (0, 0, -9.81)}, ticks=2),
    "everything pinned": Case(shape=lambda: ball(1), options={"pinned": "all"}),
}
SCANS = {name: Case(shape=partial(real, name), material=PRESETS[1].material, ticks=4) for name in REAL}
CASES = WHOLE | DEGENERATE | SCANS


def build(case: Case) -> tuple[Model, Floats, Motion]:
    """Return a model of SIZE [m], the velocities (3, n) [m/s] it starts with, and what happens to it."""
    rng = np.random.default_rng(7)
    points, faces = case.shape()
    mesh: Mesh = mesh_from_triangles(points * SIZE / np.ptp(points, axis=0).max(), faces)
    options = dict(case.options)
    pinned = base_vertices(mesh) if case.hold == "base" else None
    if options.get("pinned") == "all":
        pinned, _ = np.ones(len(points), bool), options.pop("pinned")
    if "softness" in options:
        options["softness"] = rng.uniform(0, 1, len(points))
    if "ground" in options:
        options["ground"] *= SIZE
    model = build_model(mesh, [case.material], pinned=pinned, **options)
    velocities, free = np.zeros_like(model.matching.rest), model.inverse_mass > 0
    if case.thrown:
        velocities[:, free] = rng.normal(0, 0.1, (3, int(free.sum())))
    return model, velocities, Motion(
        ticks=case.ticks, substeps=model.substeps(TICK), tick=TICK, fingertips=_fingertips(mesh, case),
        pins=_pins(model, rng) if case.moved else None,
    )  # fmt: skip


def _fingertips(mesh: Mesh, case: Case) -> tuple[FingertipMotion, ...]:
    """Return fingertips that go inward by 0.2 mm a tick from 0.01 mm above the skin, from above and from two sides."""
    radius, tips = 0.1 * SIZE, []
    used = mesh.rest_positions[~mesh.loose]
    for outward in np.array([[0.1, 0, 1.0], [0.9, 0.3, 0.3], [-0.9, 0.3, 0.3]])[: case.fingers]:
        outward = outward / np.linalg.norm(outward)
        at = used[(used @ outward).argmax()]
        start, end = (at + (radius - depth) * outward for depth in (-1e-5, 2e-4 * case.ticks - 1e-5))
        tips.append(straight(start.tolist(), end.tolist(), ticks=case.ticks, radius=radius, fresh=True))
    return tuple(tips)


def _pins(model: Model, rng: np.random.Generator) -> PinMotion:
    """Return pins that are turned a little and shifted, and do not quite arrive."""
    start = model.matching.rest[:, model.pinned]
    turn, _ = np.linalg.qr(np.eye(3) + 0.05 * rng.normal(size=(3, 3)))
    end = turn * np.sign(np.diag(turn)) @ start + np.array([[2e-3], [0.0], [1e-3]])
    return PinMotion(start, end, 0.03, 0.9)


def run(body: Body, velocities: Floats, motion: Motion, *, positions: Floats | None = None) -> Frame:
    """Put a body at rest, or at positions (3, n) [m], throw it and run a motion."""
    body.set_state(body.model.matching.rest if positions is None else positions, velocities)
    return body.step(motion)
