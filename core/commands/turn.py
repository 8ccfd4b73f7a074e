"""TURN LEFT, TURN RIGHT: the robot turns 90 degrees on the spot."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from core.commands.command import Action, Command, CommandPreview, CommandSpec, Parameter, Progress
from core.gate import Twist
from core.geometry import Pose, wrap
from core.navigation.control_context import ControlContext
from core.navigation.obstacle import why_no_headway
from core.navigation.steering import Arrival, StallDetector, spin
from core.sentences import Statement

JUMP_RAD = 0.05  # beyond the fastest turn, from which the estimate has jumped: the robot's place was found again


@dataclass(frozen=True, kw_only=True)
class Turn(CommandSpec):
    """A turn to one side."""

    side: int  # +1 left, -1 right
    needs_pose: bool = False
    pronunciations: Mapping[str, str] = field(default_factory=lambda: {"turn": "T AH N"})  # without the R
    numbers: tuple[Parameter, ...] = (
        Parameter(name="angle_rad", says="90 degrees", unit="rad", low=0.0, high=2 * math.pi, default=math.pi / 2),
    )

    def preview(self, numbers: Mapping[str, float], pose: Pose, radius: float) -> CommandPreview:
        """Return the arc around the robot."""
        return CommandPreview.turn(pose, self.side * numbers["angle_rad"], radius)

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Start turning from the present heading."""
        return Turning(self.side * command.numbers["angle_rad"], ctx)


class Turning:
    """A turn under way: closes the heading that the estimator reports, and waits until it stays.

    Where the estimate jumps, the wheels say how far the robot turned.
    """

    def __init__(self, angle: float, ctx: ControlContext) -> None:
        """`angle` [rad], counter-clockwise."""
        self._angle = angle
        self._left = angle
        self._heading, self._stamp = ctx.pose.heading, ctx.stamp
        self._arrival = Arrival(ctx.steering.heading_tolerance, ctx.steering)
        self._headway = StallDetector(0.05, ctx.steering.stalled_after)
        self._deadline = ctx.stamp + 2 * abs(angle) / ctx.body.turn + 2.0 + ctx.steering.settle

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        self._left -= self._turned(ctx)
        soon = self._left - ctx.turn_rate * ctx.steering.turn_lead
        there = self._arrival.reached(min(abs(soon), abs(self._left)), ctx.stamp)
        if self._arrival.settled(ctx.stamp):
            return Progress(finished="done", fraction=1.0)
        rate = 0.0 if there else spin(soon, ctx.body.turn, ctx.steering)
        if rate and self._headway.lost(abs(self._left), ctx.stamp):
            return Progress(finished="failed", remark=why_no_headway(ctx.scan_points, ctx.body.radius))
        if ctx.stamp > self._deadline:
            return Progress(finished="failed", remark=Statement("command.turn_too_long"))
        return Progress(twist=Twist(0.0, rate), fraction=max(0.0, 1 - abs(self._left) / max(abs(self._angle), 1e-6)))

    def _turned(self, ctx: ControlContext) -> float:
        """Return the turn [rad] since the frame before."""
        turned, elapsed = wrap(ctx.pose.heading - self._heading), ctx.stamp - self._stamp
        self._heading, self._stamp = ctx.pose.heading, ctx.stamp
        jumped = abs(turned) > ctx.body.max_turn_rate * elapsed + JUMP_RAD
        return ctx.turn_rate * elapsed if jumped else turned


TURN_LEFT = Turn(
    name="turn_left",
    words=("turn left",),
    example="turn left",
    summary="Turns left 90 degrees on the spot.",
    side=1,
    icon="turn_left",
)
TURN_RIGHT = Turn(
    name="turn_right",
    words=("turn right",),
    example="turn right",
    summary="Turns right 90 degrees on the spot.",
    side=-1,
    icon="turn_right",
)
