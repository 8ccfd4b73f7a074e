"""A laser's session as it is stored: all that is needed to go on after a restart."""

from __future__ import annotations

import msgspec
import numpy as np

from console.calibration.answers import Rows
from console.calibration.codec import board_of
from console.messages.calibration import CalibrationBoard
from core.calibration.laser.board_line import MeanScan
from core.calibration.laser.planes import BoardPose, plane_of
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.session import LaserSession, TakenPose
from core.calibration.laser.solve import LaserPose
from core.calibration.mount import Mount
from core.calibration.projection import Poses
from core.message import Array
from core.optics import CameraModel

Ranges = list[float | None]  # [m] None where nothing was measured


class StoredPose(msgspec.Struct, frozen=True):
    name: str
    dropped: bool
    rotation: Rows
    translation_m: list[float]
    covariance: Rows
    rms_px: float
    bearings_rad: list[float]
    ranges_m: Ranges
    range_sd_m: float
    room: int = 0  # number of the empty room that it was seen in

    @classmethod
    def of(cls, taken: TakenPose, room: int) -> StoredPose:
        pose = taken.pose
        rays = pose.scan.rays
        return cls(
            name=pose.name,
            dropped=taken.dropped,
            rotation=pose.board.rotation.tolist(),
            translation_m=pose.board.translation.tolist(),
            covariance=pose.board.covariance.tolist(),
            rms_px=float(pose.board.rms),
            bearings_rad=np.arctan2(rays[:, 1], rays[:, 0]).tolist(),
            ranges_m=ranges_of(pose.scan.ranges),
            range_sd_m=float(pose.scan.sd),
            room=room,
        )

    def taken(self, background: Array | None) -> TakenPose:
        rotation, translation = np.array(self.rotation), np.array(self.translation_m)
        covariance = np.array(self.covariance)
        board = BoardPose(
            rotation=rotation,
            translation=translation,
            covariance=covariance,
            rms=self.rms_px,
            plane=plane_of(Poses(rotation[None], translation[None]), covariance),
        )
        rays = unit_rays(np.array(self.bearings_rad))
        scan = MeanScan(ranges=array_of(self.ranges_m), rays=rays, sd=self.range_sd_m)
        return TakenPose(LaserPose(name=self.name, board=board, scan=scan, background=background), self.dropped)


class LaserState(msgspec.Struct, frozen=True):
    background: Ranges | None  # the empty room
    rooms: list[Ranges | None] = []  # the empty rooms of the poses, each once
    taken: list[StoredPose] = []

    @classmethod
    def of(cls, session: LaserSession) -> LaserState:
        numbers: dict[bytes, int] = {}
        rooms: list[Ranges | None] = []
        taken: list[StoredPose] = []
        for each in session.taken:
            room = each.pose.background
            key = b"" if room is None else room.tobytes()
            if key not in numbers:
                numbers[key] = len(rooms)
                rooms.append(None if room is None else ranges_of(room))
            taken.append(StoredPose.of(each, numbers[key]))
        return cls(None if session.background is None else ranges_of(session.background), rooms, taken)


def resumed(board: CalibrationBoard, camera: CameraModel, mount: Mount, state: bytes) -> LaserSession:
    """A session as its state was stored (JSON), to be solved again."""
    session = LaserSession(board_of(board), camera, mount)
    stored = msgspec.json.decode(state, type=LaserState | None)
    if stored is not None:
        session.background = None if stored.background is None else array_of(stored.background)
        rooms = [None if room is None else array_of(room) for room in stored.rooms] or [session.background]
        session.taken = [each.taken(rooms[each.room]) for each in stored.taken]
    return session


def ranges_of(ranges: Array) -> Ranges:
    """Ranges (B,) [m] → numbers."""
    return [value if np.isfinite(value) else None for value in ranges.tolist()]


def array_of(ranges: Ranges) -> Array:
    """Numbers → ranges (B,) [m]; NaN where nothing was measured."""
    return np.array(ranges, dtype=float)
