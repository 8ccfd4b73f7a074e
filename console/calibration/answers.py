"""Answers of the calibration's workers (camera, laser, solver)."""

from typing import Any, Generic, NotRequired, TypedDict, TypeVar

import msgspec

from console.messages.calibration import (
    CalibrationAdvice,
    CalibrationCheck,
    CalibrationProgress,
    CalibrationScan,
    CalibrationUncertainty,
    CalibrationVerdict,
    CalibrationView,
)
from core.calibration import reports
from core.calibration.camera.intrinsics import Calibration
from core.calibration.exports import Exports
from core.calibration.laser.solve import LaserCalibration
from core.geometry import Transform

Rows = list[list[float]]
Document = dict[str, Any]  # JSON of a file that a stranger may have written
SolvedT = TypeVar("SolvedT")
ReportT = TypeVar("ReportT")


class SolvedCamera(msgspec.Struct, frozen=True, tag=True):
    calibration: Calibration
    names: list[str]


class SolvedMount(msgspec.Struct, frozen=True, tag=True):
    calibration: LaserCalibration
    names: list[str]


SolvedViews = SolvedCamera | SolvedMount


class CountedPicture(msgspec.Struct, frozen=True):
    name: str  # of the view
    picture: bytes | None  # PNG; None: the console has the file that was sent
    small: bytes  # JPEG


class AdvisedView(msgspec.Struct, frozen=True):
    """The next view to take: as the page shows it, and for a program that can hold the board exactly."""

    shown: CalibrationAdvice
    pose: Transform  # camera_from_board


class SessionChange(msgspec.Struct, frozen=True, kw_only=True):
    """A session after its views, its solution or its advice have changed."""

    advice: AdvisedView | None
    progress: CalibrationProgress
    uncertainty: CalibrationUncertainty | None = None
    views: list[CalibrationView]  # the worst first
    state: bytes  # JSON: all that is needed to go on after a restart
    stale: bool  # the solution does not cover the views
    names: list[str]  # of the views that take part


class SessionAnswer(msgspec.Struct, frozen=True, kw_only=True):
    size: tuple[int, int] | None  # [pixel] of its pictures
    verdict: CalibrationVerdict | None = None
    counted: CountedPicture | None = None
    change: SessionChange | None = None
    scan: CalibrationScan | None = None
    check: CalibrationCheck | None = None  # of the pose that has just been counted
    room_known: bool = False  # the laser has seen the empty room


class Accepted(msgspec.Struct, Generic[ReportT], frozen=True):
    """A calibration that was accepted: as it is stored, and what is known about it."""

    document: reports.CalibrationFile
    report: ReportT


AcceptedCamera = Accepted[reports.CameraReport]
AcceptedMount = Accepted[reports.LaserReport]


class CameraSolutionReport(reports.CameraReport):
    views_refused: list[reports.RefusedPicture]
    residuals: Rows  # u, v, du, dv [pixel] of seen corners, thinned


class Solution(msgspec.Struct, Generic[SolvedT, ReportT], frozen=True):
    """A calibration that was solved: to be adopted, to be shown, to be taken away."""

    solved: SolvedT
    report: ReportT
    exports: Exports


CameraSolution = Solution[SolvedCamera, CameraSolutionReport]
LaserSolution = Solution[SolvedMount, reports.LaserReport]


class ImportedCameraReport(reports.CameraNumbers):
    """Camera model of a file."""

    warnings: list[str]
    sd: NotRequired[dict[str, float]]


class ImportedMountReport(TypedDict):
    rotation: Rows
    translation_m: list[float]
    warnings: list[str]


class ImportedCamera(msgspec.Struct, frozen=True, tag="camera"):
    """A camera from a file: as it is stored, and what is known about it."""

    document: reports.CalibrationFile
    report: ImportedCameraReport


class ImportedMount(msgspec.Struct, frozen=True, tag="laser"):
    """A mount from a file: the camera it belongs to, its entry as it is stored, and what is known about it."""

    document: reports.CalibrationFile
    extrinsics: Document
    report: ImportedMountReport
