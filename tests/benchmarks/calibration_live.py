"""The live loop measured: `python -m tests.benchmarks.calibration_live [--frames 200]`, one core, 640x480.

Pictures with a board come from a rendered hand that moves it; pictures without show the same scenes with the board
covered, clutter, and people-like shapes. Noise pictures stand for hostile ones. Times are the processor's, of one
thread, so that neighbours on the machine do not count.
"""

import time
from typing import Any

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import find_board
from core.calibration.board.quality import why_none
from core.calibration.camera.session import CameraSession
from core.calibration.practice import BoardPlacement, ImageExposure, held, picture
from core.calibration.projection import Poses
from core.message import Array
from core.optics import CameraModel
from tests.benchmarks.command import run_command

CAMERA = CameraModel(width=640, height=480, fx=560, fy=562, cx=322, cy=238, k1=-0.25, k2=0.08)
BOARD = Board(columns=9, rows=6, square=0.03)


def with_board(rng: np.random.Generator, frames: int) -> list[Array]:
    """A hand moves the board between poses and holds it still for a while."""
    shown: list[Array] = []
    while len(shown) < frames:
        pose = held(rng, 1, CAMERA, BOARD, BoardPlacement(nearest=0.3, farthest=0.9, margin=12))
        for step in range(8):
            moved = Poses(pose.rotations, pose.translations + np.array([0.01 * max(0, 3 - step), 0, 0]))
            shown.append(
                cluttered(rng, picture(rng, CAMERA, moved, BOARD, ImageExposure(motion=max(0, 6 - 2 * step))))
            )
    return shown[:frames]


def without_board(rng: np.random.Generator, frames: int) -> list[Array]:
    """Rooms without a board: shelves, windows, tiles, people-like shapes."""
    shown: list[Array] = []
    for _ in range(frames):
        grey = np.full((480, 640), rng.integers(60, 190), np.uint8)
        for _ in range(int(rng.integers(20, 90))):
            low = rng.integers(0, (640, 480))
            high = low + rng.integers(5, 160, 2)
            level = int(rng.integers(0, 255))
            if rng.random() < 0.7:
                cv2.rectangle(grey, low.tolist(), high.tolist(), level, -1 if rng.random() < 0.7 else 3)
            else:
                cv2.ellipse(grey, low.tolist(), (high - low).tolist(), float(rng.uniform(0, 180)), 0, 360, level, -1)
        noisy = cv2.GaussianBlur(grey, (0, 0), 0.8) + rng.normal(0, 3, grey.shape)
        shown.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return shown


def cluttered(rng: np.random.Generator, grey: Array) -> Array:
    """The wall behind the board gets some structure at the rim."""
    for _ in range(6):
        u = int(rng.integers(0, 60))
        cv2.line(grey, (u, 0), (u + int(rng.integers(-20, 20)), 479), int(rng.integers(0, 255)), 2)
    return grey


def loop(pictures: list[Array]) -> dict[str, Any]:
    """Every picture through the wizard's `look`, ten a second by its own clock."""
    session = CameraSession(BOARD)
    spent: list[float] = []
    kinds: dict[str, int] = {}
    for number, grey in enumerate(pictures):
        begun = time.process_time()
        verdict = session.look(grey, number / 10)
        spent.append(time.process_time() - begun)
        kinds[verdict.kind] = kinds.get(verdict.kind, 0) + 1
    told = 1e3 * np.array(spent)
    return {
        "frames": len(told),
        "frames_per_s": float(1e3 / told.mean()),
        "ms_median": float(np.median(told)),
        "ms_p95": float(np.quantile(told, 0.95)),
        "ms_most": float(told.max()),
        "verdicts": kinds,
    }


def hostile() -> list[dict[str, Any]]:
    """Noise pictures: the time until they are refused in words."""
    rng = np.random.default_rng(0)
    told: list[dict[str, Any]] = []
    for width, height in ((640, 480), (1280, 960), (4000, 3000)):
        noise = rng.integers(0, 256, (height, width), dtype=np.uint8)
        begun = time.process_time()
        found = find_board(noise, BOARD)
        words = str(why_none(noise, BOARD))
        told.append(
            {
                "size": f"{width}x{height}",
                "s": time.process_time() - begun,
                "found": found is not None,
                "words": words,
            }
        )
    return told


def main(*, frames: int = 200) -> object:
    cv2.setNumThreads(1)
    rng = np.random.default_rng(0)
    return {
        "with_board": loop(with_board(rng, frames)),
        "without_board": loop(without_board(rng, frames)),
        "noise": hostile(),
    }


if __name__ == "__main__":
    run_command(main)
