"""A person who stands and calls, heard by bearings alone while the robot drives to and fro on poor wheels."""

import math

import numpy as np
import pytest

from core.geometry import Pose, arc
from core.perception.landmarks.frame_perception import BearingSet
from core.slam.bearings.bearing_landmarks import BearingLandmarks, VoiceLandmarkSettings
from core.slam.ekf.invariant import InvariantFilter
from core.slam.motion import Increment, MotionSettings, rolled

WHEELS = MotionSettings(way_sd=0.1, wheel_sd=0.0008)
SEEDS = range(4)
HEARD = math.radians(4)  # sd that the microphones claim, beside the settings' own


def heard(step: int, bearing: float) -> BearingSet:
    return BearingSet(
        stamp=0.1 * step, eye=Pose(), bearings=np.array([bearing]), sds=np.array([HEARD]), looks=np.zeros(1)
    )


def walk(seed: int, used: bool, walks_from: int = 10**9) -> tuple[float, float, BearingLandmarks]:
    """Mean error [m] and NEES of a drive of 60 s around a person, who walks off at step `walks_from`."""
    rng = np.random.default_rng(seed)
    state, truth = InvariantFilter(), Pose()
    voices = BearingLandmarks(state, VoiceLandmarkSettings(used=used))
    errors, nees = [], []
    for step in range(600):
        place = (0.3 + 0.04 * max(0, step - walks_from), 1.3)
        move = arc(0.02, 0.02 / 1.2)
        increment = rolled(move, 0.1, WHEELS)
        truth = truth @ move
        felt = Pose(*(move.vector + rng.multivariate_normal(np.zeros(3), increment.covariance)))
        state.predict(Increment(felt, increment.covariance))
        if step % 5 == 0:
            sd = math.hypot(HEARD, VoiceLandmarkSettings().floor)
            bearing = truth.bearing_to(*place) + rng.normal(0, sd)
            voices.see(heard(step, bearing))
        state.settle()
        error = state.error(truth)
        errors.append(truth.distance_to(state.pose.x, state.pose.y))
        nees.append(float(error @ np.linalg.solve(state.covariance.block(0, 3) + 1e-12 * np.eye(3), error)))
    return float(np.mean(errors)), float(np.mean(nees[50:])), voices


@pytest.mark.campaign
def test_a_person_who_calls_holds_the_robot_s_place_and_the_filter_stays_honest() -> None:
    ears = [walk(seed, True) for seed in SEEDS]
    deaf = [walk(seed, False) for seed in SEEDS]
    assert np.mean([one[0] for one in ears]) < 0.8 * np.mean([one[0] for one in deaf])
    assert np.mean([one[1] for one in ears]) < 4.5  # mean of 3 over 4 drives, whose errors last
    assert all(one[2].used > 20 for one in ears)


def test_a_person_who_walks_off_does_not_take_the_robot_along() -> None:
    walked = np.mean([walk(seed, True, walks_from=300)[0] for seed in (1, 2)])
    assert walked < 1.2 * np.mean([walk(seed, False)[0] for seed in (1, 2)])


def test_nothing_is_made_of_bearings_from_one_place() -> None:
    state = InvariantFilter()
    voices = BearingLandmarks(state, VoiceLandmarkSettings(used=True))
    for step in range(50):
        voices.see(heard(step, 0.4))
    assert not voices.landmarks and state.pose == Pose() and len(state.places) == 0


def test_what_is_interrupted_leaves_no_pose_behind() -> None:
    state = InvariantFilter()
    voices = BearingLandmarks(state, VoiceLandmarkSettings(used=True))
    for step in range(20):
        state.predict(Increment(Pose(0.05, 0.0, 0.0), 1e-6 * np.eye(3)))
        voices.see(heard(step, 0.1))
    assert state.attached
    voices.interrupt()
    assert len(state.attached) == len(voices.landmarks)


def test_switched_off_it_touches_nothing() -> None:
    _, _, voices = walk(0, used=False)
    assert voices.used == 0 and not voices.landmarks


def test_a_landmark_is_made_by_the_views_between_which_the_odometry_is_sure() -> None:
    """First a long and unsure way, whose ends differ most in direction; then two short and sure ones."""
    state = InvariantFilter()
    voices = BearingLandmarks(state, VoiceLandmarkSettings(used=True))
    place, x = (4.0, 1.0), 0.0
    for number, (way, sd) in enumerate(((0.0, 0.0), (3.0, 0.6), (0.5, 0.02), (0.5, 0.02), (0.5, 0.02))):
        state.predict(Increment(Pose(way, 0.0, 0.0), np.diag([sd**2, 1e-4, 1e-6])))
        x += way
        voices.see(heard(10 * number, math.atan2(place[1], place[0] - x)))
    assert len(voices.landmarks) == 1
    assert np.allclose(voices.places()[0], place, atol=0.1)


def test_words_that_are_judged_once_more_go_on_with_their_direction() -> None:
    state = InvariantFilter()
    voices = BearingLandmarks(state, VoiceLandmarkSettings(used=True))
    voices.see(heard(10, 0.4))
    tracks = list(voices._tracks)
    for step in (20, 14, 21):
        voices.see(heard(step, 0.4))
    assert voices._tracks == tracks
