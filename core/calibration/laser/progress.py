"""Describe the progress of the laser's wizard, and what is missing, in words."""

from __future__ import annotations

from typing import NamedTuple

from core.calibration.laser.explanation import landings, laser_offset_words, weak_words
from core.calibration.laser.extrinsics import ExtrinsicsSettings
from core.calibration.laser.solve import LaserCalibration
from core.calibration.mount import NAMES, Mount
from core.optics import CameraModel

KNOWN_FROM = ExtrinsicsSettings.known  # gain from which a direction counts as known


class LaserProgress(NamedTuple):
    """The progress of the wizard."""

    poses: int
    precision: dict[str, float]  # per direction: share by which the data have shrunk the mount's doubt, 0..1
    weak: tuple[str, ...]  # sentences
    laser_offset: str  # a sentence; empty before the first solution
    ready: bool
    words: str
    from_ruler: dict[str, str] = {}  # direction → how it was measured, where that speaks instead of the poses
    known_from: float = KNOWN_FROM


def progress_of(
    calibration: LaserCalibration | None,
    model: CameraModel,
    mount: Mount,
    *,
    poses: int,
    wanted: tuple[int, float],
    stale: bool,
    room_known: bool,
) -> LaserProgress:
    """The solution so far, the number of poses, and how many are `wanted`, landing within how many pixels.

    A room that is not known yet matters only where more poses are needed.
    """
    least, laser_offset = wanted
    missing = least - poses
    first = "" if room_known else "First the empty room: step out of the laser's view."
    if calibration is None:
        more = f"{missing} more pose{'s' * (missing > 1)} of the board at least."
        words = (first or more) if missing > 0 else "Not solved yet."
        return LaserProgress(poses, {}, (), "", False, words, mount.from_ruler)
    found = calibration.extrinsics
    offsets, sentences = landings(found, model), weak_words(found)
    near = max(offsets[1].sideways, offsets[1].up_down) <= laser_offset
    if missing > 0:
        words = first or f"{missing} more pose{'s' * (missing > 1)} at least."
    elif stale:
        words = "Not solved yet."
    elif calibration.doubt:
        words = calibration.doubt
    elif sentences:
        words = first or sentences[0]
    elif not near:
        words = first or f"Not yet exact: {laser_offset_words(offsets)}"
    else:
        words = f"Done: {laser_offset_words(offsets)}"
    ready = missing <= 0 and not stale and not sentences and near and not calibration.doubt
    precision = {name: float(gain) for name, gain in zip(NAMES, found.gain, strict=True)}
    return LaserProgress(poses, precision, sentences, laser_offset_words(offsets), ready, words, found.from_ruler)
