"""The simulated robot as its driver sees it."""

import math
from typing import Any

import numpy as np
import pytest

from core.errors import BadInput
from core.gate import ZERO, Twist
from core.robots.requests import (
    CarryRobot,
    GroundTruth,
    PlaceThing,
    Play,
    ReadPlan,
    ReadTruth,
    RemoveThing,
    RobotRequest,
)
from core.sensors import SensorFrame
from core.simulation.faulty_robot import open_robot
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

BLIND = SimulationSettings(camera=False)
EXACT = SimulationSettings(camera=False, wheel_noise="none", laser_noise="none", dropout=0.0)


def run(robot: SimulatedRobot, seconds: float, twist: Twist | None = ZERO) -> list[SensorFrame]:
    """Frames of `seconds` [s] under one twist, told anew before each; None: nothing is told."""
    frames: list[SensorFrame] = []
    for _ in range(round(seconds * robot.profile.rate)):
        if twist is not None:
            robot.drive(twist)
        frames.append(robot.read())
    return frames


def truth(robot: SimulatedRobot) -> GroundTruth:
    return robot.ask(ReadTruth())


def test_the_profile_says_what_this_robot_is() -> None:
    profile = open_robot("floor").profile
    assert (profile.kind, profile.url, profile.drives) == ("SIM", "sim:floor", True)
    assert profile.laser is not None
    assert profile.camera is not None
    assert open_robot("lab", settings=BLIND).profile.camera is None


def test_frames_scans_and_pictures_come_at_their_rates_and_never_together() -> None:
    frames = run(open_robot("lab"), 2.0)
    np.testing.assert_allclose([f.stamp for f in frames], np.arange(1, 81) / 40)
    scans = [f for f in frames if f.scan]
    images = [f for f in frames if f.image]
    assert (len(scans), len(images)) == (20, 20)
    assert not any(f.scan and f.image for f in frames)
    assert all(f.image.stamp == f.stamp for f in images if f.image)
    for k, frame in enumerate(scans):
        assert frame.scan is not None
        assert frame.scan.stamp == pytest.approx(k / 10)
        assert 0 <= frame.stamp - frame.scan.times[-1] < 1 / 40


def test_it_drives_as_told() -> None:
    robot = open_robot("lab", settings=EXACT)
    end = run(robot, 5.0, Twist(0.2, 0.0))[-1]
    assert end.truth is not None
    assert end.truth.x == pytest.approx(0.2 * (5.0 - 0.06), abs=0.002)
    assert end.wheels is not None
    assert end.wheels.speed == pytest.approx(0.2)
    turned = run(robot, 1.0, Twist(0.0, 1.0))[-1]
    assert turned.truth is not None
    assert turned.truth.heading == pytest.approx(1.0 - 0.06, abs=0.01)


def test_speeds_are_bounded_by_the_profile() -> None:
    robot = open_robot("lab", settings=EXACT)
    frame = run(robot, 1.0, Twist(9.0, -9.0))[-1]
    assert frame.wheels is not None
    assert (frame.wheels.speed, frame.wheels.turn_rate) == pytest.approx((0.3, -1.5))


@pytest.mark.parametrize("twist", [Twist(math.nan, 0.0), Twist(0.1, math.inf)])
def test_what_is_no_number_does_not_move_it(twist: Twist) -> None:
    robot = open_robot("lab", settings=BLIND)
    run(robot, 0.5, twist)
    assert truth(robot).x_m == 0.0


def test_it_stops_by_itself_when_nothing_is_told_for_half_a_second() -> None:
    robot = open_robot("lab", settings=EXACT)
    run(robot, 1.0, Twist(0.2, 0.0))
    frames = run(robot, 1.5, None)
    speeds = [f.wheels.speed for f in frames if f.wheels]
    assert speeds[17] == pytest.approx(0.2)
    assert speeds[40:] == [0.0] * len(speeds[40:])
    assert truth(robot).x_m < 0.2 * 1.5 + 0.01


def test_a_wall_stops_it_and_says_so_until_it_backs_out() -> None:
    robot = open_robot("lab", settings=EXACT)
    frames = run(robot, 25.0, Twist(0.3, 0.0))  # the wall ahead is 5.1 m away
    assert not frames[0].contact
    assert frames[-1].contact
    assert truth(robot).contact
    assert truth(robot).clearance_m == pytest.approx(0.0, abs=0.001)
    last = frames[-1].wheels
    assert last is not None
    assert last.speed == 0.0
    turned = run(robot, 1.0, Twist(0.0, 1.0))[-1]
    assert turned.truth is not None
    assert turned.truth.heading == pytest.approx(0.94, abs=0.02)
    assert turned.contact
    run(robot, 1.1, Twist(0.0, -1.0))
    backed = run(robot, 0.5, Twist(-0.1, 0.0))
    assert not backed[-1].contact
    assert truth(robot).clearance_m > 0.03


def test_it_never_enters_anything_however_it_is_driven() -> None:
    robot = open_robot("lab", settings=BLIND)
    rng = np.random.default_rng(4)
    nearest = math.inf
    for _ in range(120):
        twist = Twist(float(rng.uniform(-0.1, 0.3)), float(rng.uniform(-0.6, 0.6)))
        run(robot, 1.0, twist)
        nearest = min(nearest, truth(robot).clearance_m)
    assert -1e-4 < nearest < 0.05


def test_the_same_seed_senses_the_same_and_another_does_not() -> None:
    def record(seed: int, settings: SimulationSettings = BLIND) -> list[SensorFrame]:
        return run(open_robot("lab", seed=seed, settings=settings), 2.0, Twist(0.1, 0.4))

    first, again, other = record(1), record(1), record(2)
    for a, b in zip(first, again, strict=True):
        assert (a.truth, a.contact) == (b.truth, b.contact)
        assert a.wheels is not None
        assert b.wheels is not None
        assert a.wheels.odometry == b.wheels.odometry
        if a.scan and b.scan:
            np.testing.assert_array_equal(a.scan.ranges, b.scan.ranges)
    assert first[-1].truth == other[-1].truth  # chance is in the sensors
    assert first[-1].wheels is not None
    assert other[-1].wheels is not None
    assert first[-1].wheels.odometry != other[-1].wheels.odometry
    with_camera = record(1, SimulationSettings())
    assert with_camera[-1].wheels is not None
    assert with_camera[-1].wheels.odometry == first[-1].wheels.odometry
    np.testing.assert_array_equal(
        [f.scan.ranges for f in with_camera if f.scan], [f.scan.ranges for f in first if f.scan]
    )


def test_a_scan_while_turning_is_sheared_as_its_beam_times_say() -> None:
    robot = open_robot("lab", settings=EXACT)
    still = next(f.scan for f in run(robot, 0.2) if f.scan)
    frames = run(robot, 2.1, Twist(0.0, 1.5))
    scan = [f.scan for f in frames if f.scan][-1]
    poses = {round(f.stamp, 3): f.truth.heading for f in frames if f.truth}
    start = poses[round(scan.stamp, 3)]
    bearing = start + 1.5 * (scan.times - scan.stamp) + scan.angles
    expected = np.interp((bearing + np.pi) % (2 * np.pi) - np.pi, still.angles, still.ranges)
    inside = np.abs((bearing + np.pi) % (2 * np.pi) - np.pi) < 2.0
    assert np.nanmedian(np.abs(scan.ranges - expected)[inside]) < 0.003


def test_a_person_and_a_box_are_placed_moved_and_removed() -> None:
    robot = open_robot("lab", settings=EXACT)
    before = next(f.scan for f in run(robot, 0.1) if f.scan).ranges
    placed = robot.ask(PlaceThing(what="person", x_m=1.0, y_m=0.0, heading_rad=math.pi))
    assert placed.id == "person 1"
    with_person = next(f.scan for f in run(robot, 0.1) if f.scan).ranges
    assert np.nanmin(with_person[300:382]) < 1.0 < np.nanmin(before[300:382])
    robot.ask(PlaceThing(what="person", id="person 1", x_m=1.0, y_m=1.0))
    robot.ask(PlaceThing(what="box", x_m=1.5, y_m=-0.5, size_m=0.3))
    mine = [t for t in robot.ask(ReadPlan()).things if not t.fixed]
    assert [(t.id, t.x_m, t.y_m) for t in mine] == [("person 1", 1.0, 1.0), ("box 1", 1.5, -0.5)]
    assert robot.ask(RemoveThing(id="person 1")).id == "person 1"
    robot.ask(RemoveThing(id="box 1"))
    after = next(f.scan for f in run(robot, 0.1) if f.scan).ranges
    np.testing.assert_array_equal(after, before)


def test_a_person_placed_in_its_way_stops_it() -> None:
    robot = open_robot("lab", settings=BLIND)
    robot.ask(PlaceThing(what="person", x_m=0.6, y_m=0.1))
    frames = run(robot, 4.0, Twist(0.3, 0.0))
    assert frames[-1].contact
    assert truth(robot).x_m < 0.6


def test_carrying_the_robot_goes_unnoticed_by_its_wheels() -> None:
    robot = open_robot("lab", settings=EXACT)
    run(robot, 1.0, Twist(0.2, 0.3))
    odometry = run(robot, 0.5)[-1].wheels
    answer = robot.ask(CarryRobot(x_m=2.0, y_m=1.0, heading_rad=7.0))
    assert (answer.x_m, answer.y_m) == (2.0, 1.0)
    assert answer.heading_rad == pytest.approx(7.0 - 2 * math.pi)
    frame = run(robot, 0.5)[-1]
    assert frame.wheels is not None
    assert odometry is not None
    assert frame.wheels.odometry == odometry.odometry
    assert frame.truth is not None
    assert (frame.truth.x, frame.truth.y) == (2.0, 1.0)


@pytest.mark.parametrize(
    ("request_", "sentence"),
    [
        (Play(), "understands the requests"),
        (PlaceThing(what="box", x_m=math.nan, y_m=0), "x_m must be a finite number"),
        (PlaceThing(what="box", x_m=50, y_m=0), "does not fit there"),
        (PlaceThing(what="person", x_m=5.4, y_m=0), "does not fit there"),
        (PlaceThing(what="person", x_m=0.2, y_m=0), "robot stands there"),
        (CarryRobot(x_m=5.45, y_m=0), "robot does not fit"),
        (CarryRobot(x_m=1, y_m=0, heading_rad=math.inf), "finite"),
        (PlaceThing(what="box", x_m=1, y_m=0, size_m=5), "size_m of a box must lie between"),
        (PlaceThing(what="box", x_m=1, y_m=0, id="crate"), "piece of the room"),
        (PlaceThing(what="box", x_m=1, y_m=0, id=""), "id must be a text"),
        (RemoveThing(id="crate"), "Nothing of that id"),
    ],
)
def test_a_request_that_cannot_be_met_is_answered_with_a_sentence(request_: RobotRequest[Any], sentence: str) -> None:
    robot = open_robot("lab", settings=BLIND)
    before = robot.ask(ReadPlan())
    with pytest.raises(BadInput, match=sentence):
        robot.ask(request_)
    assert robot.ask(ReadPlan()) == before


def test_the_room_does_not_fill_up_without_end() -> None:
    robot = open_robot("floor", settings=BLIND)
    spots = [(x, y) for x in np.arange(9.5, 12.0, 0.4) for y in np.arange(9.0, 12.2, 0.4)]
    with pytest.raises(BadInput, match="remove one first"):
        for x, y in spots:
            robot.ask(PlaceThing(what="box", x_m=float(x), y_m=float(y), size_m=0.1))
    assert len([t for t in robot.ask(ReadPlan()).things if not t.fixed]) == 30


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"wheel_noise": "some"}, "wheel_noise must be one of"),
        ({"laser_noise": "5%"}, "laser_noise must be one of"),
        ({"max_speed": math.nan}, "max_speed must lie between"),
    ],
)
def test_settings_out_of_bounds_are_refused(wrong: dict[str, Any], sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        SimulationSettings(**wrong)


@pytest.mark.campaign
def test_the_papers_wheels_are_much_worse_than_encoders() -> None:
    def error(settings: SimulationSettings) -> float:
        gaps: list[float] = []
        for seed in range(6):
            end = run(open_robot("lab", seed=seed, settings=settings), 12.0, Twist(0.1, 0.0))[-1]
            assert end.truth is not None
            assert end.wheels is not None
            gaps.append(end.truth.distance_to(end.wheels.odometry.x, end.wheels.odometry.y))
        return float(np.mean(gaps))

    assert error(BLIND) < 0.04
    assert 0.04 < error(SimulationSettings(camera=False, wheel_noise="paper")) < 0.4


def test_in_the_dark_and_at_another_rate_pictures_still_come() -> None:
    robot = open_robot("lab", settings=SimulationSettings(camera_rate=20.0, light=0.2))
    images = [f.image for f in run(robot, 1.0) if f.image]
    assert len(images) == 20
    assert images[0].pixels.mean() < 40
