"""The camera's session, as a worker holds it."""

from dataclasses import replace

import cv2
import msgspec
import numpy as np

from console.calibration import answers
from console.calibration.codec import THUMBNAIL_PX, advised_view, board_of, png, points
from console.calibration.session_worker import SessionWorker
from console.messages.calibration import (
    CalibrationBoard,
    CalibrationProgress,
    CalibrationUncertainty,
    CalibrationVerdict,
    CalibrationView,
)
from console.workers.job import job
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

    @job
    def open(
        self, board: CalibrationBoard, state: bytes, solved: answers.SolvedViews | None
    ) -> answers.SessionAnswer:
        """Begin a session, or go on where `state` ended."""
        stored = msgspec.json.decode(state, type=CameraState | None)
        self._session = CameraSession(board_of(board)) if stored is None else CameraSession.resumed(stored)
        self._session.board = board_of(board)
        return self.refresh() if solved is None else self.adopt(solved)

    @job
    def look(self, grey: Array, stamp: float) -> answers.SessionAnswer:
        return self._looked(self._session.look(grey, stamp), grey, original=False)

    @job
    def look_at_webcam(self, content: bytes, stamp: float) -> answers.SessionAnswer:
        """Take a live picture of the webcam, JPEG or PNG, when it is sharp, still and new; `stamp` [s]."""
        grey, _ = read_grey(content)
        return self._looked(self._session.look(grey, stamp), grey, original=True)

    @job
    def take_upload(self, content: bytes, name: str, corners: list[tuple[float, float]]) -> answers.SessionAnswer:
        """Take an uploaded picture, JPEG or PNG, unless it is unfit or known.

        `corners`: u, v [pixel] of the four extreme ones, where a person has marked them.
        """
        grey, remark = read_grey(content)
        verdict = self._session.capture(grey, name, np.array(corners) if corners else None)
        if remark:
            verdict = replace(verdict, words=f"{verdict.words} Note: {remark}.")
        return self._looked(verdict, grey, original=True)

    @job
    def take_picture(self, grey: Array) -> answers.SessionAnswer:
        """Take the robot's picture (H, W) uint8 unless it is unfit or known."""
        name = f"view {len(self._session.taken) + 1}"
        return self._looked(self._session.capture(grey, name), grey, original=False)

    @job
    def refresh(self) -> answers.SessionAnswer:
        return answers.SessionAnswer(size=self._session.size, change=self._change())

    @job
    def accept(self, *, force: bool) -> answers.AcceptedCamera:
        """The camera as it is stored; `force`: although it is not as exact as it should be. Raises Refused."""
        session, found = self._session, self._session.calibration
        self.check_acceptable(solved=found is not None, force=force)
        assert found is not None
        if found.sds["fx"] > UNKNOWN_SD_SHARE * found.model.fx:
            raise Refused("The focal length is not known from these views; tilt the board by 20 to 50 degrees.")
        report = camera_report(found)
        return answers.AcceptedCamera(kept(found.model, board=session.board, camera=report), report)

    def _looked(self, verdict: BoardVerdict, grey: Array, *, original: bool) -> answers.SessionAnswer:
        """`original`: the console has the picture itself, as it came."""
        size, is_counted = self._session.size, verdict.kind == "counted"
        corners = None if verdict.corners is None else points(verdict.corners)
        counted: answers.CountedPicture | None = None
        if is_counted:
            counted = answers.CountedPicture(verdict.name, None if original else png(grey), jpeg(grey, THUMBNAIL_PX))
        return answers.SessionAnswer(
            size=size,
            verdict=CalibrationVerdict(verdict.kind, verdict.words, verdict.name, corners=corners),
            counted=counted,
            change=self._change() if is_counted or self._sized != size else None,
        )

    def _change(self) -> answers.SessionChange:
        session = self._session
        self._sized = session.size
        progress, known = session.progress(), session.uncertainty()
        uncertainty = None
        if known is not None:
            rows, columns = known.sd.shape
            uncertainty = CalibrationUncertainty(columns, rows, np.round(known.sd, 3).tolist())
        return answers.SessionChange(
            advice=advised_view(session.advice()),
            progress=msgspec.convert(
                {**progress._asdict(), "bars": progress.bars._asdict(), "cells": progress.cells.tolist()},
                CalibrationProgress,
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
