"""Where a fingertip is, from the angles of its block's three joints, and which torques make a force there.

A base yaw q0 carries two links of a coaxial parallelogram, whose angles q1, q2 are counted from the horizontal:

    r = l1 cos q1 + l2 cos q2,    p = (r cos q0, r sin q0, l1 sin q1 + l2 sin q2)

All places are in the device's frame: its origin the centre of the workspace, z up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from core.vectors import Vector

from .numbers import EmulatedSpec

Rows = tuple[Vector, Vector, Vector]


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


def blocks(spec: EmulatedSpec) -> tuple[Block, ...]:
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


def adc_angles(spec: EmulatedSpec, words: tuple[int, ...]) -> Vector:
    """Return the angles [rad] of a block's three joints for its readings of 16 bits."""
    scale = spec.adc_span / 65536
    half = 32768 - (1 << (15 - spec.adc_bits) if spec.adc_bits < 16 else 0)  # the middle of a converter's step
    a, b, c = spec.adc_centres
    return a + (words[0] - half) * scale, b + (words[1] - half) * scale, c + (words[2] - half) * scale
