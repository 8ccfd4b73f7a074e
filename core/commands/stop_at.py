"""STOP AT x AND y: the robot moves towards the goal point (x, y) and stops there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from core.commands.command import Action, Command, Number, Progress
from core.errors import Refused
from core.gate import ZERO
from core.navigation.obstacle import free_space, why_no_headway
from core.navigation.planner import is_free, plan
from core.navigation.steering import Arrival, Headway, Pursuit
from core.navigation.surroundings import Surroundings
from core.navigation.terrain import survey


@dataclass(frozen=True)
class StopAt:
    """To a place in the world frame."""

    name: str = "stop_at"
    words: tuple[str, ...] = (
        "stop at {x_m} and {y_m}",
        "stop at {x_m} and {y_m} meters",
        "stop at {x_m} meters and {y_m} meters",
        "go to {x_m} and {y_m}",
        "go to {x_m} and {y_m} meters",
        "go to {x_m} meters and {y_m} meters",
    )
    numbers: tuple[Number, ...] = (
        Number(name="x_m", says="x", unit="m", low=-20.0, high=20.0, spoken_high=5.0),
        Number(name="y_m", says="y", unit="m", low=-20.0, high=20.0, spoken_high=5.0),
    )
    example: str = "stop at 1 and 0.5"
    summary: str = "Drives to the point (x, y) of the map and stops there."
    moves: bool = True

    def begin(self, command: Command, here: Surroundings) -> Action:
        """Plan the way. Raises Refused with a sentence when there is none."""
        return Going((command.numbers["x_m"], command.numbers["y_m"]), here)


class Going:
    """A way under way: follows the plan, plans anew where it is blocked, and waits a little when there is no way."""

    LOOK_EVERY = 0.2  # [s]
    PLAN_EVERY = 1.0  # [s]
    WAIT = 5.0  # [s] for a way to open again

    def __init__(self, goal: tuple[float, float], here: Surroundings) -> None:
        """`goal` (x, y) [m], world. Raises Refused."""
        self._goal = goal
        self._whole = max(here.pose.distance_to(*goal), 1e-6)
        self._arrival = Arrival(here.steering.goal_tolerance, here.steering)
        self._deadline = self._looked = here.stamp
        self._shut = ""  # why there is no way at the moment
        self._shut_since = here.stamp
        self._set_out(here)

    def drive(self, here: Surroundings) -> Progress:
        """One frame further."""
        self._look(here)
        left = here.pose.distance_to(*self._goal)
        fraction, goal = min(1.0, max(0.0, 1 - left / self._whole)), np.array(self._goal)
        if self._shut:
            waited = here.stamp - self._shut_since > self.WAIT
            return Progress(finished="failed" if waited else "", remark=self._shut, fraction=fraction, goal=goal)
        if here.stamp > self._deadline:
            return Progress(finished="failed", remark=f"The way took too long; the goal is {left:.2f} m away.")
        there = self._arrival.reached(left, here.stamp)
        if self._arrival.settled(here.stamp):
            return Progress(finished="done", fraction=1.0, goal=goal)
        space = free_space(here.scan_points, here.body.radius)
        twist = ZERO if there else self._pursuit.steer(here.pose, here.body.cruise, here.body.turn, space)
        if twist.moves and self._headway.lost(self._pursuit.effort(here.pose), here.stamp):
            return Progress(finished="failed", remark=why_no_headway(here.scan_points, here.body.radius))
        return Progress(twist=twist, fraction=fraction, path=self._pursuit.rest, goal=goal)

    def _set_out(self, here: Surroundings) -> None:
        """Plan from here and follow that. Raises Refused."""
        self._planned = here.stamp
        seen = here.pose.apply(here.scan_points)
        way = plan(here.grid, seen, here.pose, self._goal, here.body.radius, here.planner)
        self._pursuit = Pursuit(way, here.steering)
        self._headway = Headway(0.03, here.steering.stalled_after)
        length = float(np.hypot(*np.diff(way, axis=0).T).sum())
        allowance = 2 * (length / here.body.cruise + math.pi / here.body.turn) + 2.0
        self._deadline = max(self._deadline, here.stamp + allowance)

    def _look(self, here: Surroundings) -> None:
        """See whether the way is still free; plan anew where it is not."""
        if here.stamp - self._looked < self.LOOK_EVERY:
            return
        self._looked = here.stamp
        rest = np.vstack(((here.pose.x, here.pose.y), self._pursuit.rest))
        low, high = rest.min(axis=0) - 0.5, rest.max(axis=0) + 0.5
        terrain = survey(here.grid, here.pose.apply(here.scan_points), low, high, here.planner.occupied)
        if is_free(terrain, rest, here.body.radius, here.planner):
            self._shut = ""
        elif here.stamp - self._planned >= self.PLAN_EVERY:
            try:
                self._set_out(here)
                self._shut = ""
            except Refused as refusal:
                self._shut_since = self._shut_since if self._shut else here.stamp
                self._shut = str(refusal)


STOP_AT = StopAt()
