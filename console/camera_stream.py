"""The robot's pictures for the browsers: encoded once for all viewers."""

from __future__ import annotations

import cv2

from console import messages
from console.broadcast import Broadcaster
from core.sensors import Image

JPEG = [cv2.IMWRITE_JPEG_QUALITY, 80]

Picture = tuple[float, bytes]  # stamp [s], JPEG


class CameraStream:
    """One slot of the broadcaster."""

    def __init__(self, broadcaster: Broadcaster) -> None:
        self._broadcaster = broadcaster
        self._number = 0

    def encoded(self, image: Image | None) -> Picture | None:
        """Send the picture to its viewers, if there are any; from any thread."""
        if image is None or not self._broadcaster.watched("camera"):
            return None
        return image.stamp, cv2.imencode(".jpg", image.pixels, JPEG)[1].tobytes()

    def show(self, picture: Picture) -> None:
        """On the event loop: this is the newest."""
        self._number += 1
        stamp, jpeg = picture
        self._broadcaster.publish("camera", messages.CAMERA_HEADER.pack(1, self._number % 2**32, stamp) + jpeg)
