"""What only an emulated device needs of its linkage: the angles of a place, and the force of its torques."""

from __future__ import annotations

import math

from core.errors import DimpleError
from core.vectors import Vector

from .kinematics import Block

MOST_CONDITION = 1e3  # beyond it a force needs torques that no motor has


class Singular(DimpleError):
    """A block is where it cannot move, or push, in some direction."""


class Unreachable(DimpleError):
    """A position is out of reach of a block."""


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
