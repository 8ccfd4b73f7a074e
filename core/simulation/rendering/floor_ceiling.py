"""Floor and ceiling."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from core.message import Array


def paint_floor(width: float, height: float, scale: float, obstacles: Sequence[Array]) -> Array:
    """Tiles in the light of the lamps, dark where `obstacles` (polygons (K, 2) [m]) stand → (H, W, 3) uint8."""
    rows, columns = round(height * scale), round(width * scale)
    x = (np.arange(columns, dtype=np.float32) + 0.5) / scale
    y = (np.arange(rows, dtype=np.float32) + 0.5) / scale
    tile, joint = 0.5, 0.009
    tone = np.random.default_rng(7).normal(1.0, 0.025, (int(height / tile) + 2, int(width / tile) + 2))
    tone[::2, ::2] *= 0.93
    tone[1::2, 1::2] *= 0.93
    bright = tone.astype(np.float32)[(y / tile).astype(int)[:, None], (x / tile).astype(int)[None, :]]
    bright[(y % tile < joint), :] *= 0.72
    bright[:, (x % tile < joint)] *= 0.72
    lamps = (0.90 + 0.10 * np.cos(2 * np.pi * y / 2.4))[:, None] * (0.93 + 0.07 * np.cos(2 * np.pi * x / 2.4))[
        None, :
    ]
    small = np.full((rows // 4 + 1, columns // 4 + 1), 255, np.uint8)
    for polygon in obstacles:
        cv2.fillPoly(small, [np.round(polygon * scale / 4).astype(np.int32)], 0)
    away = cv2.distanceTransform(small, cv2.DIST_L2, 5) * 4 / scale
    shadow = cv2.resize(1 - 0.42 * np.exp(-away / 0.13), (columns, rows), interpolation=cv2.INTER_LINEAR)
    bright *= lamps
    bright *= shadow
    image = np.empty((rows, columns, 3), np.uint8)
    for channel, level in enumerate((150.0, 166.0, 178.0)):
        image[:, :, channel] = np.clip(bright * level, 0, 255)
    return image


def paint_ceiling(width: float, height: float, scale: float) -> Array:
    """Panels and lamps → (H, W, 3) uint8."""
    rows, columns = round(height * scale), round(width * scale)
    x = (np.arange(columns, dtype=np.float32) + 0.5)[None, :] / scale
    y = (np.arange(rows, dtype=np.float32) + 0.5)[:, None] / scale
    bright = np.full((rows, columns), 214.0, np.float32)
    bright[np.broadcast_to((x % 0.6 < 0.02) | (y % 0.6 < 0.02), bright.shape)] = 186.0
    bright[(np.abs(x % 2.4 - 1.2) < 0.6) & (np.abs(y % 2.4 - 1.2) < 0.16)] = 255.0
    return np.repeat(bright.astype(np.uint8)[:, :, None], 3, axis=2)
