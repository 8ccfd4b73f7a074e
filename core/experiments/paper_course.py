"""The paper's drive as it was planned: an S of 3.2 m among twelve corners (section 6.2).

The print gives speed, wheelbase, rates and noise (eq. 43); the corners, and the points the S leads through, are ours.
"""

import math
from functools import cache

import numpy as np

from core.geometry import wrap
from core.message import Array, message
from core.slam.motion import MotionSettings, steered

CONTROL_UPDATES = 1280  # control updates: 32 s at 40 Hz, 3.2 m at 0.1 m/s
UPDATES_PER_SIGHTING = 8  # control updates between sightings: 5 Hz
LANDMARKS = (
    (-1.0, -2.0),
    (5.0, -2.0),
    (5.0, 3.0),
    (-1.0, 3.0),
    (1.2, -2.0),
    (1.2, -1.6),
    (3.4, 3.0),
    (3.4, 2.6),
    (5.0, 0.5),
    (4.6, 0.5),
    (-1.0, 1.0),
    (-0.6, 1.0),
)  # [m]
GOALS = ((1.2, 0.2), (1.8, 0.9), (2.6, 0.9), (3.4, 0.2))  # [m]
GOAL_RADIUS_M = 0.05  # from a goal, the next one is steered for
MOST_STEER = math.radians(30)
STEER_RATE = math.radians(80)  # [rad/s]
ROOM_MARGINS_M = (1.0, 3.5)  # least and most between the drive and a wall of a drawn room
PILLAR_DEPTHS_M = (0.2, 0.6)  # least and most of a wall's edge into a drawn room


@message
class Course:
    """The true drive: what was commanded, and where it led."""

    speeds: Array  # (K,) [m/s]
    steers: Array  # (K,) [rad]
    truth: Array  # (K + 1, 3) x, y [m], heading [rad]; the first is the start
    landmarks: Array  # (N, 2) [m]


def edges_along_walls(spacing: float) -> Array:
    """The twelve corners, and further vertical edges (door frames, cabinets) every `spacing` [m] along the walls."""
    corners = np.array(LANDMARKS)
    (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
    across = np.arange(x0 + spacing / 2, x1, spacing)
    up = np.arange(y0 + spacing / 2, y1, spacing)
    walls = [np.column_stack((across, np.full(len(across), y))) for y in (y0, y1)]
    walls += [np.column_stack((np.full(len(up), x), up)) for x in (x0, x1)]
    return np.vstack((corners, *walls))


def drawn_room(rng: np.random.Generator, truth: Array) -> Array:
    """Draw a room like the one of figure 16 about a drive (K, 3): four corners, and a pillar's edge on every wall.

    Returns the twelve corners (12, 2) [m].
    """
    margins = rng.uniform(*ROOM_MARGINS_M, size=(2, 2))
    least, most = truth[:, :2].min(axis=0) - margins[0], truth[:, :2].max(axis=0) + margins[1]
    corners = [(x, y) for x in (least[0], most[0]) for y in (least[1], most[1])]
    for axis in (0, 1):
        for wall, into in ((least, 1.0), (most, -1.0)):
            along = rng.uniform(least[1 - axis], most[1 - axis])
            for depth in (0.0, rng.uniform(*PILLAR_DEPTHS_M)):
                across = wall[axis] + into * depth
                corners.append((across, along) if axis == 0 else (along, across))
    return np.array(corners)


@cache
def paper_course(wheelbase: float, step: float, cruise: float) -> Course:
    """Steer the S: wheelbase [m], control step [s], speed [m/s] → the drive without any noise."""
    motion = MotionSettings(wheelbase=wheelbase, step=step)
    x, y, heading, steer, goal = 0.0, 0.0, 0.0, 0.0, 0
    steers: list[float] = []
    truth = [(x, y, heading)]
    for _ in range(CONTROL_UPDATES):
        if goal < len(GOALS) - 1 and math.hypot(GOALS[goal][0] - x, GOALS[goal][1] - y) < GOAL_RADIUS_M:
            goal += 1
        towards = math.atan2(GOALS[goal][1] - y, GOALS[goal][0] - x)
        change = wrap(towards - heading - steer)
        steer += min(max(change, -STEER_RATE * step), STEER_RATE * step)
        steer = min(max(steer, -MOST_STEER), MOST_STEER)
        moved = steered(cruise, steer, step, motion).pose
        c, s = math.cos(heading), math.sin(heading)
        x, y = x + c * moved.x - s * moved.y, y + s * moved.x + c * moved.y
        heading = wrap(heading + moved.heading)
        steers.append(steer)
        truth.append((x, y, heading))
    return Course(
        speeds=np.full(CONTROL_UPDATES, cruise),
        steers=np.array(steers),
        truth=np.array(truth),
        landmarks=np.array(LANDMARKS),
    )
