"""Calibrate from a recording: what `calibrate camera RECORDING` and `calibrate laser RECORDING` do."""

from pathlib import Path

from core.calibration.board.board import Board
from core.calibration.camera.session import CameraSession
from core.calibration.files.camera_files import read_camera
from core.calibration.laser.still_poses import StillPoses
from core.calibration.mount import Mount
from core.calibration.reports import CameraFilesReport, LaserFilesReport, RefusedPicture
from core.errors import BadInput, Refused
from core.pipelines.calibrate import LookedAtViews, camera_from, mount_from
from core.progress import UNSEEN, WorkProgress
from core.recording.read_report import ReadReport
from core.recording.recorded_senses import RecordedImage, sights
from core.recording.recording import LogSettings

MAX_REASONS = 20  # for pictures that were not used


def calibrate_camera_recorded(
    path: Path, board: Board, out: Path | None = None, progress: WorkProgress = UNSEEN, *, printed: bool = False
) -> CameraFilesReport:
    """A recording in which the board is held still now and then → the camera as JSON keys; with `out`, files.

    The views are those that the wizard would have taken: sharp, still and new. Raises BadInput.
    """
    settings, tally = LogSettings(), ReadReport(path)
    session, pictures, refused = CameraSession(board, still_for=0.0), 0, dict[str, RefusedPicture]()
    for found in sights(path, settings, tally, progress=progress):
        if not isinstance(found, RecordedImage):
            continue
        pictures += 1
        try:
            verdict = session.look(found.grey, found.stamp)
        except Refused:
            break  # more views than are needed
        if verdict.kind in ("nothing", "refused"):
            refused[verdict.words] = {"image": f"{path.name}, picture {pictures}", "reason": verdict.words}
    warnings = list(tally.report("recording").warnings)
    if not pictures:
        raise BadInput(" ".join((f"{path.name} holds no pictures.", *warnings[:1])))
    size = session.size or (0, 0)
    looked = LookedAtViews(list(session.views), list(refused.values())[:MAX_REASONS], (), warnings, size)
    return camera_from(looked, pictures, board, out, printed=printed)


def calibrate_laser_recorded(
    path: Path,
    camera: Path,
    board: Board,
    out: Path | None = None,
    *,
    height: float | None = None,
    with_offset: bool = False,
    progress: WorkProgress = UNSEEN,
    printed: bool = False,
) -> LaserFilesReport:
    """A recording in which the board is held still now and then → the mount as JSON keys; with `out`, files.

    `height` [m] of the camera above the laser, by ruler, for upright boards. `printed`: by eq. 13. Raises BadInput.
    """
    settings, model = LogSettings(), read_camera(camera)
    tally, collected, scans = ReadReport(path), StillPoses(board, model), 0
    for found in sights(path, settings, tally, progress=progress):
        if isinstance(found, RecordedImage):
            collected.look(found.stamp, found.grey)
        elif scans * found.ranges.nbytes < settings.most_readings:
            scans += 1
            collected.sweep(found)
    warnings = list(tally.report("recording").warnings)
    if not collected.pictures or not scans:
        what = "pictures" if scans else ("laser scans" if collected.pictures else "pictures and no laser scans")
        raise BadInput(" ".join((f"{path.name} holds no {what}.", *warnings[:1])))
    if not collected.seen:
        raise BadInput(f"None of the {collected.pictures} pictures in {path.name} shows a {board.name} board.")
    poses, refused, background = collected.poses()
    mount = None if height is None else Mount.measured(height)
    result = mount_from(
        poses, refused, board, model, background, mount=mount, with_offset=with_offset, out=out, printed=printed
    )
    result["warnings"] = warnings + result["warnings"]
    return result
