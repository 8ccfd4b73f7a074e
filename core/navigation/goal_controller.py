"""The goal controller: drive to a place, up to a person, or after a person, with a goal that may move."""

import math
from dataclasses import replace
from typing import Literal

import numpy as np

from core.errors import Refused
from core.gate import ZERO, Twist
from core.geometry import wrap
from core.message import Array, message
from core.navigation.control_context import ControlContext
from core.navigation.costmap import Costmap, survey
from core.navigation.obstacle import free_space, obstacle_ahead, why_no_headway
from core.navigation.planner import PERSON_RADIUS_M, PlannerSettings, is_free, plan, plan_beside
from core.navigation.steering import Arrival, Pursuit, StallDetector, Travel, spin
from core.sentences import Statement


@message
class GoalAim:
    """A place to stand at, its distance and heading."""

    x: float  # [m] world: the place, or who stands there
    y: float  # [m]
    keep: float = 0.0  # [m] from there to stand: 0 = on the spot; else with nothing in between, and facing it
    heading: float | None = None  # [rad], world, to look in the end; None: as it comes


State = Literal["under way", "there", "waiting", "backing", "stuck"]


@message
class GoalStep:
    """The result of one frame."""

    state: State  # "stuck" is for good: nothing helped, the words say what blocks and what to do
    left: float  # [m] along the way, 0 when there
    path: Array  # (R, 2) [m], world: what lies ahead
    stand: Array  # (2,) [m], world: where it will stand
    twist: Twist = ZERO
    words: str = ""  # a sentence for the operator: why it waits, backs up or is stuck


class GoalController:
    """Plans, steers, looks, plans again when the way closes or the aim moves, waits, backs up, and asks.

    COME HERE: `GoalController(GoalAim(x=…, y=…, keep=0.5), here)`, then `drive(here)` with every frame until its
    state is "there" (facing the person, at rest) or "stuck". FOLLOW ME: `GoalController(…, here, lasting=True)` and
    a fresh aim with every frame, `drive(here, aim)`: near enough it stands and faces, farther away it sets out
    again; "there" is then no end. Raises Refused with a sentence when there is no way at the start; later it
    waits instead.
    """

    LOOK_EVERY = 0.2  # [s]
    MAX_DEFERRAL_S = 0.1  # [s] by which that may wait for a frame without picture and scan, which take their time
    PLAN_EVERY = 1.0  # [s] where the way is shut
    FOLLOW_EVERY = 0.4  # [s] where the aim moves
    MOVED_AIM_M = 0.1  # [m] from which an aim has moved
    MAX_WAIT_S = 5.0  # [s] for a way to open again
    BACK_UP_M = 0.15  # [m] that it backs up out of a tight place
    BACK_SPEED = 0.05  # [m/s]
    MAX_TRIES = 2  # times that it backs up, each time planning more carefully
    CAUTION_STEP_M = 0.03  # [m] more around the body after each
    FACING_RAD = 0.03  # [rad] within which it faces what it should
    SLACK_M = 0.04  # [m] around the distance that is kept from what moves
    MAX_DETOURS = 3  # in a row, each shut when it was come near, after which there is no way
    MIN_DETOUR_M = 0.3  # [m] by which a detour is longer than what was left of the way
    FORGET_DETOURS_M = 0.5  # [m] by which less must be left than ever before so that detours are forgotten
    MIN_GAIN_M = 0.1  # [m] of way that is gained again and again, whatever is planned meanwhile
    GAIN_TIME_S = 30.0  # [s] in which it is

    def __init__(
        self, aim: GoalAim, ctx: ControlContext, *, lasting: bool = False, cruise: float | None = None
    ) -> None:
        """`lasting`: the aim will move and being there is no end; `cruise` [m/s]: None, as the body does."""
        steering = ctx.steering
        self._aim, self._lasting = aim, lasting
        self._cruise = min(cruise or ctx.body.cruise, ctx.body.max_speed)
        self._arrival = Arrival(self.SLACK_M if lasting else steering.goal_tolerance, steering)
        self._faced = Arrival(self.FACING_RAD, steering)
        self._shut = ""  # why there is no way at the moment
        self._tries = 0
        self._back_from: tuple[float, float] | None = None
        self._detours, self._least_left = 0, math.inf
        self._gain = self._gains()
        self._began = self._looked = self._shut_since = ctx.stamp
        self._pursuit: Pursuit | None = None
        self._headway = _headway(ctx)
        self._travel = Travel(ctx.pose)
        self._allowance = self._set_out(ctx)

    def drive(self, ctx: ControlContext, aim: GoalAim | None = None) -> GoalStep:
        """Take one frame towards the former aim, or towards this new one."""
        if aim is not None:
            self._aim = aim
        self._look(ctx)
        if self._back_from is not None:
            return self._back(ctx)
        left = self._left(ctx)
        if self._arrival.reached(left, ctx.stamp):
            self._headway = _headway(ctx)
            return self._face(ctx)
        if self._shut:
            self._headway = _headway(ctx)
            return self._wait(ctx, left)
        if not self._lasting and ctx.stamp > self._began + self._allowance:
            return self._say("stuck", left, Statement("command.way_too_long_left", left=f"{left:.2f}"))
        gains_nothing = self._gain.lost(self._way.left(ctx.pose), ctx.stamp) and not self._lasting
        if gains_nothing or self._detours > self.MAX_DETOURS:
            return self._say("stuck", left, Statement("way.shut_again"))
        space = free_space(ctx.scan_points, ctx.body.radius)
        twist = self._way.steer(ctx.pose, self._cruise, ctx.body.turn, space)
        if twist.moves and self._headway.lost(self._effort(ctx), ctx.stamp):
            return self._stalled(ctx, left)
        return self._say("under way", left, twist=twist)

    def _gains(self) -> StallDetector:
        return StallDetector(self.MIN_GAIN_M, self.GAIN_TIME_S)

    @property
    def _way(self) -> Pursuit:
        assert self._pursuit is not None, "a way was planned at the start"
        return self._pursuit

    def _effort(self, ctx: ControlContext) -> float:
        """Return a length [m] that falls with progress: the way left; towards a moving aim, minus the way gone."""
        if not self._lasting:
            return self._way.effort(ctx.pose)
        return -self._travel.gone(ctx.pose)

    def _left(self, ctx: ControlContext) -> float:
        """Return the distance to the place to stand [m]; 0 within the distance to keep if nothing is between."""
        x, y = self._way.path[-1]
        left = ctx.pose.distance_to(float(x), float(y))
        if self._aim.keep == 0.0:
            return left
        beyond = ctx.pose.distance_to(self._aim.x, self._aim.y) - self._aim.keep
        return min(left, max(0.0, beyond)) if self._open else left

    def _say(self, state: State, left: float, words: str = "", twist: Twist = ZERO) -> GoalStep:
        way = self._way
        return GoalStep(state=state, left=left, path=way.rest, stand=way.path[-1], twist=twist, words=words)

    def _face(self, ctx: ControlContext) -> GoalStep:
        heading = self._aim.heading
        if heading is None and self._aim.keep > 0.0:
            heading = math.atan2(self._aim.y - ctx.pose.y, self._aim.x - ctx.pose.x)
        error = 0.0 if heading is None else wrap(heading - ctx.pose.heading)
        soon = error - ctx.turn_rate * ctx.steering.turn_lead
        if not self._faced.reached(abs(error), ctx.stamp):
            return self._say("under way", 0.0, twist=Twist(0.0, spin(soon, ctx.body.turn, ctx.steering)))
        settled = self._arrival.settled(ctx.stamp) and self._faced.settled(ctx.stamp)
        return self._say("there" if settled else "under way", 0.0)

    def _wait(self, ctx: ControlContext, left: float) -> GoalStep:
        if ctx.stamp - self._shut_since <= self.MAX_WAIT_S:
            return self._say("waiting", left, self._shut)
        if self._tries < self.MAX_TRIES and self._tight(ctx):
            return self._stalled(ctx, left)
        return self._say("stuck", left, self._shut)

    def _stalled(self, ctx: ControlContext, left: float) -> GoalStep:
        if not self._tight(ctx) or self._tries >= self.MAX_TRIES:
            return self._say("stuck", left, why_no_headway(ctx.scan_points, ctx.body.radius))
        self._tries += 1
        self._back_from = ctx.pose.x, ctx.pose.y
        self._back_until = ctx.stamp + 2 * self.BACK_UP_M / self.BACK_SPEED
        return self._back(ctx)

    def _tight(self, ctx: ControlContext) -> bool:
        points, radius = ctx.scan_points, ctx.body.radius
        return (
            free_space(points, radius) < 2 * self.CAUTION_STEP_M
            or obstacle_ahead(points, radius, self.BACK_UP_M) is not None
        )

    def _back(self, ctx: ControlContext) -> GoalStep:
        assert self._back_from is not None
        if ctx.pose.distance_to(*self._back_from) < self.BACK_UP_M and ctx.stamp < self._back_until:
            words = why_no_headway(ctx.scan_points, ctx.body.radius, back_up=True)
            return self._say("backing", self._left(ctx), words, Twist(-self.BACK_SPEED, 0.0))
        self._back_from = None
        self._try_to_set_out(ctx)
        return self._say("waiting" if self._shut else "under way", self._left(ctx), self._shut)

    def _set_out(self, ctx: ControlContext) -> float:
        """Plan from here and follow that → how long it may take [s]. Raises Refused."""
        self._planned, self._planned_for = ctx.stamp, (self._aim.x, self._aim.y)
        cautious = replace(ctx.planner, guard=ctx.planner.guard + self.CAUTION_STEP_M * self._tries)
        try:
            way = self._plan(ctx, cautious)
        except Refused:
            if not self._tries:
                raise
            way = self._plan(ctx, ctx.planner)
        self._pursuit = Pursuit(
            way, ctx.steering, turn_first=not self._lasting or self._pursuit is None or self._pursuit.turning
        )
        if not self._lasting:
            self._headway = _headway(ctx)
        self._open = self._sees_aim(ctx)
        length = float(np.hypot(*np.diff(way, axis=0).T).sum())
        return 3 * (length / self._cruise + 2 * math.pi / ctx.body.turn) + 2.0 + 2 * self.MAX_WAIT_S

    def _plan(self, ctx: ControlContext, settings: PlannerSettings) -> Array:
        seen, place = ctx.pose.apply(ctx.scan_points), (self._aim.x, self._aim.y)
        if self._aim.keep == 0.0:
            return plan(ctx.grid, seen, ctx.pose, place, ctx.body.radius, settings)
        return plan_beside(ctx.grid, seen, ctx.pose, place, self._aim.keep, ctx.body.radius, settings)

    def _try_to_set_out(self, ctx: ControlContext) -> None:
        try:
            self._set_out(ctx)
            self._shut = ""
        except Refused as refusal:
            self._shut_since = self._shut_since if self._shut else ctx.stamp
            self._shut = str(refusal)

    def _look(self, ctx: ControlContext) -> None:
        """See whether the way is still free and leads to the aim; plan again where it does not."""
        passed = ctx.stamp - self._looked
        if passed < self.LOOK_EVERY or (ctx.is_full and passed < self.LOOK_EVERY + self.MAX_DEFERRAL_S):
            return
        self._looked = ctx.stamp
        slack = self.MOVED_AIM_M if self._aim.keep else ctx.steering.goal_tolerance
        moved = math.dist(self._planned_for, (self._aim.x, self._aim.y)) > slack
        if moved and ctx.stamp - self._planned >= self.FOLLOW_EVERY:
            self._try_to_set_out(ctx)
            return
        rest = np.vstack(((ctx.pose.x, ctx.pose.y), self._way.rest))
        self._open = self._sees_aim(ctx)
        left = self._way.left(ctx.pose)
        if left < self._least_left - self.FORGET_DETOURS_M:
            self._detours, self._least_left = 0, left
        if is_free(_terrain(ctx, rest), rest, ctx.body.radius, ctx.planner):
            self._shut = ""
        elif ctx.stamp - self._planned >= self.PLAN_EVERY:
            self._try_to_set_out(ctx)
            longer = not self._shut and self._way.left(ctx.pose) > left + self.MIN_DETOUR_M
            if longer and not self._lasting:
                self._detours, self._gain = self._detours + 1, self._gains()

    def _sees_aim(self, ctx: ControlContext) -> bool:
        """Return whether nothing stands between the robot and the aim; what is near the aim does not count."""
        if self._aim.keep == 0.0:
            return True
        ends = np.array([(ctx.pose.x, ctx.pose.y), (self._aim.x, self._aim.y)])
        far = ctx.pose.distance_to(self._aim.x, self._aim.y)
        shares = np.linspace(
            0.0, max(0.0, 1 - PERSON_RADIUS_M / max(far, 1e-6)), 2 + math.ceil(far / ctx.grid.resolution)
        )
        line = ends[0] + shares[:, None] * (ends[1] - ends[0])
        return bool((_terrain(ctx, ends).clearance_at(line) > 0).all())


def _headway(ctx: ControlContext) -> StallDetector:
    return StallDetector(0.03, ctx.steering.stalled_after)


def _terrain(ctx: ControlContext, places: Array) -> Costmap:
    """The ground around places (N, 2) [m], world, with the newest scan on it."""
    low, high = places.min(axis=0) - 0.5, places.max(axis=0) + 0.5
    return survey(ctx.grid, ctx.pose.apply(ctx.scan_points), low, high, ctx.planner.occupied)
