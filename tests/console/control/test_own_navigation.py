"""Goals for the robot's own navigation: they are admitted as any motion, and every end of a command ends them."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from console.access.logins import Person
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.own_navigation import DRIVES, OwnNavigationService
from console.http.problems import Problem
from core.errors import Unavailable
from core.geometry import Pose
from core.robots import Profile
from core.robots.requests import CancelGoal, OwnNavigation, PlanarPose, SendGoal
from tests.console.live import until

OPERATOR, VIEWER = Person("ada-1", "Ada", "operator"), Person("bob-1", "Bob", "viewer")


class FakeLink:
    """A link that only answers for the robot's own navigation."""

    def __init__(self) -> None:
        self.profile = Profile(name="x", url="x:", capabilities=frozenset({"drive", "navigate"}))
        self.trouble, self.asked = "", []
        self.goal: PlanarPose | None = None

    def ask(self, request: Any, timeout: float = 2.0) -> OwnNavigation:
        self.asked.append(request)
        if isinstance(request, SendGoal):
            self.goal = PlanarPose(x_m=request.x_m, y_m=request.y_m, heading_rad=request.heading_rad)
        if isinstance(request, CancelGoal):
            self.goal = None
        pose = PlanarPose(x_m=0.0, y_m=0.0, heading_rad=0.0)
        return OwnNavigation(
            map=None, map_number=0, pose=pose, stamp_s=0.0, known_from="/tf", takes_goals="/goal_pose", goal=self.goal
        )

    def link(self) -> tuple[str, float]:
        return "live", 0.0

    def status(self) -> Any:
        return SimpleNamespace(state="armed")

    def __getattr__(self, name: str) -> Any:
        return lambda *_, **__: True


def parts(home: Path, robot: FakeLink | None = None) -> tuple[FakeLink, CommandDispatcher, OwnNavigationService]:
    robot, board = robot or FakeLink(), Notifications()
    history = History(home, lambda _: None)
    history.open()
    dispatcher = CommandDispatcher(robot, Lease(), history, board)  # type: ignore[arg-type]
    dispatcher.pilot = robot  # type: ignore[assignment]
    service = OwnNavigationService(robot, dispatcher, history, board)  # type: ignore[arg-type]
    dispatcher.when_cancelled.append(service.stop_soon)
    return robot, dispatcher, service


ENDS = ["stop", "halt", "lease"]


def end_by(dispatcher: CommandDispatcher, end: str) -> None:
    if end == "lease":
        dispatcher.forget(OPERATOR)
    else:
        getattr(dispatcher, end)(VIEWER, "rest")


@pytest.mark.parametrize("end", ENDS)
def test_a_goal_needs_the_lease_and_ends_with_any_stop(tmp_path: Path, end: str) -> None:
    async def run() -> None:
        robot, dispatcher, service = parts(tmp_path)
        with pytest.raises(Problem):
            await service.go(Pose(1.0, 2.0, 0.0), VIEWER, on_own_map=True)
        dispatcher.stop(OPERATOR, "rest")
        await asyncio.sleep(0.05)
        assert robot.asked == []  # nothing is sent unless someone asks
        await service.go(Pose(1.0, 2.0, 0.0), OPERATOR, on_own_map=True)
        assert dispatcher._lease.held_by(OPERATOR) and robot.goal is not None
        assert DRIVES in [notice.text for notice in service._notifications.shown]
        end_by(dispatcher, end)
        await until(lambda: robot.goal is None)
        assert isinstance(robot.asked[-1], CancelGoal)

    asyncio.run(run())


@pytest.mark.parametrize("end", ENDS)
def test_a_stop_before_a_goal_is_sent_keeps_it_back(tmp_path: Path, end: str) -> None:
    async def run() -> None:
        robot, dispatcher, service = parts(tmp_path)
        async with service._one_at_a_time:  # a look is under way
            going = asyncio.create_task(service.go(Pose(1.0, 2.0, 0.0), OPERATOR, on_own_map=True))
            await until(lambda: dispatcher._lease.held_by(OPERATOR))
            end_by(dispatcher, end)
        with pytest.raises(Problem) as refused:
            await going
        assert refused.value.status == 409 and robot.asked == []

    asyncio.run(run())


def test_a_goal_without_an_answer_in_time_may_drive_and_is_cancelled(tmp_path: Path) -> None:
    class SlowLink(FakeLink):
        def ask(self, request: Any, timeout: float = 2.0) -> OwnNavigation:
            answer = super().ask(request)
            if isinstance(request, SendGoal):
                raise Unavailable("The robot did not answer within 2 s.")
            return answer

    async def run() -> None:
        robot, _, service = parts(tmp_path, SlowLink())
        with pytest.raises(Unavailable):
            await service.go(Pose(1.0, 0.0), OPERATOR, on_own_map=True)
        await until(lambda: isinstance(robot.asked[-1], CancelGoal) and robot.goal is None)

    asyncio.run(run())
