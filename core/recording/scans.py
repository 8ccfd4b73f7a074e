"""Rows of ranges → scans: one meaning for "no measurement" and "nothing there", one direction, sane numbers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.recording.odometry_track import OdometryTrack
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording
from core.sensors import Laser, Scan
from core.sensors.laser import MAX_STAMP_S, MAX_SWEEP_S, beams_malformation

AT_THE_ORIGIN = Pose()
DEFAULT_RANGE = 100.0  # [m] taken for range_max where a log does not give it


def spread(beams: int) -> tuple[float, float]:
    """Beams over 180° whose angles are not given → (angle_min, angle_step) [rad].

    181, 361, … beams stand on both ends (-90° … +90°); any other number n stands every 180°/n from -90° on.
    """
    return -math.pi / 2, math.pi / (beams - 1 if beams > 1 and (beams - 1) % 180 == 0 else beams)


def make_scan(
    stamp: float,
    ranges: Array,
    angles: tuple[float, float],
    limits: tuple[float, float | None],
    time_step: float = 0.0,
) -> Scan:
    """Ranges (N,) [m] as logged → a scan from right to left.

    `angles` (angle_min, angle_step) [rad]; `limits` (range_min, range_max or None where it is not given) [m].
    Below range_min, negative or NaN: no measurement. From range_max on or +inf: nothing there; a log that does not
    give range_max claims no free space with such beams. Raises BadRecord.
    """
    angle_min, angle_step = angles
    low, high = limits
    beams = len(ranges)
    if abs(stamp) > MAX_STAMP_S:
        raise BadRecord("its time cannot be")
    if why := beams_malformation(beams, angle_min, angle_step):
        raise BadRecord(why)
    if not math.isfinite(time_step) or not 0 <= time_step * beams < MAX_SWEEP_S:
        time_step = 0.0
    limited = high is not None and 0 < high < 10_000
    top = high if high is not None and limited else DEFAULT_RANGE
    low = low if 0 <= low < top else 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        ranges = np.asarray(ranges, np.float32)
        nothing = ranges >= top
        missing = ~(ranges >= max(low, 1e-6))
    clean = np.where(missing, np.nan, np.where(nothing, np.inf if limited else np.nan, ranges))
    if angle_step < 0:
        stamp += time_step * (beams - 1)
        angle_min, angle_step, time_step = angle_min + angle_step * (beams - 1), -angle_step, -time_step
        clean = clean[::-1]
    return Scan(
        stamp=stamp,
        ranges=np.ascontiguousarray(clean, np.float32),
        angle_min=angle_min,
        angle_step=angle_step,
        range_min=low,
        range_max=top,
        time_step=time_step,
    )


def settle_stamps(own: Array, logged: Array) -> tuple[Array, Array]:
    """Stamps in the records (N,) and stamps of the recorder (N,) [s] → (stamps to use (N,), good (N,) bool).

    The records' own are used unless most are missing (NaN, zero) or repeat; records whose own stamp is more than
    30 s away from what the others suggest are not good.
    """
    stamped = np.isfinite(own) & (own > 0)
    if not stamped.any() or len(np.unique(own[stamped])) * 2 < len(own):
        return logged, np.isfinite(logged)
    late = own - logged
    offset = np.median(late[stamped])
    return own, stamped & (np.abs(late - offset) < 30.0)


def in_time_order(scans: list[Scan], tally: ReadReport) -> list[Scan]:
    """Scans in any order → rising stamps; what repeats a stamp is left out and counted."""
    ordered = sorted(scans, key=lambda scan: scan.stamp)
    kept = [scan for index, scan in enumerate(ordered) if index == 0 or scan.stamp > ordered[index - 1].stamp]
    tally.drop("the stamp is that of another scan", count=len(ordered) - len(kept))
    return kept


def laser_of(scans: list[Scan], mounting: Pose, height: float, settings: LogSettings) -> Laser:
    """The laser that made these scans, as its middle scan describes it."""
    typical = scans[len(scans) // 2]
    periods = np.diff([scan.stamp for scan in scans])
    return Laser(
        mounting=settings.mounted(mounting),
        height=height,
        beams=len(typical.ranges),
        angle_min=typical.angle_min,
        angle_step=typical.angle_step,
        range_min=typical.range_min,
        range_max=typical.range_max,
        rate=1 / float(np.median(periods)) if len(periods) else 10.0,
        time_step=typical.time_step,
    )


def scan_recording(
    path: Path,
    scans: list[Scan],
    track: OdometryTrack | None,
    tally: ReadReport,
    form: str,
    settings: LogSettings,
    mounting: Pose = AT_THE_ORIGIN,
    height: float = Laser.height,
) -> ScanRecording:
    """Scans in time order (at least one) and odometry → the recording."""
    if track is not None and (scans[0].stamp < track.times[0] - 1 or scans[-1].stamp > track.times[-1] + 1):
        tally.warn("Some scans lie outside the time of the odometry; the wheels are taken to stand still there.")
    return ScanRecording(
        path=path,
        scans=tuple(scans),
        track=track,
        laser=laser_of(scans, mounting, height, settings),
        report=tally.report(form),
    )
