"""Pictures on their way to a worker: pixels of the robot's own camera, or files from strangers."""

from __future__ import annotations

import msgspec
import numpy as np

from core.calibration.files.pictures import decode
from core.errors import BadInput
from core.message import Array


class PixelPicture(msgspec.Struct, frozen=True, tag=True):
    """A picture (H, W) or (H, W, 3) uint8."""

    pixels: bytes
    width: int
    height: int

    @classmethod
    def of(cls, pixels: Array) -> PixelPicture:
        """Pixels as they cross."""
        return cls(pixels.tobytes(), pixels.shape[1], pixels.shape[0])

    @property
    def grey(self) -> Array:
        """The grey picture (H, W) uint8."""
        return np.frombuffer(self.pixels, np.uint8).reshape(self.height, self.width)

    @property
    def colour(self) -> Array:
        """The picture (H, W, 3) uint8; a grey one has three equal channels."""
        pixels = np.frombuffer(self.pixels, np.uint8).reshape(self.height, self.width, -1)
        return np.ascontiguousarray(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))


class UploadedPicture(msgspec.Struct, frozen=True, tag=True):
    """A file that someone sent."""

    content: bytes


def decode_upload(content: bytes, how: int) -> tuple[Array, str]:
    """A JPEG or PNG from a stranger → its pixels as OpenCV's flag `how` asks for, and a remark or ''.

    Raises BadInput.
    """
    if not content.startswith((b"\xff\xd8\xff", b"\x89PNG")):
        raise BadInput("This is no JPEG or PNG picture.")
    try:
        return decode(content, how)
    except BadInput as wrong:
        words = str(wrong)
        raise BadInput(f"{words[:1].upper()}{words[1:]}.") from None
