"""`dev.py core release`: press some hundred meshes, let go, and see what comes back a second later."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from core.base import Bools, DimpleError
from core.body.model import build_model
from core.material import Material
from core.mesh.surface import Mesh, base_vertices

from .bodies import DOUGH, FOAM, GEL, NYLON, VINYL, WATER
from .primitives import makers
from .release import WAYS, Release, place_at, release

MATERIALS = {"nylon": NYLON, "vinyl": VINYL, "water": WATER, "gel": GEL, "dough": DOUGH, "foam": FOAM}
TIPS = (0.008, 0.015, 0.025)  # [m] radii of the fingertips
SEED = 3  # of the places that are pressed
FEW = 200  # vertices: liquids on fewer are summed up apart


def run_mesh(
    name: str, mesh: Mesh, materials: Sequence[tuple[str, Material]], ways: Sequence[str]
) -> Iterator[Release]:
    """Yield what comes back of presses on one mesh, a material for each fingertip; none where nothing is free.

    Raises:
        DimpleError: it cannot be simulated.
    """
    rng = np.random.default_rng(SEED)
    for way in ways:
        for radius, (label, material) in zip(TIPS, materials, strict=True):
            pinned: Bools | None = base_vertices(mesh) if WAYS[way][2] else None
            model = build_model(mesh, [material], pinned=pinned)
            if model.free:  # a body pinned at one vertex swings on
                model = build_model(mesh, [material])
            free = np.flatnonzero(~model.pinned)
            if len(free):
                place = place_at(mesh, int(rng.choice(free)))
                yield release(model, place, way, radius, mesh=name, material=label)


def add_release(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_release)
    command.add_argument("--json", type=Path, metavar="FILE", help="write each press and the sum")
    command.add_argument("--meshes", type=Path, metavar="FOLDER", help="press its meshes too: .obj, .stl, .ply")
    command.add_argument("--ways", nargs="+", choices=WAYS, default=["press"], help="how (default: press)")
    command.add_argument("--spread", type=float, metavar="MM", help="of all materials, in place of their own")
    command.add_argument("--only", default="", metavar="WORD", help="only meshes whose name has it")


def run_release(options: argparse.Namespace) -> int:
    """Press, print what did not come back, and sum up; the exit code is 1 where something did not."""
    materials = [
        (name, material if options.spread is None else replace(material, spread=1e-3 * options.spread))
        for name, material in MATERIALS.items()
    ]
    found: list[Release] = []
    count, refused = 0, {}
    for name, make in makers(options.meshes).items():
        if options.only not in name:
            continue
        mesh = make()
        some = [materials[(3 * count + i) % len(materials)] for i in range(len(TIPS))]
        if count % 4 >= 2:  # other radii for them
            some = some[1:] + some[:1]
        count += 1
        try:
            for one in run_mesh(name, mesh, some, options.ways):
                found.append(one)
                if not one.back or one.flipped:
                    print(line(one), flush=True)
        except DimpleError as error:
            refused[name] = str(error)
            print(f"{name}: {error}")
    total = summary(found, count, refused)
    print(json.dumps(total, indent=1))
    if options.json:
        try:
            rows = [asdict(one) for one in found]
            options.json.write_text(json.dumps({**total, "rows": rows}, indent=1) + "\n", encoding="utf-8")
        except OSError as error:
            raise DimpleError(f"{options.json} cannot be written: {error.strerror}.") from None
    return int(not all(one.back for one in found))


def line(one: Release) -> str:
    """Return one press in words."""
    words = [
        f"{one.mesh} ({one.vertices}), {one.material}, {one.way}",
        f"tip {1e3 * one.radius:g} mm, {1e3 * one.depth:.1f} mm deep, {one.force:.1f} N",
        f"residual {100 * one.residual:.3f} % of the size",
        f"{100 * one.residual_unspun:.3f} % without its spin of {one.spin:.1f} rad/s" if one.free else "",
        f"{one.kinetic:.1e} J",
        f"volume {100 * one.volume_change:+.2f} %",
        f"faces flipped {one.flipped_held} then {one.flipped}",
        one.note,
    ]
    return ", ".join(word for word in words if word)


def summary(found: Sequence[Release], count: int, refused: dict[str, str]) -> dict[str, object]:
    """Return the sums over all presses."""
    worst = max(found, key=lambda one: one.residual_unspun, default=None)
    liquids = [one for one in found if MATERIALS[one.material].fill == "liquid"]
    volumes = [max((abs(one.volume_change) for one in some), default=0.0) for some in (
        [one for one in liquids if one.vertices < FEW], [one for one in liquids if one.vertices >= FEW])]  # fmt: skip
    ways = {
        way: {
            "presses": len(some), "not_back": sum(not one.back for one in some),
            "flipped": sum(one.flipped > 0 for one in some), "blown_up": sum(not one.finite for one in some),
            "worst_residual": max(one.residual_unspun for one in some),
        }
        for way in WAYS
        if (some := [one for one in found if one.way == way])
    }  # fmt: skip
    return {
        "meshes": count, "meshes_pressed": len({one.mesh for one in found}), "presses": len(found),
        "not_back": sum(not one.back for one in found), "ways": ways, "refused": refused,
        "worst": line(worst) if worst else "",
        "liquid_volume_change_below_200_vertices": volumes[0], "liquid_volume_change_from_200_vertices": volumes[1],
    }  # fmt: skip
