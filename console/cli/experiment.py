"""`beckon experiment`: compute one figure or table again."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from console.cli import course_options
from console.cli.answer import add_json, add_out, tell, write, write_json
from core.experiments import EXPERIMENTS
from core.experiments.result import BoardPoseFigures, as_text

MOST_RUNS = 100_000


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("experiment", help="compute a figure or a table again")
    parser.add_argument("name", choices=sorted(EXPERIMENTS), metavar="NAME", help=", ".join(sorted(EXPERIMENTS)))
    parser.add_argument("--runs", type=runs, default=None, help="how often (the experiment's own number)")
    parser.add_argument("--seed", type=seed, default=0, help="the same seed gives the same answer (default 0)")
    add_out(parser, "where files go; every run's figures as soon as there are any")
    course_options.add(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Run it and say what came out."""
    options = course_options.chosen_options(chosen)
    result = EXPERIMENTS[chosen.name](runs=chosen.runs, seed=chosen.seed, out=chosen.out, tell=tell, **options)
    if chosen.out is not None and "boards" in result:
        result["files"]["figure_15_scene"] = board_scene(result["boards"], chosen.out)
    if chosen.json:
        write_json(result)
    else:
        write(as_text(result))
    return 0


def board_scene(boards: list[BoardPoseFigures], out: Path) -> str:
    """Figure 15 as a scene to be turned, in one file → its path. Raises Unavailable."""
    from console.scene.calibration_boards import boards_html  # viser takes a moment: only where it is needed
    from core.calibration.files.written import write as write_file
    from core.experiments.camera_table import BOARD
    from core.optics import TABLE_3

    angle = 2 * math.atan(TABLE_3.height / 2 / TABLE_3.fy)
    page = boards_html(boards, BOARD, angle, TABLE_3.width / TABLE_3.height)
    return write_file(out / "figure_15.html", page.encode())


def runs(text: str) -> int:
    """'40' → a number of runs."""
    if not (text.isascii() and text.isdigit() and len(text) <= 9 and 1 <= int(text) <= MOST_RUNS):
        raise argparse.ArgumentTypeError(f"Give a whole number of runs between 1 and {MOST_RUNS}.")
    return int(text)


def seed(text: str) -> int:
    """'7' → a seed."""
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise argparse.ArgumentTypeError("A seed is a whole number from 0 on, of at most 18 digits.")
    return int(text)
