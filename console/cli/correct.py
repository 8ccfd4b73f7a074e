"""`beckon correct`: straight pictures from a calibrated camera's bent ones (Table 1)."""

import argparse
from pathlib import Path
from typing import Any

from console.cli.answer import add_command, add_out, answer, progress


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "correct", run, "take the lens's distortion out of pictures")
    parser.add_argument("images", nargs="+", type=Path, metavar="IMAGE")
    parser.add_argument("--camera", type=Path, required=True, metavar="CAMERA.json", help="the calibrated camera")
    add_out(parser, "where the straight pictures go", required=True)
    parser.add_argument(
        "--method",
        choices=("exact", "table-1"),
        default="exact",
        help="exact, or the chapter's inverse model on 40 x 40 tie-points",
    )


def run(chosen: argparse.Namespace) -> int:
    from console.cli.calibration_words import correction_lines
    from core.pipelines.correct import correct

    with progress() as shown:
        report = correct(chosen.images, chosen.camera, chosen.out, chosen.method, shown)
    return answer(chosen, report, *correction_lines(report))
