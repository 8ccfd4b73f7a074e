"""The distance of vertical edges that two cameras beside each other see, where no laser gives it."""

import math
from collections.abc import Sequence

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.perception.landmarks.landmarks import Sighting, sighting_at
from core.sensors import Camera

MIN_BASELINE_M = 0.02  # between two cameras that are a pair
MAX_AXES_RAD = math.radians(10)  # between the directions in which they look
MAX_STAMPS_S = 0.002  # between two pictures of one moment
MIN_DISTANCE_M = 0.2  # of an edge
MIN_DISPARITY_SDS = 5.0  # standard deviations of a disparity: the distance is known to a fifth, at least
MAX_ENDS_OFF = 0.03  # between the ends of an edge in the two pictures, as slopes of their rays
MIN_RIVAL_RATIO, MIN_RIVAL_OFF = 2.0, 0.01  # difference of any other edge's ends, as its multiple, and at least
MIN_STEP_RATIO = 0.6  # of an edge's steps in brightness in the two pictures


def second_camera(cameras: Sequence[Camera]) -> Camera | None:
    """The camera that makes a pair with the first: it looks the same way from beside it; None: there is none."""
    for other in cameras[1:]:
        first = cameras[0].mounting
        apart = np.linalg.norm((other.mounting.translation - first.translation)[:2])
        if apart >= MIN_BASELINE_M and first.rotation[:, 2] @ other.mounting.rotation[:, 2] >= math.cos(MAX_AXES_RAD):
            return other
    return None


def edges_by_pair(
    edges: tuple[ImageEdge, ...],
    others: tuple[ImageEdge, ...],
    cameras: tuple[Camera, Camera],
    eye: Pose,
    stamp: float,
    settings: EdgeSettings,
) -> tuple[tuple[Sighting, ...], tuple[ImageEdge, ...]]:
    """Edges of the first camera and of the second → sightings of those that both see; the rest of the first's.

    `eye` is robot_from_eye of the first camera, in whose axes the bearings are. What any other edge of either picture
    fits nearly as well stays a bearing.
    """
    if not edges or not others:
        return (), edges
    (one, ends, steps), (two, other_ends, other_steps) = map(_columns, (edges, others), cameras)
    x, y = (cameras[1].mounting.translation - cameras[0].mounting.translation)[:2].tolist()
    disparity = np.sin(two - one[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = (x * np.sin(two) - y * np.cos(two)) / disparity  # of the crossing of the rays, from the first
        other_reach = (x * np.sin(one) - y * np.cos(one))[:, None] / disparity  # the same from the second
        step = steps[:, None] / other_steps
        fits = (np.minimum(reach, other_reach) > MIN_DISTANCE_M) & (np.minimum(step, 1 / step) >= MIN_STEP_RATIO)
    fits &= np.abs(disparity) >= MIN_DISPARITY_SDS * math.sqrt(2) * settings.pair_sd
    off = np.where(fits, np.abs(ends[:, None] - other_ends).max(axis=2), np.inf)
    sightings: list[Sighting] = []
    alone: list[ImageEdge] = []
    for i, edge in enumerate(edges):
        j = int(off[i].argmin())
        rivals = np.concatenate((np.delete(off[i], j), np.delete(off[:, j], i)))
        least = max(MIN_RIVAL_RATIO * float(off[i, j]), MIN_RIVAL_OFF)
        if edge.matched or off[i, j] > MAX_ENDS_OFF or np.any(rivals < least):
            alone.append(edge)
            continue
        rays = eye.heading + np.array([one[i], two[j]])
        normals = np.column_stack((-np.sin(rays), np.cos(rays)))
        slopes = np.linalg.inv(normals) @ np.diag([reach[i, j], other_reach[i, j]])  # of the crossing, with the rays
        across = reach[i, j] * normals[0]  # its change with the mounting, which turns both rays
        spread = settings.pair_sd**2 * slopes @ slopes.T + settings.bearing_sd**2 * np.outer(across, across)
        place = np.array([eye.x, eye.y]) + reach[i, j] * np.array([math.cos(rays[0]), math.sin(rays[0])])
        sightings.append(sighting_at(place, spread, stamp, settings, kind="rise" if edge.step > 0 else "fall"))
    return tuple(sightings), tuple(alone)


def _columns(edges: Sequence[ImageEdge], camera: Camera) -> tuple[Array, Array, Array]:
    """Bearings (N,) [rad], slopes of the rays to both ends (N, 2), and steps (N,) in brightness of edges."""
    ends = camera.model.unproject(np.array([end for edge in edges for end in (edge.top, edge.bottom)]))[:, 1]
    return np.array([edge.bearing for edge in edges]), ends.reshape(-1, 2), np.array([edge.step for edge in edges])
