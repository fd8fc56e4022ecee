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
    every = [attribute.Get() for prim in stage.Traverse() for attribute in prim.GetAttributes()]
    codes = np.arange(stage.GetStartTimeCode(), stage.GetEndTimeCode() + 1)  # what is alike is written once
    local = [np.array(mesh.GetPointsAttr().Get(code), np.float64) for code in codes]
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
        "shown_rate": stage.GetFramesPerSecond(),
        "normals": np.array([mesh.GetNormalsAttr().Get(code) for code in codes]),
        "pictures": [path for path in map(picture, every) if path],
        "lights": sum("Light" in prim.GetTypeName() for prim in stage.Traverse()),
        "faults": [each.GetMessage() for each in validated(stage)],
    }


def picture(value: Any) -> str:
    """Return the path of a picture that is there, as the file names it."""
    return value.path if type(value).__name__ == "AssetPath" and value.resolvedPath else ""


def validated(stage: Any) -> list[Any]:
    from pxr import UsdValidation

    registry = UsdValidation.ValidationRegistry()
    return list(UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(stage))


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
    still = values(primitive.attributes.NORMAL).astype(np.float64)
    result: dict[str, Any] = {
        "basis": basis, "corners": values(primitive.indices).ravel(), "images": len(file.images or ()),
        "root": np.array(file.nodes[file.scenes[0].nodes[0]].scale or (1, 1, 1)),
    }  # fmt: skip
    if primitive.attributes.TEXCOORD_1 is not None:
        result["uv"] = values(primitive.attributes.TEXCOORD_1)
    if not file.animations:
        return result
    (animation,) = file.animations
    tracks = {channel.target.path: animation.samplers[channel.sampler] for channel in animation.channels}
    if primitive.targets:
        morphs, turns = (
            np.array([values(each[name]) for each in primitive.targets], np.float64) for name in ("POSITION", "NORMAL")
        )
        times = values(tracks["weights"].input).ravel()
        weights = values(tracks["weights"].output).reshape(len(times), -1)
        result |= {"local": basis + np.einsum("tm,mvc->tvc", weights, morphs), "times": times, "weights": weights}
        result["normals"] = still + np.einsum("tm,mvc->tvc", weights, turns)
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
