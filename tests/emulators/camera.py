"""A camera on the network: motion JPEG over HTTP, as IP cameras and mjpg-streamer send it."""

import contextlib

import cv2

from core.sensors import Image
from tests.emulators.wires import Port, TcpPort, Wire
from tests.emulators.world import World

BOUNDARY = b"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n"
HEAD = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=picture\r\n\r\n"


class CameraEmulator:
    """One viewer at a time gets every picture of the simulated camera."""

    def __init__(self, world: World) -> None:
        world.on_image.append(self._see)
        self._watched = False
        self._port: Port = TcpPort(self._serve)

    @property
    def url(self) -> str:
        return f"camera://http{self._port.url[1:]}/stream.mjpg"

    def start(self) -> None:
        self._port.start()

    def stop(self) -> None:
        """Be switched off."""
        self._watched = False
        self._port.stop()

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver was there."""
        return self._port.inject(data)

    def _serve(self, wire: Wire) -> None:
        asked = b""
        while b"\r\n\r\n" not in asked:
            asked += wire.read(1.0)
        wire.write(HEAD)
        self._watched = True
        try:
            while True:
                wire.read(1.0)
        finally:
            self._watched = False

    def _see(self, image: Image) -> None:
        wire = self._port.wire
        if not self._watched or wire is None:
            return
        jpeg = cv2.imencode(".jpg", image.pixels, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
        with contextlib.suppress(OSError):
            wire.write(BOUNDARY % len(jpeg) + jpeg + b"\r\n")
