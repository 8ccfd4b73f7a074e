"""Pictures among ROS messages: raw ones → blue-green-red, and those of a recording's first camera, kept as JPEG."""

from typing import Any

import cv2
import numpy as np

from core.calibration.files import pictures
from core.errors import BadInput
from core.geometry import OPTICAL, Transform
from core.message import Array
from core.optics import CameraModel
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import RecordedPicture
from core.sensors import Camera

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
FOCAL_WIDTHS = 0.9  # focal length of an uncalibrated camera, in widths of its picture: it sees 58°
JPEG_QUALITY = 88  # of the JPEG that raw pictures are kept as
MOST_HELD = 200_000_000  # [bytes] of pictures; later ones are left out
CAMERA_HEIGHT_M = 0.16  # of a camera of which nothing is known

COLOURS: dict[str, tuple[int, int | None]] = {
    "bgr8": (3, None),
    "8UC3": (3, None),
    "rgb8": (3, cv2.COLOR_RGB2BGR),
    "bgra8": (4, cv2.COLOR_BGRA2BGR),
    "8UC4": (4, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, cv2.COLOR_RGBA2BGR),
    "mono8": (1, cv2.COLOR_GRAY2BGR),
    "8UC1": (1, cv2.COLOR_GRAY2BGR),
    "yuv422": (2, cv2.COLOR_YUV2BGR_UYVY),
    "uyvy": (2, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2BGR_YUY2),
    "yuyv": (2, cv2.COLOR_YUV2BGR_YUY2),
    "bayer_rggb8": (1, cv2.COLOR_BayerRGGB2BGR),
    "bayer_bggr8": (1, cv2.COLOR_BayerBGGR2BGR),
    "bayer_gbrg8": (1, cv2.COLOR_BayerGBRG2BGR),
    "bayer_grbg8": (1, cv2.COLOR_BayerGRBG2BGR),
}
"""A raw picture's encoding → number of its channels, and what makes blue-green-red of it."""
WIDE = {
    f"{name.removesuffix('8')}16": COLOURS[name]
    for name in COLOURS
    if name.startswith(("bgr", "rgb", "mono", "bayer"))
}
"""The same with 16 bits a channel, full scale 65535."""
WIDE_TO_BYTE = 257  # 65535 / 255


class RosPictures:
    """Takes the pictures of the first camera that sends any."""

    def __init__(self) -> None:
        self._topic = ""
        self._found: list[RecordedPicture] = []
        self._info: Any = None
        self._held = 0

    def take(self, topic: str, content: Any, kind: str, stamp: float) -> bool:
        """Take a message's content → whether it is kept. Raises BadRecord, BadInput."""
        if kind == CAMERA_INFO:
            self._info = self._info or content
            return False
        self._topic = self._topic or topic
        if topic != self._topic or self._held > MOST_HELD:
            return False
        if kind == COMPRESSED:
            encoded = bytes(content.data)
        else:
            done, jpeg = cv2.imencode(".jpg", raw_pixels(content), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
            if not done:
                raise BadRecord("its picture cannot be kept")
            encoded = jpeg.tobytes()
        self._found.append(RecordedPicture(stamp=stamp, content=encoded))
        self._held += len(encoded)
        return True

    def finish(
        self, start: float, end: float, tally: ReadReport
    ) -> tuple[tuple[RecordedPicture, ...], Camera | None]:
        """The pictures from `start` to `end` [s] in order, and their camera; None where there are none."""
        kept = sorted((one for one in self._found if start <= one.stamp <= end), key=lambda one: one.stamp)
        if self._held > MOST_HELD:
            tally.warn(f"The log holds more than {MOST_HELD // 10**6} MB of pictures; later ones are left out.")
        for one in kept:
            try:
                height, width = one.pixels.shape[:2]
            except BadInput:
                continue
            tally.topics.append(f"{self._topic}: camera")
            return tuple(kept), self._camera(width, height, len(kept) / max(end - start, 1e-3))
        return (), None

    def _camera(self, width: int, height: int, rate: float) -> Camera:
        known = None if self._info is None else camera_model(self._info, width, height)
        focal = FOCAL_WIDTHS * width
        guessed = CameraModel(width=width, height=height, fx=focal, fy=focal, cx=width / 2, cy=height / 2)
        mounting = Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, CAMERA_HEIGHT_M]))
        return Camera(model=known or guessed, mounting=mounting, rate=min(max(rate, 0.5), 60.0))


def raw_pixels(content: Any) -> Array:
    """A sensor_msgs/Image → blue-green-red (H, W, 3) uint8. Raises BadInput."""
    wide = content.encoding in WIDE
    if not wide and content.encoding not in COLOURS:
        raise BadInput(f"pictures of encoding {content.encoding[:30]!r} are not read")
    channels, conversion = (WIDE if wide else COLOURS)[content.encoding]
    height, width, step = int(content.height), int(content.width), int(content.step)
    row = width * channels * (2 if wide else 1)  # [bytes]
    if not (0 < width * height <= pictures.MOST_PIXELS and row <= step and len(content.data) >= step * height):
        raise BadInput("the picture's size does not fit its data")
    rows = np.frombuffer(bytes(content.data[: step * height]), np.uint8).reshape(height, step)[:, :row]
    pixels = np.ascontiguousarray(rows)
    if wide:
        numbers = pixels.view(">u2" if content.is_bigendian else "<u2")
        pixels = np.rint(numbers / WIDE_TO_BYTE).astype(np.uint8)
    pixels = pixels.reshape(height, width, channels)
    return pixels if conversion is None else cv2.cvtColor(pixels, conversion)


def camera_model(info: Any, width: int, height: int) -> CameraModel | None:
    """A CameraInfo → the model for pictures of this size [pixel].

    None where the camera is not calibrated, or its model of distortion is another one.
    """
    matrix, bend = getattr(info, "k", None), getattr(info, "d", None)
    if matrix is None:  # ROS 1 has capitals
        matrix, bend = info.K, info.D
    matrix, bend = np.asarray(matrix, float), np.asarray(bend, float)
    known = info.distortion_model in ("plumb_bob", "rational_polynomial", "")
    if not known or not np.isfinite(matrix).all() or not np.isfinite(bend).all() or bend[5:].any():
        return None
    if min(matrix[0], matrix[4], info.width, info.height) <= 0:
        return None
    across, down = width / info.width, height / info.height
    k1, k2, p1, p2, k3 = (float(number) for number in np.pad(bend[:5], (0, max(0, 5 - len(bend)))))
    return CameraModel(
        width=width,
        height=height,
        fx=float(matrix[0]) * across,
        fy=float(matrix[4]) * down,
        cx=(float(matrix[2]) + 0.5) * across - 0.5,
        cy=(float(matrix[5]) + 0.5) * down - 0.5,
        k1=k1,
        k2=k2,
        p1=p1,
        p2=p2,
        k3=k3,
    )
