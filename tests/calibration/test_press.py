"""From a recording to one loading curve."""

import numpy as np
import pytest

from core.base import DimpleError
from core.calibration.doubts import doubts, largest_miss
from core.calibration.measurement import Measurement
from core.calibration.press import LoadingCurve, prepare
from core.calibration.question import Answers, Undecided
from core.calibration.touch import settle


def law(depth):
    """Object 2 of Table 2, mm to N."""
    inside = np.maximum(depth, 0)
    return 0.61 * np.minimum(inside, 16.3) + 7.23 * np.maximum(inside - 16.3, 0)


def recording(depth, force, *, noise=0.0, seed=0) -> Measurement:
    """Make a measurement of depth [mm] and force [N]."""
    force = force + noise * np.ptp(force) * np.random.default_rng(seed).normal(size=len(depth))
    return Measurement(source="x.csv", depth=np.asarray(depth) / 1e3, force=force, depth_header="Depth",
                       force_header="Force")  # fmt: skip


def constants(measurement, answers=None):
    """Return K1, K2 [N/mm] and x0 [mm]."""
    _, fit = settle(prepare(measurement, answers), answers)
    return fit.K1.value / 1e3, fit.K2.value / 1e3, fit.x0.value * 1e3


def pressed(measurement, answers=None) -> LoadingCurve:
    """Return the press from the touch that was found or given."""
    return settle(prepare(measurement, answers), answers)[0]


TRUTH = pytest.approx((0.61, 7.23, 16.3), rel=0.03)


def test_travel_before_the_touch_and_an_untared_load_cell_are_taken_off():
    depth = np.linspace(-8, 22, 400)
    press = pressed(recording(depth + 31.5, law(depth) + 0.7, noise=0.002))
    assert press.touch * 1e3 == pytest.approx(31.5, abs=0.1)
    assert press.tare == pytest.approx(0.7, abs=0.05)
    assert constants(recording(depth + 31.5, law(depth) + 0.7, noise=0.002)) == TRUTH


def test_thousands_of_rows_before_the_rig_starts_do_no_harm():
    depth = np.concatenate([np.full(5000, -2.0), np.linspace(-2, 22, 300)])
    assert constants(recording(depth, law(depth), noise=0.003)) == TRUTH


def test_signs_are_turned_round():
    depth = np.linspace(-3, 22, 300)
    for sign_depth in (1, -1):
        for sign_force in (1, -1):
            turned = recording(sign_depth * depth + 5, sign_force * law(depth), noise=0.003)
            assert constants(turned) == TRUTH


def test_loading_and_unloading_are_parted_and_the_loss_is_found():
    depth = np.concatenate([np.linspace(0, 22, 300), np.linspace(22, 0, 300)])
    force = law(depth) * np.where(np.arange(600) < 300, 1.0, 0.8)
    press = prepare(recording(depth, force))
    assert len(press.depth) == pytest.approx(300, abs=2)
    assert press.loss == pytest.approx(0.2, abs=0.01)
    assert press.damping_ratio == pytest.approx(0.2 / np.pi, rel=0.05)
    assert constants(recording(depth, force)) == TRUTH


def test_the_damping_hint_is_right_for_a_spring_and_dashpot():
    z, w, k = 0.1, 1.0, 600.0
    t = np.linspace(0, 2 * np.pi, 2000)
    depth = 0.01 * (1 - np.cos(t))
    force = k * depth + 2 * z * k / w * 0.01 * np.sin(t) * w
    press = prepare(recording(depth * 1e3, force))
    assert press.damping_ratio == pytest.approx(z, rel=0.25)


def test_a_hold_at_the_bottom_and_one_on_the_way_are_dropped():
    way = np.concatenate([np.linspace(0, 10, 150), np.full(400, 10.0), np.linspace(10, 22, 150), np.full(2000, 22.0)])
    relaxed = law(way) * np.where(np.arange(len(way)) > 750, 0.8, 1.0)
    press = prepare(recording(way, relaxed, noise=0.001))
    assert "did not change" in " ".join(press.remarks.notes)
    assert constants(recording(way, relaxed, noise=0.001)) == TRUTH


def test_cycles_that_agree_need_no_question_and_the_first_is_fitted():
    one = np.concatenate([np.linspace(0, 22, 200), np.linspace(22, 0, 200)])
    press = prepare(recording(np.tile(one, 3), law(np.tile(one, 3)), noise=0.005))
    assert "3 presses agree" in " ".join(press.remarks.notes)


def test_cycles_that_differ_are_asked():
    one = np.concatenate([np.linspace(0, 22, 200), np.linspace(22, 0, 200)])
    softened = recording(np.tile(one, 2), law(np.tile(one, 2)) * np.repeat([1.0, 0.6], 400))
    with pytest.raises(Undecided, match=r"Which one is to be fitted\? Give cycle: '1' \(.*'2' \("):
        prepare(softened)
    assert constants(softened, Answers(cycle=1)) == TRUTH
    assert constants(softened, Answers(cycle=2))[0] == pytest.approx(0.6 * 0.61, rel=0.03)


def test_single_rows_that_are_wrong_are_left_out_with_a_warning():
    depth = np.linspace(0, 22, 300)
    force = law(depth) + 0.05 * np.random.default_rng(2).normal(size=300)
    force[[50, 180]] = 70, -40
    broken = recording(depth, force)
    assert "2 rows differ strongly" in " ".join(prepare(broken).remarks.warnings)
    assert constants(broken) == TRUTH


def test_a_file_that_begins_in_contact_has_its_touch_where_its_first_rows_point_back_to():
    depth = np.linspace(2, 22, 300)
    press = pressed(recording(depth, law(depth), noise=0.001))
    assert not press.tare
    assert press.touch == pytest.approx(0, abs=2e-4)


def test_a_given_touch_is_taken():
    depth = np.linspace(-3, 22, 300)
    press = pressed(recording(depth + 3, law(depth)), Answers(contact_mm=3.0))
    assert press.touch == pytest.approx(0.003)
    with pytest.raises(DimpleError, match="outside"):
        pressed(recording(depth, law(depth)), Answers(contact_mm=500.0))


def test_a_soft_beginning_is_taken_for_hardly_any_travel_before_the_touch_or_asked_about():
    depth = np.linspace(0, 20, 400)
    soft = recording(depth, 0.5 * np.expm1(depth / 4), noise=0.0005)
    try:
        touch_mm = 1e3 * pressed(soft).touch
    except Undecided as undecided:
        touch_mm = float(undecided.questions[0].default)
    assert abs(touch_mm) < 0.05 * 20


def test_a_force_that_goes_both_ways_is_asked():
    depth = np.linspace(-5, 22, 300)
    both = recording(depth, law(depth) - 40 * (np.abs(depth + 2) < 1))
    with pytest.raises(Undecided, match="Which sign is a press"):
        prepare(both)


def test_rows_from_the_last_to_the_first_are_read_backwards_with_a_warning():
    depth = np.linspace(22, 0, 300)
    press = prepare(recording(depth, law(depth)))
    assert any("only the unloading" in warning for warning in press.remarks.warnings)
    assert constants(recording(depth, law(depth))) == TRUTH


def test_rows_out_of_order_are_refused():
    depth = np.random.default_rng(0).permutation(np.linspace(0, 22, 300))
    with pytest.raises(DimpleError, match="order"):
        prepare(recording(depth, law(depth)))


def test_columns_that_are_no_press_are_refused_or_warned_of():
    rng = np.random.default_rng(4)
    noise = recording(np.linspace(0, 22, 300), rng.normal(size=300) + 5)
    loading, fit = settle(prepare(noise, Answers(press="positive")), Answers(contact_mm=0.0))
    warnings = doubts(fit, loading, largest_miss(loading.depth, loading.force, fit.law(loading.depth)), None)
    assert any("does not determine K1" in warning or "misses the measured" in warning for warning in warnings)
    with pytest.raises(DimpleError, match="same in every row"):
        prepare(recording(np.linspace(0, 22, 300), np.full(300, 5.0)))
