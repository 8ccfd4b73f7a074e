"""The hands that hold up a chessboard in the simulated room, and move it smoothly."""

from __future__ import annotations

import msgspec

from core.errors import BadInput
from core.geometry import Pose
from core.robots import Profile
from core.robots.requests import PlaceBoard, PlacedBoard
from core.simulation.actors.board_holder import holding_asked_for, seconds_asked_for, world_without
from core.simulation.actors.board_trajectory import BoardTrajectory
from core.simulation.actors.requests import BOARD, HOLDER
from core.simulation.world import World


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
