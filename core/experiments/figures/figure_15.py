"""Figure 15: the boards about the camera, drawn as a picture."""

from __future__ import annotations

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.calibration.projection import Poses
from core.message import Array
from core.optics import CameraModel

TURN, LIFT = np.deg2rad(58), np.deg2rad(24)  # from where it is seen: behind, aside and above the camera
REACH = 0.1  # [m] from the camera to its drawn picture
AXES = 0.16  # [m]
STEP = 0.1  # [m] between the lines of the floor
RIM = 36  # [pixel] left free around everything
SMOOTH = 4  # bits of the fraction of a pixel, in which cv2 takes places
GREY, DARK = (222, 222, 222), (70, 70, 70)


class BoardDrawing:
    """A white picture on which points of the camera's frame are drawn, large enough for all of `shown` (N, 3) [m]."""

    def __init__(self, shown: Array, size: tuple[int, int]) -> None:
        """`size`: width and height [pixel]."""
        self.image = np.full((size[1], size[0], 3), 255, np.uint8)
        flat = _seen(shown)[:, :2]
        low, high = flat.min(axis=0), flat.max(axis=0)
        self._scale = float(np.min((np.array(size) - 2 * RIM) / (high - low)))
        self._shift = np.array(size) / 2 - (low + high) / 2 * self._scale

    def places(self, points: Array) -> Array:
        """Points (N, 3) [m] → (N, 2) in fractions of a pixel as cv2 takes them."""
        return np.rint((_seen(points)[:, :2] * self._scale + self._shift) * 2**SMOOTH).astype(np.int32)

    def line(self, points: Array, colour: tuple[int, ...], width: int = 1, *, closed: bool = False) -> None:
        """Draw through points (N, 3)."""
        cv2.polylines(self.image, [self.places(points)], closed, colour, width, cv2.LINE_AA, SMOOTH)

    def area(self, points: Array, colour: tuple[int, ...], strength: float) -> None:
        """Fill between points (N, 3), letting what is behind shine through."""
        over = self.image.copy()
        cv2.fillPoly(over, [self.places(points)], colour, cv2.LINE_AA, SMOOTH)
        self.image = cv2.addWeighted(over, strength, self.image, 1 - strength, 0).astype(np.uint8)

    def word(self, text: str, point: Array, colour: tuple[int, ...]) -> None:
        """Write at a point (3,)."""
        u, v = (self.places(point[None])[0] / 2**SMOOTH).astype(int).tolist()
        cv2.putText(self.image, text, (u - 5, v + 5), cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)


def camera_centred(poses: Poses, board: Board, model: CameraModel, size: tuple[int, int] = (1100, 680)) -> Array:
    """Boards in the camera's frame over a floor of squares of 0.1 m: (H, W, 3) uint8, the farthest first."""
    outlines = board.outline @ np.swapaxes(poses.rotations, 1, 2) + poses.translations[:, None]
    every = np.concatenate((outlines.reshape(-1, 3), np.zeros((1, 3))))
    low, high = np.floor(every.min(axis=0) / STEP) * STEP, np.ceil(every.max(axis=0) / STEP) * STEP
    ground = np.array([[x, high[1], z] for x in (low[0], high[0]) for z in (0.0, high[2])])
    sheet = BoardDrawing(np.concatenate((every, ground)), size)
    _floor(sheet, low, high)
    for number in np.argsort(-_seen(outlines.mean(axis=1))[:, 2]):
        colour = _colour(number / len(outlines))
        sheet.area(outlines[number], colour, 0.35)
        sheet.line(outlines[number], colour, 2, closed=True)
    for number, middle in enumerate(outlines.mean(axis=1), start=1):
        sheet.word(str(number), middle, DARK)
    _camera(sheet, model)
    return sheet.image


def _floor(sheet: BoardDrawing, low: Array, high: Array) -> None:
    """A grid below the lowest board, its depth written every second line."""
    for x in np.arange(low[0], high[0] + STEP / 2, STEP):
        sheet.line(np.array([[x, high[1], 0.0], [x, high[1], high[2]]]), GREY)
    for number, z in enumerate(np.arange(0.0, high[2] + STEP / 2, STEP)):
        sheet.line(np.array([[low[0], high[1], z], [high[0], high[1], z]]), GREY)
        if number % 2 == 0:
            sheet.word(f"{z:.1f} m", np.array([high[0] + STEP / 2, high[1], z]), (150, 150, 150))


def _camera(sheet: BoardDrawing, model: CameraModel) -> None:
    """The camera's view as a pyramid, and its axes."""
    half = np.array([model.width / model.fx, model.height / model.fy]) / 2 * REACH
    rim = np.array([[x * half[0], y * half[1], REACH] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    for corner in rim:
        sheet.line(np.stack((np.zeros(3), corner)), (0, 0, 0))
    sheet.line(rim, (0, 0, 0), 2, closed=True)
    for axis, (name, colour) in zip(
        AXES * np.eye(3), (("X", (40, 40, 200)), ("Y", (40, 140, 40)), ("Z", (200, 80, 40))), strict=True
    ):
        sheet.line(np.stack((np.zeros(3), axis)), colour, 2)
        sheet.word(name, 1.12 * axis, colour)


def _seen(points: Array) -> Array:
    """Points (N, 3) of the camera's frame → right, down and away as the onlooker sees them."""
    x, y, z = points.T
    right, away = x * np.cos(TURN) + z * np.sin(TURN), z * np.cos(TURN) - x * np.sin(TURN)
    return np.column_stack((right, y * np.cos(LIFT) - away * np.sin(LIFT), y * np.sin(LIFT) + away * np.cos(LIFT)))


def _colour(share: float) -> tuple[int, ...]:
    hue = np.array([[[int(175 * share), 190, 175]]], np.uint8)
    return tuple(int(level) for level in cv2.cvtColor(hue, cv2.COLOR_HSV2BGR)[0, 0])
