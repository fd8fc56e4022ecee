"""A few shapes whose weighted sums are an animation: what morph targets and shape keys need, instead of one a frame.

The shapes are the principal components of the offsets X (frames, coordinates) from the first frame. With the Gram
matrix X X^T = U L U^T (frames, frames) they are U^T X and their weights U, the largest L first: of all sets of as many
shapes the one that leaves the least sum of squares. How many are taken is decided by the worst vertex.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Singles = npt.NDArray[np.float32]


class Basis(NamedTuple):
    """An animation as shapes.

    shapes: (keys, vertices, 3) offsets from the first frame at a weight of 1.
    weights: (frames, keys) from -1 to 1.
    error: the farthest that a vertex is off in any frame.
    """

    shapes: Singles
    weights: Singles
    error: float


def reduce(samples: Singles, tolerance: float) -> Basis:
    """Return the fewest shapes with which no vertex of samples (frames, vertices, 3) is off by more than a tolerance.

    Args:
        tolerance: a length in the units of the samples; what rounding leaves is taken for nothing.
    """
    frames = len(samples)
    offsets = (samples - samples[0]).reshape(frames, -1)
    gram = np.zeros((frames, frames))
    for begin in range(0, offsets.shape[1], 4096):  # in double precision, a part at a time
        part = offsets[:, begin : begin + 4096].astype(np.float64)
        gram += part @ part.T
    squares, vectors = np.linalg.eigh(gram)
    order = np.argsort(squares)[::-1]
    order = order[squares[order] > 1e-14 * max(squares.max(), 1e-300)]
    weights = vectors[:, order]
    shapes = (weights.T.astype(np.float32) @ offsets).reshape(len(order), *samples.shape[1:])
    low, high = 0, len(order)  # the error falls as shapes are added
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if _error(offsets, shapes, weights, middle) <= tolerance else (middle + 1, high)
    scale = np.abs(weights[:, :low]).max(axis=0) if low else np.ones(0)
    taken = (shapes[:low] * scale[:, None, None].astype(np.float32)).astype(np.float32)
    shares = (weights[:, :low] / scale).astype(np.float32)
    return Basis(taken, shares, _error(offsets, taken, shares, low))


def _error(offsets: Singles, shapes: Singles, weights: npt.NDArray[np.floating], count: int) -> float:
    """Return the farthest that a vertex is off with some of the shapes."""
    flat, worst = shapes[:count].reshape(count, offsets.shape[1]), 0.0
    for offset, weight in zip(offsets, weights[:, :count].astype(np.float32), strict=True):
        left = (offset - weight @ flat).reshape(-1, 3)
        worst = max(worst, float(np.einsum("vc,vc->v", left, left).max()))
    return worst**0.5


def error_between(samples: Singles, at: list[int]) -> float:
    """Return the farthest that a vertex of samples (frames, vertices, 3) is from the straight lines between some of
    them, those at these places; the first and the last are among them."""
    worst = 0.0
    for begin, end in zip(at, at[1:], strict=False):
        for place in range(begin + 1, end):
            share = np.float32((place - begin) / (end - begin))
            left = samples[place] - (samples[begin] + share * (samples[end] - samples[begin]))
            worst = max(worst, float(np.einsum("vc,vc->v", left, left).max()))
    return worst**0.5
