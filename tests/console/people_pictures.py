"""A room as a webcam sees it: empty, and with someone in it who does this or that."""

import math
from functools import cache

import cv2
import numpy as np

from core.geometry import Pose
from core.message import Array
from core.optics import CameraModel
from core.sensors import Camera
from core.simulation.camera import SimulatedCamera
from core.simulation.world import LAB, Thing
from tests.drawn_people import WEBCAM

SMALL = Camera(
    model=CameraModel(
        width=320, height=240, fx=260.0, fy=260.0, cx=160.0, cy=120.0, k1=-0.05, k2=0.02, p1=0.0, p2=0.0
    ),
    mounting=WEBCAM.mounting,
)


def person(x: float, *, gesture: str = "", turn: float = 0.0) -> Thing:
    """A person who faces the camera."""
    pose = Pose(x, 0.0, math.pi + turn)
    look = "green/black"
    return Thing(id="p", what="person", pose=pose, length=0.4, depth=0.4, height=1.75, look=look, gesture=gesture)


PEOPLE = {
    "down": person(3.6),
    "again": person(3.6),
    "out": person(3.6, gesture="wide"),
    "wave": person(3.8, gesture="wave"),
    "side": person(3.6, turn=math.pi / 2),
    "near": person(1.2),
}


@cache
def webcam() -> SimulatedCamera:
    return SimulatedCamera(SMALL, LAB, np.random.default_rng(0))


@cache
def png(name: str) -> bytes:
    """A picture file: "empty", one of `PEOPLE`, or what the light or a push made of it."""
    return cv2.imencode(".png", pixels(name))[1].tobytes()


def pixels(name: str) -> Array:
    """The same, not packed (H, W, 3) uint8."""
    if name == "dark":
        return pixels("down") // 8
    if name == "moved":
        return webcam().take(LAB.with_thing(PEOPLE["down"]), 0.0, Pose(heading=0.15)).pixels
    world = LAB if name == "empty" else LAB.with_thing(PEOPLE[name])
    return webcam().take(world, 0.0, Pose()).pixels
