"""The robot's pictures for the browsers: encoded once, whatever the number of viewers."""

from __future__ import annotations

import cv2

from console import wire
from console.latest import Hub
from core.sensors import Image

JPEG = [cv2.IMWRITE_JPEG_QUALITY, 80]

Picture = tuple[float, bytes]  # stamp [s], JPEG


class CameraFeed:
    """One slot of the hub."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._number = 0

    def encoded(self, image: Image | None) -> Picture | None:
        """From any thread: the picture as it goes out, when somebody looks."""
        if image is None or not self._hub.watched("camera"):
            return None
        return image.stamp, cv2.imencode(".jpg", image.pixels, JPEG)[1].tobytes()

    def show(self, picture: Picture) -> None:
        """On the event loop: this is the newest."""
        self._number += 1
        stamp, jpeg = picture
        self._hub.publish("camera", wire.CAMERA_HEADER.pack(1, self._number % 2**32, stamp) + jpeg)
