"""The formats of an exported animation: Blender's own exporters where they write one right, numpy elsewhere.

Each writer gets a clip and the path it writes to, and yields the share that is done. What cannot be seen in a Mesh
Cache by an exporter (glTF, FBX: they would write a still) gets shape keys instead.
"""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np

from ...core.base import DimpleError
from ...core.recording import PointCache
from ..bridge import timeline
from . import clips
from .clips import Clip


class Size(NamedTuple):
    """What the length of a file depends on: a mesh, and how its shading is written."""

    vertices: int  # how many it has
    corners: int
    triangles: int  # a quad is two
    normals: bool  # they are written
    sharp: bool  # they differ from corner to corner of a vertex


@dataclass(frozen=True, slots=True)
class Format:
    """An export format: how its files are named, sized and written."""

    label: str  # its name
    ending: str  # of the file; None for a folder of files
    space: str  # which coordinates, axes and units it holds
    bytes_of: Callable[[Size], float]  # about how long a frame of a mesh is
    exporter: str = ""  # the operator of Blender's that writes it, if one does, and
    options: Callable[[Clip], dict[str, Any]] | None = None  # what it is asked, where it writes all of it
    writer: Callable[[bpy.types.Context, Clip, Path], Iterator[float]] | None = None  # writes it otherwise
    keyed: bool = False  # it holds shape keys
    played: bool = False  # Blender's exporter sees the object play; it holds the mesh of a render

    def write(self, context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
        """Write a clip, and yield the share that is done."""
        if self.writer:
            yield from self.writer(context, clip, path)
            return
        with clips.ranged(context.scene, clip.plan.first, clip.plan.last):
            with clips.keyed(context, clip, clip.keys().shapes) if self.keyed else clips.playing(context, clip):
                ask(self.exporter, filepath=str(path), **self.options(clip))
        yield 1.0


GLB = {  # of every glTF
    "export_format": "GLB", "use_selection": True, "export_apply": False, "export_skins": False, "export_yup": True,
}  # fmt: skip


def is_there(name: str) -> bool:
    """Tell whether this Blender has an exporter: it may be built without, or the add-on be switched off."""
    place, _, verb = name.partition(".")
    return verb in dir(getattr(bpy.ops, place))


def ask(name: str, *, filepath: str, **options: object) -> None:
    """Ask an exporter of Blender's by the name of its operator, with the options that this Blender has.

    Raises:
        DimpleError: it refused, or wrote nothing.
    """
    export = operator.attrgetter(name)(bpy.ops)
    known = export.get_rna_type().properties.keys()
    try:
        given = {name: value for name, value in options.items() if name in known}
        result = export(filepath=filepath, check_existing=False, **given)
    except RuntimeError as error:
        raise DimpleError(
            "Blender's exporter failed at {filepath}: {why}", filepath=filepath, why=_last_line(str(error))
        ) from error
    if "FINISHED" not in result or not is_whole(Path(filepath)):
        raise DimpleError(
            "Blender's exporter could not finish {filepath}. Is the disk full, or the folder read-only?",
            filepath=filepath,
        )


def _last_line(text: str) -> str:
    """Return what an error says, without where in Blender it was raised."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith((" ", "Location:"))]
    return lines[-1].removeprefix("Error: ") if lines else text


def is_whole(path: Path) -> bool:
    """Tell whether a file ends where it says it does; some exporters do not notice that a disk is full."""
    if not path.is_file():
        return False
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(4096)
    if path.suffix == ".abc":  # set when an Ogawa archive is closed
        return head[:6] == b"Ogawa\xff"
    if path.suffix == ".usdc":  # the table of contents is written last
        return len(head) >= 24 and 24 <= int.from_bytes(head[16:24], "little") < size
    if path.suffix == ".glb":
        return int.from_bytes(head[8:12], "little") == size
    if path.suffix == ".stl":
        return size == 84 + 50 * int.from_bytes(head[80:84], "little")
    if path.suffix == ".ply":
        text, _, _ = head.partition(b"end_header\n")
        vertices, triangles = (int(text.split(b"element " + each)[1].split()[0]) for each in (b"vertex", b"face"))
        return size == len(text) + 11 + 4 * text.count(b"property float") * vertices + 13 * triangles
    return size > 0


def _pc2(_context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with PointCache(path, clip.samples.shape[1], clip.plan.first) as cache:
        for number, sample in enumerate(clip.samples, start=1):
            cache.append(sample)
            yield number / len(clip.samples)


def _mdd(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    from ...core.recording.mdd import write_mdd

    yield from write_mdd(path, clip.samples, 1 / timeline.frame_s(context.scene))


def _alembic(clip: Clip) -> dict[str, Any]:
    return {
        "start": clip.plan.first, "end": clip.plan.last, "selected": True, "normals": clip.plan.normals,
        "evaluation_mode": "RENDER", "as_background_job": False,
    }  # fmt: skip


def _usd(clip: Clip) -> dict[str, Any]:
    return {
        "selected_objects_only": True, "export_animation": True, "export_normals": clip.plan.normals,
        "evaluation_mode": "RENDER", "export_textures_mode": "KEEP", "relative_paths": False,
        "export_armatures": False, "export_shapekeys": False,  # else an object with keys of its own is a still
    }  # fmt: skip


def _glb(clip: Clip) -> dict[str, Any]:
    return GLB | {
        "export_animations": True, "export_animation_mode": "SCENE", "export_frame_range": True,
        "export_anim_slide_to_zero": True, "export_force_sampling": True, "export_optimize_animation_size": False,
        "export_morph": True, "export_morph_animation": True, "export_morph_normal": clip.plan.normals,
    }  # fmt: skip


def _fbx(_clip: Clip) -> dict[str, Any]:
    # with NLA strips or all actions it would write no movement, or that of other objects
    return {
        "use_selection": True, "object_types": {"MESH"}, "use_mesh_modifiers": False, "bake_anim": True,
        "bake_anim_use_nla_strips": False, "bake_anim_use_all_actions": False, "bake_anim_simplify_factor": 0.0,
        "bake_anim_step": 1.0, "path_mode": "ABSOLUTE",
    }  # fmt: skip


def _stl(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    yield from _sequence(context, clip, path, "wm.stl_export", use_scene_unit=False)


def _ply(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    # trimesh and others read no faces of several sizes
    yield from _sequence(
        context, clip, path, "wm.ply_export", export_uv=False, export_colors="NONE", export_normals=clip.plan.normals,
        export_triangulated_mesh=True,
    )  # fmt: skip


def _sequence(context: bpy.types.Context, clip: Clip, path: Path, exporter: str, **options: object) -> Iterator[float]:
    """Write a file a frame into a folder, whose name ends in that of the format."""
    stem, ending = path.name.rsplit("_", 1)
    path.mkdir()
    first, last = clip.plan.first, clip.plan.last
    with clips.ranged(context.scene, first, last), clips.playing(context, clip):
        for frame in range(first, last + 1):
            context.scene.frame_set(frame)
            ask(
                exporter, filepath=str(path / f"{stem}_{frame:04d}.{ending}"), export_selected_objects=True,
                apply_modifiers=True, forward_axis="Y", up_axis="Z", global_scale=1.0, **options,
            )  # fmt: skip
            yield (frame - first + 1) / clip.frames


def _texture(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    """Write the pictures, the mesh with its second UV map, and what a shader must know, into a folder."""
    from ...core.recording import vertex_texture

    frames, vertices, _ = clip.samples.shape
    where = vertex_texture.layout(vertices, frames)
    picture = vertex_texture.pixels(clip.samples[..., [0, 2, 1]] * np.float32([1, 1, -1]), where)
    yield 0.2
    path.mkdir()
    vertex_texture.write_exr(path / "offsets.exr", picture)
    yield 0.4
    least, most = vertex_texture.write_png(path / "offsets.png", picture)
    yield 0.8
    with clips.mapped(context, clip, vertex_texture.uv(vertices, where)):
        still = GLB | {"export_animations": False, "export_attributes": False}
        ask("export_scene.gltf", filepath=str(path / "mesh.glb"), **still)
    words = {
        "about": vertex_texture.__doc__, "width": where.width, "height": where.height, "rows": where.rows,
        "vertices": vertices, "frames": frames, "frame_rate": 1 / timeline.frame_s(context.scene),
        "uv_map": clips.UV_MAP, "least": least, "most": most,
    }  # fmt: skip
    (path / "layout.json").write_text(json.dumps(words, indent=1) + "\n", encoding="utf-8")
    yield 1.0


def _baked(size: Size) -> float:
    return 12 * (size.vertices + size.corners * size.normals)


def _split(size: Size) -> float:
    """Return the length of a frame where a vertex has one normal: a sharp one is written for each triangle at it."""
    return 12 * (1 + size.normals) * (3 * size.triangles if size.sharp else size.vertices)


OBJECT = "the object's own coordinates: x, y and z as in Blender, after modifiers, in its own scale"
SCENE = "the scene's coordinates: Z up, in scene units, after modifiers"
USD = "Z up, in scene units"
TEXTURE = "offsets in the coordinates of mesh.glb: Y up, in scene units, after modifiers; layout.json says how"
FORMATS = {
    "ALEMBIC": Format(
        "Alembic", ".abc", "Y up, as Alembic has it, in scene units, after modifiers",
        lambda size: 12 * (size.vertices + size.corners * (size.normals and size.sharp)), "wm.alembic_export", _alembic,
        played=True,
    ),
    "USD": Format("USD", ".usdc", f"{USD}, after modifiers", _baked, "wm.usd_export", _usd, played=True),
    "USD_SHAPES": Format(
        "USD Blend Shapes", "_shapes.usdc", f"{USD}, after modifiers", lambda size: 16 * size.vertices,
        "wm.usd_export", lambda clip: _usd(clip) | {"export_shapekeys": True}, keyed=True,
    ),
    "GLB": Format(
        "glTF", ".glb", "Y up, as glTF has it, in scene units, after modifiers", _split, "export_scene.gltf", _glb,
        keyed=True,
    ),
    "FBX": Format(
        "FBX", ".fbx", "Y up, -Z forward, UnitScaleFactor says the unit, after modifiers",
        lambda size: 17 * size.vertices, "export_scene.fbx", _fbx, keyed=True,  # it is compressed
    ),
    "PC2": Format("PC2", ".pc2", OBJECT, lambda size: 12 * size.vertices, writer=_pc2),
    "MDD": Format("MDD", ".mdd", OBJECT, lambda size: 12 * size.vertices, writer=_mdd),
    "STL": Format(
        "STL", "_stl", SCENE, lambda size: 84 + 50 * size.triangles, "wm.stl_export", writer=_stl, played=True
    ),
    "PLY": Format(
        "PLY", "_ply", SCENE, lambda size: 12 * (1 + size.normals) * size.vertices + 13 * size.triangles,
        "wm.ply_export", writer=_ply, played=True,
    ),
    "VAT": Format(
        "Vertex Animation Texture", "_vat", TEXTURE, lambda size: 18 * size.vertices, "export_scene.gltf",
        writer=_texture,
    ),
}  # fmt: skip
UNSHEARED = ("GLB", "FBX", "VAT")  # there an object has a place, a rotation and a scale
