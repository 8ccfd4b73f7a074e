"""Recordings: the scans with odometry, or the sightings, of a log, in time order."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Self

import cv2
import numpy as np

from core.calibration.files import pictures
from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.landmarks import Sighting
from core.recording.odometry_track import OdometryTrack
from core.sensors import Camera, Fault, Laser, Scan, SensorFrame, Sound, Wheels
from core.setting import Meta, Section
from core.slam.motion import Increment


@dataclass(frozen=True)
class LogSettings(Section):
    """Settings for reading a log; empty and zero mean: as the log itself says, or a sensible guess.

    Watch:
        scan_topic: topics that `beckon slam --json` names
        odometry_topic: topics that `beckon slam --json` names
        odometry_frame: topics that `beckon slam --json` names
        sound_topic: topics that `beckon hear --json` names
        sound_rate: pitch of the voices
        sound_channels: length and pitch of the sound
        base_frame: walls that turn with the robot
        mounting_x: walls that shift in turns
        mounting_y: walls that shift in turns
        mounting_heading: walls aslant to the way driven
        range_max: stray points at the end of the range (then lower it)
        largest_file_mb: memory while a log is read
        largest_block_mb: memory while a log is read
        most_readings_mb: memory, and the warning that readings were left out
    """

    scan_topic: Annotated[str, Meta(meaning="empty: the LaserScan topic with the most readings")] = ""
    odometry_topic: Annotated[
        str, Meta(meaning='empty: the Odometry topic with the most readings, else tf; "none": scans only')
    ] = ""
    odometry_frame: Annotated[str, Meta(meaning='parent of the tf that is taken for odometry; empty: "odom"')] = ""
    sound_topic: Annotated[str, Meta(meaning="empty: the topic with the most sound")] = ""
    sound_rate: Annotated[int, Meta("Hz", 0, 192_000, "of AudioData without AudioInfo; 0: as its bytes come")] = 0
    sound_channels: Annotated[int, Meta("", 0, 64, "of AudioData without AudioInfo; 0: as its bytes come")] = 0
    base_frame: Annotated[str, Meta(meaning='the robot\'s own frame; empty: "base_link" or "base_footprint"')] = ""
    mounting_x: Annotated[
        float | None, Meta("m", -10, 10, "x of robot_from_laser; not given: as the log says, or 0")
    ] = None
    mounting_y: Annotated[float | None, Meta("m", -10, 10, "y of robot_from_laser")] = None
    mounting_heading: Annotated[float | None, Meta("rad", -6.3, 6.3, "heading of robot_from_laser")] = None
    range_max: Annotated[float, Meta("m", 0, 1000, "longest range of the laser; 0: as the log says")] = 0.0
    largest_file_mb: Annotated[float, Meta("MB", 1e-5, 1e6, "larger files are refused")] = 4000.0
    largest_block_mb: Annotated[float, Meta("MB", 1e-5, 2000, "size to which a compressed block may unpack")] = 32.0
    most_readings_mb: Annotated[
        float, Meta("MB", 0.001, 32000, "readings that are held; later ones are left out, with a warning")
    ] = 400.0

    @property
    def largest_file(self) -> int:
        """Bytes of the largest file that is read."""
        return int(self.largest_file_mb * 1e6)

    @property
    def largest_block(self) -> int:
        """Bytes a compressed block may unpack to."""
        return int(self.largest_block_mb * 1e6)

    @property
    def sound(self) -> tuple[str, int, int]:
        """Topic, rate [Hz] and channels of the sound."""
        return self.sound_topic, self.sound_rate, self.sound_channels

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
    warnings: tuple[str, ...] = ()  # sentences, those of the faults among them
    faults: tuple[Fault, ...] = ()


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
class RecordedPicture:
    """One recorded picture, decoded only when it is played."""

    stamp: float  # [s]
    content: bytes  # JPEG, or what else the camera sent

    @property
    def pixels(self) -> Array:
        """(H, W, 3) uint8, blue-green-red. Raises BadInput."""
        return pictures.decode(self.content, cv2.IMREAD_COLOR, live=True)[0]


@message
class ScanRecording:
    """A log of laser scans, with odometry where there is some."""

    path: Path
    scans: tuple[Scan, ...]  # in time order; ranges as stored, mostly (N,) float32
    track: OdometryTrack | None  # odometry; None: scans only
    laser: Laser
    report: RecordingReport
    pictures: tuple[RecordedPicture, ...] = ()  # of the first camera, where they were asked for
    camera: Camera | None = None  # that took them
    sounds: tuple[Sound, ...] = ()  # the pieces of one microphone board, where they were asked for

    @property
    def start(self) -> float:
        """First stamp [s]."""
        return logged_stamp(self.scans[0])

    @property
    def duration(self) -> float:
        """Time [s] from the first to the last scan."""
        return logged_stamp(self.scans[-1]) - self.start

    def with_faults(self, faults: tuple[Fault, ...]) -> Self:
        """The recording with what was found in it later, which its report says, too."""
        sentences = (one.sentence for one in faults)
        report = replace(
            self.report, warnings=(*self.report.warnings, *sentences), faults=(*self.report.faults, *faults)
        )
        return replace(self, report=report)

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
