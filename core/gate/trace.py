"""The gate's trace: the twist of the wheels, its time, source and reason; and the checker of traces."""

import contextlib
import csv
import io
import math
import queue
import threading
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Literal

from core.gate.limits import Limits
from core.gate.status import GateStatus


class LineWriter:
    """Appends what `write` is given, in order; beginning with `heading` when the file is new."""

    def __init__(self, path: Path, heading: str = "") -> None:
        """Raises OSError when the file cannot be opened."""
        self._file = path.open("a", newline="", encoding="utf-8")
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="gate-trace", daemon=True)
        if self._file.tell() == 0:
            self.write(heading)
        self._thread.start()

    def write(self, lines: str) -> None:
        """Write this as soon as the disk takes it; never waits."""
        self._lines.put(lines)

    def close(self, patience: float = 1.0) -> None:
        """Write what is left, for `patience` [s] at most."""
        self._lines.put(None)
        self._thread.join(patience)

    def _run(self) -> None:
        while (lines := self._lines.get()) is not None:
            with contextlib.suppress(OSError):
                self._file.write(lines)
                if self._lines.empty():
                    self._file.flush()
        with contextlib.suppress(OSError):
            self._file.close()


Event = Literal["", "boot", "arm", "disarm", "stop", "halt", "reset", "hold", "trip"]
EVENTS: tuple[Event, ...] = ("", "boot", "arm", "disarm", "stop", "halt", "reset", "hold", "trip")
MAX_ROW_GAP_NS = 500_000_000  # after which a row is written though nothing changed


@dataclass(frozen=True)
class TraceRow:
    """One row of the trace."""

    t_mono_ns: int
    v: float  # [m/s]
    w: float  # [rad/s]
    source: str
    epoch: int
    reason: str
    state: str
    press: int
    event: str  # what was done to the gate at this instant; "" for a tick


HEADER = tuple(field.name for field in fields(TraceRow))


class TraceWriter:
    """Keeps rows, in memory or as lines of a file: every change, the instant before it, and at least 2 a second."""

    def __init__(self, line_writer: LineWriter | None = None) -> None:
        """Into a file that was opened by `open_trace`, or into `rows`."""
        self.rows: list[TraceRow] = []
        self._line_writer = line_writer
        self._written: TraceRow | None = None
        self._unwritten: TraceRow | None = None

    def write(self, status: GateStatus, press: int, event: Event, now: float) -> None:
        """Note what the gate says at `now` [s]."""
        stamp = round(now * 1e9)
        state = (status.v, status.w, status.source, status.epoch, status.reason, status.state, press)
        row = TraceRow(stamp, *state, event)
        last = self._written
        changed = last is None or event != "" or astuple(last)[1:-1] != state
        if last is not None and not changed and stamp - last.t_mono_ns < MAX_ROW_GAP_NS:
            self._unwritten = row
            return
        if changed and self._unwritten is not None:
            self._put(self._unwritten)
        self._unwritten = None
        self._put(row)
        self._written = row

    def _put(self, row: TraceRow) -> None:
        if self._line_writer is None:
            self.rows.append(row)
        else:
            self._line_writer.write(_line(astuple(row)))


def open_trace(path: Path) -> LineWriter:
    """Open a trace to append to, or a new one. Raises OSError."""
    return LineWriter(path, _line(HEADER))


def _line(values: Iterable[object]) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(values)
    return line.getvalue()


def read_trace(path: Path) -> list[TraceRow]:
    """Read the rows of a trace; a last line that was cut off is left out. Raises ValueError for anything else."""
    text = path.read_text()
    lines = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
    if not lines or tuple(lines[0]) != HEADER:
        raise ValueError(f"{path.name} is no trace of the gate.")
    return [
        TraceRow(int(t), float(v), float(w), source, int(epoch), reason, state, int(press), event)
        for t, v, w, source, epoch, reason, state, press, event in lines[1:]
    ]


def check(rows: Iterable[TraceRow], limits: Limits) -> list[str]:
    """A trace and the limits that were in force → what was wrong, in words; empty when everything was in order.

    Checks: speeds and their change within the limits; motion only while armed, under the armed lease, on the setpoint
    of a hand or a command; none of a press that was stopped (stop, trip, halt, reset, arming, a restart; by a hold
    only a hand's) or, for a command, overridden by a hand; a halt ends by a reset only; every event stands still; no
    gap while moving.
    """
    inspector = _Inspector(limits)
    for row in rows:
        inspector.look(row)
    return inspector.complaints


class _Inspector:
    def __init__(self, limits: Limits) -> None:
        self.complaints: list[str] = []
        self._limits = limits
        self._last: TraceRow | None = None
        self._armed: int | None = None
        self._halted = False
        self._epoch = 0
        self._moved: set[tuple[str, int]] = set()
        self._spent: set[tuple[str, int]] = set()

    def look(self, row: TraceRow) -> None:
        if row.event not in EVENTS:
            self._complain(row, f"there is no event {row.event!r}")
        self._look_at_speeds(row)
        if row.event:
            self._look_at_event(row)
        if row.v != 0.0 or row.w != 0.0:
            self._look_at_motion(row)
        self._last = row

    def _look_at_speeds(self, row: TraceRow) -> None:
        last, limits = self._last, self._limits
        if not (math.isfinite(row.v) and math.isfinite(row.w)):
            self._complain(row, "a speed is not a finite number")
            return
        if abs(row.v) > limits.max_speed + 1e-9 or abs(row.w) > limits.max_turn_rate + 1e-9:
            self._complain(row, f"speed {row.v:g} m/s, {row.w:g} rad/s is beyond the limits")
        before = (last.v, last.w) if last is not None and row.event != "boot" else (0.0, 0.0)
        elapsed = (row.t_mono_ns - last.t_mono_ns) * 1e-9 if last is not None else 0.0
        if elapsed < 0.0 and row.event != "boot":
            self._complain(row, "time ran backwards")
        if elapsed > 1.2e-9 * MAX_ROW_GAP_NS and any(before) and row.event not in ("hold", "trip"):
            self._complain(row, f"nothing was noted for {elapsed:.2f} s while moving")
        for name, was, now, most in (
            ("speed", before[0], row.v, limits.max_acceleration),
            ("turning", before[1], row.w, limits.max_turn_acceleration),
        ):
            slower = abs(now) <= abs(was) and was * now >= 0.0
            excused = slower and (row.reason != "" or (row.v == 0.0 and row.w == 0.0))
            if not excused and abs(now - was) > most * max(elapsed, 0.0) + 1e-6:
                self._complain(row, f"{name} changed by {now - was:g} in {elapsed:.3f} s")

    def _look_at_event(self, row: TraceRow) -> None:
        if row.v != 0.0 or row.w != 0.0:
            self._complain(row, f"it moves during {row.event!r}")
        if row.epoch < self._epoch and row.event != "boot":
            self._complain(row, "the epoch went back")
        over = {moved for moved in self._moved if row.event != "hold" or moved[0] == "jog"}
        self._spent |= over
        self._moved -= over
        if row.event in ("disarm", "halt", "reset", "boot"):
            self._armed = None
        if row.event == "boot" and self._halted and row.state != "halted":
            self._complain(row, "a restart lifted the halt")
        if row.event in ("halt", "reset", "boot"):
            self._halted = row.state == "halted"
        if row.event == "arm":
            if self._halted:
                self._complain(row, "armed while halted")
            self._armed = row.epoch
        self._epoch = row.epoch

    def _look_at_motion(self, row: TraceRow) -> None:
        press = (row.source, row.press)
        if self._halted or self._armed is None or row.state != "armed":
            self._complain(row, "it moves and is not armed")
        elif row.epoch != self._armed:
            self._complain(row, f"it moves for lease {row.epoch} while {self._armed} is in force")
        if row.source not in ("jog", "goal"):
            self._complain(row, "it moves without a source")
        if press in self._spent:
            self._complain(row, f"{row.source} {row.press} moves again after it was stopped")
        if row.source == "jog":
            self._spent |= {moved for moved in self._moved if moved[0] == "goal"}
        self._moved.add(press)

    def _complain(self, row: TraceRow, words: str) -> None:
        self.complaints.append(f"at {row.t_mono_ns * 1e-9:.3f} s: {words}")
