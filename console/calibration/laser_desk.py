"""The laser's session, as a worker holds it."""

from __future__ import annotations

import pickle

import numpy as np

from console.calibration.laser_keeping import resumed, state_of
from console.calibration.values import OTHER_VIEWS, SMALL, Told, advice_told, board_of, grey_of, jpeg, png, points
from core.calibration.board import Board
from core.calibration.board_line import MeanScan, find_lines, foreground
from core.calibration.laser_proof import check, dots
from core.calibration.laser_session import LaserSession, LaserVerdict
from core.calibration.laser_words import weak_words
from core.calibration.range_lines import unit_rays
from core.calibration.reports import kept, laser_report
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import TABLE_3
from core.sensors.laser import Scan

LIVE_SD = 0.01  # [m] of a single range, for the line that is shown live


class LaserDesk:
    """One laser session. Every method answers what has changed: `parts` of the session as the page gets it."""

    def __init__(self) -> None:
        self._session = LaserSession(Board(columns=9, rows=6, square=0.03), TABLE_3)
        self._grey: Array | None = None
        self._scan: Scan | None = None
        self._beams = np.empty(0, int)  # of the newest scan that end on the board
        self._solved: tuple[str, ...] = ()  # names of the poses in the solution

    def open(
        self,
        board: Told,
        state: Told | None,
        calibration: bytes | None,
        names: list[str],
        camera: Told,
        mount: Told,
    ) -> Told:
        """Begin, or go on where `state` ended; `calibration` is the solution of the poses `names`."""
        self._session = resumed(board, camera, mount, state)
        self._session.board = board_of(board)
        return self._answer(changed=True) if calibration is None else self.adopt(calibration, names)

    def look(self, pixels: bytes, width: int, height: int, stamp: float) -> Told:
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
    ) -> Told:
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

    def forget_room(self) -> Told:
        """The robot has moved, or somebody stood in the room: look at it anew. Poses stay."""
        self._session.forget_room()
        words = "The empty room is looked at anew: step out of the laser's view."
        return self._answer(changed=True, verdict=LaserVerdict(kind="background", words=words))

    def drop(self, name: str) -> Told:
        """Leave a pose out."""
        self._session.drop(name)
        return self._answer(changed=True)

    def restore(self, name: str) -> Told:
        """Take it back in."""
        self._session.restore(name)
        return self._answer(changed=True)

    def another(self) -> Told:
        """Another suggestion."""
        self._session.another()
        return self._answer(changed=True)

    def adopt(self, calibration: bytes, names: list[str]) -> Told:
        """A solution from the back room, of the poses of these names."""
        poses = tuple(each.pose for each in self._session.taken if each.pose.name in names)
        self._session.adopt(pickle.loads(calibration), poses)
        self._solved = tuple(pose.name for pose in poses)
        return self._answer(changed=True)

    def accept(self, anyway: bool) -> Told:
        """The mount as it is kept. Raises Refused with the reason."""
        session = self._session
        if not anyway:
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

    def refresh(self) -> Told:
        """All of it, as it is."""
        return self._answer(changed=True)

    def _answer(self, *, changed: bool = False, verdict: LaserVerdict | None = None) -> Told:
        session = self._session
        parts: Told = {"size": (session.model.width, session.model.height)}
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

    def _slow_parts(self) -> Told:
        progress = self._session.progress()
        return {
            "advice": advice_told(self._session.advice()),
            "progress": {
                "views": progress.poses,
                "ready": progress.ready,
                "words": progress.words,
                "gains": progress.gains,
                "weak": list(progress.weak),
                "landing": progress.landing,
                "witnessed": progress.witnessed,
                "known_from": progress.known_from,
            },
            "views": self._views(),
        }

    def _views(self) -> list[Told]:
        """Every pose and how well it fits, the worst first."""
        session, found = self._session, self._session.calibration
        fits: dict[str, tuple[str, Array]] = {}
        if found is not None:
            fits = dict(zip(self._solved, zip(found.reasons, found.residuals, strict=True), strict=True))
        rows: list[Told] = []
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
        """Numbers (K,) of the beams that end on the board now, as far as they can be told from the empty room."""
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
        told, beams = dots(scan, mount, session.model)
        board = np.isin(beams, self._beams)
        return [(u, v, r, bool(on)) for (u, v, r), on in zip(points(told, 2), board.tolist(), strict=True)]

    def _shown(self, scan: Scan) -> Told:
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

    def _check(self) -> Told | None:
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
        told = {"name": pose.name, "off_px": seen.off, "residual_rms_m": seen.residual_rms, "beams": seen.beams}
        return {**told, "words": words}
