"""Readings as a recording can hold them to the last bit, so that what was computed of them can be computed again.

A scan's ranges are float32 and sound has 16 bits, as robots send them; a picture is the content of its JPEG. Drivers
hand on frames in this form: what is seen, shown and recorded is the same.
"""

from dataclasses import replace

import cv2
import numpy as np

from core.message import Array
from core.sensors import Image, Scan, SensorFrame, Sound
from core.sensors.microphones import usable

JPEG_QUALITY = 90  # of 100
PNG_MAGIC = b"\x89PNG"
PCM_SCALE = 32768  # of a sample at full scale: sound cards and robots send whole numbers of this


def recordable(frame: SensorFrame) -> SensorFrame:
    """A frame → the same, as a recording of it is read back."""
    scan, image, sound = frame.scan, frame.image, frame.sound
    if scan is None and image is None and sound is None:
        return frame
    return replace(
        frame,
        scan=None if scan is None else _scan(scan),
        image=None if image is None else _picture(image),
        sound=None if sound is None else _sound(sound),
    )


def pack_picture(pixels: Array) -> bytes:
    """Blue-green-red pixels (H, W, 3) uint8 → JPEG."""
    return cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def unpack_picture(packed: bytes) -> Array | None:
    """JPEG or PNG → blue-green-red pixels (H, W, 3) uint8; None where it is none."""
    try:
        return cv2.imdecode(np.frombuffer(packed, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None


def pcm_of(samples: Array) -> Array:
    """Samples (N, C), full scale ±1 → the same as whole numbers of 16 bits, little endian."""
    return np.clip(np.rint(samples * PCM_SCALE), -PCM_SCALE, PCM_SCALE - 1).astype("<i2")


def samples_of(pcm: Array) -> Array:
    """Whole numbers of 16 bits → float32, full scale ±1."""
    return pcm.astype(np.float32) / np.float32(PCM_SCALE)


def _scan(scan: Scan) -> Scan:
    with np.errstate(over="ignore"):
        return replace(scan, ranges=scan.ranges.astype(np.float32).astype(np.float64))


def _picture(image: Image) -> Image:
    if image.packed:
        return image
    packed = pack_picture(image.pixels)
    pixels = unpack_picture(packed)
    return image if pixels is None else replace(image, pixels=pixels, packed=packed)


def _sound(sound: Sound) -> Sound:
    if not usable(sound.samples):
        return sound  # the pilot says so
    return replace(sound, samples=samples_of(pcm_of(sound.samples)))
