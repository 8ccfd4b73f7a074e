"""The obstacle guard: near scan points against the arc that the body is about to sweep."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from core.gate.limits import Limits, is_number
from core.gate.twist import ZERO, Twist
from core.sentences import Statement

HORIZON_M = 1.5  # up to which points are given; farther away, nothing is known to be free
REACTION_S = 0.2  # from a point's appearance to slower wheels: a turn of the laser, its way here, a tick …
ON_THE_WAY_S = 0.1  # [s] … of which its way here, at least; a scan that is older adds what it is older by
TOUCH_M = 0.005  # around the body that count as touching
GRAZE_SPEED_M_S = 0.1  # past something that is within the margin at the side
CRAWL_SPEED_M_S = 0.01  # under which it is better to stand
BACKING_SPEED_M_S = 0.1  # backwards, where the laser does not see
POINT_MEMORY_S = 10.0  # that a point counts which the laser has turned its back on
MAX_REMEMBERED_POINTS = 150  # points that count though the laser has turned its back on them

Point = tuple[float, float]


@dataclass(frozen=True)
class Permitted:
    """The part of a twist that the guard permits."""

    twist: Twist
    limit: float | None = None  # [m/s] that the surroundings allow in this direction, None: anything
    point: Point | None = None  # [m], robot frame: what is in the way
    reason: str = ""  # "" when nothing was taken away


class ObstacleGuard:
    """Remembers the newest near points, carried along with the wheels, and takes speed away.

    It only ever reduces, and never refuses what leads away from a point. A round body turns freely on the spot.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._points: tuple[Point, ...] = ()
        self._until: tuple[float, ...] = ()  # [s] of the rolled time to which each point counts unseen
        self._moved = (0.0, 0.0, 0.0)  # x, y [m], heading [rad] since the points were seen
        self._rolled = 0.0  # [s]
        self._field = math.pi  # [rad]
        self._reaction = REACTION_S  # [s]

    @property
    def backing_speed(self) -> float:
        """The most [m/s] that is good backwards: little where nothing looks that way."""
        return BACKING_SPEED_M_S if self._field < math.pi else math.inf

    def see(self, points: Sequence[Sequence[float]], field: float = math.pi, age: float = 0.0) -> None:
        """New near points (x, y) [m], robot frame, `age` [s] old, by a laser that looks `field` [rad] to either side.

        Anything but a pair of finite numbers is left out. A point that was seen before and is out of sight now still
        counts for a while.
        """
        kept = [
            (point, until)
            for point, until in zip(self._points_now(), self._until, strict=True)
            if abs(math.atan2(point[1], point[0])) > field and math.hypot(*point) < HORIZON_M and until > self._rolled
        ][:MAX_REMEMBERED_POINTS]
        pairs = (point for point in points if isinstance(point, list | tuple) and len(point) == 2)
        seen = [(point[0], point[1]) for point in pairs if is_number(point[0]) and is_number(point[1])]
        self._points = (*seen, *(point for point, _ in kept))
        self._until = (*([self._rolled + POINT_MEMORY_S] * len(seen)), *(until for _, until in kept))
        self._moved, self._field = (0.0, 0.0, 0.0), field
        self._reaction = REACTION_S + max(age - ON_THE_WAY_S, 0.0)

    def roll(self, twist: Twist, elapsed: float) -> None:
        """Move the points by `elapsed` seconds of this twist."""
        self._rolled += elapsed
        x, y, heading = self._moved
        middle = heading + 0.5 * twist.w * elapsed
        step = twist.v * elapsed
        self._moved = (x + step * math.cos(middle), y + step * math.sin(middle), heading + twist.w * elapsed)

    def permit(self, twist: Twist) -> Permitted:
        """A twist → what the surroundings leave of it."""
        if not twist.moves:
            return Permitted(twist)
        points = self._points_now()
        if twist.v == 0.0:
            return self._turn(twist, points)
        allowed, nearest = self._allowed(twist, points)
        if nearest is None or allowed >= self._limits.max_speed:
            return Permitted(twist)
        if allowed < CRAWL_SPEED_M_S:
            turn = self._turn(Twist(0.0, twist.w), points).twist
            return Permitted(turn, 0.0, nearest, Statement("gate.reason_in_the_way"))
        if abs(twist.v) <= allowed:
            return Permitted(twist, allowed, nearest)
        part = allowed / abs(twist.v)
        return Permitted(Twist(twist.v * part, twist.w * part), allowed, nearest, Statement("gate.reason_slowed"))

    def _turn(self, twist: Twist, points: list[Point]) -> Permitted:
        nearest = min(points, key=lambda point: math.hypot(*point), default=None)
        if nearest is None or math.hypot(*nearest) >= self._limits.radius - 2 * TOUCH_M:
            return Permitted(twist)
        return Permitted(ZERO, 0.0, nearest, Statement("gate.reason_inside"))

    def _points_now(self) -> list[Point]:
        x, y, heading = self._moved
        c, s = math.cos(heading), math.sin(heading)
        return [(c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)) for px, py in self._points]

    def _allowed(self, twist: Twist, points: list[Point]) -> tuple[float, Point | None]:
        """The speed [m/s] from which the body can still stop in time, and the point that says so."""
        allowed, nearest = self._stoppable(HORIZON_M), None
        for point in points:
            way, miss = approach(twist, point, self._limits.radius + self._limits.margin)
            if math.isinf(way):
                continue
            speed = self._stoppable(way)
            if miss > self._limits.radius + TOUCH_M:
                speed = max(speed, GRAZE_SPEED_M_S)
            if speed < allowed:
                allowed, nearest = speed, point
        return allowed, nearest

    def _stoppable(self, way: float) -> float:
        """The speed [m/s] that comes to rest within `way` [m]: v·T + v²/(2a) = way."""
        reach = self._limits.max_acceleration * self._reaction
        return math.sqrt(reach * reach + 2 * self._limits.max_acceleration * max(way, 0.0)) - reach


def approach(twist: Twist, point: Point, reach: float) -> tuple[float, float]:
    """Way [m] along the twist's arc until `point` is within `reach` [m] of the centre; the closest it will come [m].

    The way is inf when that never happens or the arc begins by leading away; `twist.v` is not zero.
    """
    x, y = (point[0], point[1]) if twist.v > 0 else (-point[0], -point[1])  # as if driving forward
    w = twist.w
    distance = math.hypot(x, y)
    if x <= 0.0 and distance < reach:
        return math.inf, distance
    radius = abs(twist.v / w) if w != 0.0 else math.inf
    if radius > 1e4:
        if abs(y) >= reach or x <= 0.0:
            return math.inf, abs(y)
        return max(0.0, x - math.sqrt(reach * reach - y * y)), abs(y)
    left = y if w > 0 else -y  # as if turning left, about (0, radius)
    from_centre = math.hypot(x, left - radius)
    miss = abs(from_centre - radius)
    if miss >= reach or from_centre == 0.0:
        return math.inf, miss
    if distance < reach:
        return 0.0, miss
    ahead = math.atan2(x, radius - left) % (2 * math.pi)
    half = (radius * radius + from_centre * from_centre - reach * reach) / (2 * radius * from_centre)
    return radius * (ahead - math.acos(max(-1.0, min(1.0, half)))), miss
