"""Where a fingertip is, from the angles of its block's three joints, and which torques make a force there.

A base yaw q0 carries two links of a coaxial parallelogram, whose angles q1, q2 are counted from the horizontal:

    r = l1 cos q1 + l2 cos q2,    p = (r cos q0, r sin q0, l1 sin q1 + l2 sin q2)

All places are in the device's frame: its origin the centre of the workspace, z up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..errors import DimpleError
from ..vectors import Vector
from .spec import Spec
from .wire import FULL_SCALE

Rows = tuple[Vector, Vector, Vector]
MOST_CONDITION = 1e3  # beyond it a force needs torques that no motor has


class Singular(DimpleError):
    """A block is where it cannot move, or push, in some direction."""


class Unreachable(DimpleError):
    """A position is out of reach of a block."""


class Block(NamedTuple):
    """The linkage of one finger.

    name: for messages.
    l1, l2: lengths of the links [m].
    base: position of the shoulder [m].
    cos, sin: of the angle at which it stands around the centre.
    """

    name: str
    l1: float
    l2: float
    base: Vector
    cos: float
    sin: float


def blocks(spec: Spec) -> tuple[Block, ...]:
    """Return the blocks of a device; each stands at its angle, looking at the centre."""
    made = []
    for name, angle in zip(spec.block_names, spec.block_angles, strict=True):
        c, s = math.cos(angle), math.sin(angle)
        base = (-spec.centre_distance * c, -spec.centre_distance * s, spec.base_height)
        made.append(Block(name, spec.l1, spec.l2, base, c, s))
    return tuple(made)


def forward(block: Block, q: Vector) -> Vector:
    """Return the place [m] of the tip for joint angles [rad]."""
    r = block.l1 * math.cos(q[1]) + block.l2 * math.cos(q[2])
    x, y = r * math.cos(q[0]), r * math.sin(q[0])
    return (
        block.base[0] + block.cos * x - block.sin * y,
        block.base[1] + block.sin * x + block.cos * y,
        block.base[2] + block.l1 * math.sin(q[1]) + block.l2 * math.sin(q[2]),
    )


def inverse(block: Block, p: Vector) -> Vector:
    """Return the joint angles [rad] for a place [m] of the tip, elbow up, by the law of cosines.

    Raises:
        Unreachable: it is too far from the base, or too near.
        Singular: it is on the axis of the yaw, or the links lie in one line.
    """
    dx, dy, z = p[0] - block.base[0], p[1] - block.base[1], p[2] - block.base[2]
    x, y = block.cos * dx + block.sin * dy, block.cos * dy - block.sin * dx
    r = math.hypot(x, y)
    bend = (r * r + z * z - block.l1**2 - block.l2**2) / (2 * block.l1 * block.l2)  # cos (q1 - q2)
    if not -1 <= bend <= 1:
        raise Unreachable(
            "The {name} cannot reach {distance:.3f} m from its base.", name=block.name, distance=math.hypot(r, z)
        )
    _refuse_singular(block, r, math.sqrt(1 - bend * bend))
    turn = math.acos(bend)
    q1 = math.atan2(z, r) + math.atan2(block.l2 * math.sin(turn), block.l1 + block.l2 * bend)
    return math.atan2(y, x), q1, q1 - turn


def jacobian(block: Block, q: Vector) -> Rows:
    """Return J (3, 3) [m/rad]: dp = J dq."""
    c0, s0 = math.cos(q[0]), math.sin(q[0])
    c, s = block.cos * c0 - block.sin * s0, block.sin * c0 + block.cos * s0  # of the yaw in the device's frame
    a1, b1 = block.l1 * math.cos(q[1]), block.l1 * math.sin(q[1])
    a2, b2 = block.l2 * math.cos(q[2]), block.l2 * math.sin(q[2])
    r = a1 + a2
    return (-r * s, -b1 * c, -b2 * c), (r * c, -b1 * s, -b2 * s), (0.0, a1, a2)


def torques(block: Block, q: Vector, force: Vector) -> Vector:
    """Return the joint torques [N m] that make a force [N] at the tip: J^T F."""
    (a, b, c), (d, e, f), (g, h, i) = jacobian(block, q)
    x, y, z = force
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


def force(block: Block, q: Vector, torque: Vector) -> Vector:
    """Return the force [N] at the tip that joint torques [N m] make: J^-T tau.

    Raises:
        Singular: no finite force does.
    """
    c0, s0 = math.cos(q[0]), math.sin(q[0])
    c, s = block.cos * c0 - block.sin * s0, block.sin * c0 + block.cos * s0
    r = block.l1 * math.cos(q[1]) + block.l2 * math.cos(q[2])
    bend = math.sin(q[1] - q[2])
    _refuse_singular(block, r, bend)
    t1, t2 = torque[1] / block.l1, torque[2] / block.l2
    out = (math.cos(q[2]) * t1 - math.cos(q[1]) * t2) / -bend
    up = (math.sin(q[2]) * t1 - math.sin(q[1]) * t2) / -bend
    across = torque[0] / r
    return c * out - s * across, s * out + c * across, up


def _refuse_singular(block: Block, r: float, bend: float) -> None:
    if abs(r) * MOST_CONDITION < block.l1 + block.l2:
        raise Singular(
            "The tip of the {name} is on the axis of its base: it cannot move sideways there.", name=block.name
        )
    if abs(bend) * MOST_CONDITION < 1:
        raise Singular("The links of the {name} lie in one line: the tip cannot move along it.", name=block.name)


def adc_angles(spec: Spec, words: tuple[int, ...]) -> Vector:
    """Return the angles [rad] of a block's three joints for its words of a STATE."""
    scale = spec.adc_span / 65536
    half = 32768 - (1 << (15 - spec.adc_bits) if spec.adc_bits < 16 else 0)  # the middle of a converter's step
    a, b, c = spec.adc_centres
    return a + (words[0] - half) * scale, b + (words[1] - half) * scale, c + (words[2] - half) * scale


def torque_words(spec: Spec, torque: Vector) -> tuple[int, int, int]:
    """Return the words of a CMD for a block's torques [N m], clamped to full scale; 0 where one is not a number."""
    a, b, c = spec.torque_limits
    return _word(torque[0] / a), _word(torque[1] / b), _word(torque[2] / c)


def _word(share: float) -> int:
    return round(FULL_SCALE * min(max(share, -1.0), 1.0)) if math.isfinite(share) else 0


def word_torques(spec: Spec, words: tuple[int, ...]) -> Vector:
    """Return the torques [N m] that the words of a CMD command of a block."""
    a, b, c = spec.torque_limits
    return words[0] / FULL_SCALE * a, words[1] / FULL_SCALE * b, words[2] / FULL_SCALE * c
