"""The camera's session, as a worker holds it."""

from __future__ import annotations

import pickle
from dataclasses import replace

import cv2
import numpy as np

from console.calibration.values import OTHER_VIEWS, SMALL, Told, advice_told, board_of, grey_of, jpeg, png, points
from core.calibration.board import Board
from core.calibration.intrinsics import View
from core.calibration.pictures import decode
from core.calibration.reports import camera_report, kept
from core.calibration.session import CameraSession, Verdict
from core.errors import BadInput, Refused
from core.message import Array

UNKNOWN = 0.05  # share of the focal length: a standard deviation beyond it means that nothing is known


class CameraDesk:
    """One camera session. Every method answers what has changed: `parts` of the session as the page gets it."""

    def __init__(self) -> None:
        self._session = CameraSession(Board(columns=9, rows=6, square=0.03))
        self._solved: tuple[str, ...] = ()  # names of the views in the solution
        self._sized: tuple[int, int] | None = None  # of the pictures, as the page knows it

    def open(self, board: Told, state: Told | None, calibration: bytes | None, names: list[str]) -> Told:
        """Begin, or go on where `state` ended; `calibration` is the solution of the views `names`."""
        mine = board_of(board)
        self._session = CameraSession(mine) if state is None else CameraSession.resumed(state)
        self._session.board = mine
        return self._answer(changed=True) if calibration is None else self.adopt(calibration, names)

    def look(self, pixels: bytes, width: int, height: int, stamp: float) -> Told:
        """A live picture of the robot."""
        grey = grey_of(pixels, width, height)
        return self._looked(self._session.look(grey, stamp), grey, original=False)

    def frame(self, content: bytes, stamp: float) -> Told:
        """A live picture of the browser's webcam."""
        grey, _ = read(content)
        return self._looked(self._session.look(grey, stamp), grey, original=True)

    def take(self, content: bytes, name: str) -> Told:
        """A picture that was uploaded on purpose."""
        grey, remark = read(content)
        verdict = self._session.capture(grey, name)
        if remark:
            verdict = replace(verdict, words=f"{verdict.words} Note: {remark}.")
        return self._looked(verdict, grey, original=True)

    def capture(self, pixels: bytes, width: int, height: int) -> Told:
        """The robot's picture, taken on purpose."""
        grey = grey_of(pixels, width, height)
        name = f"view {len(self._session.taken) + 1}"
        return self._looked(self._session.capture(grey, name), grey, original=False)

    def refresh(self) -> Told:
        """All of it, as it is."""
        return self._answer(changed=True)

    def drop(self, name: str) -> Told:
        """Leave a view out."""
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
        """A solution from the back room, of the views of these names."""
        views = tuple(
            View(name=each.name, corners=each.corners) for each in self._session.taken if each.name in names
        )
        self._session.adopt(pickle.loads(calibration), views)
        self._solved = tuple(view.name for view in views)
        return self._answer(changed=True)

    def accept(self, anyway: bool) -> Told:
        """The camera as it is kept. Raises Refused with the reason."""
        session = self._session
        if not anyway:
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

    def _looked(self, verdict: Verdict, grey: Array, *, original: bool) -> Told:
        """`original`: the console has the picture itself, as it came."""
        answer = self._answer(changed=verdict.kind == "counted" or self._sized != self._session.size, verdict=verdict)
        if verdict.kind == "counted":
            answer["kept"] = {
                "name": verdict.name,
                "picture": None if original else png(grey),
                "small": jpeg(grey, SMALL),
            }
        return answer

    def _answer(self, *, changed: bool, verdict: Verdict | None = None) -> Told:
        session = self._session
        parts: Told = {"size": session.size}
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

    def _slow_parts(self) -> Told:
        session = self._session
        progress, known = session.progress(), session.uncertainty()
        return {
            "advice": advice_told(session.advice()),
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

    def _views(self) -> list[Told]:
        """Every view and how well it fits, the worst first."""
        found = self._session.calibration
        verdicts = {} if found is None else {each.name: each for each in found.verdicts}
        rows: list[Told] = []
        for each in self._session.taken:
            told = verdicts.get(each.name)
            rows.append(
                {
                    "name": each.name,
                    "dropped": each.dropped,
                    "rms_px": None if told is None else told.rms,
                    "used": None if told is None or each.dropped else told.used,
                    "reason": "" if told is None else told.reason,
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
