"""Faults and attacks, row by row: `python -m tests.campaign [--rows R1,R15] [--class minutes] [--json] [--publish]`.

A class holds those below it: `seconds` are tests of the suite, `minutes` strikes running consoles some times each,
`hours` and `weekly` do it more often and take in what lasts. `--publish` writes the figures to the documentation.
Ends with 1 where a figure is worse than the published one, or fails for the first time.
"""

import argparse
import datetime
import json
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import psutil

from tests.campaign import report
from tests.campaign.figures import EFFORTS, Effort, Measurement, RowFigure, tested
from tests.campaign.rows import ROWS, CampaignRow

SIZES = tuple(EFFORTS)
LOAD_SAMPLE_S = 0.5


def busy_cores() -> float:
    """Cores that other programs keep busy; nothing of ours runs meanwhile."""
    return psutil.cpu_percent(LOAD_SAMPLE_S) / 100 * (psutil.cpu_count() or 1)


def measured(measurement: Measurement, effort: Effort) -> Iterator[RowFigure]:
    """The figures of a measurement; one that fails is a figure, too."""
    try:
        yield from measurement(effort)
    except Exception as trouble:
        why = f"{measurement.__name__}: {type(trouble).__name__} {trouble}".strip().replace("\n", " ")
        yield RowFigure("measured", 1.0, "failures", 0.0, 1, "sim", why)


def entries(row: CampaignRow, size: str, seconds: float | None = None) -> Iterator[dict[str, Any]]:
    """The figures of a row in this class, or of so much time."""
    effort = replace(EFFORTS[size], seconds=seconds or EFFORTS[size].seconds)
    checks: list[Any] = [lambda _: [tested(row.tests)]] if row.tests else []
    if SIZES.index(size) >= max(1, SIZES.index(row.size)):
        checks += [lambda effort, one=one: measured(one, effort) for one in row.measurements]
    for check in checks:
        begun, load = time.monotonic(), busy_cores()
        found = list(check(effort))
        load = round(max(load, busy_cores()), 1)
        for one in found:
            yield {
                "row": row.row,
                "goal": row.goal,
                "quantity": one.quantity,
                "figure": one.figure,
                "unit": one.unit,
                "bound": one.bound,
                "passed": one.passed,
                "driver": one.driver,
                "why": one.why,
                "trials": one.trials,
                "load": load,
                "is_time": one.is_time,
                "upper_bound": one.is_time and load > report.QUIET_LOAD,
                "seconds": round(time.monotonic() - begun, 1),
                "class": size,
                "date": datetime.date.today().isoformat(),
            }


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__)
    parser.add_argument("--rows", default="", help="R1,R15: these alone")
    parser.add_argument("--class", dest="size", choices=SIZES, default="minutes")
    parser.add_argument("--seconds", type=float, help="for which is watched, instead of the class's time")
    parser.add_argument("--json", action="store_true", help="one object on standard output")
    parser.add_argument("--publish", action="store_true", help="write the report of the documentation")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    """Run the rows → 1 where one is worse than published."""
    given = parse(arguments)
    named = set(filter(None, given.rows.upper().split(",")))
    if unknown := named - {row.row for row in ROWS}:
        sys.stderr.write(f"There is no row {', '.join(sorted(unknown))}: they are R1 to R{len(ROWS)}.\n")
        return 2
    found: list[dict[str, Any]] = []
    before = report.published()["rows"]
    today = datetime.date.today().isoformat()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("Terminated."))  # what was started ends, too
    for row in ROWS:
        if not named or row.row in named:
            for entry in entries(row, given.size, given.seconds):
                found.append(entry)
                verdict = "ok" if entry["passed"] else "busy" if report.inconclusive(entry) else "MISS"
                figure = f"{entry['figure']:g} {entry['unit']} (bound {entry['bound']:g}, n {entry['trials']})"
                line = (
                    f"{entry['row']:4}{verdict:5}{entry['driver']:12}{entry['quantity']}: {figure} {entry['why']}\n"
                )
                sys.stderr.write(line)
            if given.publish:
                report.publish([entry for entry in found if entry["row"] == row.row], today)
    left_out = [
        {
            "row": row.row,
            "goal": row.goal,
            "figure": None,
            "unit": "",
            "passed": False,
            "driver": "",
            "why": row.missing,
        }
        for row in ROWS
        if row.missing and (not named or row.row in named)
    ]
    if given.json:
        told = {"rows": [*found, *left_out], "machine": report.machine()}
        sys.stdout.write(json.dumps({**told, "version": report.version("beckon-console"), "date": today}) + "\n")
    known = {report.key(entry) for entry in before}
    first = [
        f"{entry['row']} ({entry['driver']}, {entry['quantity']}): {entry['figure']:g} {entry['unit']} {entry['why']}"
        for entry in found
        if not entry["passed"] and not report.inconclusive(entry) and report.key(entry) not in known
    ]
    sentences = [*report.worse(before, found), *first]
    sys.stderr.writelines(f"Worse than published: {sentence}\n" for sentence in sentences)
    return int(bool(sentences))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
