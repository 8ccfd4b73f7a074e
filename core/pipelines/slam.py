"""A log through the estimators as fast as it goes: no clock, no robot, the same pilot as in the console."""

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.pilot import Pilot
from core.pilot.recorded_drive import robot_of
from core.pipelines.slam_report import save
from core.pipelines.slam_result import SlamCourse, SlamResult
from core.progress import UNSEEN, WorkProgress
from core.recording import Ids, ScanRecording, SightingRecording, open_log
from core.recording.drive import DriveRecording, is_drive
from core.recording.frame_record import FRAME
from core.robots import Profile
from core.robots.replayed import profile_of
from core.sensors import SensorFrame
from core.sensors.checks import UnusableReading
from core.settings import Settings
from core.slam.ekf_slam import EkfSlam
from core.slam.map.status import ClosureStatus
from core.slam.mapper import AnchoredPose

SENSOR_NAMES = ("laser", "camera", "microphones")


@dataclass(frozen=True)
class ChosenSensors:
    """The sensors that an estimate is made from."""

    laser: bool = True
    cameras: int = 1  # 2: a stereo pair
    microphones: bool = True

    @classmethod
    def named(cls, text: str) -> "ChosenSensors":
        """Some of SENSOR_NAMES with commas between them. Raises BadInput."""
        names = {name.strip() for name in text.split(",")}
        if not names <= set(SENSOR_NAMES):
            unknown = ", ".join(repr(name) for name in sorted(names - set(SENSOR_NAMES)))
            raise BadInput(f"Sensors are some of {', '.join(SENSOR_NAMES)}, with commas between them: not {unknown}.")
        return cls("laser" in names, int("camera" in names), "microphones" in names)

    def of(self, profile: Profile) -> Profile:
        """The robot with these alone."""
        return replace(
            profile,
            lasers=profile.lasers if self.laser else (),
            cameras=profile.cameras[: self.cameras],
            arrays=profile.arrays if self.microphones else (),
        )

    def within(self, frame: SensorFrame) -> SensorFrame:
        """The part of a frame that these deliver."""
        return replace(
            frame,
            scan=frame.scan if self.laser else None,
            image=frame.image if self.cameras else None,
            sound=frame.sound if self.microphones else None,
        )

    def as_landmarks(self, settings: Settings) -> Settings:
        """Settings under which edges and people who call are landmarks, where there is a sensor for them."""
        return replace(
            settings,
            edge_landmarks=replace(settings.edge_landmarks, used=self.cameras > 0),
            voice_landmarks=replace(settings.voice_landmarks, used=self.microphones),
        )

    def missing(self, profile: Profile, delivered: set[str]) -> list[str]:
        """The names of those that the robot has not, or that are not among the `delivered` ones."""
        has = dict(zip(SENSOR_NAMES, (profile.lasers, profile.cameras, profile.arrays), strict=True))
        chosen = zip(SENSOR_NAMES, (self.laser, self.cameras, self.microphones), strict=True)
        return [name for name, wanted in chosen if wanted and not (has[name] and name in delivered)]


def slam_log(
    path: str | Path,
    settings: Settings | None = None,
    ids: Ids = "given",
    still: bool = False,
    out: Path | None = None,
    progress: WorkProgress = UNSEEN,
    sensors: ChosenSensors | None = None,
) -> SlamResult:
    """Read a log and estimate pose and landmarks over all of it; with `out`, leave the files there.

    `ids` and `still` as for `open_log`. With `sensors`, the estimate is made from these alone, and what they see and
    hear becomes landmarks. The start is the origin of the world, heading along x. Raises BadInput, Unavailable.
    """
    settings = settings or Settings()
    progress.at(0.0, "reading")
    result = _own(Path(path), settings, progress, sensors)
    if result is None:
        recording = open_log(path, settings.log, ids, still)
        if isinstance(recording, ScanRecording):
            result = _scans(recording, settings, progress, sensors)
        elif sensors is None:
            result = _sightings(recording, settings, progress)
        else:
            raise BadInput(f"{recording.path.name} holds sightings of landmarks: there is no sensor to choose.")
    if out is None:
        return result
    return replace(result, files=save(out, result, settings))


class _CourseTaker:
    """Collects how the estimate goes, reading by reading."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, float]] = []
        self._began = time.perf_counter()

    def begin(self) -> None:
        """A reading is taken in from now on."""
        self._began = time.perf_counter()

    def end(self, nis: float | None, covariance: Array) -> None:
        """Its estimate is there."""
        weakest = float(np.linalg.eigvalsh(covariance[:2, :2])[-1])
        took_ms = 1e3 * (time.perf_counter() - self._began)
        self._rows.append((math.nan if nis is None else nis, math.sqrt(max(weakest, 0.0)), took_ms))

    def course(self, closures: tuple[ClosureStatus, ...] = ()) -> SlamCourse:
        """All of it."""
        nis, position_sd, step_ms = np.array(self._rows).reshape(-1, 3).T
        return SlamCourse(nis, position_sd, step_ms, closures)


def _own(path: Path, settings: Settings, progress: WorkProgress, sensors: ChosenSensors | None) -> SlamResult | None:
    """One of Beckon's own recordings: the frames that the pilot took that day; None for all others."""
    if not is_drive(path):
        return None
    drive = DriveRecording(path, settings.log)
    try:
        profile = robot_of(drive).used
    except BadInput:
        return None  # recorded before there was a description, or without a page
    taken = ((moment.frame, moment.deaf) for moment in drive.moments())
    run = _steered(profile, settings, taken, drive.counts.get(FRAME, 0), progress, sensors)
    drive.close()
    if not run.stamps:
        raise BadInput(f"{path.name} holds no scans. It holds {', '.join(drive.report.topics[:8])}.")
    return _result(drive, run)


def _scans(
    recording: ScanRecording, settings: Settings, progress: WorkProgress, sensors: ChosenSensors | None
) -> SlamResult:
    taken = ((frame, False) for frame in recording)
    return _result(recording, _steered(profile_of(recording), settings, taken, len(recording), progress, sensors))


class _PilotRun(NamedTuple):
    """The outcome of taking every frame."""

    pilot: Pilot
    stamps: list[float]  # [s] of the frames with a scan
    stands: list[AnchoredPose]  # at them
    truth: list[Pose]  # at them, where it is known
    course: SlamCourse


def _steered(
    profile: Profile,
    settings: Settings,
    frames: Iterable[tuple[SensorFrame, bool]],
    count: int,
    progress: WorkProgress,
    sensors: ChosenSensors | None,
) -> _PilotRun:
    """Every frame through a pilot of this robot; with each, whether its sound is left out.

    Raises BadInput where a chosen sensor delivers nothing.
    """
    pilot = (
        Pilot(profile, settings) if sensors is None else Pilot(sensors.of(profile), sensors.as_landmarks(settings))
    )
    taker, stamps, stands, truth = _CourseTaker(), list[float](), list[AnchoredPose](), list[Pose]()
    closures: tuple[ClosureStatus, ...] = ()
    delivered = set[str]()
    progress.at(0.0, "estimating")
    for number, (frame, deaf) in enumerate(frames, 1):
        readings = zip(SENSOR_NAMES, (frame.scan, frame.image, frame.sound), strict=True)
        delivered.update(name for name, reading in readings if reading is not None)
        taker.begin()
        snapshot = pilot.step(frame if sensors is None else sensors.within(frame), deaf=deaf)
        if frame.scan is not None:
            stamps.append(frame.stamp)
            stands.append(pilot.anchored_pose)
            truth += [] if frame.truth is None else [frame.truth]
            taker.end(snapshot.slam.nis, snapshot.estimate.covariance)
        closures = snapshot.floor.closures
        progress.at(min(number / max(count, 1), 1.0), "estimating")
    if sensors is not None and (missing := sensors.missing(profile, delivered)):
        raise BadInput(f"The recording has no {' and no '.join(missing)} that an estimate could be made from.")
    return _PilotRun(pilot, stamps, stands, truth, taker.course(closures))


def _result(recording: ScanRecording | DriveRecording, run: _PilotRun) -> SlamResult:
    """The poses are those of the final map; what the pilot found in the readings stands in the report.

    Raises UnusableReading where it found them to be of no use.
    """
    pilot = run.pilot
    landmarks, grid = pilot.finish()
    useless = tuple(one for one in pilot.faults if not one.used)
    if useless:
        raise UnusableReading(f"{recording.path.name}: {useless[0].sentence}", useless)
    if isinstance(recording, ScanRecording):
        recording = recording.with_faults(pilot.faults)
        report = recording.report
    else:
        warnings = (*recording.report.warnings, *(one.sentence for one in pilot.faults))
        report = replace(recording.report, faults=pilot.faults, warnings=warnings)
    poses = tuple(pilot.where(stand) for stand in run.stands)
    truth = tuple(run.truth) if len(run.truth) == len(poses) else ()
    return SlamResult(
        recording,
        report,
        tuple(run.stamps),
        poses,
        landmarks,
        run.course,
        grid=grid,
        truth=truth,
        agreement=pilot.agreement,
    )


def _sightings(recording: SightingRecording, settings: Settings, progress: WorkProgress) -> SlamResult:
    """Sightings need no perception: they go to the estimator with the noise of their log."""
    slam, taker = EkfSlam(settings.ekf), _CourseTaker()
    poses: list[Pose] = []
    for step in progress.each(recording.steps, "estimating"):
        taker.begin()
        slam.advance(step.increment)
        slam.see(step.sightings)
        poses.append(slam.estimate.pose)
        taker.end(slam.health.nis, slam.estimate.covariance)
    identities = {row.id: row.identity for row in slam.table.records if row.identity is not None}
    stamps = tuple(step.stamp for step in recording)
    return SlamResult(recording, recording.report, stamps, tuple(poses), slam.landmarks, taker.course(), identities)
