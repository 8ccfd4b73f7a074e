"""A drive around the corridors of sim:floor, one scan every 0.2 m, with wheels that bend the way."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from core.geometry import Pose, wrap
from core.perception.landmarks.corners import find_corners
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.frame_perception import Beams, FramePerception
from core.perception.landmarks.landmarks import sight
from core.sensors import Laser, SensorFrame, Wheels
from core.simulation.laser import SimulatedLaser
from core.simulation.world import world_named
from core.slam.mapper import Mapper
from core.slam.motion import Motion, WheelTrack

LASER = Laser(beams=341, angle_step=2 * np.pi / 512, time_step=0.0, rate=5.0)
RING = ((11.7, -0.1), (11.7, 7.5), (-2.1, 7.5), (-2.1, -0.1), (2.0, -0.1))  # [m], world: the middle of the corridors
STEP, TURN, PERIOD = 0.2, math.radians(12), 0.4  # [m], [rad], [s] from scan to scan
SCALE, BEND = 1.01, math.radians(0.5)  # what the wheels make of a metre: its length, and a turn [rad]


@dataclass(frozen=True)
class Moment:
    """A scan, and where it was taken."""

    frame: SensorFrame
    seen: FramePerception
    truth: Pose


def way(corners: tuple[tuple[float, float], ...]) -> Iterator[Pose]:
    """Straight from corner to corner, turning on the spot."""
    pose = Pose()
    yield pose
    for x, y in corners:
        while abs(turn := pose.bearing_to(x, y)) > 1e-6:
            pose = Pose(pose.x, pose.y, wrap(pose.heading + max(-TURN, min(TURN, turn))))
            yield pose
        while (left := pose.distance_to(x, y)) > 1e-6:
            pose = pose @ Pose(min(STEP, left), 0.0, 0.0)
            yield pose


def drive(seed: int, way_points: tuple[tuple[float, float], ...] = RING) -> Iterator[Moment]:
    """Every scan of the way."""
    rng = np.random.default_rng(seed)
    laser, world = SimulatedLaser(LASER, rng), world_named("floor")
    before, odometry = Pose(), Pose()
    for number, truth in enumerate(way(way_points)):
        stamp, step = number * PERIOD, before.inverse() @ truth
        noise = rng.normal(size=2) * math.hypot(step.x, step.y) ** 0.5
        bent = BEND * step.x + 0.01 * step.heading + 0.005 * noise[1]
        odometry = odometry @ Pose(SCALE * step.x + 0.004 * noise[0], 0.0, step.heading + bent)
        before = truth
        scan = laser.scan(world, stamp, np.array([stamp, stamp + 1.0]), np.tile(truth.vector, (2, 1)))
        wheels = Wheels(odometry=odometry, speed=0.0, turn_rate=0.0)
        ends, hits = beam_ends(scan, LASER, None, stamp)
        corners = find_corners(scan, LASER, ends[hits], np.flatnonzero(hits))
        sightings, _ = sight(corners, (), stamp=stamp, edges_stamp=-1.0, wheels=wheels, camera=None)
        frame = SensorFrame(stamp=stamp, wheels=wheels, scan=scan)
        yield Moment(frame, FramePerception(sightings=sightings, beams=Beams(ends=ends, hits=hits)), truth)


TRACKS: WeakKeyDictionary[Mapper, WheelTrack] = WeakKeyDictionary()  # each floor's own count of the wheels


def told(floor: Mapper, moment: Moment) -> Pose:
    """The floor hears of a moment → where it thinks to be."""
    track = TRACKS.setdefault(floor, WheelTrack())
    return floor.update(moment.frame, moment.seen, Motion(track.step(moment.frame.stamp, moment.frame.wheels))).pose
