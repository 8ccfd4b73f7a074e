"""The laser's session, as a worker holds it."""

from __future__ import annotations

import pickle

import numpy as np

from console.calibration.codec import (
    OTHER_VIEWS,
    SMALL,
    Fields,
    advice_fields,
    board_of,
    camera_of,
    grey_of,
    jpeg,
    png,
    points,
)
from core.calibration.board.board import Board
from core.calibration.laser.board_line import MeanScan, find_lines, foreground
from core.calibration.laser.explanation import weak_words
from core.calibration.laser.planes import BoardPose, plane_of
from core.calibration.laser.proof import check, dots
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.session import LaserSession, LaserVerdict, TakenPose
from core.calibration.laser.solve import LaserPose
from core.calibration.mount import Mount
from core.calibration.projection import Poses
from core.calibration.reports import kept, laser_report
from core.errors import BadInput, Refused
from core.geometry import Transform
from core.message import Array
from core.optics import TABLE_3
from core.sensors.laser import Scan


def mount_fields(mount: Mount) -> Fields:
    """The prior knowledge of the mount, as fields."""
    nominal = mount.nominal
    return {
        "rotation": nominal.rotation.tolist(),
        "translation_m": nominal.translation.tolist(),
        "spread": [float(sd) for sd in mount.spread],
    }


def mount_of(fields: Fields) -> Mount:
    """Fields → the prior knowledge of the mount."""
    nominal = Transform(rotation=np.array(fields["rotation"]), translation=np.array(fields["translation_m"]))
    return Mount(nominal=nominal, spread=tuple(fields["spread"]))


def state_of(session: LaserSession) -> Fields:
    """All that is needed to go on after a restart."""
    rooms: dict[bytes, Fields] = {}  # each once
    taken: list[Fields] = []
    for each in session.taken:
        room = each.pose.background
        key = b"" if room is None else room.tobytes()
        rooms.setdefault(key, {"number": len(rooms), "ranges_m": None if room is None else numbers(room)})
        taken.append(pose_fields(each) | {"room": rooms[key]["number"]})
    return {
        "background": None if session.background is None else numbers(session.background),
        "rooms": [room["ranges_m"] for room in rooms.values()],
        "taken": taken,
    }


def resumed(board: Fields, camera: Fields, mount: Fields, state: Fields | None) -> LaserSession:
    """A session as `state_of` left it, to be solved again."""
    session = LaserSession(board_of(board), camera_of(camera), mount_of(mount))
    if state is not None:
        background = state["background"]
        session.background = None if background is None else array(background)
        rooms = [None if room is None else array(room) for room in state.get("rooms", ())] or [session.background]
        session.taken = [pose_of(each, rooms[each.get("room", 0)]) for each in state["taken"]]
    return session


def pose_fields(taken: TakenPose) -> Fields:
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


def pose_of(fields: Fields, background: Array | None) -> TakenPose:
    """Fields → a still pose of the board."""
    rotation, translation = np.array(fields["rotation"]), np.array(fields["translation_m"])
    covariance = np.array(fields["covariance"])
    board = BoardPose(
        rotation=rotation,
        translation=translation,
        covariance=covariance,
        rms=fields["rms_px"],
        plane=plane_of(Poses(rotation[None], translation[None]), covariance),
    )
    rays = unit_rays(np.array(fields["bearings_rad"]))
    scan = MeanScan(ranges=array(fields["ranges_m"]), rays=rays, sd=fields["range_sd_m"])
    return TakenPose(LaserPose(name=fields["name"], board=board, scan=scan, background=background), fields["dropped"])


def numbers(ranges: Array) -> list[float | None]:
    """Ranges (B,) [m] → numbers; None where nothing was measured."""
    return [value if np.isfinite(value) else None for value in ranges.tolist()]


def array(values: list[float | None]) -> Array:
    """Values → ranges (B,) [m]; NaN where nothing was measured."""
    return np.array(values, dtype=float)


LIVE_SD = 0.01  # [m] of a single range, for the line that is shown live


class LaserWorker:
    """One laser session. Every method answers what has changed: `parts` of the session as the page gets it."""

    def __init__(self) -> None:
        self._session = LaserSession(Board(columns=9, rows=6, square=0.03), TABLE_3)
        self._grey: Array | None = None
        self._scan: Scan | None = None
        self._beams = np.empty(0, int)  # of the newest scan that end on the board
        self._solved: tuple[str, ...] = ()  # names of the poses in the solution

    def open(
        self,
        board: Fields,
        state: Fields | None,
        calibration: bytes | None,
        names: list[str],
        camera: Fields,
        mount: Fields,
    ) -> Fields:
        """Begin, or go on where `state` ended; `calibration` is the solution of the poses `names`."""
        self._session = resumed(board, camera, mount, state)
        self._session.board = board_of(board)
        return self._answer(changed=True) if calibration is None else self.adopt(calibration, names)

    def look(self, pixels: bytes, width: int, height: int, stamp: float) -> Fields:
        """A live picture of the robot."""
        grey, model = grey_of(pixels, width, height), self._session.model
        if grey.shape != (model.height, model.width):
            raise BadInput(
                f"This picture is {width}x{height}, the camera in use is for {model.width}x{model.height}; "
                "calibrate the camera at this size first."
            )
        self._grey = grey
        return self._answer(verdict=self._session.look(grey, stamp))

    def sweep(
        self, ranges: bytes, angle_min: float, angle_step: float, range_min: float, range_max: float, stamp: float
    ) -> Fields:
        """A scan of the robot."""
        scan = Scan(
            stamp=stamp,
            ranges=np.frombuffer(ranges),
            angle_min=angle_min,
            angle_step=angle_step,
            range_min=range_min,
            range_max=range_max,
        )
        empty, first = self._session.background is None, self._scan is None
        verdict = self._session.sweep(scan)
        self._scan, self._beams = scan, self._on_board(scan)
        counted = verdict is not None and verdict.kind == "counted"
        room_new = empty and self._session.background is not None
        answer = self._answer(changed=counted or room_new or first, verdict=verdict)
        answer["parts"]["scan"] = self._shown(scan)
        answer["room_known"] = self._session.background is not None
        if verdict is not None and counted and self._grey is not None:
            answer["kept"] = {
                "name": verdict.name,
                "picture": png(self._grey),
                "small": jpeg(self._grey, SMALL),
            }
            answer["parts"]["check"] = self._check()
        return answer

    def forget_room(self) -> Fields:
        """Look at the empty room again: the robot has moved, or a person stood in the room. Poses stay."""
        self._session.forget_room()
        words = "The empty room is looked at again: step out of the laser's view."
        return self._answer(changed=True, verdict=LaserVerdict(kind="background", words=words))

    def drop(self, name: str) -> Fields:
        """Leave a pose out."""
        self._session.drop(name)
        return self._answer(changed=True)

    def restore(self, name: str) -> Fields:
        """Take it back in."""
        self._session.restore(name)
        return self._answer(changed=True)

    def skip(self) -> Fields:
        """Another suggestion."""
        self._session.skip()
        return self._answer(changed=True)

    def adopt(self, calibration: bytes, names: list[str]) -> Fields:
        """A solution of the solver worker, of the poses of these names."""
        poses = tuple(each.pose for each in self._session.taken if each.pose.name in names)
        self._session.adopt(pickle.loads(calibration), poses)
        self._solved = tuple(pose.name for pose in poses)
        return self._answer(changed=True)

    def accept(self, force: bool) -> Fields:
        """The mount as it is kept. Raises Refused with the reason."""
        session = self._session
        if not force:
            session.accept()
        found, names = session.calibration, [pose.name for pose in session.poses]
        if found is None or session.stale:
            raise Refused(session.progress().words)
        if self._solved != tuple(names):
            raise Refused(OTHER_VIEWS)
        if found.extrinsics.unknown:
            raise Refused(weak_words(found.extrinsics)[0])
        document = kept(session.model, "camera", board=session.board, laser=found)
        return {"document": document, "report": laser_report(found, names, session.board, session.model)}

    def refresh(self) -> Fields:
        """All of it, as it is."""
        return self._answer(changed=True)

    def _answer(self, *, changed: bool = False, verdict: LaserVerdict | None = None) -> Fields:
        session = self._session
        parts: Fields = {"size": (session.model.width, session.model.height)}
        if verdict is not None:
            parts["verdict"] = {
                "kind": verdict.kind,
                "words": verdict.words,
                "name": verdict.name,
                "corners": None if verdict.corners is None else points(verdict.corners),
                "laser": self._dots(),
                "beams": None if verdict.beams is None else verdict.beams.tolist(),
            }
        if not changed:
            return {"parts": parts}
        parts |= self._slow_parts()
        names = [pose.name for pose in session.poses]
        return {"parts": parts, "state": state_of(session), "stale": session.stale, "names": names}

    def _slow_parts(self) -> Fields:
        progress = self._session.progress()
        return {
            "advice": advice_fields(self._session.advice()),
            "progress": {
                "views": progress.poses,
                "ready": progress.ready,
                "words": progress.words,
                "precision": progress.precision,
                "weak": list(progress.weak),
                "laser_offset": progress.laser_offset,
                "from_ruler": progress.from_ruler,
                "known_from": progress.known_from,
            },
            "views": self._views(),
        }

    def _views(self) -> list[Fields]:
        """Every pose and how well it fits, the worst first."""
        session, found = self._session, self._session.calibration
        fits: dict[str, tuple[str, Array]] = {}
        if found is not None:
            fits = dict(zip(self._solved, zip(found.reasons, found.residuals, strict=True), strict=True))
        rows: list[Fields] = []
        for each in session.taken:
            reason, residuals = fits.get(each.pose.name, ("", np.empty(0)))
            known = each.pose.name in fits and not each.dropped
            rows.append(
                {
                    "name": each.pose.name,
                    "dropped": each.dropped,
                    "rms_m": float(np.sqrt(np.mean(residuals**2))) if len(residuals) else None,
                    "used": not reason if known else None,
                    "reason": reason,
                }
            )
        return sorted(rows, key=lambda row: -(row["rms_m"] or 0.0))

    def _on_board(self, scan: Scan) -> Array:
        """Numbers (K,) of the beams that end on the board now, as far as they differ from the empty room."""
        background = self._session.background
        if background is None:
            return np.empty(0, int)
        ranges = np.where(scan.valid, scan.ranges, np.nan)
        mean = MeanScan(ranges=ranges, rays=unit_rays(scan.angles), sd=LIVE_SD)
        lines = find_lines(mean, foreground(mean, background, self._session.settings.solve.line), self._session.board)
        return lines[0].beams if lines else np.empty(0, int)

    def _dots(self) -> list[tuple[float, float, float, bool]]:
        """The newest scan in the picture, by the mount as it is known: u, v [pixel], range [m], on the board."""
        scan, session = self._scan, self._session
        if scan is None:
            return []
        found = session.calibration
        mount = session.mount.nominal if found is None else found.extrinsics.transform
        pixels, beams = dots(scan, mount, session.model)
        board = np.isin(beams, self._beams)
        return [(u, v, r, bool(on)) for (u, v, r), on in zip(points(pixels, 2), board.tolist(), strict=True)]

    def _shown(self, scan: Scan) -> Fields:
        """The newest scan from above, with the empty room and the board's part."""
        rays = unit_rays(scan.angles)[:, :2]
        beams = np.flatnonzero(scan.valid)
        background = self._session.background
        room = np.empty((0, 2)) if background is None else (rays * background[:, None])[np.isfinite(background)]
        return {
            "points": points(rays[beams] * scan.ranges[beams, None], 3),
            "background": points(room, 3),
            "board": np.flatnonzero(np.isin(beams, self._beams)).tolist(),
        }

    def _check(self) -> Fields | None:
        """How the solution so far predicts the pose that has just been taken."""
        session, found = self._session, self._session.calibration
        if found is None:
            return None
        pose = session.taken[-1].pose
        try:
            seen = check(pose, found.extrinsics, session.board, session.model)
        except BadInput as missed:
            return {"name": pose.name, "off_px": 0.0, "residual_rms_m": 0.0, "beams": 0, "words": str(missed)}
        words = (
            f"{pose.name} took no part so far: the solution puts its laser points {seen.off:.1f} px "
            f"({1e3 * seen.residual_rms:.0f} mm) beside the board's plane."
        )
        result = {"name": pose.name, "off_px": seen.off, "residual_rms_m": seen.residual_rms, "beams": seen.beams}
        return {**result, "words": words}
