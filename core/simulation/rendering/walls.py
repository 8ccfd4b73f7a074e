"""Walls: their paint, their bricks, and what hangs on them."""

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

from core.simulation.rendering.mipmap import BOOKS, Colour, TextureCanvas, darker


class Paint(NamedTuple):
    """Two colours of a wall, the rail between them, and whether it is of brick."""

    lower: Colour
    upper: Colour
    rail: Colour
    split: float  # [m] height of the rail
    brick: bool = False


PAINTS: dict[str, Paint] = {
    "mint": Paint((166, 184, 118), (218, 230, 230), (232, 236, 238), 0.95),
    "sand": Paint((122, 168, 206), (206, 226, 236), (228, 236, 240), 0.95),
    "slate": Paint((142, 106, 78), (190, 172, 156), (216, 208, 200), 1.15),
    "brick": Paint((90, 110, 170), (130, 150, 194), (206, 214, 222), 0.0, brick=True),
}


def paint_wall(sheet: TextureCanvas, paint: Paint) -> None:
    """Cover a whole wall."""
    sheet.pixels[:] = paint.upper
    if paint.brick:
        _bricks(sheet, paint)
    else:
        sheet.fill(0, 0, sheet.width, paint.split, paint.lower)
        sheet.fill(0, paint.split - 0.05, sheet.width, paint.split, paint.rail)
        sheet.fill(0, paint.split - 0.062, sheet.width, paint.split - 0.05, darker(paint.lower, 0.75))
    sheet.grain(0.012)
    sheet.fill(0, 0, sheet.width, 0.085, (78, 74, 70))
    sheet.fill(0, 0.075, sheet.width, 0.085, (120, 116, 112))


def _bricks(sheet: TextureCanvas, paint: Paint) -> None:
    length, course, joint = 0.25, 0.085, 0.012
    rows = (sheet.z / course).astype(int)
    shifted = sheet.u[None, :] / length + 0.5 * (rows % 2)[:, None]
    columns = shifted.astype(int)
    tone = sheet.rng.normal(1.0, 0.07, (rows.max() + 1, columns.max() + 1)).astype(np.float32)
    sheet.pixels[:] = np.asarray(paint.lower, np.float32) * tone[rows[:, None], columns][:, :, None]
    mortar = ((sheet.z % course) < joint)[:, None] | ((shifted % 1.0) * length < joint)
    sheet.pixels[mortar] = paint.upper


def corners(sheet: TextureCanvas, left: int, right: int) -> None:
    """Darken towards a concave corner (-1), brighten the worn edge of a convex one (+1)."""
    for kind, distance in ((left, sheet.u), (right, sheet.width - sheet.u)):
        if kind < 0:
            sheet.times((1 - 0.16 * np.exp(-distance / 0.16))[None, :])
        elif kind > 0:
            sheet.times((1 + 0.12 * (distance < 0.018))[None, :])


def _door(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    wood = (96, 132, 172)
    sheet.fill(u, z, u + w, z + h, (206, 212, 216))
    a, b = u + 0.06, u + w - 0.06
    sheet.fill(a, z, b, z + h - 0.06, wood)
    sheet.fill(a, z, b, z + 0.22, (168, 166, 162))
    for low, high in ((0.34, 0.92), (1.08, h - 0.22)):
        sheet.fill(a + 0.1, z + low, b - 0.1, z + high, darker(wood, 0.74))
        sheet.fill(a + 0.125, z + low + 0.025, b - 0.1, z + high, darker(wood, 0.94))
    sheet.fill(b - 0.13, z + 0.98, b - 0.03, z + 1.02, (60, 60, 60))
    sheet.fill(b - 0.015, z, b, z + h - 0.06, darker(wood, 0.45))
    sheet.fill(a, z, a + 0.015, z + h - 0.06, darker(wood, 0.45))


def _poster(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    back = BOOKS[int(sheet.rng.integers(4))]
    sheet.fill(u, z, u + w, z + h, (244, 246, 246))
    sheet.fill(u + 0.03, z + 0.03, u + w - 0.03, z + h - 0.03, back)
    sheet.fill(u + 0.07, z + h - 0.17, u + w - 0.07, z + h - 0.09, (240, 244, 246))
    centre = (round((u + 0.5 * w) * sheet.scale), round((sheet.height - z - 0.45 * h) * sheet.scale))
    radius = round(0.28 * min(w, h) * sheet.scale)
    cv2.circle(sheet.pixels, centre, radius, (120, 210, 245), -1, cv2.LINE_AA)
    cv2.circle(sheet.pixels, centre, radius * 2 // 3, darker(back, 0.8), -1, cv2.LINE_AA)
    for line in range(3):
        low = z + 0.06 + 0.045 * line
        sheet.fill(u + 0.08, low, u + w * (0.9 - 0.12 * line), low + 0.018, (236, 236, 236))


def _board(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    sheet.fill(u, z, u + w, z + h, (150, 150, 150))
    sheet.fill(u + 0.03, z + 0.03, u + w - 0.03, z + h - 0.03, (246, 248, 248))
    for row in range(4):
        high = z + h - 0.16 - 0.16 * row
        length = float(sheet.rng.uniform(0.3, 0.8)) * w
        for piece in np.arange(0.1, length, 0.09):
            ink = ((60, 60, 70), (170, 80, 40), (50, 50, 190))[int(sheet.rng.integers(3))]
            sheet.fill(u + piece, high, u + piece + 0.06, high + 0.022, ink)
    sheet.fill(u + 0.2, z - 0.03, u + w - 0.2, z, (110, 110, 112))


def _window(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    sheet.fill(u, z, u + w, z + h, (236, 240, 240))
    a, b, low, high = u + 0.06, u + w - 0.06, z + 0.06, z + h - 0.06
    for share in np.linspace(0, 1, 24):
        sky = (255 - 10 * share, 236 - 40 * share, 220 - 80 * share)
        sheet.fill(a, low + (high - low) * share * 0.98, b, high, sky)
    sheet.fill(a, low, b, low + 0.18, (120, 160, 130))
    sheet.fill(u + w / 2 - 0.025, z, u + w / 2 + 0.025, z + h, (236, 240, 240))
    sheet.fill(u - 0.05, z - 0.05, u + w + 0.05, z, (220, 226, 228))


def _sign(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    sheet.fill(u, z, u + w, z + h, (130, 84, 40))
    sheet.fill(u + 0.02, z + h * 0.55, u + w - 0.02, z + h * 0.8, (245, 245, 245))


DRESSINGS: dict[str, Callable[[TextureCanvas, float, float, float, float], None]] = {
    "door": _door,
    "poster": _poster,
    "board": _board,
    "window": _window,
    "sign": _sign,
}
