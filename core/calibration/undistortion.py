"""Every pixel of a camera's picture."""

from __future__ import annotations

import numpy as np

from core.message import Array
from core.optics import CameraModel


def all_pixels(model: CameraModel) -> Array:
    """Normalised coordinates (H·W, 2) of every pixel, row by row."""
    pixels = np.stack(np.meshgrid(np.arange(model.width), np.arange(model.height)), axis=-1).reshape(-1, 2)
    return (pixels - (model.cx, model.cy)) / (model.fx, model.fy)
