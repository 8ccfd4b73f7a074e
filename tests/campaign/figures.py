"""A figure of a row, and the two kinds of checks that make some: tests of the suite, and measurements."""

import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEST_TIMEOUT_S = 580.0
TIME_UNITS = ("ms", "s", "a minute")  # the last: of stops by time


@dataclass(frozen=True)
class RowFigure:
    """One figure with the bound that it must not exceed."""

    quantity: str
    figure: float
    unit: str
    bound: float
    trials: int
    driver: str = "sim"
    why: str = ""

    @property
    def passed(self) -> bool:
        return self.trials > 0 and self.figure <= self.bound

    @property
    def is_time(self) -> bool:
        """A time depends on what else the machine does."""
        return self.unit in TIME_UNITS


@dataclass(frozen=True)
class Effort:
    """How much is tried: `trials` of what needs a console each, `seconds` of what is watched, from the seed on."""

    trials: int
    seconds: float
    seed: int = 1


EFFORTS = {
    "seconds": Effort(2, 10.0),
    "minutes": Effort(6, 20.0),
    "hours": Effort(50, 300.0),
    "weekly": Effort(200, 3600.0),
}

Measurement = Callable[[Effort], Iterable[RowFigure]]


def worst(quantity: str, times: list[float], bound: float, driver: str = "sim", unit: str = "ms") -> RowFigure:
    """The largest of some times."""
    return RowFigure(quantity, round(max(times), 1), unit, bound, len(times), driver)


def p99(quantity: str, times: list[float], bound: float, driver: str = "sim") -> RowFigure:
    """The value [ms] below which 99 of 100 lie."""
    rank = min(int(0.99 * len(times)), len(times) - 1)
    return RowFigure(f"{quantity}, p99", round(sorted(times)[rank], 1), "ms", bound, len(times), driver)


def none_of(quantity: str, count: int, trials: int, unit: str, driver: str = "sim") -> RowFigure:
    return RowFigure(quantity, float(count), unit, 0.0, trials, driver)


def run_tests(nodes: Iterable[str], folder: Path) -> dict[str, bool]:
    """Run tests of the suite, one after another → `file::test` and whether all of its cases passed.

    A case that was skipped passed nothing; a test that did not run is missing.
    """
    report = folder / "tests.xml"
    options = [
        "-n",
        "0",
        "-m",
        "",
        "-q",
        "-p",
        "no:cacheprovider",
        f"--junitxml={report}",
        "-o",
        "junit_family=xunit1",
    ]
    command = [sys.executable, "-m", "pytest", *options, *nodes]
    try:
        subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, timeout=TEST_TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired:
        return {}
    if not report.exists():
        return {}
    passed: dict[str, bool] = {}
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        module = "/".join(part for part in str(case.get("classname")).split(".") if not part[:1].isupper())
        node = f"{module}.py::{str(case.get('name')).partition('[')[0]}"
        fine = not any(case.find(outcome) is not None for outcome in ("failure", "error", "skipped"))
        passed[node] = passed.get(node, True) and fine
    return passed


def plain(node: str) -> str:
    """`file::class::test` → `file::test`, as the report of pytest has it."""
    file, _, name = node.partition("::")
    return f"{file}::{name.rpartition('::')[2]}"


def tested(nodes: tuple[str, ...]) -> RowFigure:
    """How many of these tests do not pass."""
    with tempfile.TemporaryDirectory() as folder:
        passed = run_tests([f"tests/{node}" for node in nodes], Path(folder))
    failed = [node for node in nodes if not passed.get(f"tests/{plain(node)}", False)]
    why = "" if not failed else "not passed: " + ", ".join(node.rpartition("::")[2] for node in failed)
    return RowFigure(
        "tests of the suite", float(len(failed)), f"failed of {len(nodes)}", 0.0, len(nodes), "suite", why
    )
