"""A robot without a world, for tests of the processes around it: `python -m tests.console.tiny_robot` is its driver.

`tiny:` drives and sees an empty room; `tiny:crash=0.5` raises after so many seconds, `tiny:exit=0.5` just ends,
`tiny:refuse` cannot be opened, `tiny:break` breaks while opening, `tiny:slow` needs long to open.
"""

import os
import time
from typing import Any, cast

import msgspec
import numpy as np

from core.errors import Refused, Unavailable
from core.gate import ZERO, Twist
from core.geometry import Pose
from core.robots import Profile
from core.robots.connect import SCHEMES, Scheme
from core.robots.process import main
from core.robots.requests import AnswerT, Requests, RobotRequest
from core.sensors import Laser, Scan, SensorFrame, Wheels

LASER = Laser(beams=100, angle_step=0.04, angle_min=-2.0)
TINY = Scheme("tests.console.tiny_robot", "tiny:", "robot for tests", "wheels, laser", section="none")


class BaseState(msgspec.Struct, frozen=True):
    """What the base does: its speeds, and how far it came."""

    v: float
    w: float
    x: float


class Acknowledged(msgspec.Struct, frozen=True):
    """It was done."""


class ReadTwist(RobotRequest[BaseState], frozen=True, tag="twist"): ...


class Touch(RobotRequest[Acknowledged], frozen=True, tag="touch"):
    value: bool


class Sleep(RobotRequest[Acknowledged], frozen=True, tag="sleep"):
    value: float


class Break(RobotRequest[Acknowledged], frozen=True, tag="raise"): ...


class Fly(RobotRequest[Acknowledged], frozen=True, tag="fly"):
    """It says no."""

    luggage: str = ""


class TinyRobot:
    def __init__(self, wish: str) -> None:
        self.profile = Profile(name="tiny", url=f"tiny:{wish}", capabilities=frozenset({"drive"}), lasers=(LASER,))
        self._wish, _, seconds = wish.partition("=")
        self._fate = float(seconds or "inf")
        self._frames = 0
        self._pose = Pose()
        self._twist = ZERO
        self._contact = False

    def drive(self, twist: Twist) -> None:
        self._twist = twist

    def read(self) -> SensorFrame:
        self._frames += 1
        stamp = self._frames / self.profile.rate
        if stamp > self._fate and self._wish == "crash":
            raise RuntimeError("the tiny robot broke down")
        if stamp > self._fate and self._wish == "exit":
            os._exit(3)
        self._pose = self._pose @ Pose(self._twist.v / 40, 0.0, self._twist.w / 40)
        scan = None
        if self._frames % 4 == 0:
            ranges = np.full(LASER.beams, 3.0 + 0.001 * (self._frames % 7))
            scan = Scan(stamp=stamp, ranges=ranges, angle_min=LASER.angle_min, angle_step=LASER.angle_step)
        wheels = Wheels(odometry=self._pose, speed=self._twist.v, turn_rate=self._twist.w)
        return SensorFrame(stamp=stamp, wheels=wheels, scan=scan, contact=self._contact, truth=self._pose)

    @property
    def requests(self) -> Requests:
        return (ReadTwist, Touch, Sleep, Break, Fly)

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        return cast(AnswerT, self._answer(request))

    def _answer(self, request: RobotRequest[Any]) -> msgspec.Struct:
        match request:
            case ReadTwist():
                return BaseState(self._twist.v, self._twist.w, self._pose.x)
            case Touch(value=value):
                self._contact = value
                return Acknowledged()
            case Sleep(value=value):
                time.sleep(value)
                return Acknowledged()
            case Break():
                raise RuntimeError("a fault in the driver")
            case _:
                raise Refused("The tiny robot does not do that.")

    def close(self) -> None: ...


def open_robot(rest: str, *, seed: int, settings: Any) -> TinyRobot:
    del seed, settings
    if rest == "refuse":
        raise Unavailable("The tiny robot is not at home.")
    if rest == "break":
        raise ZeroDivisionError
    if rest == "slow":
        time.sleep(20.0)
    return TinyRobot(rest)


if __name__ == "__main__":
    SCHEMES["tiny"] = TINY
    main()
