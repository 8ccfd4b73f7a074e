"""The camera."""

from __future__ import annotations

import numpy as np

from core.geometry import OPTICAL, Transform
from core.message import Array, message
from core.optics import TABLE_3, CameraModel


@message
class Camera:
    """A camera and its mounting."""

    name: str = "camera"
    model: CameraModel = TABLE_3
    mounting: Transform = Transform(rotation=OPTICAL, translation=np.array([0.04, 0.0, 0.16]))  # robot_from_camera
    rate: float = 10.0  # [Hz]


@message
class Image:
    """One picture."""

    stamp: float  # [s]
    camera: str = ""  # name of the camera that took it; "": of the only one
    pixels: Array  # (H, W, 3) uint8, blue-green-red
