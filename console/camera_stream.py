"""The robot's pictures for the browsers: encoded once for all viewers."""

import cv2
import numpy as np

from console.broadcast import Broadcaster
from console.messages import state as messages
from core.message import Array
from core.sensors import Image

JPEG = [cv2.IMWRITE_JPEG_QUALITY, 80]
REST_GAP_S = 0.5  # between two pictures of a robot that stands, where they look alike
COARSE_SIZE = (40, 32)  # in which two pictures are compared, so that the camera's noise is no difference
MIN_CHANGE_GREY = 4.0  # of 255: a coarse element that differs so much shows something else

Picture = tuple[float, bytes]  # stamp [s], JPEG


class CameraStream:
    def __init__(self, broadcaster: Broadcaster) -> None:
        self._broadcaster = broadcaster
        self._number = 0
        self._sent = (-np.inf, np.zeros((0, 0)))  # stamp [s] and coarse picture of the one encoded last
        self._viewers = 0  # that have it
        self._newest: Image | None = None

    def encoded(self, image: Image | None, at_rest: bool = False) -> Picture | None:
        """Send the picture to its viewers, if there are any; from any thread.

        `at_rest`: the robot stands, so a picture that looks like the last one is sent now and then. Who comes while
        no picture does, as where a recording waits, gets the newest one.
        """
        viewers = len(self._broadcaster.viewers)
        self._newest, self._viewers = image or self._newest, min(self._viewers, viewers)
        image = self._newest if viewers > self._viewers else image
        if image is None or not self._broadcaster.watched("camera"):
            return None
        coarse = cv2.resize(image.pixels, COARSE_SIZE, interpolation=cv2.INTER_AREA).astype(float)
        if at_rest and viewers == self._viewers and self._is_like_sent(image.stamp, coarse):
            return None
        self._sent, self._viewers = (image.stamp, coarse), viewers
        return image.stamp, cv2.imencode(".jpg", image.pixels, JPEG)[1].tobytes()

    def _is_like_sent(self, stamp: float, coarse: Array) -> bool:
        sent, before = self._sent
        recent = 0 <= stamp - sent < REST_GAP_S and before.shape == coarse.shape
        return recent and float(np.abs(coarse - before).max()) < MIN_CHANGE_GREY

    def show(self, picture: Picture) -> None:
        """On the event loop: this is the newest."""
        self._number += 1
        stamp, jpeg = picture
        self._broadcaster.publish("camera", messages.CAMERA_HEADER.pack(1, self._number % 2**32, stamp) + jpeg)
