"""The local contact: the force on a fingertip between two frames of the simulation."""

import math
from dataclasses import replace

import pytest

from core.haptics.contact_model import Contact, ContactBlend, fade, force_at, is_sane, stiffness_cap
from core.vectors import ZERO, length
from tests.haptics.bench_device import wall

CAP = 1000.0
SLANTED = Contact(
    force=(0.6, 0.3, 3.2), at=(0.01, 0.02, 0.03), normal=(0.0, 0.6, 0.8), k_n=600.0, k_t=400.0, gap=0.0, friction=9.0,
    stamp=0.0,
)  # fmt: skip


def test_the_force_is_linear_about_the_place_of_the_simulation() -> None:
    """F = F0 - [k_n n n^T + k_t (I - n n^T)] (x - x0), written out with a matrix."""
    d = (0.001, -0.002, 0.0005)
    n, k_n, k_t = SLANTED.normal, SLANTED.k_n, SLANTED.k_t
    expected = [
        SLANTED.force[r]
        - sum((k_n * n[r] * n[c] + k_t * ((r == c) - n[r] * n[c])) * d[c] for c in range(3))
        for r in range(3)
    ]  # fmt: skip
    x = tuple(a + b for a, b in zip(SLANTED.at, d, strict=True))
    assert force_at(SLANTED, x, CAP) == pytest.approx(expected, abs=1e-12)


def test_a_surface_pushes_and_never_pulls() -> None:
    heights = [i * 1e-4 for i in range(-100, 101)]
    pushes = [force_at(wall(force=1.2), (0.0, 0.0, z), CAP)[2] for z in heights]
    assert min(pushes) == 0.0
    assert pushes == pytest.approx([max(1.2 - 600 * z, 0.0) for z in heights], abs=1e-12)


def test_a_gap_has_no_force_until_it_ends() -> None:
    gap = wall(gap=0.002)
    assert force_at(gap, (0.0, 0.0, -0.002), CAP) == ZERO
    assert force_at(gap, (0.0, 0.0, -0.003), CAP)[2] == pytest.approx(0.6)


def test_no_stiffness_above_the_cap_is_rendered() -> None:
    assert force_at(wall(k=9130.0), (0.0, 0.0, -0.001), 640.0)[2] == pytest.approx(0.64)


def test_friction_holds_no_more_than_its_cone() -> None:
    dragged = replace(SLANTED, friction=0.5)
    fx, fy, fz = force_at(dragged, (0.2, 0.02, 0.03), CAP)
    push = 0.6 * fy + 0.8 * fz
    assert math.hypot(fx, fy - 0.6 * push, fz - 0.8 * push) == pytest.approx(0.5 * push)


def test_the_largest_stiffness_is_that_of_the_design() -> None:
    """0.8 b / (T/2 + t_d): b = 2 N s/m, T = 1 ms; with a delay of 0.7 ms 1331 N/m."""
    assert stiffness_cap(2.0, 1e-3, 0.702e-3) == pytest.approx(1331, abs=1)


def test_an_old_contact_fades_between_100_and_200_ms() -> None:
    assert [fade(age) for age in (0.0, 0.1, 0.15, 0.2, 5.0)] == pytest.approx([1, 1, 0.5, 0, 0])


def test_a_contact_from_the_future_is_of_another_clock() -> None:
    assert fade(-1.0) == 0.0


@pytest.mark.parametrize(
    "change",
    [
        {"force": (math.nan, 0, 0)}, {"at": (0, math.inf, 0)}, {"force": (0, 0, 1e9)}, {"at": (1e9, 0, 0)},
        {"normal": (0, 0, 2.0)}, {"normal": (0, 0, 0)}, {"k_n": -1.0}, {"k_n": math.inf}, {"gap": math.nan},
        {"k_t": 1e300}, {"friction": -0.1}, {"stamp": math.nan},
    ],
)  # fmt: skip
def test_a_contact_that_is_not_of_this_world_is_refused(change: dict[str, object]) -> None:
    assert is_sane(wall())
    assert not is_sane(replace(wall(), **change))


def test_a_new_contact_changes_the_force_without_a_jump_and_wholly_within_a_period() -> None:
    blend, x, period = ContactBlend(), (0.0, 0.0, -0.002), 0.016
    forces = []
    for i in range(160):
        now = i * 1e-3
        if i % 16 == 0:  # the simulation finds the wall stiffer and stiffer
            blend.take(wall(now, k=100.0 * (i // 16)), x, now, CAP)
        forces.append(blend.force(x, now, CAP)[2])
    step = 100.0 * 0.002
    assert max(abs(b - a) for a, b in zip(forces, forces[1:], strict=False)) <= 1.01 * step / (period / 1e-3)
    assert forces[-1] == pytest.approx(9 * step * 1.0, rel=0.1)


def test_a_contact_that_is_taken_away_lets_go_within_a_period_and_does_not_pull() -> None:
    blend, x = ContactBlend(), (0.0, 0.0, -0.002)
    blend.take(wall(0.0), x, 0.0, CAP)
    blend.take(wall(0.084), x, 0.084, CAP)
    blend.take(None, x, 0.1, CAP)
    forces = [blend.force(x, 0.1 + i * 1e-3, CAP) for i in range(20)]
    assert forces[0][2] == pytest.approx(1.2)
    assert all(force[2] >= 0 for force in forces)
    assert length(forces[-1]) == 0.0
