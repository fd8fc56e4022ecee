"""What of the paper can be made again, beside the printed numbers: Table 2, Fig. 7(a) and 7(b); and identification.

The paper's points were not published. The curves are reconstructed from Table 2, so what follows from them shows that
the way there and back is right, not that the paper measured well.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module, util
from pathlib import Path
from typing import Any

import numpy as np

from core.base import DimpleError, Floats
from core.calibration.calibrate import Calibration, calibrate
from core.calibration.export import write_press
from core.calibration.identify import ALLOWED, ALLOWED_FORCE, WEAK
from core.calibration.indent import find_site
from core.calibration.surface import string_balance
from core.material import POINT, PRESETS, Preset

from .assessment import FINGERTIP, Assessment, assess, bed_slopes
from .reconstruct import DEEPEST, write_samples
from .reference.paper import surface_stretch, surface_tension
from .specimen import cube
from .virtual_press import identify, press_curve

CELLS = (8, 16, 32)  # along an edge of a cube: 386, 1538, 6146 vertices
PRESSED = 16  # cells of the cube whose press is drawn and written
SECTION = 1e-6  # [m2] any: Eq. (10) needs A E, and the paper prints neither
BEYOND = 1.4  # times as deep as Object 1 can be pressed, to show that it stops and why
NAMES = ("object", "constant", "printed", "from_the_curve", "half_width_95", "from_a_virtual_press")

Series = tuple[str, str, Floats, Floats]  # the panel it is drawn in, its name, x and y


@dataclass(frozen=True, slots=True, kw_only=True)
class Identified:
    """An identification on one cube, how good it is, and the processor time it took [s]."""

    preset: Preset
    assessment: Assessment
    seconds: float


def add_command(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run)
    command.add_argument("--out", type=Path, required=True, metavar="DIR", help="where tables and figures go")
    command.add_argument("--quick", action="store_true", help="leave out the cubes of 6146 vertices")


def run(options: argparse.Namespace) -> int:
    """Make all again, write it and print the tables."""
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DimpleError(f"{options.out} cannot be made: {error.strerror or error}.") from None
    announce("Three presses of Table 2")
    curves = [calibrate(p, length=preset.size) for p, preset in zip(write_samples(options.out), PRESETS, strict=True)]
    cells = [n for n in CELLS if n <= PRESSED or not options.quick]
    pressed = [identified(preset, curve, n) for preset, curve in zip(PRESETS, curves, strict=True) for n in cells]
    shown = [one for one in pressed if len(one.assessment.mesh.rest_positions) == 6 * PRESSED**2 + 2]
    announce("Virtual presses")
    virtual = [virtual_press(one, options.out) for one in shown]
    table_2 = list(constants(curves, virtual))
    _write_csv(options.out / "table_2.csv", NAMES, table_2)
    _write_csv(options.out / "identification.csv", _ROW, map(identification_row, pressed))
    fig_7a = [column for one, curve in zip(shown, curves, strict=True) for column in forces(one, curve)]
    fig_7b = [column for preset in PRESETS for column in tensions(preset)]
    for name, series in (("fig_7a", fig_7a), ("fig_7b", fig_7b)):
        _write_csv(options.out / f"{name}.csv", ("panel", "series", "x", "y"), _long(series))
    text = "\n".join([*table_lines(table_2), "", *identification_lines(pressed)])
    (options.out / "tables.txt").write_text(text + "\n", encoding="utf-8")
    print(text)
    if util.find_spec("matplotlib") is None:
        print("No pictures: they need matplotlib, which is not installed here.")
        return 0
    _draw(options.out / "fig_7a", fig_7a, (".", "-", "o", "--"), "depth x [mm]", "force F [N]")
    _draw(options.out / "fig_7b", fig_7b, ("-", "--", ":"), "expansion [mm]", "surface tension S [N]")
    return 0


def announce(doing: str) -> None:
    """Write to stderr what is done next."""
    print(f"{doing}...", file=sys.stderr, flush=True)


def identified(preset: Preset, curve: Calibration, cells: int) -> Identified:
    """Identify a printed material on a cube of its size, as deep as it was pressed."""
    mesh, tip, started = cube(cells, preset.size), POINT, time.process_time()
    announce(f"Identifying {preset.label} on {len(mesh.rest_positions)} vertices")
    site = find_site(mesh, tip)
    deepest = DEEPEST[preset.name] * (BEYOND if preset is PRESETS[0] else 1)
    found = identify(mesh, preset.material, tip, site, deepest)
    seconds = time.process_time() - started
    return Identified(preset=preset, assessment=assess(curve, found, mesh, tip, site), seconds=seconds)


def virtual_press(one: Identified, folder: Path) -> Calibration:
    """Press the identified body, write the curve in the paper's form, and calibrate from the file."""
    found, mesh, tip = one.assessment.found, one.assessment.mesh, one.assessment.indenter
    path = folder / f"virtual_press_{one.preset.name}.csv"
    depth, force = press_curve(mesh, found.material, tip, find_site(mesh, tip), float(found.depths[-1]))
    about = (f"Virtual press of {one.preset.label}, {len(mesh.rest_positions)} vertices, not measured",)
    write_press(path, depth, force, about=about)
    return calibrate(path)


def constants(curves: Sequence[Calibration], virtual: Sequence[Calibration]) -> Iterable[tuple[Any, ...]]:
    """Yield the rows of Table 2: object, constant, printed, from the curve, half its interval, from a virtual press."""
    for number, (preset, curve, again) in enumerate(zip(PRESETS, curves, virtual, strict=True), 1):
        for name, unit in (("K1", 1e3), ("K2", 1e3), ("x0", 1e-3)):
            fitted, pressed = getattr(curve.fit, name), getattr(again.fit, name)
            printed = getattr(preset.material, name)
            yield number, name, printed / unit, fitted.value / unit, fitted.half_width / unit, pressed.value / unit
        balance = curve.surface.balance_k if curve.surface else None
        values = (balance.value / 1e3, balance.half_width / 1e3) if balance else (None, None)
        yield number, "k", preset.material.k / 1e3, *values, None


def forces(one: Identified, curve: Calibration) -> Iterable[Series]:
    """Yield the series of Fig. 7(a): object, name, depth [mm], force [N]."""
    found, name = one.assessment.found, one.preset.label
    yield name, "reconstructed points", 1e3 * curve.loading.depth, curve.loading.force
    x = np.linspace(0, DEEPEST[one.preset.name], 200)
    yield name, "K(x) of Table 2", 1e3 * x, np.array([one.preset.material.law(depth) for depth in x.tolist()])
    yield name, "simulated press", 1e3 * found.depths, found.simulated
    yield name, "predicted, 10 mm fingertip", 1e3 * one.assessment.tip_depth, one.assessment.tip_force


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
        "Table 2: printed, from the curve reconstructed from it with 1 % noise (95 %), and from a virtual press of the",
        "identified cube; K1, K2, k in N/mm, x0 in mm",
        f"{'object':>6} {'':>3} {'printed':>8} {'from the curve':>18} {'virtual press':>14}",
    ]
    for number, name, printed, value, half, again in rows:
        curve = "-" if value is None else f"{value:.3f} ± {half:.3f}"
        lines.append(
            f"{number:>6} {name:>3} {printed:>8.2f} {curve:>18} {'-' if again is None else f'{again:.3f}':>14}"
        )
    products = ", ".join(f"{preset.material.k * preset.size / 2:.0f} N" for preset in PRESETS)
    return [
        *lines,
        "k from the curve is by the force balance of a string. By Eqs. (9), (10) k = 2 A E / l, whatever is measured:",
        f"the printed k stand for A E = {products}, which is not printed; (10) alone makes Fig. 7(b) straight.",
    ]


_ROW = (
    "object", "vertices", "rms_percent", "worst_over_allowed", "volume_percent", "seconds", "scale_on_k",
    "kappa_n_per_cm3", "kappa_deepest_n_per_cm3", "tension_n_per_mm", "deepest_mm", "fingertip_n_at_5_mm",
    "fingertip_n_deepest",
)  # fmt: skip


def identification_row(one: Identified) -> tuple[Any, ...]:
    """Return the row of an identification, in the order of its header."""
    assessment, found = one.assessment, one.assessment.found
    model = found.material.constants
    assert model is not None
    slopes = bed_slopes(model)
    tip = assessment.tip_force
    at_half = float(np.interp(FINGERTIP / 2, assessment.tip_depth, tip))
    return (
        PRESETS.index(one.preset) + 1, len(assessment.mesh.rest_positions), 100 * found.rms, found.worst,
        100 * found.volume_change, one.seconds, model.membrane_scale, slopes[0] / 1e6, slopes[-1] / 1e6,
        (model.tension or 0.0) / 1e3, 1e3 * found.depths[-1], at_half, tip[-1],
    )  # fmt: skip


def identification_lines(pressed: Sequence[Identified]) -> list[str]:
    """Return the table of identifications to read."""
    lines = [
        "Identification on cubes, pressed by a point: off by RMS of full scale, at the worst depth as a share of what",
        f"is allowed ({100 * ALLOWED:.0f} %, or {100 * WEAK:.0f} % of full scale and at most {ALLOWED_FORCE} N where "
        "that is more), volume, processor time,",
        f"scale on k; a 10 mm fingertip at 5 and {1e3 * FINGERTIP:.2g} mm, predicted",
        f"{'object':>6} {'vertices':>8} {'rms':>7} {'worst':>6} {'volume':>8} {'time':>7} {'scale':>8} {'deepest':>8}",
    ]
    for one in pressed:
        number, n, rms, worst, volume, seconds, scale, *_, deepest, half, full = identification_row(one)
        lines.append(
            f"{number:>6} {n:>8} {rms:>5.2f} % {worst:>6.2f} {volume:>6.3f} % {seconds:>5.1f} s {scale:>8.2g} "
            f"{deepest:>5.1f} mm {half:.3g} N, {full:.3g} N"
        )
    stops = {one.assessment.found.stopped: PRESETS.index(one.preset) + 1 for one in pressed}
    return [*lines, *(f"Object {number}: {why}" for why, number in stops.items() if why)]


def _long(series: Iterable[Series]) -> Iterable[tuple[Any, ...]]:
    for name, kind, xs, ys in series:
        for x, y in zip(xs.tolist(), ys.tolist(), strict=True):
            yield name, kind, f"{x:.6g}", f"{y:.6g}"


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def _draw(path: Path, series: Sequence[Series], styles: Sequence[str], across: str, up: str) -> None:
    """Draw a panel for each first name, as PNG and SVG."""
    names = list(dict.fromkeys(name for name, *_ in series))
    figure = import_module("matplotlib.figure").Figure(figsize=(4.2 * len(names), 4), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(names)), names, strict=True):
        here = [one for one in series if one[0] == name]
        for (_, label, x, y), style in zip(here, styles, strict=True):
            axes.plot(x, y, style, ms=2 if style == "." else 4, mfc="none", label=label)
        axes.set(title=name, xlabel=across, ylabel=up)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.suptitle(f"Fig. {path.name[-2]}({path.name[-1]}) of the paper, made again from its Table 2")
    for suffix in ("png", "svg"):
        figure.savefig(path.with_suffix(f".{suffix}"), dpi=130)
