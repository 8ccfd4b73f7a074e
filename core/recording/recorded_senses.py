"""A recording's pictures, scans and sound, as they were recorded: MCAP, ROS 1 and ROS 2 bags, Beckon's own."""

import contextlib
import math
from collections.abc import Generator, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.optics import CameraModel
from core.progress import UNSEEN, WorkProgress
from core.recording import ros_form
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings
from core.recording.ros import HEARD, LASER_SCAN, Envelope, ros2_name, stamp_of
from core.recording.ros import decode as decoded_message
from core.recording.ros_pictures import CAMERA_INFO, COMPRESSED, IMAGE, RosCamera
from core.recording.ros_sound import RosSounds
from core.recording.scans import make_scan
from core.recording.source import is_packed, unpacked_file
from core.sensors import Scan, Sound

MAX_SILENCE_S = 4 * 3600.0  # between two pieces of sound
ALMOST_ALL = 0.99  # of a file, as far as its progress can be known


@message
class RecordedImage:
    """One recorded picture."""

    stamp: float  # [s], the camera's
    pixels: Array  # (H, W, 3) uint8, blue-green-red
    model: CameraModel | None = None  # as the recording says it

    @property
    def grey(self) -> Array:
        """(H, W) uint8."""
        return cv2.cvtColor(self.pixels, cv2.COLOR_BGR2GRAY)


def is_recording(path: Path) -> bool:
    """Return whether this file or folder is read as a recording."""
    return path.exists() and ((path.is_file() and is_packed(path)) or ros_form(path) is not None)


def sights(
    path: Path, settings: LogSettings, tally: ReadReport, every_s: float = 0.0, progress: WorkProgress = UNSEEN
) -> Iterator[RecordedImage | Scan]:
    """Pictures of one camera and scans of the first laser, or of `settings.scan_topic`, in recorded order.

    Of the pictures one is taken every `every_s` [s] at most. What cannot be read is counted in `tally`. Raises
    BadInput for files that are no recording.
    """
    camera, laser, due = RosCamera(), settings.scan_topic.strip("/"), -math.inf
    with _messages(path, settings, tally, progress) as envelopes:
        for envelope in envelopes:
            kind, topic = ros2_name(envelope.kind), envelope.topic.strip("/")
            with tally.reading(envelope.topic):
                if kind in (IMAGE, COMPRESSED) and camera.may_be(envelope.topic):
                    if not due - every_s <= envelope.logged < due:
                        picture = _picture(envelope, kind, camera)
                        due = envelope.logged + every_s
                        yield picture
                elif kind == LASER_SCAN and laser in ("", topic):
                    laser = topic
                    yield _scan(envelope, kind)
                elif kind == CAMERA_INFO:
                    camera.note_info(envelope.topic, decoded_message(envelope, kind))
                    continue
                else:
                    continue
                tally.read += 1


def recorded_sound(path: Path, settings: LogSettings, tally: ReadReport, progress: WorkProgress = UNSEEN) -> Sound:
    """The sound of a recording as one, silent where a part is missing; its stamp [s] is that of the first sample.

    Raises BadInput where it holds none.
    """
    sounds = RosSounds(*settings.sound)
    with _messages(path, settings, tally, progress) as envelopes:
        for envelope in envelopes:
            kind = ros2_name(envelope.kind)
            if kind in HEARD:
                with tally.reading(envelope.topic):
                    tally.read += sounds.take(envelope.topic, decoded_message(envelope, kind), kind, envelope.logged)
    pieces = sounds.finish(tally)
    if not pieces:
        reasons = f" What could not be read: {tally.reasons()}." if tally.skipped else ""
        raise BadInput(f"{path.name} holds no sound that can be read.{reasons}")
    return _joined(pieces)


def _joined(pieces: tuple[Sound, ...]) -> Sound:
    first, samples = pieces[0], [pieces[0].samples]
    length = len(samples[0])
    for piece in pieces[1:]:
        begin = round((piece.stamp - first.stamp) * first.rate)
        missing = min(max(begin - length, 0), round(MAX_SILENCE_S * first.rate))
        samples += [np.zeros((missing, first.channels), first.samples.dtype), piece.samples]
        length += missing + len(piece.samples)
    return replace(first, samples=np.concatenate(samples))


@contextlib.contextmanager
def _messages(
    path: Path, settings: LogSettings, tally: ReadReport, progress: WorkProgress
) -> Generator[Iterator[Envelope]]:
    """Every message of a file, a folder or a packed file. Raises BadInput for what is none."""
    with contextlib.ExitStack() as stack:
        place = path
        if path.is_file() and is_packed(path):
            place = stack.enter_context(unpacked_file(path, settings.largest_file))
        form = ros_form(place)
        if form is None:
            raise BadInput(f"{path.name} is no recording with pictures or sound: MCAP and ROS bags are.")
        yield _watched(form[1](place, settings, tally), path, progress)


def _watched(envelopes: Iterator[Envelope], path: Path, progress: WorkProgress) -> Iterator[Envelope]:
    """The same messages; the progress is their share of the file, as if it were not packed."""
    files = path.rglob("*") if path.is_dir() else (path,)
    size, passed = max(sum(one.stat().st_size for one in files if one.is_file()), 1), 0
    progress.at(0.0, path.name)
    for envelope in envelopes:
        yield envelope
        passed += len(envelope.content)
        progress.at(min(passed / size, ALMOST_ALL), path.name)


def _scan(envelope: Envelope, kind: str) -> Scan:
    decoded = decoded_message(envelope, kind)
    angles, limits = (decoded.angle_min, decoded.angle_increment), (decoded.range_min, decoded.range_max)
    return make_scan(_stamp(decoded, envelope), decoded.ranges, angles, limits, decoded.time_increment)


def _picture(envelope: Envelope, kind: str, camera: RosCamera) -> RecordedImage:
    decoded = decoded_message(envelope, kind)
    pixels = camera.pixels(envelope.topic, decoded, kind)
    model = camera.model(pixels.shape[1], pixels.shape[0])
    return RecordedImage(stamp=_stamp(decoded, envelope), pixels=pixels, model=model)


def _stamp(decoded: Any, envelope: Envelope) -> float:
    """The sensor's own time [s], or the recorder's where it has none."""
    return stamp_of(decoded.header) or envelope.logged
