"""The sway of a body: its low modes, driven by how it is led, by gravity as it turns, and by fingertips.

The surface at rest moves with it: skin and law act on top. Each mode is advanced exactly, so any step is stable and
nothing is gained or lost but by damping. Sources: Choi and Ko 2005 (modal warping: each node's displacement is turned
by the modal rotation, so that a body that bends far does not grow); Mueller, Bender, Chentanez and Macklin 2016
(rotations followed from step to step).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .base import Floats, Ints
from .body.modes import Modes
from .material import Material

FOLLOWS = 3  # rounds in which a node's rotation is followed in a step: each squares what is left of it


class Push:
    """What a fingertip does to a body: its force (3,) [N], its place (3,) and how both change with the surface.

    place: (3,) where it acts [m].
    force: (3,) on the body [N].
    slope: (3, 3) by which the force is less for each metre that the surface gives way [N/m].
    """

    def __init__(self, place: Floats, force: Floats, slope: Floats) -> None:
        self.place, self.force, self.slope = place, force, slope


class Sway:
    """The state of the modes of one body, and where its nodes are led.

    amount: of the displacement that shows, 0 to 1.
    """

    def __init__(
        self, modes: Modes, rest: Floats, *, frequency: float, density: float, damping: float, amount: float = 1.0,
        gravity: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Begin at rest.

        Args:
            rest: (n, 3) of the vertices that the modes were made of [m].
            frequency: of the first mode [Hz].
            density: [kg/m3].
            damping: ratio.
            gravity: (3,) in which the body has the shape at rest [m/s2].
        """
        self.modes, self.amount = modes, amount
        self._rates = modes.rates * (2 * math.pi * frequency / modes.rates[0])
        self._damping, self._density, self._gravity = damping, density, np.asarray(gravity, np.float64)
        self._anchors, self._near = _anchors(modes, rest)
        self._arms = rest[self._anchors]
        self._middles = self._near @ self._arms
        self._flat = modes.shapes.reshape(len(modes.rates), -1)
        self._loads = self._flat * np.repeat(modes.volume, 3)
        self.reset()

    def reset(self) -> None:
        """Come to rest."""
        self._q = np.zeros(len(self._rates))
        self._v = np.zeros(len(self._rates))
        self._turn = np.broadcast_to(np.eye(3), (len(self.modes.volume), 3, 3)).copy()
        self._at = self.modes.lattice.nodes
        self._speed: Floats | None = None  # of the nodes, None before a second place is known

    @property
    def energy(self) -> float:
        """Return kinetic and elastic energy of the modes [J]."""
        return float(self._density * (self._v**2 + (self._rates * self._q) ** 2).sum() / 2)

    def advance(self, led: Floats, seconds: float, pushes: Sequence[Push] = ()) -> None:
        """Advance to where the shape at rest is led.

        Args:
            led: (n, 3) vertices at rest at the end [m], without sway.
            seconds: until then.
        """
        at = self._follow(led)
        speed = (at - self._at) / seconds
        before, self._at, self._speed = (speed if self._speed is None else self._speed), at, speed
        pull = np.einsum("mji,mj->mi", self._turn, self._gravity - (speed - before) / seconds) - self._gravity
        self._swing(self._loads @ pull.ravel(), seconds, pushes)

    def displacement(self) -> Floats:
        """Return how far (n, 3) each vertex is from where it is led [m]."""
        moved = self.node_displacement()
        carried = self.modes.nodes
        return self.amount * sum(self.modes.shares[:, c, None] * moved[carried[:, c]] for c in range(8))

    def node_displacement(self) -> Floats:
        """Return how far (m, 3) each node is from where it is led [m]."""
        linear = (self._q @ self._flat).reshape(-1, 3)
        warped = _warped(np.einsum("kma,k->ma", self.modes.turns, self._q), linear)
        return np.einsum("mij,mj->mi", self._turn, warped)

    def _follow(self, led: Floats) -> Floats:
        """Return where the nodes (m, 3) are led, and turn them along."""
        here = led[self._anchors]
        middle = self._near @ here
        outer = (here[:, :, None] * self._arms[:, None, :]).reshape(-1, 9)
        moment = (self._near @ outer).reshape(-1, 3, 3) - middle[:, :, None] * self._middles[:, None, :]
        for _ in range(FOLLOWS):
            left = moment @ self._turn.transpose(0, 2, 1)
            torque = np.stack([left[:, i - 1, i - 2] - left[:, i - 2, i - 1] for i in range(3)], axis=1)
            size = np.abs(left[:, 0, 0] + left[:, 1, 1] + left[:, 2, 2]) + 1e-30
            self._turn = _rotation(torque / size[:, None]) @ self._turn
        return middle + np.einsum("mij,mj->mi", self._turn, self.modes.lattice.nodes - self._middles)

    def _swing(self, load: Floats, seconds: float, pushes: Sequence[Push]) -> None:
        """Advance every mode exactly under a constant load; what pushes gives way to the surface as that moves."""
        rate, z = self._rates, self._damping
        swing = rate * math.sqrt(max(1 - z * z, 1e-9))
        decay, c, s = np.exp(-z * rate * seconds), np.cos(swing * seconds), np.sin(swing * seconds)

        def after(load: Floats) -> tuple[Floats, Floats]:
            still = load / rate**2
            a = self._q - still
            b = (self._v + z * rate * a) / swing
            return still + decay * (a * c + b * s), decay * ((b * swing - z * rate * a) * c - (a * swing + z * rate * b) * s)

        if pushes:
            load = load + self._answer(load, after, (1 - decay * (c + z * rate / swing * s)) / rate**2, pushes)
        self._q, self._v = after(load)

    def _answer(self, load: Floats, after: object, gain: Floats, pushes: Sequence[Push]) -> Floats:
        """Return the load (k,) of what pushes, each less by its slope times how far the surface has gone by then."""
        ways = [self._way(push) for push in pushes]
        total = np.zeros_like(load)
        q = after(load)[0]
        for push, way in zip(pushes, ways, strict=True):
            moved, yields = way @ (q - self._q), (way * gain) @ way.T / self._density
            force = np.linalg.solve(np.eye(3) + push.slope @ yields, push.force - push.slope @ moved)
            total += way.T @ force / self._density
        return total

    def _way(self, push: Push) -> Floats:
        """Return how far (3, k) each mode moves the surface where something pushes."""
        now = self._at + self.node_displacement()
        far = 2 * self.modes.lattice.side
        near = np.clip(1 - ((now - push.place) ** 2).sum(axis=1) / far**2, 0, None) ** 2
        near /= max(near.sum(), 1e-30)
        local = np.einsum("m,mij,kmj->ik", near, self._turn, self.modes.shapes)
        return self.amount * local


def young(material: Material) -> float:
    """Return Young's modulus [Pa] of the solid that answers its measuring tip, as a sphere, alike at the knee.

    Source: Hertz, F = 4/3 E / (1 - nu^2) sqrt(R) x^1.5, with nu of a solid that keeps its volume.
    """
    radius, x = material.indenter.radius, material.x0
    return 0.75 * material.law(x) / (math.sqrt(radius) * x**1.5) * (1 - 0.25)


def first_frequency(modes: Modes, material: Material, density: float) -> float:
    """Return the first frequency [Hz] of a body of a material."""
    return float(modes.rates[0]) * math.sqrt(young(material) / density) / (2 * math.pi)


def _anchors(modes: Modes, rest: Floats) -> tuple[Ints, Floats]:
    """Return one vertex (a,) of each cell that has any, and how much (m, a) each node goes with it."""
    cells, first = np.unique(modes.nodes[:, 0], return_index=True)
    del cells
    ways = ((modes.lattice.nodes[:, None] - rest[first]) ** 2).sum(axis=2)
    near = 1 / (ways + (modes.lattice.side / 2) ** 2) ** 2
    return first, near / near.sum(axis=1, keepdims=True)


def _rotation(turn: Floats) -> Floats:
    """Return rotation matrices (m, 3, 3) of rotation vectors (m, 3)."""
    a = np.sqrt((turn**2).sum(axis=1))[:, None, None]
    k = _cross(turn)
    a = np.maximum(a, 1e-9)
    return np.eye(3) + np.sin(a) / a * k + (1 - np.cos(a)) / a**2 * (k @ k)


def _warped(turn: Floats, linear: Floats) -> Floats:
    """Return displacements (m, 3) along arcs: the mean of the rotations from none to the modal ones, times linear."""
    a = np.maximum(np.sqrt((turn**2).sum(axis=1)), 1e-9)[:, None]
    once = np.cross(turn, linear)
    return linear + (1 - np.cos(a)) / a**2 * once + (a - np.sin(a)) / a**3 * np.cross(turn, once)


def _cross(turn: Floats) -> Floats:
    k = np.zeros((len(turn), 3, 3))
    k[:, 2, 1], k[:, 0, 2], k[:, 1, 0] = turn.T
    return k - k.transpose(0, 2, 1)
