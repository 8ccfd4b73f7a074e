"""Rooms, their maps, and a robot that is put somewhere in them."""

import math
from collections.abc import Generator
from typing import TypeVar

import numpy as np

from core.geometry import Pose
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.frame_perception import Beams
from core.robots.requests import CarryRobot
from core.sensors import Laser
from core.simulation.laser import SimulatedLaser
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.simulation.world import Rect, World, outline, world_named
from core.slam.map.occupancy import OccupancyGrid, OccupancyMap
from core.slam.relocalization.search_pyramid import ScanView, SearchPyramid

T = TypeVar("T")
LASER = Laser()
LAB = world_named("lab")
OBLONG = World(name="oblong", walls=outline([Rect(0.0, 0.0, 5.0, 3.0)]))  # looks alike when it is turned by 180°
CORRIDOR = World(name="corridor", walls=outline([Rect(0.0, 0.0, 30.0, 2.0)]))  # no end within sight
ELSEWHERE = World(name="elsewhere", walls=outline([Rect(0.0, 0.0, 3.1, 2.2), Rect(1.0, 2.0, 2.2, 6.0)]))


def finish(work: Generator[None, None, T]) -> tuple[T, int]:
    """Do all the work → its result and the number of pieces."""
    pieces = 0
    while True:
        try:
            next(work)
        except StopIteration as over:
            return over.value, pieces
        pieces += 1


def seen(world: World, pose: Pose, odometry: Pose | None = None, seed: int = 0, stamp: float = 0.0) -> ScanView:
    """What the 1 % laser sees at a pose."""
    ends, hits = beams(world, pose, seed)
    return ScanView.of_beams(stamp, odometry or pose, Beams(ends=ends, hits=hits, viewpoint=LASER.mounting))


def beams(world: World, pose: Pose, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    laser = SimulatedLaser(LASER, np.random.default_rng(seed))
    poses = np.array([pose.vector, pose.vector])
    scan = laser.scan(world, 0.0, np.array([0.0, 1.0]), poses)
    return beam_ends(scan, LASER, None, 0.0)


def anywhere(world: World, rng: np.random.Generator, clearance: float = 0.25) -> Pose:
    bounds = world.bounds
    while True:
        x, y = rng.uniform((bounds.x0, bounds.y0), (bounds.x1, bounds.y1)).tolist()
        if world.free(x, y, clearance):
            return Pose(x, y, float(rng.uniform(-math.pi, math.pi)))


def mapped(world: World, places: int = 60) -> OccupancyGrid:
    """A map drawn from random true poses."""
    drawn, rng = OccupancyMap(), np.random.default_rng(7)
    for number in range(places):
        pose = anywhere(world, rng)
        ends, hits = beams(world, pose, seed=1000 + number)
        drawn.insert(pose @ LASER.mounting, pose.apply(ends), hits)
    return drawn.grid()


def charted(world: World) -> SearchPyramid:
    chart, _ = finish(SearchPyramid.prepare(mapped(world)))
    assert chart is not None
    return chart


def robot(seed: int = 1) -> SimulatedRobot:
    return SimulatedRobot("lab", seed=seed, settings=SimulationSettings(camera=False))


def carry(driven: SimulatedRobot, pose: Pose) -> None:
    driven.ask(CarryRobot(x_m=pose.x, y_m=pose.y, heading_rad=pose.heading))
