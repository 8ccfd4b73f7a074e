"""The camera."""

import numpy as np

from core.geometry import OPTICAL, Transform
from core.message import Array, message
from core.optics import TABLE_3, CameraModel
from core.sensors.checks import are_finite, is_array

MAX_PIXELS = 100_000_000  # of a picture
FLAT_TILT_COSINE = 0.7  # cosine of the tilt from which on a frame no longer lies flat


@message
class Camera:
    """A camera and its mounting."""

    name: str = "camera"
    model: CameraModel = TABLE_3
    mounting: Transform = Transform(rotation=OPTICAL, translation=np.array([0.04, 0.0, 0.16]))  # robot_from_camera
    rate: float | None = 10.0  # [Hz]; None: not known
    optics_known: bool = True  # False: `model` is assumed; it serves to look around, and tells no point of the floor
    mounting_known: bool = True  # False: so is `mounting`

    @property
    def is_known(self) -> bool:
        """Return whether a pixel tells a point of the floor."""
        return self.optics_known and self.mounting_known


def camera_mounting(at: Transform, frame: str = "") -> Transform:
    """robot_from_frame → robot_from_camera. The frame is the optical one (z looks ahead), by its name or as it is
    turned, or that of the camera's body.
    """
    if "optical" in frame or at.rotation[2, 2] < FLAT_TILT_COSINE:
        return at
    return at @ Transform(rotation=OPTICAL, translation=np.zeros(3))


@message
class Image:
    """One picture."""

    stamp: float  # [s]
    camera: str = ""  # name of the camera that took it; "": of the only one
    pixels: Array  # (H, W, 3) uint8, blue-green-red
    packed: bytes = b""  # JPEG or PNG that `pixels` are the content of, to the last bit; b"": none was made

    @property
    def malformation(self) -> str:
        """Describe what is wrong with the form of this picture; "" where nothing is."""
        if not is_array(self.pixels, 3, "u") or self.pixels.itemsize != 1:
            return "its pixels are no rows of bytes in three colours"
        if self.pixels.shape[2] != 3 or not 0 < self.pixels.size <= 3 * MAX_PIXELS:
            return f"its shape is {'x'.join(map(str, self.pixels.shape))}"
        return "" if are_finite(self.stamp) else "its time cannot be"
