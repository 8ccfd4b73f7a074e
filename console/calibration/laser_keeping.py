"""A laser session as plain values, and back."""

from __future__ import annotations

import numpy as np

from console.calibration.values import Told, board_of, camera_of
from core.calibration.board_line import MeanScan
from core.calibration.laser_session import LaserSession, TakenPose
from core.calibration.laser_solve import LaserPose
from core.calibration.mount import Mount
from core.calibration.planes import BoardPose, plane_of
from core.calibration.projection import Poses
from core.calibration.range_lines import unit_rays
from core.geometry import Transform
from core.message import Array


def mount_told(mount: Mount) -> Told:
    """What is known about the mount beforehand."""
    nominal = mount.nominal
    return {
        "rotation": nominal.rotation.tolist(),
        "translation_m": nominal.translation.tolist(),
        "spread": [float(sd) for sd in mount.spread],
    }


def mount_of(told: Told) -> Mount:
    """The other way."""
    nominal = Transform(rotation=np.array(told["rotation"]), translation=np.array(told["translation_m"]))
    return Mount(nominal=nominal, spread=tuple(told["spread"]))


def state_of(session: LaserSession) -> Told:
    """All that is needed to go on after a restart."""
    rooms: dict[bytes, Told] = {}  # each once
    taken: list[Told] = []
    for each in session.taken:
        room = each.pose.background
        key = b"" if room is None else room.tobytes()
        rooms.setdefault(key, {"number": len(rooms), "ranges_m": None if room is None else numbers(room)})
        taken.append(pose_told(each) | {"room": rooms[key]["number"]})
    return {
        "background": None if session.background is None else numbers(session.background),
        "rooms": [room["ranges_m"] for room in rooms.values()],
        "taken": taken,
    }


def resumed(board: Told, camera: Told, mount: Told, state: Told | None) -> LaserSession:
    """A session as `state_of` left it, to be solved anew."""
    session = LaserSession(board_of(board), camera_of(camera), mount_of(mount))
    if state is not None:
        background = state["background"]
        session.background = None if background is None else array(background)
        rooms = [None if room is None else array(room) for room in state.get("rooms", ())] or [session.background]
        session.taken = [pose_of(each, rooms[each.get("room", 0)]) for each in state["taken"]]
    return session


def pose_told(taken: TakenPose) -> Told:
    """A still pose of the board."""
    pose = taken.pose
    rays = pose.scan.rays
    return {
        "name": pose.name,
        "dropped": taken.dropped,
        "rotation": pose.board.rotation.tolist(),
        "translation_m": pose.board.translation.tolist(),
        "covariance": pose.board.covariance.tolist(),
        "rms_px": float(pose.board.rms),
        "bearings_rad": np.arctan2(rays[:, 1], rays[:, 0]).tolist(),
        "ranges_m": numbers(pose.scan.ranges),
        "range_sd_m": float(pose.scan.sd),
    }


def pose_of(told: Told, background: Array | None) -> TakenPose:
    """The other way."""
    rotation, translation = np.array(told["rotation"]), np.array(told["translation_m"])
    covariance = np.array(told["covariance"])
    board = BoardPose(
        rotation=rotation,
        translation=translation,
        covariance=covariance,
        rms=told["rms_px"],
        plane=plane_of(Poses(rotation[None], translation[None]), covariance),
    )
    rays = unit_rays(np.array(told["bearings_rad"]))
    scan = MeanScan(ranges=array(told["ranges_m"]), rays=rays, sd=told["range_sd_m"])
    return TakenPose(LaserPose(name=told["name"], board=board, scan=scan, background=background), told["dropped"])


def numbers(ranges: Array) -> list[float | None]:
    """Ranges (B,) [m]; what was not measured is None."""
    return [value if np.isfinite(value) else None for value in ranges.tolist()]


def array(told: list[float | None]) -> Array:
    """The other way; NaN where nothing was measured."""
    return np.array(told, dtype=float)
