"""Drives through random storeys with a real corner finder: the same as `corridor_drives`, but for scans.

The storeys of `long_log`, smaller; what is sighted are the corners found in simulated scans, with the covariance that
the finder states. A sighting is of the corner of the plan that it truly lies at; of none where there is none.
"""

import math
from itertools import islice

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.corners import find_corners
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.landmarks import sight
from core.recording.recording import SightingStep
from core.slam.motion import Increment
from tests.benchmarks.corridor_drives import Drive
from tests.benchmarks.long_log import LASER, TURN_SD, WAY_SD, Storey, frames

UPDATES = 1500  # of one drive, 81 m
AT = 0.15  # [m] from a corner of the plan that a sighting of it truly lies
SIDE_SD = 1e-3  # [m] per root metre


def plan_drive(seed: int, updates: int = UPDATES) -> Drive:
    """A drive through the storey of that seed."""
    storey = Storey(seed, columns=2, rows=1)
    start = next(storey.route(np.random.default_rng(0)))
    corners = start.inverse().apply(np.unique(storey.walls.reshape(-1, 2), axis=0))
    steps, names, truth, before = list[SightingStep](), list[tuple[int, ...]](), list[Array](), Pose()
    for frame in islice(frames(seed, storey), updates):
        assert frame.scan is not None and frame.wheels is not None and frame.truth is not None
        ends, hits = beam_ends(frame.scan, LASER, None, frame.stamp)
        found = find_corners(frame.scan, LASER, ends[hits], np.flatnonzero(hits))
        seen, _ = sight(found, (), stamp=frame.stamp, edges_stamp=-1.0, wheels=frame.wheels, camera=None)
        moved, before = before.inverse() @ frame.wheels.odometry, frame.wheels.odometry
        steps.append(SightingStep(stamp=frame.stamp, increment=_increment(moved), sightings=seen))
        names.append(tuple(_name(frame.truth.apply(one.position[None])[0], corners) for one in seen))
        truth.append(frame.truth.vector)
    return Drive(None, tuple(steps), tuple(names), np.array(truth), corners)


def _increment(moved: Pose) -> Increment:
    way = math.hypot(moved.x, moved.y)
    return Increment(moved, np.diag([(WAY_SD * way) ** 2, SIDE_SD**2 * way, TURN_SD**2 * way]))


def _name(place: Array, corners: Array) -> int:
    gaps = np.hypot(*(corners - place).T)
    nearest = int(gaps.argmin())
    return nearest if gaps[nearest] < AT else -1
