"""Messages between two processes: whole or not at all."""

import math
import os
import subprocess
import sys
import time
from dataclasses import replace

import pytest

from core.constants import FACTORS
from core.device.force_guard import Arming
from core.device.mailbox import FROM_SERVO, TO_SERVO, Mailbox
from core.device.orders import (
    LinkState,
    Order,
    ServoReport,
    TipState,
    pack_order,
    pack_report,
    unpack_order,
    unpack_report,
)
from core.device.rendered_surface import Law
from core.message import Message
from tests.haptics.bench_device import wall
from tools.environment import ROOT

WRITER = """
import sys
sys.path.append(sys.argv[1])
from pathlib import Path
from core.device.mailbox import TO_SERVO, Mailbox
box = Mailbox(Path(sys.argv[2]))
i = 0
while True:
    i += 1
    box.post(TO_SERVO, bytes((i % 256,)) * 400)
"""


def test_an_order_and_a_report_arrive_as_they_were_sent() -> None:
    factors = tuple(1.0 + k / 7 for k in range(FACTORS))
    other = replace(wall(2.5), anchor=(1.0, -2.0, 3.0), law=Law(1.0, 2.0, 3.0, 1.5, factors, 0.1))
    order = Order(
        arm=3, disarm=2, held_until=4.5, surfaces=(None, wall(1.5), other)
    )
    assert unpack_order(pack_order(order)) == order
    report = ServoReport(
        link=LinkState.READY, arming=Arming.RAMP, states=7, lost=1, unsent=5, wrong=2, stale=3, rate=1000.0,
        tips=(TipState(position=(1.0, 2.0, 3.0), full=True), TipState(), TipState()),
        delay=1e-3, cap=640.0, peak=10.0, note="Größe",
    )  # fmt: skip
    assert unpack_report(pack_report(report)) == report


@pytest.mark.parametrize("note", ["ß" * 5000, Message("{name}", name="ß" * 5000), Message("{name}", name="short")])
def test_the_longest_order_and_any_note_fit(note: str) -> None:
    """A message that does not fit would end the servo."""
    law = Law(*(-1.2345678901234567e-05,) * 4, (-1.2345678901234567e-05,) * FACTORS, 1.2345678901234567e-05)
    place = (-1.2345678901234567e-05,) * 3
    surface = replace(wall(), place=place, normal=place, anchor=place, law=law, stamp=1234567.890123456)
    report = ServoReport(tips=(TipState(place, place, *place[:1]),) * 3, note=note)
    box = Mailbox()
    box.post(TO_SERVO, pack_order(Order(surfaces=(surface,) * 3)))
    box.post(FROM_SERVO, pack_report(report))
    message = box.read(FROM_SERVO)[1] or b""
    assert note.startswith(unpack_report(message).note) and unpack_report(message).tips == report.tips
    assert unpack_order(box.read(TO_SERVO)[1] or b"").surfaces == (surface,) * 3
    box.close()


def test_not_a_number_arrives_as_such_for_the_servo_to_refuse() -> None:
    order = unpack_order(pack_order(Order(surfaces=(replace(wall(), friction=math.nan),))))
    assert order.surfaces[0] and math.isnan(order.surfaces[0].friction)


def test_a_message_is_read_once_and_the_newest_replaces_the_one_before() -> None:
    box = Mailbox()
    assert box.read(TO_SERVO) == (0, None)
    box.post(TO_SERVO, b"one")
    box.post(TO_SERVO, b"two")
    number, message = box.read(TO_SERVO)
    assert message == b"two"
    assert box.read(TO_SERVO, number) == (number, None)
    assert box.read(FROM_SERVO) == (0, None)
    box.close()


def test_a_message_that_is_being_written_or_was_damaged_is_not_read() -> None:
    box = Mailbox()
    box.post(TO_SERVO, b"whole")
    box._map[14] ^= 1
    assert box.read(TO_SERVO) == (0, None)
    box.close()


def test_no_reader_ever_gets_a_mixture_of_two_messages() -> None:
    box = Mailbox()
    writer = subprocess.Popen([sys.executable, "-I", "-S", "-c", WRITER, str(ROOT), str(box.path)])
    seen, read, until = 0, 0, time.perf_counter() + 10
    try:
        while read < 200 and time.perf_counter() < until:
            seen, message = box.read(TO_SERVO, seen)
            if message:
                read += 1
                assert len(set(message)) == 1
    finally:
        writer.kill()
        writer.wait()
        box.close()
    assert read == 200


def test_the_file_goes_as_soon_as_both_have_it_or_with_the_one_who_made_it() -> None:
    """So that nothing is left behind, whichever is killed."""
    box = Mailbox()
    assert box.path.exists()
    other = Mailbox(box.path)
    assert box.path.exists() == (os.name != "posix")
    box.post(TO_SERVO, b"mapped")
    assert other.read(TO_SERVO)[1] == b"mapped"
    for each in (other, box, Mailbox()):
        each.close()
        assert not each.path.exists()


def test_a_message_that_does_not_fit_is_refused() -> None:
    box = Mailbox()
    with pytest.raises(ValueError):
        box.post(TO_SERVO, bytes(9000))
    box.close()


def test_all_samples_of_a_servo_arrive_once_and_in_order() -> None:
    box, seen, found = Mailbox(), 0, list[float]()
    for number in range(1, 1001):
        box.post_sample((number, number / 1000, *(0.0,) * 18))
        if number % 16 == 0:
            seen, samples = box.samples(seen)
            found += [sample[0] for sample in samples]
    assert found == [number / 1000 for number in range(1, 992)], "the newest may be half written: it comes next time"
    for number in range(1001, 7001):
        box.post_sample((number, number / 1000, *(0.0,) * 18))
    seen, samples = box.samples(seen)
    assert seen == 6999 and [sample[0] for sample in samples] == [number / 1000 for number in range(2905, 7000)]
    box.close()
