"""A device in the hands of a host gone mad: whatever it sends, the limits hold."""

from __future__ import annotations

import math
import random

import pytest

from core.device import wire
from core.vectors import ZERO
from studies.bench.faulty_emulator import FaultyEmulator
from tests.haptics.host import SPEC
from tests.haptics.test_firmware import CONVERTERS
from tests.haptics.test_motors import rise


def mad_frame(dice: random.Random, session: int, state: wire.DeviceState | None, seq: int) -> bytes:
    """Return a frame that is mostly right, or nonsense, or noise."""
    seq, echo = seq & 0xFFFF, state.seq if state else 0
    steady = random.Random(seq // 40)  # long enough for the force to grow
    force = tuple(steady.choice((0, steady.randint(-32768, 32767))) for _ in range(9))
    kind = dice.random()
    if kind < 0.985:
        flags = 3 if dice.random() < 0.99 else dice.randrange(256)
        frame: wire.Frame = wire.Command(session, seq, echo, force, flags, 5)  # type: ignore[arg-type]
        if dice.random() < 0.01:
            frame = frame._replace(seq=dice.randrange(65536), echo=dice.randrange(65536), ttl_ms=dice.randrange(256))
    elif kind < 0.99:
        frame = wire.Arm(dice.choice((session, dice.randrange(256))))
    else:
        frame = dice.choice(
            [
                wire.Disarm(session, dice.randrange(256)),
                wire.Hello(dice.randrange(65536), dice.randrange(4), dice.randrange(4)),
                wire.Fault(session, 1, 2, 3),
                state or wire.Arm(0),
            ]
        )
    code = wire.encode(frame)
    return dice.randbytes(dice.randrange(60)) if dice.random() < 0.02 else code


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 8))])
def test_whatever_a_host_sends_the_limits_hold(seed: int) -> None:
    """6 s each. Peak, slew upwards, and no force but in the modes that have some."""
    dice = random.Random(seed)
    device = FaultyEmulator(SPEC, seed=seed, baud=0, trace=[])
    decoder, out, session, state, modes = wire.Decoder(), wire.encode(wire.Hello(1, 2, 2)), 0, None, set()
    for i in range(6000):
        for frame in decoder.feed(device.step(i * SPEC.tick + 5e-4, out)):
            session = frame.session if isinstance(frame, wire.Info) else session
            state = frame if isinstance(frame, wire.DeviceState) else state
        calm = (i // 700) % 2 == 0  # long enough to be armed: no force, all held
        if calm and state:
            out = wire.encode(wire.Command(session, i & 0xFFFF, state.seq, wire.NO_FORCE, 7, 5))
            out += wire.encode(wire.Arm(session)) if i % 700 == 10 else b""
        else:
            out = mad_frame(dice, session, state, i)
        modes.add(device.mode)
    assert {wire.ARMED, wire.FAULT} & modes and wire.RAMP in modes
    assert device.trace is not None
    assert max(math.hypot(*row[11:14]) for row in device.trace) > 3.0  # it did push
    for finger in range(3):
        forces = [row[11 + 3 * finger : 14 + 3 * finger] for row in device.trace]
        assert all(math.isfinite(part) for force in forces for part in force)
        assert max(math.hypot(*force) for force in forces) <= SPEC.peak_force + CONVERTERS
        for before, after in zip(forces, forces[1:], strict=False):
            assert rise(before, after) <= 1.0 + 2 * CONVERTERS
        for row, force in zip(device.trace, forces, strict=True):
            assert force == ZERO or int(row[1]) in (wire.RAMP, wire.ARMED, wire.FAULT)
