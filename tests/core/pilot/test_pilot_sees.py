"""What the pilot's eyes make of bad pictures, and what the operator hears of them."""

from dataclasses import replace

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import Pose
from core.perception.people.camera_geometry import axis
from core.pilot import Pilot, landmark_perception
from core.pilot.landmark_perception import LandmarkPerception
from core.sensors import Image, SensorFrame
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.motion import Increment, Motion


def dark_robot(light: float) -> SimulatedRobot:
    return SimulatedRobot("lab", seed=4, settings=SimulationSettings(light=light))


def pictures(light: float, seconds: float) -> list[Image]:
    robot = dark_robot(light)
    frames = [robot.read() for _ in range(int(40 * seconds))]
    return [frame.image for frame in frames if frame.image is not None]


def test_the_view_carries_the_pictures_quality_and_a_dark_one_is_brightened() -> None:
    robot = dark_robot(0.15)
    pilot = Pilot(robot.profile)
    views = [pilot.step(robot.read()).view for _ in range(20)]
    view = views[-1]
    assert view is not None
    assert view.quality is not None
    assert view.quality.state == "mended"
    assert view.quality.words.startswith("Too dark: brightened.")
    assert len(view.edges) > 2
    plain = Pilot(robot.profile, replace(Settings(), image_quality=replace(Settings().image_quality, prepare=False)))
    frame = next(frame for frame in iter(robot.read, None) if frame.image is not None)
    seen = plain.step(frame).view
    assert seen is not None
    assert len(seen.edges) < len(view.edges)


def test_unusable_pictures_are_told_once_after_a_second_and_so_is_their_end() -> None:
    robot = dark_robot(1.0)
    pilot = Pilot(robot.profile)
    told: list[tuple[float, str]] = []
    known: list[str] = []
    for number in range(140):
        frame = robot.read()
        if frame.image is not None and 20 <= number < 90:
            frame = replace(frame, image=Image(stamp=frame.image.stamp, pixels=np.zeros_like(frame.image.pixels)))
        snapshot = pilot.step(frame)
        new = [notice for notice in snapshot.notices if notice.text not in known]
        known += [notice.text for notice in new]
        told += [(snapshot.stamp, notice.text) for notice in new if "camera" in notice.text]
    (begun, trouble), (ended, relief) = told
    assert begun == pytest.approx(1.5, abs=0.2)
    assert trouble.startswith("The camera's pictures cannot be used: black.")
    assert ended == pytest.approx(2.25, abs=0.2)
    assert relief == "The camera sees well enough again."


def test_the_pilot_does_not_look_at_a_camera_that_hangs() -> None:
    robot = dark_robot(1.0)
    pilot, frozen = Pilot(robot.profile), None
    robot.drive(Twist(0.0, 0.3))
    seen: list[float] = []
    for _ in range(60):
        robot.drive(Twist(0.0, 0.3))
        frame = robot.read()
        if frame.image is not None:
            frozen = frozen or frame.image
            frame = replace(frame, image=Image(stamp=frame.image.stamp, pixels=frozen.pixels))
        view = pilot.step(frame).view
        seen.append(view.stamp if view is not None else 0.0)
    assert max(seen) < 0.5  # the first picture, and its first repetition


def test_a_single_black_picture_is_nothing_to_tell() -> None:
    robot = dark_robot(1.0)
    eyes = LandmarkPerception(robot.profile, Settings())
    for image in pictures(1.0, 0.5):
        eyes.look(SensorFrame(stamp=image.stamp, image=image), Motion())
        black = Image(stamp=image.stamp + 0.05, pixels=np.zeros_like(image.pixels))
        eyes.look(SensorFrame(stamp=black.stamp, image=black), Motion())
        assert eyes.poor == ""


def test_the_scans_of_a_standing_robot_are_read_every_other_second_and_at_once_when_a_person_comes() -> None:
    robot = SimulatedRobot("lab", seed=4)
    eyes = LandmarkPerception(robot.profile, Settings())

    def is_read(frame: SensorFrame) -> bool:
        return eyes.look(frame, Motion(wheels=frame.wheels), idle=True).sightings is not None

    frames = [robot.read() for _ in range(40 * 10)]
    read = [frame.stamp for frame in frames if is_read(frame)]
    assert len([stamp for stamp in read if stamp > frames[-1].stamp - 4.0]) == 2
    frame = next(frame for frame in iter(robot.read, None) if frame.scan is not None and not is_read(frame))
    assert frame.scan is not None
    ranges = frame.scan.ranges.copy()
    ranges[300:320] -= 0.5  # 0.4 m wide at 3 m
    assert is_read(replace(frame, scan=replace(frame.scan, ranges=ranges)))


@pytest.mark.parametrize(("pace", "looks"), [(1.0, 10), (0.6, 5)])
def test_where_the_computer_is_too_slow_every_second_picture_is_looked_at(
    pace: float, looks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, seen = SimulatedRobot("lab", seed=4), list[float]()
    monkeypatch.setattr(landmark_perception, "find_edges", lambda image, *_: seen.append(image.stamp) or ())
    eyes = LandmarkPerception(robot.profile, Settings())
    for frame in (robot.read() for _ in range(40)):
        robot.drive(Twist(0.0, 0.3))
        eyes.look(replace(frame, pace=pace), Motion(wheels=frame.wheels))
    assert len(seen) == looks


def test_pictures_of_a_standing_robot_are_looked_at_every_other_second_and_soon_when_something_changes() -> None:
    robot = SimulatedRobot("lab", seed=4)
    eyes, looked = LandmarkPerception(robot.profile, Settings()), list[float]()
    frames = [frame for _ in range(40 * 10) if (frame := robot.read()).image is not None]

    def look(frame: SensorFrame) -> bool:
        before = eyes.view.edges if eyes.view is not None else None
        eyes.look(frame, Motion(wheels=frame.wheels), idle=True)
        return eyes.view is not None and eyes.view.edges is not before

    looked = [frame.stamp for frame in frames[:-1] if look(frame)]
    assert len([stamp for stamp in looked if stamp > frames[-1].stamp - 4.0]) == 2
    image = frames[-1].image
    assert image is not None
    pixels = image.pixels.copy()
    pixels[60:200, 100:130] = 200 - pixels[60:200, 100:130] // 2
    assert look(replace(frames[-1], image=Image(stamp=looked[-1] + 0.5, pixels=pixels)))


def test_the_camera_of_a_late_picture_looks_where_it_looked_when_it_was_taken() -> None:
    robot = dark_robot(1.0)
    eyes, camera = LandmarkPerception(robot.profile, Settings()), robot.profile.camera
    assert camera is not None
    for number in range(20):  # 0.8 rad/s
        turned = Increment(Pose(0.0, 0.0, 0.04))
        eyes.look(SensorFrame(stamp=0.05 * number), Motion(increment=turned))
    late = eyes.camera_of(Image(stamp=0.85, pixels=np.zeros((4, 4, 3), np.uint8)), 0.95)
    assert late is not None and axis(late) - axis(camera) == pytest.approx(-0.08)
    assert eyes.camera_of(Image(stamp=0.95, pixels=np.zeros((4, 4, 3), np.uint8)), 0.95) == camera
    assert eyes.camera_of(None, 0.95) == camera
