"""Pictures of a board, and one who shows them to a console over REST."""

from functools import cache
from typing import Any
from urllib.parse import quote

import cv2
import numpy as np

from console.calibration.service import CalibrationService
from core.calibration.board.board import Board
from core.calibration.board.chessboard import find_board
from core.calibration.practice import ImageExposure, held, picture
from core.calibration.projection import Poses
from core.message import Array
from core.optics import TABLE_3
from tests.console.live import Live, Reply

BOARD = Board(columns=9, rows=6, square=0.03)
BOARD_TOLD: dict[str, Any] = {"columns": 9, "rows": 6, "square_m": 0.03, "panel_m": None}
JPEG = {"Content-Type": "image/jpeg"}
PNG = {"Content-Type": "image/png"}


@cache
def boards(count: int = 14) -> tuple[bytes, ...]:
    """Different views of the board by the paper's camera, as PNG."""
    rng = np.random.default_rng(3)
    poses = held(rng, count, TABLE_3, BOARD)
    return tuple(png(picture(rng, TABLE_3, poses.take(slice(n, n + 1)), BOARD)) for n in range(count))


@cache
def blurred() -> bytes:
    """A board that was moved while the picture was taken."""
    pose = Poses(np.eye(3)[None], np.array([[-0.12, -0.075, 0.4]]))
    return png(picture(np.random.default_rng(3), TABLE_3, pose, BOARD, ImageExposure(motion=9)))


@cache
def with_a_thumb() -> tuple[bytes, Array]:
    """The first board with a thumb over a crossing, so that it is not found, and its corners (54, 2) [pixel]."""
    grey: Any = cv2.imdecode(np.frombuffer(boards()[0], np.uint8), cv2.IMREAD_GRAYSCALE)
    found = find_board(grey, BOARD)
    assert found is not None
    return png(cv2.circle(grey, np.rint(found.corners[22]).astype(int).tolist(), 12, 127, -1)), found.corners


def png(grey: Array) -> bytes:
    return cv2.imencode(".png", grey)[1].tobytes()


class Wizard:
    """One session of a wizard, as its page walks it."""

    def __init__(self, live: Live, kind: str = "camera", source: str = "upload", **more: Any) -> None:
        self.live = live
        told = {"kind": kind, "board": BOARD_TOLD, "source": source, **more}
        begun = live.ask("POST", "/api/calibration/sessions", told, token=live.operator)
        assert begun.status == 201, begun.body
        self.id = str(begun.json["id"])
        self.base = f"/api/calibration/sessions/{self.id}"

    @property
    def told(self) -> Any:
        return self.live.ask("GET", self.base, token=self.live.operator).json

    @property
    def worker(self) -> int | None:
        """Number of the session's process."""
        return self.live.on_loop(lambda: self.live.runtime.parts[CalibrationService].sessions[self.id].pid)

    def send(self, content: bytes, name: str = "a.png", kind: dict[str, str] = PNG, more: str = "") -> Reply:
        path = f"{self.base}/pictures?name={quote(name)}{more}"
        return self.live.ask("POST", path, raw=content, headers=kind, token=self.live.operator)

    def post(self, what: str, body: Any = None) -> Reply:
        headers = {"Content-Length": "0"} if body is None else None
        return self.live.ask("POST", f"{self.base}/{what}", body, headers=headers, token=self.live.operator)

    def show(self, count: int) -> list[str]:
        """Send so many views → what became of each."""
        return [self.send(content, f"{number}.png").json["kind"] for number, content in enumerate(boards()[:count])]

    def solved(self) -> Any:
        """Wait for the solution of all that was shown → the session."""

        def now() -> Any:
            told = self.told
            fresh = told["solution"] is not None and told["solving"] is None
            return told if fresh and not told["progress"]["words"].startswith("Not solved") else None

        return self.live.until(now)
