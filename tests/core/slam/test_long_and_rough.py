"""Small versions of the benchmarks of consistency and of shocks."""

import dataclasses

import numpy as np
import pytest

from tests.benchmarks.consistency import MOTION, run_filter
from tests.benchmarks.filter_shocks import run as perturbed


@pytest.mark.campaign
@pytest.mark.parametrize(("times", "run", "most"), [(1.0, 0, 4.9), (2.0, 1, 9.0)])
def test_over_a_lap_of_600_metres_the_filter_stays_as_sure_as_it_should_be(
    times: float, run: int, most: float
) -> None:
    motion = dataclasses.replace(MOTION, speed_sd=times * MOTION.speed_sd, steer_sd=times * MOTION.steer_sd)
    squared, errors = run_filter(run, "invariant", motion, updates=1040)
    assert 1.0 < np.mean(squared) < most
    assert np.mean(errors) < 8.0 * times


@pytest.mark.parametrize("shock", ["names", "slip", "push"])
def test_after_a_shock_the_robot_is_found_again_and_the_map_stays_where_it_was(shock: str) -> None:
    outcome = perturbed(shock, 3)
    assert outcome.back <= 10.0
    assert outcome.worst < 0.06
    assert outcome.moved < 0.05
    assert (outcome.noticed > 0) is (shock != "names")


def test_without_a_shock_none_is_noticed() -> None:
    outcome = perturbed("none", 3)
    assert outcome.noticed == 0
    assert outcome.worst < 0.06
