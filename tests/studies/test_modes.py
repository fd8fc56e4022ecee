"""The lattice's modes are those of solid finite elements."""

import numpy as np
import pytest

from studies.body.modes import bodies, by_elements, by_lattice


@pytest.mark.parametrize("name", ["block", "block, free", "ball, free"])
def test_frequencies_and_sag_are_those_of_tetrahedra(name: str) -> None:
    body = bodies(fine=0.75)[name]
    (ours, sag), (theirs, fell) = by_lattice(body), by_elements(body)
    assert ours == pytest.approx(theirs, rel=0.10)
    assert sag[fell > 0] == pytest.approx(fell[fell > 0], rel=0.15)


@pytest.mark.slow
def test_a_ball_on_its_base_and_a_limb_with_a_bone_too() -> None:
    for name, far in (("ball", 0.10), ("limb with a bone", 0.20)):
        body = bodies()[name]
        (ours, sag), (theirs, fell) = by_lattice(body), by_elements(body)
        assert ours == pytest.approx(theirs, rel=far), name
        assert np.linalg.norm(sag) == pytest.approx(np.linalg.norm(fell), rel=0.2), name
