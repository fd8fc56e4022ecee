"""The formats of an exported animation: Blender's own exporters where they write one right, numpy elsewhere.

Each writer gets a clip and the path it writes to, and yields the share that is done. What cannot be seen in a Mesh
Cache by an exporter (glTF, FBX: they would write a still) gets shape keys instead.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.base import DimpleError
from ..core.recording import PointCache
from . import stage, timeline

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..core.animation.basis import Basis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Clip:
    """An object and what it does.

    obj: the object.
    cache: a PC2 file that it can play.
    cache_first: frame of the first sample of that.
    samples: (frames, vertices, 3) its own coordinates, in frames first to last.
    first, last: frames.
    step: frames from one shape key to the next.
    key_error: how far a vertex may be off where shape keys are few, as a share of the object's size; 0 for one a frame.
    normals: write how the surface is shaded.
    found: the few shape keys, once they are known.
    """

    obj: bpy.types.Object
    cache: Path
    cache_first: int
    samples: npt.NDArray[np.float32]
    first: int
    last: int
    step: int
    key_error: float
    normals: bool
    found: list[Basis] = field(default_factory=list)

    def basis(self, samples: npt.NDArray[np.float32]) -> Basis:
        """Return the few shapes that samples are made of; found once."""
        from ..core.animation.basis import reduce

        if not self.found:
            self.found.append(reduce(samples, self.key_error * float(np.ptp(samples[0], axis=0).max())))
        return self.found[0]

    @property
    def key_frames(self) -> list[int]:
        """Return the frames that have a shape key."""
        return sorted({*range(self.first, self.last + 1, self.step), self.last})


@dataclass(frozen=True, slots=True)
class Format:
    """A format.

    label: its name.
    ending: of the file; None for a folder of files.
    space: which coordinates, axes and units it holds.
    write: the writer.
    bytes_of: about how long the file is.
    """

    label: str
    ending: str
    space: str
    write: Callable[[bpy.types.Context, Clip, Path], Iterator[float]]
    bytes_of: Callable[[int, int, int], float]


def _pc2(_context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with PointCache(path, clip.samples.shape[1], clip.first) as cache:
        for number, sample in enumerate(clip.samples, start=1):
            cache.append(sample)
            yield number / len(clip.samples)


def _mdd(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    from ..core.animation.mdd import write_mdd

    yield from write_mdd(path, clip.samples, 1 / timeline.frame_s(context.scene))


def _alembic(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with _playing(context, clip):
        _asked(
            bpy.ops.wm.alembic_export, filepath=str(path), check_existing=False, start=clip.first, end=clip.last,
            selected=True, normals=clip.normals, evaluation_mode="RENDER", as_background_job=False,
        )  # fmt: skip
    yield 1.0


def _usd(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with _playing(context, clip):
        _asked(
            bpy.ops.wm.usd_export, filepath=str(path), check_existing=False, selected_objects_only=True,
            export_animation=True, export_normals=clip.normals, evaluation_mode="RENDER", export_textures_mode="KEEP",
            relative_paths=False,
        )  # fmt: skip
    yield 1.0


def _glb(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with _keyed(context, clip):
        _asked(
            bpy.ops.export_scene.gltf, filepath=str(path), check_existing=False, export_format="GLB",
            use_selection=True, export_animations=True, export_animation_mode="SCENE", export_frame_range=True,
            export_anim_slide_to_zero=True, export_force_sampling=True, export_optimize_animation_size=False,
            export_morph=True, export_morph_animation=True, export_morph_normal=clip.normals, export_apply=False,
            export_skins=False, export_yup=True,
        )  # fmt: skip
    yield 1.0


def _fbx(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    with _keyed(context, clip):
        # with NLA strips or all actions it would write no movement, or that of other objects
        _asked(
            bpy.ops.export_scene.fbx, filepath=str(path), check_existing=False, use_selection=True,
            object_types={"MESH"}, use_mesh_modifiers=False, bake_anim=True, bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False, bake_anim_simplify_factor=0.0, bake_anim_step=1.0,
            path_mode="ABSOLUTE",
        )  # fmt: skip
    yield 1.0


def _stl(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    def one(file: str) -> None:
        _asked(
            bpy.ops.wm.stl_export, filepath=file, check_existing=False, export_selected_objects=True,
            apply_modifiers=True, forward_axis="Y", up_axis="Z", global_scale=1.0, use_scene_unit=False,
        )  # fmt: skip

    yield from _sequence(context, clip, path, one)


def _ply(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    def one(file: str) -> None:
        _asked(
            bpy.ops.wm.ply_export, filepath=file, check_existing=False, export_selected_objects=True,
            apply_modifiers=True, forward_axis="Y", up_axis="Z", global_scale=1.0, export_uv=False,
            export_colors="NONE", export_normals=clip.normals,
            export_triangulated_mesh=True,  # trimesh and others read no faces of several sizes
        )  # fmt: skip

    yield from _sequence(context, clip, path, one)


def _sequence(context: bpy.types.Context, clip: Clip, path: Path, one: Callable[[str], None]) -> Iterator[float]:
    """Write a file a frame into a folder, whose name ends in that of the format."""
    stem, ending = path.name.rsplit("_", 1)
    path.mkdir()
    with _playing(context, clip):
        for frame in range(clip.first, clip.last + 1):
            context.scene.frame_set(frame)
            one(str(path / f"{stem}_{frame:04d}.{ending}"))
            yield (frame - clip.first + 1) / (clip.last - clip.first + 1)


def _texture(context: bpy.types.Context, clip: Clip, path: Path) -> Iterator[float]:
    """Write the pictures, the mesh with its second UV map, and what a shader must know, into a folder."""
    from ..core.animation import vertex_texture

    frames, vertices, _ = clip.samples.shape
    where = vertex_texture.layout(vertices, frames)
    picture = vertex_texture.pixels(clip.samples[..., [0, 2, 1]] * np.float32([1, 1, -1]), where)
    yield 0.2
    path.mkdir()
    vertex_texture.write_exr(path / "offsets.exr", picture)
    yield 0.4
    least, most = vertex_texture.write_png(path / "offsets.png", picture)
    yield 0.8
    with stage.mapped(context, clip.obj, clip.samples[0], vertex_texture.uv(vertices, where)):
        _asked(
            bpy.ops.export_scene.gltf, filepath=str(path / "mesh.glb"), check_existing=False, export_format="GLB",
            use_selection=True, export_animations=False, export_apply=False, export_skins=False, export_yup=True,
            export_attributes=False,
        )  # fmt: skip
    words = {
        "about": vertex_texture.__doc__, "width": where.width, "height": where.height, "rows": where.rows,
        "vertices": vertices, "frames": frames, "frame_rate": 1 / timeline.frame_s(context.scene),
        "uv_map": stage.UV_MAP, "least": least, "most": most,
    }  # fmt: skip
    (path / "layout.json").write_text(json.dumps(words, indent=1) + "\n", encoding="utf-8")
    yield 1.0


@contextlib.contextmanager
def _playing(context: bpy.types.Context, clip: Clip) -> Iterator[None]:
    with stage.ranged(context.scene, clip.first, clip.last):
        with stage.playing(context, clip.obj, clip.cache, clip.cache_first):
            yield


@contextlib.contextmanager
def _keyed(context: bpy.types.Context, clip: Clip) -> Iterator[None]:
    with stage.ranged(context.scene, clip.first, clip.last):
        with stage.keyed(context, clip.obj, clip.samples[0], shape_keys(clip)):
            yield


def shape_keys(clip: Clip) -> list[stage.KeyedShape]:
    """Return the shape keys of a clip: one for each frame that has one, or a few that all frames are made of."""
    frames = clip.key_frames
    samples = clip.samples if clip.step == 1 else clip.samples[[frame - clip.first for frame in frames]]
    if not clip.key_error:
        near = [frames[max(at - 1, 0) : at + 2] for at in range(len(frames))]
        return [
            stage.KeyedShape(f"Frame {frame:04d}", sample, some, [float(each == frame) for each in some])
            for frame, sample, some in zip(frames, samples, near, strict=True)
        ]
    basis = clip.basis(samples)
    return [
        stage.KeyedShape(f"Shape {number:03d}", samples[0] + shape, frames, weights)
        for number, (shape, weights) in enumerate(zip(basis.shapes, basis.weights.T, strict=True), start=1)
    ]


def _asked(export: Callable[..., set[str]], *, filepath: str, **options: object) -> None:
    """Ask an exporter of Blender's, with the options that this Blender has.

    Raises:
        DimpleError: it refused, or wrote nothing.
    """
    known = export.get_rna_type().properties.keys()  # type: ignore[attr-defined]
    try:
        result = export(filepath=filepath, **{name: value for name, value in options.items() if name in known})
    except RuntimeError as error:
        raise DimpleError(f"Blender's exporter failed at {filepath}: {_last_line(str(error))}") from error
    if "FINISHED" not in result or not is_whole(Path(filepath)):
        raise DimpleError(f"Blender's exporter could not finish {filepath}. Is the disk full, or the folder read-only?")


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


def _points(vertices: int, frames: int, _corners: int) -> float:
    return 12 * vertices * frames


def _keys(vertices: int, frames: int, corners: int) -> float:
    return (24 if corners else 12) * vertices * frames


def _texels(vertices: int, frames: int, _corners: int) -> float:
    return 18 * vertices * frames


def _baked(vertices: int, frames: int, corners: int) -> float:
    return 12 * (vertices + corners) * frames


OBJECT = "the object's own coordinates: x, y and z as in Blender, before its modifiers, in its own scale"
SCENE = "the scene's coordinates: Z up, in scene units, after modifiers"
TEXTURE = "offsets in the coordinates of mesh.glb: Y up, in scene units, before modifiers; layout.json says how"
FORMATS = {
    "ALEMBIC": Format("Alembic", ".abc", "Y up, as Alembic has it, in scene units, after modifiers", _alembic, _baked),
    "USD": Format("USD", ".usdc", "Z up, metersPerUnit says the unit, after modifiers", _usd, _baked),
    "GLB": Format("glTF", ".glb", "Y up, as glTF has it, in scene units; modifiers are left out", _glb, _keys),
    "FBX": Format("FBX", ".fbx", "Y up, -Z forward, UnitScaleFactor says the unit; no modifiers", _fbx, _keys),
    "PC2": Format("PC2", ".pc2", OBJECT, _pc2, _points),
    "MDD": Format("MDD", ".mdd", OBJECT, _mdd, _points),
    "STL": Format("STL", "_stl", SCENE, _stl, lambda vertices, frames, _: 100 * vertices * frames),
    "PLY": Format("PLY", "_ply", SCENE, _ply, _baked),
    "VAT": Format("Vertex Animation Texture", "_vat", TEXTURE, _texture, _texels),
}
