"""Files that are read with a straight face and mean something else: each is right, asked, refused or warned of."""

import numpy as np
import pytest

from core.base import DimpleError
from core.calibration.calibrate import calibrate
from core.calibration.question import Undecided

H = "Depth (mm),Force (N)"
NARROW = "\u202f"


def german(text: str) -> str:
    return text.translate(str.maketrans(".,", ",."))


# name: header, row (number from 1, depth [mm], force [N]), what may become of it
FILES = {
    "unit row lost": ("Weg;Kraft", lambda i, d, f: german(f"{d:.5f};{f:.5f}"), "asked"),
    "kilonewtons without a unit": ("Extension,Load", lambda i, d, f: f"{d:.5f},{f / 1e3:.8f}", "asked"),
    "columns moved with their headers": (
        "Force (N),Judge,Time (s),Depth (mm)", lambda i, d, f: f"{f:.5f},OK,{i / 10},{d:.5f}", "right"),
    "thousands and decimal comma": (
        "Weg (um);Kraft (mN)", lambda i, d, f: german(f"{1e3 * d:,.2f};{1e3 * f:,.2f}"), "right"),
    "thousands only": ("Weg (um);Kraft (mN)", lambda i, d, f: german(f"{1e3 * d:,.0f};{1e3 * f:,.0f}"), "asked"),
    "thousands between commas": ("Travel (um),Force (mN)", lambda i, d, f: f"{1e3 * d:,.1f},{1e3 * f:,.1f}", "asked"),
    "thousands by narrow blanks": (
        "Weg (um);Kraft (mN)", lambda i, d, f: f"{1e3 * d:,.1f};{1e3 * f:,.1f}".replace(",", NARROW), "right"),
    "thousands by apostrophes": (
        "Weg (um);Kraft (mN)", lambda i, d, f: f"{1e3 * d:,.1f};{1e3 * f:,.1f}".replace(",", "'"), "right"),
    "kilograms": ("Depth (mm),Weight (kg)", lambda i, d, f: f"{d:.5f},{f / 9.80665:.6f}", "right"),
    "capitals": ("DEPTH (MM),FORCE (KGF)", lambda i, d, f: f"{d:.5f},{f / 9.80665:.6f}", "right"),
    "both signs turned, nothing tared": (H, lambda i, d, f: f"{100 - d:.5f},{3 - f:.5f}", "right"),
    "the gap of the plates": ("Gap (mm),Normal force (N)", lambda i, d, f: f"{30 - d:.5f},{f:.5f}", "right"),
    "words for no number": (H, lambda i, d, f: f"{d:.5f},{'NaN' if i % 7 == 0 else f'{f:.5f}'}", "right"),
    "a number for no number": (H, lambda i, d, f: f"{d:.5f},{-9999 if i % 20 == 0 else f:.5f}", "warned"),
    "a run of numbers for no number": (H, lambda i, d, f: f"{d:.5f},{-9999 if 50 < i < 60 else f:.5f}", "refused"),
    "a force that drops out": (H, lambda i, d, f: f"{d:.5f},{0 if 150 < i < 170 else f:.5f}", "right"),
    "a load cell at its end": (H, lambda i, d, f: f"{d:.5f},{min(f, 25):.5f}", "warned"),
    "dates first": (
        f"Timestamp,{H}", lambda i, d, f: f"2024-12-26T10:{i // 60:02d}:{i % 60:02d}.1,{d:.5f},{f:.5f}", "right"),
    "seconds since 1970 first": (f"Timestamp,{H}", lambda i, d, f: f"{1700000000 + i},{d:.5f},{f:.5f}", "right"),
    "strain for depth": ("Compression (%),Load (N)", lambda i, d, f: f"{d / 1.65:.5f},{f:.5f}", "asked"),
    "stress for force": ("Displacement (mm),Stress (MPa)", lambda i, d, f: f"{d:.5f},{f / 1e3:.7f}", "asked"),
    "a micro sign that was lost": ("Depth (?m),Force (mN)", lambda i, d, f: f"{1e3 * d:.2f},{1e3 * f:.2f}", "asked"),
    "feet": ("Displacement (ft),Load (lbf)", lambda i, d, f: f"{d / 304.8:.8f},{f / 4.4482216:.6f}", "asked"),
    "tens of newtons": ("Depth (mm),Force (x10 N)", lambda i, d, f: f"{d:.5f},{f / 10:.6f}", "asked"),
    "a power of ten": ("Depth (mm),Force (10^-3 N)", lambda i, d, f: f"{d:.5f},{1e3 * f:.2f}", "asked"),
    "a table of R, whose header is shorter": (H, lambda i, d, f: f"{i},{d:.5f},{f:.5f}", "asked"),
    "a header too long": (f"Test,{H}", lambda i, d, f: f"{d:.5f},{f:.5f}", "asked"),
    "crosshead and extensometer": (
        "Crosshead (mm),Extensometer (mm),Load (N)", lambda i, d, f: f"{1.4 * d:.5f},{d:.5f},{f:.5f}", "asked"),
    "a second force without a name": (
        "Depth (mm),Force (N),Ch3 (N)", lambda i, d, f: f"{d:.5f},{f / 100:.5f},{f:.5f}", "asked"),
    "a force that was asked for": (f"{H},Target force (N)", lambda i, d, f: f"{d:.5f},{f:.5f},50.0", "right"),
    "specimens side by side": (f"{H},{H}", lambda i, d, f: f"{d:.5f},{f:.5f},{d:.5f},{f * 0.4:.5f}", "asked"),
    "headers exchanged": ("Force (N),Depth (mm)", lambda i, d, f: f"{d:.5f},{f:.5f}", "warned"),
}  # fmt: skip

FOOTERS = {
    "a summary in words": ("Max,51.2\nMin,0.0\nMean,10.1\n", "right"),
    "a summary in numbers": ("22.0,51.2\n0.0,0.0\n11.0,12.3\n", "right"),
    "another specimen": (None, "asked"),
    "another specimen under its header": (f"{H}\n", "asked"),
}


def became(path) -> str:
    try:
        done = calibrate(path)
    except Undecided:
        return "asked"
    except DimpleError:
        return "refused"
    fit = done.fit
    right = fit.model == "two"
    for name, truth in (("K1", 610.0), ("K2", 7230.0), ("x0", 0.0163)):
        right &= abs(getattr(fit, name).value - truth) < max(0.1 * truth, 2 * getattr(fit, name).half_width)
    return "right" if right else "warned" if done.warnings else "wrong in silence"


def rows(curve, line, scale=1.0) -> str:
    return "".join(
        f"{line(i, d, f * scale)}\n" for i, (d, f) in enumerate(zip(curve.depth, curve.force, strict=True), 1)
    )


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_means_something_else(name, curve, write):
    header, line, wanted = FILES[name]
    assert became(write(f"{header}\n{rows(curve, line)}")) == wanted


@pytest.mark.parametrize("name", FOOTERS)
def test_what_follows_the_measurement(name, curve, write):
    footer, wanted = FOOTERS[name]
    line = lambda i, d, f: f"{d:.5f},{f:.5f}"  # noqa: E731
    if footer is None or footer.startswith("Depth"):
        footer = (footer or "") + rows(curve, line, 0.4)
    assert became(write(f"{H}\n{rows(curve, line)}{footer}")) == wanted


def test_a_summary_of_which_the_label_is_a_column(curve, write):
    line = lambda i, d, f: f",{d:.5f},{f:.5f}"  # noqa: E731
    assert became(write(f"Label,{H}\n{rows(curve, line)}Max,22,51.2\nMin,0,0\nAvg,11,12\nStd,6,14\n")) == "right"


def test_rows_that_are_doubled_change_nothing(curve, write):
    line = lambda i, d, f: "\n".join([f"{d:.5f},{f:.5f}"] * (1 + i % 2))  # noqa: E731
    assert became(write(f"{H}\n{rows(curve, line)}")) == "right"


def test_a_shallow_touch_before_the_press_is_left_out_and_said(curve, write):
    line = lambda i, d, f: f"{d:.5f},{f:.5f}"  # noqa: E731
    touch = "".join(f"{d:.3f},{0.61 * d:.4f}\n" for d in [*np.linspace(0, 5, 40), *np.linspace(5, 0, 40)])
    path = write(f"{H}\n{touch}{rows(curve, line)}")
    assert became(path) == "right"
    assert any("left out" in note for note in calibrate(path).notes)
