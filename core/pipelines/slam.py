"""A log through the estimators as fast as it goes: no clock, no robot, the same pilot as in the console."""

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple, NotRequired, TypedDict

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.pilot import Pilot
from core.pilot.recorded_drive import robot_of
from core.pipelines import slam_files
from core.pipelines.slam_report import ReportedRun, SlamCourse, report_html
from core.progress import UNSEEN, WorkProgress
from core.recording import Ids, Recording, RecordingReport, ScanRecording, SightingRecording, open_log
from core.recording.drive import DriveRecording, is_drive
from core.recording.frame_record import FRAME
from core.robots.replayed import profile_of
from core.sensors import SensorFrame
from core.sensors.checks import UnusableReading
from core.settings import Settings
from core.slam.ekf_slam import EkfSlam
from core.slam.estimate import Landmark
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import ClosureStatus
from core.slam.mapper import AnchoredPose

PATH_STEP_M = 0.02  # the path is measured from place to place this far apart, so that trembling at rest adds nothing


class LandmarkFigures(TypedDict):
    """A landmark, as JSON."""

    id: int
    x_m: float
    y_m: float
    cov_m2: list[list[float]]
    hits: int
    misses: int
    kind: str
    identity: NotRequired[int]  # its name in the log


class SlamFigures(TypedDict):
    """Everything of a result but the poses, as JSON."""

    frames: int
    duration_s: float
    path_m: float
    landmarks: list[LandmarkFigures]
    files: dict[str, str | None]
    form: str
    topics: list[str]
    odometry: bool
    read: int
    skipped: int
    declared: int | None
    warnings: list[str]
    faults: list[dict[str, str]]  # code and sentence of what the checks of the readings found
    processing_s: NotRequired[float]  # as the caller measured it


@dataclass(frozen=True)
class SlamResult:
    """The estimates from one log. The caller measures the time that it took."""

    recording: Recording | DriveRecording
    report: RecordingReport
    stamps: tuple[float, ...]  # [s], the log's own, one per pose
    poses: tuple[Pose, ...]  # world, one per reading that carries a scan or a sighting
    landmarks: tuple[Landmark, ...]
    course: SlamCourse
    identities: dict[int, int] = field(default_factory=dict[int, int])  # landmark → its name in the log, where given
    grid: OccupancyGrid | None = None
    files: dict[str, str | None] = field(default_factory=lambda: {"trajectory_tum": None, "map_yaml": None})

    @property
    def path(self) -> float:
        """Length [m] of the estimated path."""
        total, last = 0.0, self.poses[0]
        for pose in self.poses[1:]:
            way = last.distance_to(pose.x, pose.y)
            if way >= PATH_STEP_M:
                total, last = total + way, pose
        return total

    def json(self) -> SlamFigures:
        """Everything but the poses, as plain values with their units in the keys."""
        report = self.report
        return {
            "frames": len(self.poses),
            "duration_s": self.stamps[-1] - self.stamps[0],
            "path_m": self.path,
            "landmarks": [self._row(mark) for mark in self.landmarks],
            "files": self.files,
            "form": report.form,
            "topics": list(report.topics),
            "odometry": self.recording.has_wheels,
            "read": report.read,
            "skipped": report.skipped,
            "declared": report.declared,
            "warnings": list(report.warnings),
            "faults": [{"code": one.code, "sensor": one.sensor, "sentence": one.sentence} for one in report.faults],
        }

    def _row(self, mark: Landmark) -> LandmarkFigures:
        x, y = mark.position.tolist()
        row = LandmarkFigures(
            id=mark.id,
            x_m=x,
            y_m=y,
            cov_m2=mark.covariance.tolist(),
            hits=mark.hits,
            misses=mark.misses,
            kind=mark.kind,
        )
        if mark.id in self.identities:
            row["identity"] = self.identities[mark.id]
        return row


def slam_log(
    path: str | Path,
    settings: Settings | None = None,
    ids: Ids = "given",
    still: bool = False,
    out: Path | None = None,
    progress: WorkProgress = UNSEEN,
) -> SlamResult:
    """Read a log and estimate pose and landmarks over all of it; with `out`, leave the files there.

    `ids` and `still` as for `open_log`. The start is the origin of the world, heading along x. Raises BadInput,
    Unavailable.
    """
    settings = settings or Settings()
    progress.at(0.0, "reading")
    result = _own(Path(path), settings, progress)
    if result is None:
        recording = open_log(path, settings.log, ids, still)
        scans = isinstance(recording, ScanRecording)
        result = _scans(recording, settings, progress) if scans else _sightings(recording, settings, progress)
    if out is None:
        return result
    report = report_html(_reported(result, settings))
    files = slam_files.save(out, result.stamps, result.poses, result.landmarks, result.grid, report)
    return replace(result, files=files)


def _reported(result: SlamResult, settings: Settings) -> ReportedRun:
    """The report of a result."""
    report = result.report
    return ReportedRun(
        title=result.recording.path.name,
        facts=(
            ("form", f"{report.form}: {', '.join(report.topics)}".rstrip(": ")),
            ("readings", f"{len(result.poses)} over {result.stamps[-1] - result.stamps[0]:.1f} s"),
            ("records skipped", str(report.skipped)),
            ("odometry", "yes" if result.recording.has_wheels else "no"),
            ("path", f"{result.path:.2f} m"),
            ("landmarks", str(len(result.landmarks))),
        ),
        warnings=report.warnings,
        stamps=result.stamps,
        poses=result.poses,
        landmarks=result.landmarks,
        grid=result.grid,
        course=result.course,
        settings=settings,
    )


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


def _own(path: Path, settings: Settings, progress: WorkProgress) -> SlamResult | None:
    """One of Beckon's own recordings: the frames that the pilot took that day; None for all others."""
    if not is_drive(path):
        return None
    drive = DriveRecording(path, settings.log)
    try:
        pilot = Pilot(robot_of(drive).used, settings)
    except BadInput:
        return None  # recorded before there was a description, or without a page
    run = _steered(pilot, drive, drive.counts.get(FRAME, 0), progress)
    drive.close()
    if not run.stamps:
        raise BadInput(f"{path.name} holds no scans. It holds {', '.join(drive.report.topics[:8])}.")
    return _result(drive, pilot, run)


def _scans(recording: ScanRecording, settings: Settings, progress: WorkProgress) -> SlamResult:
    """Scans go through the pilot itself, frame by frame."""
    pilot = Pilot(profile_of(recording), settings)
    return _result(recording, pilot, _steered(pilot, recording, len(recording), progress))


class _PilotRun(NamedTuple):
    """The outcome of taking every frame."""

    stamps: list[float]  # [s] of the frames with a scan
    stands: list[AnchoredPose]  # at them
    course: SlamCourse


def _steered(pilot: Pilot, frames: Iterable[SensorFrame], count: int, progress: WorkProgress) -> _PilotRun:
    """Take `count` frames."""
    taker, stamps, stands = _CourseTaker(), list[float](), list[AnchoredPose]()
    closures: tuple[ClosureStatus, ...] = ()
    progress.at(0.0, "estimating")
    for number, frame in enumerate(frames, 1):
        taker.begin()
        snapshot = pilot.step(frame)
        if frame.scan is not None:
            stamps.append(frame.stamp)
            stands.append(pilot.anchored_pose)
            taker.end(snapshot.slam.nis, snapshot.estimate.covariance)
        closures = snapshot.floor.closures
        progress.at(min(number / max(count, 1), 1.0), "estimating")
    return _PilotRun(stamps, stands, taker.course(closures))


def _result(recording: ScanRecording | DriveRecording, pilot: Pilot, run: _PilotRun) -> SlamResult:
    """The poses are those of the final map; what the pilot found in the readings stands in the report.

    Raises UnusableReading where it found them to be of no use.
    """
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
    return SlamResult(recording, report, tuple(run.stamps), poses, landmarks, run.course, grid=grid)


def _sightings(recording: SightingRecording, settings: Settings, progress: WorkProgress) -> SlamResult:
    """Sightings need no perception: they go to the estimator with the noise of their log."""
    slam, taker = EkfSlam(settings.ekf, settings.motion), _CourseTaker()
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
