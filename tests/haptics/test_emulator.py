"""The emulated device is a physical thing: masses, friction, springs, converters, and bytes that take time."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path

import pytest

from core.device import wire
from core.errors import DimpleError
from core.vectors import ZERO, Vector
from studies.bench.faults import InjectedFault
from studies.bench.faulty_emulator import FaultyEmulator, FaultyLine, TraceRow
from studies.bench.hand import EmulatedHand, Keyframe, load_hand
from studies.bench.line import EmulatedLine
from studies.bench.tip import EmulatedTip
from tests.haptics.host import SPEC, Host

FREE = EmulatedHand(stiffness=0.0, damping=0.0)


def move(
    tip: EmulatedTip, seconds: float, force: Vector = ZERO, hand: EmulatedHand = FREE, begin: float = 0.0
) -> EmulatedTip:
    for i in range(round(seconds / SPEC.tick)):
        tip.step(SPEC, hand, 0, begin + i * SPEC.tick, force)
    return tip


def test_a_pushed_tip_goes_as_fast_as_friction_lets_it() -> None:
    """v = (F - Fc) / b = 0.4 m/s at 1 N; 60 ms is one time constant, v (1 - 1/e)."""
    tip = move(EmulatedTip((-0.2, 0.0, 0.0)), 0.06, (1.0, 0.0, 0.0))
    assert tip.velocity[0] == pytest.approx(0.4 * (1 - math.exp(-1)), rel=0.01)
    tip = move(EmulatedTip((-0.2, 0.0, 0.0)), 0.6, (1.0, 0.0, 0.0))
    assert tip.velocity[0] == pytest.approx(0.4, rel=1e-3)


def test_dry_friction_holds_what_is_weaker_than_it() -> None:
    assert move(EmulatedTip(ZERO), 1.0, (0.11, 0.11, 0.11)).position == ZERO  # 0.19 N
    assert move(EmulatedTip(ZERO), 1.0, (0.12, 0.12, 0.12)).position != ZERO  # 0.21 N


def test_a_hand_yields_like_its_spring() -> None:
    """At rest the spring carries the force, but for what dry friction holds."""
    hand = EmulatedHand(stiffness=400.0, damping=4.0)
    x = move(EmulatedTip(ZERO), 2.0, (4.0, 0.0, 0.0), hand).position[0]
    assert abs(400.0 * x - 4.0) <= SPEC.coulomb


def test_a_plucked_tip_rings_at_its_frequency() -> None:
    """A spring of 1000 N/m and no hand's damping: zero crossings pi / omega apart, omega^2 = k/m - (b/2m)^2."""
    hand, tip, crossings = EmulatedHand(stiffness=1000.0, damping=0.0), EmulatedTip((0.05, 0.0, 0.0)), []
    for i in range(200):
        before = tip.position[0]
        move(tip, SPEC.tick, hand=hand)
        if before > 0 >= tip.position[0] or before < 0 <= tip.position[0]:
            crossings.append((i + before / (before - tip.position[0])) * SPEC.tick)
    omega = math.sqrt(1000.0 / SPEC.tip_mass - (SPEC.viscous / (2 * SPEC.tip_mass)) ** 2)
    assert len(crossings) >= 4
    gaps = [b - a for a, b in zip(crossings, crossings[1:], strict=False)]
    assert gaps[0] == pytest.approx(math.pi / omega, rel=0.02)


def test_a_tip_never_gains_energy_by_itself() -> None:
    """Any hand that holds still: kinetic and spring energy never exceed what they were, and end up as heat."""
    dice = random.Random(8)
    for _ in range(20):
        k = 10 ** dice.uniform(1, 3.5)
        hand = EmulatedHand(stiffness=k, damping=dice.choice((0.0, 4.0)))
        tip = EmulatedTip((dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1), 0.0), (dice.uniform(-1, 1), 0.0, 0.0))
        first = energy(tip, k)
        for _ in range(500):
            move(tip, SPEC.tick, hand=hand)
            assert energy(tip, k) <= first * 1.02  # the ripple of a semi-implicit step, omega h / 2 = 2 %
        assert energy(tip, k) < 0.2 * first or k < 100


def energy(tip: EmulatedTip, k: float) -> float:
    return 0.5 * SPEC.tip_mass * math.hypot(*tip.velocity) ** 2 + 0.5 * k * math.hypot(*tip.position) ** 2


def test_the_linkage_stops_at_its_stops() -> None:
    tip = move(EmulatedTip(ZERO), 2.0, (6.0, 5.0, 3.0))
    assert math.hypot(*tip.position) == pytest.approx(SPEC.stop_radius)
    tip = move(tip, 0.05, (-6.0, -5.0, -3.0))
    assert math.hypot(*tip.position) < SPEC.stop_radius - 0.01  # it bounces nowhere, and comes away freely


def test_a_hand_goes_its_way_straight_from_keyframe_to_keyframe() -> None:
    keys: tuple[Keyframe, ...] = ((1.0, 0.0, 0.0, 0.0), (2.0, 0.1, 0.0, -0.1), (3.0, 0.1, 0.0, -0.1))
    hand = EmulatedHand(tips=(keys,) * 3)
    assert hand.target(0, -math.inf) == hand.target(0, 0.5) == (ZERO, ZERO)
    place, velocity = hand.target(0, 1.25)
    assert place == pytest.approx((0.025, 0.0, -0.025)) and velocity == pytest.approx((0.1, 0.0, -0.1))
    assert hand.target(0, 9.0) == ((0.1, 0.0, -0.1), ZERO)
    rigid = EmulatedHand(tips=(keys,) * 3, stiffness=None)
    assert move(EmulatedTip(ZERO), 0.25, (9.0, 9.0, 9.0), rigid, begin=1.0).position == pytest.approx(
        (0.025, 0.0, -0.025)
    )


def test_a_hand_comes_from_a_file_and_a_wrong_one_is_refused(tmp_path: Path) -> None:
    path, keys = tmp_path / "hand.json", [[0, 0, 0, 0], [1, 0, 0, -0.05]]
    path.write_text(json.dumps({"tips": [keys, keys, keys], "stiffness": 300, "damping": 5, "from": "start"}))
    hand = load_hand(path)
    assert (hand.stiffness, hand.damping, hand.from_arm) == (300.0, 5.0, False)
    assert hand.tips[2] == ((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, -0.05))
    wrong: list[object] = [
        [],
        {},
        {"tips": [keys]},
        {"tips": [keys, keys, []]},
        {"tips": [keys, keys, [[0, 0, 0]]]},
        {"tips": [keys, keys, keys[::-1]]},
        {"tips": [keys, keys, [[math.nan, 0, 0, 0]]]},
        {"tips": [keys] * 3, "stiffness": -1},
        {"tips": [keys] * 3, "from": "never"},
    ]
    for file in wrong:
        path.write_text(json.dumps(file))
        with pytest.raises(DimpleError, match="is not a hand"):
            load_hand(path)
    with pytest.raises(DimpleError, match="cannot be read"):
        load_hand(tmp_path / "none.json")


def test_the_device_reports_where_its_tips_are() -> None:
    """Within what the converters resolve: 0.08 mm rms of their steps, 0.085 with the noise; 4 sigma."""
    keys: tuple[Keyframe, ...] = ((0.0, -0.1, 0.05, 0.0), (1.0, 0.1, -0.05, 0.1))
    device = FaultyEmulator(SPEC, hand=EmulatedHand(tips=(keys,) * 3, stiffness=None, from_arm=False), trace=[])
    host, out, errors = Host(arms=False), b"", []
    out = host.hello()
    for i in range(10_000):
        out = host.step(i * 1e-4, device.step(i * 1e-4, out))
    assert device.trace is not None
    for state in host.states:
        row = device.trace[round(state.t_us / 1000)]
        for i in range(3):
            p = [word * wire.PLACE_STEP for word in state.place[3 * i : 3 * i + 3]]
            errors.append(1e3 * math.dist(p, row[2 + 3 * i : 5 + 3 * i]))
    assert len(errors) > 2900
    assert math.sqrt(sum(e * e for e in errors) / len(errors)) == pytest.approx(0.085, rel=0.15)
    assert max(errors) < 0.4


def test_the_force_at_the_tip_is_the_one_the_host_asked_for() -> None:
    """In any direction and place: max(0.05 N, 2 %)."""
    dice = random.Random(12)
    for _ in range(5):
        place = (dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1))
        asked = (dice.uniform(-3, 3), dice.uniform(-3, 3), dice.uniform(-3, 3))
        device = FaultyEmulator(SPEC, hand=EmulatedHand(tips=(((0.0, *place),),) * 3, stiffness=None))
        host = Host(lambda finger, time, asked=asked: asked if time > 0.1 else ZERO)  # type: ignore[misc]
        out = host.hello()
        for i in range(3500):
            out = host.step(i * 2e-4, device.step(i * 2e-4, out))
        assert device.mode == wire.ARMED
        for force in device.forces:
            assert math.dist(force, asked) <= max(0.05, 0.02 * math.hypot(*asked))


@pytest.mark.parametrize("baud", [115_200, 921_600])
def test_bytes_take_their_time_on_the_line(baud: int) -> None:
    """Ten bits a byte, one after the other; 36 bytes of a STATE are 390 us at 921600 baud."""
    line, arrived = EmulatedLine(baud), b""
    line.send(0.0, bytes(range(36)))
    line.send(0.0, bytes(range(36, 72)))
    for i in range(1, 72):
        time = i * 10 / baud
        assert line.take(time - 2e-7) == b""
        arrived += line.take(time + 2e-7)
        assert arrived == bytes(range(i))
    assert line.next_time() == pytest.approx(720 / baud, abs=1e-12)
    assert arrived + line.take(720 / baud) == bytes(range(72)) and line.next_time() == math.inf


def test_at_115200_baud_the_line_falls_behind() -> None:
    """Why the host must refuse it: a State of 3.1 ms a millisecond."""
    device, host = FaultyEmulator(SPEC, baud=115_200), Host(arms=False)
    out = host.hello()
    for i in range(5000):
        out = host.step(i * 2e-4, device.step(i * 2e-4, out))
    assert len(host.states) == pytest.approx(320, abs=3)


def test_a_line_that_drops_half_delivers_half() -> None:
    line = FaultyLine(0, [InjectedFault("drop", 0.5)], random.Random(1))
    for _ in range(10_000):
        line.send(0.0, b"x")
    assert len(line.take(0.0)) == pytest.approx(5000, abs=150)  # three sigma


def test_a_line_flips_the_share_of_bits_it_should() -> None:
    for rate in (1e-3, 0.1, 1.0):
        line = FaultyLine(0, [InjectedFault("flip", rate)], random.Random(1))
        for _ in range(1000):
            line.send(0.0, bytes(100))
        flipped = sum(byte.bit_count() for byte in line.take(0.0))
        assert flipped == pytest.approx(800_000 * rate, rel=0.15)  # three sigma of 800


def test_what_happens_does_not_depend_on_how_often_one_looks() -> None:
    """Steps of a whole tick or of a hundredth: the same bytes."""
    streams = []
    for n in (1, 3, 100):
        device, got = FaultyEmulator(SPEC, seed=4), b""
        got = device.step(0.0, wire.encode(wire.Hello(1, 2, 2)))
        for i in range(1, 200 * n):
            got += device.step(i * 1e-3 / n, b"")
        streams.append([frame for frame in wire.Decoder().feed(got) if isinstance(frame, wire.DeviceState)][:150])
    assert len(streams[0]) == 150 and streams[0] == streams[1] == streams[2]


def test_the_same_seed_is_the_same_device() -> None:
    def bytes_of(seed: int) -> bytes:
        device = FaultyEmulator(SPEC, seed=seed, faults=[InjectedFault("flip", 1e-3), InjectedFault("drop", 0.1)])
        got = device.step(0.0, wire.encode(wire.Hello(1, 2, 2)))
        return got + b"".join(device.step(i * 1e-3, b"") for i in range(100))

    assert bytes_of(1) == bytes_of(1) != bytes_of(2)


def test_a_state_leaves_before_the_motors_are_computed_and_its_answer_acts_from_the_next_tick_on() -> None:
    """On a line without wire time, answered at once: 0.5 N are asked from 0.7 s on, and act a tick later."""
    trace: list[TraceRow] = []
    device = FaultyEmulator(SPEC, baud=0, trace=trace)
    host = Host(lambda finger, time: (0.0, 0.0, 0.5 if time >= 0.7 - 1e-9 else 0.0))
    rest = device.step(0.0, host.hello())
    for i in range(1, 710):
        now, before = i * SPEC.tick, len(trace)
        outgoing = rest + device.step(now, b"")
        assert len(trace) == before  # it did not compute what the host does not wait for
        rest = device.step(now, host.step(now, outgoing))
        assert len(trace) == before + 1
    assert device.mode == wire.ARMED
    acts = [row[0] for row in trace if row[13] > 0.25]
    assert acts[0] == pytest.approx(0.701)
