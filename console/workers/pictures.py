"""Pictures in a worker: pixels of the robot's own camera, or files from strangers."""

import cv2
import numpy as np

from core.calibration.files.pictures import decode
from core.errors import BadInput
from core.message import Array


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


def in_colour(pixels: Array) -> Array:
    """The robot's picture (H, W) or (H, W, 3) uint8 → (H, W, 3); a grey one has three equal channels."""
    return pixels if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, axis=2)


def jpeg(picture: Array, longest: int | None = None, quality: int = 85) -> bytes:
    """A picture as a JPEG, made smaller where a side is longer than `longest` [pixel]."""
    scale = 1.0 if longest is None else min(1.0, longest / max(picture.shape[:2]))
    if scale < 1:
        picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
