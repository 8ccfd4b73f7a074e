"""The published figures: `published.json` beside this file, and the page of the documentation made of it."""

import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import psutil

from tests.campaign.figures import ROOT
from tests.campaign.rows import ROWS, CampaignRow

PUBLISHED = Path(__file__).parent / "published.json"
PAGE = ROOT / "static/docs/reliability.md"
QUIET_LOAD = 1.0  # cores busy with other programs, above which a time is an upper bound
MAX_TIME_RATIO = 1.5  # times the published time, on quiet machines both, is worse
SUITE_DRIVER = "suite"
INTRODUCTION = """# Reliability

Sixty faults and attacks, the goal for each, and the figure that was measured. The page is written by
`python -m tests.campaign --publish`; a run that is worse than this page ends with an error.
[Safety](explanation/safety.md) explains the means; [What happens when …](reference/what-happens-when.md) shows what
an operator sees, fault by fault.

*Other programs* is the number of processor cores that other programs kept busy. Above 1, a time is an upper bound
(≤): it shows that a goal is met, and not that one is missed. Drivers: *sim* is the simulated robot, *foxglove* and
*serial+scip* are whole drivers on sockets with emulated robots at the other end, *suite* are tests of the suite.
"""


def machine() -> str:
    system = f"{platform.system()} {platform.release().partition('-')[0]}, {platform.machine()}"
    return f"{psutil.cpu_count()} cores, {system}, Python {platform.python_version()}"


def published() -> dict[str, Any]:
    """The published report; empty before the first one."""
    return json.loads(PUBLISHED.read_text()) if PUBLISHED.exists() else {"rows": []}


def key(entry: dict[str, Any]) -> tuple[str, str, str]:
    return entry["row"], entry["driver"], entry["quantity"]


def is_suite(entry: dict[str, Any]) -> bool:
    return entry["driver"] == SUITE_DRIVER and entry["quantity"] == "tests of the suite"


def merged(old: list[dict[str, Any]], new: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The new figures, and those of the old report whose tests or measurements were not run again."""
    again = {(entry["row"], is_suite(entry)) for entry in new}
    kept = [entry for entry in old if (entry["row"], is_suite(entry)) not in again]
    return sorted([*kept, *new], key=lambda entry: (int(entry["row"][1:]), not is_suite(entry)))


def inconclusive(entry: dict[str, Any]) -> bool:
    """A time above its goal on a busy machine shows nothing."""
    return not entry["passed"] and entry["upper_bound"]


def worse(old: list[dict[str, Any]], new: list[dict[str, Any]]) -> list[str]:
    """A sentence for each figure that is worse than the published one."""
    before = {key(entry): entry for entry in old}
    found: list[str] = []
    for entry in new:
        was = before.get(key(entry))
        if was is None or inconclusive(entry):
            continue
        quiet = not (entry["upper_bound"] or was["upper_bound"])
        slower = entry["is_time"] and quiet and entry["figure"] > MAX_TIME_RATIO * was["figure"] + 1.0
        if (was["passed"] and not entry["passed"]) or slower:
            now = f"{entry['figure']:g} {entry['unit']}"
            found.append(
                f"{entry['row']} ({entry['driver']}, {entry['quantity']}): {now}, published {was['figure']:g}."
            )
    return found


def state_of(row: CampaignRow, entries: list[dict[str, Any]]) -> str:
    """How a row stands: holds, fails, not shown, not run."""
    if row.missing:
        return "not checked"
    expected = bool(row.tests) + bool(row.measurements)
    kinds = {is_suite(entry) for entry in entries}
    if any(not entry["passed"] and not inconclusive(entry) for entry in entries):
        return "fails"
    if any(inconclusive(entry) for entry in entries):
        return "not shown"
    return "holds" if len(kinds) == expected else "in part" if kinds else "not run"


STATES_WORST_FIRST = ("fails", "not shown", "not checked", "not run", "in part", "holds")


def page(report: dict[str, Any]) -> str:
    """The page of the documentation, misses first."""
    of = {row.row: [entry for entry in report["rows"] if entry["row"] == row.row] for row in ROWS}
    states = {row.row: state_of(row, of[row.row]) for row in ROWS}
    counts = ", ".join(
        f"{count} {state}" for state in STATES_WORST_FIRST if (count := list(states.values()).count(state))
    )
    lines = [
        INTRODUCTION,
        f"Machine: {report['machine']}. Beckon {report['version']}, {report['date']}. Of {len(ROWS)} rows: {counts}.",
        "",
        "| row | fault | goal | state | driver | figure | bound | tried | other programs | date |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in sorted(ROWS, key=lambda one: (STATES_WORST_FIRST.index(states[one.row]), one.number)):
        start = f"| {row.row} | {row.fault} | {row.goal} | {states[row.row]} "
        if not of[row.row]:
            why = row.missing or f"measured in the class *{row.size}*"
            lines.append(f"{start}| | {why} | | | | |")
        for entry in of[row.row]:
            figure = f"{'≤ ' if entry['upper_bound'] else ''}{entry['figure']:g} {entry['unit']}"
            note = f" ({entry['why'].rstrip('.')})" if entry["why"] and not is_suite(entry) else ""
            lines.append(
                f"{start}| {entry['driver']} | {entry['quantity']}: {figure}{note} | {entry['bound']:g} | "
                f"{entry['trials']} | {entry['load']:g} | {entry['date']} |"
            )
            start = "| | | | "
        if row.instead and states[row.row] != "holds":
            lines.append(f"{start}| | What protects instead: {row.instead} | | | | |")
    return "\n".join(lines) + "\n"


def publish(new: list[dict[str, Any]], date: str) -> dict[str, Any]:
    """Write both files → the report."""
    rows = merged(published()["rows"], new) if new else published()["rows"]
    report = {"machine": machine(), "version": version("beckon-console"), "date": date, "rows": rows}
    PUBLISHED.write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    PAGE.write_text(page(report))
    return report
