"""Pictures among ROS messages: raw ones → blue-green-red, and those of one camera of a recording, kept as JPEG."""

import math
import re
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from core.calibration.files.camera_files import check_lens
from core.calibration.files.pictures import MOST_PIXELS, decode
from core.errors import BadInput
from core.geometry import OPTICAL, Transform
from core.message import Array
from core.optics import CameraModel
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import RecordedPicture
from core.recording.robot_names import is_seen
from core.sensors import Camera
from core.sensors.camera import camera_mounting, lens_faults

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
FOCAL_WIDTHS = 0.9  # focal length of an uncalibrated camera, in widths of its picture: it sees 58°
JPEG_QUALITY = 88  # of the JPEG that raw pictures are kept as
MAX_HELD_BYTES = 200_000_000  # of pictures; later ones are left out
CAMERA_HEIGHT_M = 0.16  # of a camera of which nothing is known
MAX_STRETCH = 0.02  # by which pictures may be scaled differently across and down
RECTIFIED = re.compile(r"(?<![a-z])rect")

PlaceFrame = Callable[[str], Transform | None]
"""A frame's name → robot_from_frame; None: it is not known."""

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


class RosCamera:
    """The camera of a log whose pictures are used: the first one that sees what people see; and what describes it."""

    def __init__(self) -> None:
        self.topic = self._frame = ""
        self._infos: dict[str, Any] = {}  # by topic

    def note_info(self, topic: str, info: Any) -> None:
        """Take a CameraInfo, of whichever camera it is."""
        self._infos.setdefault(topic, info)

    def may_be(self, topic: str) -> bool:
        """Return whether pictures of a topic are of this camera, as far as that is known."""
        return topic == self.topic if self.topic else is_seen(topic)

    def pixels(self, topic: str, content: Any, kind: str) -> Array:
        """A picture's content → blue-green-red (H, W, 3) uint8. The first that can be read chooses the camera.

        Raises BadInput.
        """
        found = pixels_of(content, kind)
        if not self.topic:
            self.topic, self._frame = topic, content.header.frame_id.strip("/")
        return found

    def model(self, width: int, height: int) -> CameraModel | None:
        """The model for pictures of this size [pixel]; None where no CameraInfo that is known tells it."""
        fitting = (info for topic, info in self._infos.items() if describes(topic, info, self.topic, self._frame))
        rectified = is_rectified(self.topic)
        found = (camera_model(info, width, height, rectified=rectified) for info in fitting)
        return next((model for model in found if model is not None), None)

    def mounting(self, place: PlaceFrame) -> Transform | None:
        """robot_from_camera by the frames of the log; None: they do not tell it."""
        placed = place(self._frame)
        return None if placed is None else camera_mounting(placed, self._frame)


class RosPictures:
    """Keeps the pictures of one camera."""

    def __init__(self) -> None:
        self._camera = RosCamera()
        self._found: list[RecordedPicture] = []
        self._held = 0

    def take(self, topic: str, content: Any, kind: str, stamp: float) -> bool:
        """Take a message's content → whether it is kept. Raises BadRecord, BadInput."""
        if kind == CAMERA_INFO:
            self._camera.note_info(topic, content)
            return False
        if not self._camera.may_be(topic) or self._held > MAX_HELD_BYTES:
            return False
        if kind == COMPRESSED and self._camera.topic:
            encoded = bytes(content.data)
        else:
            pixels = self._camera.pixels(topic, content, kind)
            encoded = bytes(content.data) if kind == COMPRESSED else _jpeg(pixels)
        self._found.append(RecordedPicture(stamp=stamp, content=encoded))
        self._held += len(encoded)
        return True

    def finish(
        self, start: float, end: float, tally: ReadReport, place: PlaceFrame
    ) -> tuple[tuple[RecordedPicture, ...], Camera | None]:
        """The pictures from `start` to `end` [s] in order, and their camera; None where there are none."""
        kept = sorted((one for one in self._found if start <= one.stamp <= end), key=lambda one: one.stamp)
        if self._held > MAX_HELD_BYTES:
            tally.warn(f"The log holds more than {MAX_HELD_BYTES // 10**6} MB of pictures; later ones are left out.")
        for one in kept:
            try:
                height, width = one.pixels.shape[:2]
            except BadInput:
                continue
            tally.topics.append(f"{self._camera.topic}: camera")
            rate = min(max(len(kept) / max(end - start, 1e-3), 0.5), 60.0)
            return tuple(kept), Camera(
                model=self._model(width, height, tally),
                mounting=self._mounting(place, tally),
                rate=rate,
                optics_known=self._camera.model(width, height) is not None,
                mounting_known=self._camera.mounting(place) is not None,
            )
        return (), None

    def _model(self, width: int, height: int, tally: ReadReport) -> CameraModel:
        known = self._camera.model(width, height)
        if known is None:
            view = math.degrees(2 * math.atan(0.5 / FOCAL_WIDTHS))
            tally.fault("camera.guessed", self._camera.topic, used=True, view=f"{view:.0f}")
        for doubt in () if known is None else lens_faults(self._camera.topic, known):
            tally.note(doubt)
        return known or guessed_model(width, height)

    def _mounting(self, place: PlaceFrame, tally: ReadReport) -> Transform:
        known = self._camera.mounting(place)
        if known is None:
            tally.fault("camera.unplaced", self._camera.topic, used=True, height=f"{CAMERA_HEIGHT_M:g}")
        return known or Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, CAMERA_HEIGHT_M]))


def describes(info_topic: str, info: Any, topic: str, frame: str) -> bool:
    """Return whether a CameraInfo is of the camera of a topic's pictures: it lies beside them, or has their frame.

    Where a frame has no name, it may be.
    """
    named = info.header.frame_id.strip("/")
    beside = info_topic.rpartition("/")[0] == topic.removesuffix("/compressed").rpartition("/")[0]
    return beside or named == frame or not (named and frame)


def is_rectified(topic: str) -> bool:
    """Return whether the pictures of a topic are rectified, by its name: image_rect, image_rect_color."""
    return RECTIFIED.search(topic) is not None


def guessed_model(width: int, height: int) -> CameraModel:
    """The model of a camera of which only the size of its pictures [pixel] is known."""
    focal = FOCAL_WIDTHS * width
    return CameraModel(width=width, height=height, fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2)


def pixels_of(content: Any, kind: str) -> Array:
    """A message with a picture → blue-green-red (H, W, 3) uint8. Raises BadInput."""
    return decode(bytes(content.data), cv2.IMREAD_COLOR, live=True)[0] if kind == COMPRESSED else raw_pixels(content)


def _jpeg(pixels: Array) -> bytes:
    done, jpeg = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:
        raise BadRecord("its picture cannot be kept")
    return jpeg.tobytes()


def raw_pixels(content: Any) -> Array:
    """A sensor_msgs/Image → blue-green-red (H, W, 3) uint8. Raises BadInput."""
    wide = content.encoding in WIDE
    if not wide and content.encoding not in COLOURS:
        raise BadInput(f"pictures of encoding {content.encoding[:30]!r} are not read")
    channels, conversion = (WIDE if wide else COLOURS)[content.encoding]
    height, width, step = int(content.height), int(content.width), int(content.step)
    row = width * channels * (2 if wide else 1)  # [bytes]
    if not (0 < width * height <= MOST_PIXELS and row <= step and len(content.data) >= step * height):
        raise BadInput("the picture's size does not fit its data")
    rows = np.frombuffer(bytes(content.data[: step * height]), np.uint8).reshape(height, step)[:, :row]
    pixels = np.ascontiguousarray(rows)
    if wide:
        numbers = pixels.view(">u2" if content.is_bigendian else "<u2")
        pixels = np.rint(numbers / WIDE_TO_BYTE).astype(np.uint8)
    pixels = pixels.reshape(height, width, channels)
    return pixels if conversion is None else cv2.cvtColor(pixels, conversion)


def camera_model(info: Any, width: int, height: int, *, rectified: bool = False) -> CameraModel | None:
    """A CameraInfo → the model for pictures of this size [pixel], or for rectified ones, which have no distortion.

    None where the camera is not calibrated, no lens has these numbers, its model of distortion is another one, or its
    pictures have another shape: they are of another camera, or cut.
    """
    matrix, bend, projection = (_numbers(info, name) for name in "kdp")
    known = rectified or info.distortion_model in ("plumb_bob", "rational_polynomial", "")
    if rectified:  # P, a row of which has four numbers
        matrix, bend = projection.reshape(3, 4)[:, :3].ravel(), np.zeros(5)
    if not known or not np.isfinite(matrix).all() or not np.isfinite(bend).all() or bend[5:].any():
        return None
    left, top, seen_width, seen_height = _region(info)
    if min(matrix[0], matrix[4], seen_width, seen_height) <= 0:
        return None
    across, down = width / seen_width, height / seen_height
    if abs(across / down - 1.0) > MAX_STRETCH:
        return None
    k1, k2, p1, p2, k3 = (float(number) for number in np.pad(bend[:5], (0, max(0, 5 - len(bend)))))
    model = CameraModel(
        width=width,
        height=height,
        fx=float(matrix[0]) * across,
        fy=float(matrix[4]) * down,
        cx=(float(matrix[2]) - left + 0.5) * across - 0.5,
        cy=(float(matrix[5]) - top + 0.5) * down - 0.5,
        k1=k1,
        k2=k2,
        p1=p1,
        p2=p2,
        k3=k3,
    )
    try:
        check_lens(model)
    except BadInput:
        return None
    return model


def _numbers(info: Any, name: str) -> Array:
    """A matrix of a CameraInfo; ROS 1 has capitals."""
    found = getattr(info, name, None)
    return np.asarray(getattr(info, name.upper()) if found is None else found, float)


def _region(info: Any) -> tuple[float, float, float, float]:
    """The part of the sensor that the pictures show: left, top, width, height [pixel], before binning."""
    roi = info.roi
    if roi.width <= 0 or roi.height <= 0:
        return 0.0, 0.0, info.width, info.height
    return roi.x_offset, roi.y_offset, roi.width, roi.height
