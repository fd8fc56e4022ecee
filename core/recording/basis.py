"""A few frames whose weighted sums approximate an animation: morph targets or shape keys, fewer than one per frame.

They are chosen one by one: always the frame with the largest error, until all are within the tolerance. The error is
that of the worst vertex and of the worst normal, so the shading of a dent is as accurate as its shape. Each shape is a
frame of the animation, so its normals are right in every program. Weights are from 0 to 1: some programs clip others.
"""

from __future__ import annotations

import hashlib
from typing import NamedTuple

import numpy as np

from ..base import Floats, Singles

TURN = np.radians(1.0)  # [rad] tolerance of a normal: at most 1.7 % of the light; the eye distinguishes 2 % (Weber)
SWEEPS = 200  # sweeps of coordinate descent: enough in practice; the remaining error is measured


class Basis(NamedTuple):
    """An animation as weighted sums of some of its frames.

    chosen: the indices of these frames; their differences from frame 0 are weighted and added to it.
    weights: (frames, chosen).
    error: largest error of a vertex in any frame, in the units of the samples.
    turn: largest error of a normal in any frame [rad], at most.
    """

    chosen: list[int]
    weights: Singles
    error: float = 0.0
    turn: float = 0.0


def distinct(samples: Singles) -> Basis:
    """Return the exact basis of samples (frames, vertices, 3): every distinct frame is a shape of its own."""
    numbers: dict[bytes, int] = {}
    which = [numbers.setdefault(hashlib.sha256(each.tobytes()).digest(), len(numbers)) for each in samples]
    chosen = [which.index(number) for number in range(1, len(numbers))]
    return Basis(chosen, np.eye(len(numbers), dtype=np.float32)[which, 1:])


def reduce(samples: Singles, normals: Singles, tolerance: float) -> Basis:
    """Return a basis of few frames with no error of a vertex above a tolerance, and none of a normal above `TURN`.

    Args:
        samples: (frames, vertices, 3) positions.
        normals: (frames, n, 3) unit normals of the surface.
        tolerance: a length in the units of the samples.
    """
    count = len(samples)
    parts = ((samples - samples[0]) / tolerance, (normals - normals[0]) / TURN)
    every = np.concatenate([part.reshape(count, -1).astype(np.float32) for part in parts], axis=1)
    products = (every @ every.T).astype(np.float64)
    chosen: list[int] = []
    weights = np.zeros((count, 0), np.float32)
    while True:
        left = (every - weights @ every[chosen]).reshape(count, -1, 3)
        off = np.einsum("fnc,fnc->fn", left, left)
        worst = int(off.max(axis=1).argmax())
        if off[worst].max() <= 1:
            error, turn = (float(np.sqrt(part.max())) for part in np.split(off, [samples.shape[1]], axis=1))
            return Basis(chosen, weights, error * tolerance, turn * TURN)
        chosen.append(worst)
        weights = _fitted(products[np.ix_(chosen, chosen)], products[:, chosen], np.pad(weights, ((0, 0), (0, 1))))
        weights[chosen] = np.eye(len(chosen))


def _fitted(among: Floats, of: Floats, weights: Singles) -> Singles:
    """Return the least-squares weights (frames, n) from 0 to 1 of shapes in frames, by coordinate descent.

    Args:
        among: (n, n) dot products of the shapes with each other.
        of: (frames, n) dot products of the frames with the shapes.
        weights: (frames, n) starting values.
    """
    weights = weights.astype(np.float64)
    for _ in range(SWEEPS):
        for number, row in enumerate(among):
            weights[:, number] = np.clip(weights[:, number] + (of[:, number] - weights @ row) / row[number], 0, 1)
    return weights.astype(np.float32)
