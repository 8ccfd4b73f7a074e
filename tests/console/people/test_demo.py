"""Someone in the simulated room shows the gestures; what stands in the way is said before any picture is taken."""

import asyncio
import contextlib
import math
from typing import Any, cast

import pytest

from console.people.demo import DemoPerson
from console.people.enrollment import EnrollmentSession
from core.errors import Refused
from core.robots.requests import AnswerT, CarryRobot, PlacedThing, PlaceThing, ReadPlan, RobotRequest
from core.simulation.robot import SimulatedRobot


def shown(robot: SimulatedRobot, person: str = "") -> list[str]:
    """Let someone show the gestures → who is in the room at each picture before that ended. Raises Refused."""
    taken: list[str] = []

    async def ask(request: RobotRequest[AnswerT]) -> AnswerT:
        return robot.ask(request)

    async def capture(_: EnrollmentSession, what: str) -> None:
        taken.append(" ".join([what, *(thing.id for thing in people(robot))]))
        raise StopAsyncIteration

    async def sit() -> None:
        demo = DemoPerson(cast(Any, ask), robot.profile.camera, 0, person)
        try:
            with contextlib.suppress(StopAsyncIteration):
                await demo.sit(cast(EnrollmentSession, None), capture)
        finally:
            await demo.leave()

    asyncio.run(sit())
    return taken


def people(robot: SimulatedRobot) -> list[PlacedThing]:
    things = robot.ask(ReadPlan()).things
    people = [thing for thing in things if isinstance(thing, PlacedThing) and thing.what == "person"]
    return sorted(people, key=lambda one: one.id)


def test_the_empty_room_comes_first_and_nobody_is_left_in_it() -> None:
    robot = SimulatedRobot("lab", seed=1)
    before = robot.ask(ReadPlan()).things
    assert shown(robot) == ["background"]
    assert robot.ask(ReadPlan()).things == before


def test_who_is_before_the_camera_leaves_for_that_time_and_is_as_before_afterwards() -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(PlaceThing("person", 2.0, 0.4, 0.7, id="Ann", clothes="red/blue", size_m=1.6, gesture="wave"))
    robot.ask(PlaceThing("person", -0.8, 0.4, 0.0, id="Bob"))
    robot.ask(PlaceThing("person", 2.0, -0.4, 0.0, id="Cleo", path_m=((2.0, 0.0), (1.5, 0.0)), again=True))
    before = {one.id: one for one in people(robot)}
    assert shown(robot) == ["background Bob"]
    assert {one.id: one for one in people(robot)} == before


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (-1.2, 0.0, 3.14)])
def test_an_inhabitant_is_back_however_the_demonstration_ended(pose: tuple[float, float, float]) -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(PlaceThing("person", 2.0, 1.2, 0.7, id="Ann", clothes="red/blue"))
    robot.ask(CarryRobot(*pose))
    before = people(robot)
    with contextlib.suppress(Refused):
        assert shown(robot, "Ann") == ["background"]
    assert people(robot) == before


def test_who_finds_the_robot_in_their_place_comes_back_beside_it() -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(PlaceThing("person", 2.0, 0.0, 0.0, id="Ann"))

    async def sit() -> None:
        async def ask(request: RobotRequest[AnswerT]) -> AnswerT:
            return robot.ask(request)

        async def capture(_: EnrollmentSession, what: str) -> None:
            robot.ask(CarryRobot(x_m=2.0, y_m=0.0))
            raise StopAsyncIteration

        demo = DemoPerson(cast(Any, ask), robot.profile.camera, 0, "Ann")
        with contextlib.suppress(StopAsyncIteration):
            await demo.sit(cast(EnrollmentSession, None), capture)
        await demo.leave()

    asyncio.run(sit())
    (ann,) = people(robot)
    assert ann.id == "Ann" and 0.4 < math.hypot(ann.x_m - 2.0, ann.y_m) < 0.6


@pytest.mark.parametrize("step", range(1, 7))
def test_nobody_is_lost_when_it_is_stopped_at_any_request(step: int) -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(PlaceThing("person", 2.0, 1.2, 0.7, id="Ann", clothes="red/blue"))
    robot.ask(PlaceThing("person", 2.0, -1.0, 0.7, id="Bob"))
    before, asked = people(robot), 0

    async def ask(request: RobotRequest[AnswerT]) -> AnswerT:
        nonlocal asked
        answer, asked = robot.ask(request), asked + 1
        if asked == step:
            raise asyncio.CancelledError  # what was requested is done, and nobody takes the answer
        return answer

    async def capture(_: EnrollmentSession, what: str) -> None:
        raise StopAsyncIteration

    async def sit() -> None:
        demo = DemoPerson(cast(Any, ask), robot.profile.camera, 0)
        with contextlib.suppress(asyncio.CancelledError):
            await demo.sit(cast(EnrollmentSession, None), capture)
        await demo.leave()

    asyncio.run(sit())
    assert people(robot) == before


def test_nobody_of_that_name_is_said_and_nothing_is_taken_away() -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(PlaceThing("box", 2.0, 0.0, 0.0, id="Ann"))
    before = robot.ask(ReadPlan()).things
    with pytest.raises(Refused, match="There is no Ann"):
        shown(robot, "Ann")
    assert robot.ask(ReadPlan()).things == before


def test_a_wall_before_the_camera_is_said_before_a_picture_is_taken() -> None:
    robot = SimulatedRobot("lab", seed=1)
    robot.ask(CarryRobot(x_m=-1.2, y_m=0.0, heading_rad=3.14))
    with pytest.raises(Refused, match="no room to stand whole"):
        shown(robot)
