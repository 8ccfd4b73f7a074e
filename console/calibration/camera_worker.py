"""The camera's session, as a worker holds it."""

from dataclasses import replace

import cv2
import msgspec
import numpy as np

from console.calibration import jobs
from console.calibration.codec import THUMBNAIL_PX, advised_view, board_of, png, points
from console.calibration.session_worker import SessionWorker
from console.messages.calibration import (
    CalibrationBars,
    CalibrationProgress,
    CalibrationUncertainty,
    CalibrationVerdict,
    CalibrationView,
)
from console.workers.pictures import decode_upload, jpeg
from core.calibration.board.board import Board
from core.calibration.board.session import BoardVerdict
from core.calibration.camera.session import CameraSession, CameraState
from core.calibration.reports import camera_report, kept
from core.errors import Refused
from core.message import Array
from core.sentences import plain

UNKNOWN_SD_SHARE = 0.05  # share of the focal length: a standard deviation beyond it means that nothing is known


class CameraWorker(SessionWorker[CameraSession]):
    def __init__(self) -> None:
        super().__init__(CameraSession(Board(columns=9, rows=6, square=0.03)))
        self._sized: tuple[int, int] | None = None  # of the pictures, as the page knows it

    def open(self, job: jobs.OpenCamera) -> jobs.SessionAnswer:
        state = msgspec.json.decode(job.state, type=CameraState | None)
        self._session = CameraSession(board_of(job.board)) if state is None else CameraSession.resumed(state)
        self._session.board = board_of(job.board)
        return self.refresh() if job.solved is None else self.adopt(jobs.AdoptSolution(job.solved))

    def look(self, job: jobs.LookAtPicture) -> jobs.SessionAnswer:
        """Take a live picture of the robot when it is sharp, still and new."""
        return self._looked(self._session.look(job.grey, job.stamp), job.grey, original=False)

    def look_at_webcam(self, job: jobs.LookAtWebcam) -> jobs.SessionAnswer:
        """Take a live picture of the webcam when it is sharp, still and new."""
        grey, _ = read_grey(job.content)
        return self._looked(self._session.look(grey, job.stamp), grey, original=True)

    def take_upload(self, job: jobs.TakeUpload) -> jobs.SessionAnswer:
        """Take an uploaded picture unless it is unfit or known."""
        grey, remark = read_grey(job.content)
        verdict = self._session.capture(grey, job.name, np.array(job.corners) if job.corners else None)
        if remark:
            verdict = replace(verdict, words=f"{verdict.words} Note: {remark}.")
        return self._looked(verdict, grey, original=True)

    def take_picture(self, job: jobs.TakePicture) -> jobs.SessionAnswer:
        """Take the robot's picture unless it is unfit or known."""
        name = f"view {len(self._session.taken) + 1}"
        return self._looked(self._session.capture(job.grey, name), job.grey, original=False)

    def refresh(self, _: jobs.RefreshSession | None = None) -> jobs.SessionAnswer:
        return jobs.SessionAnswer(size=self._session.size, change=self._change())

    def accept(self, job: jobs.AcceptCamera) -> jobs.AcceptedCamera:
        session, found = self._session, self._session.calibration
        self.check_acceptable(solved=found is not None, force=job.force)
        assert found is not None
        if found.sds["fx"] > UNKNOWN_SD_SHARE * found.model.fx:
            raise Refused("The focal length is not known from these views; tilt the board by 20 to 50 degrees.")
        report = camera_report(found)
        return jobs.AcceptedCamera(kept(found.model, board=session.board, camera=report), report)

    def _looked(self, verdict: BoardVerdict, grey: Array, *, original: bool) -> jobs.SessionAnswer:
        """`original`: the console has the picture itself, as it came."""
        size, is_counted = self._session.size, verdict.kind == "counted"
        corners = None if verdict.corners is None else points(verdict.corners)
        counted: jobs.CountedPicture | None = None
        if is_counted:
            counted = jobs.CountedPicture(verdict.name, None if original else png(grey), jpeg(grey, THUMBNAIL_PX))
        return jobs.SessionAnswer(
            size=size,
            verdict=CalibrationVerdict(verdict.kind, verdict.words, verdict.name, corners=corners),
            counted=counted,
            change=self._change() if is_counted or self._sized != size else None,
        )

    def _change(self) -> jobs.SessionChange:
        session = self._session
        self._sized = session.size
        progress, known = session.progress(), session.uncertainty()
        uncertainty = None
        if known is not None:
            rows, columns = known.sd.shape
            uncertainty = CalibrationUncertainty(columns, rows, np.round(known.sd, 3).tolist())
        return jobs.SessionChange(
            advice=advised_view(session.advice()),
            progress=CalibrationProgress(
                views=progress.views,
                ready=progress.ready,
                words=progress.words,
                p95_px=progress.p95,
                target_px=progress.target,
                bars=CalibrationBars(**progress.bars._asdict()),
                cells=progress.cells.tolist(),
            ),
            uncertainty=uncertainty,
            views=self._views(),
            state=msgspec.json.encode(session.state(), enc_hook=plain),
            stale=session.stale,
            names=list(session.names),
        )

    def _views(self) -> list[CalibrationView]:
        found = self._session.calibration
        verdicts = {} if found is None else {each.name: each for each in found.verdicts}
        rows: list[CalibrationView] = []
        for each in self._session.taken:
            row, verdict = CalibrationView(each.name, each.dropped), verdicts.get(each.name)
            if verdict is not None:
                row.rms_px, row.reason = verdict.rms, verdict.reason
                row.used = None if each.dropped else verdict.used
            rows.append(row)
        return sorted(rows, key=lambda row: -(row.rms_px or 0.0))


def read_grey(content: bytes) -> tuple[Array, str]:
    """A JPEG or PNG from a stranger → grey (H, W) uint8 and a remark or ''. Raises BadInput."""
    return decode_upload(content, cv2.IMREAD_GRAYSCALE)
