"""The checker catches every violation that it claims to, and the writer leaves nothing out that it needs."""

import math
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from core.gate import Limits, TraceRow, TraceWriter, check, read_trace
from core.gate.status import GateStatus
from core.gate.trace import open_trace
from tests.core.gate.bench import Bench

LIMITS = Limits()


def row(t: float, v: float = 0.0, w: float = 0.0, source: str = "", **more: object) -> TraceRow:
    plain = TraceRow(round(t * 1e9), v, w, source, 1, "", "armed", 0, "")
    return replace(plain, **more)  # type: ignore[arg-type]


ARM = row(1.0, event="arm")


def drive(t: float, v: float = 0.02, press: int = 5, source: str = "jog", **more: object) -> TraceRow:
    return row(t, v, 0.0, source, press=press, **more)


def test_an_orderly_drive_passes() -> None:
    rows = [
        ARM,
        drive(1.02),
        drive(1.04, 0.04),
        row(1.06),
        row(1.08, event="stop", reason="stopped"),
        drive(2.0, press=6),
    ]
    assert check(rows, LIMITS) == []


@pytest.mark.parametrize(
    ("rows", "complaint"),
    [
        ([ARM, drive(5.0, 0.31, reason="x")], "beyond the limits"),
        ([ARM, row(5.0, 0.0, 1.6, "jog")], "beyond the limits"),
        ([ARM, drive(1.02, math.nan)], "not a finite number"),
        ([ARM, drive(1.02, 0.05)], "speed changed by 0.05"),
        ([ARM, drive(1.02, -0.05)], "speed changed by -0.05"),
        ([ARM, row(1.02, 0.0, 0.5, "jog")], "turning changed"),
        ([ARM, drive(1.3, 0.3), drive(1.32, 0.1)], "speed changed by -0.2"),
        ([ARM, drive(1.3, 0.1), drive(1.32, -0.02, reason="slowed")], "speed changed by -0.12"),
        ([drive(1.02)], "not armed"),
        ([ARM, row(1.01, event="disarm", state="disarmed"), drive(1.1)], "not armed"),
        ([ARM, drive(1.02, state="disarmed")], "not armed"),
        ([ARM, row(1.01, event="halt", state="halted"), drive(1.1)], "not armed"),
        ([ARM, row(1.01, event="halt", state="halted"), row(1.02, event="reset"), drive(1.1)], "not armed"),
        ([row(1.0, event="halt", state="halted"), row(1.1, event="arm")], "armed while halted"),
        ([row(1.0, event="halt", state="halted"), row(0.1, event="boot", state="disarmed")], "lifted the halt"),
        ([row(1.0, event="boot", state="halted"), row(1.1, event="arm", state="armed")], "armed while halted"),
        ([ARM, drive(1.02, epoch=2)], "moves for lease 2"),
        ([ARM, row(2.0, epoch=0, event="stop")], "epoch went back"),
        ([ARM, drive(1.02, source="")], "without a source"),
        ([ARM, drive(1.02, source="guard")], "without a source"),
        ([ARM, drive(1.02), row(1.03, event="stop"), drive(1.1)], "moves again after it was stopped"),
        ([ARM, drive(1.02), row(1.03, event="trip"), drive(1.1)], "moves again after it was stopped"),
        (
            [ARM, drive(1.02), row(1.03, event="arm", epoch=2), drive(1.1, epoch=2)],
            "moves again after it was stopped",
        ),
        (
            [ARM, drive(1.02, source="goal"), drive(1.04, press=9), drive(1.06, source="goal")],
            "goal 5 moves again after it was stopped",
        ),
        ([ARM, drive(1.02), row(1.04, 0.02, event="stop", source="jog", press=5)], "moves during 'stop'"),
        ([ARM, drive(1.02), drive(1.7)], "nothing was noted for 0.68 s"),
        ([ARM, row(0.9)], "time ran backwards"),
        ([row(1.0, event="explode")], "no event 'explode'"),
    ],
)
def test_each_violation_is_caught(rows: list[TraceRow], complaint: str) -> None:
    assert any(complaint in words for words in check(rows, LIMITS)), check(rows, LIMITS)


def test_a_stop_may_drop_the_speed_at_once_and_the_guard_may_cut_it() -> None:
    assert check([ARM, drive(1.3, 0.3), row(1.32)], LIMITS) == []
    assert check([ARM, drive(1.3, 0.3), drive(1.32, 0.1, reason="slowed for something near")], LIMITS) == []


def test_a_drive_leaves_a_diary_with_two_rows_a_second_at_least() -> None:
    bench = Bench()
    bench.run(2.0)
    bench.hold("jog", 0.3, seconds=3.0)
    gaps = [b.t_mono_ns - a.t_mono_ns for a, b in zip(bench.rows, bench.rows[1:], strict=False)]
    assert max(gaps) <= 0.5e9 + 1e6
    assert len(bench.rows) < 60
    assert bench.complaints() == []


def test_the_instant_before_a_change_is_written_too() -> None:
    writer = TraceWriter()
    for n in range(10):
        writer.write(GateStatus(v=0.1), 1, "", 0.02 * n)
    writer.write(GateStatus(v=0.2), 1, "", 0.2)
    assert [r.t_mono_ns for r in writer.rows] == [0, 180_000_000, 200_000_000]


def test_a_diary_comes_back_from_its_file_without_the_line_that_was_cut(tmp_path: Path) -> None:
    path = tmp_path / "gate.csv"
    for first in (0, 2):
        line_writer = open_trace(path)
        writer = TraceWriter(line_writer)
        for n in range(first, first + 2):
            writer.write(GateStatus(v=0.1 * n, reason='a "reason", with commas'), n, "", 0.1 * n)
        line_writer.close()
    with path.open("a") as file:
        file.write("12345,0.1")
    rows = read_trace(path)
    assert [r.v for r in rows] == [0.0, 0.1, 0.2, 0.1 * 3]
    assert rows[1].reason == 'a "reason", with commas'
    assert path.read_text().startswith("t_mono_ns,v,w,source,epoch,reason")


def test_a_full_disk_does_not_disturb_the_gate() -> None:
    before = threading.active_count()
    line_writer = open_trace(Path("/dev/full"))
    writer = TraceWriter(line_writer)
    assert threading.active_count() == before + 1
    for n in range(1000):
        writer.write(GateStatus(v=0.1 * n), n, "", 0.1 * n)
    line_writer.close()
    assert threading.active_count() == before  # its thread lived to the end, and ended


def test_another_file_is_no_diary(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match=r"x\.csv is no trace"):
        read_trace(path)
