"""Recordings: the scans with odometry, or the sightings, of a log, in time order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.geometry import Pose
from core.message import message
from core.perception.landmarks.landmarks import Sighting
from core.recording.odometry_track import OdometryTrack
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.slam.motion import Increment


@dataclass(frozen=True)
class LogSettings:
    """Settings for reading a log; empty and zero mean: as the log itself says, or a sensible guess."""

    scan_topic: str = ""  # "" = the LaserScan topic with the most readings
    odometry_topic: str = ""  # "" = the Odometry topic with the most readings, else tf; "none" = scans only
    odometry_frame: str = ""  # parent of the tf that is taken for odometry; "" = "odom"
    base_frame: str = ""  # the robot's own frame; "" = "base_link" or "base_footprint"
    mounting_x: float | None = None  # [m] robot_from_laser; None = as the log says, or 0
    mounting_y: float | None = None  # [m]
    mounting_heading: float | None = None  # [rad]
    range_max: float = 0.0  # [m]; 0 = as the log says
    largest_file_mb: float = 4000.0  # larger files are refused
    largest_block_mb: float = 32.0  # what a compressed block may unpack to
    most_readings_mb: float = 400.0  # that are held; later ones are left out, with a warning

    @property
    def largest_file(self) -> int:
        """Bytes of the largest file that is read."""
        return int(self.largest_file_mb * 1e6)

    @property
    def largest_block(self) -> int:
        """Bytes a compressed block may unpack to."""
        return int(self.largest_block_mb * 1e6)

    @property
    def most_readings(self) -> int:
        """Bytes of readings that are held."""
        return int(self.most_readings_mb * 1e6)

    def mounted(self, logged: Pose) -> Pose:
        """The mounting in the log → the one to use, robot_from_laser."""
        ours = (self.mounting_x, self.mounting_y, self.mounting_heading)
        theirs = (logged.x, logged.y, logged.heading)
        return Pose(*(log if given is None else given for given, log in zip(ours, theirs, strict=True)))


@message
class RecordingReport:
    """Counts of records that were read and skipped, and warnings."""

    form: str  # "MCAP", "CARMEN text", …
    read: int  # records that were taken in
    skipped: int  # records that should have been and could not be
    declared: int | None = None  # records the file says it holds
    topics: tuple[str, ...] = ()  # what was used: "/scan: laser", "/odom: odometry"
    warnings: tuple[str, ...] = ()  # sentences


@message
class SightingStep:
    """The move since the step before, and what was seen at its end.

    The noise of both belongs to the log's description and stands in their covariances.
    """

    stamp: float  # [s], the log's own time
    increment: Increment
    sightings: tuple[Sighting, ...]


@message
class SightingRecording:
    """A log of landmark sightings, one step per instant with a sighting."""

    path: Path
    steps: tuple[SightingStep, ...]
    range_max: float  # [m]: the farthest sighting; with the next, what the sensor could have seen
    half_field: float  # [rad] to either side of straight ahead: the widest sighting
    report: RecordingReport

    @property
    def start(self) -> float:
        """First stamp [s]."""
        return self.steps[0].stamp

    @property
    def duration(self) -> float:
        """Time [s] from the first to the last step."""
        return self.steps[-1].stamp - self.steps[0].stamp

    @property
    def has_wheels(self) -> bool:
        """Sightings logs always carry the motion between the steps."""
        return True

    def __iter__(self) -> Iterator[SightingStep]:
        return iter(self.steps)

    def __len__(self) -> int:
        return len(self.steps)


def logged_stamp(scan: Scan) -> float:
    """The stamp [s] the log gives a scan: of its earliest beam, the last one of a mirror that turns clockwise."""
    return scan.stamp + _head_start(scan)


def stamped(scan: Scan, stamp: float) -> Scan:
    """The same scan with another stamp [s] by the log."""
    return replace(scan, stamp=stamp - _head_start(scan))


def _head_start(scan: Scan) -> float:
    """Time [s] from the first beam (rightmost) back to the earliest; never positive."""
    return min(0.0, scan.time_step) * (len(scan.ranges) - 1)


@message
class ScanRecording:
    """A log of laser scans, with odometry where there is some."""

    path: Path
    scans: tuple[Scan, ...]  # in time order; ranges as stored, mostly (N,) float32
    track: OdometryTrack | None  # odometry; None: scans only
    laser: Laser
    report: RecordingReport

    @property
    def start(self) -> float:
        """First stamp [s]."""
        return logged_stamp(self.scans[0])

    @property
    def duration(self) -> float:
        """Time [s] from the first to the last scan."""
        return logged_stamp(self.scans[-1]) - self.start

    @property
    def has_wheels(self) -> bool:
        """True if there is odometry."""
        return self.track is not None

    def scan(self, index: int) -> Scan:
        """The scan of that number, its ranges (N,) as float64 [m]."""
        scan = self.scans[index]
        return replace(scan, ranges=scan.ranges.astype(np.float64))

    def wheels_at(self, stamp: float) -> Wheels | None:
        """The wheels' reading at `stamp` [s]; None without odometry."""
        return None if self.track is None else self.track.wheels_at(stamp)

    def __iter__(self) -> Iterator[SensorFrame]:
        """One frame per scan, stamped as the log stamps it, with the odometry of that instant."""
        for index, scan in enumerate(self.scans):
            yield SensorFrame(
                stamp=logged_stamp(scan), wheels=self.wheels_at(logged_stamp(scan)), scan=self.scan(index)
            )

    def __len__(self) -> int:
        return len(self.scans)


Recording = ScanRecording | SightingRecording
