"""A log through the estimators as fast as it goes: no clock, no robot, the same pilot as in the console."""

import math
import time
from collections.abc import Iterable
from dataclasses import replace
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
from core.robots.replayed import profile_of
from core.sensors import SensorFrame
from core.sensors.checks import UnusableReading
from core.settings import Settings
from core.slam.ekf_slam import EkfSlam
from core.slam.map.status import ClosureStatus
from core.slam.mapper import AnchoredPose


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
