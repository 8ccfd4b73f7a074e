"""CONTINUE x METERS: the robot continues x metres straight with its current direction."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from core.commands.command import Action, Command, CommandPreview, CommandSpec, Parameter, Progress
from core.gate import ZERO
from core.geometry import Pose
from core.navigation.control_context import ControlContext
from core.navigation.obstacle import why_no_headway
from core.navigation.steering import Arrival, StallDetector, hold_line
from core.sentences import Statement


@dataclass(frozen=True, kw_only=True)
class Continue(CommandSpec):
    """Straight ahead for a distance."""

    name: str = "continue"
    words: tuple[str, ...] = ("continue {distance_m} meters",)
    numbers: tuple[Parameter, ...] = (
        Parameter(name="distance_m", says="x", unit="m", low=0.01, high=20.0, spoken_high=5.0),
    )
    example: str = "continue 1.5 meters"
    summary: str = "Drives straight ahead for that many metres."
    icon: str = "continue"

    def preview(self, numbers: Mapping[str, float], pose: Pose, radius: float) -> CommandPreview:
        """Return the line ahead."""
        end = pose @ Pose(numbers["distance_m"], 0.0, 0.0)
        return CommandPreview.straight(pose, (end.x, end.y))

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Start along the present heading."""
        return Continuing(command.numbers["distance_m"], ctx)


class Continuing:
    """A straight line under way: holds the line through the start by the estimated pose."""

    def __init__(self, distance: float, ctx: ControlContext) -> None:
        """`distance` [m]."""
        self._distance = distance
        self._start = ctx.anchored(ctx.pose)
        self._arrival = Arrival(ctx.steering.distance_tolerance, ctx.steering)
        self._headway = StallDetector(0.02, ctx.steering.stalled_after)
        self._deadline = ctx.stamp + 2 * distance / ctx.body.cruise + 2.0

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        start = self._start()
        end = start @ Pose(self._distance, 0.0, 0.0)
        done = (start.inverse() @ ctx.pose).x
        left = self._distance - done
        there = self._arrival.reached(left, ctx.stamp)
        if self._arrival.settled(ctx.stamp):
            return Progress(finished="done", fraction=1.0)
        twist = ZERO
        if not there:
            twist = hold_line(ctx.pose, start, left, ctx.body.cruise, ctx.body.turn, ctx.steering)
        far = f" {max(done, 0):.2f} of {self._distance:g} m are done."
        if twist.moves and self._headway.lost(left, ctx.stamp):
            return Progress(finished="failed", remark=why_no_headway(ctx.scan_points, ctx.body.radius) + far)
        if ctx.stamp > self._deadline:
            return Progress(finished="failed", remark=Statement("command.way_too_long") + far)
        return Progress(
            twist=twist,
            fraction=min(1.0, max(0.0, done / self._distance)),
            path=np.array([[ctx.pose.x, ctx.pose.y], [end.x, end.y]]),
            goal=np.array([end.x, end.y]),
        )


CONTINUE = Continue()
