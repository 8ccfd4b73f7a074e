"""How sure the robot is of where it is: two standard deviations of place, and of heading; where it may be if lost."""

import math

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import Lines, ellipses, joined, lifted
from console.scene.drawing.palette import DOUBT, POSE, faded
from console.scene.drawing.shapes import place
from core.geometry import Pose
from core.message import Array
from core.robots import Profile
from core.slam.map.status import LostStatus
from core.snapshot import Snapshot

ELLIPSE_SDS = 2.0
HEIGHT_M = 0.010
MIN_CHANGE_SHARE = 0.02  # relative change of the covariance that is worth a new drawing
CANDIDATE_HEIGHT_M = 0.02
OUTLINE_SIDES = 20  # of an outline
POINTER_RADII = 2.2  # radii from the middle to the tip of its pointer


class PoseEllipse:
    """An ellipse under the robot and a wedge of headings before it; both travel with it as one."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._reach = 2.6 * robot.radius
        self._place = scene.add_frame("/sureness", show_axes=False)
        self._heading = scene.add_frame("/sureness/heading", show_axes=False)
        self._ellipse = Lines(scene, "/sureness/ellipse", POSE, 2.4)
        self._wedge = Lines(scene, "/sureness/heading/wedge", POSE, 1.4)
        self._drawn = np.full((3, 3), np.inf)

    def show(self, snapshot: Snapshot) -> None:
        pose, covariance = snapshot.estimate.pose, snapshot.estimate.covariance
        place(self._place, Pose(pose.x, pose.y))
        place(self._heading, Pose(heading=pose.heading))
        if np.abs(covariance - self._drawn).max() <= MIN_CHANGE_SHARE * np.abs(np.diag(covariance)).min():
            return
        self._drawn = covariance
        self._ellipse.draw(ellipses(np.zeros((1, 2)), covariance[None, :2, :2], ELLIPSE_SDS, HEIGHT_M))
        self._wedge.draw(joined(wedge(self._reach, float(covariance[2, 2])), HEIGHT_M))


def wedge(reach: float, variance: float) -> Array:
    """Variance of the heading [rad²] → outline (15, 2) [m] of the headings that are likely, about straight ahead."""
    half = min(ELLIPSE_SDS * math.sqrt(max(variance, 0.0)), math.pi)
    angles = np.linspace(-half, half, 13)
    arc = reach * np.column_stack((np.cos(angles), np.sin(angles)))
    return np.vstack((np.zeros((1, 2)), arc, np.zeros((1, 2))))


class CandidatePoses:
    """While the robot is lost: outlines of itself where it may be, the likeliest drawn the strongest; in one node."""

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
        shades = (DOUBT, faded(DOUBT, 0.5))
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
    return lifted(segments @ turn + (x, y), CANDIDATE_HEIGHT_M)
