"""A log through the estimators as fast as it goes: no clock, no robot, the same pilot as in the console."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import NotRequired, TypedDict

from core.geometry import Pose
from core.pilot import Pilot
from core.pipelines import slam_files
from core.recording import Ids, Recording, ScanRecording, SightingRecording, open_log
from core.robots.replayed import profile_of
from core.settings import Settings
from core.slam.ekf_slam import EkfSlam
from core.slam.estimate import Landmark
from core.slam.map.occupancy import OccupancyGrid
from core.slam.mapper import AnchoredPose

PACE = 0.02  # [m]: the path is measured from place to place this far apart, so that trembling at rest adds nothing


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

    recording: Recording
    poses: tuple[Pose, ...]  # world, one per reading that carries a scan or a sighting
    landmarks: tuple[Landmark, ...]
    identities: dict[int, int] = field(default_factory=dict[int, int])  # landmark → its name in the log, where given
    grid: OccupancyGrid | None = None
    files: dict[str, str | None] = field(default_factory=lambda: {"trajectory_tum": None, "map_yaml": None})

    @property
    def stamps(self) -> tuple[float, ...]:
        """The log's own stamp [s] of every pose."""
        return tuple(reading.stamp for reading in self.recording)

    @property
    def path(self) -> float:
        """Length [m] of the estimated path."""
        total, last = 0.0, self.poses[0]
        for pose in self.poses[1:]:
            way = last.distance_to(pose.x, pose.y)
            if way >= PACE:
                total, last = total + way, pose
        return total

    def json(self) -> SlamFigures:
        """Everything but the poses, as plain values with their units in the keys."""
        report = self.recording.report
        return {
            "frames": len(self.poses),
            "duration_s": self.recording.duration,
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
) -> SlamResult:
    """Read a log and estimate pose and landmarks over all of it; with `out`, leave the files there.

    `ids` and `still` as for `open_log`. The start is the origin of the world, heading along x. Raises BadInput,
    Unavailable.
    """
    settings = settings or Settings()
    recording = open_log(path, settings.log, ids, still)
    result = _scans(recording, settings) if isinstance(recording, ScanRecording) else _sightings(recording, settings)
    if out is None:
        return result
    files = slam_files.save(out, result.stamps, result.poses, result.landmarks, result.grid)
    return SlamResult(recording, result.poses, result.landmarks, result.identities, result.grid, files)


def _scans(recording: ScanRecording, settings: Settings) -> SlamResult:
    """Scans go through the pilot itself, frame by frame; the poses are those of the final map."""
    pilot = Pilot(profile_of(recording), settings)
    stands: list[AnchoredPose] = []
    for frame in recording:
        pilot.step(frame)
        stands.append(pilot.anchored_pose)
    landmarks, grid = pilot.finish()
    recording = recording.with_faults(pilot.faults)
    return SlamResult(recording, tuple(pilot.where(stand) for stand in stands), landmarks, grid=grid)


def _sightings(recording: SightingRecording, settings: Settings) -> SlamResult:
    """Sightings need no perception: they go to the estimator with the noise of their log."""
    slam = EkfSlam(settings.ekf, settings.motion)
    poses: list[Pose] = []
    for step in recording:
        slam.advance(step.increment)
        slam.see(step.sightings)
        poses.append(slam.estimate.pose)
    identities = {row.id: row.identity for row in slam.table.rows if row.identity is not None}
    return SlamResult(recording, tuple(poses), slam.landmarks, identities)
