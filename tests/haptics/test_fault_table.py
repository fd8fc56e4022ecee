"""The table of faults of the design, row by row: the real servo and the emulated device on one clock, during a press.

Each end alone is tested in test_faults.py and test_firmware.py (device) and in test_servo.py (host).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.device import wire
from core.device.limits import LEASE, QUIET_TIME
from core.device.orders import LinkState
from core.device.rendered_surface import Law, Surface, stiffness_cap
from core.device.servo import Servo
from core.device.spec import Spec
from core.vectors import length
from studies.bench.faults import parse_fault
from studies.bench.faulty_emulator import FaultyEmulator, TraceRow
from studies.bench.hand import EmulatedHand, Keyframe
from tests.haptics.bench_device import wall
from tests.haptics.host import SPEC
from tests.haptics.test_firmware import BRAKE_NOISE, CONVERTERS

STEP = 2.5e-4  # [s] of the clock
FRAME = 0.016  # [s] of the simulation
WAY = ((0.0, 0.0, 0.0, 0.01), (0.7, 0.0, 0.0, 0.01), (0.8, 0.0, 0.0, -0.01))  # from the device's ramp
TWICE = (*WAY, (2.4, 0.0, 0.0, -0.01), (2.6, 0.0, 0.0, 0.01), (2.8, 0.0, 0.0, 0.01), (3.0, 0.0, 0.0, -0.01))
AT = 1.8  # [s] when things go wrong: the fingertips rest in the wall since 1.4 s
NEAR = 0.002  # [m] a place farther from the truth is a wrong one: converters err by 0.3 mm


class Press:
    """Let a hand press three fingertips into a wall of 300 N/m; 1.7 N act on each, at 5.7 mm.

    surface: what the simulation posts at a time, None where it posts nothing.  places: the largest error of a place
    that the servo trusted [m].
    """

    def __init__(
        self,
        *faults: str,
        surface: Callable[[float], Surface | None] = lambda now: wall(now, k=300.0),
        spec: Spec = SPEC,
        way: tuple[Keyframe, ...] = WAY,
        baud: int | None = None,
    ) -> None:
        self.trace: list[TraceRow] = []
        hand, spoiled = EmulatedHand(tips=(way,) * 3), [parse_fault(text) for text in faults]
        self.device = FaultyEmulator(spec, hand=hand, faults=spoiled, seed=3, trace=self.trace, baud=baud)
        self.servo, self.surface = Servo(), surface
        self.now = self.next_frame = self.places = 0.0
        self.host_runs, self.line_runs, self.to_device, self.to_host = True, True, b"", b""

    def run(self, until: float) -> Press:
        """Let time pass until a time [s]."""
        while self.now < until:
            self.now += STEP
            self.to_host += self.device.step(self.now, self.to_device)
            heard, self.to_host = (self.to_host, b"") if self.line_runs else (b"", self.to_host)
            self.to_device = self.servo.step(self.now, heard) if self.host_runs else b""
            if self.servo.link is LinkState.READY and self.now >= self.next_frame:
                self.next_frame = self.now + FRAME
                surface = self.surface(self.now)
                surfaces = (surface,) * 3 if surface else self.servo.order.surfaces
                order, held = self.servo.order, self.now + LEASE
                self.servo.order = replace(order, arm=max(order.arm, 1), held_until=held, surfaces=surfaces)
            for tip, finger in zip(self.device.tips, self.servo._fingers, strict=True):
                if finger.known and not self.device.unplugged:
                    self.places = max(self.places, math.dist(tip.position, finger.at))
        return self

    def forces(self, begin: float, end: float = math.inf) -> list[float]:
        """Return the strongest true force of the three tips [N], of the ticks of a time."""
        rows = [row for row in self.trace if begin <= row[0] < end]
        return [max(math.hypot(*row[i : i + 3]) for i in (11, 14, 17)) for row in rows]

    def energy(self) -> float:
        """Return the lowest energy [J] that a hand had given a motor."""
        rows = np.array(self.trace)
        x, force = rows[:, 2:11].reshape(-1, 3, 3), rows[:, 11:].reshape(-1, 3, 3)
        return float(-np.cumsum((force[:-1] * np.diff(x, axis=0)).sum(axis=2), axis=0).max())

    @property
    def arming(self) -> str:
        return self.servo.report().arming.name

    @property
    def note(self) -> str:
        return self.servo.report().note

    def let_go(self) -> bool:
        """Tell whether host and device are disarmed, and no force acts but a brake at rest."""
        acts = max(self.forces(self.now - 0.05, self.now)) > BRAKE_NOISE
        return self.arming == "OFF" and self.device.mode not in (wire.RAMP, wire.ARMED) and not acts

    def presses(self, within: float = 0.2) -> bool:
        """Tell whether all is as it was: armed, and the wall rendered, as stiff as the delay lets it be."""
        force = self.forces(self.now - 0.02)[-1]
        return self.arming == "ON" and force == pytest.approx(leant(self.servo.cap), abs=within)


def leant(cap: float, stiffness: float = 300.0) -> float:
    """Return the force [N] of a wall, or of a cap [N/m]; the hand wants 10 mm, on a spring of 400 N/m."""
    k = min(stiffness, cap)
    return 0.01 * k * 400 / (k + 400)


def test_without_a_fault_it_presses() -> None:
    press = Press().run(AT)
    assert press.presses() and press.places < NEAR / 2


@pytest.mark.parametrize("hz", [250, pytest.param(500, marks=pytest.mark.slow), 2000])
def test_slower_and_faster_devices_press_too(hz: int) -> None:
    """No wall is stiffer than the tick lets it be: at 250 Hz 267 N/m, so a little less than the 1.7 N."""
    spec = replace(SPEC, tick_hz=hz)
    press = Press(spec=spec).run(AT)
    force = leant(stiffness_cap(spec.viscous, spec.tick, spec.tick))  # answers come within the tick
    assert press.arming == "ON" and press.forces(AT - 0.02)[-1] == pytest.approx(force, abs=0.1)


@pytest.mark.parametrize(
    "rate", [*(pytest.param(rate, marks=pytest.mark.slow) for rate in ("1e-6", "1e-5")), "1e-4", "1e-3"]
)
def test_flipped_bits(rate: str) -> None:
    """No place and no torque of a wrong frame; 25 % lost at 1e-3 is reported, and not enough to disarm.

    What the device lets go of in a gap of the line comes back slowly: up to a fifth of the force is then missing.
    """
    press = Press(f"flip={rate}@{AT}").run(AT + 1.5)
    assert press.presses(within=0.4 if rate == "1e-3" else 0.2)
    assert press.places < NEAR  # what is lost is not known for some ticks
    assert max(press.forces(AT)) < 1.9 + CONVERTERS
    assert ("lost on the line" in press.note) == (rate == "1e-3")


def test_more_flipped_bits_than_a_line_can_bear() -> None:
    press = Press(f"flip=2e-3@{AT}").run(AT + 1.5)
    assert press.let_go() and "Check the cable" in press.note


@pytest.mark.parametrize("fault", ["garbage=0.05", "truncate=0.05", "drop=0.05"])
def test_garbage(fault: str) -> None:
    """At most two frames are lost by each of the 50 times of a second, give or take three deviations."""
    press = Press(f"{fault}@{AT}").run(AT + 1.0)
    assert press.presses() and 0 < press.servo.report().lost <= 2 * (50 + 3 * math.sqrt(50))
    assert max(press.forces(AT)) < 1.9 + CONVERTERS


def test_wrong_baud_rate() -> None:
    press = Press("wrong-baud").run(1.1)
    assert press.servo.link is LinkState.REFUSED and "baud" in press.note
    assert max(press.forces(0.0)) == 0.0


@pytest.mark.parametrize("fault", ["duplicate=0.3", "reorder=0.1", "stale=1"])
def test_duplicated_reordered_and_stale_frames(fault: str) -> None:
    length_of = "+0.02" if fault == "stale=1" else ""  # longer than 100 ms is an unplugged line
    press = Press(f"{fault}@{AT}{length_of}").run(AT + 1.0)
    watch = press.device.firmware.link
    assert press.presses() and watch and watch.stale > 0  # answers that came twice, late, or to States long gone
    assert press.servo.report().stale > 0 or fault == "stale=1"  # which come in order, if late
    assert max(press.forces(AT)) < 1.9 + CONVERTERS


def test_unplugged() -> None:
    """No force is asked for after 5 ms; lost within 100 ms."""
    press = Press(f"unplug@{AT}").run(AT + 0.007)
    assert press.servo.link is LinkState.READY and not any(length(tip.force) for tip in press.servo.report().tips)
    press.run(AT + 0.102)
    assert press.servo.link is LinkState.LOST and press.arming == "OFF" and "lost" in press.note


@pytest.mark.parametrize("stall", [0.15, 1.0])
def test_the_host_is_killed_or_stalls(stall: float) -> None:
    """Zero by 25 ms, brake, latched after 100 ms; what comes later needs a CLEAR and a new ARM."""
    press = Press().run(AT)
    press.host_runs = False
    press.run(AT + stall)
    still = press.forces(AT + 0.026, AT + 0.1)
    speed = 0.25  # [m/s] at most: the hand goes on by 4 mm, on a spring of 400 N/m with 0.12 kg
    assert max(still) < SPEC.brake * speed and max(press.forces(AT + 0.13)) < BRAKE_NOISE
    assert press.device.mode == wire.FAULT
    press.host_runs = True
    press.run(AT + stall + 0.5)
    assert press.let_go() and press.note
    press.device.hand = EmulatedHand(tips=(WAY[:1],) * 3)  # the hand lifts off
    press.run(press.now + 0.3)
    press.servo.order = replace(press.servo.order, arm=2)
    assert press.run(press.now + 1.3).arming == "ON"


SLOW = pytest.mark.slow
STALLS = [(0.006, "line"), (0.03, "line"), (0.006, "host"), (0.03, "host")]
MORE_STALLS = [*((stall, what) for what in ("line", "host") for stall in (0.012, 0.02, 0.06))]


@pytest.mark.parametrize(("stall", "what"), [*STALLS, *(pytest.param(*each, marks=SLOW) for each in MORE_STALLS)])
def test_a_force_that_comes_back_after_a_stall_gives_the_hand_no_more_than_it_took(what: str, stall: float) -> None:
    """The force of a stiff wall fades and the fingertip sinks in; pushed out whole it gets up to 6 mJ too much.

    The force yields until the fingertip has left the wall; the next press meets the whole of it.
    """
    press = Press(surface=lambda now: wall(now, k=1000.0), way=TWICE, baud=0).run(AT)
    press.host_runs, press.line_runs = what != "host", what != "line"
    press.run(AT + stall)
    press.host_runs = press.line_runs = True
    press.run(AT + 0.7)
    assert press.arming == "ON" and press.energy() > -5e-4
    if stall < QUIET_TIME:  # without force for so long, a wall has nothing left to give
        assert press.forces(press.now - 0.02)[-1] > 0.2
    press.run(3.6)
    assert press.energy() > -5e-4
    assert press.forces(press.now - 0.02)[-1] == pytest.approx(leant(press.servo.cap, 1000.0), abs=0.2)


@pytest.mark.parametrize("stall", [0.15, 0.2])
def test_a_wall_that_comes_back_after_the_simulation_stood_still_hardly_gives_the_hand_more_than_it_took(
    stall: float,
) -> None:
    """The wall fades, and the fingertip sinks in by 7 mm more: pushed out with the whole wall it would get 36 mJ.

    It may get the 0.5 mJ that are allowed; the next press meets the whole wall.
    """
    press = Press(
        surface=lambda now: None if AT < now < AT + stall else wall(now, k=1000.0), way=TWICE, baud=0
    ).run(3.6)
    assert press.arming == "ON" and press.energy() > -1e-3
    assert press.forces(press.now - 0.02)[-1] == pytest.approx(leant(press.servo.cap, 1000.0), abs=0.2)


def test_what_friction_took_pushes_out_no_fingertip_that_sank_in() -> None:
    """The hand rubs a rough wall for a second: 70 mJ, all of them heat. The wall holds half of 10 mm of it: 4 mJ."""
    rub = [(0.8 + t / 10, 0.02 * math.sin(2 * math.pi * t / 10), 0.0, -0.01) for t in range(10)]
    stall = AT + 0.5
    way = (*WAY[:2], *rub, (AT, 0.0, 0.0, -0.01), (stall + 0.5, 0.0, 0.0, -0.01), (stall + 1.5, 0.0, 0.0, 0.01))

    def rough(now: float) -> Surface | None:
        anchor = press.servo._fingers[0].contact.anchor
        return None if stall < now < stall + 0.2 else replace(wall(now, k=1000.0), friction=0.5, anchor=anchor)

    press = Press(surface=rough, way=way, baud=0)
    press.run(stall)
    rows, stored = len(press.trace), press.servo._fingers[0].guard.passivity.stored
    press.run(stall + 2.0)
    del press.trace[:rows]
    assert stored > 0.05 and press.arming == "ON"
    assert press.energy() > -0.0041 - 1e-3


@pytest.mark.parametrize("fault", ["adc-range", "adc-frozen", "adc-jump"])
def test_a_sensor_that_lies(fault: str) -> None:
    """Masked at once (a frozen one after 50 readings alike), disarmed after 5 more."""
    press = Press(f"{fault}=1@{AT}").run(AT + 0.2)
    assert press.let_go() and "sensor" in press.note
    known = 50 if fault == "adc-frozen" else 0
    finger = [math.hypot(*row[14:17]) for row in press.trace if row[0] >= AT]
    assert max(finger[known + 1 :]) == 0.0


@pytest.mark.parametrize(
    "bad", [{"place": (0.0, math.nan, 0.0)}, {"law": Law(math.inf, 1.0, 1.0, 1.0)}, {"place": (0.0, 0.0, 1e9)}]
)
def test_models_that_are_no_numbers(bad: dict[str, object]) -> None:
    press = Press(surface=lambda now: replace(wall(now, k=300.0), **(bad if now >= AT else {}))).run(AT + 0.3)
    assert press.let_go() and "not numbers" in press.note
    assert max(press.forces(AT)) < 1.9 + CONVERTERS


def test_a_huge_model() -> None:
    """Its 500 N are cut to 10 N, 1 N a millisecond; what the device cannot bear for long it folds back."""
    press = Press(surface=lambda now: wall(now, k=300.0, force=500.0 if now >= AT else 0.0)).run(AT + 0.3)
    forces = press.forces(AT - 0.01)
    assert 5.0 < max(forces) <= SPEC.peak_force + CONVERTERS
    assert max(b - a for a, b in zip(forces, forces[1:], strict=False)) <= 1.0 + 2 * CONVERTERS


def test_a_frozen_simulation() -> None:
    press = Press(surface=lambda now: wall(now, k=300.0) if now < AT else None).run(AT + 0.09)
    assert press.presses()
    assert 0.3 < press.run(AT + 0.15).forces(AT + 0.14)[-1] < 1.5
    assert max(press.run(AT + 0.26).forces(AT + 0.25)) == 0.0 and press.arming == "ON"
    assert max(press.run(AT + 1.5).forces(AT + 0.25)) == 0.0 and press.arming == "WAITING"


def test_another_protocol() -> None:
    press = Press("version=3").run(0.3)
    assert press.servo.link is LinkState.REFUSED and "3.0" in press.note and "2.0" in press.note
