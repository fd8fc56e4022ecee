"""Read an animation without Blender, in a process of its own: `read_back.py FILE OUT.npz`, the readers on the path.

Writes points (frames, vertices, 3), times [s], corners (the vertex of each corner of the faces), counts (corners a
face), and up, unit and frame_rate where the format says them.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np


def usd(path: Path) -> dict[str, Any]:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    (mesh,) = (UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    codes, local = blended(stage, mesh)
    worlds = [np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(mesh.GetPrim())) for code in codes]
    return {
        "local": np.array(local),
        "points": np.array([p @ m[:3, :3] + m[3, :3] for p, m in zip(local, worlds, strict=True)]),
        "times": np.array(codes) / stage.GetTimeCodesPerSecond(),
        "frame_rate": stage.GetTimeCodesPerSecond(),
        "range": [stage.GetStartTimeCode(), stage.GetEndTimeCode()],
        "corners": np.array(mesh.GetFaceVertexIndicesAttr().Get()),
        "counts": np.array(mesh.GetFaceVertexCountsAttr().Get()),
        "unit": UsdGeom.GetStageMetersPerUnit(stage),
        "up": str(UsdGeom.GetStageUpAxis(stage)),
    }


def blended(stage: Any, mesh: Any) -> tuple[list[float], list[np.ndarray]]:
    """Return the time codes and points of a mesh: its samples, or the sums of its blend shapes."""
    from pxr import UsdSkel

    points = mesh.GetPointsAttr()
    animations = [UsdSkel.Animation(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation)]
    if not animations:
        return points.GetTimeSamples(), [np.array(points.Get(code), np.float64) for code in points.GetTimeSamples()]
    (animation,) = animations
    rest, shapes = np.array(points.Get(), np.float64), {}
    binding = UsdSkel.BindingAPI(mesh)
    targets = binding.GetBlendShapeTargetsRel().GetTargets()
    for name, target in zip(binding.GetBlendShapesAttr().Get(), targets, strict=True):
        shape = UsdSkel.BlendShape(stage.GetPrimAtPath(target))
        offsets, some = np.array(shape.GetOffsetsAttr().Get(), np.float64), shape.GetPointIndicesAttr().Get()
        shapes[name] = np.zeros_like(rest)
        shapes[name][slice(None) if some is None else np.array(some)] = offsets.reshape(-1, 3)
    weights, names = animation.GetBlendShapeWeightsAttr(), animation.GetBlendShapesAttr().Get()
    basis = np.array([shapes[name] for name in names])
    codes = weights.GetTimeSamples()
    return codes, [rest + np.tensordot(np.array(weights.Get(code), np.float64), basis, 1) for code in codes]


def glb(path: Path) -> dict[str, Any]:
    from pygltflib import GLTF2

    file = GLTF2().load(str(path))
    data = file.binary_blob()

    def values(number: int) -> np.ndarray:
        accessor = file.accessors[number]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor.type]
        kind = {5123: "<u2", 5125: "<u4", 5126: "<f4"}[accessor.componentType]
        found = np.zeros((accessor.count, width), kind)
        if accessor.bufferView is not None:
            view = file.bufferViews[accessor.bufferView]
            at = (view.byteOffset or 0) + (accessor.byteOffset or 0)
            found = np.frombuffer(data, kind, accessor.count * width, at).reshape(-1, width).copy()
        if accessor.sparse is not None:
            sparse = accessor.sparse
            view = file.bufferViews[sparse.indices.bufferView]
            kind_of = {5123: "<u2", 5125: "<u4", 5121: "<u1"}[sparse.indices.componentType]
            at = (view.byteOffset or 0) + (sparse.indices.byteOffset or 0)
            rows = np.frombuffer(data, kind_of, sparse.count, at)
            view = file.bufferViews[sparse.values.bufferView]
            at = (view.byteOffset or 0) + (sparse.values.byteOffset or 0)
            found[rows] = np.frombuffer(data, kind, sparse.count * width, at).reshape(-1, width)
        return found

    (node,) = (node for node in file.nodes if node.mesh is not None)
    (primitive,) = file.meshes[node.mesh].primitives
    basis = values(primitive.attributes.POSITION).astype(np.float64)
    result: dict[str, Any] = {"basis": basis, "corners": values(primitive.indices).ravel()}
    if primitive.attributes.TEXCOORD_1 is not None:
        result["uv"] = values(primitive.attributes.TEXCOORD_1)
    if not file.animations:
        return result
    morphs = np.array([values(target["POSITION"]) for target in primitive.targets], np.float64)
    (animation,) = file.animations
    tracks = {channel.target.path: animation.samplers[channel.sampler] for channel in animation.channels}
    times = values(tracks["weights"].input).ravel()
    weights = values(tracks["weights"].output).reshape(len(times), -1)
    result |= {"local": basis + np.einsum("tm,mvc->tvc", weights, morphs), "times": times}
    for path_of in ("translation", "rotation", "scale"):
        track, still = tracks.get(path_of), getattr(node, path_of)
        if track:
            result[path_of] = values(track.output)
        elif still:
            result[path_of] = np.array(still)
    return result


if __name__ == "__main__":
    source, out = map(Path, sys.argv[1:])
    np.savez(out, **{".usdc": usd, ".glb": glb}[source.suffix](source))
