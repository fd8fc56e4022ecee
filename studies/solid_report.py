"""`dev.py core solid`: press solids by finite elements; write force and dent as CSV and as a chart."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from core.base import DimpleError, Floats

from .membrane import SHOWN, compare
from .solid import LAWS, SolidPress, Tip, ball_tip, inward, press_solid
from .solid_mesh import SHAPES

DEPTHS = np.array([0.25, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12.5, 15, 17.5, 20]) * 1e-3  # [m]
TIPS = {"ball 10 mm": ball_tip(0.010), "ball 20 mm": ball_tip(0.020), "punch 5 mm": Tip(0.005, 0.0005)}
STANDARD = 3.0  # [N] at 5 mm of the ball of 10 mm: Young's modulus is chosen for it
WITHIN = 0.050  # [m] along the skin: how far dents are compared
DENTS = (5e-3, 10e-3, 20e-3)  # [m] depths whose dents are written


def reach(press: SolidPress, depth: float, share: float) -> float:
    """Return how far along the skin the dent falls to a share of its depth [m]."""
    way, down = inward(press, depth)
    last = int(np.flatnonzero(down < share * down[0])[0])
    high, low = down[last - 1], down[last]
    return float(way[last - 1] + (high - share * down[0]) / (high - low) * (way[last] - way[last - 1]))


def bulge(press: SolidPress, depth: float) -> float:
    """Return how far the skin comes out at most [m]."""
    return float(-inward(press, depth)[1].min())


def secant_ratio(depth: Floats, force: Floats) -> float:
    """Return the secant stiffness at 1 mm over that at 5 mm."""
    return float(np.divide(*(np.interp([1e-3, 5e-3], depth, force) / [1e-3, 5e-3])))


def slope(depth: Floats, force: Floats) -> float:
    """Return the slope of a line through log F over log depth, from 0.25 to 10 mm."""
    some = (depth > 0.2e-3) & (depth < 10.1e-3)
    return float(np.polyfit(np.log(depth[some]), np.log(force[some]), 1)[0])


def press_all(depths: Floats = DEPTHS, refine: float = 1.0) -> dict[tuple[str, str, str], SolidPress]:
    """Return every shape under every law and tip; forces [N] of the Young's modulus that gives the standard force."""
    presses = {}
    for shape in SHAPES:
        for law in LAWS:
            young = 0.0
            for name, tip in TIPS.items():
                if name.startswith("punch") and law != "linear":
                    continue  # minutes for one curve, as the skin wraps the edge
                press = press_solid(shape, tip, depths, law=law, refine=refine)
                young = young or STANDARD / float(np.interp(5e-3, depths, press.force))
                presses[shape, law, name] = press.scaled(young)
    return presses


def add_solid(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_solid)
    command.add_argument("--out", type=Path, default=Path("build/solid"), metavar="DIR", help="where the results go")
    command.add_argument("--refine", type=float, default=1.0, help="elements along each side over the usual")


def run_solid(options: argparse.Namespace) -> int:
    """Press, print each curve in a line, write solid_force.csv, solid_dent.csv and solid.png."""
    presses = press_all(refine=options.refine)
    print("body, law, tip: force at 1, 5, 10, 20 mm; stiffness 1 mm over 5 mm; slope; at 20 mm: a half, a tenth of the")
    print("dent at, bulge, change of volume")
    for (shape, law, tip), press in presses.items():
        forces = " ".join(f"{np.interp(1e-3 * x, press.depth, press.force):7.2f}" for x in (1, 5, 10, 20))
        ways = " ".join(f"{1e3 * reach(press, 20e-3, share):5.1f}" for share in (0.5, 0.1))
        ratios = f"{secant_ratio(press.depth, press.force):.3f} {slope(press.depth, press.force):.3f}"
        out = f"{1e3 * bulge(press, 20e-3):.2f} mm  {100 * press.volume[-1]:+.3f} %"
        print(f"{shape:<6}{law:<12}{tip:<11} {forces} N  {ratios}  {ways} mm  {out}")
    print(f"\nThe screened membrane, by what it was fitted to: errors of the force at {[1e3 * x for x in SHOWN]} mm,")
    print(f"and of the dent from the second depth on (RMS over depth, along {1e3 * WITHIN:.0f} mm of the skin)")
    for shape in SHAPES:
        for law in LAWS:
            print(f"{shape}, {law}")
            both = {tip: presses[shape, law, tip] for tip in TIPS if tip.startswith("ball")}
            print("\n".join(compare(both, within=WITHIN)))
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        write(presses, options.out)
        draw(presses, options.out / "solid.png")
    except OSError as error:
        raise DimpleError(f"{options.out} cannot be written: {error.strerror}.") from None
    return 0


def write(presses: dict[tuple[str, str, str], SolidPress], out: Path) -> None:
    """Write the forces, and the dents at every other node of the skin."""
    with (out / "solid_force.csv").open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["body", "law", "tip", "depth_mm", "force_n", "volume_change"])
        for case, press in presses.items():
            for depth, force, volume in zip(press.depth, press.force, press.volume, strict=True):
                rows.writerow([*case, f"{1e3 * depth:g}", f"{force:.5g}", f"{volume:.3g}"])
    with (out / "solid_dent.csv").open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["body", "law", "tip", "depth_mm", "r_mm", "z_mm", "u_r_mm", "u_z_mm"])
        for case, press in presses.items():
            for depth in DENTS:
                row = int(np.argmin(np.abs(press.depth - depth)))
                for values in 1e3 * np.stack([press.r, press.z, press.u_r[row], press.u_z[row]], axis=1)[::2]:
                    rows.writerow([*case, f"{1e3 * depth:g}", *(f"{value + 0:.3f}" for value in values)])


def draw(presses: dict[tuple[str, str, str], SolidPress], path: Path) -> None:
    """Draw force over depth, and the skin pressed by 20 mm, for each body."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), layout="constrained")
    for column, shape in enumerate(SHAPES, 1):
        force, dent = figure.add_subplot(2, 2, column), figure.add_subplot(2, 2, column + 2)
        some = [(law, tip, press) for (body, law, tip), press in presses.items() if body == shape]
        for law, tip, press in some:
            ls, color, label = "--" if law == "linear" else "-", f"C{list(TIPS).index(tip)}", f"{tip}, {law}"
            force.plot(1e3 * press.depth, press.force, ls=ls, color=color, label=label)
            dent.plot(1e3 * (press.r + press.u_r[-1]), 1e3 * (press.z + press.u_z[-1]), ls=ls, color=color)
        dent.plot(1e3 * press.r, 1e3 * press.z, color="0.7", lw=1)
        force.set(title=shape, xlabel="depth [mm]", ylabel="force [N]")
        dent.set(xlabel="r [mm]", ylabel="z [mm]", xlim=(0, 95), ylim=(-70, 8), aspect="equal")
        force.legend(fontsize="small")
    figure.savefig(path, dpi=110)
