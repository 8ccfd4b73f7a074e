"""A laser or a camera that hangs is noticed on the move; a robot that stands may see the same again."""

from dataclasses import replace

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import Pose
from core.message import Array
from core.pilot import Pilot
from core.robots import Profile
from core.robots.repeated_readings import RepeatedReadings
from core.sensors import Camera, Image, Laser, Scan, SensorFrame, Wheels
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

ONE = Profile(name="one of each", url="", lasers=(Laser(),), cameras=(Camera(),))
TWO = Profile(name="two lasers", url="", lasers=(Laser(name="front"), Laser(name="rear")))
STANDS, DRIVES = Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), Wheels(odometry=Pose(), speed=0.1, turn_rate=0.0)
NEAR, FAR = np.linspace(1.0, 2.0, 10), np.linspace(2.0, 3.0, 10)


def scan(ranges: Array, laser: str = "") -> SensorFrame:
    return SensorFrame(
        stamp=0.0, scan=Scan(stamp=0.0, laser=laser, ranges=ranges.copy(), angle_min=0.0, angle_step=0.1)
    )


def picture(grey: int) -> SensorFrame:
    return SensorFrame(stamp=0.0, image=Image(stamp=0.0, pixels=np.full((2, 2, 3), grey, np.uint8)))


@pytest.mark.parametrize(
    ("first", "second", "word"),
    [(scan(NEAR), scan(FAR), "laser repeats one scan"), (picture(1), picture(2), "camera repeats one picture")],
)
def test_what_repeats_itself_on_the_move_is_taken_out_until_another_comes(
    first: SensorFrame, second: SensorFrame, word: str
) -> None:
    watch = RepeatedReadings(ONE)

    def shown(frame: SensorFrame, wheels: Wheels | None) -> bool:
        left = watch.taken_out(frame, wheels)
        return left.scan is not None or left.image is not None

    assert all(shown(first, wheels) for wheels in (STANDS, None) for _ in range(5))  # nothing need change
    assert [shown(first, DRIVES) for _ in range(3)] == [True, False, False]
    assert [word in trouble for _, trouble in watch.troubles()] == [True]
    assert not shown(first, STANDS)  # because of that it stands; it hangs nevertheless
    assert shown(second, STANDS) and shown(first, DRIVES)
    assert [trouble for _, trouble in watch.troubles()] == [""]


def test_the_one_that_hangs_of_two_is_named_and_the_other_goes_on() -> None:
    watch = RepeatedReadings(TWO)
    for number in range(4):
        rear = watch.taken_out(scan(NEAR, "rear"), DRIVES)
        assert watch.taken_out(scan(NEAR + 0.01 * number, "front"), DRIVES).scan is not None
    assert rear.scan is None
    assert watch.hangs("laser", "rear") and not watch.hangs("laser", "front")
    assert "The laser rear repeats" in "".join(trouble for _, trouble in watch.troubles())


def test_where_nothing_is_near_the_laser_does_not_hang() -> None:
    watch = RepeatedReadings(ONE)
    assert all(watch.taken_out(scan(np.full(10, np.inf)), DRIVES).scan is not None for _ in range(5))


def test_the_pilot_names_a_laser_that_hangs_and_counts_it_as_lost() -> None:
    robot = SimulatedRobot("lab", seed=4, settings=SimulationSettings(camera=False))
    pilot, frozen = Pilot(robot.profile), None
    for _ in range(80):
        robot.drive(Twist(0.0, 0.3))
        frame = robot.read()
        if frame.scan is not None:
            frozen = frozen or frame.scan
            frame = replace(frame, scan=replace(frozen, stamp=frame.scan.stamp))
        snapshot = pilot.step(frame)
    assert [notice.text for notice in snapshot.notices] == [
        "The laser repeats one scan while the robot moves; it is not used until another one comes."
    ]
    assert {one.kind: one.state for one in snapshot.sensors}["laser"] == "lost"


def test_a_robot_in_a_simulator_without_noise_neither_hangs_nor_is_carried_while_it_stands() -> None:
    robot = SimulatedRobot("lab", seed=1, settings=SimulationSettings(camera=False))
    pilot = Pilot(robot.profile)
    scan, here = None, Pose()
    for number in range(400):
        turning = 160 <= number < 200
        robot.drive(Twist(0.0, 0.5 if turning else 0.0))
        frame = robot.read()
        if frame.scan is not None:
            scan = frame.scan if turning or scan is None else replace(scan, stamp=frame.scan.stamp)
            frame = replace(frame, scan=scan)
        if frame.wheels is not None and not turning:
            here = here if number != 200 else frame.wheels.odometry
            frame = replace(frame, wheels=replace(frame.wheels, odometry=here, speed=0.0, turn_rate=0.0))
        snapshot = pilot.step(frame)
        assert snapshot.floor.lost is None
    assert [notice.text for notice in snapshot.notices] == []
