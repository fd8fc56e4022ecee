"""The formats of an exported animation: Blender's own exporters if they write a format correctly, otherwise numpy.

Each writer gets what is seen and the path it writes to. Exporters that do not see what a Mesh Cache plays (glTF, FBX:
they would write a still) get shape keys instead.
"""

from __future__ import annotations

import json
import operator
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
import numpy.typing as npt

from ...core.base import DimpleError
from ..bridge import timeline
from . import clips
from .clips import Seen

UV_MAP = "dimple_vertex"  # of a vertex animation texture


class Size(NamedTuple):
    """The counts that determine the size of a file."""

    vertices: int  # of the mesh
    corners: int  # of its faces
    split: int  # vertices after a split at sharp edges, one normal each
    smooth: bool  # no edge is sharp
    pictures: int  # [bytes] size of its textures


@dataclass(frozen=True, slots=True)
class Format:
    """An export format: how its files are named, sized and written."""

    label: str  # its name
    ending: str  # of the name of the file, or of the folder of files
    space: str  # coordinates, axes and units of the file
    bytes_of: Callable[[Size], float]  # largest size of a frame [bytes]: frames that are alike need less
    write: Callable[[bpy.types.Context, Seen, Path], None]
    exporter: str = ""  # Blender's operator that it needs
    keyed: bool = False  # the motion is stored in shape keys
    pictures: bool = True  # it contains textures
    slid: bool = False  # its time 0 is the first exported frame, not frame 0


def is_there(name: str) -> bool:
    """Return whether this Blender has an exporter: a build may lack it, or its add-on may be switched off."""
    place, _, verb = name.partition(".")
    return verb in dir(getattr(bpy.ops, place))


def ask(name: str, *, filepath: str, **options: object) -> None:
    """Run one of Blender's exporters by the name of its operator.

    Raises:
        DimpleError: it failed.
    """
    try:
        result = operator.attrgetter(name)(bpy.ops)(filepath=filepath, check_existing=False, **options)
    except RuntimeError as error:
        raise DimpleError(
            "Blender's exporter failed at {filepath}: {why}", filepath=filepath, why=_last_line(str(error))
        ) from error
    if "FINISHED" not in result:
        raise _unfinished(Path(filepath))


def _last_line(text: str) -> str:
    """Return the message of an error, without the place in Blender where it was raised."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith((" ", "Location:"))]
    return lines[-1].removeprefix("Error: ") if lines else text


def _unfinished(path: Path) -> DimpleError:
    return DimpleError(
        "Blender's exporter could not finish {filepath}. Is the disk full, or the folder read-only?", filepath=path
    )


def _pc2(_context: bpy.types.Context, seen: Seen, path: Path) -> None:
    shutil.copy(seen.path, path)


def _alembic(context: bpy.types.Context, seen: Seen, path: Path) -> None:
    plan = seen.clip.plan
    with clips.staged(context, seen, first=plan.first, metres=False) as obj:
        clips.add_cache(obj, seen)
        ask("wm.alembic_export", filepath=str(path), start=plan.first, end=plan.last, as_background_job=False)


def _fbx(context: bpy.types.Context, seen: Seen, path: Path) -> None:
    nameless = [image for image in bpy.data.images if image.packed_file and not image.filepath_raw]
    for image in nameless:  # Blender's exporter takes the name from the path
        image.filepath_raw = f"//{bpy.path.clean_name(image.name)}.{image.file_format.lower().removeprefix('open_')}"
    try:
        with clips.staged(context, seen) as obj:
            clips.add_keys(obj, seen)
            ask(  # with NLA strips or all actions it would write no movement, or that of other objects
                "export_scene.fbx", filepath=str(path), use_mesh_modifiers=False, bake_anim_use_nla_strips=False,
                bake_anim_use_all_actions=False, bake_anim_simplify_factor=0.0, path_mode="COPY", embed_textures=True,
                apply_scale_options="FBX_SCALE_UNITS",
            )  # fmt: skip
    finally:
        for image in nameless:
            image.filepath_raw = ""


def _usd(context: bpy.types.Context, seen: Seen, path: Path) -> None:
    """Write a USD file and its textures, with relative paths, into a folder."""
    path.mkdir()
    file = path / f"{path.name.removesuffix('_usd')}.usdc"
    with clips.staged(context, seen, first=seen.clip.plan.first) as obj:
        clips.add_cache(obj, seen)
        ask(
            "wm.usd_export", filepath=str(file), export_animation=True, export_textures_mode="NEW", relative_paths=True
        )
    if hasattr(bpy.utils, "expose_bundled_modules"):  # the Python module of Blender hides them
        bpy.utils.expose_bundled_modules()
    from pxr import Tf, Usd

    try:
        stage = Usd.Stage.Open(str(file))
        stage.SetFramesPerSecond(1 / timeline.frame_s(context.scene))  # Blender's exporter leaves it at its default
        stage.Save()
    except Tf.ErrorException as error:  # nor does it notice that a disk is full
        raise _unfinished(file) from error


def _glb(context: bpy.types.Context, seen: Seen, path: Path) -> None:
    with clips.staged(context, seen) as obj:
        clips.add_keys(obj, seen)
        _ask_gltf(context.scene, path)


def _ask_gltf(staged: bpy.types.Scene, path: Path) -> None:
    staged.render.fps_base = 1 / staged.render.fps_base  # Blender's exporter multiplies by it, where it should divide
    ask(
        "export_scene.gltf", filepath=str(path), export_format="GLB", use_active_scene=True, export_skins=False,
        export_animation_mode="SCENE", export_frame_range=True, export_anim_slide_to_zero=True,
        export_force_sampling=True, export_optimize_animation_size=False, export_morph_normal=True,
    )  # fmt: skip


def _texture(context: bpy.types.Context, seen: Seen, path: Path) -> None:
    """Write the textures, the mesh with its second UV map, and the layout for a shader, into a folder."""
    from ...core.recording import vertex_texture_layout

    frames, vertices = len(seen.samples), len(seen.vertex_of)
    where = vertex_texture_layout.layout(vertices, frames)
    points, normals = (
        each[..., [0, 2, 1]] * np.float32([1, 1, -1]) for each in (seen.samples[:, seen.vertex_of], seen.normals)
    )
    path.mkdir()
    _write_picture(path / "offsets.exr", vertex_texture_layout.pixels(points - points[0], where))
    _write_picture(path / "normals.exr", vertex_texture_layout.pixels(normals, where))
    with clips.staged(context, seen) as obj:
        maps, corners = obj.data.uv_layers, vertex_texture_layout.uv(vertices, where)[seen.split_of]
        while len(maps) > 1:  # the new map must be the second
            maps.remove(maps[-1])
        if not maps:
            maps.new(name="UVMap", do_init=False)
        maps.new(name=UV_MAP, do_init=False).uv.foreach_set("vector", corners.ravel())
        _ask_gltf(context.scene, path / "mesh.glb")
    words = {
        "about": vertex_texture_layout.__doc__, "width": where.width, "height": where.height, "rows": where.rows,
        "vertices": vertices, "frames": frames, "frame_rate": 1 / timeline.frame_s(context.scene), "uv_map": UV_MAP,
        "bounds": [points.min(axis=(0, 1)).tolist(), points.max(axis=(0, 1)).tolist()],
    }  # fmt: skip
    (path / "layout.json").write_text(json.dumps(words, indent=1) + "\n", encoding="utf-8")


def _write_picture(path: Path, pixels: npt.NDArray[np.float32]) -> None:
    """Write pixels (height, width, 3), the top row first, as OpenEXR with 32-bit floats."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new("Dimple", width, height, float_buffer=True, is_data=True)
    try:
        image.pixels.foreach_set(np.pad(pixels[::-1], ((0, 0), (0, 0), (0, 1)), constant_values=1).ravel())
        image.file_format, image.filepath_raw = "OPEN_EXR", str(path)
        image.save()
    except RuntimeError as error:
        raise _unfinished(path) from error
    finally:
        bpy.data.images.remove(image)


def _corners(size: Size) -> float:
    return 12 * (size.vertices + size.corners)


FORMATS = {
    "ALEMBIC": Format(
        "Alembic", ".abc", "Y up, as Alembic has it, in scene units",
        lambda size: 12 * size.vertices if size.smooth else _corners(size),  # readers smooth it
        _alembic, "wm.alembic_export", pictures=False,
    ),
    "USD": Format("USD", "_usd", "Z up, in metres", _corners, _usd, "wm.usd_export"),
    "GLB": Format(
        "glTF", ".glb", "Y up, in metres, as glTF has it", lambda size: 24 * size.split, _glb, "export_scene.gltf",
        keyed=True, slid=True,
    ),
    "FBX": Format(
        "FBX", ".fbx", "Y up, -Z forward, in metres by UnitScaleFactor",
        lambda size: 14 * size.vertices, _fbx, "export_scene.fbx", keyed=True, slid=True,  # it is compressed
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
