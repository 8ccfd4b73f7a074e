"""A recording's pictures and scans, one after the other as they were recorded: MCAP, ROS 1 and ROS 2 bags."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from core.calibration.files.pictures import MOST_PIXELS, decode_grey
from core.errors import BadInput
from core.message import Array, message
from core.recording import ROS_FORMS, ros2_bag
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings
from core.recording.ros import LASER_SCAN, Envelope, decode, ros2_name, stamp_of
from core.recording.ros_pictures import COMPRESSED, IMAGE
from core.recording.scans import make_scan
from core.sensors import Scan

CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4}
TO_GREY = {
    "rgb8": cv2.COLOR_RGB2GRAY,
    "bgr8": cv2.COLOR_BGR2GRAY,
    "8UC3": cv2.COLOR_BGR2GRAY,
    "rgba8": cv2.COLOR_RGBA2GRAY,
    "bgra8": cv2.COLOR_BGRA2GRAY,
}


@message
class RecordedImage:
    """One recorded picture."""

    stamp: float  # [s], the camera's
    grey: Array  # (H, W) uint8


def is_recording(path: Path) -> bool:
    """Return whether this file or folder is read as a recording with pictures and scans."""
    if path.is_dir():
        return any(each.suffix in (".db3", ".mcap") for each in path.iterdir())
    return path.suffix.lower() in ROS_FORMS


def sights(path: Path, settings: LogSettings, tally: ReadReport) -> Iterator[RecordedImage | Scan]:
    """Pictures of the first camera and scans of the first laser, or of `settings.scan_topic`, in recorded order.

    What cannot be read is counted in `tally`. Raises BadInput for files that are no recording.
    """
    if path.is_dir():
        envelopes = ros2_bag.folder_messages(path, settings, tally)
    elif path.suffix.lower() in ROS_FORMS:
        envelopes = ROS_FORMS[path.suffix.lower()][1](path, settings, tally)
    else:
        raise BadInput(f"{path.name} is no recording with pictures: {', '.join(ROS_FORMS)} and bag folders are read.")
    camera, laser = "", settings.scan_topic.strip("/")
    for envelope in envelopes:
        kind, topic = ros2_name(envelope.kind), envelope.topic.strip("/")
        if kind in (IMAGE, COMPRESSED) and camera in ("", topic):
            camera, read = topic, _picture
        elif kind == LASER_SCAN and laser in ("", topic):
            laser, read = topic, _scan
        else:
            continue
        try:
            found = read(envelope, kind)
        except (BadRecord, BadInput) as problem:
            tally.skip(str(problem), f"a message of {envelope.topic}")
            continue
        except Exception:  # whatever a decoder raises on hostile bytes, the next message may be fine
            tally.skip("it cannot be decoded", f"a message of {envelope.topic}")
            continue
        tally.read += 1
        yield found


def _scan(envelope: Envelope, kind: str) -> Scan:
    decoded = decode(envelope, kind)
    angles, limits = (decoded.angle_min, decoded.angle_increment), (decoded.range_min, decoded.range_max)
    return make_scan(_stamp(decoded, envelope), decoded.ranges, angles, limits, decoded.time_increment)


def _picture(envelope: Envelope, kind: str) -> RecordedImage:
    decoded = decode(envelope, kind)
    grey = decode_grey(bytes(decoded.data))[0] if kind == COMPRESSED else _raw(decoded)
    return RecordedImage(stamp=_stamp(decoded, envelope), grey=grey)


def _raw(picture: Any) -> Array:
    """An uncompressed picture → grey (H, W). Raises BadRecord."""
    height, width, step, channels = picture.height, picture.width, picture.step, CHANNELS.get(picture.encoding, 0)
    if not channels:
        raise BadRecord(f"its pixels are '{str(picture.encoding)[:20]}'; {', '.join(CHANNELS)} are read")
    if not 0 < width * height <= MOST_PIXELS or step < width * channels or len(picture.data) < step * height:
        raise BadRecord("its size does not fit its pixels")
    rows = np.asarray(picture.data, np.uint8)[: step * height].reshape(height, step)[:, : width * channels]
    if channels == 1:
        return np.ascontiguousarray(rows)
    pixels = np.ascontiguousarray(rows).reshape(height, width, channels)
    return np.asarray(cv2.cvtColor(pixels, TO_GREY[picture.encoding]))


def _stamp(decoded: Any, envelope: Envelope) -> float:
    """The sensor's own time [s], or the recorder's where it has none."""
    return stamp_of(decoded.header) or envelope.logged
