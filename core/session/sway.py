"""The sway of a body: its low modes, driven by the motion of object and rig, by gravity as it turns, and by contact.

The surface at rest moves with it: skin and law act on top. Each mode is advanced exactly, so any step is stable, no
energy is gained, and only damping loses it. Sources: Choi and Ko 2005 (modal warping: each node's displacement is
rotated by the modal rotation, so that a body that bends far does not grow); Mueller, Bender, Chentanez and Macklin 2016
(rotations tracked from step to step).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .. import native
from ..base import Floats, Ints, Singles
from ..body.lattice import POISSON
from ..body.model import Model
from ..body.modes import Modes, modes_of
from ..constants import ROUNDING
from ..material import Material
from ..mesh.surface import Mesh
from ..native.motion import Touch
from .fingertip import Finger

After = Callable[[Floats], tuple[Floats, Floats]]
STILL = 1e-5  # of the body's size: it shows no sway and no dent smaller than this


class Push(NamedTuple):
    """Contact forces on some vertices (p,) of a body.

    vertices: indices in the swaying mesh.
    forces: (p, 3) on them [N].
    slopes: (p,) decrease of the forces for each metre that the surface gives way [N/m].
    """

    vertices: Ints
    forces: Floats
    slopes: Floats


def push_of(touch: Touch, finger: Finger, mesh: Mesh) -> Push:
    """Return the push of a touching fingertip on a body; with a prescribed force it does not decrease."""
    slope = touch.slope if finger.force is None else 0.0
    return Push(mesh.triangles[touch.triangle], np.tile(touch.force, (3, 1)) / -3, np.full(3, slope / 3))


class Sway:
    """The state of the modes of one body, and the motion of its nodes with object and rig.

    amount: share of the displacement that is shown, 0 to 1.
    """

    def __init__(
        self, mesh: Mesh, held: Floats, modes: Modes, *, frequency: float, density: float, damping: float,
        amount: float = 1.0, gravity: Sequence[float] | Floats = (0.0, 0.0, 0.0), young: float = 0.0,
    ) -> None:  # fmt: skip
        """Begin at rest.

        Args:
            mesh, held: from which the modes were made.
            modes: of the body.
            frequency: of the first mode [Hz].
            density: [kg/m3].
            damping: ratio.
            gravity: (3,) [m/s2] in which the body has its shape at rest.
            young: Young's modulus of its skin at its stiffest, beyond the knee [Pa].
        """
        self.mesh, self.held, self.modes, self.amount = mesh, held, modes, amount
        self._rates = modes.rates * (2 * math.pi * frequency / modes.rates[0])
        self._damping, self._density, self._young = damping, density, young
        self._gravity = self._modelled = np.asarray(gravity, np.float64)  # current, and that of the shape at rest
        rest = mesh.rest_positions
        self._anchors, self._near = _anchors(modes, rest)
        self._arms = rest[self._anchors]
        self._middles = self._near @ self._arms
        moment = self._moments(self._arms, self._middles)
        size = np.einsum("mii->m", moment)[:, None, None] + 1e-30
        self._yields = size * np.linalg.inv((1 + ROUNDING) * size * np.eye(3) - moment)
        self._flat = modes.shapes.reshape(len(modes.rates), -1)
        self._loads = self._flat * np.repeat(modes.volume, 3)
        self._reach = np.abs(self._flat).max(axis=1)
        self.reset()

    def reset(self) -> None:
        """Put the body back to rest."""
        self._q = np.zeros(len(self._rates))
        self._v = np.zeros(len(self._rates))
        self._turn = np.broadcast_to(np.eye(3), (len(self.modes.volume), 3, 3)).copy()
        self._at = self.modes.lattice.nodes
        self._speed: Floats | None = None  # of the nodes, None before a second position is known

    def go_on(self, before: Sway) -> None:
        """Continue the previous sway of the same body."""
        self._q, self._v, self._turn = before._q, before._v, before._turn
        self._at, self._speed, self._modelled = before._at, before._speed, before._modelled

    @property
    def moves(self) -> bool:
        """Return whether anything sways, or moves with object or rig."""
        far = np.abs(self._q) + np.abs(self._v) / self._rates
        sways = bool((far * self._reach).sum() > STILL * self.mesh.size)
        return self._speed is None or bool(self._speed.any()) or sways

    @property
    def frequency(self) -> float:
        """Return the frequency of its slowest mode [Hz]."""
        return float(self._rates[0]) / (2 * math.pi)

    def advance(self, led: Floats, seconds: float, pushes: Sequence[Push] = ()) -> None:
        """Advance to the positions at which object and rig put the shape at rest.

        Args:
            led: (n, 3) these positions of the vertices at the end, without sway [m].
            seconds: duration [s].
            pushes: contact forces meanwhile.
        """
        at = self._follow(led)
        speed = (at - self._at) / seconds
        before, self._at, self._speed = (speed if self._speed is None else self._speed), at, speed
        kick = np.einsum("mji,mj->mi", self._turn, before - speed)  # an impulse, whatever the step's duration
        pull = self._gravity @ self._turn - self._modelled
        self._v = self._v + self._loads @ kick.ravel()
        self._swing(self._loads @ pull.ravel(), seconds, pushes)

    def met(self, impulses: Floats, seconds: float, vertices: Ints | None) -> Push:
        """Return the push of other surfaces on vertices that they touch.

        Args:
            impulses: (m, 3) that they gave in some seconds [N s].
            vertices: (m,) vertices of the mesh that received them, None for all.

        Source: Sneddon 1965: the slope 2 E / (1 - nu^2) a for a contact of radius a holds for a tip of any shape.
        """
        size = np.linalg.norm(impulses, axis=1)
        touched = np.flatnonzero(size)
        at = touched if vertices is None else vertices[touched]
        radius = math.sqrt(float(self.mesh.vertex_areas[at].sum()) / math.pi)
        slope = 2 * self._young / (1 - POISSON**2) * radius
        return Push(at, impulses[touched] / seconds, slope * size[touched] / max(float(size.sum()), 1e-30))

    def displacement(self) -> Singles:
        """Return the displacement (n, 3) of each vertex by the sway [m]."""
        return self._carried(self.amount * self.node_displacement())

    def node_displacement(self) -> Floats:
        """Return the displacement (m, 3) of each node by the whole sway, whatever the amount [m]."""
        linear = (self._q @ self._flat).reshape(-1, 3)
        warped = _warped(np.einsum("kma,k->ma", self.modes.turns, self._q), linear)
        return np.einsum("mij,mj->mi", self._turn, warped)

    def velocity(self) -> Singles:
        """Return the velocity (n, 3) of each vertex by the sway [m/s]."""
        swings = np.einsum("mij,mj->mi", self._turn, (self._v @ self._flat).reshape(-1, 3))
        return self._carried(self.amount * swings)

    def _carried(self, nodes: Floats) -> Singles:
        """Return values (m, 3) of the nodes interpolated to the vertices (n, 3)."""
        return native.carry_by_nodes(native.library(), self.modes.nodes, self.modes.shares, nodes)

    def _follow(self, led: Floats) -> Floats:
        """Return the positions of the nodes (m, 3) without sway, and update their rotations."""
        here = led[self._anchors]
        middle = self._near @ here
        moment = self._moments(here, middle)
        left = self._turn.transpose(0, 2, 1) @ moment
        torque = np.stack([left[:, i - 1, i - 2] - left[:, i - 2, i - 1] for i in range(3)], axis=1)
        size = np.abs(np.einsum("mii->m", left)) + 1e-30
        self._turn = self._turn @ _rotation(np.einsum("mij,mj,m->mi", self._yields, torque, 1 / size))
        return middle + np.einsum("mij,mj->mi", self._turn, self.modes.lattice.nodes - self._middles)

    def _moments(self, here: Floats, middle: Floats) -> Floats:
        """Return the covariances (m, 3, 3) of the anchors (a, 3) with their positions at rest, about each node [m2]."""
        outer = (here[:, :, None] * self._arms[:, None, :]).reshape(-1, 9)
        return (self._near @ outer).reshape(-1, 3, 3) - middle[:, :, None] * self._middles[:, None, :]

    def _swing(self, load: Floats, seconds: float, pushes: Sequence[Push]) -> None:
        """Advance every mode exactly under a constant load; pushes decrease as the surface gives way."""
        rate, z = self._rates, self._damping
        swing = rate * math.sqrt(max(1 - z * z, 1e-9))
        decay, c, s = np.exp(-z * rate * seconds), np.cos(swing * seconds), np.sin(swing * seconds)

        def after(load: Floats) -> tuple[Floats, Floats]:
            still = load / rate**2
            a = self._q - still
            b = (self._v + z * rate * a) / swing
            q = still + decay * (a * c + b * s)
            return q, decay * ((b * swing - z * rate * a) * c - (a * swing + z * rate * b) * s)

        if pushes:
            push = Push(*map(np.concatenate, zip(*pushes, strict=True)))
            load = load + self._answer(load, after, (1 - decay * (c + z * rate / swing * s)) / rate**2, push)
        self._q, self._v = after(load)

    def _answer(self, load: Floats, after: After, gain: Floats, push: Push) -> Floats:
        """Return the load (k,) of a push, less its slopes times the distance that the surface has given way by the end.

        Source: Mindlin: the slope along the surface is two thirds of the normal one.
        """
        _, forces, slopes = push
        ways = self._ways(push.vertices)
        outward = forces / np.maximum(np.linalg.norm(forces, axis=1, keepdims=True), 1e-30)
        yields = 2 / 3 * ways + np.einsum("pi,pj,pjk->pik", outward, outward, ways) / 3
        flat = ways.reshape(-1, len(load)).T / self._density
        resists = flat @ (slopes[:, None, None] * yields).reshape(-1, len(load))
        left = flat @ forces.ravel() - resists @ (after(load)[0] - self._q)
        return np.linalg.solve(np.eye(len(load)) + resists * gain, left)

    def _ways(self, vertices: Ints) -> Floats:
        """Return the displacement (p, 3, k) of some vertices by each mode."""
        nodes, shares = self.modes.nodes[vertices], self.modes.shares[vertices]
        turned = (self.amount * shares[:, :, None, None] * self._turn[nodes]).transpose(0, 2, 1, 3)
        shapes = self.modes.shapes.transpose(1, 2, 0)[nodes]
        return turned.reshape(len(vertices), 3, -1) @ shapes.reshape(len(vertices), turned[0].size // 3, -1)


def sway_of(model: Model, before: Sway | None) -> Sway | None:
    """Return the sway of a model at rest, None if it has none; it continues `before` if that is of the same body."""
    wanted = model.sway
    if wanted is None:
        return None
    mesh = model.mesh
    goes_on = before is not None and before.mesh is mesh and np.array_equal(before.held, wanted.held)
    modes = before.modes if before and goes_on else modes_of(mesh, wanted.held, bones=wanted.bones)
    if modes is None:
        return None
    largest = int(np.bincount(mesh.triangle_material, mesh.triangle_areas, len(model.materials)).argmax())
    material, density = model.materials[largest], float(model.mass.sum()) / mesh.volume
    sway = Sway(
        mesh, wanted.held, modes, frequency=wanted.frequency or first_frequency(modes, material, density),
        density=density, damping=wanted.damping, amount=wanted.amount, gravity=wanted.gravity,
        young=young(material) * max(1.0, material.K2 / material.K1),
    )  # fmt: skip
    if before and goes_on:
        sway.go_on(before)
    return sway


def young(material: Material) -> float:
    """Return Young's modulus [Pa] of the solid with the material's force at the knee, under a spherical measuring tip.

    Source: Hertz, F = 4/3 E / (1 - nu^2) sqrt(R) x^1.5, with nu near 1/2 for a solid that keeps its volume.
    """
    radius, x = material.indenter.radius, material.x0
    return 0.75 * material.law(x) / (math.sqrt(radius) * x**1.5) * (1 - 0.25)


def first_frequency(modes: Modes, material: Material, density: float) -> float:
    """Return the first frequency [Hz] of a body of a material and a density [kg/m3]."""
    return float(modes.rates[0]) * math.sqrt(young(material) / density) / (2 * math.pi)


def _anchors(modes: Modes, rest: Floats) -> tuple[Ints, Floats]:
    """Return one vertex (a,) of each cell that has any, and the weights (m, a) by which each node follows them."""
    _, first = np.unique(modes.nodes[:, 0], return_index=True)
    ways = ((modes.lattice.nodes[:, None] - rest[first]) ** 2).sum(axis=2)
    near = 1 / (ways + (modes.lattice.sides.mean() / 2) ** 2) ** 2
    return first, near / near.sum(axis=1, keepdims=True)


def _rotation(turn: Floats) -> Floats:
    """Return rotation matrices (m, 3, 3) of rotation vectors (m, 3)."""
    a = np.sqrt((turn**2).sum(axis=1))[:, None, None]
    k = _cross(turn)
    a = np.maximum(a, 1e-9)
    return np.eye(3) + np.sin(a) / a * k + (1 - np.cos(a)) / a**2 * (k @ k)


def _warped(turn: Floats, linear: Floats) -> Floats:
    """Return displacements (m, 3) along arcs: the linear ones times the mean of the rotations from 0 to `turn`."""
    a = np.maximum(np.sqrt((turn**2).sum(axis=1)), 1e-9)[:, None]
    once = np.cross(turn, linear)
    return linear + (1 - np.cos(a)) / a**2 * once + (a - np.sin(a)) / a**3 * np.cross(turn, once)


def _cross(turn: Floats) -> Floats:
    k = np.zeros((len(turn), 3, 3))
    k[:, 2, 1], k[:, 0, 2], k[:, 1, 0] = turn.T
    return k - k.transpose(0, 2, 1)
