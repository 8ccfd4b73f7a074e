import math

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import Pose, wrap
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.frame_perception import Beams
from core.slam.map.occupancy import OccupancyGrid
from core.slam.relocalization.kidnap_detector import KidnapDetector, LocalizationEvidence, WidenedWalls
from core.slam.relocalization.recovery import UNCHECKED_SD_M, Click, RecoveredPose, Recovery
from core.slam.relocalization.search_pyramid import ScanView
from tests.core.slam.carried_scenes import LAB, LASER, OBLONG, anywhere, carry, mapped, robot, seen

EMPTY = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))


@pytest.fixture(scope="module")
def lab() -> OccupancyGrid:
    return mapped(LAB)


def stand(finding: Recovery, view: ScanView, frames: int, start: float = 0.0) -> RecoveredPose | None:
    """So many frames of standing with this view."""
    for frame in range(frames):
        found = finding.step(start + frame / 40, view.odometry, view if frame == 0 else None, False)
        if found is not None:
            return found
    return None


def test_a_match_that_stays_bad_for_a_second_is_being_lost() -> None:
    alarm = KidnapDetector()
    told = [alarm.observe(LocalizationEvidence(0.1 * n, match=0.2)) for n in range(11)]
    assert told == [False] * 10 + [True]
    assert alarm.doubt == "the scans do not fit what was seen just before"


def test_a_bad_match_that_passes_is_only_a_doubt() -> None:
    alarm = KidnapDetector()
    for n in range(8):
        assert not alarm.observe(LocalizationEvidence(0.1 * n, match=0.2))
    assert alarm.doubt
    assert not alarm.observe(LocalizationEvidence(0.8, match=0.9)) and not alarm.doubt
    assert not any(alarm.observe(LocalizationEvidence(0.9 + 0.1 * n, match=0.2)) for n in range(10))


def test_what_is_usual_with_a_noisy_laser_raises_no_doubt() -> None:
    alarm = KidnapDetector()
    for n in range(50):
        alarm.observe(LocalizationEvidence(0.1 * n, match=0.52, agreement=0.7))
    assert not any(alarm.observe(LocalizationEvidence(5 + 0.1 * n, match=0.42, agreement=0.55)) for n in range(30))
    assert not alarm.doubt
    assert [alarm.observe(LocalizationEvidence(8 + 0.1 * n, match=0.28, agreement=0.55)) for n in range(11)][-1]


def test_innovations_out_of_band_count_only_where_most_sightings_match_nothing() -> None:
    wild, strange = KidnapDetector(), KidnapDetector()
    assert not any(wild.observe(LocalizationEvidence(0.1 * n, nis=9.0, unmatched=0.3)) for n in range(20))
    assert [strange.observe(LocalizationEvidence(0.1 * n, nis=9.0, unmatched=0.7)) for n in range(11)][-1]


def test_scans_that_move_while_the_wheels_stand_tell_of_being_carried() -> None:
    alarm, step = KidnapDetector(), Pose(0.06, 0.0, 0.0)
    told = [alarm.observe(LocalizationEvidence(0.1 * n, match=0.9, wheels=Pose(), scans=step)) for n in range(10)]
    assert told.index(True) == 8
    alarm.calm()
    assert not any(
        alarm.observe(LocalizationEvidence(1 + 0.1 * n, match=0.9, wheels=step, scans=Pose())) for n in range(30)
    )  # slip


def test_what_was_never_seen_does_not_contradict_the_map(lab: OccupancyGrid) -> None:
    walls, here = WidenedWalls(), Pose(0.5, 0.3, 0.4)
    points = seen(LAB, here).points
    right = walls.agreement(lab, here.apply(points))
    wrong = walls.agreement(lab, Pose(0.5, 0.3, 2.4).apply(points))
    assert right is not None and right > 0.95
    assert wrong is not None and wrong < 0.6
    assert walls.agreement(lab, here.apply(points) + 100.0) is None
    nothing = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))
    assert WidenedWalls().agreement(nothing, points) is None


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.campaign)])
def test_a_carried_robot_turns_on_the_spot_and_knows_where_it_is_within_three_seconds(
    lab: OccupancyGrid, seed: int
) -> None:
    carried, place = robot(seed), anywhere(LAB, np.random.default_rng(50 + seed))
    carry(carried, place)
    finding, found, phases = Recovery(0.0, "it was carried", lab), None, set[str]()
    for number in range(120):
        frame = carried.read()
        assert frame.wheels is not None and frame.truth is not None
        view = None
        if frame.scan is not None:
            ends, hits = beam_ends(frame.scan, LASER, frame.wheels, frame.stamp)
            beams = Beams(ends=ends, hits=hits, viewpoint=LASER.mounting)
            view = ScanView.of_beams(frame.stamp, frame.wheels.odometry, beams)
        found = finding.step(number / 40, frame.wheels.odometry, view, True)
        phases.add(finding.lost.phase)
        if found is not None:
            break
        assert abs(finding.turn) <= 0.6
        carried.drive(Twist(0.0, finding.turn))
    assert found is not None
    assert finding.turn == 0.0
    assert frame.truth.distance_to(found.pose.x, found.pose.y) < 0.1
    assert abs(wrap(found.pose.heading - frame.truth.heading)) < math.radians(2)
    error = found.pose.vector - frame.truth.vector
    error[2] = wrap(float(error[2]))
    assert error @ np.linalg.solve(found.covariance, error) < 16.3
    assert place.distance_to(frame.truth.x, frame.truth.y) < 0.05
    assert phases <= {"searching", "confirming"}


def test_a_robot_that_may_not_turn_stands_and_is_not_believed_on_one_view(lab: OccupancyGrid) -> None:
    finding = Recovery(0.0, "it was carried", lab)
    assert stand(finding, seen(LAB, Pose(0.5, 0.3, 0.4), Pose()), 200) is None
    assert finding.turn == 0.0
    assert finding.lost.phase == "confirming"
    assert len(finding.lost.candidates) >= 1
    assert "turn left" in finding.lost.words


@pytest.mark.campaign
def test_where_rooms_look_alike_it_asks_after_a_full_turn() -> None:
    finding, phases = Recovery(0.0, "it was carried", mapped(OBLONG)), list[str]()
    for number in range(480):
        pose = Pose(1.4, 1.1, math.radians(0.83 * number))
        view = seen(OBLONG, pose, pose, seed=number) if number % 4 == 0 else None
        assert finding.step(number / 40, pose, view, True) is None
        phases.append(finding.lost.phase)
    assert phases[0] == "searching" and "confirming" in phases and phases[-1] == "asking"
    assert finding.turn == 0.0
    assert len(finding.lost.candidates) == 2
    assert "look the same" in finding.lost.words and "Click" in finding.lost.words


def test_a_click_decides_between_places_that_look_alike() -> None:
    truth = Pose(1.4, 1.1, 0.8)
    finding = Recovery(0.0, "it was carried", mapped(OBLONG))
    assert stand(finding, seen(OBLONG, truth, Pose()), 200) is None
    finding.place_at(Click(1.1, 1.5, None))
    found = stand(finding, seen(OBLONG, truth, Pose(), seed=1), 300)
    assert found is not None
    assert truth.distance_to(found.pose.x, found.pose.y) < 0.05
    assert abs(wrap(found.pose.heading - truth.heading)) < math.radians(1)


def test_a_click_at_the_wrong_place_is_answered_in_words_and_a_better_one_is_taken(lab: OccupancyGrid) -> None:
    truth = Pose(0.5, 0.3, 0.4)
    view = seen(LAB, truth, Pose())
    elsewhere = next(
        p for s in range(50) if (p := anywhere(LAB, np.random.default_rng(s))).distance_to(0.5, 0.3) > 2.5
    )
    finding = Recovery(0.0, "it was carried", lab)
    finding.place_at(Click(elsewhere.x, elsewhere.y, None))
    assert stand(finding, view, 300) is None
    assert finding.lost.phase == "asking"
    assert finding.lost.words.startswith("What I see does not fit the map there")
    finding.place_at(Click(0.9, 0.0, 0.3))
    found = stand(finding, view, 300)
    assert found is not None and truth.distance_to(found.pose.x, found.pose.y) < 0.05


def scans(finding: Recovery, pose: Pose, count: int) -> RecoveredPose | None:
    """So many scans of standing there, four frames each."""
    for number in range(count):
        view = seen(LAB, pose, Pose(), seed=number, stamp=0.1 * number)
        found = stand(finding, view, 4, start=0.1 * number)
        if found is not None:
            return found
    return None


def test_a_robot_that_never_left_goes_on_where_it_was_once_all_fits_again(lab: OccupancyGrid) -> None:
    truth = Pose(0.5, 0.3, 0.4)
    finding = Recovery(0.0, "someone stands before the laser", lab, before=Pose(0.53, 0.28, 0.41))
    found = scans(finding, truth, 40)
    assert found is not None and "all fits as before" in found.words
    assert truth.distance_to(found.pose.x, found.pose.y) < 0.05
    assert scans(Recovery(0.0, "it was carried", lab), truth, 40) is None  # nobody knows where it was


@pytest.mark.parametrize("seed", range(6))
def test_a_robot_that_was_carried_is_not_taken_for_one_that_never_left(lab: OccupancyGrid, seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth, before = anywhere(LAB, rng), anywhere(LAB, rng)
    assert scans(Recovery(0.0, "it fits nowhere", lab, before=before), truth, 40) is None


def test_a_click_that_the_walls_refute_leaves_a_robot_that_was_not_lost_where_it_was(lab: OccupancyGrid) -> None:
    truth = Pose(0.5, 0.3, 0.4)
    finding = Recovery(0.0, "you have told me so", lab, before=Pose(0.53, 0.28, 0.41))
    finding.place_at(Click(0.6, 0.2, 0.4 + math.pi / 2))
    found = stand(finding, seen(LAB, truth, Pose()), 300)
    assert found is not None and truth.distance_to(found.pose.x, found.pose.y) < 0.05
    assert "does not fit the map there" in found.words and "I stay where I was" in found.words


def test_where_neither_the_click_nor_the_former_place_fits_it_asks(lab: OccupancyGrid) -> None:
    finding = Recovery(0.0, "you have told me so", lab, before=Pose(0.5, 0.3, 0.4 + math.pi))
    finding.place_at(Click(0.6, 0.2, 0.4 + math.pi / 2))
    assert stand(finding, seen(LAB, Pose(0.5, 0.3, 0.4), Pose()), 300) is None
    assert finding.lost.phase == "asking"


def test_on_an_empty_map_it_asks_and_takes_the_click_as_it_is() -> None:
    finding = Recovery(0.0, "it was carried", EMPTY)
    view = seen(LAB, Pose(0.5, 0.3, 0.4), Pose())
    assert stand(finding, view, 10) is None
    assert finding.lost.phase == "asking" and "too little on the map" in finding.lost.words
    finding.place_at(Click(2.0, 1.0, 0.5))
    found = stand(finding, view, 10)
    assert found is not None
    assert found.pose == Pose(2.0, 1.0, 0.5)
    assert found.covariance[0, 0] == UNCHECKED_SD_M**2


def test_the_place_is_told_for_the_frame_in_which_it_was_found(lab: OccupancyGrid) -> None:
    truth, finding = Pose(0.5, 0.3, 0.4), Recovery(0.0, "it was carried", lab)
    finding.place_at(Click(0.6, 0.2, 0.5))
    view, found, frame = seen(LAB, truth, Pose()), None, 0
    while found is None:
        moved = Pose(0.001 * frame, 0.0, 0.002 * frame)
        found = finding.step(frame / 40, moved, view if frame == 0 else None, False)
        frame += 1
        assert frame < 300
    now = truth @ moved
    assert frame > 5
    assert now.distance_to(found.pose.x, found.pose.y) < 0.05
    assert abs(wrap(found.pose.heading - now.heading)) < math.radians(1)
