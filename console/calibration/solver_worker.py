"""Work that takes long or needs no memory: solving, straightening pictures, reading files."""

from __future__ import annotations

import json
import pickle

import numpy as np

from console.calibration.camera_worker import read
from console.calibration.codec import Fields, board_of, camera_of, jpeg
from console.calibration.laser_worker import resumed
from core.calibration.board.board import Board
from core.calibration.camera.facts import PARAMETERS, known_facts
from core.calibration.camera.intrinsics import Calibration
from core.calibration.camera.session import CameraSession
from core.calibration.camera.undistortion import exact_map, straighten
from core.calibration.files.camera_files import kalibr_yaml, opencv_yaml, parse_camera, read_json, ros_yaml
from core.calibration.files.mount_files import both_ways, matrix, static_transform, urdf_joint
from core.calibration.files.mount_reading import holds_mount, parse_mount
from core.calibration.laser.solve import LaserCalibration
from core.calibration.reports import camera_report, correction_report, kept, laser_report
from core.errors import BadInput

ARROWS = 800  # residuals shown at most
FROM_FILE = "Read from a file; how exact it is stands only in the file it came from."

Exports = dict[str, list[str]]  # form → file name, text


class SolverWorker:
    """Remembers nothing from job to job."""

    def solve_camera(self, board: Fields, state: Fields) -> Fields:
        """A session's state → its solution: to be adopted, to be shown, to be taken away. Raises BadInput."""
        session = CameraSession.resumed(state)
        session.board = board_of(board)
        names = [view.name for view in session.views]
        found = session.solve()
        report = camera_report(found)
        report["views_refused"] = [
            {"image": each.name, "reason": each.reason} for each in found.verdicts if not each.used
        ]
        exports = camera_exports(found, report)
        report["residuals"] = residuals(found)
        return {"calibration": pickle.dumps(found), "names": names, "report": report, "exports": exports}

    def solve_laser(self, board: Fields, camera: Fields, mount: Fields, state: Fields) -> Fields:
        """Likewise for the laser."""
        session = resumed(board, camera, mount, state)
        names = [pose.name for pose in session.poses]
        found = session.solve()
        report = laser_report(found, names, session.board, session.model)
        exports = laser_exports(found, session.board, camera)
        return {"calibration": pickle.dumps(found), "names": names, "report": report, "exports": exports}

    def correction(self, camera: Fields) -> Fields:
        """The errors of Table 1's inverse and of the exact one."""
        return correction_report(camera_of(camera))

    def picture(self, content: bytes, camera: Fields | None) -> bytes:
        """A kept picture as JPEG, straight where a camera is given. Raises BadInput."""
        grey, _ = read(content)
        if camera is not None:
            model = camera_of(camera)
            if grey.shape != (model.height, model.width):
                raise BadInput("This picture has another size than the calibration.")
            grey = straighten(grey, exact_map(model))
        return jpeg(grey)

    def read_file(self, text: str, camera: Fields | None) -> Fields:
        """A camera's or a mount's file in any form → which it is, how it is kept, and what is known about it.

        A mount belongs to a camera: the one in its own file, else `camera`, which is in use. Raises BadInput.
        """
        if not holds_mount(text):
            return {"kind": "camera", **self._camera_file(text)}
        mount = parse_mount(text)
        own = read_json(text) if text.lstrip().startswith("{") else {}
        if "camera" not in own and camera is None:
            raise BadInput("A mount belongs to a camera: calibrate the camera first, or bring the camera's file.")
        model = parse_camera(text) if "camera" in own else camera_of(camera or {})
        entry = own["extrinsics"] if "extrinsics" in own else both_ways(mount)
        report = {
            "rotation": mount.rotation.tolist(),
            "translation_m": mount.translation.tolist(),
            "warnings": [FROM_FILE],
        }
        return {"kind": "laser", "document": {**kept(model, "camera"), "extrinsics": entry}, "report": report}

    def _camera_file(self, text: str) -> Fields:
        model = parse_camera(text)
        document = kept(model, "camera")
        report: Fields = {"image_size": [model.width, model.height], **parameters(model)}
        report["warnings"] = [FROM_FILE]
        known, board = known_facts(text)
        document["camera"] |= known
        if board is not None:
            document["board"] = board
        return {"document": document, "report": report | sds(document["camera"])}


def parameters(model: object) -> Fields:
    """fx … k3 by name."""
    return {name: getattr(model, name) for name in PARAMETERS}


def sds(entry: Fields) -> Fields:
    """Standard deviations by name, where they are known."""
    return {"sd": dict(zip(entry["free"], entry["sd"], strict=True))} if "sd" in entry else {}


def camera_exports(found: Calibration, report: Fields) -> Exports:
    """Every form of a camera's file; Kalibr's has no k3."""
    board = found.board
    document = kept(found.model, "camera", board=board, camera=report)
    exports: Exports = {
        "ros": ["camera.yaml", ros_yaml(found.model)],
        "opencv": [
            "camera_opencv.yml",
            opencv_yaml(found.model, board=(board.columns, board.rows, board.square), rms=found.rms),
        ],
        "json": ["camera.json", json.dumps(document, indent=1)],
    }
    if found.model.k3 == 0:
        exports["kalibr"] = ["camera_kalibr.yaml", kalibr_yaml(found.model)]
    return exports


def laser_exports(found: LaserCalibration, board: Board, camera: Fields) -> Exports:
    """Every form of a mount's file."""
    transform = found.extrinsics.transform
    both = {
        "laser_from_camera": matrix(transform).tolist(),
        "camera_from_laser": matrix(transform.inverse()).tolist(),
    }
    document = kept(camera_of(camera), "camera", board=board, laser=found)
    return {
        "json": ["mount.json", json.dumps(document, indent=1)],
        "urdf": ["mount.urdf.xml", urdf_joint(transform)],
        "static_transform": ["mount.sh", static_transform(transform) + "\n"],
        "matrix": ["mount_matrix.json", json.dumps(both, indent=1)],
    }


def residuals(found: Calibration) -> list[list[float]]:
    """Return the seen corners and by how much they miss: rows of u, v, du, dv [pixel], thinned."""
    used = found.corners.used
    rows = np.concatenate((found.corners.pixels[used], found.residuals[used]), axis=1)
    step = -(-len(rows) // ARROWS)
    return np.round(rows[::step], 3).tolist()
