"""Between core's values and the calibration's messages."""

import cv2
import msgspec
import numpy as np

from console.calibration.answers import AdvisedView
from console.messages.calibration import CalibrationAdvice, CalibrationBoard, CalibrationSessionState, Pixel
from core.calibration.board.board import Board
from core.calibration.camera.guidance import Advice
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel

THUMBNAIL_PX = 200  # longest side of a thumbnail


def board_of(board: CalibrationBoard) -> Board:
    """The board of a session. Raises BadInput."""
    return Board(columns=board.columns, rows=board.rows, square=board.square_m, panel=board.panel_m)


def points(array: Array, digits: int = 1) -> list[Pixel]:
    """Points (N, 2), rounded for the page."""
    return [(x, y) for x, y in np.round(array.astype(float), digits).tolist()]


def advised_view(advice: Advice | None) -> AdvisedView | None:
    """The next view, and the board's pose for a program that can hold it exactly."""
    if advice is None:
        return None
    shown = CalibrationAdvice(advice.words, points(advice.outline), points(advice.corners))
    return AdvisedView(shown, Transform(rotation=advice.rotation, translation=advice.translation))


def png(grey: Array) -> bytes:
    return cv2.imencode(".png", grey)[1].tobytes()


def camera_in(session: CalibrationSessionState) -> CameraModel | None:
    if session.kind != "camera" or session.solution is None:
        return None
    width, height = session.solution["image_size"]
    return msgspec.convert({**session.solution, "width": width, "height": height}, CameraModel)
