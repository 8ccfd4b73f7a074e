"""`--board 9x6 --square 0.025 --panel 0.34x0.25` of a command line → a board."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from core.calibration.board.board import Board
from core.errors import BadInput


def add_board(parser: argparse.ArgumentParser, *, required: bool) -> None:
    """Give a subcommand `--board`, `--square` and `--panel`, and its own way to complain about them."""
    parser.add_argument(
        "--board",
        type=corner_counts,
        required=required,
        metavar="9x6",
        help="inner corners in a row x rows: the points where four squares meet",
    )
    parser.add_argument(
        "--square", type=side, required=required, metavar="METRES", help="side of one square, as in 0.025"
    )
    parser.add_argument(
        "--panel",
        type=panel_size,
        default=None,
        metavar="WxH",
        help="the stiff panel that carries the print, in metres; the laser sees the panel",
    )
    parser.set_defaults(wrong_usage=parser.error)


def corner_counts(text: str) -> tuple[int, int]:
    """'9x6' → columns and rows."""
    try:
        board = Board.parse(text, square=0.025)
    except BadInput as wrong:
        raise argparse.ArgumentTypeError(str(wrong)) from None
    return board.columns, board.rows


def side(text: str) -> float:
    """'0.025' → the side of a square [m]."""
    try:
        return Board(columns=3, rows=3, square=float(text)).square
    except ValueError:
        raise argparse.ArgumentTypeError("Give the side of a square in metres, as in 0.025.") from None
    except BadInput as wrong:
        raise argparse.ArgumentTypeError(str(wrong)) from None


def panel_size(text: str) -> tuple[float, float]:
    """'0.34x0.25' → width and height [m]."""
    found = re.fullmatch(r"\s*(\d*\.?\d+)\s*[xX×]\s*(\d*\.?\d+)\s*", text, re.ASCII)
    if found is None or not all(0 < float(each) <= 10 for each in found.groups()):
        raise argparse.ArgumentTypeError("Write the panel as width x height in metres, as in 0.34x0.25.")
    return float(found[1]), float(found[2])


def board_from(chosen: argparse.Namespace) -> Board:
    """The board that was described in full."""
    return _assembled(chosen, chosen.board, chosen.square, chosen.panel)


def board_or_known(chosen: argparse.Namespace, camera: Path) -> Board:
    """The board as described, completed by what the camera file says. Raises BadInput where neither says it all."""
    if chosen.board is not None and chosen.square is not None:
        return board_from(chosen)
    from core.calibration.files.camera_files import read_camera  # OpenCV and scipy take a moment: only where needed
    from core.pipelines.calibrate import board_in

    read_camera(camera)
    known = board_in(camera)
    counts = chosen.board or (known.columns, known.rows)
    return _assembled(chosen, counts, chosen.square or known.square, chosen.panel or known.panel)


def _assembled(
    chosen: argparse.Namespace, counts: tuple[int, int], square: float, panel: tuple[float, float] | None
) -> Board:
    try:
        return Board(columns=counts[0], rows=counts[1], square=square, panel=panel)
    except BadInput as wrong:
        chosen.wrong_usage(str(wrong))
        raise
