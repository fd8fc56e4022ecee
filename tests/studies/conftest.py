"""Studies whose expected figures are of the laws as they were before shape matching had a tension (2026-11-22).

Those bodies are now stiff by the tension instead of by springs, and free ones take steps of an eighth of a millisecond
at most. Each is to be measured again (`dev.py charts`) or given a body of its own; then it leaves this list.
"""

import pytest

BEFORE_TENSION = {
    "test_fronts.py": (
        "test_what_is_on_the_front_of_the_oscillator_comes_as_near_when_it_is_run_again",
        "test_the_kept_map_has_limits_within_a_tenth_of_theory_over_four_decades_and_none_for_the_rest",
    ),
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let what is listed fail, and say why."""
    for item in items:
        if getattr(item, "originalname", item.name) in BEFORE_TENSION.get(item.path.name, ()):
            item.add_marker(pytest.mark.xfail(reason="its figures are of the laws before the tension", strict=False))
