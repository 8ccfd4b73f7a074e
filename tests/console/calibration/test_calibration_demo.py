"""The simulated person: what it does when, and whether cameras and lasers get calibrated by it."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from console.calibration.demo import MAX_HOLD_S, TRIES_PER_ADVICE, BoardDemo, SessionView
from core.calibration.board.board import Board
from core.calibration.camera.guidance import Advice
from core.calibration.camera.session import CameraSession
from core.calibration.laser.session import LaserSession
from core.errors import BadInput, Refused
from core.geometry import Transform
from core.optics import TABLE_3, CameraModel
from core.robots.requests import AnswerT, BoardInCamera, PlaceBoard, ReadPlan, RemovedThing, RemoveThing, RobotRequest
from core.sensors import SensorFrame
from core.simulation.faulty_robot import open_robot
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

BOARD = Board(columns=9, rows=6, square=0.03, panel=(0.34, 0.25))
FACING = Transform(rotation=np.eye(3), translation=np.array([-0.12, -0.075, 0.5]))


@dataclass
class Driver:
    """Takes requests down; refuses boards whose middle is lower than `floor` [m] under the camera."""

    floor: float = 1.0
    asked: list[RobotRequest[Any]] = field(default_factory=list)
    refused: int = 0
    others: int = 0  # times that another suggestion was asked for
    advised: Transform | None = FACING

    async def ask(self, request: RobotRequest[AnswerT], /) -> AnswerT:
        if isinstance(request, PlaceBoard) and self.middle(request)[1] > self.floor:
            self.refused += 1
            raise BadInput("The board would go through the floor there.")
        self.asked.append(request)
        return cast(AnswerT, RemovedThing("board"))

    @property
    def kinds(self) -> list[type[RobotRequest[Any]]]:
        return [type(request) for request in self.asked]

    @property
    def poses(self) -> list[BoardInCamera]:
        boards = (request.in_camera for request in self.asked if isinstance(request, PlaceBoard))
        return [pose for pose in boards if pose is not None]

    async def advice(self, skip: bool) -> Transform | None:
        self.others += skip
        return self.advised

    @staticmethod
    def middle(request: PlaceBoard) -> Any:
        pose = request.in_camera
        assert pose is not None
        return np.array(pose.rotation) @ BOARD.centre + pose.translation_m


def shown(driver: Driver, sights: Callable[[float], SessionView], seconds: float, seed: int = 0) -> BoardDemo:
    """A simulated person who is told `sights(now)` ten times a second."""
    board_demo = BoardDemo(driver.ask, driver.advice, BOARD, seed=seed)

    async def go() -> None:
        for tick in range(round(seconds * 10)):
            await board_demo.step(tick / 10, sights(tick / 10))

    asyncio.run(go())
    return board_demo


def test_it_stays_away_while_the_room_has_to_be_empty_and_comes_then() -> None:
    driver = Driver()
    shown(driver, lambda now: SessionView(kind="background", empty=now < 2.0), 1.9)
    assert driver.asked == []
    shown(driver, lambda now: SessionView(kind="background", empty=now < 2.0), 2.2)
    assert driver.kinds == [PlaceBoard]
    first = driver.asked[0]
    assert isinstance(first, PlaceBoard) and first.holder and first.panel_m == (0.34, 0.25)


def test_it_steps_aside_when_the_room_is_looked_at_anew_and_comes_back() -> None:
    driver = Driver()
    shown(driver, lambda now: SessionView(empty=1.0 < now < 2.0), 2.5)
    assert driver.kinds == [PlaceBoard, RemoveThing, PlaceBoard]


def test_it_goes_on_as_soon_as_a_view_has_counted() -> None:
    driver = Driver()
    shown(driver, lambda now: SessionView(number=int(now), kind="counted"), 4.0)
    assert len(driver.asked) == 4  # at 0, 1, 2 and 3 s
    assert driver.others == 0


def test_verdicts_from_before_it_arrived_do_not_count() -> None:
    driver = Driver()
    shown(driver, lambda now: SessionView(number=5, kind="same"), MAX_HOLD_S - 0.2)
    assert len(driver.asked) == 1


def test_it_waits_longer_while_scans_are_gathered_than_while_nothing_is_seen() -> None:
    held = {}
    for kind in ("nothing", "moving", "gathering"):
        driver = Driver()
        shown(driver, lambda now, kind=kind: SessionView(number=int(10 * now), kind=kind), 7.0)
        held[kind] = len(driver.asked)
    assert held["nothing"] > held["moving"] > held["gathering"] == 1


def test_a_view_that_is_refused_is_tried_more_carefully_and_then_another_one_is_asked_for() -> None:
    driver = Driver()
    shown(driver, lambda now: SessionView(number=int(10 * now), kind="refused"), 6.0)
    off = [np.linalg.norm(driver.middle(request) - [0.0, 0.0, 0.5]) for request in driver.asked]
    assert len(off) >= 4 and driver.others == 1
    assert off[2] < 0.03


def test_it_misses_as_a_hand_does_and_the_same_for_the_same_seed() -> None:
    driver = Driver()
    for seed in range(200):
        shown(driver, lambda _: SessionView(), 0.1, seed)
    middles = np.array([driver.middle(request) for request in driver.asked])
    turns = [Rotation.from_matrix(np.array(pose.rotation)).magnitude() for pose in driver.poses]
    assert np.sqrt(np.mean(np.sum((middles - [0, 0, 0.5]) ** 2, axis=1))) == pytest.approx(0.05, rel=0.15)
    assert np.sqrt(np.mean(np.square(turns))) == pytest.approx(np.deg2rad(5), rel=0.15)
    again = Driver()
    shown(again, lambda _: SessionView(), 0.1, 199)
    assert again.asked[0] == driver.asked[199]


def test_a_pose_in_the_floor_is_taken_higher_or_another_one_is_asked_for() -> None:
    near = Driver(floor=-0.05)
    shown(near, lambda _: SessionView(), 0.1)
    assert near.asked and near.middle(near.asked[0])[1] < -0.05
    deep = Driver(floor=-0.9)
    shown(deep, lambda _: SessionView(), 1.0)
    assert deep.asked == [] and deep.others == 9 and deep.refused == 10 * TRIES_PER_ADVICE


def test_where_there_is_no_room_at_all_it_gives_up_with_a_sentence() -> None:
    with pytest.raises(Refused, match=r"through the floor there\. Drive the robot to where there is room"):
        shown(Driver(floor=-0.9), lambda _: SessionView(), 10.0)


def test_a_view_that_counted_just_before_it_arrived_is_no_failure() -> None:
    driver = Driver()
    verdicts = {12: "counted", 13: "same", 14: "same"}  # of the second pose, which is taken at 0.2 s
    sights = lambda now: SessionView(number=round(10 * now), kind=verdicts.get(round(10 * now), "same"))  # noqa: E731
    shown(driver, sights, 1.6)
    assert len(driver.asked) == 3 and driver.others == 0
    off = [np.linalg.norm(driver.middle(request) - [0.0, 0.0, 0.5]) for request in driver.asked]
    cautious = Driver()
    shown(cautious, lambda now: SessionView(number=round(10 * now), kind="same"), 1.8)
    assert len(cautious.asked) == 3
    less = [np.linalg.norm(cautious.middle(request) - [0.0, 0.0, 0.5]) for request in cautious.asked]
    assert off[2] == pytest.approx(4 * less[2], rel=1e-6)  # the same chance, at full and at a quarter of the miss


def test_it_waits_for_a_solution_because_the_advice_will_be_better_but_not_for_ever() -> None:
    driver = Driver()
    shown(driver, lambda now: SessionView(number=int(now), kind="counted", busy=now > 0.5), 3.5)
    assert len(driver.asked) == 1
    shown(driver, lambda now: SessionView(number=int(now), kind="counted", busy=now > 0.5), 5.0)
    assert len(driver.asked) == 3


def test_without_advice_it_waits() -> None:
    driver = Driver(advised=None)
    shown(driver, lambda _: SessionView(), 1.0)
    assert driver.asked == []


def test_it_leaves_when_the_session_is_ready_or_it_is_sent_away() -> None:
    driver = Driver()
    board_demo = shown(driver, lambda now: SessionView(ready=now > 0.5), 1.0)
    assert board_demo.done
    assert driver.kinds == [PlaceBoard, RemoveThing]
    sent = Driver()
    board_demo = shown(sent, lambda _: SessionView(), 0.5)
    asyncio.run(board_demo.leave())
    asyncio.run(board_demo.leave())
    assert sent.kinds == [PlaceBoard, RemoveThing] and not board_demo.done


class Lesson:
    """One session in the simulated laboratory, watched by a simulated person, on simulated time."""

    def __init__(self, robot: SimulatedRobot, session: CameraSession | LaserSession, seed: int) -> None:
        self.robot, self.session = robot, session
        self.board_demo = BoardDemo(self._ask, self._advice, BOARD, seed=seed)
        self._number, self._kind, self._ready = 0, "", False

    async def _ask(self, request: RobotRequest[AnswerT], /) -> AnswerT:
        return self.robot.ask(request)

    async def _advice(self, skip: bool) -> Transform | None:
        told: Advice | None = self.session.skip() if skip else self.session.advice()
        return None if told is None else Transform(rotation=told.rotation, translation=told.translation)

    def _sense(self, frame: SensorFrame) -> bool:
        """Show the frame to the session → whether it has said something."""
        verdict = None
        if frame.scan is not None and isinstance(self.session, LaserSession):
            verdict = self.session.sweep(frame.scan)
        if frame.image is not None:
            grey = cv2.cvtColor(frame.image.pixels, cv2.COLOR_BGR2GRAY)
            timed = (frame.stamp,) if isinstance(self.session, CameraSession) else ()
            verdict = self.session.look(grey, *timed)
        if verdict is None:
            return False
        self._number, self._kind = self._number + 1, verdict.kind
        if self.session.stale and len(self.session.taken) % 2 == 0:  # a solution takes its time
            self.session.solve()
            self._ready = self.session.progress().ready
        return True

    def run(self, seconds: float) -> float:
        """Until the demo is done → how long it took [s]."""

        async def go() -> float:
            first = last = self.robot.read().stamp
            while not self.board_demo.done and last - first < seconds:
                frame = self.robot.read()
                last = frame.stamp
                if self._sense(frame):
                    empty = isinstance(self.session, LaserSession) and self.session.background is None
                    await self.board_demo.step(last, SessionView(self._number, self._kind, self._ready, empty))
            return last - first

        return asyncio.run(go())


def some_robot(seed: int, rate: float = 10.0) -> SimulatedRobot:
    """With the worse of the lasers; `rate` [Hz] of its pictures."""
    return open_robot("lab", seed=seed, settings=SimulationSettings(laser_noise="3%", camera_rate=rate))


@pytest.mark.campaign
def test_the_demo_calibrates_the_camera_by_itself() -> None:
    robot, session = some_robot(6), CameraSession(BOARD)
    took = Lesson(robot, session, 6).run(60.0)
    progress = session.progress()
    assert progress.ready and progress.p95_px is not None and progress.p95_px <= 0.5 and took < 60
    found = session.accept()
    for name in found.free:
        off = getattr(found.model, name) - getattr(TABLE_3, name)
        assert abs(off) < 4 * found.sds[name], name
    assert robot.ask(ReadPlan()).things[-1].fixed  # the board is gone


@pytest.mark.campaign  # the browser tests let it do the same while someone watches
def test_the_demo_calibrates_the_laser_by_itself_with_a_camera_that_is_not_quite_exact() -> None:
    robot = some_robot(11, rate=5.0)
    camera = CameraModel(
        width=320, height=256, fx=301.3, fy=303.0, cx=155.6, cy=139.2, k1=-0.4305, k2=0.2410, p1=-0.0038, p2=-0.003
    )
    session = LaserSession(BOARD, camera)
    took = Lesson(robot, session, 11).run(120.0)
    progress = session.progress()
    assert progress.ready and "Done" in progress.words and took < 120
    found, profile = session.accept().extrinsics.transform, robot.profile
    assert profile.laser is not None and profile.camera is not None
    true = Transform.of_pose(profile.laser.mounting, profile.laser.height).inverse() @ profile.camera.mounting
    turn = Rotation.from_matrix(found.rotation @ true.rotation.T).magnitude()
    assert np.degrees(turn) < 0.8
    assert np.linalg.norm(found.translation - true.translation) < 0.006
