"""Model constants from a simulated press."""

import functools
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from core.base import DimpleError
from core.body import pressure, shape_matching, springs
from core.body.estimate import estimate
from core.body.model import initial_state
from core.calibration import cache
from core.calibration.calibrate import calibrate
from core.calibration.export import write_press
from core.calibration.identify import ALLOWED, ALLOWED_FORCE, NOTICEABLE_FORCE, WEAK, _deepest
from core.calibration.indent import find_site, go_down, press, set_up
from core.calibration.least_squares import bounded
from core.material import FINGERTIP, POINT, PRESETS, Indenter, ModelConstants
from core.mesh.surface import base_vertices
from core.session import Session
from studies.assessment import assess, assessment_json, assessment_lines
from studies.reconstruct import DEEPEST
from studies.scenes import ball, cube
from studies.virtual_press import identify, press_curve

OBJECT_1, OBJECT_2, OBJECT_3 = PRESETS
PUNCH, WIDE = Indenter(shape="punch", radius=0.020), Indenter(shape="sphere", radius=0.025)
# a bed that stiffens twice, 8 and 12 mm deep, under a tension that carries a dent 20 mm far
CONSTANTS = ModelConstants(
    kappa1=1.4e6, kappa2=1.4e6, d0=0.0137, membrane_scale=0.01, tension=560.0, pieces=((0.008, 4e6), (0.012, 1.5e7))
)
# 602 and 2402, 642 and 2562 vertices
BODIES = ("cube 10", "cube 20", "ball 3", "ball 4")


@functools.cache
def body(preset, words):
    """Return a cube of so many cells along its edge, or a ball of so many subdivisions, as large as an object."""
    shape, number = words.split()
    mesh = cube(int(number), preset.size) if shape == "cube" else ball(int(number), preset.size / 2)
    return mesh, base_vertices(mesh)


@functools.cache
def identified(preset, words, tip=POINT, deepest=0.0, **changed):
    """Identify an object, with some constants changed, and return it with the shares done that were yielded."""
    mesh, pinned = body(preset, words)
    yielded = []
    site = find_site(mesh, tip, pinned=pinned)
    material = replace(preset.material, **changed)
    return identify(mesh, material, tip, site, deepest or DEEPEST[preset.name], progress=yielded.append), yielded


def found_on(*given, **changed):
    return identified(*given, **changed)[0]


def off(found):
    """Return how far each force is off, as a share of full scale."""
    return np.abs(found.simulated - found.wanted) / found.wanted.max()


def assert_met(found, deepest):
    """The law at every depth: 1 % of full scale, and 0.2 % on the whole."""
    assert found.stopped == ""
    assert found.depths[-1] == pytest.approx(deepest) and len(found.depths) >= 20
    assert found.wanted == pytest.approx([found.material.law(depth) for depth in found.depths.tolist()])
    assert found.rms == pytest.approx(np.sqrt((off(found) ** 2).mean()))
    assert off(found).max() < 0.01 and found.rms < 0.002
    assert len(found.notes) == 1 and "k" in found.notes[0] and "%" in found.notes[0]


@pytest.mark.parametrize("words", BODIES)
@pytest.mark.parametrize("preset", [OBJECT_2, OBJECT_3], ids=lambda preset: preset.name)
def test_the_identified_body_answers_the_curve_a_point_measured(preset, words):
    found = found_on(preset, words)
    assert_met(found, DEEPEST[preset.name])
    assert 1e-6 < found.volume_change < 0.005


@pytest.mark.parametrize("words", BODIES)
def test_the_identified_body_answers_the_curve_a_punch_measured(words):
    found = found_on(OBJECT_3, words, PUNCH)
    assert_met(found, DEEPEST[OBJECT_3.name])
    assert found.material.indenter == PUNCH


def test_a_press_of_its_own_answers_what_the_identification_says():
    """On other depths than those that were checked, and straight down from the touch."""
    mesh, pinned = body(OBJECT_2, "cube 10")
    material, site = found_on(OBJECT_2, "cube 10").material, find_site(mesh, POINT, pinned=pinned)
    for depth in (0.0051, 0.0127, 0.0203):
        station = go_down(set_up(mesh, material, POINT, site), POINT, site, 0.0, depth)
        assert station.force == pytest.approx(OBJECT_2.material.law(depth), rel=0.02)


@pytest.mark.parametrize("words", ["cube 16", "cube 20"])
@pytest.mark.parametrize("preset", [OBJECT_2, OBJECT_3], ids=lambda preset: preset.name)
def test_a_round_fingertip_rounds_the_knee_and_ends_at_the_measured_force(preset, words):
    found = found_on(preset, words, FINGERTIP)
    assert found.stopped == "" and found.depths[-1] == pytest.approx(DEEPEST[preset.name])
    assert found.simulated[-1] == pytest.approx(found.wanted[-1], rel=0.08)
    assert 0.002 < found.rms <= 0.025 and off(found).max() <= 0.08
    assert found.worst <= 1 or "round tip" in found.notes[-1]


def test_little_is_pressed_to_identify_a_body_by_a_point(monkeypatch):
    """In simulated time; it was 0.57 s when the tip rested twice as long at each depth."""
    simulated, step = [], Session.step

    def counted(session, dt, **given):
        simulated.append(dt)
        return step(session, dt, **given)

    monkeypatch.setattr(Session, "step", counted)
    mesh, pinned = body(OBJECT_3, "ball 4")
    found = identify(mesh, OBJECT_3.material, POINT, find_site(mesh, POINT, pinned=pinned), DEEPEST[OBJECT_3.name])
    assert sum(simulated) < 0.5 and found.rms < 0.02


@pytest.mark.parametrize("tip", [FINGERTIP, WIDE], ids=["10 mm", "25 mm"])
def test_between_the_depths_that_were_fitted_a_round_tip_is_off_no_more(tip):
    mesh, pinned = body(OBJECT_3, "ball 3")
    found = found_on(OBJECT_3, "ball 3", tip)
    depths = found.depths[-1] * (np.arange(1, 31) - 0.37) / 30
    stations = list(press(mesh, found.material, tip, find_site(mesh, tip, pinned=pinned), depths.tolist()))
    wanted = np.array([found.material.law(depth) for depth in depths.tolist()])
    missed = np.array([station.force for station in stations]) - wanted
    assert np.sqrt((missed**2).mean()) < 0.025 * wanted.max()


@pytest.mark.parametrize("words", ["cube 10", "ball 3"])
def test_a_round_tip_as_wide_as_the_body_is_met_from_the_touch_on(words):
    """So little of it touches at first that the bed must jump there, within a hundredth of the knee."""
    found = found_on(OBJECT_1, words, WIDE)
    assert found.depths[-1] == pytest.approx(DEEPEST[OBJECT_1.name])
    assert found.rms < 0.01 and off(found)[found.depths < 0.010].max() < 0.015


def test_bounded_least_squares_finds_the_least_of_what_is_allowed():
    """Against every combination of values on a grid."""
    random = np.random.default_rng(2)
    matrix, wanted = random.normal(size=(6, 3)), 3 * random.normal(size=6)
    low, high = np.array([-1.0, 0.0, -0.5]), np.array([0.5, 2.0, 0.5])
    found = bounded(matrix, wanted, low, high, 0.1)
    grid = np.stack(np.meshgrid(*(np.linspace(a, b, 41) for a, b in zip(low, high, strict=True))), axis=-1)

    def cost(y):
        return ((y @ matrix.T - wanted) ** 2).sum(axis=-1) + 0.01 * (y**2).sum(axis=-1)

    assert (found >= low).all() and (found <= high).all()
    assert cost(found) <= cost(grid).min() * (1 + 1e-9)
    assert cost(found) == pytest.approx(cost(grid).min(), rel=0.01)


@pytest.mark.parametrize("words", ["cube 4", "ball 2"])
def test_a_mesh_with_one_vertex_under_the_tip_is_met_as_well(words):
    mesh, pinned = body(OBJECT_3, words)
    assert find_site(mesh, POINT, pinned=pinned).under.sum() == 1
    assert_met(found_on(OBJECT_3, words), DEEPEST[OBJECT_3.name])


def test_the_estimate_answers_with_another_curve():
    """What identification is for: without it the same press on the same body is far outside what is allowed."""
    mesh, pinned = body(OBJECT_3, "cube 10")
    material, site = replace(OBJECT_3.material, indenter=POINT), find_site(mesh, POINT, pinned=pinned)
    depths = found_on(OBJECT_3, "cube 10").depths[4::5]
    stations = list(press(mesh, material, POINT, site, depths))
    wanted = np.array([material.law(depth) for depth in depths.tolist()])
    errors = np.abs(np.array([station.force for station in stations]) - wanted)
    assert len(stations) == len(depths) == 4 and (errors > 2 * np.maximum(0.1 * wanted, 0.3)).any()


def test_object_1_is_met_as_deep_as_its_thickness_allows_and_says_why_it_stops():
    found = found_on(OBJECT_1, "cube 8", deepest=0.060)
    assert found.depths[-1] == pytest.approx(0.9 * OBJECT_1.size, rel=1e-5)
    assert "far side" in found.stopped and found.stopped in found.notes
    assert off(found).max() < 0.01 and found.rms < 0.002


@pytest.mark.parametrize(
    ("x0", "pressed"), [(0.0005, 0.018), (0.005, 0.12 / 7), (0.0163, 24 / 22 * 0.0163), (0.03, 0.018)]
)
def test_on_thin_parts_one_depth_is_the_knee_if_little_is_left_out(x0, pressed):
    one = SimpleNamespace(thickness=0.020, others=())
    for site, depth in ((one, 0.018), (SimpleNamespace(thickness=0.020, others=(one,)), pressed)):
        deep, stopped = _deepest(0.045, site, x0)
        assert deep == pytest.approx(depth) and "far side" in stopped


@pytest.mark.parametrize("deepest", [0.001, 0.006, 0.012], ids=lambda depth: f"{1e3 * depth:g} mm")
def test_a_press_that_ends_before_the_knee_is_met(deepest):
    found = found_on(OBJECT_3, "cube 10", deepest=deepest)
    assert_met(found, deepest)
    assert found.wanted == pytest.approx(OBJECT_3.material.K1 * found.depths)


def test_a_straight_law_and_one_that_softens_a_little_are_met():
    """Beyond the knee the tension round the tip goes on pulling, so a body softens less than its bed does."""
    K1 = OBJECT_3.material.K1
    assert_met(found_on(OBJECT_3, "cube 10", K2=K1), DEEPEST[OBJECT_3.name])
    found = found_on(OBJECT_3, "cube 10", K2=0.75 * K1)
    assert found.worst <= 1 and found.rms < 0.02 and len(found.notes) == 1
    slopes = np.diff(found.simulated) / np.diff(found.depths)
    assert slopes[-1] < 0.95 * slopes[0]


def test_a_body_that_cannot_follow_says_where_it_misses_most():
    """A law that all but yields: no bed is softer than none, and the tension alone answers more."""
    found = found_on(OBJECT_3, "cube 10", K2=0.3 * OBJECT_3.material.K1)
    allowed = np.maximum(ALLOWED * found.wanted, min(ALLOWED_FORCE, WEAK * found.wanted.max()))
    at = int((np.abs(found.simulated - found.wanted) / allowed).argmax())
    assert found.worst > 1
    assert f"off the most at {1e3 * found.depths[at]:.3g} mm" in found.notes[-1]
    assert f"{found.simulated[at]:.3g} N instead of {found.wanted[at]:.3g} N" in found.notes[-1]


def test_the_constants_become_the_model():
    """Without a tension a bed under a grip of area A answers A (kappa1 x + what each piece adds beyond its knee)."""
    mesh, pinned = body(OBJECT_3, "cube 20")
    site = find_site(mesh, POINT, pinned=pinned)
    constants = replace(CONSTANTS, membrane_scale=1e-6, tension=0.0)
    material = replace(OBJECT_3.material, fill="none", constants=constants)
    assert estimate(material, OBJECT_3.size) is constants
    area = float(mesh.vertex_areas[site.under].sum())
    for station in press(mesh, material, POINT, site, [0.006, 0.010, 0.015]):
        pieces = sum(more * max(station.depth - knee, 0.0) for knee, more in constants.pieces)
        assert station.force == pytest.approx(area * (constants.kappa1 * station.depth + pieces), rel=0.01)


@pytest.mark.parametrize("fill", ["air", "liquid", "none"])
def test_the_work_of_the_tip_is_the_energy_stored(fill):
    mesh, pinned = body(OBJECT_3, "cube 6")
    site = find_site(mesh, POINT, pinned=pinned)
    material = replace(OBJECT_3.material, fill=fill, constants=CONSTANTS)
    depths = np.linspace(0.004, 0.020, 33)
    stations = list(press(mesh, material, POINT, site, depths.tolist()))
    model = set_up(mesh, material, POINT, site).model
    pose = initial_state(model).pose
    stored = [
        springs.energy(model.springs, s.positions)
        + pressure.energy(model.pressure, s.positions)
        + shape_matching.energy(model.matching, s.positions, pose)
        for s in (stations[0], stations[-1])
    ]
    forces = np.array([s.force for s in stations])
    work = ((forces[1:] + forces[:-1]) / 2 * np.diff(depths)).sum()
    # 1 %: the trapezoids' error at the knees
    assert work == pytest.approx(stored[1] - stored[0], rel=0.01)


def test_what_another_tip_meets_follows_from_the_material():
    """Deeper is more, and in the end a wider tip meets more: a prediction, for only the point was measured."""
    mesh, pinned = body(OBJECT_3, "cube 20")
    material = found_on(OBJECT_3, "cube 20").material
    curves = []
    for tip in (FINGERTIP, WIDE, PUNCH):
        site = find_site(mesh, tip, pinned=pinned)
        curves.append([station.force for station in press(mesh, material, tip, site, [0.004, 0.008, 0.012])])
    assert (np.diff(curves, axis=1) > 0).all() and curves[0][0] > 0
    assert curves[0][-1] < curves[1][-1] < curves[2][-1]


def test_a_round_tip_is_off_by_more_than_the_just_noticeable_difference_and_it_is_said():
    """It touches more as it sinks in: soft at first and round at the knee, which an error over full scale hides."""
    preset, tip = OBJECT_2, WIDE
    mesh, pinned = body(preset, "cube 8")
    found = found_on(preset, "cube 8", tip)
    share = np.abs(found.simulated - found.wanted) / found.wanted
    assert found.rms < min(NOTICEABLE_FORCE) / 2 and max(NOTICEABLE_FORCE) < share.max()
    assert "off the most" in found.notes[-1] and "round tip" in found.notes[-1]
    assert found.off == pytest.approx(share)
    measured = calibrate(Path(__file__).parents[2] / "blend_samples" / "calibration" / f"{preset.name}.csv")
    assessment = assess(measured, found, mesh, tip, find_site(mesh, tip, pinned=pinned))
    record = assessment_json(assessment)
    assert record["force_off_percent"] == pytest.approx(100 * share.max())
    text = " ".join(assessment_lines(assessment))
    assert f"largest force error {100 * share.max():.1f} %" in text
    constants, pieces = found.material.constants, record["pieces"]
    given = np.array([(1e-3 * piece["knee"], 1e6 * piece["more"]) for piece in pieces])
    assert given == pytest.approx(np.array(constants.pieces))
    assert 1e3 * record["tension"] == pytest.approx(constants.tension)
    assert f"tension {record['tension']:.3g} N/mm" in text


@pytest.mark.parametrize(
    ("words", "tip", "deepest"),
    [("cube 6", POINT, 0.018), ("ball 2", POINT, 0.018), ("cube 6", FINGERTIP, 0.018), ("cube 6", POINT, 0.006)],
    ids=["a cube", "a ball", "a fingertip", "before the knee"],
)
def test_the_share_that_is_done_foretells_how_much_is_left(words, tip, deepest):
    """Steps are about as long, so the time that is left follows, within a half; a round tip ends where it is met."""
    shares = np.array(identified(OBJECT_3, words, tip, deepest)[1])
    assert 0 < shares[0] < 0.1 and (np.diff(shares) > 0).all() and 0.3 < shares[-1] < 1
    foretold = shares[-1] * (np.arange(1, len(shares) + 1) / shares)[shares > 0.1]
    assert (foretold < 1.5 * len(shares)).all() and (foretold > len(shares) / 1.5).all()
    assert shares[-1] > 0.9 or tip == FINGERTIP


def test_an_identification_is_remembered_by_mesh_material_and_tip(tmp_path):
    mesh, pinned = body(OBJECT_3, "cube 10")
    material, at = OBJECT_3.material, find_site(mesh, PUNCH, pinned=pinned).point
    found = found_on(OBJECT_3, "cube 10", PUNCH)
    name = cache.key(mesh, material, PUNCH, 0.012, at)
    assert cache.recall(tmp_path, name) is None
    cache.remember(tmp_path, name, found)
    again = cache.recall(tmp_path, name)
    assert again.material == found.material and again.material.indenter == PUNCH
    assert len(again.material.constants.pieces) > 5 and again.material.constants.tension > 0
    for array in ("depths", "wanted", "simulated"):
        assert np.array_equal(getattr(again, array), getattr(found, array))
    assert (again.rms, again.worst, again.stopped, again.notes) == (found.rms, found.worst, found.stopped, found.notes)
    assert name == cache.key(mesh, replace(material, constants=found.material.constants), PUNCH, 0.012, at)
    moving = {"mass": None, "density": 300.0, "damping_ratio": 1.5}
    again = found_on(OBJECT_3, "cube 10", PUNCH, **moving)
    assert again.material.constants == found.material.constants
    assert name == cache.key(mesh, replace(material, **moving), PUNCH, 0.012, at), "it is found at rest"
    assert name != cache.key(mesh, replace(material, K1=1.0), PUNCH, 0.012, at)
    assert name != cache.key(mesh, material, Indenter(shape="sphere"), 0.012, at)
    assert name != cache.key(mesh, material, PUNCH, 0.013, at)
    (tmp_path / f"{name}.json").write_text('{"material": 3')
    assert cache.recall(tmp_path, name) is None


def test_a_virtual_press_written_and_read_gives_the_material_back(tmp_path):
    preset = OBJECT_3
    mesh, pinned = body(preset, "cube 10")
    site, path = find_site(mesh, POINT, pinned=pinned), tmp_path / "virtual.csv"
    curve = press_curve(mesh, found_on(preset, "cube 10").material, POINT, site, DEEPEST[preset.name])
    write_press(path, *curve, about=("a virtual press",))
    fit = calibrate(path).fit
    assert (fit.K1.value, fit.K2.value, fit.x0.value) == pytest.approx(
        (preset.material.K1, preset.material.K2, preset.material.x0), rel=0.01
    )


def test_a_tip_that_cannot_press_is_refused():
    mesh = cube(6, 0.1)
    with pytest.raises(DimpleError, match="misses"):
        find_site(mesh, POINT, above=(1.0, 0.0, 0.0))
    with pytest.raises(DimpleError, match="pinned"):
        find_site(mesh, POINT, pinned=mesh.rest_positions[mesh.source, 2] > 0)
    with pytest.raises(DimpleError, match="radius"):
        Indenter(radius=0.0)
    with pytest.raises(DimpleError, match="one of point"):
        Indenter(shape="cone")


def test_a_body_without_pinned_vertices_is_pressed_against_its_base():
    mesh = cube(6, 0.1)
    assert np.array_equal(find_site(mesh, POINT).pinned[mesh.source], base_vertices(mesh))
    sideways = find_site(mesh, POINT, inward=(1.0, 0.0, 0.0))
    assert mesh.rest_positions[sideways.pinned, 0].min() > 0.03
    assert sideways.thickness == pytest.approx(0.1, rel=1e-3)
