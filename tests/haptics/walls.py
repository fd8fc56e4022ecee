"""Walls rendered through emulated device and servo on one clock: stability, stiffness, energy.

`python -m tests.haptics.walls` prints its figures.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.device import wire
from core.device.limits import LEASE
from core.device.orders import LinkState
from core.device.passivity import Passivity
from core.device.servo import Servo
from core.device.wire import RAMP
from core.vectors import Vector
from studies.bench.faulty_emulator import FaultyEmulator, TraceRow
from studies.bench.hand import EmulatedHand, Keyframe
from studies.bench.numbers import EmulatedSpec, load_emulated
from tests.haptics.bench_device import wall

STEP = 2e-4  # [s] of the clock
FRAME = 0.016  # [s] of the simulation
BEGIN = 1.2  # [s] after the device's ramp


class Unwatched(Passivity):
    """Observe, and never damp or yield: the limit of the wall itself is wanted."""

    def observe(self, force: Vector, way: Vector) -> None:
        Passivity.observe(self, force, way)
        self.floor, self.share = -math.inf, 1.0

    def damp(self, force: Vector, speed: Vector, dt: float) -> Vector:
        return force


class Uncapped(Servo):
    """Render walls of any stiffness, unwatched."""

    def _take_info(self, info: wire.Info, now: float) -> None:
        super()._take_info(info, now)
        self.spec = replace(self.spec, viscous=1e3)
        for finger in self._fingers:
            finger.guard.passivity = Unwatched()


@dataclass(frozen=True)
class Run:
    """A run.

    trace: of the device, from the ramp on.
    observed: lowest observed energy [J].
    cap: largest stiffness [N/m].
    """

    trace: np.ndarray
    observed: float
    cap: float

    def tip(self, finger: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return time [s], positions [m] and forces [N]."""
        at = 2 + 3 * finger
        return self.trace[:, 0] - self.trace[0, 0], self.trace[:, at : at + 3], self.trace[:, at + 9 : at + 12]

    @property
    def strongest(self) -> float:
        """Return the largest force of a fingertip [N], of the one that pressed least."""
        return float(min(np.linalg.norm(self.tip(finger)[2], axis=1).max() for finger in range(3)))

    @property
    def energy(self) -> float:
        """Return the lowest energy [J] that the motors had taken from a hand."""
        lows = []
        for finger in range(3):
            _, x, force = self.tip(finger)
            lows.append(-np.cumsum((force[:-1] * np.diff(x, axis=0)).sum(axis=1)).max())
        return float(min(lows))


def press_wall(
    hand: EmulatedHand,
    k: Callable[[Servo], float],
    seconds: float,
    *,
    spec: EmulatedSpec | None = None,
    servo: Servo | None = None,
    stuck: float = 0.0,
) -> Run:
    """Press the wall z = 0 of a stiffness [N/m] for some seconds after arming.

    stuck: share of the ticks at which the servo's process is kept from running, for 2 to 3 ms.
    """
    spec = spec or load_emulated()
    trace: list[TraceRow] = []
    emulator, servo = FaultyEmulator(spec, hand=hand, trace=trace, baud=0), servo or Servo()
    now, frame, to_device, to_servo = 0.0, 0.0, b"", b""
    until, dice, runs = math.inf, np.random.default_rng(2), 0.0
    while now < until:
        now += STEP
        to_servo, to_device = to_servo + emulator.step(now, to_device), b""
        if now < runs:
            continue
        if dice.random() < stuck * STEP / spec.tick:
            runs = now + dice.uniform(2e-3, 3e-3)
        to_device, to_servo = servo.step(now, to_servo), b""
        if servo.link is LinkState.READY and now >= frame:
            frame = now + FRAME
            servo.order = replace(servo.order, arm=1, held_until=now + LEASE, surfaces=(wall(now, k=k(servo)),) * 3)
        if until == math.inf and emulator.mode == RAMP:
            until = now + BEGIN + seconds
    assert servo.report().arming.name == "ON", servo.report().note
    rows = np.array(trace)
    rows = rows[np.flatnonzero(rows[:, 1] == RAMP)[0] :]
    return Run(rows, min(tip.least_energy for tip in servo.report().tips), servo.cap)


def grows(k: float) -> bool:
    """Tell whether the swing of a fingertip that leans on a wall with 2 N grows rather than dies out.

    Without dry friction, converter steps and passivity controller, which all hide where the wall itself is unstable.
    """
    spec = replace(load_emulated(), coulomb=0.0, adc_bits=16, adc_noise=0.0)
    servo = Uncapped()
    lean: Sequence[Keyframe] = ((0.0, 0.0, 0.0, 0.002), (BEGIN, 0.0, 0.0, 0.002), (BEGIN + 0.5, 0.0, 0.0, -0.1))
    run = press_wall(
        EmulatedHand(tips=(tuple(lean),) * 3, stiffness=20.0, damping=0.0), lambda _: k, 2.0, spec=spec, servo=servo
    )
    time, x, _ = run.tip()
    speeds = np.abs(np.diff(x[:, 2])) / spec.tick
    early, late = (speeds[(time[1:] > BEGIN + t) & (time[1:] < BEGIN + t + 0.2)].max() for t in (1.0, 1.7))
    return bool(late > max(early, 0.004))  # slower are the steps of the converter


def limit(low: float = 900.0, high: float = 1900.0, steps: int = 6) -> float:
    """Return the stiffness [N/m] from which on the fingertip does not come to rest."""
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (low, middle) if grows(middle) else (middle, high)
    return (low + high) / 2


def limit_by_formula() -> float:
    """Return b / (T/2 + t_d) [N/m]: an answer within the tick acts at the next one."""
    spec = load_emulated()
    return spec.viscous / (spec.tick / 2 + spec.tick)


def stairs(levels: Sequence[float], hold: float = 0.5) -> tuple[Keyframe, ...]:
    """Return the way of a hand from hold to hold [m]."""
    keys: list[Keyframe] = [(BEGIN, 0.0, 0.0, 0.01)]
    for level in levels:
        at = keys[-1][0]
        keys += [(at + 0.1, 0.0, 0.0, -level), (at + 0.1 + hold, 0.0, 0.0, -level)]
    return tuple(keys)


def static_error(k: float | None, levels: Sequence[float] = (0.004, 0.007, 0.010, 0.013)) -> tuple[float, float]:
    """Return the error of the rendered stiffness as a share, and the rms error of the force while holding [N].

    Args:
        k: [N/m], None: the largest there is.
    """
    run = press_wall(
        EmulatedHand(tips=(stairs(levels),) * 3), lambda servo: servo.cap if k is None else k, 0.6 * len(levels)
    )
    k = run.cap if k is None else k
    slopes, errors = [], []
    for finger in range(3):
        time, x, force = run.tip(finger)
        depth, push = [], []
        for i in range(len(levels)):
            begin = BEGIN + 0.6 * i
            held = (time > begin + 0.25) & (time < begin + 0.6)
            depth.append(-x[held, 2].mean())
            push.append(force[held, 2].mean())
            errors.append(force[held, 2] + k * x[held, 2])
        slopes.append(np.polyfit(depth, push, 1)[0])
    return float(np.abs(np.array(slopes) / k - 1).max()), float(np.sqrt((np.concatenate(errors) ** 2).mean()))


def poke(seconds: float, stuck: float = 0.0) -> Run:
    """Poke the stiffest wall there is, up to twice a second and 12 mm deep, each finger in its own time."""
    dice = np.random.default_rng(1)
    tips = []
    for _ in range(3):
        keys: list[Keyframe] = [(BEGIN, 0.0, 0.0, 0.01)]
        while keys[-1][0] < BEGIN + seconds:
            at = keys[-1][0]
            down, up = dice.uniform(0.1, 0.4, 2)
            deep = -dice.uniform(0.002, 0.012)
            keys += [(at + down, 0.0, 0.0, deep), (at + down + 0.15, 0.0, 0.0, deep),
                     (at + down + up + 0.15, 0.0, 0.0, 0.005)]  # fmt: skip
        tips.append(tuple(keys))
    return press_wall(EmulatedHand(tips=tuple(tips)), lambda servo: servo.cap, seconds, stuck=stuck)


if __name__ == "__main__":
    found, formula = limit(), limit_by_formula()
    print(f"stiffness limit          {found:.0f} N/m, formula {formula:.0f} N/m: {found / formula - 1:+.1%}")
    for k in (200.0, 600.0, None):
        share, force = static_error(k)
        print(f"static, {k or 'K_cap':>6} N/m       stiffness error {share:.2%}, force error {force:.3f} N rms")
    for stuck in (0.0, 1 / 500, 1 / 100):
        run = poke(60.0, stuck)
        print(f"60 s of poking at {run.cap:.0f} N/m, {stuck:.1%} of the answers 2 to 3 ms late: lowest energy "
              f"{1e3 * run.energy:.3f} mJ, observed {1e3 * run.observed:.3f} mJ")  # fmt: skip
