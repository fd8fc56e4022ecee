"""What many machines would bring, computed: no gain without enough vertices, and never more than their number."""

import pytest

from studies.machines import PROCESSORS, pays_from, split_step

EACH, MEETING, WIRE = 1e-8, 1e-4, 1e9


@pytest.mark.parametrize("machines", [2, 4, 16])
def test_a_body_on_many_machines_gains_less_than_their_number_and_little_below_the_meeting(machines: int) -> None:
    one, many = (
        [split_step(n, k, each=EACH, meeting=MEETING, wire=WIRE) for n in (1e3, 1e5, 1e7)] for k in (1, machines)
    )
    ratios = [a / b for a, b in zip(one, many, strict=True)]
    assert ratios[0] < 1 < ratios[1] < ratios[2] < machines


def test_two_machines_pay_from_where_half_the_work_outweighs_a_meeting() -> None:
    at = pays_from(EACH / 2, MEETING)
    less, more = (split_step(n, 2, each=EACH, meeting=MEETING, wire=1e15) / (n * EACH) for n in (0.9 * at, 1.1 * at))
    assert more < 1 < less


def test_a_processor_takes_at_least_a_meeting_and_its_memory_limits_it() -> None:
    for processor in PROCESSORS:
        assert processor.step(0) == processor.meeting
        assert processor.step(1e6) > 1e6 * 300 / processor.rate
