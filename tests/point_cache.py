"""Read a PC2 file as any other program would; the extension's own reader takes whole files alone."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

HEADER = struct.Struct("<12siiffi")


def cache_of(obj: Any) -> Any:
    """Return the Mesh Cache by which a baked object plays its offsets in the viewport."""
    group = next(each.node_group for each in obj.modifiers if each.name.startswith("Dimple"))
    infos = sorted((each for each in group.nodes if each.type == "OBJECT_INFO"), key=lambda each: each.name)
    return infos[0].inputs["Object"].default_value.modifiers[0]


def read_point_cache(path: str | Path) -> tuple[float, float, npt.NDArray[np.float32]]:
    """Return start frame, sample rate and positions (samples, vertices, 3); of a file cut short the whole samples."""
    data = Path(path).read_bytes()
    if len(data) < HEADER.size or data[:12] != b"POINTCACHE2\0":
        raise ValueError(f"{path} is not a PC2 point cache")
    _, version, vertices, start, rate, samples = HEADER.unpack_from(data)
    assert version == 1
    whole = min(samples, (len(data) - HEADER.size) // (12 * vertices))
    points = np.frombuffer(data, "<f4", whole * vertices * 3, HEADER.size)
    return start, rate, points.reshape(whole, vertices, 3).astype(np.float32)
