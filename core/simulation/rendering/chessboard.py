"""Rendering of a chessboard: every pixel is the mean of the area it covers, so corners stay in their places."""

import math
from typing import NamedTuple

import cv2
import numpy as np

from core.message import Array
from core.simulation.rendering.mipmap import shade
from core.simulation.rendering.view import Eye, PinholeView
from core.simulation.world import HeldBoard

DARK_GREY, LIGHT_GREY, BACK_GREY = 40.0, 214.0, 130.0  # grey levels of ink, paper and the panel's other side
NEAR_PLANE_M = 0.05  # ahead of the eye; nearer panels are not drawn in part


class BoardInView(NamedTuple):
    """A board in a view."""

    rows: slice
    columns: slice
    grey: Array  # (R, C)
    cover: Array  # (R, C) share of the pixel that the panel covers
    depth: Array  # (R, C) [m] ahead


def see(board: HeldBoard, view: PinholeView, eye: Eye) -> BoardInView | None:
    """The board as the eye sees it, whatever may be in front of it; None where it is out of view."""
    outline = _from_eye(board.outline, eye)
    if outline[:, 2].min() < NEAR_PLANE_M:
        return None
    across, down = outline[:, 0] / outline[:, 2], outline[:, 1] / outline[:, 2]
    rim = 2 / view.focal
    columns = view.columns(float(across.min()) - rim, float(across.max()) + rim)
    rows = view.rows(float(down.min()) - rim, float(down.max()) + rim)
    if columns.start == columns.stop or rows.start == rows.stop:
        return None
    origin, along, aside = _from_eye(board.pose.apply(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])), eye)
    plane = np.column_stack((along - origin, aside - origin, origin))
    if abs(np.linalg.det(plane)) < 1e-9:
        return None  # seen exactly from the side
    back = np.linalg.inv(plane).astype(np.float32)
    x, y = view.x[columns].astype(np.float32)[None, :], view.y[rows].astype(np.float32)[:, None]
    nearness = back[2, 0] * x + (back[2, 1] * y + back[2, 2])
    depth = 1 / nearness
    places, widths = zip(*(_on_board(back, axis, x, y, depth, view.focal) for axis in (0, 1)), strict=True)
    cover = np.ones_like(depth)
    for place, width, middle, size in zip(places, widths, board.middle[:2], board.panel, strict=True):
        cover *= _within(place - np.float32(middle), width, size / 2)
    # The world's normal of the front points to the viewer: against the board's z.
    front = -board.pose.rotation[:, 2]
    faces = float(plane[:, 2] @ np.cross(plane[:, 0], plane[:, 1])) > 0
    light = _brightness(front if faces else -front)
    grey = np.full_like(depth, BACK_GREY)
    if faces:
        grey = _ink(board, places, widths)
        grey *= np.float32(DARK_GREY - LIGHT_GREY)
        grey += np.float32(LIGHT_GREY)
    grey *= np.float32(light)
    return BoardInView(rows, columns, grey, cover, depth)


def _from_eye(points: Array, eye: Eye) -> Array:
    """World points (K, 3) [m] → (K, 3) [m]: right, down and ahead of the eye."""
    level = eye.sees(points[:, :2])
    return np.column_stack((level[:, 1], eye.z - points[:, 2], level[:, 0]))


def _on_board(back: Array, axis: int, x: Array, y: Array, depth: Array, focal: float) -> tuple[Array, Array]:
    """Return the pixels' places on the board along one axis, and the length that one pixel covers (R, C) [m]."""
    place = (back[axis, 0] * x + (back[axis, 1] * y + back[axis, 2])) * depth
    by_x, by_y = back[axis, 0] - back[2, 0] * place, back[axis, 1] - back[2, 1] * place
    width = cv2.magnitude(by_x, by_y)
    width *= depth * np.float32(1 / focal)
    return place, width


def _within(place: Array, width: Array, half: float) -> Array:
    return np.clip((np.float32(half) - np.abs(place)) / width + np.float32(0.5), 0.0, 1.0)


def _ink(board: HeldBoard, places: tuple[Array, ...], widths: tuple[Array, ...]) -> Array:
    """Share of dark under every pixel (R, C): the squares around the inner corners, one more to every side.

    A square is dark where the waves along x and y agree, so two integrals along each axis give the exact mean.
    """
    agree, printed = np.ones_like(places[0]), np.ones_like(places[0])
    for place, width, count in zip(places, widths, (board.columns, board.rows), strict=True):
        middle, half = place * np.float32(1 / board.square), width * np.float32(0.5 / board.square)
        first, last = np.clip(middle - half, -1, count), np.clip(middle + half, -1, count)
        share = np.float32(0.5) / half
        agree *= (_ramp(last) - _ramp(first)) * share
        printed *= (last - first) * share
    agree += printed
    agree *= np.float32(0.5)
    return agree


def _ramp(place: Array) -> Array:
    """The integral of a wave that is +1 on even squares, -1 on odd ones: the distance to the next even edge."""
    half = place * np.float32(0.5)
    return 2 * np.abs(half - np.rint(half))


def _brightness(normal: Array) -> float:
    """A face's normal in the world (3,) → its light: as of walls, and more from the lamps above."""
    upright = math.hypot(normal[0], normal[1])
    sideways = float(shade(math.atan2(normal[1], normal[0])))
    return upright * sideways + (1 - upright) * 0.9 + 0.12 * float(normal[2])
