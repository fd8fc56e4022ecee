"""The numbers that a device reports: those that are not safe are refused, and the reason is named."""

import pytest

from core.device import wire
from core.device.spec import Spec, spec_of
from core.errors import DimpleError
from studies.bench.numbers import info

INFO = info(Spec(), 1, 2)


def test_a_device_is_what_it_reports() -> None:
    assert wire.Decoder().feed(wire.encode(INFO)) == [INFO]
    assert spec_of(INFO) == Spec()
    other = Spec(fingers=1, tick_hz=500, viscous=1.5)
    assert spec_of(other.info(1, 2)) == other


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"fingers": 0}, "fingertips"),
        ({"fingers": 4}, "fingertips"),
        ({"peak_cn": 2001}, "forces"),
        ({"continuous_cn": 1001}, "forces"),
        ({"continuous_cn": 0}, "forces"),
        ({"hold_ms": 6}, "timeouts"),
        ({"zero_ms": 26}, "timeouts"),
        ({"latch_ms": 101}, "timeouts"),
        ({"zero_ms": 5}, "timeouts"),
        ({"speed_dms": 16}, "speed"),
        ({"speed_dms": 0}, "speed"),
        ({"viscous_cns_m": 2001}, "friction"),
        ({"tick_hz": 249}, "rate"),
        ({"tick_hz": 2001}, "rate"),
        ({"hold_ms": 1}, "rate"),
        ({"major": 1}, "protocol 1.0, this Dimple 2.0"),
    ],
)
def test_no_device_weakens_a_limit(changes: dict[str, int], reason: str) -> None:
    with pytest.raises(DimpleError, match=reason):
        spec_of(INFO._replace(**changes))
