"""The camera's session, as a worker holds it."""

from __future__ import annotations

import pickle
from dataclasses import replace

import cv2
import numpy as np

from console.calibration.codec import OTHER_VIEWS, SMALL, Fields, advice_fields, board_of, grey_of, jpeg, png, points
from core.calibration.board.board import Board
from core.calibration.camera.intrinsics import ViewCorners
from core.calibration.camera.session import CameraSession, PictureVerdict
from core.calibration.files.pictures import decode
from core.calibration.reports import camera_report, kept
from core.errors import BadInput, Refused
from core.message import Array

UNKNOWN = 0.05  # share of the focal length: a standard deviation beyond it means that nothing is known


class CameraWorker:
    """One camera session. Every method answers what has changed: `parts` of the session as the page gets it."""

    def __init__(self) -> None:
        self._session = CameraSession(Board(columns=9, rows=6, square=0.03))
        self._solved: tuple[str, ...] = ()  # names of the views in the solution
        self._sized: tuple[int, int] | None = None  # of the pictures, as the page knows it

    def open(self, board: Fields, state: Fields | None, calibration: bytes | None, names: list[str]) -> Fields:
        """Begin, or go on where `state` ended; `calibration` is the solution of the views `names`."""
        mine = board_of(board)
        self._session = CameraSession(mine) if state is None else CameraSession.resumed(state)
        self._session.board = mine
        return self._answer(changed=True) if calibration is None else self.adopt(calibration, names)

    def look(self, pixels: bytes, width: int, height: int, stamp: float) -> Fields:
        """A live picture of the robot."""
        grey = grey_of(pixels, width, height)
        return self._looked(self._session.look(grey, stamp), grey, original=False)

    def frame(self, content: bytes, stamp: float) -> Fields:
        """A live picture of the browser's webcam."""
        grey, _ = read(content)
        return self._looked(self._session.look(grey, stamp), grey, original=True)

    def take(self, content: bytes, name: str) -> Fields:
        """A picture that was uploaded on purpose."""
        grey, remark = read(content)
        verdict = self._session.capture(grey, name)
        if remark:
            verdict = replace(verdict, words=f"{verdict.words} Note: {remark}.")
        return self._looked(verdict, grey, original=True)

    def capture(self, pixels: bytes, width: int, height: int) -> Fields:
        """The robot's picture, taken on purpose."""
        grey = grey_of(pixels, width, height)
        name = f"view {len(self._session.taken) + 1}"
        return self._looked(self._session.capture(grey, name), grey, original=False)

    def refresh(self) -> Fields:
        """All of it, as it is."""
        return self._answer(changed=True)

    def drop(self, name: str) -> Fields:
        """Leave a view out."""
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
        """A solution of the solver worker, of the views of these names."""
        views = tuple(
            ViewCorners(name=each.name, corners=each.corners) for each in self._session.taken if each.name in names
        )
        self._session.adopt(pickle.loads(calibration), views)
        self._solved = tuple(view.name for view in views)
        return self._answer(changed=True)

    def accept(self, force: bool) -> Fields:
        """The camera as it is kept. Raises Refused with the reason."""
        session = self._session
        if not force:
            session.accept()
        found = session.calibration
        if found is None or session.stale:
            raise Refused(session.progress().words)
        if self._solved != tuple(view.name for view in session.views):
            raise Refused(OTHER_VIEWS)
        if found.sds["fx"] > UNKNOWN * found.model.fx:
            raise Refused("The focal length is not known from these views; tilt the board by 20 to 50 degrees.")
        report = camera_report(found)
        return {"document": kept(found.model, "camera", board=session.board, camera=report), "report": report}

    def _looked(self, verdict: PictureVerdict, grey: Array, *, original: bool) -> Fields:
        """`original`: the console has the picture itself, as it came."""
        answer = self._answer(changed=verdict.kind == "counted" or self._sized != self._session.size, verdict=verdict)
        if verdict.kind == "counted":
            answer["kept"] = {
                "name": verdict.name,
                "picture": None if original else png(grey),
                "small": jpeg(grey, SMALL),
            }
        return answer

    def _answer(self, *, changed: bool, verdict: PictureVerdict | None = None) -> Fields:
        session = self._session
        parts: Fields = {"size": session.size}
        if verdict is not None:
            corners = None if verdict.corners is None else points(verdict.corners)
            parts["verdict"] = {
                "kind": verdict.kind,
                "words": verdict.words,
                "name": verdict.name,
                "corners": corners,
            }
        if not changed:
            return {"parts": parts}
        self._sized = session.size
        parts |= self._slow_parts()
        names = [view.name for view in session.views]
        return {"parts": parts, "state": session.state(), "stale": session.stale, "names": names}

    def _slow_parts(self) -> Fields:
        session = self._session
        progress, known = session.progress(), session.uncertainty()
        return {
            "advice": advice_fields(session.advice()),
            "progress": {
                "views": progress.views,
                "ready": progress.ready,
                "words": progress.words,
                "p95_px": progress.p95,
                "target_px": progress.target,
                "bars": progress.bars._asdict(),
                "cells": progress.cells.tolist(),
            },
            "uncertainty": None
            if known is None
            else {"columns": known.sd.shape[1], "rows": known.sd.shape[0], "sd_px": np.round(known.sd, 3).tolist()},
            "views": self._views(),
        }

    def _views(self) -> list[Fields]:
        """Every view and how well it fits, the worst first."""
        found = self._session.calibration
        verdicts = {} if found is None else {each.name: each for each in found.verdicts}
        rows: list[Fields] = []
        for each in self._session.taken:
            verdict = verdicts.get(each.name)
            rows.append(
                {
                    "name": each.name,
                    "dropped": each.dropped,
                    "rms_px": None if verdict is None else verdict.rms,
                    "used": None if verdict is None or each.dropped else verdict.used,
                    "reason": "" if verdict is None else verdict.reason,
                }
            )
        return sorted(rows, key=lambda row: -(row["rms_px"] or 0.0))


def read(content: bytes) -> tuple[Array, str]:
    """A JPEG or PNG from a stranger → grey (H, W) uint8 and a remark or ''. Raises BadInput."""
    if not content.startswith((b"\xff\xd8\xff", b"\x89PNG")):
        raise BadInput("This is no JPEG or PNG picture.")
    try:
        return decode(content, cv2.IMREAD_GRAYSCALE)
    except BadInput as wrong:
        words = str(wrong)
        raise BadInput(f"{words[:1].upper()}{words[1:]}.") from None
