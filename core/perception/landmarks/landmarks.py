"""Landmarks as the paper has them: laser corners, confirmed and sharpened by vertical edges (section 4.1)."""

import dataclasses
import math

import numpy as np

from core.geometry import Pose, arc, wrap, wrap_all
from core.message import Array, message
from core.perception.landmarks.corners import Corner
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.sensors import Camera, Laser, Wheels


@message
class Sighting:
    """A landmark seen from the robot."""

    range: float  # [m] from the robot's origin
    bearing: float  # [rad] in the robot frame
    covariance: Array  # (2, 2) of range [m] and bearing [rad]
    stamp: float = 0.0  # [s] of the robot frame it is given in
    kind: str = ""  # "convex" | "concave" of a corner, "rise" | "fall" of an edge on a wall, or ""
    confirmed: bool = False  # a vertical edge stands there
    opening: float | None = None  # [rad] robot frame: bisector of the corner's walls, on the robot's side
    sector: float = math.pi  # [rad] around the opening from where the corner can be seen
    id: int | None = None  # whose it is, where that is known (experiments)

    @property
    def position(self) -> Array:
        """Position (2,) [m] in the robot frame."""
        return self.range * np.array([math.cos(self.bearing), math.sin(self.bearing)])


def sight(
    corners: tuple[Corner, ...],
    edges: tuple[ImageEdge, ...] = (),
    *,
    stamp: float = 0.0,
    edges_stamp: float = 0.0,
    wheels: Wheels | None = None,
    moved: Pose | None = None,
    camera: Camera | None = None,
    settings: EdgeSettings | None = None,
) -> tuple[tuple[Sighting, ...], tuple[ImageEdge, ...]]:
    """Corners at `stamp` [s] and edges at `edges_stamp` [s] → sightings, and the edges with those matched marked.

    `moved`: pose of the robot at `edges_stamp` seen from its pose at `stamp`; None: from the wheels' twist.
    An edge confirms the corner it goes with and sharpens its bearing. It is no gate, unless `edge_required` asks for
    the paper's rule: with a narrow camera that would starve the filter.
    """
    settings = settings or EdgeSettings()
    matched: dict[int, int] = {}
    if corners and edges and camera is not None:
        there = _moved(wheels, edges_stamp - stamp) if moved is None else moved
        corners, matched = _confirm(corners, edges, there, camera, settings)
    sightings = tuple(
        _sighting(corner, stamp, index in matched, settings)
        for index, corner in enumerate(corners)
        if index in matched or not settings.edge_required
    )
    confirming = set(matched.values())
    return sightings, tuple(
        dataclasses.replace(edge, matched=True) if index in confirming else edge for index, edge in enumerate(edges)
    )


def edges_on_walls(
    edges: tuple[ImageEdge, ...], points: Array, eye: Pose, stamp: float, settings: EdgeSettings
) -> tuple[tuple[Sighting, ...], tuple[ImageEdge, ...]]:
    """Edges that confirm no corner, seen from `eye` (robot_from_eye) → sightings of those on walls; the other edges.

    `points` (M, 2) [m] of the scan, robot frame: the wall says how far an edge on it is. In which direction the
    picture becomes brighter across the edge is its kind.
    """
    sightings: list[Sighting] = []
    others: list[ImageEdge] = []
    walls = SeenWalls(points, eye)
    for edge in edges:
        if edge.matched:
            continue
        wall = wall_range(walls, edge.bearing, settings.bearing_sd, settings.wall_sd)
        if wall is None or edge.step == 0:
            others.append(edge)
            continue
        reach, sd = wall
        ray = eye.heading + edge.bearing
        c, s = math.cos(ray), math.sin(ray)
        place = np.array([eye.x + reach * c, eye.y + reach * s])
        axes = np.array([[c, -s], [s, c]])
        spread = axes @ np.diag([sd**2, (reach * settings.bearing_sd) ** 2]) @ axes.T
        sightings.append(sighting_at(place, spread, stamp, settings, kind="rise" if edge.step > 0 else "fall"))
    return tuple(sightings), tuple(others)


ASIDE_RAD = math.radians(4)  # of the direction in which the wall's points are looked at
MIN_POINTS = 6  # points of a wall
MAX_WALL_RMS_M = 0.03  # rms off the line, at most
MIN_INCIDENCE_RAD = math.radians(8)  # between the wall and the direction, at least


class SeenWalls:
    """The points of a scan, as an eye sees them."""

    def __init__(self, points: Array, eye: Pose) -> None:
        """`points` (K, 2) [m] of the scan, robot frame; `eye` is robot_from_eye."""
        self._points = eye.inverse().apply(points)
        self._angles = np.arctan2(self._points[:, 1], self._points[:, 0])

    def near(self, bearing: float) -> Array | None:
        """Points (N, 2) [m], eye's frame, around a bearing [rad], some on either side; None: too few."""
        off = wrap_all(self._angles - bearing)
        beside = np.flatnonzero(np.abs(off) < ASIDE_RAD)
        if len(beside) < MIN_POINTS or off[beside].min() > 0 or off[beside].max() < 0:
            return None
        return self._points[beside]


def wall_range(walls: SeenWalls, bearing: float, sd: float, wall_sd: float) -> tuple[float, float] | None:
    """A bearing [rad] of an eye → range [m] of the wall there and its sd.

    `sd` [rad] of the bearing, `wall_sd` [m] across the wall. None where the laser sees no straight wall.
    """
    near = walls.near(bearing)
    if near is None:
        return None
    middle = near.mean(axis=0)
    values, vectors = np.linalg.eigh((near - middle).T @ (near - middle) / len(near))
    if math.sqrt(max(float(values[0]), 0.0)) > MAX_WALL_RMS_M:
        return None
    normal = vectors[:, 0]
    slope = float(normal @ np.array([math.cos(bearing), math.sin(bearing)]))
    if abs(slope) < math.sin(MIN_INCIDENCE_RAD):
        return None
    reach = float(normal @ middle) / slope
    along = math.sqrt(max(1 - slope**2, 0.0)) / abs(slope)
    return reach, math.hypot(wall_sd / slope, reach * along * sd)


def laser_in_picture(points: Array, laser: Laser, camera: Camera, moved: Pose | None = None) -> Array:
    """Laser points (M, 2) [m], robot frame → those in the picture (K, 3): u, v [pixel] and range [m] from the laser.

    `moved`: where the robot was when the picture was taken, in the robot frame of the points.
    """
    seen = (moved or Pose()).inverse().apply(points) if len(points) else points.reshape(0, 2)
    pixels, drawn = in_picture(np.column_stack((seen, np.full(len(seen), laser.height))), camera)
    ranges = np.hypot(points[:, 0] - laser.mounting.x, points[:, 1] - laser.mounting.y)
    return np.column_stack((pixels, ranges))[drawn]


def between_picture_edges(places: Array, camera: Camera) -> Array:
    """Return whether a vertical edge at each of these places (N, 2) [m], robot frame, stands in the picture (N,)."""
    height = np.full(len(places), camera.mounting.translation[2])
    return in_picture(np.column_stack((places, height)), camera)[1]


def in_picture(space: Array, camera: Camera) -> tuple[Array, Array]:
    """Points (M, 3) [m], robot frame → pixels (M, 2), NaN where there are none; whether each is in the picture."""
    in_camera = camera.mounting.inverse().apply(space)
    model, pixels = camera.model, np.full((len(space), 2), np.nan)
    ahead = in_camera[:, 2] > 0.01
    off_axis = np.hypot(in_camera[:, 0], in_camera[:, 1]) / np.where(ahead, in_camera[:, 2], np.nan)
    inside = ahead & (off_axis <= model.widest_ray)  # beyond, the distortion folds back
    pixels[inside] = model.project(in_camera[inside])
    (u, v), (width, height) = pixels.T, (model.width - 0.5, model.height - 0.5)
    return pixels, (u >= -0.5) & (u < width) & (v >= -0.5) & (v < height)


def _moved(wheels: Wheels | None, elapsed: float) -> Pose:
    """Pose of the robot `elapsed` [s] later (earlier if negative), seen from its pose now."""
    return Pose() if wheels is None else arc(wheels.speed * elapsed, wheels.turn_rate * elapsed)


def _confirm(
    corners: tuple[Corner, ...], edges: tuple[ImageEdge, ...], moved: Pose, camera: Camera, settings: EdgeSettings
) -> tuple[tuple[Corner, ...], dict[int, int]]:
    """Corners, edges → the corners with sharpened bearings, and corner → edge for those matched (one to one)."""
    eye = moved.apply(camera.mounting.translation[None, :2])[0]
    edge_variance = settings.bearing_sd**2 + (settings.shift_share * moved.heading) ** 2
    seen = np.array([corner.position - eye for corner in corners])
    reach = np.maximum((seen**2).sum(axis=1), 1e-6)
    slopes = np.column_stack((-seen[:, 1], seen[:, 0])) / reach[:, None]
    spreads = np.array([corner.covariance for corner in corners])
    variances = np.einsum("ci,cij,cj->c", slopes, spreads, slopes) + edge_variance
    bearings = np.arctan2(seen[:, 1], seen[:, 0])
    shown = np.array([edge.bearing + moved.heading for edge in edges])
    from scipy.optimize import linear_sum_assignment  # the pilot has it; drivers, which know sightings, do without

    off = wrap_all(shown[None, :] - bearings[:, None])
    distance = off**2 / variances[:, None]
    fits = distance < settings.gate**2
    rows, columns = linear_sum_assignment(np.where(fits, distance, 1e3))
    matched = {int(row): int(column) for row, column in zip(rows, columns, strict=True) if fits[row, column]}
    sharpened = list(corners)
    for row, column in matched.items():
        gain = spreads[row] @ slopes[row] / variances[row]
        sharpened[row] = dataclasses.replace(
            corners[row],
            position=corners[row].position + gain * off[row, column],
            covariance=spreads[row] - variances[row] * np.outer(gain, gain),
        )
    return tuple(sharpened), matched


def _sighting(corner: Corner, stamp: float, confirmed: bool, settings: EdgeSettings) -> Sighting:
    seen = sighting_at(corner.position, settings.inflation * corner.covariance, stamp, settings, kind=corner.kind)
    return dataclasses.replace(seen, confirmed=confirmed, opening=corner.opening, sector=corner.sector)


def sighting_at(position: Array, covariance: Array, stamp: float, settings: EdgeSettings, kind: str) -> Sighting:
    """Place (2,) [m] in the robot frame → range and bearing with their covariance J C Jᵀ, and the floor below it."""
    x, y = position.tolist()
    reach = max(math.hypot(x, y), 1e-6)
    slopes = np.array([[x / reach, y / reach], [-y / reach**2, x / reach**2]])
    floor = np.diag([settings.range_floor**2, settings.bearing_floor**2])
    return Sighting(
        range=reach,
        bearing=wrap(math.atan2(y, x)),
        covariance=slopes @ covariance @ slopes.T + floor,
        stamp=stamp,
        kind=kind,
    )
