"""What holds of a rendered wall on one clock, whatever the machine. `python -m tests.haptics.walls` prints them."""

import pytest

from tests.haptics import walls


def test_the_stiffness_limit_is_that_of_the_formula_within_10_percent() -> None:
    formula = walls.limit_by_formula()
    assert walls.grows(1.10 * formula) and not walls.grows(0.90 * formula)


@pytest.mark.slow
def test_the_stiffness_limit_is_found_between_the_two() -> None:
    assert walls.limit() == pytest.approx(walls.limit_by_formula(), rel=0.10)


@pytest.mark.parametrize("k", [200.0, pytest.param(600.0, marks=pytest.mark.slow), None])
def test_the_rendered_stiffness_is_that_of_the_contact_within_3_percent(k: float | None) -> None:
    """Up to the largest there is (None), through converters of 12 bits, their noise and dry friction."""
    share, force = walls.static_error(k)
    assert share < 0.03
    assert force < 0.06  # [N] a fingertip rests anywhere in a step of the converters: 0.08 mm at 1067 N/m


def test_poking_the_stiffest_wall_gives_no_hand_a_millijoule() -> None:
    run = walls.poke(6.0)
    assert run.cap == pytest.approx(0.8 * walls.limit_by_formula(), rel=0.01)
    assert run.strongest > 2.0
    assert run.energy > -5e-4


@pytest.mark.slow
def test_answers_late_now_and_then_leave_the_stiffness_and_give_no_hand_a_millijoule_either() -> None:
    """One of 500 ticks finds the servo stuck for 2 to 3 ms, twice what was measured."""
    run = walls.poke(6.0, stuck=1 / 500)
    assert run.cap == pytest.approx(0.8 * walls.limit_by_formula(), rel=0.02)
    assert run.strongest > 2.0
    assert run.energy > -5e-4


def test_the_more_answers_are_late_the_lower_is_the_stiffness_and_no_hand_gets_a_millijoule() -> None:
    """Up to 3 ms: 0.8 b / (T / 2 + T (1 + 2 p)) for a share p of the ticks, whatever STATEs were passed over."""
    caps = []
    for stuck in (0.0, 1 / 50, 1 / 10, 1 / 2):
        run = walls.poke(3.0, stuck)
        caps.append(run.cap)
        assert run.strongest > 1.0
        assert run.energy > -5e-4
    best, third = 0.8 * walls.limit_by_formula(), 0.8 * 2.0 / 3.5e-3
    assert best == pytest.approx(caps[0], rel=0.01) and caps == sorted(caps, reverse=True) and caps[-1] > third
