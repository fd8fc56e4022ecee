"""Who may move a hand over a network: the ends of a sealed line, on a clock of their own."""

import pytest

from core.device.seal import NOBODY, Seal
from studies.bench import network
from studies.bench.network import OWNED, DeviceSeal

SECRET = "a secret of this test alone"


@pytest.fixture
def now(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The device's clock [s], to be set."""
    at = [100.0]
    monkeypatch.setattr(network.time, "monotonic", lambda: at[0])
    return at


def greeted(device: DeviceSeal) -> Seal:
    """Return a host that the device has heard and answered."""
    host = Seal(SECRET)
    assert device.open(host.close(b"hello")) == b"hello"
    assert host.open(device.close(b"info")) == b"info"
    return host


def test_both_ends_hear_each_other_and_each_datagram_once(now: list[float]) -> None:
    device = DeviceSeal(SECRET)
    host = greeted(device)
    data = host.close(b"one")
    assert (device.open(data), device.open(data)) == (b"one", b"")
    first, second = host.close(b"two"), host.close(b"three")
    assert (device.open(second), device.open(first)) == (b"three", b""), "what comes late is old"


def test_a_device_has_one_host_until_that_is_silent(now: list[float]) -> None:
    device = DeviceSeal(SECRET)
    host = greeted(device)
    other = Seal(SECRET)
    assert device.open(other.close(b"hello")) == b""
    now[0] += 0.9 * OWNED
    assert host.open(device.close(b"state")) == b"" == device.open(host.close(b"mine")), "to nobody: both were silent"
    host.heard = now[0]
    assert device.open(other.close(b"hello")) == b"" and device.open(host.close(b"mine")) == b"mine"
    now[0] += OWNED + 0.01
    assert device.open(other.close(b"hello")) == b"hello", "its host is gone"


def test_what_was_sent_before_a_device_started_again_does_not_act(now: list[float]) -> None:
    before = DeviceSeal(SECRET)
    host = greeted(before)
    commands = [host.close(b"push") for _ in range(10)]
    after = DeviceSeal(SECRET)
    assert [after.open(each) for each in commands] == [b""] * 10


def test_a_host_follows_a_device_that_started_again_and_never_back(now: list[float]) -> None:
    before, after, host = DeviceSeal(SECRET), DeviceSeal(SECRET), Seal(SECRET)
    before.open(host.close(b"hello"))
    old = [before.close(b"state") for _ in range(3)]
    assert host.open(old[0]) == b"state"
    now[0] += OWNED
    assert after.open(host.close(b"hello")) == b"hello", "to nobody, for it heard nothing"
    assert host.open(after.close(b"info")) == b"info" and host.other == after.own
    assert host.open(old[1]) == b"" and host.other == after.own, "an end that was left is not followed again"


@pytest.mark.parametrize("at", range(0, 40, 3))
def test_a_datagram_with_any_byte_changed_is_dropped(at: int) -> None:
    device, host = DeviceSeal(SECRET), Seal(SECRET)
    data = bytearray(host.close(b"hello"))
    data[at] ^= 1
    assert device.open(bytes(data)) == b""
    assert host.other == NOBODY and device.open(b"") == device.open(bytes(39)) == b""
