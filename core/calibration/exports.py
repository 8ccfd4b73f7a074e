"""A calibration as files, in every form that other programs read: for the command line and for the page."""

import json

from core.calibration.board.board import Board
from core.calibration.camera.intrinsics import Calibration
from core.calibration.files.camera_files import kalibr_yaml, opencv_yaml, ros_yaml
from core.calibration.files.mount_files import matrix, static_transform, urdf_joint
from core.calibration.laser.solve import LaserCalibration
from core.calibration.reports import CameraReport, kept
from core.optics import CameraModel

Exports = dict[str, tuple[str, str]]  # form → file name, text


def camera_exports(found: Calibration, report: CameraReport) -> Exports:
    """Every form of a camera's file; Kalibr's has no k3."""
    model, board = found.model, found.board
    exports: Exports = {
        "ros": ("camera.yaml", ros_yaml(model)),
        "opencv": (
            "camera_opencv.yml",
            opencv_yaml(model, board=(board.columns, board.rows, board.square), rms=found.rms),
        ),
        "json": ("camera.json", json.dumps(kept(model, board=board, camera=report), indent=1)),
    }
    if model.k3 == 0:
        exports["kalibr"] = ("camera_kalibr.yaml", kalibr_yaml(model))
    return exports


def laser_exports(found: LaserCalibration, board: Board, camera: CameraModel) -> Exports:
    """Every form of a mount's file."""
    transform = found.extrinsics.transform
    both = {
        "laser_from_camera": matrix(transform).tolist(),
        "camera_from_laser": matrix(transform.inverse()).tolist(),
    }
    return {
        "json": ("mount.json", json.dumps(kept(camera, board=board, laser=found), indent=1)),
        "urdf": ("mount.urdf.xml", urdf_joint(transform)),
        "static_transform": ("mount.sh", static_transform(transform) + "\n"),
        "matrix": ("mount_matrix.json", json.dumps(both, indent=1)),
    }
