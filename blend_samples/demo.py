"""The main job end to end (`python3 dev.py demo`): open the samples, press, bake, and write what an artist takes away.

Writes for each sample NAME.blend (plays), NAME.abc, NAME_contact_sheet.png, NAME_force_depth.png and .csv, and for
all of them summary.json.
"""

from __future__ import annotations

import csv
import json
import math
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import bpy
import matplotlib
import numpy as np
from scene_parts import DOWN, HELD, REST, install

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
SAMPLES = "three_objects", "suzanne"
MOMENTS = {"rest": 1, "pressed": DOWN, "held": HELD, "released": REST}
RENDER_WORTH = 6  # of the progress bar: a picture takes about as long as this many frames of a bake


def main() -> int:
    """Run the demo; return 0 when every number is finite."""
    options = install()
    out: Path = options.out
    bpy.context.preferences.filepaths.save_version = 0
    progress = Progress(len(SAMPLES) * (REST + RENDER_WORTH * len(MOMENTS)), out / "blender.log")
    rows = []
    for name in SAMPLES:
        rows += sample(name, out, progress)
    progress.done()
    summary = {"blender": bpy.app.version_string, "objects": rows}
    (out / "summary.json").write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    for row in rows:
        print(
            f"  {row['name']:22} {row['vertices']:5} vertices, {row['moving_vertices']:5} move  "
            f"{row['max_depth_mm']:5.1f} mm  {row['force_n']:6.1f} N (law {row['law_n']:5.1f} N)  "
            f"volume {100 * row['volume_error']:.2f} %  {row['steps']} steps"
        )
    print(f"wrote {out}")
    return 0 if all(row["finite"] for row in rows) else 1


def sample(name: str, out: Path, progress: Progress) -> list[dict[str, object]]:
    """Press, bake, export and photograph one sample; return its lines of the summary."""
    bpy.ops.wm.open_mainfile(filepath=str(HERE / f"{name}.blend"))
    scene = bpy.context.scene
    bpy.ops.wm.save_as_mainfile(filepath=str(out / f"{name}.blend"))
    bodies = [thing for thing in scene.objects if thing.dimple.enabled]
    for thing in scene.objects:
        thing.select_set(thing in bodies)
    bpy.context.view_layer.objects.active = bodies[0]
    progress.say(f"{name}: press and bake")
    folder = out / "cache"
    scene.dimple.cache_dir = bpy.path.relpath(str(folder))
    bpy.app.handlers.frame_change_post.append(progress.frame)
    bpy.ops.dimple.bake(frame_start=1, frame_end=REST)
    bpy.app.handlers.frame_change_post.remove(progress.frame)
    tables = {
        body.name: read_table(next(folder.glob(f"{name}_{bpy.path.clean_name(body.name)}*.csv"))) for body in bodies
    }
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.alembic_export(filepath=str(out / f"{name}.abc"), start=1, end=REST)
    photograph(name, out, progress)
    draw_curves(name, out, bodies, tables)
    return [summary_row(body, tables[body.name]) for body in bodies]


def read_table(path: Path) -> list[dict[str, float]]:
    """Read the forces beside a cache: one line a frame."""
    with path.open(newline="", encoding="utf-8") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def finger_of(table: Sequence[dict[str, float]]) -> int:
    """Return the fingertip that pressed this body."""
    return max((1, 2, 3), key=lambda i: max(row[f"depth_{i}_mm"] for row in table))


def law_at(body: bpy.types.Object, depth_mm: float) -> float:
    """Return the force [N] of Eq. (1) at a depth, with the constants of a body's material."""
    from bl_ext.user_default.dimple.core.material import Material

    return Material(**body.active_material.dimple.to_params()).law(depth_mm / 1e3)


def summary_row(body: bpy.types.Object, table: Sequence[dict[str, float]]) -> dict[str, object]:
    """Return what the summary says of one body: forces at the deepest frame that is held, the worst volume."""
    from bl_ext.user_default.dimple.core.message import read

    finger, held = finger_of(table), table[HELD - 1]
    vertices, planned = len(body.data.vertices), read(body.dimple.plan_reason).values
    return {
        "name": body.name,
        "vertices": vertices,
        "moving_vertices": planned.get("vertices", vertices),  # of the proxy, where one is simulated in its place
        "steps": int(table[-1]["steps"]),
        "max_depth_mm": max(row[f"depth_{finger}_mm"] for row in table),
        "force_n": held[f"force_{finger}_n"],
        "law_n": law_at(body, held[f"depth_{finger}_mm"]),
        "volume_error": max(abs(row["volume_m3"] / row["rest_volume_m3"] - 1) for row in table),
        "finite": all(math.isfinite(value) for row in table for value in row.values()),
    }


def draw_curves(
    name: str,
    out: Path,
    bodies: Sequence[bpy.types.Object],
    tables: dict[str, list[dict[str, float]]],
) -> None:
    """Draw force against depth while the fingertip goes in, over Eq. (1); write the numbers beside."""
    figure, axes = plt.subplots(1, len(bodies), figsize=(4.4 * len(bodies), 3.8), squeeze=False)
    with (out / f"{name}_force_depth.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["object", "depth_mm", "force_n", "law_n"])
        for axis, body in zip(axes[0], bodies, strict=True):
            table = tables[body.name]
            finger = finger_of(table)
            down = [row for row in table[:DOWN] if row[f"depth_{finger}_mm"] > 0]
            depth, force = (
                np.array([row[f"{kind}_{finger}_{unit}"] for row in down])
                for kind, unit in (("depth", "mm"), ("force", "n"))
            )
            writer.writerows((body.name, x, f, law_at(body, x)) for x, f in zip(depth, force, strict=True))
            fine = np.linspace(0, depth.max(), 200)
            law = np.array([law_at(body, x) for x in fine])
            axis.plot(fine, law, "k-", linewidth=1, label="K(x), Eq. (1)")
            axis.plot(depth, force, "o", markersize=3, label="on the fingertip")
            top = 1.2 * max(law.max(), force.max())
            axis.set(title=body.name, xlabel="depth of the fingertip [mm]", ylabel="force [N]", xlim=(0, None))
            axis.set_ylim(0, top)
            axis.legend(fontsize=7)
            axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(out / f"{name}_force_depth.png", dpi=110)
    plt.close(figure)


def photograph(name: str, out: Path, progress: Progress) -> None:
    """Render the four moments of the press side by side."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 16, "CPU"
    scene.render.resolution_x, scene.render.resolution_y = 640, 420
    scene.render.image_settings.file_format = "PNG"
    figure, axes = plt.subplots(2, 2, figsize=(12.8, 8.9))
    for axis, (moment, frame) in zip(axes.flat, MOMENTS.items(), strict=True):
        progress.say(f"{name}: picture of it {moment}")
        scene.frame_set(frame)
        scene.render.filepath = str(out / f"{name}_{moment}.png")
        bpy.ops.render.render(write_still=True)
        axis.imshow(plt.imread(scene.render.filepath))
        axis.set_title(f"{moment} (frame {frame})", fontsize=12)
        axis.axis("off")
        Path(scene.render.filepath).unlink()
        progress.step(worth=RENDER_WORTH)
    figure.tight_layout()
    figure.savefig(out / f"{name}_contact_sheet.png", dpi=100)
    plt.close(figure)


class Progress:
    """Draw a bar with the time left on one line of the terminal; what Blender itself prints goes to a log."""

    def __init__(self, total: int, log: Path) -> None:
        self.total, self.count, self.started, self.what = total, 0, time.monotonic(), ""
        self._terminal = os.fdopen(os.dup(1), "w")
        os.dup2(os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 1)

    def say(self, what: str) -> None:
        """Name what is being done."""
        self.what = what
        self._draw("\r" if self._terminal.isatty() else "\n")

    def step(self, worth: int = 1) -> None:
        """Count something done."""
        self.count = min(self.count + worth, self.total)
        if self._terminal.isatty():
            self._draw("\r")

    def frame(self, scene: bpy.types.Scene, *_: object) -> None:
        """Count a whole frame: a handler of Blender's."""
        if scene.frame_subframe == 0.0:
            self.step()

    def done(self) -> None:
        """Fill the bar, end the line and give the terminal back."""
        self.count, self.what = self.total, f"done in {time.monotonic() - self.started:.0f} s"
        self._draw("\n")
        sys.stdout.flush()
        os.dup2(self._terminal.fileno(), 1)

    def _draw(self, end: str) -> None:
        share, spent = self.count / self.total, time.monotonic() - self.started
        left = f"{spent / share - spent:3.0f} s left" if 0 < share < 1 else ""
        self._terminal.write(f"[{'#' * round(30 * share):30}] {100 * share:3.0f} % {left:10} {self.what:48}{end}")
        self._terminal.flush()


if __name__ == "__main__":
    sys.exit(main())
