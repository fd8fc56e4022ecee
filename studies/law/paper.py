"""What of the paper can be made again, beside the printed numbers: Table 2, Fig. 7(a) and 7(b).

The paper's points were not published. The curves are reconstructed from Table 2, so what follows from them shows that
the way there and back is right, not that the paper measured well.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from core.base import Floats
from core.body.model import build_model
from core.calibration.calibrate import Calibration, calibrate
from core.calibration.surface_constant import string_balance
from core.calibration.virtual_press import find_site, press_rows, write_press
from core.material import Preset
from core.mesh.surface import base_vertices
from studies.files import new_figure, save_picture, write_csv
from studies.meshes.simple import cube
from studies.paper_objects import PRESETS
from studies.reference.paper import surface_stretch, surface_tension

CELLS, PRESS_ROWS = 16, 60  # along an edge of the cube that is pressed, 1538 vertices; of the press that is written
NOISE = 0.01  # of full scale: of a strain gauge on a cantilever, as the paper's
ROWS = 300
# how deep [m] each object is pressed; the paper does not say. Object 1 to nine tenths of its height.
DEEPEST = {"object_1_nylon_air": 0.045, "object_2_vinyl_air": 0.022, "object_3_vinyl_water": 0.020}
SECTION = 1e-6  # [m2] any: Eq. (10) needs A E, and the paper prints neither
NAMES = ("object", "constant", "printed", "from_the_curve", "half_width_95", "from_a_virtual_press")

Series = tuple[str, str, Floats, Floats]  # the panel it is drawn in, its name, x and y


def add_command(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run)
    command.add_argument("--out", type=Path, required=True, metavar="DIR", help="where tables and figures go")


def run(options: argparse.Namespace) -> int:
    """Make all again, write it and print the tables."""
    options.out.mkdir(parents=True, exist_ok=True)
    curves = [calibrate(p, length=preset.size) for p, preset in zip(write_samples(options.out), PRESETS, strict=True)]
    virtual = [virtual_press(preset, options.out) for preset in PRESETS]
    table_2 = list(constants(curves, virtual))
    write_csv(options.out / "table_2.csv", NAMES, table_2)
    fig_7a = [column for each in zip(PRESETS, curves, virtual, strict=True) for column in forces(*each)]
    fig_7b = [column for preset in PRESETS for column in tensions(preset)]
    for name, series in (("fig_7a", fig_7a), ("fig_7b", fig_7b)):
        write_csv(options.out / f"{name}.csv", ("panel", "series", "x", "y"), _long(series))
    text = "\n".join(table_lines(table_2))
    (options.out / "tables.txt").write_text(text + "\n", encoding="utf-8")
    print(text)
    _draw(options.out / "fig_7a", fig_7a, (".", "-", "o"), "depth x [mm]", "force F [N]")
    _draw(options.out / "fig_7b", fig_7b, ("-", "--", ":"), "expansion [mm]", "surface tension S [N]")
    return 0


def reconstruct(preset: Preset, *, rows: int = ROWS, noise: float = NOISE, seed: int = 0) -> tuple[Floats, Floats]:
    """Return depth (n,) [m] and force (n,) [N] of a press of one of Table 2's objects.

    Args:
        noise: standard deviation as a share of full scale.
    """
    depth = np.linspace(0, DEEPEST[preset.name], rows)
    force = np.array([preset.material.law(x) for x in depth])
    return depth, force + noise * force.max() * np.random.default_rng(seed).normal(size=rows)


def write_samples(folder: str | Path) -> list[Path]:
    """Write the three curves into a folder and return their paths."""
    paths = []
    for number, preset in enumerate(PRESETS, 1):
        path = Path(folder) / f"{preset.name}.csv"
        depth, force = reconstruct(preset, seed=number)
        about = (
            f"Object {number} of Table 1: {preset.label}",
            "RECONSTRUCTED from Table 2, not measured: K(x) of Eq. (1) with 1 % of full scale of noise added",
            "Source of the constants: Sakama, Tanaka and Araki, Haptic Rendering for Virtual Object in Cyber Space",
        )
        write_press(path, depth, force, about=about)
        paths.append(path)
    return paths


def virtual_press(preset: Preset, folder: Path) -> Calibration:
    """Press a cube, write the curve in the paper's form, and calibrate from the file."""
    mesh = cube(CELLS, preset.size)
    model = build_model(mesh, [preset.material], pinned=base_vertices(mesh))
    path = folder / f"virtual_press_{preset.name}.csv"
    rows = press_rows(model, preset.material.indenter.radius, find_site(mesh), DEEPEST[preset.name], PRESS_ROWS)
    depth, force = np.array(list(rows)).T
    about = (f"Virtual press of {preset.label}, {len(mesh.rest_positions)} vertices, not measured",)
    write_press(path, depth, force, about=about)
    return calibrate(path)


def constants(curves: Sequence[Calibration], virtual: Sequence[Calibration]) -> Iterable[tuple[Any, ...]]:
    """Yield the rows of Table 2: object, constant, printed, from the curve, half its interval, from a virtual press."""
    for number, (preset, curve, again) in enumerate(zip(PRESETS, curves, virtual, strict=True), 1):
        for name, unit in (("K1", 1e3), ("K2", 1e3), ("x0", 1e-3)):
            fitted, pressed = getattr(curve.fit, name), getattr(again.fit, name)
            printed = getattr(preset.material, name)
            yield number, name, printed / unit, fitted.value / unit, fitted.half_width / unit, pressed.value / unit
        yield number, "k", preset.material.k / 1e3, curve.k and curve.k / 1e3, None, None


def forces(preset: Preset, curve: Calibration, virtual: Calibration) -> Iterable[Series]:
    """Yield the series of Fig. 7(a): object, name, depth [mm], force [N]."""
    yield preset.label, "reconstructed points", 1e3 * curve.loading.depth, curve.loading.force
    x = np.linspace(0, DEEPEST[preset.name], 200)
    yield preset.label, "K(x) of Table 2", 1e3 * x, np.array([preset.material.law(depth) for depth in x.tolist()])
    yield preset.label, "virtual press", 1e3 * virtual.loading.depth, virtual.loading.force


def tensions(preset: Preset) -> Iterable[Series]:
    """Yield the series of Fig. 7(b): way, object, stretch [mm], tension [N], of K(x) of Table 2."""
    depth = np.linspace(0, DEEPEST[preset.name], 200)[1:]
    force = np.array([preset.material.law(x) for x in depth.tolist()])
    tension = np.array(
        [surface_tension(f, x, preset.size) for f, x in zip(force.tolist(), depth.tolist(), strict=True)]
    )
    modulus = preset.material.k * preset.size / (2 * SECTION)  # such that Eq. (10) has the printed slope
    stretch = np.array([surface_stretch(s, preset.size, SECTION, modulus) for s in tension.tolist()])
    yield "by Eqs. (9) and (10), A E from the printed k", preset.label, 1e3 * stretch, tension
    pulled, balance = string_balance(depth, force, preset.size)
    yield "by the force balance of a string", preset.label, 1e3 * pulled, balance


def table_lines(rows: Sequence[tuple[Any, ...]]) -> list[str]:
    """Return Table 2 to read."""
    lines = [
        "Table 2: printed, from the curve reconstructed from it with 1 % noise (95 %), and from a virtual press of a",
        "cube; K1, K2, k in N/mm, x0 in mm",
        f"{'object':>6} {'':>3} {'printed':>8} {'from the curve':>18} {'virtual press':>14}",
    ]
    for number, name, printed, value, half, again in rows:
        curve = "-" if value is None else f"{value:.3f}" if half is None else f"{value:.3f} ± {half:.3f}"
        lines.append(
            f"{number:>6} {name:>3} {printed:>8.2f} {curve:>18} {'-' if again is None else f'{again:.3f}':>14}"
        )
    products = ", ".join(f"{preset.material.k * preset.size / 2:.0f} N" for preset in PRESETS)
    return [
        *lines,
        "k from the curve is by the force balance of a string. By Eqs. (9), (10) k = 2 A E / l, whatever is measured:",
        f"the printed k stand for A E = {products}, which is not printed; (10) alone makes Fig. 7(b) straight.",
    ]


def _long(series: Iterable[Series]) -> Iterable[tuple[Any, ...]]:
    for name, kind, xs, ys in series:
        for x, y in zip(xs.tolist(), ys.tolist(), strict=True):
            yield name, kind, f"{x:.6g}", f"{y:.6g}"


def _draw(path: Path, series: Sequence[Series], styles: Sequence[str], across: str, up: str) -> None:
    """Draw a panel for each first name, as PNG and SVG."""
    names = list(dict.fromkeys(name for name, *_ in series))
    figure = new_figure(4.2 * len(names), 4)
    for axes, name in zip(figure.subplots(1, len(names)), names, strict=True):
        here = [one for one in series if one[0] == name]
        for (_, label, x, y), style in zip(here, styles, strict=True):
            axes.plot(x, y, style, ms=2 if style == "." else 4, mfc="none", label=label)
        axes.set(title=name, xlabel=across, ylabel=up)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.suptitle(f"Fig. {path.name[-2]}({path.name[-1]}) of the paper, made again from its Table 2")
    for suffix in ("png", "svg"):
        save_picture(figure, path.with_suffix(f".{suffix}"))
