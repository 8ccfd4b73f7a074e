import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.geometry import Pose, arc, wrap
from core.sensors import Wheels
from core.slam.dead_reckoning import DeadReckoning
from core.slam.motion import (
    Increment,
    MotionSettings,
    WheelTrack,
    control_jacobian,
    encoder_noise,
    paper_noise,
    rolled,
    steered,
    steered_jacobian,
)

small = st.floats(-1.0, 1.0)
STEP = 1e-6


def wheels(odometry: Pose) -> Wheels:
    return Wheels(odometry=odometry, speed=0.0, turn_rate=0.0)


def midpoint(forward: float, turn: float) -> np.ndarray:
    return np.array([forward * math.cos(turn / 2), forward * math.sin(turn / 2), turn])


def slope(function, at: tuple[float, float]) -> np.ndarray:
    columns = []
    for axis in range(2):
        high, low = list(at), list(at)
        high[axis] += STEP
        low[axis] -= STEP
        columns.append((function(*high) - function(*low)) / (2 * STEP))
    return np.column_stack(columns)


@given(small, small)
def test_the_control_jacobian_is_the_derivative_of_the_move(forward: float, turn: float) -> None:
    assert np.allclose(control_jacobian(forward, turn), slope(midpoint, (forward, turn)), atol=1e-8)


@given(small, st.floats(-0.6, 0.6))
def test_the_car_s_jacobian_is_the_derivative_of_its_move(speed: float, steer: float) -> None:
    settings = MotionSettings()

    def move(v: float, g: float) -> np.ndarray:
        pose = steered(v, g, 0.025, settings).pose
        return np.array([pose.x, pose.y, pose.heading])

    assert np.allclose(steered_jacobian(speed, steer, 0.025, 0.1), slope(move, (speed, steer)), atol=1e-8)


def test_the_car_goes_where_the_corrected_equation_says() -> None:
    move = steered(0.1, 0.2, 0.025, MotionSettings()).pose
    assert move.x == pytest.approx(0.1 * 0.025 * math.cos(0.2))
    assert move.y == pytest.approx(0.1 * 0.025 * math.sin(0.2))
    assert move.heading == pytest.approx(0.1 * 0.025 * math.sin(0.2) / 0.1)


@given(small, small, small, small, small, small)
@settings(max_examples=50)
def test_two_moves_as_one_carry_both_covariances(a: float, b: float, c: float, d: float, e: float, f: float) -> None:
    """The derivative of the joint move with the noise of either, by finite differences."""
    first, second = Pose(a, b, c), Pose(d, e, f)

    def joint(n: np.ndarray) -> np.ndarray:
        one = Pose(first.x + n[0], first.y + n[1], first.heading + n[2])
        two = Pose(second.x + n[3], second.y + n[4], second.heading + n[5])
        both = one @ two
        return np.array([both.x, both.y, both.heading])

    jacobian = np.zeros((3, 6))
    for axis in range(6):
        high, low = STEP * np.eye(6)[axis], -STEP * np.eye(6)[axis]
        difference = joint(high) - joint(low)
        difference[2] = wrap(difference[2])
        jacobian[:, axis] = difference / (2 * STEP)
    rng = np.random.default_rng(0)
    roots = [rng.normal(size=(3, 3)) for _ in range(2)]
    spread = np.zeros((6, 6))
    spread[:3, :3], spread[3:, 3:] = roots[0] @ roots[0].T, roots[1] @ roots[1].T
    both = Increment(first, spread[:3, :3]).then(Increment(second, spread[3:, 3:]))
    assert np.allclose(both.covariance, jacobian @ spread @ jacobian.T, atol=1e-6)


@given(small, small, st.floats(-3, 3))
def test_moves_compose_like_poses(x: float, y: float, heading: float) -> None:
    first, second = Increment(Pose(x, y, heading)), Increment(Pose(0.3, -0.1, 0.4))
    assert first.then(second).pose == first.pose @ second.pose
    assert np.allclose(first.then(Increment()).pose.vector, first.pose.vector, atol=1e-12)


def test_wheels_that_stand_add_nothing() -> None:
    for model in ("encoder", "paper"):
        step = rolled(Pose(), 0.025, MotionSettings(model=model))
        assert step.still
        assert not step.covariance.any()


@pytest.mark.parametrize("model", ["encoder", "paper"])
@given(st.floats(-0.1, 0.1), st.floats(-0.5, 0.5))
@settings(max_examples=30)
def test_covariances_are_symmetric_and_not_negative(model: str, forward: float, turn: float) -> None:
    spread = rolled(arc(forward, turn), 0.025, MotionSettings(model=model)).covariance  # type: ignore[arg-type]
    assert np.allclose(spread, spread.T)
    assert np.linalg.eigvalsh(spread).min() > -1e-12


def test_backing_up_is_as_uncertain_as_going_ahead() -> None:
    ahead, back = (rolled(arc(way, 0.0), 0.025, MotionSettings()).covariance for way in (0.01, -0.01))
    assert np.allclose(np.diag(ahead), np.diag(back))


def test_encoder_noise_is_what_two_slipping_wheels_do() -> None:
    settings, rng = MotionSettings(way_sd=0.0), np.random.default_rng(0)
    forward, turn = 0.05, 0.4
    wheels = np.array([forward - 0.05 * turn, forward + 0.05 * turn])
    slips = settings.wheel_sd * np.sqrt(np.abs(wheels)) * rng.normal(size=(200000, 2))
    moves = np.column_stack((slips.sum(axis=1) / 2, (slips[:, 1] - slips[:, 0]) / settings.wheelbase))
    assert np.allclose(np.cov(moves.T), encoder_noise(forward, turn, 0.025, settings), rtol=0.02)


def test_paper_noise_grows_with_the_number_of_control_steps() -> None:
    one, four = (paper_noise(0.01, 0.0, elapsed, MotionSettings()) for elapsed in (0.025, 0.1))
    assert np.allclose(4 * one, four)
    assert math.sqrt(one[0, 0]) == pytest.approx(0.2 * 0.025)


def test_frames_that_were_lost_lose_no_way() -> None:
    rng = np.random.default_rng(1)
    odometry, poses = Pose(), []
    for _ in range(60):
        odometry = odometry @ arc(0.003, float(rng.normal(0, 0.02)))
        poses.append(odometry)
    ends = []
    for every in (1, 5):
        reckoning, track = DeadReckoning(), WheelTrack()
        for index in range(0, 60, every):
            reckoning.update(track.step(0.025 * index, wheels(poses[index])))
        ends.append(reckoning.update(track.step(1.5, wheels(poses[-1]))).pose)
    assert np.allclose(ends[0].vector, ends[1].vector, atol=1e-12)


def test_a_seek_backwards_is_no_move() -> None:
    track = WheelTrack()
    track.step(5.0, wheels(Pose(3.0, 1.0, 0.5)))
    assert track.step(1.0, wheels(Pose())).still
    assert track.step(1.1, wheels(Pose(0.1, 0.0, 0.0))).pose.x == pytest.approx(0.1)


def test_dead_reckoning_only_gets_less_sure() -> None:
    reckoning, track, odometry, last = DeadReckoning(), WheelTrack(), Pose(), 0.0
    for index in range(100):
        odometry = odometry @ arc(0.0025, 0.01)
        estimate = reckoning.update(track.step(0.025 * index, wheels(odometry)))
        spread = float(np.trace(estimate.covariance[:2, :2]))
        assert spread >= last
        last = spread
    still = reckoning.update(track.step(10.0, wheels(odometry)))
    assert np.array_equal(still.covariance, estimate.covariance)
