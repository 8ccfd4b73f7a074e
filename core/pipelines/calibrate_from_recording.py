"""The camera's mount from a recording with pictures and scans: what `calibrate laser RECORDING` does."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from core.calibration.board.board import Board
from core.calibration.files.camera_files import read_camera
from core.calibration.laser.still_poses import StillPoses
from core.calibration.mount import Mount
from core.calibration.reports import LaserFilesReport
from core.errors import BadInput
from core.pipelines.calibrate import mount_from
from core.recording.images_and_scans import RecordedImage, sights
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings

TELL_EVERY = 100  # pictures


def calibrate_laser_recorded(
    path: Path,
    camera: Path,
    board: Board,
    out: Path | None = None,
    *,
    height: float | None = None,
    with_offset: bool = False,
    say: Callable[[str], None],
    settings: LogSettings | None = None,
    printed: bool = False,
) -> LaserFilesReport:
    """A recording in which the board is held still now and then → the mount as JSON keys; with `out`, files.

    `height` [m] of the camera above the laser, by ruler, for upright boards. `printed`: by eq. 13. Raises BadInput.
    """
    settings, model = settings or LogSettings(), read_camera(camera)
    tally, collected, scans = ReadReport(path), StillPoses(board, model), 0
    for found in sights(path, settings, tally):
        if isinstance(found, RecordedImage):
            collected.look(found.stamp, found.grey)
            if collected.pictures % TELL_EVERY == 1:
                say(f"picture {collected.pictures}: {collected.seen} have shown the board")
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
