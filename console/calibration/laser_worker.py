"""The laser's session, as a worker holds it."""

import msgspec
import numpy as np

from console.calibration import answers
from console.calibration.codec import THUMBNAIL_PX, advised_view, png, points
from console.calibration.laser_state import LaserState, resumed
from console.calibration.session_worker import SessionWorker
from console.messages.calibration import (
    CalibrationBoard,
    CalibrationCheck,
    CalibrationProgress,
    CalibrationScan,
    CalibrationVerdict,
    CalibrationView,
)
from console.workers.job import job
from console.workers.pictures import jpeg
from core.calibration.board.board import Board
from core.calibration.board.session import BoardVerdict
from core.calibration.files.pictures import size_words
from core.calibration.laser.board_line import MeanScan, find_lines, foreground
from core.calibration.laser.explanation import weak_words
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.session import LaserSession
from core.calibration.laser.solve import check, dots
from core.calibration.mount import Mount
from core.calibration.reports import kept, laser_report
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import TABLE_3, CameraModel
from core.sensors.laser import Scan
from core.sentences import plain

LIVE_SD_M = 0.01  # of a single range, for the line that is shown live


class LaserWorker(SessionWorker[LaserSession]):
    def __init__(self) -> None:
        super().__init__(LaserSession(Board(columns=9, rows=6, square=0.03), TABLE_3))
        self._grey: Array | None = None
        self._scan: Scan | None = None
        self._beams = np.empty(0, int)  # of the newest scan that end on the board

    @job
    def open(
        self,
        board: CalibrationBoard,
        state: bytes,
        solved: answers.SolvedViews | None,
        camera: CameraModel,
        mount: Mount,
    ) -> answers.SessionAnswer:
        """Begin a session, or go on where `state` ended."""
        self._session = resumed(board, camera, mount, state)
        return self.refresh() if solved is None else self.adopt(solved)

    @job
    def look(self, grey: Array, stamp: float) -> answers.SessionAnswer:
        model = self._session.model
        if grey.shape != (model.height, model.width):
            raise BadInput(
                f"This picture is {size_words(grey)}, the camera in use is for "
                f"{model.width}x{model.height}; calibrate the camera at this size first."
            )
        self._grey = grey
        return self._answer(verdict=self._session.look(grey, stamp))

    @job
    def sweep(self, scan: Scan) -> answers.SessionAnswer:
        """Look at a scan: first of the empty room, then of the still board."""
        empty, first = self._session.background is None, self._scan is None
        verdict = self._session.sweep(scan)
        self._scan, self._beams = scan, self._on_board(scan)
        is_counted = verdict is not None and verdict.kind == "counted"
        room_known = self._session.background is not None
        answer = self._answer(changed=is_counted or (empty and room_known) or first, verdict=verdict)
        answer = msgspec.structs.replace(answer, scan=self._shown(scan), room_known=room_known)
        if verdict is None or not is_counted or self._grey is None:
            return answer
        counted = answers.CountedPicture(verdict.name, png(self._grey), jpeg(self._grey, THUMBNAIL_PX))
        return msgspec.structs.replace(answer, counted=counted, check=self._check())

    @job
    def forget_room(self) -> answers.SessionAnswer:
        """Look at the empty room again: the robot has moved, or a person stood in the room. Poses stay."""
        self._session.forget_room()
        words = "The empty room is looked at again: step out of the laser's view."
        return self._answer(changed=True, verdict=BoardVerdict(kind="background", words=words))

    @job
    def refresh(self) -> answers.SessionAnswer:
        return self._answer(changed=True)

    @job
    def accept(self, *, force: bool) -> answers.AcceptedMount:
        """The mount as it is stored; `force`: although it is not as exact as it should be. Raises Refused."""
        session, found = self._session, self._session.calibration
        self.check_acceptable(solved=found is not None, force=force)
        assert found is not None
        if found.extrinsics.unknown:
            raise Refused(weak_words(found.extrinsics)[0])
        document = kept(session.model, board=session.board, laser=found)
        return answers.AcceptedMount(document, laser_report(found, session.names, session.board, session.model))

    def _answer(self, *, changed: bool = False, verdict: BoardVerdict | None = None) -> answers.SessionAnswer:
        model = self._session.model
        shown = None
        if verdict is not None:
            shown = CalibrationVerdict(
                kind=verdict.kind,
                words=verdict.words,
                name=verdict.name,
                corners=None if verdict.corners is None else points(verdict.corners),
                laser=self._dots(),
                beams=None if verdict.beams is None else verdict.beams.tolist(),
            )
        change = self._change() if changed else None
        return answers.SessionAnswer(size=(model.width, model.height), verdict=shown, change=change)

    def _change(self) -> answers.SessionChange:
        session, progress = self._session, self._session.progress()
        return answers.SessionChange(
            advice=advised_view(session.advice()),
            progress=msgspec.convert({**progress._asdict(), "views": progress.poses}, CalibrationProgress),
            views=self._views(),
            state=msgspec.json.encode(LaserState.of(session), enc_hook=plain),
            stale=session.stale,
            names=list(session.names),
        )

    def _views(self) -> list[CalibrationView]:
        session, found = self._session, self._session.calibration
        fits: dict[str, tuple[str, Array]] = {}
        if found is not None:
            fits = dict(zip(session.solved, zip(found.reasons, found.residuals, strict=True), strict=True))
        rows: list[CalibrationView] = []
        for each in session.taken:
            row = CalibrationView(each.pose.name, each.dropped)
            if each.pose.name in fits:
                row.reason, residuals = fits[each.pose.name]
                row.rms_m = float(np.sqrt(np.mean(residuals**2))) if len(residuals) else None
                row.used = None if each.dropped else not row.reason
            rows.append(row)
        return sorted(rows, key=lambda row: -(row.rms_m or 0.0))

    def _on_board(self, scan: Scan) -> Array:
        """Numbers (K,) of the beams that end on the board now, as far as they differ from the empty room."""
        background = self._session.background
        if background is None:
            return np.empty(0, int)
        ranges = np.where(scan.valid, scan.ranges, np.nan)
        mean = MeanScan(ranges=ranges, rays=unit_rays(scan.angles), sd=LIVE_SD_M)
        lines = find_lines(mean, foreground(mean, background), self._session.board)
        return lines[0] if lines else np.empty(0, int)

    def _dots(self) -> list[tuple[float, float, float, bool]]:
        """The newest scan in the picture, by the mount as it is known: u, v [pixel], range [m], on the board."""
        scan, session = self._scan, self._session
        if scan is None:
            return []
        found = session.calibration
        mount = session.mount.nominal if found is None else found.extrinsics.transform
        pixels, beams = dots(scan, mount, session.model)
        board, rows = np.isin(beams, self._beams), np.round(pixels.astype(float), 2)
        return [(u, v, r, bool(on)) for (u, v, r), on in zip(rows.tolist(), board.tolist(), strict=True)]

    def _shown(self, scan: Scan) -> CalibrationScan:
        rays = unit_rays(scan.angles)[:, :2]
        beams = np.flatnonzero(scan.valid)
        background = self._session.background
        room = np.empty((0, 2)) if background is None else (rays * background[:, None])[np.isfinite(background)]
        return CalibrationScan(
            points=points(rays[beams] * scan.ranges[beams, None], 3),
            background=points(room, 3),
            board=np.flatnonzero(np.isin(beams, self._beams)).tolist(),
        )

    def _check(self) -> CalibrationCheck | None:
        """How the solution so far predicts the pose that has just been taken."""
        session, found = self._session, self._session.calibration
        if found is None:
            return None
        pose = session.taken[-1].pose
        try:
            seen = check(pose, found.extrinsics, session.board, session.model)
        except BadInput as missed:
            return CalibrationCheck(pose.name, off_px=0.0, residual_rms_m=0.0, beams=0, words=str(missed))
        words = (
            f"{pose.name} took no part so far: the solution puts its laser points {seen.off:.1f} px "
            f"({1e3 * seen.residual_rms:.0f} mm) beside the board's plane."
        )
        return CalibrationCheck(pose.name, seen.off, seen.residual_rms, seen.beams, words)
