"""The formats of an exported animation: Blender's own exporters if they write a format correctly, otherwise numpy.

Each writer gets a clip and the path it writes to, and yields the share that is done. Exporters that do not see what a
Mesh Cache plays (glTF, FBX: they would write a still) get shape keys instead.
"""

from __future__ import annotations

import json
import operator
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ...core.base import DimpleError
from ...core.recording import PointCache
from ..bridge import scene_objects, timeline
from . import clips
from .clips import Clip


class Size(NamedTuple):
    """The counts that determine the size of a file."""

    vertices: int  # of the mesh
    corners: int  # of its faces
    split: int  # vertices after a split at sharp edges, one normal each
    pictures: int  # [bytes] size of its textures


@dataclass(frozen=True, slots=True)
class Format:
    """An export format: how its files are named, sized and written."""

    label: str  # its name
    ending: str  # of the name of the file, or of the folder of files
    space: str  # coordinates, axes and units of the file
    bytes_of: Callable[[Size], float]  # approximate size of a frame [bytes]
    write: Callable[[bpy.types.Context, Clip, Path], Iterator[float]]  # yields the share that is done
    exporter: str = ""  # Blender's operator that it needs
    keyed: bool = False  # the motion is stored in shape keys
    played: bool = False  # Blender's exporter sees the object play
    pictures: bool = True  # it contains textures
    slid: bool = False  # its time 0 is the first exported frame, not frame 0


def is_there(name: str) -> bool:
    """Return whether this Blender has an exporter: a build may lack it, or its add-on may be switched off."""
    place, _, verb = name.partition(".")
    return verb in dir(getattr(bpy.ops, place))


def ask(name: str, *, filepath: str, **options: object) -> None:
    """Run one of Blender's exporters by the name of its operator, with those options that this Blender has.

    Raises:
        DimpleError: it failed, or its file is incomplete.
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
    """Return the message of an error, without the place in Blender where it was raised."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith((" ", "Location:"))]
    return lines[-1].removeprefix("Error: ") if lines else text


def is_whole(path: Path) -> bool:
    """Return whether a file is complete by its own header; some exporters do not notice that a disk is full."""
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
    return size > 0


def _pc2(_context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with PointCache(path, clip.samples.shape[1], clip.plan.first) as cache:
        for number, sample in enumerate(clip.samples, start=1):
            cache.append(sample)
            yield number / len(clip.samples)


def _alembic(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with clips.playing(context, clip):
        ask(
            "wm.alembic_export", filepath=str(path), start=clip.plan.first, end=clip.plan.last, selected=True,
            evaluation_mode="VIEWPORT", as_background_job=False,
        )  # fmt: skip
    yield 1.0


def _fbx(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    nameless = [image for image in bpy.data.images if image.packed_file and not image.filepath_raw]
    for image in nameless:  # Blender's exporter takes the name from the path
        image.filepath_raw = f"//{bpy.path.clean_name(image.name)}.{image.file_format.lower().removeprefix('open_')}"
    try:
        with clips.keyed(context, clip, clip.keys()):
            ask(  # with NLA strips or all actions it would write no movement, or that of other objects
                "export_scene.fbx", filepath=str(path), use_selection=True, object_types={"MESH"},
                use_mesh_modifiers=False, bake_anim=True, bake_anim_use_nla_strips=False,
                bake_anim_use_all_actions=False, bake_anim_simplify_factor=0.0, bake_anim_step=1.0, path_mode="COPY",
                embed_textures=True, apply_scale_options="FBX_SCALE_UNITS",
            )  # fmt: skip
    finally:
        for image in nameless:
            image.filepath_raw = ""
    yield 1.0


def _usd(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    """Write a USD file and its textures, with relative paths, into a folder."""
    path.mkdir()
    file = path / f"{path.name.removesuffix('_usd')}.usdc"
    with clips.playing(context, clip):
        ask(
            "wm.usd_export", filepath=str(file), selected_objects_only=True, export_animation=True,
            evaluation_mode="VIEWPORT", export_textures_mode="NEW", relative_paths=True, convert_world_material=False,
            export_armatures=False, export_shapekeys=False,  # otherwise an object with its own shape keys is a still
        )  # fmt: skip
    if hasattr(bpy.utils, "expose_bundled_modules"):  # the Python module of Blender hides them
        bpy.utils.expose_bundled_modules()
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(file))  # Blender's exporter leaves both at their defaults
    stage.SetFramesPerSecond(1 / timeline.frame_s(context.scene))
    UsdGeom.SetStageMetersPerUnit(stage, scene_objects.metres_per_unit(context.scene))
    stage.Save()
    yield 1.0


def _glb(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with clips.keyed(context, clip, clip.keys()):
        _ask_gltf(context.scene, path)
    yield 1.0


def _ask_gltf(scene: bpy.types.Scene, path: Path) -> None:
    """Write a GLB of the selected object in seconds and metres."""
    render = scene.render
    base = render.fps_base
    render.fps_base = 1 / base  # Blender's exporter multiplies by it, where it should divide
    try:
        ask(
            "export_scene.gltf", filepath=str(path), export_format="GLB", use_selection=True, export_apply=False,
            export_skins=False, export_yup=True, export_attributes=False, export_animations=True,
            export_animation_mode="SCENE", export_frame_range=True, export_anim_slide_to_zero=True,
            export_force_sampling=True, export_optimize_animation_size=False, export_morph=True,
            export_morph_animation=True, export_morph_normal=True,
        )  # fmt: skip
    finally:
        render.fps_base = base
    metres = scene_objects.metres_per_unit(scene)
    if metres != 1:
        _scale_gltf(path, metres)


def _scale_gltf(path: Path, scale: float) -> None:
    """Put the contents of a GLB below a node with a scale."""
    data = path.read_bytes()
    end = 20 + int.from_bytes(data[12:16], "little")
    words = json.loads(data[20:end])
    words["nodes"].append({"name": "Metres", "scale": [scale] * 3, "children": words["scenes"][0]["nodes"]})
    words["scenes"][0]["nodes"] = [len(words["nodes"]) - 1]
    text = json.dumps(words, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(data) - end, len(text), b"JSON")
    path.write_bytes(head + text + data[end:])


def _texture(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    """Write the textures, the mesh with its second UV map, and the layout for a shader, into a folder."""
    from ...core.recording import vertex_texture

    frames, vertices = len(clip.samples), len(clip.vertex_of)
    where = vertex_texture.layout(vertices, frames)
    points, normals = (
        each[..., [0, 2, 1]] * np.float32([1, 1, -1]) for each in (clip.samples[:, clip.vertex_of], clip.normals)
    )
    offsets = points - points[0]
    least, most = float(offsets.min()), float(offsets.max())
    picture = vertex_texture.pixels(offsets, where)
    yield 0.2
    path.mkdir()
    vertex_texture.write_exr(path / "offsets.exr", picture)
    yield 0.4
    vertex_texture.write_png(path / "offsets.png", picture, least, most)
    yield 0.6
    vertex_texture.write_png(path / "normals.png", vertex_texture.pixels(normals, where), -1.0, 1.0)
    yield 0.8
    with clips.mapped(context, clip, vertex_texture.uv(vertices, where)):
        _ask_gltf(context.scene, path / "mesh.glb")
    words = {
        "about": vertex_texture.__doc__, "width": where.width, "height": where.height, "rows": where.rows,
        "vertices": vertices, "frames": frames, "frame_rate": 1 / timeline.frame_s(context.scene),
        "uv_map": clips.UV_MAP, "least": least, "most": most,
        "bounds": [points.min(axis=(0, 1)).tolist(), points.max(axis=(0, 1)).tolist()],
    }  # fmt: skip
    (path / "layout.json").write_text(json.dumps(words, indent=1) + "\n", encoding="utf-8")
    yield 1.0


def _corners(size: Size) -> float:
    return 12 * (size.vertices + size.corners)


FORMATS = {
    "ALEMBIC": Format(
        "Alembic", ".abc", "Y up, as Alembic has it, in scene units",
        lambda size: _corners(size) if size.split > size.vertices else 12 * size.vertices,  # readers smooth it
        _alembic, "wm.alembic_export", played=True, pictures=False,
    ),
    "USD": Format("USD", "_usd", "Z up, metersPerUnit says the unit", _corners, _usd, "wm.usd_export", played=True),
    "GLB": Format(
        "glTF", ".glb", "Y up, in metres, as glTF has it", lambda size: 24 * size.split, _glb, "export_scene.gltf",
        keyed=True, slid=True,
    ),
    "FBX": Format(
        "FBX", ".fbx", "Y up, -Z forward, UnitScaleFactor says the unit",
        lambda size: 18 * size.vertices, _fbx, "export_scene.fbx", keyed=True,  # it is compressed
    ),
    "PC2": Format(
        "PC2", ".pc2", "the object's own coordinates: x, y and z as in Blender, in its own scale",
        lambda size: 12 * size.vertices, _pc2, pictures=False,
    ),
    "VAT": Format(
        "Vertex Animation Texture", "_vat", "Y up, in the coordinates of mesh.glb; layout.json says how",
        lambda size: 24 * size.split, _texture, "export_scene.gltf", slid=True,
    ),
}  # fmt: skip
UNSHEARED = ("GLB", "FBX", "VAT")  # formats whose objects have a location, a rotation and a scale, but no shear
