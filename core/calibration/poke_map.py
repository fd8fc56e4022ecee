"""A map of softness from many pokes of one object: where, how deep and with which force, as robots record them.

At each place the force over that of the material's law says how many times as stiff the object is there. Its logarithm
is taken for a Gaussian process over the surface: smooth, over a length and with a noise that the pokes themselves make
the most likely. So every vertex gets a softness with an interval, and every place can be predicted from the others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base import DimpleError, Floats
from ..material import Material
from ..mesh.surface import Mesh
from ..messages import Message

FEWEST, MOST = 8, 800  # places: fewer tell no map, more are joined with their neighbours
SAME = 1e-3  # of the size: pokes this near are at one place
FAR = 0.1  # of the size: pokes farther from the surface are none of this object
LEAST_LAW = 1e-9  # [N]
LENGTHS = np.geomspace(0.03, 2.0, 22)  # of the size of the object: over which softness changes
NOISES = np.geomspace(0.02, 3.0, 16)  # of how much softness differs: standard deviation at a place
BROAD = 10.0  # standard deviation of the mean, in those of softness
NORMAL_95 = 1.96
PER_WEIGHT = 2 * math.log(4.0)  # a weight of 1 is four times as soft as one of 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Pokes:
    """Pokes of one object: places (p, 3) [m], depths (p,) [m] and forces (p,) [N]."""

    places: Floats
    depths: Floats
    forces: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeMap:
    """Softness over a mesh.

    stiffness: (n,) how many times as stiff as the material each vertex is.
    interval: (n,) factor by which it may be more or less, 95 %.
    weights: (n,) softness as it is painted: 0.5 as measured, 1 four times softer, 0 four times stiffer.
    length: over which softness changes [m].
    noise: of one place, as a share of its force.
    places: how many there are.
    pokes: how many there were.
    error: of the force at places that are predicted from all others, RMS as a share of it.
    without: what that error would be with one softness for all.
    coverage: share of those places that lie in the 95 % interval predicted for them.
    outside: share of the vertices that are softer or stiffer than a map can say.
    """

    stiffness: Floats
    interval: Floats
    weights: Floats
    length: float
    noise: float
    places: int
    pokes: int
    error: float
    without: float
    coverage: float
    outside: float

    @property
    def text(self) -> str:
        """Return what was found, as a sentence."""
        return Message(
            "{pokes} pokes at {places} places: each place predicted from the others, the force is off by {error:.1%} "
            "(RMS; with one softness for all {without:.1%}), {coverage:.0%} lie in their 95 % interval. Softness "
            "changes over {length:.3g} mm.",
            pokes=self.pokes, places=self.places, error=self.error, without=self.without, coverage=self.coverage,
            length=1e3 * self.length
        )  # fmt: skip


def map_pokes(mesh: Mesh, material: Material, pokes: Pokes) -> PokeMap:
    """Find softness over a mesh.

    Args:
        mesh: in the size and the place of the object that was poked [m].
        material: whose law the forces are compared with.

    Raises:
        DimpleError: too few places, or they are not on this object.
    """
    _check(mesh, pokes)
    law = np.array([material.law(depth) for depth in pokes.depths.tolist()])
    good = (law > LEAST_LAW) & (pokes.forces > 0)
    if not good.any():
        raise DimpleError("No poke has a depth and a force greater than 0. Are the columns the right ones?")
    places, logs, counts = _at_places(pokes.places[good], pokes.forces[good], law[good], SAME * mesh.size)
    if len(places) < FEWEST:
        raise DimpleError(
            "A map needs pokes at {least} or more different places; this file has {places}.",
            least=FEWEST, places=len(places)
        )  # fmt: skip
    found = _likeliest(places, logs, counts, mesh.size)
    mean, spread = found.at(mesh.rest_positions)
    left_out, left_error = found.left_out()
    error = np.exp(left_out - logs) - 1
    flat = np.exp((logs.sum() - logs) / (len(logs) - 1) - logs) - 1
    weights = 0.5 - mean / PER_WEIGHT
    return PokeMap(
        stiffness=np.exp(mean), interval=np.exp(NORMAL_95 * spread), weights=np.clip(weights, 0.0, 1.0),
        length=found.length, noise=found.noise, places=len(places), pokes=int(good.sum()),
        error=float(np.sqrt((error**2).mean())), without=float(np.sqrt((flat**2).mean())),
        coverage=float((np.abs(left_out - logs) <= NORMAL_95 * left_error).mean()),
        outside=float(((weights < 0) | (weights > 1)).mean()),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Process:
    """A Gaussian process through measurements, with a mean that is not known.

    places: (p, 3) [m].
    logs: (p,) logarithms that were measured there.
    length: over which they change [m].
    noise: standard deviation of one of them.
    scale: variance of softness.
    inverse: (p, p) of the covariance, in units of that.
    """

    places: Floats
    logs: Floats
    length: float
    noise: float
    scale: float
    inverse: Floats

    def at(self, points: Floats) -> tuple[Floats, Floats]:
        """Return mean and standard deviation (n,) at points (n, 3) [m]."""
        mean, spread = np.empty(len(points)), np.empty(len(points))
        weighted = self.inverse @ self.logs
        for part in np.array_split(np.arange(len(points)), len(points) // 2000 + 1):
            cross = _kernel(points[part], self.places, self.length) + BROAD**2
            mean[part] = cross @ weighted
            own = 1 + BROAD**2
            spread[part] = np.sqrt(self.scale * np.maximum(own - ((cross @ self.inverse) * cross).sum(axis=1), 0))
        return mean, spread

    def left_out(self) -> tuple[Floats, Floats]:
        """Return mean and standard deviation (p,) of each measurement, predicted from all others."""
        diagonal = np.diag(self.inverse)
        return self.logs - (self.inverse @ self.logs) / diagonal, np.sqrt(self.scale / diagonal)


def _likeliest(places: Floats, logs: Floats, counts: Floats, size: float) -> _Process:
    """Return the process whose length and noise make the measurements the most likely."""
    found: tuple[float, _Process] | None = None
    for length in LENGTHS * size:
        shape = _kernel(places, places, float(length)) + BROAD**2
        for noise in NOISES:
            covariance = shape + np.diag(noise**2 / counts)
            try:
                factor = np.linalg.cholesky(covariance)
            except np.linalg.LinAlgError:
                continue
            solved = np.linalg.solve(factor, logs)
            scale = float(solved @ solved) / len(logs)
            likely = -np.log(np.diag(factor)).sum() - len(logs) / 2 * math.log(max(scale, 1e-30))
            if found is None or likely > found[0]:
                inverse = np.linalg.inv(covariance)
                process = _Process(places, logs, float(length), float(noise * math.sqrt(scale)), scale, inverse)
                found = float(likely), process
    if found is None:
        raise DimpleError("All pokes are at almost the same place. Record them across the surface.")
    return found[1]


def _kernel(one: Floats, other: Floats, length: float) -> Floats:
    """Return Matern's covariance (n, m) of order 3/2: smooth, but no smoother than a body is."""
    squares = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1) - 2 * one @ other.T
    r = np.sqrt(3 * np.maximum(squares, 0)) / length
    return np.asarray((1 + r) * np.exp(-r), np.float64)


def _at_places(places: Floats, forces: Floats, law: Floats, same: float) -> tuple[Floats, Floats, Floats]:
    """Return places (q, 3) [m], the logarithm of stiffness (q,) and how many pokes there are at each (q,).

    Pokes at one place are one measurement: the force over the law's, by least squares.
    """
    while True:
        _, which, counts = np.unique(np.round(places / same), axis=0, return_inverse=True, return_counts=True)
        if len(counts) <= MOST:
            break
        same *= 1.3
    which = which.reshape(-1)
    ratio = np.bincount(which, weights=forces * law) / np.bincount(which, weights=law**2)
    middle = np.stack([np.bincount(which, weights=axis) / counts for axis in places.T], axis=1)
    return middle, np.log(ratio), counts.astype(float)


def _check(mesh: Mesh, pokes: Pokes) -> None:
    """Raise a DimpleError where the pokes are not near the surface."""
    sample: Sequence[int] = range(0, len(pokes.places), max(len(pokes.places) // 200, 1))
    points = np.concatenate([mesh.rest_positions[~mesh.loose], mesh.rest_positions[mesh.triangles].mean(axis=1)])
    away = np.array([math.sqrt(((points - pokes.places[i]) ** 2).sum(axis=1).min()) for i in sample])
    reach = FAR * mesh.size + float(np.median(mesh.rest_lengths))
    if np.median(away) > reach:
        raise DimpleError(
            "The pokes lie {distance:.3g} mm from the surface. Their x, y and z are places on the object as it "
            "stands in the scene, at its physical size.",
            distance=1e3 * float(np.median(away)),
        )
