"""People who walk in the simulated room: along a path, around each other and around the robot, never into it."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import msgspec
import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap
from core.message import Array
from core.robots.requests import PlacedThing, PlaceThing, Point, finite
from core.simulation.actors.requests import describe
from core.simulation.world import FOOT_REACH_M, Thing, World

DEFAULT_SPEED_M_S = 0.5  # where a request names none
SPEED_BOUNDS_M_S = (0.05, 2.0)
MOST_POINTS = 100
WALKER_RADIUS_M = 0.2  # that a walker needs around
MIN_HEADROOM_M = 1.8  # [m] and above
BERTH = FOOT_REACH_M + 0.03  # [m] that a walker keeps from the robot's body
STEP_LENGTH_M = 1.2  # of a whole step, left and right
TURN_RATE_RAD_S = 4.0
SAMPLE_STEP_M = 0.1  # between the places of a path that are checked


@dataclass
class _WalkingPath:
    path: Array  # (P, 2) [m], where they set out first
    speed: float  # [m/s]
    again: bool  # round and round, or once
    at: int = 1  # of the point that they walk to
    strode: float = 0.0  # [m]


class Pedestrians:
    """The people who walk. Owned by the simulated robot."""

    def __init__(self, radius: float) -> None:
        """`radius` [m] of the robot."""
        self._walks: dict[str, _WalkingPath] = {}
        self._berth = radius + BERTH
        self._stamp = 0.0

    def send(self, request: PlaceThing, person: Thing, world: World) -> PlacedThing:
        """Take in the request for a person: with `path_m` they walk, without they stand.

        → the answer, with the walk if there is one. Raises BadInput that says what is wrong.
        """
        self._walks.pop(person.id, None)
        if request.path_m is None:
            return describe(person)
        if person.what != "person":
            raise BadInput("Only a person can walk; leave path_m out.")
        speed = DEFAULT_SPEED_M_S if request.speed_m_s is None else finite(request.speed_m_s, "speed_m_s")
        if not SPEED_BOUNDS_M_S[0] <= speed <= SPEED_BOUNDS_M_S[1]:
            raise BadInput(f"speed_m_s must lie between {SPEED_BOUNDS_M_S[0]:g} and {SPEED_BOUNDS_M_S[1]:g}.")
        again = request.again is True
        path = np.vstack(((person.pose.x, person.pose.y), _points(request.path_m)))
        _check(np.vstack((path, path[:1])) if again else path, world, person.id)
        self._walks[person.id] = _WalkingPath(path, speed, again)
        return msgspec.structs.replace(self.described(person), path_m=request.path_m)

    def described(self, thing: Thing) -> PlacedThing:
        """A thing as the answers have it; with the rest of the walk, from where they are, of a person who walks."""
        walk = self._walks.get(thing.id)
        if walk is None:
            return describe(thing)
        behind = walk.path[: walk.at] if walk.again else walk.path[:0]
        if len(behind) and math.dist(behind[-1], (thing.pose.x, thing.pose.y)) < SAMPLE_STEP_M:
            behind = behind[:-1]  # a round ends where it begins
        path = tuple((float(x), float(y)) for x, y in (*walk.path[walk.at :], *behind))
        return msgspec.structs.replace(describe(thing), path_m=path, speed_m_s=walk.speed, again=walk.again)

    def forget(self, name: str) -> None:
        """Stop the walk of the person with this name, if there is one."""
        self._walks.pop(name, None)

    def in_world(self, world: World, stamp: float, robot: Pose) -> World:
        """The world as it is at `stamp` [s]: the same object while nobody walks."""
        passed, self._stamp = stamp - self._stamp, stamp
        if not self._walks or passed <= 0:
            return world
        for person in [thing for thing in world.things if thing.id in self._walks]:
            walk = self._walks[person.id]
            moved = self._stepped(walk, person, passed, robot, world)
            if moved is not person:
                world = world.with_thing(moved)
            if walk.at >= len(walk.path):
                del self._walks[person.id]
        return world

    def _stepped(self, walk: _WalkingPath, person: Thing, passed: float, robot: Pose, world: World) -> Thing:
        x, y = person.pose.x, person.pose.y
        goal = walk.path[walk.at]
        left = math.hypot(goal[0] - x, goal[1] - y)
        towards = math.atan2(goal[1] - y, goal[0] - x) if left > 1e-6 else person.pose.heading
        turn = wrap(towards - person.pose.heading)
        heading = wrap(person.pose.heading + max(-TURN_RATE_RAD_S * passed, min(TURN_RATE_RAD_S * passed, turn)))
        way = min(left, walk.speed * passed) * max(0.0, math.cos(turn))
        x, y = x + way * math.cos(towards), y + way * math.sin(towards)
        gap, before = robot.distance_to(x, y), robot.distance_to(person.pose.x, person.pose.y)
        if gap < self._berth and gap < before:  # the robot stands in the way: around it, or feet together, and wait
            beside = self._around(person, goal, way, robot, world)
            if beside is None:
                return replace(person, stride=0.0) if person.stride else person
            walk.strode += way
            return replace(
                person, pose=Pose(*beside, heading), stride=math.tau * walk.strode / STEP_LENGTH_M % math.tau
            )
        walk.strode += way
        if left - way < 1e-3:
            walk.at = (walk.at + 1) % len(walk.path) if walk.again else walk.at + 1
        over = walk.at >= len(walk.path)
        stride = 0.0 if over else math.tau * walk.strode / STEP_LENGTH_M % math.tau
        return replace(person, pose=Pose(x, y, heading), stride=stride)

    def _around(
        self, person: Thing, goal: Array, way: float, robot: Pose, world: World
    ) -> tuple[float, float] | None:
        """Return the place (x, y) [m] after `way` [m] around the robot, towards the goal; None: there is no room."""
        if robot.distance_to(float(goal[0]), float(goal[1])) < self._berth:
            return None
        away = max(robot.distance_to(person.pose.x, person.pose.y), self._berth)
        now = math.atan2(person.pose.y - robot.y, person.pose.x - robot.x)
        side = math.copysign(1.0, wrap(math.atan2(goal[1] - robot.y, goal[0] - robot.x) - now))
        angle = now + side * way / away
        x, y = robot.x + away * math.cos(angle), robot.y + away * math.sin(angle)
        return (x, y) if world.without(person.id).upright(x, y, WALKER_RADIUS_M, MIN_HEADROOM_M) else None


def _points(waypoints: tuple[Point, ...]) -> Array:
    """A path of a request as (P, 2) [m]."""
    if not 1 <= len(waypoints) <= MOST_POINTS:
        raise BadInput(f"path_m must be a list of 1 to {MOST_POINTS} places [x, y] in metres.")
    return np.array([[finite(value, "path_m") for value in place] for place in waypoints])


def _check(path: Array, world: World, walker: str) -> None:
    """Raises BadInput when a person who walks there meets a wall or a thing; people make way for each other."""
    people = [thing.id for thing in world.things if thing.what == "person" and not thing.fixed]
    bare = replace(world, things=tuple(thing for thing in world.things if thing.id not in (*people, walker)))
    for start, end in pairwise(path):
        count = max(2, math.ceil(float(np.hypot(*(end - start))) / SAMPLE_STEP_M) + 1)
        for x, y in np.linspace(start, end, count):
            if not bare.upright(float(x), float(y), WALKER_RADIUS_M, MIN_HEADROOM_M):
                raise BadInput(
                    f"Nobody can walk past {x:.2f} and {y:.2f}; "
                    f"lead the path over free floor, {WALKER_RADIUS_M:g} m from walls."
                )
