"""Someone in the simulated room shows the gestures; what stands in the way is said before any picture is taken."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any, cast

import pytest

from console.people.demo import DemoPerson
from console.people.enrollment import EnrollmentSession
from core.errors import Refused
from core.robots.requests import AnswerT, CarryRobot, PlaceThing, ReadPlan, RobotRequest
from core.simulation.robot import SimulatedRobot


def shown(robot: SimulatedRobot) -> list[str]:
    """Let someone show the gestures → the pictures that were taken before that ended. Raises Refused."""
    taken: list[str] = []

    async def ask(request: RobotRequest[AnswerT]) -> AnswerT:
        return robot.ask(request)

    async def capture(_: EnrollmentSession, what: str) -> None:
        taken.append(what)
        raise StopAsyncIteration

    async def sit() -> None:
        person = DemoPerson(cast(Any, ask), robot.profile.camera, 0)
        with contextlib.suppress(StopAsyncIteration):
            await person.sit(cast(EnrollmentSession, None), capture)

    asyncio.run(sit())
    return taken


def test_the_empty_room_comes_first_and_nobody_is_left_in_it() -> None:
    robot = SimulatedRobot("lab", seed=1)
    before = robot.ask(ReadPlan()).things
    assert shown(robot) == ["background"]
    assert robot.ask(ReadPlan()).things == before


def test_who_stands_before_the_camera_is_named() -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(PlaceThing("person", 2.0, 0.4, 0.0, id="Bob"))
    with pytest.raises(Refused, match=r"Bob stands before the camera.*Turn the robot"):
        shown(robot)
    robot.ask(PlaceThing("person", -0.8, 0.4, 0.0, id="Bob"))
    assert shown(robot) == ["background"]


def test_a_wall_before_the_camera_is_said_before_a_picture_is_taken() -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(CarryRobot(x_m=-1.2, y_m=0.0, heading_rad=3.14))
    with pytest.raises(Refused, match="no room to stand whole"):
        shown(robot)
