"""`camera://0`, `camera://rtsp/host/path`, `camera:///path/film.mp4`: what OpenCV opens as a video."""

import os
import threading
import time
from typing import Any
from urllib.parse import parse_qsl

import cv2
import numpy as np

from core.errors import BadInput
from core.geometry import OPTICAL, Transform
from core.optics import TABLE_3, CameraModel
from core.robots.device import Device, Equipment
from core.robots.readings import Readings
from core.sensors import Camera, Image

EXAMPLE = "camera://0, camera://rtsp/192.168.0.7/stream, camera:///path/film.mp4"
KEYS = ("width", "height", "rate")
OPENING_TIMEOUT_S = 8.0  # for the first picture
MAX_SILENCE_S = 3.0  # without a picture after which the camera is lost
PROTOCOLS = {"http": "http,https,tls,tcp,crypto", "https": "http,https,tls,tcp,crypto", "rtsp": "rtsp,rtp,udp,tcp"}
"""Of FFmpeg, by the way to a camera on the network: what a stream refers to may be fetched by these alone."""
NETWORK = tuple(PROTOCOLS)
FFMPEG = "OPENCV_FFMPEG_CAPTURE_OPTIONS"
PICTURES_ONLY = (
    "format_whitelist;mpjpeg,mjpeg,jpeg_pipe,png_pipe,image2,mov,matroska,mpegts,h264,hevc,rtsp|max_redirects;0"
)
"""For a URL that is not trusted: no playlists, no redirections."""
FIELD_OF_VIEW_RAD = 1.05  # across the picture, until it is calibrated
GIVEN = os.environ.get(FFMPEG, "")


class VideoCamera(Device):
    """A camera or a film. Reading may wait for long, so a thread reads, and closing does not wait for it."""

    restrained = False  # of a process in which cameras send pictures from where they are asked, or nothing

    def __init__(self, arguments: str = "") -> None:
        """`arguments`: what follows `camera:`. Raises BadInput."""
        self._source, self._options = parse_address(arguments)
        self._newest: tuple[int, np.ndarray] | None = None
        self._condition = threading.Condition()
        self._over = threading.Event()

    def open(self) -> Equipment:
        """Wait for the first picture → a camera of its size. Raises OSError."""
        self._over, self._newest = threading.Event(), None
        threading.Thread(target=self._grab, args=(self._over,), name="camera-grabber", daemon=True).start()
        first = self._next(0, OPENING_TIMEOUT_S)
        if first is None:
            raise OSError(f"no picture came within {OPENING_TIMEOUT_S:g} s")
        height, width = first[1].shape[:2]
        camera = Camera(
            model=model_of(width, height),
            mounting=Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, 0.16])),
            rate=self._options.get("rate", 10.0),
            optics_known=False,
            mounting_known=False,
        )
        return Equipment(name="camera", cameras=(camera,))

    def run(self, readings: Readings) -> None:
        """Hand on the newest picture at most `rate` times a second."""
        number, due, period = 0, 0.0, 1 / self._options.get("rate", 10.0)
        while not self._over.is_set():
            newest = self._next(number, MAX_SILENCE_S)
            if newest is None:
                return
            number, pixels = newest
            now = time.monotonic()
            if now >= due:
                due = max(due + period, now)
                readings.image(Image(stamp=readings.now(), pixels=pixels))

    def close(self) -> None:
        """Let go; a read that hangs ends with its thread."""
        self._over.set()
        with self._condition:
            self._condition.notify_all()

    def _next(self, after: int, patience: float) -> tuple[int, np.ndarray] | None:
        """The newest picture with a number above `after`, waited for; None: none came, or it is over."""
        with self._condition:
            self._condition.wait_for(
                lambda: self._over.is_set() or (self._newest is not None and self._newest[0] > after), patience
            )
            found = self._newest
        return found if found is not None and found[0] > after and not self._over.is_set() else None

    def _grab(self, over: threading.Event) -> None:
        """Read pictures as they come; a film goes at its own pace, again and again."""
        os.environ[FFMPEG] = stream_options(self._source, restrained=self.restrained)
        capture: Any = cv2.VideoCapture(self._source)
        try:
            capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
            for key, name in (("width", cv2.CAP_PROP_FRAME_WIDTH), ("height", cv2.CAP_PROP_FRAME_HEIGHT)):
                if key in self._options:
                    capture.set(name, self._options[key])
            film = isinstance(self._source, str) and os.path.isfile(self._source)
            pause = 1 / max(capture.get(cv2.CAP_PROP_FPS) or 25.0, 1.0) if film else 0.0
            number = 0
            while not over.wait(pause):
                there, pixels = capture.read()
                if not there and film and number:
                    capture.set(cv2.CAP_PROP_POS_FRAMES, 0)
                    there, pixels = capture.read()
                if not there or pixels is None:
                    return
                number += 1
                with self._condition:
                    self._newest = (number, pixels)
                    self._condition.notify_all()
        finally:
            capture.release()


def stream_options(source: int | str, *, restrained: bool = False) -> str:
    """FFmpeg's options for what OpenCV opens; those of the environment where it has some."""
    if GIVEN and not restrained:
        return GIVEN
    kind = source.partition("://")[0] if isinstance(source, str) else ""
    usual = f"rtsp_transport;tcp|fflags;nobuffer|protocol_whitelist;{PROTOCOLS.get(kind, 'file')}"
    return f"{usual}|{PICTURES_ONLY}" if restrained else usual


def model_of(width: int, height: int) -> CameraModel:
    """A pinhole of 60° for a camera that is not calibrated; the chapter's own where the size is the same."""
    if (width, height) == (TABLE_3.width, TABLE_3.height):
        return TABLE_3
    focal = 0.5 * width / np.tan(0.5 * FIELD_OF_VIEW_RAD)
    return CameraModel(fx=focal, fy=focal, cx=width / 2, cy=height / 2, width=width, height=height)


def parse_address(arguments: str) -> tuple[int | str, dict[str, float]]:
    """`//0?width=640`, `//rtsp/host/path`, `///film.mp4` → what OpenCV opens, and options. Raises BadInput."""
    place, _, query = arguments.removeprefix("//").partition("?")
    if not place:
        raise BadInput(f"A camera needs a number, a network address or a file: {EXAMPLE}.")
    options: dict[str, float] = {}
    kind, _, rest = place.partition("/")
    for key, value in parse_qsl(query, keep_blank_values=True):
        if key not in KEYS and kind not in NETWORK:
            raise BadInput(f"A camera has no setting {key[:40]!r}; known are {', '.join(KEYS)}.")
        if key in KEYS:
            options[key] = _number(key, value)
    if place.isdigit():
        return int(place), options
    if kind in NETWORK and rest:
        own = "&".join(pair for pair in query.split("&") if pair.partition("=")[0] not in KEYS)
        return f"{kind}://{rest}{'?' if own else ''}{own}", options
    if not os.path.isfile(place):
        raise BadInput(f"There is no film {place[:100]}; a camera is {EXAMPLE}.")
    return place, options


def _number(key: str, value: str) -> float:
    low, high = (0.5, 60.0) if key == "rate" else (16.0, 8192.0)
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not low <= number <= high:
        raise BadInput(f"{key} of a camera lies between {low:g} and {high:g}, not {value[:20]!r}.")
    return number


def open_device(rest: str) -> VideoCamera:
    """`camera:<rest>` → the camera. Raises BadInput."""
    return VideoCamera(rest)
