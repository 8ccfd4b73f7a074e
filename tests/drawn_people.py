"""Pictures of simulated rooms with people and things set down at random, and who stands where in them."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from core.geometry import OPTICAL, Pose, Transform, wrap
from core.message import Array
from core.optics import CameraModel
from core.sensors import Camera
from core.simulation.camera import SimulatedCamera
from core.simulation.world import COLOURS, GESTURES, Thing, World, cast, furniture
from core.simulation.world.objects import What

ROBOTS = Camera()
WEBCAM = Camera(
    model=CameraModel(
        width=640, height=480, fx=520.0, fy=520.0, cx=320.0, cy=240.0, k1=-0.05, k2=0.02, p1=0.0, p2=0.0
    ),
    mounting=Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, 1.15])),
)
"""A camera that stands on a desk or a screen."""
VIEW_HALF_RAD = 0.42  # to either side in which people are set down
CLUTTER: tuple[tuple[What, tuple[float, float, float]], ...] = (
    ("cabinet", (0.6, 0.4, 1.7)),
    ("shelf", (0.8, 0.35, 1.8)),
    ("box", (0.35, 0.35, 0.4)),
    ("table", (1.1, 0.6, 0.74)),
    ("stool", (0.34, 0.34, 0.48)),
    ("bin", (0.28, 0.28, 0.42)),
    ("pillar", (0.3, 0.3, 2.7)),
    ("cabinet", (0.35, 0.35, 1.75)),
    ("pillar", (0.22, 0.22, 1.6)),
)


@dataclass(frozen=True)
class DrawnPerson:
    """A person as they truly stand in a picture."""

    distance: float  # [m] from the camera
    bearing: float  # [rad] robot frame, from the camera
    height: float  # [m]
    shown: float  # share that nothing hides, of the body's middle, from the floor up
    look: str
    place: tuple[float, float]  # [m] world


@dataclass(frozen=True)
class DrawnScene:
    """A picture and who is in it."""

    pixels: Array
    camera: Camera
    people: tuple[DrawnPerson, ...]
    pose: Pose


class Stage:
    """Makes scenes of one world; the same chance makes the same scenes."""

    def __init__(
        self, world: World, rng: np.random.Generator, *, cameras: tuple[Camera, ...] = (ROBOTS, WEBCAM)
    ) -> None:
        self._world, self._rng = world, rng
        self._eyes = [SimulatedCamera(camera, world, rng, snr=60.0) for camera in cameras]

    def scene(
        self,
        people: int,
        *,
        clutter: int = 3,
        light: tuple[float, float] = (0.35, 1.15),
        reach: float = 5.5,
        nearest: float = 0.7,
    ) -> DrawnScene:
        """A picture with so many people in view, none of them behind a wall."""
        rng = self._rng
        while True:
            pose = self._somewhere()
            world = self._cluttered(pose, clutter)
            placed = [self._person(world, pose, number, reach, nearest) for number in range(people)]
            persons = [thing for thing in placed if thing is not None]
            if len(persons) == people and _separate(persons, pose):
                break
        for thing in persons:
            world = world.with_thing(thing)
        eye = self._eyes[int(rng.integers(len(self._eyes)))]
        pixels = eye.take(world, 0.0, pose).pixels
        return DrawnScene(
            pixels=self._lit(pixels, float(rng.uniform(*light))),
            camera=eye.camera,
            people=tuple(_someone(world, thing, pose, eye.camera) for thing in persons),
            pose=pose,
        )

    def _somewhere(self) -> Pose:
        box, rng = self._world.bounds, self._rng
        while True:
            x, y = rng.uniform(box.x0, box.x1), rng.uniform(box.y0, box.y1)
            if self._world.free(float(x), float(y), 0.3):
                return Pose(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))

    def _cluttered(self, pose: Pose, most: int) -> World:
        world, rng = self._world, self._rng
        for number in range(int(rng.integers(0, most + 1))):
            what, size = CLUTTER[int(rng.integers(len(CLUTTER)))]
            place = pose @ Pose(float(rng.uniform(1.0, 5.0)), 0.0, 0.0)
            x, y = place.x + rng.normal(0, 0.8), place.y + rng.normal(0, 0.8)
            thing = furniture(f"clutter {number}", what, float(x), float(y), size, float(rng.uniform(0, 360)))
            if world.free(float(x), float(y), thing.reach) and pose.distance_to(float(x), float(y)) > 0.7:
                world = world.with_thing(thing)
        return world

    def _person(self, world: World, pose: Pose, number: int, reach: float, nearest: float) -> Thing | None:
        rng = self._rng
        distance = float(np.exp(rng.uniform(math.log(nearest), math.log(reach))))
        angle = float(rng.uniform(-VIEW_HALF_RAD, VIEW_HALF_RAD))
        spot = pose @ Pose(distance * math.cos(angle), distance * math.sin(angle), 0.0)
        if not world.free(spot.x, spot.y, 0.2) or _hidden(world, pose, spot, 0.15):
            return None
        return Thing(
            id=f"person {number}",
            what="person",
            pose=Pose(spot.x, spot.y, float(rng.uniform(-math.pi, math.pi))),
            length=0.4,
            depth=0.4,
            height=float(rng.uniform(1.56, 1.92)),
            look=f"{COLOURS[rng.integers(len(COLOURS))]}/{COLOURS[rng.integers(len(COLOURS))]}",
            gesture=GESTURES[rng.integers(len(GESTURES))],
            stride=float(rng.choice((0.0, rng.uniform(0, math.tau)))),
        )

    def _lit(self, pixels: Array, light: float) -> Array:
        """Less light, and the noise of a sensor that does not care."""
        noise = self._rng.normal(0, 2.0, pixels.shape).astype(np.float32)
        return cv2.convertScaleAbs(np.maximum(pixels * np.float32(light) + noise, 0))


def _separate(persons: list[Thing], pose: Pose) -> bool:
    """Return whether no person stands in front of or inside another."""
    bearings = [pose.bearing_to(one.pose.x, one.pose.y) for one in persons]
    distances = [pose.distance_to(one.pose.x, one.pose.y) for one in persons]
    return all(
        abs(wrap(bearings[one] - bearings[other])) * min(distances[one], distances[other]) > 0.6
        for one in range(len(persons))
        for other in range(one)
    )


def _hidden(world: World, pose: Pose, spot: Pose, height: float) -> bool:
    """Return whether something stands between at that height."""
    away = np.array([[spot.x - pose.x, spot.y - pose.y]])
    return bool(cast(np.array([pose.x, pose.y]), away, world.surfaces(height)).distance[0] < 1.0)


def _someone(world: World, thing: Thing, pose: Pose, camera: Camera) -> DrawnPerson:
    eye = pose.apply(camera.mounting.translation[None, :2])[0]
    from_eye = Pose(float(eye[0]), float(eye[1]), pose.heading)
    others = world.without(thing.id)
    heights = np.linspace(0.1, thing.height - 0.1, 7)
    free = [not _hidden(others, from_eye, thing.pose, float(height)) for height in heights]
    return DrawnPerson(
        distance=from_eye.distance_to(thing.pose.x, thing.pose.y),
        bearing=from_eye.bearing_to(thing.pose.x, thing.pose.y),
        height=thing.height,
        shown=float(np.mean(free)),
        look=thing.look,
        place=(thing.pose.x, thing.pose.y),
    )
