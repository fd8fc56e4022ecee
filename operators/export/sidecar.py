"""The files that accompany an exported animation: a table of forces, and a JSON about the files and the simulation."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any

import bpy

from ..bridge import bake_files, scene_objects, timeline
from .clips import Clip, Seen
from .formats import FORMATS

VERSION = 1  # of the layout of this JSON


def describe(context: bpy.types.Context, clip: Clip) -> dict[str, Any]:
    """Return the description that all files of an object share; `files` is still empty."""
    obj = clip.obj
    return {
        "dimple_animation": VERSION,
        "dimple": bake_files.version(),
        "blender": bpy.app.version_string,
        "object": obj.name,
        "mesh": f"after modifiers, as for {'a render' if clip.plan.rendered else 'the viewport'}",
        "frames": [clip.plan.first, clip.plan.last],
        "frame_rate": 1 / timeline.frame_s(context.scene),
        "metres_per_scene_unit": scene_objects.scale_and_top(context, obj)[0],
        "scene_unit_scale": context.scene.unit_settings.scale_length,
        "table_units": "force N, depth mm, pressure Pa, volume m3, work J, time s",
        "error_unit": "of the object's own coordinates",
        "simulated": "for this export" if clip.plays else "before, as a bake",
        "body": _plain(obj.dimple.to_params()),
        "materials": {
            slot.material.name: _plain(slot.material.dimple.to_params())
            for slot in obj.material_slots
            if slot.material
        },
        "files": {},
    }


def describe_file(each: str, seen: Seen) -> dict[str, Any]:
    """Return what is in a file, or in the files of a folder."""
    kind = FORMATS[each]
    keys = seen.keys() if kind.keyed else None
    return {
        "format": kind.label,
        "coordinates": kind.space,
        "vertices": seen.samples.shape[1],
        "time_0_is_frame": seen.clip.plan.first if kind.slid else 0,
        "shape_keys": len(keys.chosen) if keys else None,
        "worst_vertex_error": keys.error if keys else 0.0,
        "worst_normal_error_degrees": math.degrees(keys.turn) if keys else 0.0,
    }


def copy_table(table: Path, path: Path, first: int, last: int) -> None:
    """Write those rows of a table of forces that are within a range of frames."""
    with table.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    kept = [row for row in rows if row and first <= float(row[0]) <= last]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *kept])


def _plain(params: dict[str, Any]) -> dict[str, Any]:
    """Return settings in types that JSON can store."""
    return {name: asdict(value) if is_dataclass(value) else value for name, value in params.items()}
