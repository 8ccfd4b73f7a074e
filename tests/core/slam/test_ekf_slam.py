import math
from typing import Literal

import numpy as np
import pytest

from core.geometry import Pose, arc, wrap
from core.perception.landmarks.landmarks import Sighting
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.slam.ekf_slam import EkfSettings
from core.slam.motion import Increment
from tests.core.slam.frame_slam import FrameSlam

SPREAD = np.diag([0.02**2, math.radians(0.5) ** 2])
ROOM = [(2.0, 1.5), (2.0, -1.5), (-1.5, 1.2), (0.5, 2.0), (3.0, 0.2), (1.0, -2.2), (3.5, 1.8), (-0.5, -1.8)]
MODES: list[Literal["invariant", "paper"]] = ["invariant", "paper"]


def seen_from(
    pose: Pose, places: list[tuple[float, float]], rng: np.random.Generator | None = None, kind: str = ""
) -> list[Sighting]:
    noise = np.zeros((len(places), 2)) if rng is None else rng.normal(0, (0.02, math.radians(0.5)), (len(places), 2))
    return [
        Sighting(
            range=pose.distance_to(x, y) + off[0],
            bearing=wrap(pose.bearing_to(x, y) + off[1]),
            covariance=SPREAD,
            kind=kind,
        )
        for (x, y), off in zip(places, noise, strict=True)
    ]


def frame(stamp: float, odometry: Pose, scan: Scan | None = None) -> SensorFrame:
    return SensorFrame(stamp=stamp, wheels=Wheels(odometry=odometry, speed=0.0, turn_rate=0.0), scan=scan)


def open_view(distance: float) -> Scan:
    laser = Laser()
    return Scan(
        stamp=0.0, ranges=np.full(laser.beams, distance), angle_min=laser.angle_min, angle_step=laser.angle_step
    )


@pytest.mark.parametrize("mode", MODES)
def test_a_drive_around_a_room_is_known_far_better_than_by_the_wheels(mode: Literal["invariant", "paper"]) -> None:
    errors, reckoned, nees = [], [], []
    for seed in range(3):
        rng, slam = np.random.default_rng(seed), FrameSlam(EkfSettings(mode=mode))
        truth = odometry = Pose()
        for index in range(300):
            if index > 10:
                truth = truth @ arc(0.02, 0.03)
                odometry = odometry @ arc(0.02 + rng.normal(0, 0.0006), 0.03 + rng.normal(0, 0.003))
            slam.update(frame(0.1 * index, odometry), seen_from(truth, ROOM, rng))
            errors.append(slam.estimate.pose.distance_to(truth.x, truth.y))
            reckoned.append(odometry.distance_to(truth.x, truth.y))
            nees += [slam.nees(truth)] if index > 20 else []
        assert len(slam.landmarks) == len(ROOM)
        for landmark in slam.landmarks:
            assert min(math.hypot(landmark.position[0] - x, landmark.position[1] - y) for x, y in ROOM) < 0.05
    assert max(errors) < 0.04
    assert np.mean(errors) < 0.3 * np.mean(reckoned)
    assert 1.0 < np.mean(nees) < 5.0


def test_a_few_landmarks_are_believed_at_once_and_later_ones_after_three_hits() -> None:
    slam = FrameSlam()
    slam.see(seen_from(Pose(), ROOM[:6]))
    assert len(slam.landmarks) == 6
    late = seen_from(Pose(), ROOM)
    slam.see(late)
    assert len(slam.landmarks) == 6
    assert slam.health.tentative == 2
    slam.see(late)
    assert len(slam.landmarks) == 6
    slam.see(late)
    assert len(slam.landmarks) == 8
    assert slam.health.tentative == 0
    assert {landmark.hits for landmark in slam.landmarks[6:]} == {3}


def test_on_probation_a_landmark_does_not_touch_the_pose() -> None:
    slam = FrameSlam(EkfSettings(at_once=0))
    slam.see(seen_from(Pose(), ROOM[:2]))
    slam.advance(Increment(Pose(0.2, 0.0, 0.0), 1e-3 * np.eye(3)))
    before = slam.estimate
    slam.see(seen_from(Pose(0.22, 0.0, 0.0), ROOM[:2]))
    assert slam.estimate.pose == before.pose
    assert np.allclose(slam.estimate.covariance, before.covariance)
    slam.see(seen_from(Pose(0.22, 0.0, 0.0), ROOM[:2]))
    assert slam.estimate.pose.x > 0.21


def test_a_tentative_landmark_that_is_not_seen_again_goes() -> None:
    slam = FrameSlam(EkfSettings(at_once=1, patience=5))
    slam.see(seen_from(Pose(), ROOM[:2]))
    for index in range(8):
        slam.advance(Increment(Pose(0.01, 0.0, 0.0), 1e-6 * np.eye(3)))
        slam.see(seen_from(Pose(0.01 * (index + 1), 0.0, 0.0), ROOM[:1]))
    assert slam.health.tentative == 0
    assert len(slam.filter.places) == 1


def test_what_is_seen_through_is_suppressed_and_what_is_hidden_stays() -> None:
    for distance, left in ((5.0, 1), (1.0, 2)):
        slam = FrameSlam(EkfSettings(still_every=1), laser=Laser())
        places = [(2.0, 0.8), (2.0, -0.8)]
        for _ in range(4):
            slam.update(frame(0.0, Pose()), seen_from(Pose(), places))
        for _ in range(12):
            slam.update(frame(0.1, Pose(), open_view(distance)), seen_from(Pose(), places[:1]))
        assert len(slam.landmarks) == left
        assert max(landmark.misses for landmark in slam.landmarks) == 0


def test_standing_wheels_add_no_uncertainty() -> None:
    slam = FrameSlam()
    slam.update(frame(0.0, Pose()))
    for index in range(1, 41):
        slam.update(frame(0.025 * index, arc(0.0025 * index, 0.0)))
    moved = slam.estimate
    for index in range(41, 200):
        slam.update(frame(0.025 * index, arc(0.1, 0.0)))
    assert np.array_equal(slam.estimate.covariance, moved.covariance)
    assert slam.estimate.pose == moved.pose


def test_the_robot_looks_around_until_ten_scans_were_taken_at_rest() -> None:
    slam = FrameSlam(laser=Laser())
    for index in range(10):
        assert slam.health.looking_around
        slam.update(frame(0.1 * index, Pose()), seen_from(Pose(), ROOM))
    assert not slam.health.looking_around


def test_a_robot_that_moves_anyway_need_not_wait_for_ever() -> None:
    slam = FrameSlam(laser=Laser())
    slam.update(frame(0.0, Pose()))
    slam.update(frame(0.1, arc(0.2, 0.0)), seen_from(arc(0.2, 0.0), ROOM))
    assert not slam.looking_around


def test_at_rest_only_some_scans_count_after_the_first_ten() -> None:
    slam = FrameSlam(EkfSettings(still_scans=10, still_every=5))
    for index in range(30):
        slam.update(frame(0.1 * index, Pose()), seen_from(Pose(), ROOM))
    assert slam.health.updates == 10 + 4


def test_one_wild_sighting_is_softened_and_does_not_carry_the_robot_away() -> None:
    slam = FrameSlam()
    for _ in range(5):
        slam.see(seen_from(Pose(), ROOM))
    slam.advance(Increment(Pose(0.1, 0.0, 0.0), 1e-4 * np.eye(3)))
    sightings = seen_from(Pose(0.1, 0.0, 0.0), ROOM)
    sightings[0] = seen_from(Pose(0.1, 0.0, 0.0), [(ROOM[0][0] + 0.09, ROOM[0][1])])[0]
    slam.see(sightings)
    assert slam.estimate.pose.distance_to(0.1, 0.0) < 0.005


def test_doubles_join_unless_they_were_seen_at_once() -> None:
    apart = [(2.0, 0.0), (2.0, 0.05)]
    for together in (False, True):
        slam = FrameSlam(EkfSettings(double_reach=0.3))
        for _ in range(3):
            slam.see(seen_from(Pose(), [*ROOM[:1], *(apart if together else apart[:1])]))
        if not together:
            slam.filter.add(np.array([2.0, 0.025]), 4 * SPREAD)
            slam.table.add(seen_from(Pose(), apart[1:])[0], 0.0)
        before = len(slam.table)
        for _ in range(3):
            slam.see(seen_from(Pose(), [*ROOM[:1], *(apart if together else apart[:1])]))
        assert len(slam.table) == (before if together else before - 1)


def test_identities_that_are_known_are_used() -> None:
    rng, slam = np.random.default_rng(0), FrameSlam()
    for index in range(20):
        sightings = [
            Sighting(range=s.range, bearing=s.bearing, covariance=s.covariance, id=100 + k)
            for k, s in enumerate(seen_from(Pose(), [(2.0, 0.0), (2.0, 0.01)], rng))
        ]
        slam.update(frame(0.1 * index, Pose()), sightings)
    assert len(slam.landmarks) == 2


def test_kinds_keep_corners_apart() -> None:
    slam = FrameSlam()
    for _ in range(4):
        slam.see([*seen_from(Pose(), [(2.0, 0.0)], kind="convex"), *seen_from(Pose(), [(2.0, 0.12)], kind="concave")])
    assert sorted(landmark.kind for landmark in slam.landmarks) == ["concave", "convex"]


def test_the_running_nis_is_about_one() -> None:
    rng, slam = np.random.default_rng(0), FrameSlam(EkfSettings(still_every=1))
    for index in range(200):
        slam.update(frame(0.1 * index, Pose()), seen_from(Pose(), ROOM, rng))
    nis = slam.health.nis
    assert nis is not None
    assert 0.7 < nis < 1.3


def test_every_sighting_has_a_fate() -> None:
    slam = FrameSlam()
    slam.see(seen_from(Pose(), ROOM))
    assert {association.fate for association in slam.associations} == {"new"}
    beside = [(ROOM[0][0] + 0.1, ROOM[0][1])]  # too near to be another one, and that one is seen itself
    slam.see([*seen_from(Pose(), ROOM), *seen_from(Pose(), beside)])
    fates = [association.fate for association in slam.associations]
    assert fates.count("matched") == 6
    assert fates.count("tentative") == len(ROOM) - 6
    assert fates[-1] == "ignored"
    assert np.allclose(slam.associations[-1].position, beside[0], atol=1e-6)


def test_the_paper_s_measurement_noise_is_a_setting() -> None:
    surer, paper = FrameSlam(), FrameSlam(EkfSettings(mode="paper", sighting_noise="paper"))
    for slam in (surer, paper):
        slam.see(seen_from(Pose(), ROOM[:1]))
    wide = paper.landmarks[0].covariance
    reach = math.hypot(*ROOM[0])
    assert np.sqrt(np.linalg.eigvalsh(wide)) == pytest.approx(sorted((0.08, reach * math.radians(1))))
    assert np.trace(surer.landmarks[0].covariance) < np.trace(wide)


def test_what_was_believed_at_once_and_never_seen_again_is_not_in_the_map_but_kept() -> None:
    slam, ghost = FrameSlam(EkfSettings(still_every=1)), (1.5, 0.5)
    slam.see(seen_from(Pose(), [*ROOM[:4], ghost]))
    assert len(slam.landmarks) == 5
    for _ in range(slam.settings.patience + 1):
        slam.see(seen_from(Pose(), ROOM[:4]))
    assert len(slam.landmarks) == 4
    slam.see(seen_from(Pose(), [*ROOM[:4], ghost]))
    assert len(slam.landmarks) == 5
