"""FOLLOW WALL: the robot keeps moving parallel to the wall on its right side at a distance of 0.5 m."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from core.commands.command import Action, Command, CommandSpec, Parameter, Progress
from core.errors import Refused
from core.gate import Twist
from core.message import Array
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalAim, GoalController
from core.navigation.obstacle import free_space, why_no_headway
from core.navigation.steering import Pursuit, StallDetector, Travel
from core.navigation.wall import MIN_PLACE_GAP_M, RightWall, WallLine, walls_on_the_right
from core.sentences import Statement

MAX_PLACES = 6  # at the wall that are tried
AT_THE_WALL = "Following the wall on the right"
LOST = Statement("wall.gone")


@dataclass(frozen=True, kw_only=True)
class FollowWall(CommandSpec):
    """Along the wall on the right, until another command."""

    name: str = "follow_wall"
    words: tuple[str, ...] = ("follow wall", "follow the wall")
    numbers: tuple[Parameter, ...] = (
        Parameter(name="distance_m", says="0.5", unit="m", low=0.5, high=0.5, default=0.5),
    )
    example: str = "follow wall"
    summary: str = "Drives along the wall on its right, half a metre away, until another command."
    endless: bool = True
    already: str = Statement("command.already_at_wall")
    icon: str = "follow_wall"
    fixed: Mapping[str, str] = field(default_factory=lambda: {"side": "right"})
    pronunciations: Mapping[str, str] = field(default_factory=lambda: {"wall": "W AA L", "follow": "TH AA L OW"})
    """"Caught" said as "cot", and an F blurred by a room, which is taken for a TH first (Miller and Nicely 1955)."""

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Find the wall. Raises Refused with a sentence when there is none."""
        return FollowingWall(command.numbers["distance_m"], ctx)


class FollowingWall:
    """A wall under way: first to it, then along it."""

    LOOK_EVERY = 0.1  # [s]: a turn of the laser
    BACK_UP_M = 0.12  # [m] that it backs up when something holds it
    BACK_SPEED = 0.05  # [m/s]
    MAX_TRIES = 3  # times that it backs up without getting on in between

    def __init__(self, distance: float, ctx: ControlContext) -> None:
        """`distance` [m]. Raises Refused."""
        self._distance = distance
        self._wall = RightWall(ctx.wall)
        self._travel = Travel(ctx.pose)
        self._headway = StallDetector(0.05, ctx.steering.stalled_after)
        self._looked = self._seen = -math.inf
        self._line: WallLine | None = None
        self._pursuit: Pursuit | None = None
        self._back_until, self._tries, self._tried_at = -math.inf, 0, 0.0
        self._shut: list[Array] = []  # (2,) [m] each, world: places at the wall that nothing leads to
        self._towards, self._far = np.zeros(2), 0.0
        self._approach = self._to_the_wall(ctx)

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        if self._approach is not None:
            return self._come(self._approach, ctx)
        self._look(ctx)
        if self._line is None or self._pursuit is None:
            lost = ctx.stamp - self._seen > ctx.wall.lost_after
            return Progress(finished="failed" if lost else "", remark=LOST if lost else "Where is the wall?")
        gone = self._travel.gone(ctx.pose)
        if ctx.stamp < self._back_until:
            self._headway = StallDetector(0.05, ctx.steering.stalled_after)
            words = why_no_headway(ctx.scan_points, ctx.body.radius, back_up=True)
            return Progress(twist=Twist(-self.BACK_SPEED, 0.0), remark=words)
        space = free_space(ctx.scan_points, ctx.body.radius)
        twist = self._pursuit.steer(ctx.pose, ctx.body.cruise, ctx.body.turn, space)
        if twist.moves and self._headway.lost(-gone, ctx.stamp):
            return self._held(ctx, gone)
        opening = "" if self._line.gap is None else f", past an opening of {self._line.gap:.1f} m"
        return Progress(twist=twist, remark=f"{AT_THE_WALL}{opening}.", path=self._pursuit.rest)

    def _to_the_wall(self, ctx: ControlContext) -> GoalController | None:
        """Plan to the nearest wall on the right at which there is room; None where it is near already.

        Raises Refused.
        """
        places = walls_on_the_right(ctx.pose, ctx.scan_points, ctx.wall)
        if not len(places):
            raise Refused(Statement("wall.none", reach=f"{ctx.wall.seek:g}"))
        robot = np.array([ctx.pose.x, ctx.pose.y])
        away = np.hypot(*(robot - places).T)
        if away[0] <= self._distance + ctx.wall.near:
            return None
        why = ""
        for found, far in zip(places[:MAX_PLACES], away.tolist(), strict=False):
            if any(math.dist(found, shut) < MIN_PLACE_GAP_M for shut in self._shut):
                continue
            out = (robot - found) / far
            x, y = (found + self._distance * out).tolist()
            try:
                approach = GoalController(GoalAim(x=x, y=y, heading=math.atan2(-out[0], out[1])), ctx)
            except Refused as refusal:
                why = why or str(refusal)
                continue
            self._towards, self._far = found, far
            return approach
        raise Refused(why or Statement("wall.no_room"))

    def _come(self, approach: GoalController, ctx: ControlContext) -> Progress:
        """To the wall first; to another place at it where this one turns out to be shut."""
        step = approach.drive(ctx)
        if step.state == "stuck":
            self._shut.append(self._towards)
            try:
                self._approach = self._to_the_wall(ctx)
            except Refused:
                return Progress(finished="failed", remark=f"I cannot get to the wall. {step.words}")
        if step.state == "there":
            self._approach = None
            self._travel = Travel(ctx.pose)
        words = step.words or Statement("wall.to_it_first", far=f"{self._far:.1f}")
        return Progress(twist=step.twist, remark=words, path=step.path, goal=step.stand)

    def _look(self, ctx: ControlContext) -> None:
        if ctx.stamp - self._looked < self.LOOK_EVERY - 1e-6:
            return
        self._looked = ctx.stamp
        self._wall.see(ctx.pose, ctx.scan_points, ctx.stamp)
        self._line = self._wall.line(ctx.pose, self._distance)
        if self._line is None:
            self._pursuit = None
            self._seen = ctx.stamp if self._seen == -math.inf else self._seen
            return
        self._seen = ctx.stamp
        turning = self._pursuit is not None and self._pursuit.turning
        self._pursuit = Pursuit(self._line.path, ctx.steering, turn_first=turning)

    def _held(self, ctx: ControlContext, gone: float) -> Progress:
        self._tries = self._tries + 1 if gone - self._tried_at < 1.0 else 1
        self._tried_at = gone
        if self._tries > self.MAX_TRIES:
            return Progress(finished="failed", remark=why_no_headway(ctx.scan_points, ctx.body.radius))
        self._back_until = ctx.stamp + self.BACK_UP_M / self.BACK_SPEED
        words = why_no_headway(ctx.scan_points, ctx.body.radius, back_up=True)
        return Progress(twist=Twist(-self.BACK_SPEED, 0.0), remark=words)


FOLLOW_WALL = FollowWall()
