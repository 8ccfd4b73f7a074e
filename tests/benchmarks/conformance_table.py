"""Every scheme and every check in one table: `python -m tests.benchmarks.conformance_table [--stops 100] [NAME …]`.

Each driver is examined against its emulator on a real wire, as `beckon robot check --drive --interactive` does it,
and stopped so many times. Emulator and simulated robot have a process of their own where they can, so that the driver
does not wait for them. Beside the 99th percentile of the delay from a request to zero on the wire stands that of a
byte between two threads of the driver's process in the same run. The table is Markdown.
"""

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from core.gate import ZERO
from core.robots.conformance import ConformanceReport, Interruption, check_robot
from core.robots.connect import connect
from core.robots.driver_session import DriverSession
from tests.benchmarks.command import print_row, run_command
from tests.core.robots.test_conformance import CHECKS, SUBJECTS, Emulated, Subject, nth_slowest, stop_delays
from tests.emulators.robot_process import KINDS, robot_process

SHARE = 0.99


def cell(subject: Subject, report: ConformanceReport, name: str) -> str:
    """One check of one driver: its figure, or why there is none."""
    mine = [check for check in report.checks if check.name == name or check.name.endswith(f" {name}")]
    if not mine:
        return "–" if name in subject.lacks else "not checked"
    figures = ", ".join(f"{one.figure:.3g} {one.unit}" if one.figure is not None else "ok" for one in mine)
    failed = [one.advice for one in mine if not one.passed]
    return f"FAILED {figures}: {' '.join(failed)}" if failed else figures


def stops_of(robot: Emulated, stops: int) -> str:
    """p99 of a stop's delay, and of the machine's own."""
    if robot.applied is None:
        return "–"
    session = DriverSession(connect(robot.url))
    try:
        session.frames(0.5, ZERO)
        delays, machine = stop_delays(robot, session, stops)
    finally:
        session.close()
    p99, own = (1000 * nth_slowest(values, SHARE) for values in (delays, machine))
    return f"{p99:.1f} ms (machine {own:.1f})"


@contextmanager
def emulated(name: str) -> Iterator[Emulated]:
    """The robot of one row; in this process where it needs a sound card of this process, or no emulator."""
    if name not in KINDS or name == "audio":
        with SUBJECTS[name].make() as robot:
            yield robot
        return
    with robot_process(name) as process:
        yield Emulated(
            process.url,
            restart=Interruption(lambda: process.ask("cut"), lambda: process.ask("restore")),
            applied=None if "drive" in SUBJECTS[name].lacks and name != "srv1" else lambda: process.ask("applied"),
        )


def column(name: str, stops: int) -> dict[str, str]:
    """All cells of one driver."""
    subject = SUBJECTS[name]
    with emulated(name) as robot:
        report = check_robot(robot.url, drive=True, interruption=robot.restart)
        cells = {check: cell(subject, report, check) for check in CHECKS}
        cells["stop p99"] = stops_of(robot, stops)
    cells["load"] = f"{os.getloadavg()[0]:.1f}"
    return cells


def main(names: Sequence[str] = tuple(SUBJECTS), *, stops: int = 100) -> None:
    began, heads = time.monotonic(), (*CHECKS, "stop p99", "load")
    print_row(f"| scheme | {' | '.join(heads)} |\n|{'---|' * (len(heads) + 1)}")
    for name in names:
        cells = column(name, stops)
        print_row(f"| {name} | {' | '.join(cells[head] for head in heads)} |")
    print_row(f"\n{time.monotonic() - began:.0f} s, {stops} stops per driver")


if __name__ == "__main__":
    run_command(main)
