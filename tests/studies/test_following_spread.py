"""What another tip meets: with a spread that follows the contact, and where the solid's own curve is identified."""

import pytest

from studies import other_tip_identified
from studies.following_spread import following, rows
from studies.membrane import ball_force


def test_with_a_spread_that_follows_the_contact_the_force_grows_as_that_of_a_half_space() -> None:
    """F ~ R^(1/2) x^(3/2), Hertz; with a constant spread a ball twice as large meets hardly more."""
    force, larger, deeper = (following(*press, 1.0)[0] for press in ((1e-4, 0.01), (1e-4, 0.02), (4e-4, 0.01)))
    assert larger / force == pytest.approx(2**0.5, rel=0.01)
    assert deeper / force == pytest.approx(8, rel=0.02)
    assert ball_force(1e-4, 0.02, 0.02)[0] / ball_force(1e-4, 0.01, 0.02)[0] < 1.15


def test_a_linear_solid_fitted_through_one_tip_is_then_met_by_another_from_1_to_20_mm() -> None:
    """Within 3 percent, ball and block; with a constant spread more than 20 percent off."""
    found = [row for row in rows() if row["solid"] == "linear" and row["fitted_mm"] != row["tip_mm"]]
    missed = {
        (row["body"], row["fitted_mm"], row["spread"]): max(
            abs(float(str(row[f"force_{mm}_mm_percent"]))) for mm in (1, 2, 5, 10, 15, 20)
        )
        for row in found
    }
    for body in ("ball", "block"):
        for fitted in (10, 20):
            assert missed[body, fitted, "following, 1"] < 3
            assert missed[body, fitted, "constant, 16 mm"] > 20


@pytest.mark.slow
def test_identified_by_its_curve_instead_of_two_slopes_a_solid_is_met_by_another_tip(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Identified with 10 mm, a tip of 20 mm meets 1 to 20 mm within 13 percent; by two slopes more than 40 off."""
    monkeypatch.setattr(other_tip_identified, "LAWS", ("linear",))
    found = [row for row in other_tip_identified.rows(5) if (row["identified_mm"], row["tip_mm"]) == (10, 20)]
    missed = {
        row["by"]: max(abs(float(str(row[f"force_{mm}_mm_percent"]))) for mm in (1, 2, 5, 10, 15, 20)) for row in found
    }
    assert missed["curve"] < 13 and missed["two slopes"] > 40
