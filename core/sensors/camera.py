"""The camera."""

import math
from collections.abc import Iterator

import numpy as np

from core.geometry import OPTICAL, Transform
from core.message import Array, message
from core.optics import TABLE_3, CameraModel
from core.sensors.checks import Fault, are_finite, fault, is_array

MAX_PIXELS = 100_000_000  # of a picture
FLAT_TILT_COSINE = 0.7  # cosine of the tilt from which on a frame no longer lies flat
MAX_PIXEL_ASPECT = 1.1  # between the focal lengths across and down: pixels are square
MAX_PRINCIPAL_SHARE = 0.15  # of a side, by which the principal point lies beside the picture's middle
MIN_VIEW_DEG, MAX_VIEW_DEG = 10, 125  # across, of a camera whose lens is no fisheye


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


def lens_faults(sensor: str, model: CameraModel) -> tuple[Fault, ...]:
    """Find what of a calibration is possible, and what hardly any lens and pixels have.

    `sensor` is the name of the camera or of its file.
    """
    return tuple(_lens_faults(sensor, model))


def _lens_faults(sensor: str, model: CameraModel) -> Iterator[Fault]:
    ratio = model.fx / model.fy
    if not 1 / MAX_PIXEL_ASPECT <= ratio <= MAX_PIXEL_ASPECT:
        fx, fy = f"{model.fx:g}", f"{model.fy:g}"
        yield fault("camera.focal_ratio", sensor, used=True, fx=fx, fy=fy, ratio=f"{ratio:.2g}")
    aside = max(abs(model.cx / model.width - 0.5), abs(model.cy / model.height - 0.5))
    if aside > MAX_PRINCIPAL_SHARE:
        at = {"cx": f"{model.cx:g}", "cy": f"{model.cy:g}", "size": f"{model.width}x{model.height}"}
        yield fault("camera.principal_point", sensor, used=True, **at)
    view = math.degrees(2 * math.atan(0.5 * model.width / model.fx))
    if not MIN_VIEW_DEG <= view <= MAX_VIEW_DEG:
        yield fault("camera.view", sensor, used=True, view=f"{view:.0f}", low=MIN_VIEW_DEG, high=MAX_VIEW_DEG)
