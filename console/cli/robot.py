"""`beckon robot`: check a robot with its driver, or begin a driver."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, add_out, answer, progress, tell
from core.errors import BadInput, Refused
from core.files import write_atomic
from core.sensors.checks import found_faults

if TYPE_CHECKING:
    from core.robots.conformance import ConformanceReport

CONSENT = (
    "The robot will move at 2 cm/s for about a second, twice, then turn by 40° to both sides and, where 70 cm around "
    "it are free, go 40 cm ahead and back. Are the wheels free, or the floor? [y/N] "
)
CUT = "Pull the robot's cable or switch its radio off, then press Enter. "
RESTORE = "Plug it in again, then press Enter. "


def add(subcommands: Any) -> None:
    parser = subcommands.add_parser("robot", help="check a robot, or begin a driver of one's own")
    kinds = parser.add_subparsers(dest="kind", metavar="check|new", required=True)
    check = add_command(kinds, "check", run_check, "try whether a robot does what a driver promises")
    check.add_argument("robot", metavar="URL|robot.toml", help="how it is reached, see beckon robots")
    check.add_argument("--drive", action="store_true", help="let it move, after a question")
    check.add_argument("--yes", action="store_true", help="answer the question: the robot may move")
    check.add_argument("--interactive", action="store_true", help="ask to pull the cable, and to plug it in again")
    new = add_command(kinds, "new", run_new, "write a driver that simulates itself, and its test")
    new.add_argument("name", metavar="NAME", help="of the robot: small letters, digits, underscores")
    add_out(new, "where the two files go (default: here)")


def run_check(chosen: argparse.Namespace) -> int:
    """Print the table. Exit code 1 when a check failed."""
    from core.robots.conformance import Interruption, check_robot  # robots take a second to import: only here

    if chosen.drive and not chosen.yes and asked(CONSENT).strip().lower() not in ("y", "yes"):
        raise Refused("Nothing was moved. Lift the wheels off the floor and answer y, or check without --drive.")
    pulled = Interruption(lambda: asked(CUT), lambda: asked(RESTORE)) if chosen.interactive else None
    with progress() as say:
        report = check_robot(chosen.robot, drive=chosen.drive, compare=chosen.drive, interruption=pulled, say=say)
    width = 2 + max(len(one.name) for one in (*report.checks, *report.not_checked))
    lines: list[str] = []
    for one in report.checks:
        figure = "" if one.figure is None else f"{one.figure:.4g} {one.unit}"
        lines.append(f"{one.name:{width}}{'passed' if one.passed else 'FAILED':13}{figure}".rstrip())
        if not one.passed:
            lines.append(f"{'':{width}}→ {one.advice}")
    lines += [f"{skipped.name:{width}}not checked  {skipped.reason}" for skipped in report.not_checked]
    lines += [f"remark: {remark}" for remark in report.remarks]
    lines += [f"fault {fault.code}: {fault.sentence}" for fault in report.faults]
    failed, asked_for = sum(not one.passed for one in report.checks), len(report.checks)
    left_out = f" {len(report.not_checked)} were not made." if report.not_checked else ""
    lines.append(f"{failed} of {asked_for} checks failed." if failed else f"All {asked_for} checks passed.{left_out}")
    checks = [
        {"name": one.name, "passed": one.passed, "figure": one.figure, "unit": one.unit, "advice": one.advice}
        for one in report.checks
    ]
    found = {
        "robot": chosen.robot,
        "passed": report.passed,
        "checks": checks,
        "not_checked": [one._asdict() for one in report.not_checked],
        "remarks": list(report.remarks),
        "faults": found_faults(report.faults),
        "agreement": agreement_of(report),
    }
    answer(chosen, found, *lines)
    return 1 if failed else 0


def agreement_of(report: ConformanceReport) -> dict[str, object] | None:
    """How far wheels and scans agree, as JSON; None: the robot has not both."""
    found = report.agreement
    if found is None:
        return None
    return {
        "laser": found.laser,
        "moved": bool(found.turns or found.ways),
        "turns": found.turns,
        "ways": found.ways,
        "turn_scale": found.turn_scale,
        "turn_scale_sd": found.turn_sd,
        "way_scale": found.way_scale,
        "way_scale_sd": found.way_sd,
        "lateness_s": found.lateness,
    }


def run_new(chosen: argparse.Namespace) -> int:
    """Write the driver and its test. Raises BadInput where one of them is there already."""
    from core.robots.driver_template import check_name, sources

    check_name(chosen.name)
    folder: Path = chosen.out or Path()
    files = {folder / name: text for name, text in sources(chosen.name).items()}
    there = next((path for path in files if path.exists()), None)
    if there is not None:
        raise BadInput(f"{there.name} is there already; choose another name, or another folder with --out.")
    for path, text in files.items():
        write_atomic(path, text)
    driver, test = files
    return answer(
        chosen,
        {"files": {"driver": str(driver), "test": str(test)}, "url": f"py:{driver}:"},
        f"{driver} and {test} are written. The robot simulates itself until you have done the TODOs.",
        f"Try it with    beckon robot check py:{driver}:",
        f"Drive it with  beckon run --robot py:{driver}:",
    )


def asked(question: str) -> str:
    """A line of the person at the terminal; "" where there is nobody."""
    tell(question)
    return sys.stdin.readline()
