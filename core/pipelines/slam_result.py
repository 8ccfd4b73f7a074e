"""The result of an offline run: the estimates from one log, and how they went."""

from dataclasses import dataclass, field
from typing import NotRequired, TypedDict

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.recording import Recording, RecordingReport
from core.recording.drive import DriveRecording
from core.sensors.checks import FoundFault, found_faults
from core.slam.estimate import Landmark
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import ClosureStatus
from core.slam.scan_matching.agreement import MoveAgreement

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


class PositionErrors(TypedDict):
    """Distances from the true positions, the first pose laid upon the first true one, as JSON."""

    mean_m: float
    worst_m: float
    final_m: float


class MoveScales(TypedDict):
    """Moves by the wheels over those by the scans, as JSON; null: too few show it. The sds are of the scans."""

    way: float | None
    way_sd: float | None
    turn: float | None
    turn_sd: float | None


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
    faults: list[FoundFault]  # of what the checks of the readings found
    wheels_over_scans: NotRequired[MoveScales]  # where the log shows them
    error: NotRequired[PositionErrors]  # where the truth is known: a recording of the simulated robot
    processing_s: NotRequired[float]  # as the caller measured it


@dataclass(frozen=True)
class SlamCourse:
    """How an estimate went, reading by reading."""

    nis: Array  # (N,) running mean per degree of freedom; NaN before the first update
    position_sd: Array  # (N,) [m] of the weaker direction
    step_ms: Array  # (N,) of processing
    closures: tuple[ClosureStatus, ...] = ()


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
    truth: tuple[Pose, ...] = ()  # of every pose, in the simulator's world; (): it is not known
    agreement: MoveAgreement | None = None  # of wheels and scans
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

    @property
    def errors(self) -> PositionErrors | None:
        """Against the truth; None where it is not known."""
        if not self.truth:
            return None
        moved = self.poses[0] @ self.truth[0].inverse()
        true = moved.apply(np.array([(pose.x, pose.y) for pose in self.truth]))
        off = np.hypot(*(np.array([(pose.x, pose.y) for pose in self.poses]) - true).T)
        return {"mean_m": float(off.mean()), "worst_m": float(off.max()), "final_m": float(off[-1])}

    def json(self) -> SlamFigures:
        """Everything but the poses, as plain values with their units in the keys."""
        report, errors = self.report, self.errors
        figures: SlamFigures = {
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
            "faults": found_faults(report.faults),
        }
        shown = self.agreement
        if shown is not None and (shown.way_scale, shown.turn_scale) != (None, None):
            figures["wheels_over_scans"] = {
                "way": shown.way_scale,
                "way_sd": shown.way_sd,
                "turn": shown.turn_scale,
                "turn_sd": shown.turn_sd,
            }
        if errors is not None:
            figures["error"] = errors
        return figures

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
