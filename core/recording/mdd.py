"""MDD: the point cache of LightWave, which Maya, Cinema 4D, Houdini and Blender's Mesh Cache modifier read.

Format: int32 samples, int32 vertices, float32 (samples,) time of each [s], then float32 (samples, vertices, 3),
big-endian.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt


def write_mdd(path: str | os.PathLike[str], samples: npt.NDArray[np.float32], fps: float) -> Iterator[float]:
    """Write samples (frames, vertices, 3), the first at 0 s; yield the share that is done.

    Raises:
        OSError: the disk refuses.
    """
    count, vertices, _ = samples.shape
    with Path(path).open("wb") as file:
        file.write(np.array([count, vertices], ">i4").tobytes())
        file.write((np.arange(count) / fps).astype(">f4").tobytes())
        for number, sample in enumerate(samples, start=1):
            file.write(sample.astype(">f4").tobytes())
            yield number / count
