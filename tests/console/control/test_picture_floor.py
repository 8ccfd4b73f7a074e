"""What is drawn on the floor of a picture and pressed there belongs to the moment of the picture."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from console.broadcast import Broadcaster, Subscriber
from console.control.picture_floor import PictureFloor
from core.errors import BadInput, Refused, Unavailable
from core.gate import Twist
from core.geometry import Pose
from core.perception.picture_floor import ASSUMED, ring_in_picture
from core.pilot import Pilot
from core.simulation.robot import SimulatedRobot
from core.snapshot import Snapshot


class Drive:
    """A simulated robot, its pilot, and the part that looks on."""

    def __init__(self) -> None:
        self.robot = SimulatedRobot("lab")
        self.pilot = Pilot(self.robot.profile)
        self.broadcaster = Broadcaster()
        self.floor = PictureFloor(SimpleNamespace(profile=self.robot.profile), self.broadcaster)  # type: ignore[arg-type]
        self.floor.calibrated(self.robot.profile)
        self.truth: dict[float, Pose] = {}
        self.snapshot = self.step()

    def step(self, twist: Twist | None = None) -> Snapshot:
        self.robot.drive(twist or Twist())
        frame = self.robot.read()
        self.snapshot = self.pilot.step(frame)
        self.floor.on_snapshot(self.snapshot, frame)
        assert frame.truth is not None
        self.truth[frame.stamp] = frame.truth
        return self.snapshot

    def watch(self) -> None:
        self.broadcaster.join(Subscriber("camera"))


@pytest.fixture
def drive() -> Drive:
    return Drive()


def turned(drive: Drive) -> float:
    """Let it turn and drive until a picture is some frames old → stamp [s] of that picture."""
    for count in range(200):
        drive.step(Twist(0.1, 0.6 if count > 80 else 0.0))
        view = drive.snapshot.view
        if count > 120 and view is not None and drive.snapshot.stamp - view.stamp > 0.06:
            return view.stamp
    raise AssertionError("There is no picture that is older than its snapshot.")


def test_a_true_point_of_the_floor_pressed_in_an_older_picture_comes_back_within_two_centimetres(
    drive: Drive,
) -> None:
    stamp = turned(drive)
    camera = drive.robot.profile.camera
    assert camera is not None
    point = np.array([0.04 + 0.9, 0.05])
    u, v = ring_in_picture(point, 1e-4, camera).mean(axis=0).tolist()
    there = drive.truth[stamp].apply(point[None])[0]
    (x, y), distance, ring = drive.floor.floor(u, v, stamp)
    assert math.dist((x, y), there) < 0.02
    assert distance == pytest.approx(np.linalg.norm(point), abs=1e-3)
    assert np.abs(ring.mean(axis=0) - (u, v)).max() < 3
    moved = drive.snapshot.estimate.pose.apply(point[None])[0]
    assert math.dist(moved, there) > 0.03, "the newest pose would have missed it"


def test_the_way_is_drawn_where_the_picture_shows_it_and_only_for_who_watches(drive: Drive) -> None:
    stamp = turned(drive)
    camera = drive.robot.profile.camera
    assert camera is not None
    way = np.array([[0.0, 0.0], [1.2, 0.0]])
    world = drive.truth[stamp].apply(way)
    planned = replace(drive.snapshot, path=world, goal=world[1])
    assert drive.floor.drawn(planned)[0] == []
    drive.watch()
    (part,), ring = drive.floor.drawn(planned)
    right = ring_in_picture(way[1], 1e-4, camera).mean(axis=0)
    assert np.abs(part[-1, :2] - right).max() < 4 and np.abs(ring.mean(axis=0) - right).max() < 4
    assert drive.floor.drawn(drive.snapshot)[0] == []
    drive.floor.calibrated(replace(drive.robot.profile, cameras=(replace(camera, mounting_known=False),)))
    assert drive.floor.drawn(planned)[0] == []
    with pytest.raises(BadInput) as refusal:
        drive.floor.floor(160, 200, stamp)
    assert str(refusal.value) == ASSUMED


def test_a_picture_that_is_too_old_or_not_there_tells_no_floor(drive: Drive) -> None:
    stamp = turned(drive)
    for _ in range(120):
        drive.step()
    with pytest.raises(Refused, match="too old"):
        drive.floor.floor(160, 200, stamp)
    with pytest.raises(Unavailable, match="no camera picture"):
        PictureFloor(None, drive.broadcaster).floor(160, 200, stamp)  # type: ignore[arg-type]
