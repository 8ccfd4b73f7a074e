"""Calibrate from a recording: what `calibrate camera RECORDING` and `calibrate laser RECORDING` do."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.quality import judge
from core.calibration.board.session import Watcher
from core.calibration.camera.session import CameraSession
from core.calibration.files.camera_files import read_camera
from core.calibration.laser.board_line import average
from core.calibration.laser.planes import board_pose
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.solve import LaserPose
from core.calibration.mount import Mount
from core.calibration.reports import CameraFilesReport, LaserFilesReport, RefusedPicture
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import CameraModel
from core.pipelines.calibrate import LookedAtViews, camera_from, mount_from
from core.progress import UNSEEN, WorkProgress
from core.recording.read_report import ReadReport
from core.recording.recorded_senses import RecordedImage, sights
from core.recording.recording import LogSettings
from core.sensors.camera import lens_faults
from core.sensors.laser import Scan

# Criteria of a board that is held still.
MAX_MOTION_PX = 0.7  # [pixel] mean motion of the corners between pictures, per 640 pixels of width
MAX_DRIFT_PX = 2.0  # [pixel] from the first picture of a pose, and between poses that count as different
MAX_PICTURE_GAP_S = 1.0  # [s] between pictures of one pose at most
MIN_SCAN_COUNT = 3
MAX_SCAN_COUNT = 60
USUAL_RANGE_QUANTILE = 0.75  # quantile of a beam's ranges over the whole recording that is taken for the empty room


@dataclass
class _Still:
    """Pictures in a row that show the board at one place."""

    stamps: list[float]  # [s]
    corners: list[Array]  # (N, 2) [pixel] each


@dataclass
class StillPoses:
    """Collects a stream; `poses` when it has ended. Owned by one thread."""

    board: Board
    model: CameraModel
    pictures: int = 0
    seen: int = 0  # pictures that show the board

    def __post_init__(self) -> None:
        self._watcher = Watcher(self.board)
        self._stills: list[_Still] = []
        self._open: _Still | None = None
        self._scans: list[tuple[float, Array]] = []
        self._bearings = np.empty(0)

    def look(self, stamp: float, grey: Array) -> None:
        """One picture (H, W) uint8 taken at `stamp` [s]. Raises BadInput where the camera file is for other ones."""
        if grey.shape != (self.model.height, self.model.width):
            raise BadInput(
                f"The pictures are {grey.shape[1]}x{grey.shape[0]}, the camera file is for "
                f"{self.model.width}x{self.model.height}."
            )
        self.pictures += 1
        view = self._watcher.look(grey)
        self.seen += view is not None
        still = self._open
        if view is None or judge(grey, view, self.board).refusals:
            self._open = None
        elif still is None or stamp - still.stamps[-1] > MAX_PICTURE_GAP_S or not self._same(still, view.corners):
            self._open = _Still([stamp], [view.corners])
            self._stills.append(self._open)
        else:
            still.stamps.append(stamp)
            still.corners.append(view.corners)

    def sweep(self, scan: Scan) -> None:
        """One scan. Those with other beams than the first are left out."""
        if not len(self._bearings):
            self._bearings = scan.angles
        if len(scan.ranges) == len(self._bearings):
            self._scans.append((scan.stamp, np.where(scan.valid, scan.ranges, np.nan).astype(np.float32)))

    def poses(self) -> tuple[list[LaserPose], list[RefusedPicture], Array | None]:
        """The still poses, those that cannot be used with the reason, and the empty room (B,) [m] if it is known."""
        found: list[LaserPose] = []
        refused: list[RefusedPicture] = []
        taken: list[Array] = []
        times = np.array([stamp for stamp, _ in self._scans])
        start = min([still.stamps[0] for still in self._stills], default=0.0)
        for still in self._stills:
            if len(still.stamps) < 2:
                continue
            name = f"{still.stamps[0] - start:.1f} s"
            inside = np.flatnonzero((times >= still.stamps[0]) & (times <= still.stamps[-1]))
            corners = np.mean(still.corners, axis=0)
            if len(inside) < MIN_SCAN_COUNT:
                refused.append({"image": name, "reason": f"only {len(inside)} scans while the board was still"})
            elif any(self._apart(corners, each) < MAX_DRIFT_PX for each in taken):
                refused.append({"image": name, "reason": "the board stands where it stood before"})
            else:
                taken.append(corners)
                scans = np.array([self._scans[each][1] for each in inside[:MAX_SCAN_COUNT]], float)
                board = board_pose(self.model, self.board, corners)
                found.append(LaserPose(name=name, board=board, scan=average(scans, unit_rays(self._bearings))))
        return found, refused, self._empty_room() if found else None

    def _same(self, still: _Still, corners: Array) -> bool:
        moved, drifted = self._apart(corners, still.corners[-1]), self._apart(corners, still.corners[0])
        return moved <= MAX_MOTION_PX and drifted <= MAX_DRIFT_PX

    def _apart(self, corners: Array, others: Array) -> float:
        return self._watcher.apart(corners, others, self.model.width)

    def _empty_room(self) -> Array:
        """(B,) [m]: how far every beam usually reaches."""
        every = np.array([ranges for _, ranges in self._scans[:: max(1, len(self._scans) // 400)]], float)
        measured = np.isfinite(every).any(axis=0)
        room = np.full(every.shape[1], np.nan)
        room[measured] = np.nanquantile(every[:, measured], USUAL_RANGE_QUANTILE, axis=0)
        return room


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
        poses,
        refused,
        board,
        model,
        background,
        faults=lens_faults(camera.name, model),
        mount=mount,
        with_offset=with_offset,
        out=out,
        printed=printed,
    )
    result["warnings"] = warnings + result["warnings"]
    return result
