"""Leaving and entering rooms: what the filter keeps, what the wheels are believed, where tiles come to lie."""

import math

import numpy as np
import pytest

from core.geometry import Pose, rotation
from core.perception.landmarks.frame_perception import Beams
from core.slam.ekf_slam import FORMS
from core.slam.map.closure import ClosureSettings, Constraint, agreeing, agreement, departure, inverted
from core.slam.map.map_graph import MapGraph
from core.slam.mapper import Mapper
from core.slam.motion import Increment
from core.slam.scan_matching.field_matching import ScanMatchingSettings
from core.slam.scan_matching.scan_tracker import ScanTracker
from core.slam.submap_manager import MapperSettings, SubmapManager
from tests.core.slam.ring import LASER, drive, told

SURE = np.diag([0.02**2, 0.01**2, math.radians(0.5) ** 2])


@pytest.mark.parametrize("form", FORMS)
def test_who_is_seated_anew_knows_its_landmarks_as_before(form: str) -> None:
    rng, one = np.random.default_rng(1), FORMS[form](Pose(1.0, 2.0, 0.3))
    one.predict(Increment(Pose(0.5, 0.0, 0.1), SURE))
    for bearing in (-1.0, 0.2, 1.3):
        one.add(np.array([2.0 + rng.random(), bearing]), np.diag([1e-3, 1e-4]))
    one.predict(Increment(Pose(0.5, 0.1, -0.4), SURE))
    one.settle()
    places, spreads, apart = one.places.copy(), one.place_covariances(), one.apart(0, 2)[1]
    there, spread = Pose(-3.0, 1.0, 2.0), np.diag([0.04, 0.01, 0.02])
    one.reset_pose(there, spread)
    assert one.pose == there
    assert one.pose_covariance() == pytest.approx(spread, abs=1e-12)
    assert one.places == pytest.approx(places)
    assert one.place_covariances() == pytest.approx(spreads, abs=1e-10)
    assert one.apart(0, 2)[1] == pytest.approx(apart, abs=1e-10)


@pytest.mark.parametrize("form", FORMS)
def test_an_amended_move_is_as_if_it_had_been_told_at_once(form: str) -> None:
    one, two = FORMS[form](), FORMS[form]()
    better = Increment(Pose(0.9, 0.1, 0.2), SURE)
    one.predict(Increment(Pose(1.0, 0.0, 0.0), 4 * SURE))
    one.amend(better)
    two.predict(better)
    assert one.pose == two.pose
    assert one.pose_covariance() == pytest.approx(two.pose_covariance())


def test_the_way_back_undoes_the_way_there() -> None:
    move = Increment(Pose(1.0, -0.5, 0.8), SURE)
    assert move.then(inverted(move)).pose.vector == pytest.approx(np.zeros(3), abs=1e-12)
    again = inverted(inverted(move))
    assert again.pose.vector == pytest.approx(move.pose.vector)
    assert again.covariance == pytest.approx(move.covariance)


def test_a_way_is_its_steps_one_after_the_other() -> None:
    rng, graph, move = np.random.default_rng(2), MapGraph(), Increment()
    floor = Mapper(laser=LASER)
    for moment in drive(2, ((0.2, 0.0),)):
        told(floor, moment)
        break
    graph.submaps.append(floor.submaps.active)
    graph.add(floor.graph.views[0], None, None, Pose(1.0, 2.0, 0.5))
    steps = [Increment(Pose(*rng.normal(size=3).tolist()), (1 + k) * SURE) for k in range(5)]
    for step in steps:
        graph.add(floor.graph.views[0], step, None, Pose())
    for step in steps[1:4]:
        move = move.then(step)
    way = graph.way(1, 4)
    assert way.pose.vector == pytest.approx(move.pose.vector)
    assert way.covariance == pytest.approx(move.covariance)
    back = graph.way(4, 1)
    assert way.then(back).pose.vector == pytest.approx(np.zeros(3), abs=1e-12)


def straight(a: int, b: int) -> Increment:
    """Views stand half a metre apart on a line."""
    return Increment(Pose(0.5 * (b - a), 0.0, 0.0), 0.01 * abs(b - a) * SURE)


def link(a: int, b: int, move: Pose) -> Constraint:
    return Constraint(a, b, move, SURE, 0.8, 0.0)


def test_links_that_agree_vouch_for_each_other_and_a_wrong_one_stays_alone() -> None:
    right = [
        link(k, 100 + k, Pose(-0.5 * k, 0.0, 0.0) @ Pose(0.3, 0.2, 0.1) @ Pose(0.5 * k, 0.0, 0.0)) for k in range(4)
    ]
    wrong = link(2, 102, Pose(1.5, 0.2, 0.1))
    assert agreement(right[0], right[3], straight)[0] < 1e-6
    assert agreement(right[0], wrong, straight)[0] > 50
    settings = ClosureSettings()
    assert set(map(id, agreeing(right[0], [*right[1:], wrong], straight, settings))) == set(map(id, right))
    assert agreeing(wrong, right, straight, settings) == []
    assert agreeing(right[0], right[1:2], straight, settings) == []
    assert departure(link(0, 2, Pose(1.0, 0.0, 0.0)), straight(0, 2)) < 1e-6


def test_wheels_that_slip_are_noticed_and_the_scan_is_followed() -> None:
    tracker, moments = ScanTracker(ScanMatchingSettings()), list(drive(5, ((2.0, 0.0),)))
    tracker.around([one.truth.apply(one.seen.beams.points) for one in moments[:4]])
    before, now = moments[3].truth, moments[4]
    truth = before.inverse() @ now.truth
    points = now.seen.beams.points
    good = tracker.track(before, Increment(truth, 1e-4 * SURE), points)
    assert not tracker.slipping
    assert good.pose.vector == pytest.approx(truth.vector, abs=0.01)
    tracker = ScanTracker(ScanMatchingSettings())
    tracker.around([one.truth.apply(one.seen.beams.points) for one in moments[:4]])
    slipped = tracker.track(before, Increment(truth @ Pose(0.25, 0.0, 0.0), 1e-4 * SURE), points)
    assert tracker.slipping
    assert tracker.seen is not None
    assert slipped.pose.vector == pytest.approx(truth.vector, abs=0.04)


def test_a_match_that_is_always_a_little_off_is_no_move_of_wheels_that_stand() -> None:
    tracker, moments = ScanTracker(ScanMatchingSettings()), list(drive(5, ((2.0, 0.0),)))
    tracker.around([one.truth.apply(one.seen.beams.points) for one in moments[:4]])
    off, points = moments[3].truth @ Pose(0.03, -0.02, 0.01), moments[3].seen.beams.points
    first, moved = Pose(), Pose()
    for number in range(41):
        tracker.track(off, Increment(), points)
        assert tracker.seen is not None
        first, moved = (tracker.seen, moved) if number == 0 else (first, moved @ tracker.seen)
    assert abs(first.x) > 0.01
    assert moved.distance_to(0.0, 0.0) < 0.01 and abs(moved.heading) < 0.005


def test_a_robot_that_is_carried_slowly_is_followed_beyond_what_is_searched_at_once() -> None:
    tracker, moments = ScanTracker(ScanMatchingSettings()), list(drive(5, ((2.0, 0.0),)))
    tracker.around([one.truth.apply(one.seen.beams.points) for one in moments[:4]])
    stands, points = moments[3].truth, moments[3].seen.beams.points
    carried = Pose()
    for number in range(12):
        tracker.track(stands, Increment(), Pose(-0.04 * number, 0.0, 0.0).apply(points))
        assert tracker.seen is not None
        carried = carried @ tracker.seen
    assert abs(carried.x) == pytest.approx(0.44, abs=0.06)


def test_tiles_move_with_their_rooms() -> None:
    floor = Mapper(laser=LASER)
    for moment in drive(6, ((1.0, 0.0),)):
        told(floor, moment)
    at_home = floor.grid
    walls = at_home.origin + 0.05 * (np.argwhere(at_home.log_odds > 1.0)[:, ::-1] + 0.5)
    poses, turn = floor.graph.pose_array(), 0.5
    poses[:, :2] = poses[:, :2] @ rotation(turn).T + (2.0, -1.0)
    poses[:, 2] += turn
    floor.graph.revise(poses)
    moved = floor.grid
    places = np.floor((walls @ rotation(turn).T + (2.0, -1.0) - moved.origin) / 0.05).astype(int)
    assert moved is not at_home
    assert (moved.log_odds[places[:, 1], places[:, 0]] > 0.2).mean() > 0.95


def test_a_scan_that_went_astray_is_put_where_nothing_is_looked_through() -> None:
    floor, moments = Mapper(laser=LASER), list(drive(7, ((2.4, 0.0),)))
    for moment in moments[:-1]:
        told(floor, moment)
    last = moments[-1]
    slam, views = floor.submaps.active, len(floor.graph.views)
    right = slam.pose @ (moments[-2].truth.inverse() @ last.truth)
    slam.reset_pose(right @ Pose(0.5, 0.6, 0.35), 1e-4 * np.eye(3))
    floor.submaps.mend(last.seen.beams)
    off = right.inverse() @ slam.pose
    assert math.hypot(off.x, off.y) < 0.06
    assert abs(off.heading) < math.radians(1.5)
    assert slam.filter.pose_covariance()[0, 0] > 0.04**2
    assert len(floor.graph.views) == views


def test_a_map_grows_with_what_it_shows_and_not_with_how_long_it_is_driven_in() -> None:
    rng, graph, parts = np.random.default_rng(3), MapGraph(), MapperSettings()
    rooms = SubmapManager(parts, None, graph)
    bearings = np.linspace(-2.0, 2.0, 9)
    ends, hits = 3.0 * np.stack((np.cos(bearings), np.sin(bearings)), axis=1), np.ones(9, bool)
    kept: list[int] = []
    for number in range(2400):
        rooms.active.reset_pose(Pose(*rng.uniform((-1, -1, -math.pi), (1, 1, math.pi))), 1e-4 * np.eye(3))
        rooms.keep(float(number), Beams(ends=ends, hits=hits))
        kept.append(len(graph.views))
    quarters = np.diff([0, *kept[599::600]])
    assert quarters[0] > 60, "every place is seen from every side"
    assert quarters[3] < 0.1 * quarters[0]
    sectors = 2 * math.pi / parts.floor.crowd_turn
    assert kept[-1] < parts.floor.crowd * sectors * 4.0 / (math.pi * (parts.floor.crowd_distance / 2) ** 2) / 2
