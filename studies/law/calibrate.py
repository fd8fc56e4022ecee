"""`dev.py core calibrate`: from a file of depths and forces to constants."""

from __future__ import annotations

import argparse
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from core.calibration.calibrate import Calibration, calibrate, to_record
from core.calibration.doubts import Miss
from core.calibration.question import Answers, Undecided
from core.material import POINT, TIPS, Indenter
from studies.files import new_figure, save_picture, write_json

DONE, OPEN = 0, 3  # exit codes


def add_command(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run)
    command.add_argument("file", type=Path, metavar="FILE", help="file of an instrument")
    command.add_argument("--length-mm", type=float, metavar="L", help="edge length of the object, for k")
    command.add_argument("--tip-radius-mm", type=float, metavar="R", default=1e3 * POINT.radius, help="tip radius")
    command.add_argument("--indenter", choices=TIPS, default="point", help="shape of the tip; a point is a small punch")
    command.add_argument("--json", type=Path, metavar="OUT", help="write the constants, or the questions, as JSON")
    command.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the curve and the fit (needs matplotlib)")
    answers = command.add_argument_group("answers, where the file leaves something open")
    for field in fields(Answers):
        kind = {"int | None": int, "float | None": float}.get(str(field.type), str)
        text, choices = field.metadata["text"], field.metadata["choices"] or None
        answers.add_argument(option(field.name), type=kind, choices=choices, help=text)


def option(name: str) -> str:
    """Return the option that gives a field of Answers."""
    return "--" + name.replace("_", "-")


def run(options: argparse.Namespace) -> int:
    """Calibrate and print the result; return OPEN where a file leaves something open."""
    tip = Indenter(shape=options.indenter, radius=1e-3 * options.tip_radius_mm)
    try:
        answers = Answers(**{field.name: getattr(options, field.name) for field in fields(Answers)})
        length = None if options.length_mm is None else 1e-3 * options.length_mm
        calibration = calibrate(options.file, answers, length=length, tip=tip)
    except Undecided as undecided:
        print("\n".join(question_lines(undecided)), file=sys.stderr)
        if options.json:
            write_json(options.json, questions_json(undecided))
        return OPEN
    print("\n".join(to_lines(calibration)))
    if options.json:
        write_json(options.json, to_record(calibration))
    if options.plot:
        save_plot(calibration, options.plot)
    return DONE


def to_lines(calibration: Calibration) -> list[str]:
    """Return a calibration as lines of text."""
    c, fit, loading, m = calibration, calibration.fit, calibration.loading, calibration.measurement
    slopes = "two slopes" if fit.model == "two" else "one slope"
    lines = [f"{c.measurement.source}: {slopes} through {fit.rows} rows up to {fit.full_scale:.4g} N"]
    lines.append(f"  K1 = {fit.K1.text(1e3)} N/mm (95 %)")
    lines.append(f"  K2 = {fit.K2.text(1e3)} N/mm")
    lines.append(f"  x0 = {fit.x0.text(1e-3)} mm")
    lines.append(f"  first touch at {loading.reading(0.0):.4g} mm of the file, tare {loading.tare:.4g} N")
    named = zip(("depth", "force"), (m.depth_header, m.force_header), m.columns, m.units, strict=True)
    lines += [f"  the {role} is “{name}” (column {number}) in {unit}" for role, name, number, unit in named]
    lines.append(f"  residual {100 * fit.misfit:.2f} % of full scale (RMS){_miss_text(c.miss)}")
    if loading.damping_ratio is not None:
        lost = 100 * (loading.loss or 0)
        lines.append(f"  {lost:.0f} % of the work is lost: damping ratio about {loading.damping_ratio:.2f}")
    if c.k is not None:
        lines.append(f"  k = {c.k / 1e3:.3g} N/mm")
    lines += [f"  Note: {note}" for note in c.notes]
    lines += ["  Warning: " + warning.replace("\n", "\n    ") for warning in c.warnings]
    return lines


def _miss_text(miss: Miss | None) -> str:
    """Return how far the law is from the measured points where it is farthest."""
    if miss is None:
        return ""
    where = f"{miss.error:+.3g} N at {1e3 * miss.depth:.3g} mm"
    return f"; off the points by up to {100 * miss.share:.1f} % of the force ({where})"


def question_lines(undecided: Undecided) -> list[str]:
    """Return open questions as lines of text, with the options that answer them."""
    lines = []
    for question in undecided.questions:
        answer = option(question.name)
        lines.append(f"{question.text} Answer with {answer}:")
        likeliest = {question.default: " (the likeliest)"}
        lines += [f"  {answer} {c.value}   {c.label}{likeliest.get(c.value, '')}" for c in question.candidates]
    return lines


def questions_json(undecided: Undecided) -> dict[str, Any]:
    """Return open questions as plain data, with the options that answer them."""
    record = undecided.to_record()
    for question in record["questions"]:
        question["option"] = option(question["name"])
    return record


def save_plot(calibration: Calibration, path: Path) -> None:
    """Draw loading, unloading and the law with its constants.

    Raises:
        DimpleError: matplotlib is not installed, or writes no such picture.
    """
    figure = new_figure(7, 5)
    axes, loading, fit = figure.add_subplot(), calibration.loading, calibration.fit
    axes.plot(1e3 * loading.depth, loading.force, ".", ms=3, color="0.55", label="measured")
    if len(loading.unloading_depth) > 8:
        axes.plot(1e3 * loading.unloading_depth, loading.unloading_force, color="0.75", label="unloading")
    x = np.linspace(0, float(loading.depth.max()), 400)
    low, high = fit.law(x) - fit.band(x), fit.law(x) + fit.band(x)
    axes.fill_between(1e3 * x, low, high, color="tab:red", alpha=0.25, lw=0, label="95 % of the law")
    law = f"K = {fit.K1.text(1e3)} N/mm"
    if fit.model != "one":
        law = f"K1 = {fit.K1.text(1e3)}, K2 = {fit.K2.text(1e3)} N/mm, x0 = {fit.x0.text(1e-3)} mm"
    axes.plot(1e3 * x, fit.law(x), color="tab:red", label=law)
    axes.set(xlabel="depth x [mm]", ylabel="force F [N]", title=calibration.measurement.source)
    axes.legend(loc="upper left")
    axes.grid(alpha=0.3)
    save_picture(figure, path)
