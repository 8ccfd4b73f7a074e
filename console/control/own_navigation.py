"""The robot's own navigation beside Beckon's: its map and pose for the scene, and goals for it on request.

While it drives, the robot's own software steers it and Beckon's gate does not. Everything that ends a command of
Beckon's ends such a goal, too: STOP, another command, a hand, a lease that lapses.
"""

import asyncio
import logging
from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np

from console.access.logins import Person
from console.control.command_freshness import VOID
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.notices import Notifications
from console.http.problems import Problem
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.workers.tasks import HeldTasks
from core.errors import BadInput, BeckonError, Refused, Unavailable
from core.geometry import Pose
from core.message import Array
from core.robots import requests
from core.sensors import SensorFrame
from core.snapshot import Ending, Snapshot

log = logging.getLogger(__name__)

LOOK_PERIOD_S = 0.5  # between two looks
MAX_HELD_POSES = 200  # poses of Beckon's own that are kept, for the one of a stamp: 5 s
SAME_TIME_S = 0.2  # between a pose on the robot's map and Beckon's own at which they are one
DRIVES = "The robot's own navigation drives now, and Beckon's gate does not look ahead for it. STOP ends it."
UNALIGNED = (
    "The robot does not say where it is on its map, so how that lies to Beckon's is not known: both are drawn "
    "with one origin."
)


@dataclass(frozen=True)
class DecodedMap:
    number: int
    cells: Array  # (H, W) uint8: 0 unknown, 1 free … 101 occupied; row 0 at the highest y
    width: float  # [m]
    height: float  # [m]
    origin: Pose  # of the lower left corner, on the map


@dataclass(frozen=True)
class OwnMapView:
    """The robot's own map, and where it is in Beckon's world."""

    map: DecodedMap
    corner: Pose  # of its lower left corner, world
    robot: Pose | None  # where its own navigation believes to be, world
    aligned: bool  # its place in Beckon's world is known


class OwnNavigationService(Part):
    """Asks the robot twice a second; its methods run on the event loop."""

    def __init__(
        self, robot: RobotSupervisor, dispatcher: CommandDispatcher, history: History, notifications: Notifications
    ) -> None:
        self.shown = True  # in the scene
        self.newest: requests.OwnNavigation | None = None  # its map apart
        self.map: DecodedMap | None = None
        self.map_view: OwnMapView | None = None  # for the scene; None: nothing is shown
        self.own_from_map: Pose | None = None  # where the robot's map lies on Beckon's; None: not known
        self._robot, self._dispatcher = robot, dispatcher
        self._history, self._notifications = history, notifications
        self._poses: deque[tuple[float, Pose]] = deque(maxlen=MAX_HELD_POSES)
        self._ends, self._why_ended = 0, ""  # of commands until now, and why the newest one was
        self._entry = 0  # in the history, of the goal that is under way; 0: none
        self._one_at_a_time = asyncio.Lock()  # a look that began before a goal must not end it
        self._stopping = HeldTasks()

    @property
    def there(self) -> bool:
        return "navigate" in self._robot.profile.capabilities

    @property
    def sentence(self) -> str:
        """How its map lies to Beckon's, or why there is none."""
        if self.newest is not None and self.newest.refused:
            return self.newest.refused
        if self.map is None:
            return "The robot has not published a map yet."
        if self.own_from_map is None:
            return UNALIGNED
        known_from = self.newest.known_from if self.newest is not None else ""
        return f"It lies on Beckon's map as {known_from} and the odometry say."

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Keep where Beckon believed to be, for poses of the same time."""
        self._poses.append((snapshot.stamp, snapshot.estimate.pose))

    async def run(self) -> None:
        while self.there:
            try:
                await self._look()
            except BeckonError as trouble:
                log.debug("The robot's own navigation: %s", trouble)
            await asyncio.sleep(LOOK_PERIOD_S)

    async def go(self, goal: Pose, who: Person, *, on_own_map: bool) -> None:
        """Send a goal on the robot's map, or on Beckon's. Raises Problem 403 to 503 or BeckonError."""
        if not self.there:
            raise Refused("This robot has no navigation of its own.")
        if not on_own_map:
            if self.own_from_map is None:
                raise Refused(UNALIGNED)
            goal = self.own_from_map.inverse() @ goal
        self._dispatcher.admit_own_navigation(who)
        ends = self._ends
        request = requests.SendGoal(x_m=goal.x, y_m=goal.y, heading_rad=goal.heading)
        words = f"goal ({goal.x:.2f}, {goal.y:.2f}) on the robot's own map"
        async with self._one_at_a_time:
            if self._ends != ends:
                raise Problem(409, VOID(what=self._why_ended))
            self._end("pre-empted", "Another goal came after it.")
            self._entry = self._history.add("goal", who, state="running", words=words).id
            try:
                answer = await self._ask(request)
            except BeckonError as why:
                self._end("refused", str(why))
                if isinstance(why, Unavailable):  # it may be on its way all the same
                    self._stopping.start(self._stopped())
                raise
            self._notifications.tell("warning", DRIVES)
            self._take(answer)

    async def stop(self) -> None:
        """Let the robot's own navigation stand, if it drives for Beckon. Raises Refused, Unavailable."""
        if self.there:
            async with self._one_at_a_time:
                answer = await self._ask(requests.CancelGoal())
                self._end("cancelled", "The robot's own navigation was stopped: its present pose is its goal now.")
                self._take(answer)

    def stop_soon(self, state: Ending, why: str, objected: bool) -> None:
        """End a goal that is under way, or may be, without waiting: something else happens."""
        self._ends, self._why_ended = self._ends + 1, why
        goal = self.newest.goal if self.newest is not None else None
        if self._entry or goal is not None:
            self._stopping.start(self._stopped())

    def show(self, shown: bool) -> None:
        self.shown = shown
        self._draw()

    async def _stopped(self) -> None:
        try:
            await self.stop()
        except BeckonError as trouble:
            self._notifications.tell("error", f"The robot's own navigation could not be stopped: {trouble}")

    async def _look(self) -> None:
        known = self.map.number if self.map is not None else 0
        async with self._one_at_a_time:
            self._take(await self._ask(requests.ReadNavigation(known_map=known)))

    async def _ask(self, request: requests.RobotRequest[requests.AnswerT]) -> requests.AnswerT:
        return await asyncio.to_thread(self._robot.ask, request)

    def _take(self, answer: requests.OwnNavigation) -> None:
        if answer.map is not None:
            try:
                self.map = decoded(answer)
            except BadInput as wrong:
                log.warning("The robot's own map: %s", wrong)
        self.newest = answer
        if self._entry and answer.goal is None:
            self._end("done", "The robot's own navigation has ended its way: it reached the goal.")
        self._align(answer)
        self._draw()

    def _end(self, state: str, remark: str) -> None:
        entry, self._entry = self._entry, 0
        if entry:
            self._history.end(entry, state, remark)
            if state in ("done", "cancelled"):
                self._notifications.tell("info", remark)

    def _align(self, answer: requests.OwnNavigation) -> None:
        if answer.pose is None or not self._poses:
            return
        stamp, here = min(self._poses, key=lambda entry: abs(entry[0] - answer.stamp_s))
        if abs(stamp - answer.stamp_s) < SAME_TIME_S:
            self.own_from_map = here @ as_pose(answer.pose).inverse()

    def _draw(self) -> None:
        found = self.map
        if found is None or not self.shown:
            self.map_view = None
            return
        aligned = self.own_from_map or Pose()
        said = self.newest.pose if self.newest is not None else None
        self.map_view = OwnMapView(
            map=found,
            corner=aligned @ found.origin,
            robot=None if said is None else aligned @ as_pose(said),
            aligned=self.own_from_map is not None,
        )


def decoded(answer: requests.OwnNavigation) -> DecodedMap:
    """The map in an answer. Raises BadInput."""
    assert answer.map is not None
    cells = cv2.imdecode(np.frombuffer(answer.map.png, np.uint8), cv2.IMREAD_GRAYSCALE)
    if cells is None:
        raise BadInput("Its picture cannot be read.")
    return DecodedMap(answer.map_number, cells, answer.map.width_m, answer.map.height_m, as_pose(answer.map.origin))


def as_pose(said: requests.PlanarPose) -> Pose:
    """A pose as it was handed on → a pose."""
    return Pose(said.x_m, said.y_m, said.heading_rad)
