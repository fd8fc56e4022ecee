"""Where the fingertips are, and which torques push there."""

import math
import random
import re

import numpy as np
import pytest

from core.vectors import Vector
from studies.bench import kinematics, linkage
from studies.bench.kinematics import Block
from studies.bench.linkage import Singular, Unreachable
from studies.bench.numbers import HAPTIC_MASTER, load_emulated
from tests.haptics.converters import adc_words

SPEC = load_emulated()
BLOCKS = kinematics.blocks(SPEC)


def places(n: int, radius: float = SPEC.workspace_radius) -> list[Vector]:
    """Return places in the workspace, half of them on its surface, where it is worst."""
    dice = random.Random(5)
    found = []
    for i in range(n):
        way = [dice.gauss(0, 1) for _ in range(3)]
        factor = radius * (1.0 if i % 2 else dice.random() ** (1 / 3)) / math.hypot(*way)
        found.append((way[0] * factor, way[1] * factor, way[2] * factor))
    return found


PLACES = places(2000)


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.name)
def test_the_inverse_brings_every_fingertip_back_to_its_place(block: Block) -> None:
    """Closed form: to rounding."""
    for p in PLACES:
        assert math.dist(kinematics.forward(block, linkage.inverse(block, p)), p) < 1e-12


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.name)
def test_every_converter_spans_the_whole_workspace(block: Block) -> None:
    """To the mechanical stops, with 5 degrees to spare (at its end a converter counts as broken), and no finer."""
    farthest = max(
        abs(angle - centre)
        for p in places(2000, SPEC.stop_radius)
        for angle, centre in zip(linkage.inverse(block, p), SPEC.adc_centres, strict=True)
    )
    assert 0.75 * SPEC.adc_span / 2 < farthest < SPEC.adc_span / 2 - math.radians(5)


def test_the_jacobian_is_the_derivative_of_the_place() -> None:
    """Central differences; their own error is of the order h^2 = 1e-10."""
    h = 1e-5
    for block in BLOCKS:
        for p in PLACES[:100]:
            q = linkage.inverse(block, p)
            rows = kinematics.jacobian(block, q)
            for j in range(3):
                ahead, behind = list(q), list(q)
                ahead[j] += h
                behind[j] -= h
                a, b = kinematics.forward(block, tuple(ahead)), kinematics.forward(block, tuple(behind))
                for i in range(3):
                    assert (a[i] - b[i]) / (2 * h) == pytest.approx(rows[i][j], abs=1e-9)


def test_torques_do_the_work_of_the_force() -> None:
    """tau . dq = F . dp for every motion."""
    dice = random.Random(2)
    for block in BLOCKS:
        for p in PLACES[:200]:
            q, force, rates = linkage.inverse(block, p), rand3(dice), rand3(dice)
            velocity = np.array(kinematics.jacobian(block, q)) @ rates
            tau = kinematics.torques(block, q, force)
            assert np.dot(tau, rates) == pytest.approx(np.dot(force, velocity), abs=1e-12)
            assert math.dist(linkage.force(block, q, tau), force) < 1e-11


def rand3(dice: random.Random) -> Vector:
    return dice.uniform(-10, 10), dice.uniform(-10, 10), dice.uniform(-10, 10)


def test_nowhere_in_the_workspace_is_a_block_near_singular() -> None:
    """The worst place is the farthest from the base, 0.55 m away: 4.2 to the digits of the design (4.231)."""

    def condition(block: kinematics.Block, place: Vector) -> float:
        return float(np.linalg.cond(kinematics.jacobian(block, linkage.inverse(block, place))))

    worst = max(condition(block, p) for block in BLOCKS for p in PLACES)
    assert worst <= 4.25
    far = condition(BLOCKS[0], (SPEC.workspace_radius, 0.0, 0.0))
    assert round(far, 1) == 4.2 and worst <= far


def test_the_converters_resolve_eight_hundredths_of_a_millimetre() -> None:
    """Root mean square over the workspace of |tip read - tip|, 12 bits over 120 degrees."""
    errors = []
    for block in BLOCKS:
        for p in places(4000)[::2]:  # inside, evenly
            q = kinematics.adc_angles(SPEC, adc_words(SPEC, linkage.inverse(block, p)))
            errors.append(math.dist(kinematics.forward(block, q), p))
    rms = 1e3 * math.sqrt(sum(e * e for e in errors) / len(errors))
    assert rms == pytest.approx(0.08, abs=0.005)


def test_a_converter_is_right_within_half_a_step_and_holds_at_its_ends() -> None:
    step = SPEC.adc_span / (1 << SPEC.adc_bits)
    dice = random.Random(4)
    for _ in range(1000):
        q = tuple(centre + dice.uniform(-0.5, 0.5) * SPEC.adc_span for centre in SPEC.adc_centres)
        words = adc_words(SPEC, q)
        assert all(word % 16 == 0 for word in words)
        for read, true in zip(kinematics.adc_angles(SPEC, words), q, strict=True):
            assert abs(read - true) <= step / 2 + 1e-12
    assert adc_words(SPEC, (-9.0, 9.0, -9.0)) == (0, 0xFFF0, 0)


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.name)
def test_the_motors_reach_the_peak_force_everywhere_in_the_workspace(block: Block) -> None:
    """10 N in any direction: no joint needs more than its motor has, and the weakest nearly all of it."""
    dice, largest = random.Random(6), 0.0
    for p in PLACES[:500]:
        way = rand3(dice)
        factor = SPEC.peak_force / math.hypot(*way)
        push = (way[0] * factor, way[1] * factor, way[2] * factor)
        tau = kinematics.torques(block, linkage.inverse(block, p), push)
        largest = max(largest, *(abs(part) / limit for part, limit in zip(tau, SPEC.torque_limits, strict=True)))
    assert 0.8 < largest <= 1.0


def test_singular_and_unreachable_places_are_named() -> None:
    block = BLOCKS[0]
    x, y, z = block.base
    with pytest.raises(Unreachable, match="thumb cannot reach"):
        linkage.inverse(block, (x + 0.6, y, z))
    with pytest.raises(Singular, match="one line"):
        linkage.inverse(block, (x + block.l1 + block.l2 - 1e-12, y, z))
    with pytest.raises(Singular, match="axis"):
        linkage.inverse(block, (x, y, z + 0.3))
    with pytest.raises(Singular, match="one line"):
        linkage.force(block, (0.0, 0.5, 0.5), (1.0, 0.0, 0.0))
    with pytest.raises(Singular, match="axis"):
        q1, q2 = math.acos(0.2 / block.l1), math.pi + math.acos(0.2 / block.l2)
        linkage.force(block, (0.0, q1, q2), (1.0, 0.0, 0.0))


def test_every_number_of_the_device_states_where_it_comes_from() -> None:
    lines = [line for line in HAPTIC_MASTER.read_text().splitlines() if "=" in line and not line.startswith("#")]
    numbers = [line for line in lines if re.search(r"= *\[?[\d.\"]", line) and not line.startswith("name ")]
    assert len(numbers) > 20 and len(numbers) == len(lines) - 1
    assert [line for line in numbers if not re.search(r"# \([APD]\)", line)] == []


def test_the_default_device_is_that_of_the_design() -> None:
    assert (SPEC.l1, SPEC.l2, SPEC.centre_distance, 2 * SPEC.workspace_radius) == (0.28, 0.30, 0.35, 0.40)
    assert (SPEC.peak_force, SPEC.continuous_force, SPEC.torque_limits) == (10.0, 4.0, (6.0, 3.2, 3.2))
    assert (SPEC.hold, SPEC.zero, SPEC.latch, SPEC.slew, SPEC.tip_speed) == (0.005, 0.025, 0.1, 1000.0, 1.5)
    assert (SPEC.tip_mass, SPEC.viscous, SPEC.coulomb, SPEC.tick_hz, SPEC.baud) == (0.12, 2.0, 0.2, 1000, 921600)
