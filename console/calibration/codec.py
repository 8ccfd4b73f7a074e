"""Messages between the console and its calibration workers: plain values, both ways."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from console.messages.calibration import CalibrationSessionState
from core.calibration.board.board import Board
from core.calibration.camera.guidance import Advice
from core.message import Array
from core.optics import CameraModel

SMALL = 200  # [pixel] longest side of a thumbnail
CAMERA_NAMES = ("width", "height", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
OTHER_VIEWS = (
    "The solution is of other views than those that take part now. Take the views back that it was made of, or show "
    "more until it is solved again."
)

Fields = dict[str, Any]


def board_of(fields: Fields) -> Board:
    """{"columns", "rows", "square_m", "panel_m"} → the board. Raises BadInput."""
    panel = fields["panel_m"]
    return Board(
        columns=fields["columns"],
        rows=fields["rows"],
        square=fields["square_m"],
        panel=None if panel is None else (panel[0], panel[1]),
    )


def board_fields(board: Board) -> Fields:
    """A board → its fields."""
    panel = None if board.panel is None else list(board.panel)
    return {"columns": board.columns, "rows": board.rows, "square_m": board.square, "panel_m": panel}


def camera_of(fields: Fields) -> CameraModel:
    """The camera's parameters by name → the camera. Raises BadInput."""
    return CameraModel(**{name: fields[name] for name in CAMERA_NAMES})


def camera_fields(model: CameraModel) -> Fields:
    """A camera → its fields."""
    size = {"width": model.width, "height": model.height}
    return {**{name: float(getattr(model, name)) for name in CAMERA_NAMES}, **size}


def points(array: Array, digits: int = 1) -> list[Any]:
    """Points (N, K), rounded for the page."""
    return np.round(array.astype(float), digits).tolist()


def advice_fields(advice: Advice | None) -> Fields | None:
    """The next view, and the board's pose for a program that can hold it exactly."""
    if advice is None:
        return None
    return {
        "words": advice.words,
        "outline": points(advice.outline),
        "corners": points(advice.corners),
        "rotation": advice.rotation.tolist(),
        "translation_m": advice.translation.tolist(),
    }


def grey_of(pixels: bytes, width: int, height: int) -> Array:
    """Raw bytes → the grey picture (H, W) uint8."""
    return np.frombuffer(pixels, np.uint8).reshape(height, width)


def png(grey: Array) -> bytes:
    """Without loss."""
    return cv2.imencode(".png", grey)[1].tobytes()


def jpeg(picture: Array, longest: int | None = None, quality: int = 85) -> bytes:
    """Made smaller where a side is longer than `longest` [pixel]."""
    scale = 1.0 if longest is None else min(1.0, longest / max(picture.shape[:2]))
    if scale < 1:
        picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def camera_in(session: CalibrationSessionState) -> Fields | None:
    """The solved camera's parameters by name, where there is one."""
    solution = session.solution
    if session.kind != "camera" or solution is None:
        return None
    width, height = solution["image_size"]
    names = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")
    return {
        "width": width,
        "height": height,
        "k3": solution.get("k3", 0.0),
        **{name: solution[name] for name in names},
    }
