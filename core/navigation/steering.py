"""From a path to a speed: regulated pure pursuit, turning on the spot first when the path lies to the side."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from core.gate import Twist
from core.geometry import Pose, wrap
from core.message import Array
from core.setting import Meta, Section


@dataclass(frozen=True)
class SteeringSettings(Section):
    """Gains and tolerances of everything that steers.

    Watch:
        turn_gain: swinging about the heading (then lower it)
        turn_deceleration: turns that overshoot on a heavy robot (then lower it)
        approach_gain: ways that overshoot (then lower it)
        lookahead: swinging about the path (then raise it), cut corners (then lower it)
        slow_within: speed in doors
        heading_tolerance: hunting at the end of a turn (then raise it)
        distance_tolerance: hunting at the end of a way (then raise it)
        goal_tolerance: hunting at a goal (then raise it)
        settle: time until a command is done
        stalled_after: commands given up on a soft floor (then raise it)
    """

    turn_lead: float = 0.1  # [s] time by which a turn looks ahead, for what is on its way to the wheels
    turn_floor: float = 0.04  # [rad/s] least turn rate that is asked for, so that no turn starves near its end
    approach_floor: float = 0.02  # [m/s] least speed on approach
    side_gain: float = 2.5  # [rad/m] heading aimed back at the line per distance from it
    pivot_above: float = 0.9  # [rad] angle to the path above which it turns on the spot
    pivot_below: float = 0.12  # [rad] angle to the path below which it drives on
    slowest: float = 0.4  # share of the cruising speed in the tightest place
    again_beyond: float = 3.5  # error per tolerance at which it sets out again
    turn_gain: Annotated[
        float, Meta("1/s", 0.2, 10, "turn rate per heading error; a third of what a delay of 0.1 s would bear")
    ] = 3.0
    turn_deceleration: Annotated[float, Meta("rad/s²", 0.1, 6, "deceleration at the end of a turn")] = 1.5
    approach_gain: Annotated[float, Meta("1/s", 0.2, 10, "speed per distance left")] = 1.5
    lookahead: Annotated[float, Meta("m", 0.05, 1, "distance ahead on the path at which the robot aims")] = 0.22
    slow_within: Annotated[
        float, Meta("m", 0.01, 2, "free space around the body below which it slows", common=True, live=True)
    ] = 0.25
    heading_tolerance: Annotated[float, Meta("rad", 0.001, 0.2, "error of the heading at a turn's end")] = 0.006
    distance_tolerance: Annotated[float, Meta("m", 0.001, 0.1, "error of the distance at a line's end")] = 0.004
    goal_tolerance: Annotated[
        float, Meta("m", 0.005, 0.2, "distance from a goal at which it is reached", common=True, live=True)
    ] = 0.012
    settle: Annotated[float, Meta("s", 0, 5, "rest within the tolerance before a command is done")] = 0.3
    stalled_after: Annotated[float, Meta("s", 1, 60, "time without headway until a command gives up")] = 4.0


def spin(error: float, fastest: float, settings: SteeringSettings) -> float:
    """Heading error [rad], the fastest turn rate [rad/s] → the turn rate [rad/s] that closes it and slows in time."""
    size = abs(error)
    rate = min(fastest, settings.turn_gain * size, math.sqrt(2 * settings.turn_deceleration * size))
    return math.copysign(max(rate, settings.turn_floor), error)


def approach(left: float, cruise: float, settings: SteeringSettings) -> float:
    """Distance left [m], cruising speed [m/s] → the speed [m/s] that arrives slowly."""
    return min(cruise, max(settings.approach_gain * left, settings.approach_floor))


def hold_line(
    pose: Pose, start: Pose, left: float, cruise: float, fastest: float, settings: SteeringSettings
) -> Twist:
    """Drive along the line through `start` in its heading, `left` [m] before its end."""
    aside = (start.inverse() @ pose).y
    aim = wrap(start.heading - math.atan(settings.side_gain * aside) - pose.heading)
    return Twist(approach(left, cruise, settings), max(-fastest, min(fastest, settings.turn_gain * aim)))


class Pursuit:
    """Follows one path to its end; remembers how far along it is and whether it is turning on the spot."""

    def __init__(self, path: Array, settings: SteeringSettings, *, turn_first: bool = True) -> None:
        """Path (P, 2) [m], world, P ≥ 1, its points a few centimetres apart; `turn_first`: look along it exactly."""
        self.path = path
        self._settings = settings
        steps = np.hypot(*np.diff(path, axis=0).T) if len(path) > 1 else np.zeros(0)
        self._travel = np.concatenate(([0.0], np.cumsum(steps)))
        self._at = 0
        self.turning = turn_first

    def left(self, pose: Pose) -> float:
        """Distance [m] to the path's end along the path."""
        self._advance(pose)
        rest = float(self._travel[-1] - self._travel[self._at])
        return max(rest, pose.distance_to(*self.path[-1])) if rest < self._settings.lookahead else rest

    @property
    def rest(self) -> Array:
        """(R, 2) [m]: what lies ahead of the path."""
        return self.path[self._at :]

    def steer(self, pose: Pose, cruise: float, turn: float, space: float) -> Twist:
        """Pose, cruising speed [m/s], turn rate [rad/s], free space [m] around the body → what the wheels do."""
        settings = self._settings
        left = self.left(pose)
        x, y = self._carrot()
        bearing = pose.bearing_to(x, y)
        self.turning = abs(bearing) > (settings.pivot_below if self.turning else settings.pivot_above)
        if self.turning:
            return Twist(0.0, spin(bearing, turn, settings))
        room = max(settings.slowest, min(1.0, space / settings.slow_within))
        speed = approach(left, cruise, settings) * room * math.cos(bearing)
        curvature = 2 * math.sin(bearing) / max(pose.distance_to(x, y), 0.5 * settings.lookahead)
        if abs(speed * curvature) > turn:
            speed = turn / abs(curvature)
        return Twist(speed, speed * curvature)

    def effort(self, pose: Pose) -> float:
        """Return the way left [m], with a turn towards the path counted as a way; it falls as the robot proceeds."""
        return self.left(pose) + 0.2 * abs(pose.bearing_to(*self._carrot()))

    def _advance(self, pose: Pose) -> None:
        window = self.path[self._at : self._at + 40]
        self._at += int(np.hypot(window[:, 0] - pose.x, window[:, 1] - pose.y).argmin())

    def _carrot(self) -> tuple[float, float]:
        ahead = int(np.searchsorted(self._travel, self._travel[self._at] + self._settings.lookahead))
        x, y = self.path[min(ahead, len(self.path) - 1)]
        return float(x), float(y)


class Arrival:
    """Has come near enough, and stays: where the estimate jitters or commands lag, it does not set out again."""

    def __init__(self, tolerance: float, settings: SteeringSettings) -> None:
        """`tolerance`: what is left when it has arrived, in any unit."""
        self._near, self._far = tolerance, settings.again_beyond * tolerance
        self._hold = settings.settle
        self._there = False
        self._since = 0.0

    def reached(self, left: float, stamp: float) -> bool:
        """Take in one frame; whether to stand still."""
        was = self._there
        self._there = left < (self._far if was else self._near)
        if self._there and not was:
            self._since = stamp
        return self._there

    def settled(self, stamp: float) -> bool:
        """Return whether it has stood there long enough to be done."""
        return self._there and stamp - self._since >= self._hold


class Travel:
    """Distance travelled, with turns counted as ways of their own; jitter of the estimate does not count."""

    STEP_M = 0.05  # [m]

    def __init__(self, pose: Pose) -> None:
        self._from, self._gone = pose, 0.0

    def gone(self, pose: Pose) -> float:
        """Take in a pose → [m] since the beginning."""
        step = self._from.distance_to(pose.x, pose.y) + 0.2 * abs(wrap(pose.heading - self._from.heading))
        if step > self.STEP_M:
            self._from, self._gone = pose, self._gone + step
        return self._gone


class StallDetector:
    """Watches that what is left grows less."""

    def __init__(self, step: float, patience: float) -> None:
        """`step`: the least headway that counts; `patience` [s]: how long to wait for it."""
        self._step = step
        self._patience = patience
        self._best = math.inf
        self._since = 0.0

    def lost(self, left: float, stamp: float) -> bool:
        """Take in one frame; whether nothing was gained for too long."""
        if left < self._best - self._step:
            self._best = left
            self._since = stamp
        return stamp - self._since > self._patience
