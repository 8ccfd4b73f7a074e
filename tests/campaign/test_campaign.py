"""The campaign's table: every row is there, every test that it names exists, and its page is that of its figures."""

import time
from pathlib import Path

import pytest

from core.gate import TraceWriter
from core.gate.status import GateStatus
from core.gate.trace import open_trace
from tests.campaign.figures import RowFigure
from tests.campaign.report import PAGE, merged, page, published, state_of, worse
from tests.campaign.rows import ROWS
from tests.campaign.struck import TraceOnlooker, until

TESTS = Path(__file__).parents[1]


def entry(figure: float, bound: float, *, busy: bool = False, driver: str = "sim") -> dict[str, object]:
    of = RowFigure("to zero", figure, "ms", bound, 5, driver)
    told = {"row": "R1", "quantity": of.quantity, "figure": of.figure, "unit": of.unit, "passed": of.passed}
    return {**told, "driver": driver, "is_time": of.is_time, "upper_bound": busy, "why": ""}


def test_there_are_sixty_rows_and_each_is_checked_or_says_why_not() -> None:
    assert [row.row for row in ROWS] == [f"R{number}" for number in range(1, 61)]
    assert all(bool(row.tests or row.measurements) or row.missing for row in ROWS)


@pytest.mark.parametrize("row", [row for row in ROWS if row.tests], ids=lambda row: row.row)
def test_every_test_that_a_row_names_exists(row: object) -> None:
    for node in row.tests:  # type: ignore[attr-defined]
        file, _, name = node.partition("::")
        assert f"def {name}(" in (TESTS / file).read_text() or "::runTest" in node, node


def test_the_page_is_that_of_the_published_figures() -> None:
    assert PAGE.read_text() == page(published()), "run: python -m tests.campaign --publish"


@pytest.mark.parametrize("by_simulator", [True, False])
def test_the_time_of_a_motion_is_by_this_programs_clock_whatever_the_gates_is(
    tmp_path: Path, by_simulator: bool
) -> None:
    file = tmp_path / "gate.csv"
    lines = open_trace(file)
    trace = TraceWriter(lines)
    until(lambda: file.stat().st_size > 0)
    with TraceOnlooker(file) as onlooker:
        began = time.monotonic_ns()
        for v in (0.1, 0.0):
            trace.write(GateStatus(v=v), 1, "", 3.0 + v if by_simulator else time.monotonic())
        until(lambda: onlooker.last_motion > 0)
        assert began <= onlooker.last_motion <= time.monotonic_ns()
    lines.close()


def test_a_figure_that_was_met_and_is_missed_is_worse_but_on_a_busy_machine_shows_nothing() -> None:
    before = [entry(80.0, 100.0)]
    assert worse(before, [entry(90.0, 100.0)]) == []
    assert len(worse(before, [entry(120.0, 100.0)])) == 1
    assert worse(before, [entry(120.0, 100.0, busy=True)]) == []
    assert len(worse([entry(20.0, 100.0)], [entry(60.0, 100.0)])) == 1
    assert worse(before, [entry(120.0, 100.0, driver="foxglove")]) == []


def test_a_row_fails_by_a_miss_and_is_not_shown_by_an_upper_bound() -> None:
    row = ROWS[0]
    suite = {**entry(0.0, 0.0, driver="suite"), "quantity": "tests of the suite"}
    states = {
        "holds": [suite, entry(80.0, 100.0)],
        "in part": [suite],
        "fails": [suite, entry(120.0, 100.0)],
        "not shown": [suite, entry(120.0, 100.0, busy=True)],
        "not run": [],
    }
    assert {name: state_of(row, found) for name, found in states.items()} == {name: name for name in states}


def test_a_run_replaces_what_it_measured_again_and_keeps_the_rest() -> None:
    suite = {**entry(0.0, 0.0, driver="suite"), "quantity": "tests of the suite"}
    again = entry(70.0, 100.0, driver="foxglove")
    assert merged([suite, entry(80.0, 100.0)], [again]) == [suite, again]
