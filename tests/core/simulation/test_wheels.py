"""What the simulated encoders say, against what the base did."""

import math

import numpy as np
import pytest

from core.geometry import Pose
from core.simulation.differential_drive import EncoderWheels, PaperWheels, PerfectWheels, SimulatedWheels

STEP = 0.025  # [s]


def drive(wheels: SimulatedWheels, forward: float, turn: float, frames: int) -> Pose:
    """The odometry after `frames` equal steps."""
    for _ in range(frames):
        wheels.roll(forward, turn)
        reading = wheels.read(STEP)
    return reading.odometry


def test_perfect_wheels_close_a_circle() -> None:
    end = drive(PerfectWheels(), 0.01, 2 * math.pi / 400, 400)
    np.testing.assert_allclose(end.vector, 0.0, atol=1e-9)


def test_speeds_are_what_was_rolled_since_the_last_reading() -> None:
    wheels = PerfectWheels()
    wheels.roll(0.001, 0.01)
    wheels.roll(0.002, 0.02)
    reading = wheels.read(STEP)
    assert (reading.speed, reading.turn_rate) == pytest.approx((0.12, 1.2))


@pytest.mark.parametrize("wheels", [EncoderWheels(np.random.default_rng(0)), PaperWheels(np.random.default_rng(0))])
def test_a_standing_robot_reports_exactly_no_motion(wheels: SimulatedWheels) -> None:
    before = drive(wheels, 0.0025, 0.01, 40)
    for _ in range(40):
        wheels.roll(0.0, 0.0)
        reading = wheels.read(STEP)
        assert (reading.speed, reading.turn_rate) == (0.0, 0.0)
    assert reading.odometry == before


def test_encoders_count_whole_ticks() -> None:
    wheels = EncoderWheels(
        np.random.default_rng(0), scale_error=0.0, mismatch=0.0, wheelbase_error=0.0, slip=0.0, tick=0.01
    )
    wheels.roll(0.0099, 0.0)
    assert wheels.read(STEP).odometry == Pose()
    wheels.roll(0.0002, 0.0)
    assert wheels.read(STEP).odometry.x == pytest.approx(0.01)


def test_slip_grows_with_the_root_of_the_distance_whatever_the_steps() -> None:
    def spread(frames: int, forward: float) -> float:
        ends = [
            drive(
                EncoderWheels(np.random.default_rng(seed), scale_error=0, mismatch=0, wheelbase_error=0, slip=0.002),
                forward,
                0.0,
                frames,
            ).heading
            for seed in range(150)
        ]
        return float(np.std(ends))

    expected = 0.002 * math.sqrt(2 * 1.0) / 0.10
    assert spread(10, 0.1) == pytest.approx(expected, rel=0.2)
    assert spread(40, 0.025) == pytest.approx(expected, rel=0.2)


def test_encoders_drift_by_centimetres_and_degrees_over_ten_metres() -> None:
    ends = [drive(EncoderWheels(np.random.default_rng(seed)), 0.05, 0.0, 200) for seed in range(60)]
    along = np.std([end.x for end in ends])
    heading = np.degrees(np.std([end.heading for end in ends]))
    assert 0.01 < along < 0.06
    assert 1.0 < heading < 4.0


def test_the_papers_noise_has_the_papers_size() -> None:
    """Eq. 43: 0.2 m/s every 25 ms over 1280 steps of cruise are 0.18 m; 1° of steer turns as at cruising speed."""
    ends = [drive(PaperWheels(np.random.default_rng(seed)), 0.0025, 0.0, 1280) for seed in range(60)]
    assert np.std([end.x for end in ends]) == pytest.approx(0.2 * STEP * math.sqrt(1280), rel=0.25)
    turn = 0.1 * math.sin(math.radians(1)) / 0.1 * STEP
    assert np.std([end.heading for end in ends]) == pytest.approx(turn * math.sqrt(1280), rel=0.25)
