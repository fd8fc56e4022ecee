"""The two-piece fit against closed forms, SciPy and pwlf; its intervals against files of a known law."""

import math

import numpy as np
import pwlf
import pytest
from scipy import optimize, stats

from core.base import DimpleError
from core.calibration.calibrate import calibrate
from core.calibration.fit import fit_law, t_95
from core.calibration.virtual_press import write_press
from studies.law.paper import reconstruct
from studies.paper_objects import PRESETS


def law(x, K1, K2, x0):
    return K1 * np.minimum(x, x0) + K2 * np.maximum(x - x0, 0)


def test_a_curve_without_noise_gives_its_constants_back():
    x = np.linspace(0, 0.02, 101)
    fit = fit_law(x, law(x, 620.0, 9130.0, 0.01373))
    assert fit.model == "two"
    assert (fit.K1.value, fit.K2.value, fit.x0.value) == pytest.approx((620.0, 9130.0, 0.01373), rel=1e-6)


def test_a_knee_on_a_row_is_found_as_well_as_one_between_rows():
    x = np.linspace(0, 0.02, 101)
    assert fit_law(x, law(x, 620.0, 9130.0, x[60])).x0.value == pytest.approx(x[60], rel=1e-6)


@pytest.mark.parametrize(("curves", "finer"), [(10, 1000), pytest.param(40, 4000, marks=pytest.mark.slow)])
def test_no_finer_search_of_the_knee_finds_less_residual(curves, finer):
    rng = np.random.default_rng(1)
    for free in ((), ("tare",)):
        for _ in range(curves):
            x = np.sort(rng.uniform(0, 1, 40))
            y = law(x, *rng.uniform(0.5, 5, 2), rng.uniform(0.3, 0.7)) + 0.05 * rng.normal(size=40)
            fit = fit_law(x, y, free=free)
            if fit.model == "one":
                continue
            found = float(((y - fit.tare.value - fit.law(x)) ** 2).sum())
            finest = min(residual_at(x, y, knee, free) for knee in np.linspace(x[2], x[-3], finer))
            assert found <= finest * (1 + 1e-9)


def residual_at(x, y, knee, free):
    design = np.stack([np.minimum(x, knee), np.maximum(x - knee, 0), *([np.ones(len(x))] if free else [])], axis=1)
    return float(((y - design @ np.linalg.lstsq(design, y, rcond=None)[0]) ** 2).sum())


def test_constants_and_errors_agree_with_scipy_to_six_digits():
    for preset in PRESETS:
        x, f = (a[1:] for a in reconstruct(preset, seed=7))
        fit = fit_law(x, f)
        start = [fit.K1.value, fit.K2.value, fit.x0.value]
        values, covariance = optimize.curve_fit(law, x, f, np.array(start) * 1.002, xtol=1e-15, ftol=1e-15)
        assert start == pytest.approx(values, rel=1e-6)
        errors = [fit.K1.error, fit.K2.error, fit.x0.error]
        assert errors == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-6)


def test_pieces_and_errors_agree_with_pwlf_to_six_digits():
    for preset in PRESETS:
        x, f = (a[1:] for a in reconstruct(preset, rows=120, seed=8))
        x = x * 1e3  # pwlf searches best near 1
        fit = fit_law(x, f)
        oracle = pwlf.PiecewiseLinFit(x, f)
        best = optimize.minimize_scalar(
            forced_residual,
            args=(oracle, x[-1]),
            bounds=(x[int(np.searchsorted(x, fit.x0.value)) - 1], x[int(np.searchsorted(x, fit.x0.value))]),
            method="bounded", options={"xatol": 1e-12},
        )  # fmt: skip
        assert fit.x0.value == pytest.approx(best.x, rel=1e-6)
        oracle.fit_with_breaks_force_points([0.0, fit.x0.value, x[-1]], [0.0], [0.0])
        assert [fit.K1.value, fit.K2.value] == pytest.approx(oracle.slopes, rel=1e-6)


def forced_residual(knee, oracle, end):
    """Return pwlf's sum of squared residuals; what it minimises itself has the constraint's multipliers added."""
    oracle.fit_with_breaks_force_points([0.0, knee, end], [0.0], [0.0])
    return oracle.ssr


def test_the_free_line_agrees_with_pwlf():
    x, f = reconstruct(PRESETS[2], rows=120, seed=9)
    x = x * 1e3
    fit = fit_law(x, f, free=("tare",))
    oracle = pwlf.PiecewiseLinFit(x, f, seed=1)
    oracle.fit(2)
    assert fit.fitted.squares(x, f) <= oracle.ssr * (1 + 1e-9)
    oracle.fit_with_breaks([x[0], fit.x0.value, x[-1]])
    assert [fit.K1.value, fit.K2.value] == pytest.approx(oracle.slopes, rel=1e-6)


def test_standard_errors_agree_with_pwlf():
    """pwlf's errors belong to a free line: give it the origin as a row so heavy that the line goes through it."""
    x, f = (a[1:] for a in reconstruct(PRESETS[1], rows=200, seed=10))
    x = x * 1e3
    fit = fit_law(x, f)
    # pwlf tells the errors of intercept, slope 1, change of slope and knee, but not how they go together: the error of
    # slope 2 is that of slope 1 of the curve seen from its other end
    there = pwlf_errors(x, f, 0.0, fit.x0.value)
    back = pwlf_errors(x[-1] - x, f, x[-1], x[-1] - fit.x0.value)
    assert (there[1], back[1]) == pytest.approx((fit.K1.error, fit.K2.error), rel=1e-6)
    assert (there[3], back[3]) == pytest.approx((fit.x0.error, fit.x0.error), rel=1e-6)


def pwlf_errors(x, f, touch, knee):
    heavy = pwlf.PiecewiseLinFit(np.append(touch, x), np.append(0.0, f), weights=np.append(1e4, np.ones(len(x))))
    breaks = np.array([0.0, knee, max(touch, x.max())])
    heavy.fit_with_breaks(breaks)
    heavy.fit_breaks = breaks
    # the added row counts in its degrees of freedom
    freedom = math.sqrt((len(x) + 1 - 4) / (len(x) - 3))
    return freedom * heavy.standard_errors(method="non-linear", step_size=1e-5)


@pytest.mark.parametrize("files", [20, pytest.param(100, marks=pytest.mark.slow)])
@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.name)
def test_table_2_lies_in_the_intervals_as_often_as_they_say(preset, files, tmp_path):
    truth, path, errors = preset.material, tmp_path / "press.csv", []
    for seed in range(files):
        write_press(path, *reconstruct(preset, rows=150, seed=seed))
        fit = calibrate(path).fit
        assert fit.model == "two"
        errors.append(errors_over_half_widths(fit, truth))
    check_intervals(np.array(errors), least=0.90)


def errors_over_half_widths(fit, truth) -> list[float]:
    """Return the errors of K1, K2 and x0 over half the width of their intervals."""
    pairs = (fit.K1, truth.K1), (fit.K2, truth.K2), (fit.x0, truth.x0)
    return [(constant.value - value) / constant.half_width for constant, value in pairs]


def check_intervals(errors, *, least):
    """Check that 95 % intervals are neither too narrow nor too wide, from errors (files, 3) over their half widths.

    A share from `least` to 0.99 of the files lies inside; fewer files than 100 may all do so. The RMS error is 1 / 1.96
    of a half width, with 3 standard errors for so many files.
    """
    files = len(errors)
    inside = (np.abs(errors) <= 1).mean(axis=0)
    assert (inside >= least).all() and (files < 100 or (inside <= 0.99).all()), inside
    rms = 1.96 * np.sqrt((errors**2).mean(axis=0))
    assert (np.abs(rms - 1) < 3 / math.sqrt(2 * files)).all(), rms


def test_an_estimated_contact_widens_the_intervals_just_enough():
    truth = PRESETS[2].material
    x = np.linspace(-0.004, 0.020, 360)
    exact = law(np.maximum(x, 0), truth.K1, truth.K2, truth.x0)
    errors = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        force = exact + 0.01 * exact.max() * rng.normal(size=len(x)) + 0.3
        fit = fit_law(x + 0.0003 * rng.normal(), force - 0.2, free=("contact", "tare"))
        errors.append(errors_over_half_widths(fit, truth))
    check_intervals(np.array(errors), least=0.88)


def test_the_band_round_the_law_holds_the_true_law():
    truth = PRESETS[1].material
    at = np.linspace(0.001, 0.021, 11)
    exact = law(at, truth.K1, truth.K2, truth.x0)
    held = np.zeros(len(at), int)
    for seed in range(200):
        fit = fit_law(*reconstruct(PRESETS[1], seed=seed))
        held += np.abs(fit.law(at) - exact) <= fit.band(at)
    assert ((held >= 180) & (held <= 198)).all(), held  # 90 to 99 %, as the intervals of the constants
    assert fit.band(at[:3]) == pytest.approx(at[:3] * fit.K1.half_width)  # one slope alone is at work there


def test_a_straight_line_is_not_given_a_knee_and_a_slight_bend_is():
    x = np.linspace(0, 0.02, 300)
    noise = [0.12 * np.random.default_rng(seed).normal(size=300) for seed in range(100)]
    assert sum(fit_law(x, 600 * x + each).model == "two" for each in noise) <= 5
    assert sum(fit_law(x, law(x, 600, 640, 0.01) + each).model == "two" for each in noise) >= 90


def test_a_straight_line_without_noise_has_one_slope():
    x = np.linspace(0, 0.02, 300)
    fit = fit_law(x, 600 * x)
    assert fit.model == "one"
    assert fit.K1.value == fit.K2.value == pytest.approx(600)


def test_a_knee_that_shows_is_claimed():
    x = np.linspace(0, 0.02, 300)
    f = law(x, 600, 900, 0.012)
    assert all(
        fit_law(x, f + 0.01 * f.max() * np.random.default_rng(seed).normal(size=300)).model == "two"
        for seed in range(20)
    )


def test_correlated_residuals_widen_the_intervals():
    x = np.linspace(0, 0.02, 600)
    rng = np.random.default_rng(3)
    white = rng.normal(size=600)
    coloured = np.convolve(rng.normal(size=640), np.ones(20) / math.sqrt(20), "same")[20:620]
    f = law(x, 620, 9130, 0.0137)
    plain, smooth = fit_law(x, f + 0.3 * white), fit_law(x, f + 0.3 * coloured)
    assert smooth.x0.half_width > 2 * plain.x0.half_width


def test_a_curve_that_falls_is_given_pieces_that_rise():
    x = np.linspace(0, 0.01, 200)
    fit = fit_law(x, 5 * np.sin(x / 0.01 * 1.1 * math.pi) + 200 * x)
    assert fit.K1.value > 0 and fit.K2.value > 0


def test_too_few_rows_are_refused():
    with pytest.raises(DimpleError, match="rows lie beyond the first touch"):
        fit_law(np.linspace(0, 1, 4), np.linspace(0, 1, 4))


@pytest.mark.parametrize("presses", [40, pytest.param(200, marks=pytest.mark.slow)])
def test_short_and_noisy_presses_are_fitted_with_errors_or_refused(presses):
    """Their noise may put the touch beyond the rows, or the knee before the touch."""
    fitted = 0
    for seed in range(presses):
        rng = np.random.default_rng(seed)
        x = np.linspace(rng.choice([0.0, -0.3]), 1, int(rng.choice([10, 15, 30])))
        f = law(np.maximum(x, 0), 1.0, 10 ** rng.uniform(-1, 1), rng.uniform(0, 1.3))
        f += np.ptp(f) * (10 ** rng.uniform(-3, 0.3) * rng.normal(size=len(x)) + rng.choice([0.0, -1.0]))
        for free in ((), ("contact",), ("tare",), ("contact", "tare")):
            try:
                fit = fit_law(x, f, free=free)
            except DimpleError as error:
                assert "beyond the first touch" in str(error)
                continue
            fitted += 1
            assert all(math.isfinite(c.half_width) for c in (fit.K1, fit.K2, fit.x0, fit.contact)), (seed, free)
            assert 0 < fit.x0.value <= x[-1] - fit.contact.value
    assert fitted > 2 * presses


def test_the_t_of_an_interval_agrees_with_scipy():
    for freedom in (3.0, 4.5, 7.0, 30.0, 1e3, 1e6):
        assert t_95(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=0.01)
