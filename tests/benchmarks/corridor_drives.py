"""Drives around a corridor among false corners, drawn from a seed, for `corridors` and the tests.

A corridor runs around a block; recessed doors in its outer wall and its own corners are the landmarks, two for every
door. The robot goes round in the middle at 0.3 m/s and turns the corners in arcs. At 5 Hz it sights the landmarks
within 4 m and 120 degrees to either side that no wall hides, most of the time, and a few places where nothing is. The
odometry errs by white noise, which its covariance states, and by a constant rate of turning per metre, which it does
not.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from core.geometry import Pose, arc, wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.recording.archives import CORRIDOR_NOISE
from core.recording.recording import SightingStep
from core.slam.motion import Increment

PERIOD, STRIDE = 0.2, 0.06  # [s], [m] from one update to the next
REACH, HALF_FIELD = 4.0, math.radians(120)
RECESS = 0.25  # [m] that a door is set back
BEND = 0.5  # [m] radius of the arcs at the corners
WAY_SD, SIDE_SD, TURN_SD = 0.019, 0.0058, math.radians(1.54)  # of the odometry, per root metre: [m], [m], [rad]
IN_PLACE = 1e-6  # [m]: a line of sight may end this much in the wall that its landmark is on


@dataclass(frozen=True)
class Corridor:
    """What was drawn."""

    length: float  # [m] outside
    breadth: float  # [m]
    width: float  # [m]
    door: float  # [m]
    gap: float  # [m] between doors, at least
    loops: int
    detection: float  # probability that a landmark in view is sighted
    clutter: float  # false sightings per update, mean
    bias: float  # [rad] per metre, of the odometry's heading


@dataclass(frozen=True)
class Drive:
    """One drive, as a filter may hear it, and the truth beside it."""

    corridor: Corridor | None  # None: another kind of place
    steps: tuple[SightingStep, ...]  # their sightings have no identity
    names: tuple[tuple[int, ...], ...]  # which landmark every sighting is of; -1: none
    truth: Array  # (K, 3) true pose after every step, seen from where the robot began
    landmarks: Array  # (N, 2) [m], seen from there

    @property
    def sighted(self) -> int:
        """Landmarks that were sighted three times or more."""
        counts = np.bincount([name + 1 for names in self.names for name in names], minlength=len(self.landmarks) + 1)
        return int((counts[1:] >= 3).sum())


def drawn(seed: int) -> Corridor:
    rng = np.random.default_rng((seed, 1))
    return Corridor(
        length=rng.uniform(14, 30),
        breadth=rng.uniform(8, 14),
        width=rng.uniform(1.4, 2.4),
        door=rng.uniform(0.7, 1.0),
        gap=rng.uniform(0.6, 2.5),
        loops=int(rng.integers(1, 4)),
        detection=rng.uniform(0.7, 0.95),
        clutter=rng.uniform(0.0, 0.6),
        bias=math.radians(rng.uniform(-1.0, 1.0)),
    )


def drive(corridor: Corridor, seed: int) -> Drive:
    """A drive through that corridor; doors and noise are the seed's."""
    rng = np.random.default_rng((seed, 2))
    landmarks, walls = _built(corridor, rng)
    route = _route(corridor)
    start, steps, names = route[0], [], []
    for number, (before, pose) in enumerate(pairwise(route), 1):
        seen, called = _sighted(pose, landmarks, walls, corridor, PERIOD * number, rng)
        increment = _heard(before.inverse() @ pose, corridor.bias, rng)
        steps.append(SightingStep(stamp=PERIOD * number, increment=increment, sightings=seen))
        names.append(called)
    back = start.inverse()
    return Drive(
        corridor=corridor,
        steps=tuple(steps),
        names=tuple(names),
        truth=np.array([(back @ pose).vector for pose in route[1:]]),
        landmarks=back.apply(landmarks),
    )


def _built(corridor: Corridor, rng: np.random.Generator) -> tuple[Array, Array]:
    """Landmarks (N, 2) and walls (W, 4) [m]: x0 y0 x1 y1."""
    long, broad, width = corridor.length, corridor.breadth, corridor.width
    outer = np.array([(0.0, 0.0), (long, 0.0), (long, broad), (0.0, broad)])
    inner = np.array([(width, width), (long - width, width), (long - width, broad - width), (width, broad - width)])
    corners, walls = [*outer, *inner], [np.hstack((a, b)) for a, b in zip(inner, np.roll(inner, -1, 0), strict=True)]
    for begin, end in zip(outer, np.roll(outer, -1, 0), strict=True):
        length = math.hypot(*(end - begin))
        along = (end - begin) / length
        back = RECESS * np.array([along[1], -along[0]])
        line, at = [begin], corridor.gap * rng.uniform(0.5, 1.5)
        while at + corridor.door < length - 0.3:
            mouth = begin + at * along, begin + (at + corridor.door) * along
            corners += mouth
            line += [mouth[0], mouth[0] + back, mouth[1] + back, mouth[1]]
            at += corridor.door + corridor.gap + rng.uniform(0.0, 1.5)
        line.append(end)
        walls += [np.hstack((a, b)) for a, b in pairwise(line)]
    return np.array(corners), np.array(walls)


def _route(corridor: Corridor) -> list[Pose]:
    """Poses one update apart, counter-clockwise along the middle."""
    long, broad = corridor.length - corridor.width, corridor.breadth - corridor.width
    pose = Pose(0.5 * corridor.width + BEND, 0.5 * corridor.width)
    bend = max(1, round(0.5 * math.pi * BEND / STRIDE))
    poses = [pose]
    for side in range(4 * corridor.loops):
        straight = (long, broad)[side % 2] - 2 * BEND
        count = max(1, round(straight / STRIDE))
        for move in [arc(straight / count, 0.0)] * count + [
            arc(0.5 * math.pi * BEND / bend, 0.5 * math.pi / bend)
        ] * bend:
            pose = pose @ move
            poses.append(pose)
    return poses


def _heard(driven: Pose, bias: float, rng: np.random.Generator) -> Increment:
    """What the odometry tells of a step."""
    way = math.hypot(driven.x, driven.y)
    sds = math.sqrt(way) * np.array([WAY_SD, SIDE_SD, TURN_SD])
    off = sds * rng.standard_normal(3)
    told = Pose(driven.x + off[0], driven.y + off[1], driven.heading + off[2] + bias * way)
    return Increment(told, np.diag(sds**2))


def _sighted(
    pose: Pose, landmarks: Array, walls: Array, corridor: Corridor, stamp: float, rng: np.random.Generator
) -> tuple[tuple[Sighting, ...], tuple[int, ...]]:
    """What is sighted from a pose, in the order of the bearings, and which landmark each is of."""
    local = pose.inverse().apply(landmarks)
    reach, bearing = np.hypot(*local.T), np.arctan2(local[:, 1], local[:, 0])
    near = np.flatnonzero((reach < REACH) & (np.abs(bearing) < HALF_FIELD))
    near = near[~_hidden(np.array([pose.x, pose.y]), landmarks[near], walls)]
    near = near[rng.random(len(near)) < corridor.detection]
    false = rng.poisson(corridor.clutter)
    readings = np.vstack(
        (
            np.column_stack((reach[near], bearing[near])) + rng.normal(0.0, CORRIDOR_NOISE, (len(near), 2)),
            np.column_stack((rng.uniform(0.3, REACH, false), rng.uniform(-HALF_FIELD, HALF_FIELD, false))),
        )
    )
    names = np.concatenate((near, np.full(false, -1)))
    order, noise = np.argsort(readings[:, 1]), np.diag(np.square(CORRIDOR_NOISE))
    return tuple(
        Sighting(range=r, bearing=wrap(b), covariance=noise, stamp=stamp) for r, b in readings[order].tolist()
    ), tuple(names[order].tolist())


def _hidden(here: Array, places: Array, walls: Array) -> Array:
    """Whether a wall stands between `here` (2,) and each of the places (N, 2): (N,) bool."""
    edge, way = walls[:, 2:] - walls[:, :2], places - here
    off = walls[:, :2] - here
    cross = way[:, None, 0] * edge[:, 1] - way[:, None, 1] * edge[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (off[:, 0] * edge[:, 1] - off[:, 1] * edge[:, 0]) / cross
        along = (off[:, 0] * way[:, None, 1] - off[:, 1] * way[:, None, 0]) / cross
    return ((share > 0) & (share < 1 - IN_PLACE) & (along >= 0) & (along <= 1)).any(axis=1)
