"""`python -m core calibrate`: from a file of depths and forces to constants."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

from core.base import DimpleError
from core.calibration.calibrate import Calibration, calibrate, fitted_material
from core.calibration.identify import identify
from core.calibration.indent import POINT, SHAPES, Indenter, find_site
from core.calibration.question import Answers, Undecided
from core.calibration.report import questions_json, to_json, to_lines
from core.calibration.verdict import Verdict, judge, verdict_json, verdict_lines
from core.material import FILLS, PRESETS

from .calibration_plot import save_plot
from .specimen import CELLS, cube, load_mesh

DONE, OPEN = 0, 3  # exit codes


def add_command(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run)
    command.add_argument("file", type=Path, metavar="FILE", help="what the instrument wrote (CSV or text)")
    command.add_argument("--length-mm", type=float, metavar="L", help="edge of the object, for k")
    command.add_argument("--tip-radius-mm", type=float, metavar="R", default=1e3 * POINT.radius, help="of the tip")
    command.add_argument("--indenter", choices=SHAPES, default="point", help="what measured; a point is a small punch")
    command.add_argument("--section-mm2", type=float, metavar="A", help="section of the surface, for k by Eq. (10)")
    command.add_argument("--youngs-modulus-mpa", type=float, metavar="E", help="of the surface, for k by Eq. (10)")
    command.add_argument("--json", type=Path, metavar="OUT", help="write the constants, or the questions, as JSON")
    command.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the curve and the fit (needs matplotlib)")
    press = command.add_argument_group("the simulated press")
    press.add_argument("--identify", action="store_true", help="find the model's constants for a cube of --length-mm")
    press.add_argument("--mesh", type=Path, metavar="FILE", help="the body instead (OBJ, STL, PLY; longest side L)")
    press.add_argument("--fill", choices=[fill for fill in FILLS if fill != "paper"], default="air", help="inside")
    answers = command.add_argument_group("answers, where the file leaves something open")
    for option, kind, text in (
        ("--depth-column", str, "header or number of the column of depth"),
        ("--force-column", str, "header or number of the column of force"),
        ("--depth-unit", str, "mm, m, um, in..."),
        ("--force-unit", str, "N, gf, kgf, mN, kN, lbf..."),
        ("--decimal", str, "the decimal mark, . or ,"),
        ("--table", int, "which of several tables, counted from 1"),
        ("--press", str, "sign of a pressing force, positive or negative"),
        ("--cycle", int, "which of several presses, counted from 1"),
        ("--contact-mm", float, "reading of the depth at first touch"),
    ):
        answers.add_argument(option, type=kind, help=text)


def run(options: argparse.Namespace) -> int:
    """Calibrate and tell; return OPEN where the file leaves something open."""
    answers = Answers(**{field.name: getattr(options, field.name) for field in fields(Answers)})
    tip = Indenter(shape=options.indenter, radius=1e-3 * options.tip_radius_mm)
    try:
        calibration = calibrate(
            options.file, answers, length=_scaled(options.length_mm, 1e-3), tip=tip,
            section=_scaled(options.section_mm2, 1e-6), youngs_modulus=_scaled(options.youngs_modulus_mpa, 1e6),
        )  # fmt: skip
    except Undecided as undecided:
        print(undecided, file=sys.stderr)
        if options.json:
            write_json(options.json, questions_json(undecided))
        return OPEN
    report, verdict = to_json(calibration), None
    print("\n".join(to_lines(calibration)))
    if options.identify or options.mesh:
        verdict = _pressed(options, calibration)
        print("\n".join(verdict_lines(verdict)))
        report["identification"] = verdict_json(verdict)
    if options.json:
        write_json(options.json, report)
    if options.plot:
        save_plot(calibration, options.plot, verdict)
    return DONE


def _pressed(options: argparse.Namespace, calibration: Calibration) -> Verdict:
    """Identify on the body asked for, telling on stderr how far it is."""
    length = calibration.length
    if length is None:
        raise DimpleError("How large is the object? Say it with --length-mm: a cube's edge, or a mesh's longest side.")
    mesh = load_mesh(options.mesh, length) if options.mesh else cube(CELLS, length)
    template = next(preset.material for preset in PRESETS if preset.material.fill == options.fill)
    material = fitted_material(calibration, template)
    indenter = calibration.tip
    site = find_site(mesh, indenter)
    told = 0.0

    def tell(share: float) -> None:
        nonlocal told
        if share > told + 0.1:
            print(f"Identifying: {share:.0%}", file=sys.stderr, flush=True)
            told = share

    found = identify(mesh, material, indenter, site, float(calibration.press.depth.max()), progress=tell)
    return judge(calibration, found, mesh, indenter, site)


def write_json(path: Path, report: dict[str, Any]) -> None:
    """Write a report.

    Raises:
        DimpleError: the file cannot be written.
    """
    try:
        path.write_text(json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise DimpleError(f"{path} cannot be written: {error.strerror or error}.") from None


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value
