"""Furniture: the faces of what stands in the room."""

from collections.abc import Callable

import numpy as np

from core.simulation.rendering.mipmap import BOOKS, TextureCanvas, darker, shade


def _cabinet(sheet: TextureCanvas) -> None:
    body = (204, 212, 214)
    sheet.pixels[:] = body
    count = max(1, round(sheet.width / 0.5))
    for door in range(count + 1):
        u = door * sheet.width / count
        sheet.fill(u - 0.01, 0.08, u + 0.01, sheet.height - 0.03, (112, 118, 120))
        sheet.fill(u + 0.05, sheet.height * 0.5, u + 0.07, sheet.height * 0.5 + 0.16, (70, 70, 72))
    sheet.fill(0, sheet.height - 0.03, sheet.width, sheet.height, (96, 130, 168))
    sheet.fill(0, 0, sheet.width, 0.08, (64, 62, 60))


def _shelf(sheet: TextureCanvas) -> None:
    frame = (120, 156, 188)
    sheet.pixels[:] = (62, 70, 78)
    level = 0.08
    while level < sheet.height - 0.2:
        u = 0.05
        while u < sheet.width - 0.08:
            thick, tall = float(sheet.rng.uniform(0.025, 0.06)), float(sheet.rng.uniform(0.18, 0.28))
            book = BOOKS[int(sheet.rng.integers(len(BOOKS)))]
            if sheet.rng.random() < 0.88:
                sheet.fill(u, level, min(u + thick, sheet.width - 0.04), level + tall, book)
                sheet.fill(
                    u, level + tall * 0.7, min(u + thick, sheet.width - 0.04), level + tall * 0.78, (210, 220, 224)
                )
            u += thick + 0.004
        level += 0.34
        sheet.fill(0, level - 0.03, sheet.width, level, frame)
    sheet.fill(0, sheet.height - 0.04, sheet.width, sheet.height, frame)
    sheet.fill(0, 0, sheet.width, 0.08, darker(frame, 0.7))
    sheet.fill(0, 0, 0.035, sheet.height, frame)
    sheet.fill(sheet.width - 0.035, 0, sheet.width, sheet.height, frame)


def _cardboard(sheet: TextureCanvas) -> None:
    card = (112, 158, 196)
    sheet.pixels[:] = card
    sheet.grain(0.03)
    middle = sheet.width / 2
    sheet.fill(middle - 0.03, 0, middle + 0.03, sheet.height, (150, 190, 216))
    sheet.fill(sheet.width * 0.62, sheet.height * 0.2, sheet.width * 0.9, sheet.height * 0.45, (236, 240, 240))
    sheet.fill(sheet.width * 0.66, sheet.height * 0.3, sheet.width * 0.86, sheet.height * 0.34, (60, 60, 60))
    for u in (0.0, sheet.width - 0.012):
        sheet.fill(u, 0, u + 0.012, sheet.height, darker(card, 0.8))


def _concrete(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (178, 182, 182)
    sheet.grain(0.02)
    sheet.fill(0, 0, sheet.width, 0.9, (140, 152, 158))
    sheet.fill(0, 0.9, sheet.width, 0.93, (40, 150, 220))


def _steel(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (150, 146, 142)


def _bin(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (120, 76, 44)
    for z in (0.04, sheet.height - 0.05):
        sheet.fill(0, z, sheet.width, z + 0.03, (168, 120, 76))


def _wood(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (118, 158, 194)


def _seat(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (58, 54, 150)


FURNITURE: dict[str, Callable[[TextureCanvas], None]] = {
    "cabinet": _cabinet,
    "shelf": _shelf,
    "box": _cardboard,
    "column": _concrete,
    "pillar": _concrete,
    "steel": _steel,
    "bin": _bin,
    "wood": _wood,
    "seat": _seat,
}


def paint_round(sheet: TextureCanvas) -> None:
    """Light a texture that goes around a post, u from the side that looks to +x."""
    around = sheet.u / sheet.width * 2 * np.pi
    sheet.times(np.asarray(shade(around), np.float32)[None, :])
