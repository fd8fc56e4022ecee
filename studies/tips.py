"""How well and how fast a body is identified: Table 2's objects under points, punches and balls, on several meshes.

`python3 dev.py core tips` prints a line for each, with `--json FILE` the same as rows.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from core.base import DimpleError
from core.body.estimate import bed_area, estimate
from core.body.model import build_model
from core.calibration.identify import Identification
from core.calibration.indent import Site
from core.calibration.inversion import STEEPEST, STEEPEST_COARSE, inverted, piece_ends, pulled
from core.calibration.place import typical_site
from core.material import POINT, PRESETS, Indenter, Preset
from core.mesh.surface import Mesh
from core.steps import result_of

from .flat_bed import least_missed
from .reconstruct import DEEPEST
from .scenes import ball, cube
from .virtual_press import identify

TIPS = (
    POINT, Indenter(shape="punch", radius=0.005),
    *(Indenter(shape="sphere", radius=radius) for radius in (0.005, 0.010, 0.025)),
)  # fmt: skip
CUBES, BALLS = (10, 20, 41), (3, 4, 5)  # cells along an edge, subdivisions: 600, 2,400 and 10,000 vertices
FREE = 1e9  # times the first slope: no limit
RMS, WORST, WORST_FORCE = 0.01, 0.05, 0.15  # what a row should keep: shares of full scale, and [N]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One identification.

    body, tip: what was pressed, and with what.
    vertices: of the mesh.
    seconds: of processor time.
    rms, worst: errors of the force over full scale.
    worst_force: the largest error [N].
    end: the force at the deepest over the measured one.
    deepest: [mm].
    note: why it ends before the depth asked for.
    why: "" or why it is not kept, in numbers.
    """

    body: str
    tip: str
    vertices: int
    seconds: float
    rms: float
    worst: float
    worst_force: float
    end: float
    deepest: float
    note: str
    why: str = ""

    @property
    def kept(self) -> bool:
        """Tell whether the error is as small as it should be at every depth."""
        return self.rms <= RMS and (self.worst <= WORST or self.worst_force <= WORST_FORCE)


def rows(presets: Sequence[Preset], tips: Sequence[Indenter], sizes: int) -> Iterator[Row]:
    """Identify each object with each tip on a cube and a ball of so many sizes."""
    for preset in presets:
        for tip in tips:
            for shape, number in [("cube", n) for n in CUBES[:sizes]] + [("ball", n) for n in BALLS[:sizes]]:
                mesh = cube(number, preset.size) if shape == "cube" else ball(number, preset.size / 2)
                yield _row(preset, shape, mesh, tip)


def _row(preset: Preset, shape: str, mesh: Mesh, tip: Indenter) -> Row:
    label, words = preset.name[:8], f"{tip.shape} {1e3 * tip.radius:g} mm"
    started = time.process_time()
    try:
        site = typical_site(mesh, tip)  # where the product presses to identify
        found = identify(mesh, preset.material, tip, site, DEEPEST[preset.name])
    except DimpleError as error:
        nothing = float("nan")
        return Row(
            body=f"{label} {shape}", tip=words, vertices=len(mesh.rest_positions), seconds=0.0, rms=nothing,
            worst=nothing, worst_force=nothing, end=nothing, deepest=0.0, note=str(error),
        )  # fmt: skip
    row = _of(found, f"{label} {shape}", words, mesh, time.process_time() - started)
    return row if row.kept or tip.shape != "sphere" else replace(row, why=_why(found, site, mesh, tip))


def _why(found: Identification, site: Site, mesh: Mesh, tip: Indenter) -> str:
    """Return why a round tip is not met, each cause in numbers.

    That is what a bed without a mesh would miss, what as many presses again leave, and how few vertices
    carry the force.
    """
    deepest, again = float(found.depths[-1]), _again(found, site, mesh)
    material = replace(found.material, constants=None)
    model, first = build_model(mesh, [material]), estimate(material, mesh.size)
    steepest = max(
        STEEPEST * pulled(model, model.matching.k1 / first.kappa1) / first.kappa1,
        STEEPEST_COARSE * max(first.kappa2 / first.kappa1, 1.0),
    )
    free, limited = (100 * least_missed(material, tip, mesh.size, deepest, most) for most in (FREE, steepest))
    _, contact = bed_area(tip, mesh.size, material.spread, min(material.x0, deepest))
    touched = np.pi * contact**2 / float(mesh.vertex_areas.mean())
    return (
        f"on a flat bed without a mesh the best law misses {free:.2f} % RMS, and {limited:.2f} % with slopes up to "
        f"{steepest:.0f} times the first, which the step allows; as many presses again leave {again:.2f} %; "
        f"at the knee {touched:.1f} vertices touch the tip "
        f"({1e3 * contact:.1f} mm of contact, {1e3 * float(np.median(mesh.rest_lengths)):.1f} mm apart), "
        f"and with each that joins the force turns; pressed to {100 * deepest / mesh.size:.0f} % of the size"
    )


def _again(found: Identification, site: Site, mesh: Mesh) -> float:
    """Return the RMS error [% of full scale] that is left after going on from what was found with as many presses."""
    constants, ends = found.material.constants, piece_ends(found.material.x0, float(found.depths[-1]))
    assert constants
    slopes = constants.kappa1 + np.cumsum([0.0, *(more for _, more in constants.pieces)])
    steps = inverted(mesh, found.material, replace(constants, pieces=()), site, ends, slopes, 0.0)
    _, stations = result_of(steps)
    wanted = np.array([found.material.law(station.depth) for station in stations])
    missed = np.array([station.force for station in stations]) - wanted
    return 100 * min(found.rms, float(np.sqrt((missed**2).mean()) / wanted.max()))


def _of(found: Identification, body: str, tip: str, mesh: Mesh, seconds: float) -> Row:
    off, full = np.abs(found.simulated - found.wanted), float(found.wanted.max())
    return Row(
        body=body, tip=tip, vertices=len(mesh.rest_positions), seconds=seconds, rms=found.rms,
        worst=float(off.max()) / full, worst_force=float(off.max()),
        end=float(found.simulated[-1] / found.wanted[-1]), deepest=1e3 * float(found.depths[-1]), note=found.stopped,
    )  # fmt: skip


def add_tips(command: argparse.ArgumentParser) -> None:
    """Take the options of `core tips`."""
    command.add_argument("--json", type=Path, help="write the rows there")
    command.add_argument("--sizes", type=int, default=3, choices=(1, 2, 3), help="600, 2,400 and 10,000 vertices")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print a line for each identification, and the medians of the time it takes."""
    found = []
    for row in rows(PRESETS, TIPS, options.sizes):
        found.append(row)
        print(
            f"{row.body:14} {row.tip:12} {row.vertices:6} vertices {row.seconds:6.2f} s  rms {100 * row.rms:6.2f} %  "
            f"worst {100 * row.worst:6.2f} % {row.worst_force:6.2f} N  at {row.deepest:4.1f} mm {row.end:5.3f} of it"
            f"{'' if row.kept else '  *'}",
            flush=True,
        )
        if row.why:
            print(f"    {row.why}", flush=True)
    for size in sorted({len(str(row.vertices)) for row in found}):
        times = [row.seconds for row in found if len(str(row.vertices)) == size]
        print(f"vertices of {size} digits: median {statistics.median(times):.2f} s of processor time")
    kept = sum(row.kept for row in found)
    print(f"{kept} of {len(found)} within {RMS:.0%} RMS and {WORST:.0%} or {WORST_FORCE} N at worst; the others: *")
    if options.json:
        options.json.write_text(json.dumps([asdict(row) for row in found], indent=1) + "\n", encoding="utf-8")
    return 0
