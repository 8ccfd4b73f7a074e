"""The floor in the camera's picture: a way and a ring on it as the picture shows them, and a pixel's point of it."""

import math

import numpy as np

from core.errors import BadInput
from core.geometry import floor_point
from core.message import Array
from core.perception.landmarks.landmarks import in_picture
from core.sensors import Camera
from core.sentences import Statement

STEP_M, MAX_STEPS = 0.01, 1000  # between two points of a way that are looked at, and how many there are
MAX_POINTS, MIN_STEP_PX = 24, 6.0  # of a way in the picture, but for the ends of its parts
MAX_PARTS = 3
RING_POINTS = 12
MAX_SHIFT_M = 0.3  # by which a point of the floor may move with one pixel
HIDING_RAD, HIDING_M = math.radians(1.5), 0.1  # beside the direction of a point, and before it, to hide it
ABOVE, FAR = Statement("picture_floor.above"), Statement("picture_floor.far")
HIDDEN, ASSUMED = Statement("picture_floor.hidden"), Statement("picture_floor.assumed")


def way_in_picture(way: Array, camera: Camera) -> list[Array]:
    """A way (P, 2) [m] on the floor, robot frame → what of it is in the picture: parts (K, 3) of u, v [pixel] and the
    distance from the camera [m].
    """
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))))
    steps = np.linspace(0.0, along[-1], 2 + min(int(along[-1] / STEP_M), MAX_STEPS))
    points = np.column_stack([np.interp(steps, along, one) for one in way.T])
    pixels, inside = in_picture(np.column_stack((points, np.zeros(len(points)))), camera)
    rows = np.column_stack((pixels, np.linalg.norm(points - camera.mounting.translation[:2], axis=1)))
    parts = np.split(np.arange(len(rows)), np.flatnonzero(np.diff(inside)) + 1)
    seen = [rows[part] for part in parts if inside[part[0]] and len(part) > 1][:MAX_PARTS]
    lengths = [np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(part[:, :2], axis=0).T)))) for part in seen]
    step = max(MIN_STEP_PX, sum(float(length[-1]) for length in lengths) / MAX_POINTS)
    return [_thinned(part, length, step) for part, length in zip(seen, lengths, strict=True)]


def ring_in_picture(centre: Array, radius: float, camera: Camera) -> Array:
    """A ring on the floor around (2,) [m], robot frame → (N, 2) [pixel]; empty where the picture does not show it."""
    turns = np.linspace(0.0, math.tau, RING_POINTS, endpoint=False)
    points = np.column_stack((centre[0] + radius * np.cos(turns), centre[1] + radius * np.sin(turns)))
    pixels, inside = in_picture(np.column_stack((points, np.zeros(RING_POINTS))), camera)
    return pixels if inside.any() and np.isfinite(pixels).all() else np.zeros((0, 2))


def floor_at(u: float, v: float, camera: Camera, scan: Array) -> tuple[float, float]:
    """A pixel → the point of the floor [m] that it shows, robot frame. `scan` (M, 2) [m]: the laser's points there.

    Raises BadInput where it shows none, or one that it does not locate.
    """
    if not camera.is_known:
        raise BadInput(ASSUMED)
    pixels = np.array([(u, v), (u, v - 1), (u + 1, v)])
    rays = np.column_stack((camera.model.unproject(pixels), np.ones(3))) @ camera.mounting.rotation.T
    x, y, z = camera.mounting.translation.tolist()
    found, *others = [floor_point((x, y, z), (a, b, c)) for a, b, c in rays.tolist()]
    if found is None:
        raise BadInput(ABOVE)
    seen, there = scan - (x, y), np.array(found) - (x, y)
    aside = np.abs(np.angle((seen @ (1, 1j)) * np.conj(there @ (1, 1j))))
    if ((aside < HIDING_RAD) & (np.linalg.norm(seen, axis=1) < np.linalg.norm(there) - HIDING_M)).any():
        raise BadInput(HIDDEN)
    if any(other is None or math.dist(found, other) > MAX_SHIFT_M for other in others):
        raise BadInput(FAR(centimetres=f"{100 * MAX_SHIFT_M:.0f}"))
    return found


def _thinned(part: Array, along: Array, step: float) -> Array:
    """A part of a way (K, 3) with points every `step` [pixel]; `along` (K,) [pixel] of each from its begin."""
    wanted = np.linspace(0.0, along[-1], 2 + int(along[-1] / step))
    return np.column_stack([np.interp(wanted, along, column) for column in part.T])
