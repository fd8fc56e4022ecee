"""The force on a fingertip 1000 times a second, on the surface that Blender carries 60 times a second."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.device.rendered_surface import Contact, Law, Surface, is_sane, left_at, stiffness_cap
from core.material import law_force, law_slope
from core.vectors import ZERO, Vector, length
from studies.paper_objects import PRESETS
from tests.haptics.bench_device import wall

CAP = 1e5  # [N/m] of a device that renders all
MATERIAL = PRESETS[1].material  # vinyl and air: K1 = 610 N/m
VINYL = Law(MATERIAL.K1, MATERIAL.K2, MATERIAL.x0, 1.0)
SOLID = Law(600.0, 1350.0, 0.006, 1.5)
OTHER = VINYL._replace(factors=(2.0, 1.5, 1.2, 1.1, 1.0), deepest=0.04)
LAYER = SOLID._replace(factors=tuple(1.0 + 0.01 * k * k for k in range(33)), deepest=0.04)  # a wide tip on a thin one
LAWS = pytest.mark.parametrize(
    "law", [VINYL, SOLID, OTHER, LAYER], ids=["straight", "bent", "another tip", "another tip on a layer"]
)


def surface(law: Law = VINYL, **changes: object) -> Surface:
    return replace(wall(), law=law, **changes)


def contact(law: Law = VINYL, cap: float = CAP, **changes: object) -> Contact:
    """Return a contact that rests above the surface z = 0."""
    made = Contact()
    made.take(surface(law, **changes), (0.0, 0.0, 0.01), 0.0, cap)
    return made


def at(depth: float, x: float = 0.0) -> Vector:
    return (x, 0.0, -depth)


@LAWS
@pytest.mark.parametrize("speed", [0.01, 0.1, 0.5], ids="{} m/s".format)
def test_between_two_frames_the_force_is_the_law_at_the_depth_of_the_fingertip(law: Law, speed: float) -> None:
    """Whatever its speed, and through the knee: 16 ticks on one surface, which Blender sent at their begin."""
    made = contact(law)
    for tick in range(160):
        depth = -0.005 + speed * tick * 1e-3
        plain = law_force(depth, *law[:4])
        made.surface = replace(made.surface, stamp=tick // 16 * 0.016)  # type: ignore[type-var]
        assert made.force(at(depth), tick * 1e-3)[2] == pytest.approx(law.factor(depth)[0] * plain, abs=1e-12)


def test_the_factor_of_another_tip_is_read_between_its_depths() -> None:
    """At depths that grow with the square of their number: the second of five lies at a sixteenth of the deepest."""
    assert [OTHER.factor(x)[0] for x in (0.0, 0.04 / 16, 0.04 * (1.5 / 4) ** 2, 0.04, 1.0)] == pytest.approx(
        [2.0, 1.5, 1.35, 1.0, 1.0]
    )


@LAWS
def test_what_the_device_cannot_render_is_as_steep_as_it_can(law: Law) -> None:
    depths = np.linspace(0.0, 0.035, 3001)[1:]
    for cap in (1300.0, 640.0, 300.0):
        forces, whole = (np.array([law.force(depth, most) for depth in depths]) for most in (cap, CAP))
        assert (forces <= whole + 1e-12).all()
        assert np.diff(forces).max() <= cap * (depths[1] - depths[0]) * (1 + 1e-9)
    assert VINYL.force(0.020, 640.0) == pytest.approx(610 * 0.0163 + 640 * (0.020 - 0.0163))


@LAWS
@pytest.mark.parametrize("force", [0.5, 2.0, 8.0])
def test_up_to_a_force_a_law_is_rendered_unchanged_from_its_steepest_slope_on(law: Law, force: float) -> None:
    steepest, changed = law.steepest(force), 0
    for x in np.linspace(0, 0.05, 300):
        true = law.force(x, math.inf)
        if true < force:
            assert law.force(x, steepest) == pytest.approx(true, rel=1e-3)
            changed += law.force(x, 0.8 * steepest) < 0.99 * true
    assert changed, "and a device that renders less changes it"


def test_the_slope_of_a_law_is_its_derivative() -> None:
    for law in (VINYL[:4], SOLID[:4]):
        for depth in (0.002, 0.005, 0.008, 0.020):
            rise = law_force(depth + 1e-7, *law) - law_force(depth - 1e-7, *law)
            assert law_slope(depth, *law) == pytest.approx(rise / 2e-7, rel=1e-4)


@pytest.mark.parametrize(
    ("law", "over"),
    [
        (Law(610, 610, 0.016, 1), 0.0), (Law(610, 7230, 0.0163, 1), 0.012), (Law(50, 5000, 0.01, 1), 0.09),
        (Law(600, 4000, 0.02, 1.5), 0.012),
    ],
)  # fmt: skip
def test_the_energy_of_a_press_is_the_integral_of_its_force_or_a_little_more(law: Law, over: float) -> None:
    for depth in np.linspace(0.1, 3.0, 30) * law.x0:
        x = np.linspace(0, depth, 4001)
        forces = np.array([law.force(each, math.inf) for each in x])
        exact = float(((forces[1:] + forces[:-1]) / 2).sum() * x[1])
        assert (1 - 1e-6) * exact <= law.energy(depth, math.inf) <= (1 + over + 1e-6) * exact


@LAWS
@pytest.mark.parametrize("cap", [CAP, 800.0])
def test_a_surface_at_rest_gives_exactly_what_it_took(law: Law, cap: float) -> None:
    """Pressed in and out straight, as often as you like: the force is a function of the depth alone."""
    made, depths = contact(law, cap, friction=0.0), 0.012 * np.sin(np.linspace(0, 6 * np.pi, 6001))
    forces = np.array([made.force(at(depth), 0.0)[2] for depth in depths])
    assert abs(float(((forces[1:] + forces[:-1]) / 2) @ np.diff(depths))) < 1e-6, "[J]"


def test_a_surface_pushes_and_never_pulls_and_a_gap_has_no_force() -> None:
    made = contact(Law(600.0, 600.0, 1.0, 1.0), place=(0.0, 0.0, -0.002))
    assert made.force(at(0.002), 0.0) == ZERO == made.force(at(-0.05), 0.0)
    assert made.force(at(0.003), 0.0)[2] == pytest.approx(0.6)


@pytest.mark.parametrize("cap", [CAP, 300.0])
def test_friction_is_a_spring_to_the_anchor_of_two_thirds_of_the_stiffness(cap: float) -> None:
    made = Contact()
    made.take(surface(anchor=at(0.010), friction=0.5), at(0.010, 0.002), 0.0, cap)
    force = made.force(at(0.010, 0.002), 0.1)
    assert force[0] == pytest.approx(-2 / 3 * min(MATERIAL.K1, cap) * 0.002)
    assert made.anchor == pytest.approx(at(0.010)), "it holds"


@pytest.mark.parametrize("cap", [CAP, 300.0])
def test_a_fingertip_that_slips_draws_the_anchor_along_and_pulls_back_with_coulombs_friction(cap: float) -> None:
    made = contact(VINYL, cap, friction=0.5)
    made.force(at(0.010), 0.0)
    for x in np.linspace(0, 0.03, 31):
        fx, _, fz = made.force(at(0.010, x), 0.0)
    assert fx == pytest.approx(-0.5 * fz) and made.anchor and 0.02 < made.anchor[0] < 0.03
    back = made.force(at(0.010, 0.0225), 0.0)
    assert abs(back[0]) < 1e-3 * fz, "half way back through its spring: 2 x 7.5 mm"


def test_the_anchor_of_a_body_that_is_carried_along_takes_the_friction_with_it() -> None:
    """A lifted cube: Blender sends where its own anchor is, and the fingertip that moves with it does not slip."""
    made = contact(friction=0.5)
    for frame in range(20):
        x, now = 0.001 * frame, 0.016 * frame
        made.take(surface(anchor=at(0.010, x - 0.002), friction=0.5, stamp=now), at(0.010, x), now, CAP)
        force = made.force(at(0.010, x), now + 0.016)
        if frame > 3:
            assert force[0] == pytest.approx(-2 / 3 * MATERIAL.K1 * 0.002, rel=1e-2)


def test_a_fingertip_that_touches_before_blender_knows_is_held_from_where_it_touched() -> None:
    made = contact(friction=0.5)
    made.force(at(0.001, 0.003), 0.0)
    assert made.force(at(0.005, 0.004), 0.0)[0] == pytest.approx(-2 / 3 * MATERIAL.K1 * 0.001)
    made.take(surface(friction=0.5), at(0.005, 0.004), 0.016, CAP)  # its frame was before the touch
    assert made.anchor == pytest.approx((0.003, 0.0, -0.005))


def test_the_largest_stiffness_is_that_of_the_design() -> None:
    """0.8 b / (T/2 + t_d): b = 2 N s/m, T = 1 ms; with a delay of 0.7 ms 1331 N/m."""
    assert stiffness_cap(2.0, 1e-3, 0.702e-3) == pytest.approx(1331, abs=1)


def test_an_old_surface_fades_between_100_and_200_ms_and_one_from_the_future_is_of_another_clock() -> None:
    assert [left_at(age) for age in (0.0, 0.1, 0.15, 0.2, 5.0, -1.0)] == pytest.approx([1, 1, 0.5, 0, 0, 0])


@pytest.mark.parametrize(
    "change",
    [
        {"place": (math.nan, 0, 0)}, {"place": (0, math.inf, 0)}, {"place": (1e9, 0, 0)}, {"anchor": (0, 0, 1e9)},
        {"anchor": (0, math.nan, 0)}, {"normal": (0, 0, 2.0)}, {"normal": (0, 0, 0)}, {"friction": -0.1},
        {"stamp": math.nan}, {"law": VINYL._replace(K1=-1.0)}, {"law": VINYL._replace(K2=math.inf)},
        {"law": VINYL._replace(x0=-0.001)}, {"law": VINYL._replace(power=math.nan)}, {"law": VINYL._replace(power=0.5)},
        {"law": VINYL._replace(K1=1e300)}, {"law": OTHER._replace(deepest=0.0)},
        {"law": OTHER._replace(factors=(1.0, math.nan))}, {"law": OTHER._replace(factors=(1.0,))},
    ],
)  # fmt: skip
def test_a_surface_that_is_not_of_this_world_is_refused(change: dict[str, object]) -> None:
    assert is_sane(wall()) and is_sane(surface(OTHER))
    assert not is_sane(replace(wall(), **change))


def test_a_new_surface_changes_the_force_without_a_jump_and_wholly_within_a_frame() -> None:
    made, x, frame = Contact(), at(0.002), 0.016
    forces = []
    for i in range(160):
        now = i * 1e-3
        if i % 16 == 0:  # the surface rises
            made.take(wall(now, k=1000.0, force=0.2 * (i // 16) - 2.0), x, now, CAP)
        forces.append(made.force(x, now)[2])
    assert max(abs(b - a) for a, b in zip(forces, forces[1:], strict=False)) <= 1.01 * 0.2 / (frame / 1e-3)
    assert forces[-1] == pytest.approx(9 * 0.2, rel=0.1)


def test_another_cap_changes_the_force_without_a_jump() -> None:
    made = contact(Law(1000.0, 1000.0, 1.0, 1.0))
    before = made.force(at(0.004), 0.016)
    made.take(surface(made.surface.law, stamp=0.016), at(0.004), 0.016, 500.0)  # type: ignore[union-attr]
    forces = [made.force(at(0.004), 0.016 + i * 1e-3)[2] for i in range(20)]
    assert forces[0] == pytest.approx(before[2]) and forces[-1] == pytest.approx(2.0)
    assert max(a - b for a, b in zip(forces, forces[1:], strict=False)) < 0.2


def test_a_surface_that_is_taken_away_lets_go_within_a_frame_and_does_not_pull() -> None:
    made, x = Contact(), at(0.002)
    made.take(wall(0.0), x, 0.0, CAP)
    made.take(wall(0.084), x, 0.084, CAP)
    made.take(None, x, 0.1, CAP)
    forces = [made.force(x, 0.1 + i * 1e-3) for i in range(20)]
    assert forces[0][2] == pytest.approx(1.2)
    assert all(force[2] >= 0 for force in forces)
    assert length(forces[-1]) == 0.0
