"""Vertical edges in a picture, as bearings (Canny, Hough; section 4.1)."""

import math
from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.perception.landmarks.level_view import LevelView, level_view
from core.sensors import Camera, Image
from core.setting import Meta, Section


@message
class Preprocessing:
    """Preprocessing steps before edge detection; the defaults do nothing."""

    gain: float = 1.0  # on the light, before it is rounded to grey levels
    gamma: float = 1.0  # on the result: below 1 lifts the darks
    contrast: float = 1.0  # on gradients; below 1 where even the smoothing leaves too much noise
    along: float = 1.0  # times Canny's smoothing, along upright edges
    across: float = 1.0  # and across them

    @property
    def idle(self) -> bool:
        """True when no step does anything."""
        return (self.gain, self.gamma, self.contrast, self.along, self.across) == (1.0, 1.0, 1.0, 1.0, 1.0)

    def grey(self, pixels: Array) -> Array:
        """Picture (H, W, 3) or (H, W) uint8 → grey (H, W) uint8, brightened before anything is rounded."""
        if self.gain == 1.0:
            grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if pixels.ndim == 3 else pixels
        elif pixels.ndim == 3:
            grey = cv2.transform(pixels, self.gain * np.array([[0.114, 0.587, 0.299]]))
        else:
            grey = cv2.convertScaleAbs(pixels, alpha=self.gain)
        if self.gamma != 1.0:
            curve = 255 * (np.arange(256) / 255) ** self.gamma
            grey = cv2.LUT(grey, np.round(curve).astype(np.uint8))
        return grey

    def slope(self, level: float) -> float:
        """Factor by which gain and gamma enlarge a small difference at grey level `level`."""
        reached = min(max(self.gain * level, 1.0), 255.0)
        return self.gain * self.gamma * (reached / 255) ** (self.gamma - 1)


NOTHING = Preprocessing()


@message
class ImageEdge:
    """A vertical edge in the newest picture."""

    top: Array  # (2,) pixel in the picture as the camera delivers it
    bottom: Array  # (2,) pixel
    bearing: float  # [rad] in the robot's axes, seen from the camera
    matched: bool = False  # confirms a laser corner
    step: float = 0.0  # by which the picture becomes brighter across it, from left to right


@dataclass(frozen=True)
class EdgeSettings(Section):
    """Criteria of a vertical edge and of its match with a corner.

    Watch:
        canny_low: edges drawn on the picture; raise it for noise among them
        canny_high: edges drawn on the picture; lower it for missing pale ones
        bearing_sd: corners that an edge confirms; raise it where a new calibration confirms fewer
        on_walls: landmarks on bare walls, and the pose's sd in a corridor
        by_pair: landmarks where the laser sees no corner
    """

    blur: float = 1.0  # [pixel] sd of the smoothing against sensor noise
    tilt: float = math.radians(5)  # [rad] angle of an edge off the vertical, at most
    length: float = 0.2  # length of an edge per picture's height, at least
    gap: float = 6.0  # [pixel] gap within an edge, at most
    together: float = 3.0  # [pixel] columns closer together than this are one edge
    shift_share: float = 0.1  # sd of the turn between picture and scan, as a share of it
    gate: float = 3.0  # [sd] distance between an edge and the corner it confirms, at most
    inflation: float = 1.3  # factor on a corner's covariance: a wall can hide steps within the laser's noise
    range_floor: float = 0.004  # [m] sd of a sighting's range that no averaging takes away
    bearing_floor: float = math.radians(0.08)  # [rad] sd of a sighting's bearing that no averaging takes away
    corners_enough: int = 2  # corners in a scan from which edges that confirm none are left alone: they repeat errors
    wall_sd: float = 0.02  # [m] sd across the wall of such an edge's distance
    pair_sd: float = math.radians(0.04)  # [rad] sd of a bearing of a pair of cameras against the other's
    edge_required: bool = False  # the paper's rule: a corner without an edge is no landmark
    canny_low: Annotated[float, Meta("", 1, 500, "lower gradient threshold of Canny's hysteresis")] = 15.0
    canny_high: Annotated[float, Meta("", 1, 1000, "upper gradient threshold of Canny's hysteresis")] = 35.0
    bearing_sd: Annotated[
        float, Meta("rad", 1e-5, 0.2, "sd of an edge's bearing, extrinsic calibration included")
    ] = math.radians(0.25)
    on_walls: Annotated[
        bool, Meta(meaning="an edge that confirms no corner is a landmark where the laser sees a straight wall")
    ] = True
    by_pair: Annotated[bool, Meta(meaning="so is one whose distance a second camera beside the first gives")] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.canny_low > self.canny_high:
            raise BadInput(f"canny_low must not exceed canny_high: {self.canny_low:g} and {self.canny_high:g}.")


def find_edges(
    image: Image, camera: Camera, settings: EdgeSettings | None = None, preparation: Preprocessing = NOTHING
) -> tuple[ImageEdge, ...]:
    """Picture → its vertical edges, left to right in the picture. Raises BadInput for a picture of another size.

    `preparation` is what the picture's quality calls for; without it the picture is taken as it comes.
    """
    settings = settings or EdgeSettings()
    model = camera.model
    if image.pixels.shape[:2] != (model.height, model.width):
        size = "x".join(str(n) for n in image.pixels.shape[1::-1])
        raise BadInput(
            f"The picture is {size}, its calibration {model.width}x{model.height}; calibrate at this size."
        )
    view = level_view(camera)
    outline, across = _outline(view.warp(preparation.grey(image.pixels)), view, settings, preparation)
    edges: list[ImageEdge] = []
    for top, bottom, column in _uprights(outline, np.abs(across), settings):
        ends = view.to_picture(np.array([[column, top], [column, bottom]]))
        if np.isfinite(ends).all():
            step = _step(across, int(top), int(bottom), round(column))
            edges.append(ImageEdge(top=ends[0], bottom=ends[1], bearing=view.bearing(column), step=step))
    return tuple(edges)


def _outline(
    level: Array, view: LevelView, settings: EdgeSettings, preparation: Preprocessing
) -> tuple[Array, Array]:
    """Level picture → Canny's outline where it runs upright (uint8), and the slope across (float32)."""
    spread = settings.blur * preparation.across, settings.blur * preparation.along
    smooth = cv2.GaussianBlur(level, (0, 0), sigmaX=spread[0], sigmaY=spread[1])
    across = cv2.Sobel(smooth, cv2.CV_16S, 1, 0)
    down = cv2.Sobel(smooth, cv2.CV_16S, 0, 1)
    low, high = settings.canny_low / preparation.contrast, settings.canny_high / preparation.contrast
    outline = cv2.Canny(across, down, low, high, L2gradient=True)
    slope = across.astype(np.float32)
    upright = (np.abs(slope) > 2.0 * np.abs(down)) & view.inside
    return np.where(upright, outline, 0).astype(np.uint8), slope


def _uprights(outline: Array, steepness: Array, settings: EdgeSettings) -> list[tuple[float, float, float]]:
    """Outline → upright edges as (top row, bottom row, column); segments of nearly one column are one edge."""
    shortest = settings.length * outline.shape[0]
    broad = cv2.dilate(outline, np.ones((1, 3), np.uint8))  # an edge between two columns must not fall to pieces
    found = cv2.HoughLinesP(
        broad, 1.0, math.pi / 360, int(0.5 * shortest), minLineLength=0.6 * shortest, maxLineGap=settings.gap
    )
    if found is None:
        return []
    segments = np.asarray(found, dtype=float).reshape(-1, 4)  # OpenCV 4 has (N, 1, 4), OpenCV 5 (N, 4)
    rise = np.abs(segments[:, 3] - segments[:, 1])
    slope = np.abs(segments[:, 2] - segments[:, 0]) / np.maximum(rise, 1e-9)
    segments = segments[slope < math.tan(settings.tilt)]
    segments = segments[np.argsort(0.5 * (segments[:, 0] + segments[:, 2]))]
    middle = 0.5 * (segments[:, 0] + segments[:, 2])
    groups = np.split(segments, np.flatnonzero(np.diff(middle) > settings.together) + 1)
    edges: list[tuple[float, float, float]] = []
    for group in groups:
        piece = _longest(group, settings.gap)
        if len(piece) and piece[:, 1::2].max() - piece[:, 1::2].min() >= shortest:
            top, bottom = float(piece[:, 1::2].min()), float(piece[:, 1::2].max())
            columns = 0.5 * (piece[:, 0] + piece[:, 2])
            edges.append((top, bottom, _column(steepness, int(top), int(bottom), columns, settings)))
    return edges


def _longest(group: Array, gap: float) -> Array:
    """Segments (K, 4) of one column → those of its longest piece without a larger gap."""
    if not len(group):
        return group
    tops, bottoms = group[:, 1::2].min(axis=1), group[:, 1::2].max(axis=1)
    order = np.argsort(tops)
    reached = np.maximum.accumulate(bottoms[order])
    pieces = np.split(order, np.flatnonzero(tops[order][1:] > reached[:-1] + gap) + 1)
    return group[max(pieces, key=lambda piece: bottoms[piece].max() - tops[piece].min())]


def _step(across: Array, top: int, bottom: int, column: int) -> float:
    left, right = max(column - 1, 0), min(column + 2, across.shape[1])
    return float(across[top : bottom + 1, left:right].mean())


def _column(steepness: Array, top: int, bottom: int, columns: Array, settings: EdgeSettings) -> float:
    """Column of an edge to a part of a pixel: the centre of the steepness around it, over all its rows."""
    reach = round(settings.together) + 1
    middle = round(float(columns.mean()))
    left, right = max(middle - reach, 0), min(middle + reach + 1, steepness.shape[1])
    profile = steepness[top : bottom + 1, left:right].mean(axis=0)
    profile = np.maximum(profile - profile.min(), 0.0) ** 2
    total = float(profile.sum())
    return float((profile * np.arange(left, right)).sum()) / total if total > 0 else float(columns.mean())
