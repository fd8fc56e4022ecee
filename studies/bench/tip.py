"""The mechanics of an emulated device: each fingertip is a mass with friction, held by a hand and pushed by motors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from core.vectors import ZERO, Vector, dot, length, scaled

from .hand import EmulatedHand
from .numbers import EmulatedSpec

SUBSTEPS = 4  # per tick: with the stiffest hand and wall (2 kN/m on 0.12 kg) a step is a thirtieth of a radian


@dataclass(slots=True)
class EmulatedTip:
    """A fingertip: position [m] and velocity [m/s]."""

    position: Vector
    velocity: Vector = ZERO

    def step(self, spec: EmulatedSpec, hand: EmulatedHand, finger: int, time: float, force: Vector) -> None:
        """Move for one tick.

        Semi-implicit: friction and damping act on the new velocity, so they can only brake.

        Args:
            spec: the device.
            hand: what holds the fingertip.
            finger: which of the hand's.
            time: of the hand's script [s].
            force: of the motors at the tip [N].
        """
        if hand.stiffness is None:
            self.position, self.velocity = hand.target(finger, time + spec.tick)
            return
        h, k = spec.tick / SUBSTEPS, hand.stiffness
        push, grip = h / spec.tip_mass, hand.damping
        slow = 1 / (1 + push * (spec.viscous + grip))
        stick = push * spec.coulomb * slow  # what dry friction takes of the speed
        x, y, z = self.position
        vx, vy, vz = self.velocity
        fx, fy, fz = force
        for i in range(1, SUBSTEPS + 1):
            (tx, ty, tz), (wx, wy, wz) = hand.target(finger, time + i * h)
            vx = (vx + push * (fx + k * (tx - x) + grip * wx)) * slow
            vy = (vy + push * (fy + k * (ty - y) + grip * wy)) * slow
            vz = (vz + push * (fz + k * (tz - z) + grip * wz)) * slow
            speed = math.sqrt(vx * vx + vy * vy + vz * vz)
            left = 1 - stick / speed if speed > stick else 0.0
            vx, vy, vz = vx * left, vy * left, vz * left
            x, y, z = x + h * vx, y + h * vy, z + h * vz
        self.position, self.velocity = (x, y, z), (vx, vy, vz)
        self._stop(spec.stop_radius)

    def _stop(self, radius: float) -> None:
        """Keep the tip within the mechanical stops of the linkage."""
        away = length(self.position)
        if away > radius:
            out = scaled(self.position, 1 / away)
            self.position = scaled(out, radius)
            outward = max(dot(self.velocity, out), 0.0)
            vx, vy, vz = self.velocity
            self.velocity = (vx - outward * out[0], vy - outward * out[1], vz - outward * out[2])
