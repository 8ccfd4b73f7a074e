"""`beckon experiment`: compute one figure or table again, or one for every setting of a grid."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

from console.cli import course_options
from console.cli.answer import add_json, add_out, progress, tell, write, write_json
from core.errors import BadSettings
from core.experiments import EXPERIMENTS
from core.experiments.campaign import REPORT_EVERY_S, Campaign
from core.experiments.result import BoardPoseFigures, as_text

MOST_RUNS = 100_000
MAX_WORKERS = 1024
SWEEP = "sweep"
TERMINAL_EVERY_S = 0.2  # of a progress that changes in its line


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("experiment", help="compute a figure or a table again")
    names = sorted(EXPERIMENTS)
    parser.add_argument("name", choices=[*names, SWEEP], metavar="NAME", help=", ".join(names) + "; or sweep NAME")
    parser.add_argument("swept", nargs="?", choices=names, metavar="NAME", help="sweep: the experiment")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="SECTION.SETTING=A,B,…",
        help="sweep: a setting and its values, as ekf.gate=3,5,9; with several of them all combinations",
    )
    parser.add_argument("--runs", type=runs, default=None, help="how often (the experiment's own number)")
    parser.add_argument("--seed", type=seed, default=0, help="the same seed gives the same answer (default 0)")
    add_out(parser, "where files go; every run's figures as soon as it is done")
    parser.add_argument(
        "--workers",
        type=workers,
        metavar="N",
        help="processes on this computer, or of the cluster at the most; the answer does not depend on it",
    )
    parser.add_argument("--cluster", default="", metavar="tcp://HOST:8786", help="scheduler of a dask cluster")
    parser.add_argument("--resume", action="store_true", help="go on with the runs that lack in --out")
    course_options.add(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Run it and say what came out."""
    if chosen.resume and chosen.out is None:
        raise BadSettings("--resume goes on with the runs in a folder; give it with --out DIR.")
    name = chosen.swept if chosen.name == SWEEP else chosen.name
    if (name is None) or (chosen.name != SWEEP and (chosen.swept is not None or chosen.set)):
        raise BadSettings("A sweep is `beckon experiment sweep NAME --set SECTION.SETTING=A,B,…`.")
    options = {"runs": chosen.runs, **course_options.chosen_options(chosen, name)}
    with progress() as say:
        campaign = Campaign(
            name if chosen.name != SWEEP else f"{SWEEP}-{name}",
            chosen.seed,
            chosen.out,
            tell,
            chosen.workers,
            chosen.cluster,
            chosen.resume,
            say,
            TERMINAL_EVERY_S if sys.stderr.isatty() else REPORT_EVERY_S,
        )
        if chosen.name == SWEEP:
            from core.experiments.sweep import sweep  # all settings: they take a moment

            result = campaign.carry_out(sweep(name, chosen.set, {**options, "seed": chosen.seed}))
        else:
            result = EXPERIMENTS[name].carry_out(campaign, options)
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
    return _number(text, MOST_RUNS, "runs")


def workers(text: str) -> int:
    """'4' → a number of processes."""
    return _number(text, MAX_WORKERS, "processes")


def _number(text: str, most: int, of: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 9 and 1 <= int(text) <= most):
        raise argparse.ArgumentTypeError(f"Give a whole number of {of} between 1 and {most}.")
    return int(text)


def seed(text: str) -> int:
    """'7' → a seed."""
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise argparse.ArgumentTypeError("A seed is a whole number from 0 on, of at most 18 digits.")
    return int(text)
