"""The landmark filter on the shared logs of sightings, with one and the same settings for all."""

from pathlib import Path

import numpy as np
import pytest
from _pytest.mark.structures import ParameterSet

from core.recording import Ids, victoria_park
from tests.benchmarks.log_scores import CORRIDOR, PARK, ROBOTS, aligned, score

pytestmark = pytest.mark.real_data


def campaign(*values: object) -> ParameterSet:
    """These are for `pytest -m campaign`."""
    return pytest.param(*values, marks=pytest.mark.campaign)


def test_the_best_turn_and_shift_is_found() -> None:
    rng = np.random.default_rng(0)
    points, angle = rng.normal(size=(50, 2)), 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    assert np.allclose(aligned(points, points @ turn.T + (3.0, -1.0)), points @ turn.T + (3.0, -1.0))


@pytest.mark.parametrize("logs", [ROBOTS[:1], campaign(ROBOTS[::2])], ids=["one", "three"])
def test_real_robots_are_followed_when_identities_are_given(shared_data: Path, logs: tuple[str, ...]) -> None:
    scores = [score(shared_data, log, "given") for log in logs]
    assert np.median([one.error for one in scores]) <= 0.20
    assert max(one.error for one in scores) <= 0.32
    assert {one.landmarks for one in scores} == {15}


@pytest.mark.parametrize(
    ("updates", "landmarks"), [(400, range(26, 30)), campaign(None, range(52, 57))], ids=["begun", "driven twice"]
)
def test_a_corridor_is_driven_without_identities_nearly_as_well_as_with_them(
    shared_data: Path, updates: int | None, landmarks: range
) -> None:
    given, hidden = (score(shared_data, CORRIDOR, ids, updates=updates) for ids in ("given", "hidden"))
    assert hidden.error <= 1.15 * given.error
    assert hidden.landmarks in landmarks
    assert hidden.nees <= 4.0


@pytest.mark.parametrize(
    ("updates", "ids", "error"),
    [(400, "given", 1.5), (400, "hidden", 2.0), campaign(None, "given", 4.5), campaign(None, "hidden", 15.0)],
)
def test_four_kilometres_through_a_park_are_driven_with_honest_doubt(
    shared_data: Path, updates: int | None, ids: Ids, error: float
) -> None:
    found = score(shared_data, PARK, ids, updates=updates)
    assert found.error <= error
    assert 1.0 <= found.nees <= 4.0


@pytest.mark.campaign
@pytest.mark.parametrize("noise", [0.03, 0.07, 0.09])
def test_the_park_does_not_hang_on_how_rough_the_car_s_turns_are_thought_to_be(
    shared_data: Path, noise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(victoria_park, "TURN_NOISE", noise)
    assert score(shared_data, PARK, "hidden").error <= 4.0
