"""The hands that hold up a chessboard in the simulated room, and move it smoothly."""

from dataclasses import dataclass, replace

import cv2
import msgspec

from core.errors import BadInput
from core.geometry import Pose, Transform, wrap
from core.robots import Profile
from core.robots.requests import PlaceBoard, PlacedBoard
from core.simulation.actors.board_holder import HeldBoardRequest, holding_asked_for, seconds_asked_for, world_without
from core.simulation.actors.requests import BOARD, HOLDER
from core.simulation.world import HeldBoard, Thing, World


@dataclass(frozen=True)
class BoardTrajectory:
    """From `start` at time `begun` [s] to `end`, `seconds` later."""

    start: HeldBoardRequest
    end: HeldBoardRequest
    begun: float
    seconds: float

    def over(self, stamp: float) -> bool:
        """Return whether the board has arrived at `stamp` [s]."""
        return stamp >= self.begun + self.seconds

    def at(self, stamp: float) -> HeldBoardRequest:
        """Return the board and its holder at `stamp` [s]."""
        share = (stamp - self.begun) / self.seconds if self.seconds > 0 else 1.0
        if share >= 1:
            return self.end
        gone = smooth(max(share, 0.0))
        return HeldBoardRequest(_board(self.start.board, self.end.board, gone), _holder(self.start, self.end, gone))


def smooth(share: float) -> float:
    """Share of the time (0..1) → share of the way, without a jerk at either end (least-jerk polynomial)."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def _board(start: HeldBoard, end: HeldBoard, gone: float) -> HeldBoard:
    """The middle goes straight while the board turns about one axis."""
    turn, _ = cv2.Rodrigues(end.pose.rotation @ start.pose.rotation.T)
    rotation = cv2.Rodrigues(gone * turn)[0] @ start.pose.rotation
    place = start.place + gone * (end.place - start.place)
    return replace(end, pose=Transform(rotation=rotation, translation=place - rotation @ end.middle))


def _holder(start: HeldBoardRequest, end: HeldBoardRequest, gone: float) -> Thing | None:
    if start.holder is None or end.holder is None:
        return end.holder
    a, b = start.holder.pose, end.holder.pose
    heading = wrap(a.heading + gone * wrap(b.heading - a.heading))
    return replace(end.holder, pose=Pose(a.x + gone * (b.x - a.x), a.y + gone * (b.y - a.y), heading))


class BoardMotion:
    """The board's place at every instant, if there is a board. Owned by the simulated robot."""

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self._trajectory: BoardTrajectory | None = None

    def hold(self, request: PlaceBoard, world: World, robot: Pose, now: float) -> PlacedBoard:
        """Begin the request at `now` [s] → what is held, and how long the way takes.

        A board that was not there before is in its place at once. BadInput says what is wrong.
        """
        seconds = seconds_asked_for(request)
        wanted = holding_asked_for(request, world, robot, self._profile.radius, self._profile.camera)
        start = None if self._trajectory is None else self._trajectory.at(now)
        self._trajectory = BoardTrajectory(start or wanted, wanted, now, seconds if start else 0.0)
        return msgspec.structs.replace(wanted.described, seconds=self._trajectory.seconds)

    def put_down(self, name: str) -> None:
        """Take the board away. BadInput when there is none, or only its holder is named."""
        if self._trajectory is None:
            raise BadInput("There is no chessboard in the room.")
        if name == HOLDER:
            raise BadInput(f"The board's holder goes with it; remove the id {BOARD}.")
        self._trajectory = None

    def in_world(self, world: World, stamp: float) -> World:
        """The world as it is at `stamp` [s]: the same object while nothing moves."""
        if self._trajectory is None:
            return world if world.board is None else world_without(world)
        holding = self._trajectory.at(stamp)
        return world if world.board is holding.board else holding.put(world)

    def described(self, stamp: float) -> list[PlacedBoard]:
        """The board as the list of things has it, if there is one."""
        return [] if self._trajectory is None else [self._trajectory.at(stamp).described]
