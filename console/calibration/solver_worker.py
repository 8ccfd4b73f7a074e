"""Work that takes long or needs no memory: solving, straightening pictures, reading files."""

from typing import Any

import msgspec
import numpy as np

from console.calibration import answers
from console.calibration.camera_worker import read_grey
from console.calibration.codec import board_of
from console.calibration.laser_state import resumed
from console.messages.calibration import CalibrationBoard
from console.workers.job import job
from console.workers.pictures import jpeg
from core.calibration.camera.facts import known_facts
from core.calibration.camera.intrinsics import Calibration
from core.calibration.camera.session import CameraSession, CameraState
from core.calibration.camera.undistortion import exact_map, straighten
from core.calibration.exports import camera_exports, laser_exports
from core.calibration.files.camera_files import CAMERA_NAME, parse_camera, read_json
from core.calibration.files.mount_files import both_ways
from core.calibration.files.mount_reading import holds_mount, mount_doubts, parse_mount
from core.calibration.mount import Mount
from core.calibration.printed import equation_44
from core.calibration.reports import (
    CorrectionReport,
    camera_numbers,
    camera_report,
    correction_report,
    kept,
    laser_report,
)
from core.errors import BadInput
from core.optics import CameraModel
from core.sensors.camera import lens_faults

MAX_ARROWS = 800  # residuals shown at most
FROM_FILE = "Read from a file; how exact it is stands only in the file it came from."


class SolverWorker:
    """Remembers nothing from job to job."""

    @job
    def solve_camera(self, board: CalibrationBoard, state: bytes, *, printed: bool) -> answers.CameraSolution:
        """Solve a session; `printed`: with the coefficients as eq. 44 has them. Raises BadInput."""
        session = CameraSession.resumed(msgspec.json.decode(state, type=CameraState))
        session.board = board_of(board)
        names = [view.name for view in session.views]
        found = session.solve()
        report = camera_report(found)
        shown: answers.CameraSolutionReport = {
            **report,
            "views_refused": [
                {"image": each.name, "reason": each.reason} for each in found.verdicts if not each.used
            ],
            "residuals": residuals(found),
        }
        if printed:
            shown["eq_44"] = equation_44(found.model)
        return answers.CameraSolution(answers.SolvedCamera(found, names), shown, camera_exports(found, report))

    @job
    def solve_laser(
        self, board: CalibrationBoard, state: bytes, camera: CameraModel, mount: Mount, *, printed: bool
    ) -> answers.LaserSolution:
        """Solve a session; `printed`: by eq. 13. Raises BadInput."""
        session = resumed(board, camera, mount, state)
        names = [pose.name for pose in session.poses]
        found = session.solve(printed=printed)
        report = laser_report(found, names, session.board, session.model)
        exports = laser_exports(found, session.board, session.model)
        return answers.LaserSolution(answers.SolvedMount(found, names), report, exports)

    @job
    def correction(self, camera: CameraModel) -> CorrectionReport:
        """Measure how well Table 1's inverse and the exact one straighten this camera's pictures."""
        return correction_report(camera)

    @job
    def picture(self, content: bytes, camera: CameraModel | None) -> bytes:
        """A stored picture, JPEG or PNG → JPEG, straight where a camera is given. Raises BadInput."""
        grey, _ = read_grey(content)
        if camera is not None:
            if grey.shape != (camera.height, camera.width):
                raise BadInput("This picture has another size than the calibration.")
            grey = straighten(grey, exact_map(camera))
        return jpeg(grey)

    @job
    def read_file(self, text: str, camera: CameraModel | None) -> answers.ImportedCamera | answers.ImportedMount:
        """Read a camera's or a mount's file of any form. Raises BadInput.

        A mount belongs to a camera: the one in its own file, else `camera`, which is in use.
        """
        if not holds_mount(text):
            return imported_camera(text)
        mount = parse_mount(text)
        own = read_json(text) if text.lstrip().startswith("{") else {}
        if "camera" in own:
            model = parse_camera(text)
        elif camera is not None:
            model = camera
        else:
            raise BadInput("A mount belongs to a camera: calibrate the camera first, or bring the camera's file.")
        entry: Any = own.get("extrinsics", {**both_ways(mount)})
        if not isinstance(entry, dict):
            raise BadInput("It holds no mount.")
        lens = [one.sentence for one in lens_faults(CAMERA_NAME, model)]
        return answers.ImportedMount(
            kept(model),
            entry,
            {
                "rotation": mount.rotation.tolist(),
                "translation_m": mount.translation.tolist(),
                "warnings": [FROM_FILE, *mount_doubts(mount), *lens],
            },
        )


def imported_camera(text: str) -> answers.ImportedCamera:
    """The text of a camera's file → the camera and what is known about it. Raises BadInput."""
    model = parse_camera(text)
    document = kept(model)
    report: answers.ImportedCameraReport = {
        **camera_numbers(model),
        "warnings": [FROM_FILE, *(one.sentence for one in lens_faults(CAMERA_NAME, model))],
    }
    known, board = known_facts(text)
    document["camera"] = {**document["camera"], **known}
    if board is not None:
        document["board"] = board
    if "free" in known and "sd" in known:
        report["sd"] = dict(zip(known["free"], known["sd"], strict=True))
    return answers.ImportedCamera(document, report)


def residuals(found: Calibration) -> list[list[float]]:
    """Return the seen corners and by how much they miss: rows of u, v, du, dv [pixel], thinned."""
    used = found.corners.used
    rows = np.concatenate((found.corners.pixels[used], found.residuals[used]), axis=1)
    step = -(-len(rows) // MAX_ARROWS)
    return np.round(rows[::step], 3).tolist()
