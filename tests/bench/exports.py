"""What an export costs: 41,000 vertices in 250 frames, each format, beside Blender's own exporters of the same thing.

`python3 dev.py bench --exports` writes exports.csv into build/exports; the files themselves are deleted.
"""

import argparse
import csv
import importlib
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import bpy

VERTICES, FRAMES = 40_962, 250
FORMATS = ("PC2", "ALEMBIC", "USD", "VAT", "GLB", "FBX")


def press() -> bpy.types.Object:
    """Add a ball that is pressed, held and let go, simulated by a proxy as it would be live."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=7, radius=1)
    obj, scene = bpy.context.object, bpy.context.scene
    assert len(obj.data.vertices) == VERTICES
    bpy.ops.object.shade_smooth()
    obj.name, obj.dimple.size_mode, obj.dimple.simulated = "Ball", "CUSTOM", "PROXY"
    bpy.context.object.dimple.material = "object_2_vinyl_air"
    bpy.ops.dimple.add_fingertip()
    tip = scene.dimple.finger_1
    top = tip.location.z
    for frame, height in ((1, top), (60, top - 0.3), (120, top - 0.3), (180, top), (250, top)):
        tip.location.z = height
        tip.keyframe_insert("location", frame=frame)
    for each in bpy.context.selected_objects:
        each.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    scene.frame_start, scene.frame_end = 1, FRAMES
    return obj


def size_of(folder: Path) -> int:
    files = [path for path in folder.rglob("*") if path.is_file() and path.suffix not in (".csv", ".json")]
    return sum(path.stat().st_size for path in files)


class Table:
    """The rows that were measured, printed as they come."""

    def __init__(self) -> None:
        self.rows: list[dict[str, str]] = []

    def add(self, what: str, seconds: float, size: int, expected: float | None) -> None:
        said = {"estimate_MB": f"{expected / 1e6:.1f}"} if expected else {}
        each = f"{size / VERTICES / FRAMES:.1f}"
        row = {"what": what, "seconds": f"{seconds:.1f}", "MB": f"{size / 1e6:.1f}", "bytes_a_vertex_a_frame": each}
        self.rows.append(row | said)
        print(f"ROW {what:44} {seconds:8.1f} s {size / 1e6:8.1f} MB {said}", flush=True)

    def measure(
        self, what: str, folder: Path, action: Callable[[Path], object], expected: float | None = None
    ) -> None:
        """Measure once, in a folder that is deleted.

        Args:
            expected: what the dialog said before [bytes].
        """
        folder.mkdir()
        started = time.perf_counter()
        action(folder)
        self.add(what, time.perf_counter() - started, size_of(folder), expected)
        shutil.rmtree(folder)


def exported(kind: str, key_error: float = 0.0) -> Callable[[Path], object]:
    return lambda folder: bpy.ops.dimple.export_animation(
        directory=str(folder), formats={kind}, frame_start=1, frame_end=FRAMES, key_error=key_error
    )


def estimated(kind: str) -> float:
    """Return the size [bytes] that the export dialog says."""
    plans = importlib.import_module("bl_ext.user_default.dimple.operators.export.export_plan")
    plan = plans.ExportPlan(objects=[bpy.context.object], formats=[kind], folder=Path(), first=1, last=FRAMES)
    return plans.estimate(plan, [plans.size_of(bpy.context, bpy.context.object, plan)])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--zip", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    bpy.ops.extensions.package_install_files(
        filepath=str(options.zip), repo="user_default", enable_on_install=True
    )
    press()
    table, work = Table(), options.out / "work"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    scene = bpy.context.scene
    scene.dimple.cache_dir = str(work / "caches")
    table.measure("Dimple simulates and bakes to PC2", work / "caches", _bake)
    _bake(work)
    table.measure("Blender plays it once (Mesh Cache)", work / "a", _play)
    table.measure("Blender's own Alembic exporter", work / "a", _blenders_alembic)
    table.measure("Blender's own USD exporter", work / "a", _blenders_usd)
    for kind in FORMATS:
        table.measure(f"Dimple {kind}", work / "a", exported(kind), estimated(kind))
    for kind in ("GLB", "FBX"):
        table.measure(f"Dimple {kind}, key error 0.05 %", work / "a", exported(kind, 0.05))
    shutil.rmtree(work)
    with (options.out / "exports.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, [*table.rows[0], "estimate_MB"])
        writer.writeheader()
        writer.writerows(table.rows)


def _bake(_folder: Path) -> None:
    bpy.ops.dimple.unbake()
    bpy.ops.dimple.bake(frame_start=1, frame_end=FRAMES)


def _play(_folder: Path) -> None:
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)


def _blenders_alembic(folder: Path) -> None:
    bpy.ops.wm.alembic_export(
        filepath=str(folder / "a.abc"), start=1, end=FRAMES, selected=True, as_background_job=False
    )


def _blenders_usd(folder: Path) -> None:
    bpy.ops.wm.usd_export(filepath=str(folder / "a.usdc"), selected_objects_only=True, export_animation=True)


if __name__ == "__main__":
    main()
