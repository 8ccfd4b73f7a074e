"""Calibrations as JSON: for the command line, for the page, and to be kept."""

from collections.abc import Sequence
from typing import Literal, NotRequired, TypedDict

import cv2
import numpy as np
import scipy

from core.calibration.board.board import Board
from core.calibration.camera.facts import BoardEntry, BoardPoseEntry, CameraFacts
from core.calibration.camera.intrinsics import Calibration
from core.calibration.camera.uncertainty import uncertainty_map
from core.calibration.camera.undistortion import MapError, errors
from core.calibration.files.camera_files import CameraEntry, camera_entry
from core.calibration.files.mount_files import MountEntry, mount_entry, static_transform
from core.calibration.laser.explanation import (
    LaserLanding,
    landings,
    laser_offset_words,
    square_words,
    warnings,
    weak_words,
)
from core.calibration.laser.solve import LaserCalibration
from core.calibration.mount import NAMES
from core.calibration.printed import Equation44
from core.geometry import OPTICAL
from core.optics import CameraModel
from core.sensors.checks import FoundFault, found_faults

FORMAT_NAME, FORMAT_VERSION = "beckon-calibration", 1
Method = Literal["exact", "table-1"]
# The 95 % uncertainty to be reached: a share of the picture's width, and no less than so much [pixel].
TARGET_SHARE, TARGET_LEAST = 1 / 1000, 0.5
MAX_DISAGREEMENT = 1.5  # times the deviations, up to which pictures may disagree without a word


class RefusedPicture(TypedDict):
    """A picture or a pose that was not used, and why."""

    image: str
    reason: str
    seen: NotRequired[str]  # another board that is in the picture, as in "10x10"


class ViewFit(TypedDict):
    """How well one view fits the camera."""

    image: str
    used: bool
    rms_px: float
    remark: str
    corners_left_out: int
    pose: BoardPoseEntry


class PictureUncertainty(TypedDict):
    """How exactly the picture is known [pixel]."""

    p95_px: float
    median_px: float
    worst_px: float
    target_px: float
    reached: bool


class CorrectionReport(TypedDict):
    """The errors of Table 1's inverse and of the exact path."""

    table_1: MapError
    exact: MapError


class StraightPicture(TypedDict):
    """A picture that was straightened, and its file."""

    image: str
    file: str


class CorrectedPictures(TypedDict):
    """The result of straightening pictures."""

    method: Method
    pictures: list[StraightPicture]
    pictures_refused: list[RefusedPicture]
    faults: list[FoundFault]  # of the camera file, and of the pictures that were refused
    warnings: list[str]  # the sentences of those of the camera file
    error: CorrectionReport


class CameraNumbers(TypedDict):
    """A camera by its numbers."""

    image_size: list[int]  # width, height
    fx: float
    fy: float
    cx: float
    cy: float
    k1: float
    k2: float
    p1: float
    p2: float
    k3: NotRequired[float]  # where it was estimated


class CameraReport(CameraNumbers):
    """Everything there is to say about a camera's calibration."""

    views_used: int
    rms_px: float
    noise_px: float
    sd: dict[str, float]  # of every number that was estimated
    disagreement: float  # times these, by which cameras from other pictures alike would differ
    covariance: list[list[float]]  # in the order of sd
    views: list[ViewFit]
    uncertainty: PictureUncertainty
    faults: list[FoundFault]
    warnings: list[str]  # the faults' sentences among them
    eq_44: NotRequired[Equation44]  # by [chapter] mode = "printed"


class CameraFilesReport(CameraReport):
    """A camera's calibration from picture files, and the files that were written."""

    views_refused: list[RefusedPicture]
    correction: CorrectionReport
    files: dict[str, str]


class BoardPoseFit(TypedDict):
    """How well one pose of the board fits the mount."""

    image: str
    used: bool
    beams: int
    residual_rms_m: float | None


class ValueSd(TypedDict):
    """A value with its standard deviation."""

    value: float
    sd: float


class SquareReport(TypedDict):
    """The board's squares [m], as entered and as the laser measures them."""

    entered: float
    by_laser: float
    sd: float


class LaserReport(TypedDict):
    """Everything there is to say about a mount's calibration."""

    rotation: list[list[float]]
    translation_m: list[float]
    turn_deg: list[float]  # roll, pitch, yaw away from looking straight ahead
    sd_rotation_deg: list[float]
    sd_translation_m: list[float]
    axes: list[str]
    covariance: list[list[float]]  # in the order of axes
    not_known: list[str]
    from_ruler: dict[str, str]
    weak_directions: list[str]
    poses_used: int
    poses_refused: list[RefusedPicture]
    poses: list[BoardPoseFit]
    residual_rms_m: float
    range_sd_m: float
    chi2_per_freedom: float
    range_offset_m: ValueSd | None
    square_m: SquareReport
    square_words: str
    laser_offset: list[LaserLanding]
    laser_offset_words: str
    static_transform: str
    warnings: list[str]


class LaserFilesReport(LaserReport):
    """A mount's calibration from files, and the files that were written."""

    faults: list[FoundFault]  # of the camera file, and of the pairs that were refused
    files: dict[str, str]


class SoftwareVersions(TypedDict):
    """The libraries that computed a calibration."""

    opencv: str
    numpy: str


class CalibratedCameraEntry(CameraEntry, CameraFacts):
    """The camera in our own file, with what is known of its exactness."""


class CalibrationFile(TypedDict):
    """Our own JSON file."""

    format: str
    version: int
    software: SoftwareVersions
    camera: CalibratedCameraEntry
    board: NotRequired[BoardEntry]
    extrinsics: NotRequired[MountEntry]


def target(width: int) -> float:
    """[pixel]: projection uncertainty (95 % of the picture) at which a camera counts as calibrated."""
    return max(TARGET_LEAST, TARGET_SHARE * width)


def camera_report(calibration: Calibration) -> CameraReport:
    """Everything there is to say about a camera's calibration; names and units as the command line prints them."""
    model, sds = calibration.model, calibration.sds
    known = uncertainty_map(calibration)
    enough = known.p95 <= target(model.width)
    doubts = list(calibration.warnings)
    if not enough:
        doubts.append(
            f"Not yet exact: 95 % of the picture is known to ±{known.p95:.2f} px (wanted {target(model.width):.2f}). "
            "Show the board tilted, close up and near the rims."
        )
    if calibration.disagreement > MAX_DISAGREEMENT:
        doubts.append(
            f"The pictures disagree by more than their noise: from other pictures alike the camera would differ by "
            f"about {calibration.disagreement:.1f} times the deviations that are stated. Fix the board to something "
            "stiff, lock the focus, and hold still."
        )
    if calibration.free[-1] == "k3":
        doubts.append("k3 was needed: it predicts pictures that took no part in the fit better.")
    return {
        **camera_numbers(model, with_k3="k3" in calibration.free),
        "views_used": int(np.count_nonzero(calibration.used)),
        "rms_px": calibration.rms,
        "noise_px": calibration.noise,
        "sd": sds,
        "disagreement": calibration.disagreement,
        "covariance": calibration.covariance.tolist(),
        "views": [
            {
                "image": verdict.name,
                "used": verdict.used,
                "rms_px": verdict.rms,
                "remark": verdict.reason,
                "corners_left_out": len(verdict.left_out),
                "pose": pose,
            }
            for verdict, pose in zip(calibration.verdicts, board_poses(calibration), strict=True)
        ],
        "uncertainty": {
            "p95_px": known.p95,
            "median_px": known.median,
            "worst_px": known.worst,
            "target_px": target(model.width),
            "reached": enough,
        },
        "faults": found_faults(calibration.faults),
        "warnings": doubts,
    }


def board_poses(calibration: Calibration) -> list[BoardPoseEntry]:
    """List the poses of the board in every view, camera_from_board (figure 15)."""
    poses = calibration.poses
    vectors = scipy.spatial.transform.Rotation.from_matrix(poses.rotations).as_rotvec()
    return [
        {"rvec_rad": turn, "tvec_m": place, "sd_rotation_rad": sds[:3], "sd_translation_m": sds[3:]}
        for turn, place, sds in zip(
            vectors.tolist(), poses.translations.tolist(), calibration.pose_sds.tolist(), strict=True
        )
    ]


def camera_numbers(model: CameraModel, *, with_k3: bool = True) -> CameraNumbers:
    """A camera by its numbers."""
    numbers: CameraNumbers = {
        "image_size": [model.width, model.height],
        "fx": model.fx,
        "fy": model.fy,
        "cx": model.cx,
        "cy": model.cy,
        "k1": model.k1,
        "k2": model.k2,
        "p1": model.p1,
        "p2": model.p2,
    }
    return {**numbers, "k3": model.k3} if with_k3 else numbers


def correction_report(model: CameraModel) -> CorrectionReport:
    """The errors over the whole picture of Table 1's inverse and of the exact path."""
    table_1, exact = errors(model)
    return {"table_1": table_1, "exact": exact}


def laser_report(
    calibration: LaserCalibration, names: Sequence[str], board: Board, model: CameraModel
) -> LaserReport:
    """Everything there is to say about a mount's calibration."""
    found = calibration.extrinsics
    covariance = found.shown_covariance
    sds = np.sqrt(np.diag(covariance))
    where = landings(found, model)
    turn = scipy.spatial.transform.Rotation.from_matrix(found.transform.rotation @ OPTICAL.T)
    return {
        "rotation": found.transform.rotation.tolist(),
        "translation_m": found.transform.translation.tolist(),
        "turn_deg": turn.as_euler("xyz", degrees=True).tolist(),  # roll, pitch, yaw away from looking straight ahead
        "sd_rotation_deg": np.degrees(sds[:3]).tolist(),
        "sd_translation_m": sds[3:].tolist(),
        "axes": list(NAMES),
        "covariance": covariance.tolist(),
        "not_known": list(found.unknown),
        "from_ruler": found.from_ruler,
        "weak_directions": list(weak_words(found)),
        "poses_used": int(np.count_nonzero(calibration.used)),
        "poses_refused": [
            {"image": name, "reason": reason}
            for name, reason in zip(names, calibration.reasons, strict=True)
            if reason
        ],
        "poses": [
            {
                "image": name,
                "used": not reason,
                "beams": len(beams),
                "residual_rms_m": float(np.sqrt(np.mean(residuals**2))) if len(residuals) else None,
            }
            for name, reason, beams, residuals in zip(
                names, calibration.reasons, calibration.beams, calibration.residuals, strict=True
            )
        ],
        "residual_rms_m": calibration.residual_rms,
        "range_sd_m": calibration.range_sd,
        "chi2_per_freedom": found.misfit,
        "range_offset_m": None if found.offset is None else {"value": found.offset[0], "sd": found.offset[1]},
        "square_m": {"entered": board.square, "by_laser": calibration.square[0], "sd": calibration.square[1]},
        "square_words": square_words(calibration),
        "laser_offset": where,
        "laser_offset_words": laser_offset_words(where),
        "static_transform": static_transform(found.transform),
        "warnings": list(warnings(calibration, board)),
    }


def kept(
    model: CameraModel,
    *,
    board: Board | None = None,
    camera: CameraReport | None = None,
    laser: LaserCalibration | None = None,
) -> CalibrationFile:
    """Our own JSON file: the camera, the board, and where there is one the mount; with covariances and versions."""
    document: CalibrationFile = {
        "format": FORMAT_NAME,
        "version": FORMAT_VERSION,
        "software": {"opencv": cv2.__version__, "numpy": np.__version__},
        "camera": {**camera_entry(model)} if camera is None else _calibrated(model, camera),
    }
    if board is not None:
        document["board"] = {
            "inner_corners": [board.columns, board.rows],
            "square_m": board.square,
            "panel_m": None if board.panel is None else list(board.panel),
        }
    if laser is not None:
        document["extrinsics"] = mount_entry(laser.extrinsics)
    return document


def _calibrated(model: CameraModel, report: CameraReport) -> CalibratedCameraEntry:
    """The camera's entry with the part of its report that goes into its file."""
    return {
        **camera_entry(model),
        "free": list(report["sd"]),
        "sd": list(report["sd"].values()),
        "covariance": report["covariance"],
        "rms_px": report["rms_px"],
        "p95_uncertainty_px": report["uncertainty"]["p95_px"],
        "views_used": report["views_used"],
        "views_dropped": [
            {"name": view["image"], "why": view["remark"]} for view in report["views"] if not view["used"]
        ],
        "board_poses": [{"name": view["image"], **view["pose"]} for view in report["views"] if view["used"]],
    }
