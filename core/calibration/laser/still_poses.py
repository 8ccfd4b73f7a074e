"""Still poses of the board in a stream of unselected pictures and scans, as in a recording."""

from dataclasses import dataclass

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.quality import judge
from core.calibration.board.tracking import Watcher
from core.calibration.laser.board_line import average
from core.calibration.laser.planes import board_pose
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.solve import LaserPose
from core.calibration.reports import RefusedPicture
from core.errors import BadInput
from core.message import Array
from core.optics import CameraModel
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
            ranges = np.where(scan.valid, scan.ranges, np.nan)
            self._scans.append((scan.stamp, ranges.astype(np.float32)))

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
