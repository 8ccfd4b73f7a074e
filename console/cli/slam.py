"""`beckon slam`: a log through the estimator, offline, as fast as it goes."""

import argparse
import time
from pathlib import Path
from typing import Any

from console.cli.answer import add_command, add_out, answer, progress


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "slam", run, "a recording through the estimator, offline")
    parser.add_argument(
        "log",
        metavar="LOG",
        help="MCAP, ROS bag, CARMEN text, JSON lines, .npz or a folder; FILE#N picks a run or robot",
    )
    add_out(parser, "where trajectory, map and landmarks go")
    parser.add_argument("--settings", type=Path, metavar="FILE.toml")
    parser.add_argument(
        "--ids",
        choices=("given", "hidden"),
        default="given",
        help="whether identities in the log are shown to the filter",
    )
    parser.add_argument("--still", action="store_true", help="take in the frames before the robot moved")
    parser.add_argument(
        "--sensors",
        metavar="LIST",
        help="estimate from these alone, of laser,camera,microphones; what they see and hear becomes landmarks",
    )


def run(chosen: argparse.Namespace) -> int:
    from core.pipelines.slam import ChosenSensors, slam_log  # scipy and OpenCV take a moment: only where needed
    from core.settings import load

    began = time.perf_counter()
    with progress() as shown:
        sensors = None if chosen.sensors is None else ChosenSensors.named(chosen.sensors)
        result = slam_log(chosen.log, load(chosen.settings), chosen.ids, chosen.still, chosen.out, shown, sensors)
    report, took = result.json(), round(time.perf_counter() - began, 3)
    report["processing_s"] = took
    lines = [
        f"{report['form']}: {report['frames']} readings over {report['duration_s']:.1f} s in {took:.1f} s",
        f"path {report['path_m']:.2f} m, {len(report['landmarks'])} landmarks, {report['skipped']} records skipped",
        *_scales(report),
        *_errors(report),
        *(f"note: {warning}" for warning in report["warnings"]),
        *(f"{name}: {path}" for name, path in report["files"].items() if path),
    ]
    return answer(chosen, report, *lines, warnings=report["warnings"])


def _scales(report: Any) -> list[str]:
    found = report.get("wheels_over_scans", {})
    known = [(name, found[name], found[f"{name}_sd"]) for name in ("way", "turn") if found.get(name) is not None]
    return [f"{name}s by the wheels are {scale:.3f} ± {sd:.3f} times those by the scans" for name, scale, sd in known]


def _errors(report: Any) -> list[str]:
    if "error" not in report:
        return []
    error = report["error"]
    return [f"off the true position by {error['mean_m']:.3f} m in the mean, {error['worst_m']:.3f} m at worst"]
