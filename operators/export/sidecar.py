"""The files that accompany an exported animation: a table of forces, and a JSON about the files and the simulation."""

from __future__ import annotations

import csv
import hashlib
import json
import math
import os
import zlib
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..bridge import cache_files, final_mesh, scene_objects
from .clips import Clip
from .formats import FORMATS

if TYPE_CHECKING:
    from ...core.session import Session

VERSION = 1  # of the layout of this JSON


def describe(context: bpy.types.Context, clip: Clip) -> dict[str, Any]:
    """Return the description that all files of an object share, while it plays; `files` is still empty."""
    obj, render = clip.obj, context.scene.render
    mesh = obj.evaluated_get(context.evaluated_depsgraph_get()).data
    return {
        "dimple_animation": VERSION,
        "dimple": cache_files.version(),
        "blender": bpy.app.version_string,
        "object": obj.name,
        "mesh": f"after modifiers, as for {'a render' if clip.plan.rendered else 'the viewport'}",
        "vertices": len(mesh.vertices),
        "polygons": len(mesh.polygons),
        "topology_crc32": f"{zlib.crc32(final_mesh.corners_of(mesh).tobytes()):08x}",
        "frames": [clip.plan.first, clip.plan.last],
        "frame_rate": render.fps / render.fps_base,
        "metres_per_scene_unit": scene_objects.scale_and_top(context, obj)[0],
        "scene_unit_scale": context.scene.unit_settings.scale_length,
        "table_units": "force N, depth mm, pressure Pa, volume m3, work J, time s",
        "error_unit": "of the object's own coordinates",
        "seeds": [],  # nothing is random: the same file gives the same bytes
        "simulation": clip.simulated or "a bake or recording made before this export",
        "body": _plain(obj.dimple.to_params()),
        "materials": {
            slot.material.name: _plain(slot.material.dimple.to_params())
            for slot in obj.material_slots
            if slot.material
        },
        "files": {},
    }


def describe_session(session: Session) -> dict[str, Any]:
    """Return how a session was simulated."""
    return {
        "solver": session.backend,
        "tick_s": session.clock.tick,
        "steps_in_a_tick": session.substeps,
        "proxy_vertices": len(session.proxy.seeds) if session.proxy else None,
        "model_notes": list(session.model.notes),
    }


def describe_file(path: Path, each: str, clip: Clip) -> dict[str, Any]:
    """Return the contents, size and checksum of a file, or of the files in a folder."""
    kind = FORMATS[each]
    keys = clip.keys() if kind.keyed else None
    files = sorted(each for each in path.rglob("*") if each.is_file()) if path.is_dir() else [path]
    checksum = hashlib.sha256()
    for file in files:
        with file.open("rb") as opened:
            while block := opened.read(1 << 20):
                checksum.update(block)
    return {
        "format": kind.label,
        "coordinates": kind.space,
        "time_0_is_frame": clip.plan.first if kind.slid else 0,
        "shape_keys": len(keys.chosen) if keys else None,
        "worst_vertex_error": keys.error if keys else 0.0,
        "worst_normal_error_degrees": math.degrees(keys.turn) if keys else 0.0,
        "bytes": sum(file.stat().st_size for file in files),
        "sha256": checksum.hexdigest(),
    }


def write(path: Path, described: dict[str, Any]) -> None:
    """Write the JSON.

    Raises:
        OSError: the disk refuses.
    """
    with path.open("w", encoding="utf-8") as file:
        json.dump(described, file, indent=1, ensure_ascii=False)
        file.write("\n")
        file.flush()
        os.fsync(file.fileno())


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
