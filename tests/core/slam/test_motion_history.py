import numpy as np
import pytest

from core.geometry import Pose, arc
from core.perception.landmarks.landmarks import Sighting
from core.slam.motion import Increment, MotionSettings, rolled
from core.slam.motion_history import SPAN_S, MotionHistory, carried

MOTION = MotionSettings()
STEP = 0.1


def history(turn: float = 0.06, steps: int = 15) -> MotionHistory:
    """An even drive from time 0 on, told every tenth of a second."""
    moves = MotionHistory()
    moves.add(0.0, Increment())
    for number in range(1, steps + 1):
        moves.add(STEP * number, rolled(arc(0.03, turn), STEP, MOTION))
    return moves


@pytest.mark.parametrize(("start", "end"), [(0.0, 1.5), (0.3, 0.7), (0.34, 0.36), (0.25, 1.13), (0.5, 0.5)])
def test_an_even_drive_is_known_between_any_two_times(start: float, end: float) -> None:
    move = history().between(start, end)
    assert move is not None
    assert np.allclose(move.pose.vector, arc(0.3 * (end - start), 0.6 * (end - start)).vector, atol=1e-9)


def test_two_moves_after_each_other_are_one() -> None:
    moves = history()
    first, second, both = moves.between(0.22, 0.9), moves.between(0.9, 1.41), moves.between(0.22, 1.41)
    assert first is not None
    assert second is not None
    assert both is not None
    joined = first.then(second)
    assert np.allclose(joined.pose.vector, both.pose.vector)
    assert np.allclose(joined.covariance, both.covariance, atol=1e-12)


def test_what_was_before_or_is_still_to_come_is_not_known() -> None:
    moves = history(steps=40)
    assert moves.between(3.9, 4.05) is None
    assert moves.between(4.0 - SPAN_S - 0.3, 4.0) is None
    assert moves.between(4.0 - SPAN_S + 0.05, 4.0) is not None


def test_after_a_jump_back_in_time_history_begins_anew() -> None:
    moves = history()
    moves.add(0.4, Increment())
    moves.add(0.5, Increment(Pose(0.1, 0.0, 0.0)))
    move = moves.between(0.4, 0.5)
    assert move is not None
    assert move.pose == Pose(0.1, 0.0, 0.0)
    assert moves.between(0.2, 0.5) is None


def test_a_sighting_that_is_carried_along_stays_where_it_is_and_knows_its_doubt() -> None:
    move = Increment(Pose(0.2, -0.1, 0.7), np.diag([4e-4, 1e-4, 9e-4]))
    noise = np.array([[4e-4, 1e-4], [1e-4, 2e-4]])
    seen = Sighting(range=2.0, bearing=0.4, covariance=noise, opening=1.0)
    told = carried(seen, move, 3.0)
    assert np.allclose(move.pose.apply(told.position[None])[0], seen.position)
    assert told.stamp == 3.0
    assert told.opening == pytest.approx(0.3)

    def at(off: np.ndarray) -> np.ndarray:
        reach, bearing = 2.0 + off[0], 0.4 + off[1]
        place = reach * np.array([np.cos(bearing), np.sin(bearing)])
        pose = Pose(*(move.pose.vector + off[2:]).tolist())
        x, y = pose.inverse().apply(place[None])[0]
        return np.array([np.hypot(x, y), np.arctan2(y, x)])

    step = 1e-6
    slope = np.column_stack([(at(step * unit) - at(-step * unit)) / (2 * step) for unit in np.eye(5)])
    whole = np.zeros((5, 5))
    whole[:2, :2], whole[2:, 2:] = noise, move.covariance
    assert np.allclose(told.covariance, slope @ whole @ slope.T, rtol=1e-6)
