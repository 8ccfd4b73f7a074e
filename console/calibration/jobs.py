"""Jobs of the calibration's workers (camera, laser, solver), and their answers."""

from typing import Any, Generic, NotRequired, TypedDict, TypeVar

import msgspec

from console.messages.calibration import (
    CalibrationAdvice,
    CalibrationBoard,
    CalibrationCheck,
    CalibrationProgress,
    CalibrationScan,
    CalibrationUncertainty,
    CalibrationVerdict,
    CalibrationView,
)
from console.workers.job import Job
from core.calibration import reports
from core.calibration.camera.intrinsics import Calibration
from core.calibration.exports import Exports
from core.calibration.laser.solve import LaserCalibration
from core.calibration.mount import Mount
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel
from core.sensors.laser import Scan

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


class OpenCamera(Job[SessionAnswer], frozen=True):
    """Begin a camera's session, or go on where `state` ended."""

    board: CalibrationBoard
    state: bytes
    solved: SolvedViews | None


class OpenLaser(Job[SessionAnswer], frozen=True):
    """Begin a laser's session, or go on where `state` ended."""

    board: CalibrationBoard
    state: bytes
    solved: SolvedViews | None
    camera: CameraModel
    mount: Mount


class LookAtPicture(Job[SessionAnswer], frozen=True):
    """A live picture of the robot."""

    grey: Array  # (H, W) uint8
    stamp: float  # [s]


class LookAtWebcam(Job[SessionAnswer], frozen=True):
    """A live picture of the browser's webcam."""

    content: bytes  # JPEG or PNG
    stamp: float  # [s]


class TakeUpload(Job[SessionAnswer], frozen=True):
    """A picture that was uploaded on purpose."""

    content: bytes  # JPEG or PNG
    name: str
    corners: list[tuple[float, float]] = []  # [pixel] the four extreme ones, where a person has marked them


class TakePicture(Job[SessionAnswer], frozen=True):
    """The robot's picture, taken on purpose."""

    grey: Array  # (H, W) uint8


class SweepScan(Job[SessionAnswer], frozen=True):
    scan: Scan


class ForgetRoom(Job[SessionAnswer], frozen=True):
    """Look at the empty room again: the robot has moved, or a person stood in the room. Poses stay."""


class RefreshSession(Job[SessionAnswer], frozen=True):
    """Answer all of it, as it is."""


class DropView(Job[SessionAnswer], frozen=True):
    """Leave a view out. Raises BadInput."""

    name: str


class RestoreView(Job[SessionAnswer], frozen=True):
    """Take a view back in. Raises BadInput."""

    name: str


class SkipAdvice(Job[SessionAnswer], frozen=True):
    """Suggest another view."""


class AdoptSolution(Job[SessionAnswer], frozen=True):
    solved: SolvedViews


class AcceptCamera(Job[AcceptedCamera], frozen=True):
    """The camera as it is stored; `force`: although it is not as exact as it should be. Raises Refused."""

    force: bool


class AcceptMount(Job[AcceptedMount], frozen=True):
    """The mount as it is stored; `force`: although it is not as exact as it should be. Raises Refused."""

    force: bool


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


class SolveCamera(Job[CameraSolution], frozen=True):
    """Solve a camera's session. Raises BadInput."""

    board: CalibrationBoard
    state: bytes
    printed: bool = False  # with the coefficients as eq. 44 has them


class SolveLaser(Job[LaserSolution], frozen=True):
    """Solve a laser's session. Raises BadInput."""

    board: CalibrationBoard
    state: bytes
    camera: CameraModel
    mount: Mount
    printed: bool = False  # by eq. 13


class MeasureCorrection(Job[reports.CorrectionReport], frozen=True):
    """Measure how well Table 1's inverse and the exact one straighten this camera's pictures."""

    camera: CameraModel


class StraightenPicture(Job[bytes], frozen=True):
    """A stored picture → JPEG, straight where a camera is given. Raises BadInput."""

    content: bytes  # JPEG or PNG
    camera: CameraModel | None


class ReadCalibrationFile(Job[ImportedCamera | ImportedMount], frozen=True):
    """Read a camera's or a mount's file of any form. Raises BadInput.

    A mount belongs to a camera: the one in its own file, else `camera`, which is in use.
    """

    text: str
    camera: CameraModel | None
