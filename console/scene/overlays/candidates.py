"""While the robot is lost: where it may be, as outlines of itself, the likeliest drawn the strongest."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import Lines, lifted
from console.scene.drawing.palette import DOUBT, UNSURE, mix
from core.message import Array
from core.robots import Profile
from core.slam.map.status import LostStatus
from core.snapshot import Snapshot

HEIGHT_M = 0.02
OUTLINE_SIDES = 20  # of an outline
POINTER_RADII = 2.2  # radii from the middle to the tip of its pointer


class CandidatePoses:
    """One node for all of them; hidden while the robot knows where it is."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._outline = outline(robot.radius)
        self._strokes = Lines(scene, "/candidates", DOUBT, 2.4)
        self._shown: LostStatus | None = None

    def show(self, snapshot: Snapshot) -> None:
        lost = snapshot.floor.lost
        if lost is self._shown:
            return
        self._shown = lost
        places = () if lost is None else lost.candidates
        shades = (DOUBT, mix(DOUBT, UNSURE, 0.5))
        self._strokes.draw_each((stood(self._outline, one), shades[rank > 0]) for rank, one in enumerate(places))


def outline(radius: float) -> Array:
    """Segments (N, 2, 2) [m], robot frame: a ring and a pointer ahead."""
    angles = np.linspace(0.0, 2 * np.pi, OUTLINE_SIDES + 1)
    ring = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    pointer = [[[radius, 0.0], [POINTER_RADII * radius, 0.0]]]
    return np.concatenate((np.stack((ring[:-1], ring[1:]), axis=1), np.array(pointer)))


def stood(segments: Array, place: Array) -> Array:
    """Segments (N, 2, 2), robot frame, and a place (3,) x, y [m], heading [rad] → (N, 2, 3), world."""
    x, y, heading = place.tolist()
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    return lifted(segments @ turn + (x, y), HEIGHT_M)
