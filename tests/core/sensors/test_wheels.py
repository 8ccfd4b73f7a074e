"""A base that was restarted is told from one that moved."""

import numpy as np
import pytest

from core.geometry import Pose, arc
from core.sensors.wheels import is_restart

RNG = np.random.default_rng(20)
PLACES = [Pose(*RNG.uniform((-4, -4, -3), (4, 4, 3))) for _ in range(46)]
SPOTS = [Pose(0.0, 0.0, 1.57), Pose(0.0, 0.0, -0.5), Pose(0.15, 0.0, 0.0), Pose(3.0, 0.5, 1.57)]


@pytest.mark.parametrize("silence", [0.5, 1.5, 8.0])
def test_fifty_restarts_anywhere_are_no_motion(silence: float) -> None:
    drift = Pose(0.003, 0.0, 0.005)
    assert [place for place in (*PLACES, *SPOTS) if not is_restart(place, drift, silence)] == []


@pytest.mark.parametrize("silence", [0.0, 0.05, 0.2])
def test_a_base_that_is_back_at_its_origin_sooner_than_it_can_drive_there_was_restarted(silence: float) -> None:
    near = [Pose(0.5, 0.1, 2.6), Pose(-0.3, -0.3, 0.0), Pose(0.0, 0.0, 1.2)]
    assert [place for place in (*PLACES, *near) if not is_restart(place, Pose(0.003, 0.0, 0.005), silence)] == []


@pytest.mark.parametrize("rate", [2.0, 5.0, 10.0, 40.0])
@pytest.mark.parametrize("speed", [0.3, 1.5])
def test_a_healthy_drive_is_no_restart_even_with_a_gap_of_six_seconds(rate: float, speed: float) -> None:
    pose, last = Pose(), Pose()
    for step in range(int(60 * rate)):
        elapsed = 6.0 if step % 97 == 96 else 1 / rate
        turn_rate = 1.5 * np.sin(0.1 * step)
        pose = last @ arc(speed * elapsed, turn_rate * elapsed)
        assert not is_restart(last, pose, elapsed) or (elapsed > 1 and abs(pose.x) < 0.02 and abs(pose.y) < 0.02)
        last = pose
