"""A few frames whose weighted sums are an animation: what morph targets and shape keys need, instead of one a frame.

They are chosen one by one: the frame that is farthest off, until none is. How far off is judged by the worst vertex and
by the worst normal, so the shading of a dent is as right as its shape. Each shape is a frame that was seen, so its
normals are right whoever computes them. Weights are from 0 to 1, for some programs cut off any other.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
TURN = np.radians(1.0)  # of a normal: it changes the light by at most 1.7 %; the eye tells apart 2 % (Weber's fraction)
SWEEPS = 200  # over the weights; near enough, for what they leave is measured


class Basis(NamedTuple):
    """An animation as sums of some of its frames.

    chosen: the places of those frames; the first frame is what the sums are added to.
    weights: (frames, chosen).
    error: the farthest that a vertex is off in any frame.
    turn: the farthest that a normal is off in any frame [rad].
    """

    chosen: list[int]
    weights: Singles
    error: float = 0.0
    turn: float = 0.0


def distinct(samples: Singles) -> Basis:
    """Return all frames of samples (frames, vertices, 3) that are not alike."""
    numbers: dict[bytes, int] = {}
    which = [numbers.setdefault(hashlib.sha256(each.tobytes()).digest(), len(numbers)) for each in samples]
    chosen = [which.index(number) for number in range(1, len(numbers))]
    return Basis(chosen, np.eye(len(numbers), dtype=np.float32)[which, 1:])


def reduce(samples: Singles, normals: Singles, tolerance: float) -> Basis:
    """Return few frames with which no vertex is off by more than a tolerance, and no normal by more than `TURN`.

    Args:
        samples: (frames, vertices, 3).
        normals: (frames, n, 3) of the surface, of length 1.
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
        off = np.einsum("fnc,fnc->fn", left, left).max(axis=1)
        worst = int(off.argmax())
        if off[worst] <= 1:
            break
        chosen.append(worst)
        weights = _fitted(products[np.ix_(chosen, chosen)], products[:, chosen], np.pad(weights, ((0, 0), (0, 1))))
        weights[chosen] = np.eye(len(chosen))
    error = max(np.linalg.norm(played - now, axis=1).max() for played, now in _played(samples, chosen, weights))
    turn = max(_angle(played, now) for played, now in _played(normals, chosen, weights))
    return Basis(chosen, weights, float(error), turn)


def _fitted(among: Floats, of: Floats, weights: Singles) -> Singles:
    """Return weights (frames, n) from 0 to 1 with which shapes come nearest to frames, by coordinate descent.

    Args:
        among: (n, n) products of the shapes with each other.
        of: (frames, n) products of the frames with the shapes.
        weights: (frames, n) to begin with.
    """
    weights = weights.astype(np.float64)
    for _ in range(SWEEPS):
        for number, row in enumerate(among):
            weights[:, number] = np.clip(weights[:, number] + (of[:, number] - weights @ row) / row[number], 0, 1)
    return weights.astype(np.float32)


def _played(samples: Singles, chosen: list[int], weights: Singles) -> Iterator[tuple[Singles, Singles]]:
    """Yield each frame as it is played, and as it was."""
    shapes = samples[chosen] - samples[0]
    for now, weight in zip(samples, weights, strict=True):
        yield samples[0] + np.tensordot(weight, shapes, 1), now


def _angle(played: Singles, now: Singles) -> float:
    """Return the largest angle [rad] between normals as they are played and as they were."""
    length = np.linalg.norm(played, axis=1, keepdims=True)
    chord = np.linalg.norm(played / np.maximum(length, 1e-9) - now, axis=1).max()
    return float(2 * np.arcsin(min(chord / 2, 1.0)))
