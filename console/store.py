"""What must outlast the console: who did what, and how it ended. SQLite, written by a thread of its own.

Whoever records something never waits; rows that pile up meanwhile are committed together, with `synchronous=FULL`.
"""

from __future__ import annotations

import logging
import queue
import sqlite3
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import msgspec

log = logging.getLogger(__name__)

REMEMBERED = 500  # deeds kept at hand
KEPT = 100_000  # deeds kept on disk
PRUNE = 1000  # rows written between two times that the oldest are forgotten
BUSY = 5.0  # [s] to wait for another console that writes to the same file


@dataclass(frozen=True)
class Deed:
    """One row: whatever gives, takes, bounds or ends motion, with who, when, and how it ended."""

    id: int
    what: str  # command | stop | halt | halt_reset | lease | drive | playback | place | login | logout | console
    who: str
    wall: float  # [s] since 1970
    mono: float  # [s] of the console's own clock
    role: str = ""
    source: str = ""
    words: str = ""  # as they arrived
    heard_as: str = ""  # as they were understood
    name: str = ""
    numbers: dict[str, float] = field(default_factory=dict[str, float])
    state: str = "done"  # running | done | refused | cancelled | pre-empted | failed
    remark: str = ""
    ended: float | None = None  # [s] since 1970


COLUMNS = ("run", *(column.name for column in fields(Deed)))
SCHEMA = f"CREATE TABLE IF NOT EXISTS deeds ({', '.join(COLUMNS)}, PRIMARY KEY (run, id))"
WRITE = f"INSERT OR REPLACE INTO deeds VALUES ({', '.join('?' * len(COLUMNS))})"
READ = "SELECT * FROM deeds ORDER BY wall DESC, id DESC LIMIT ?"
FORGET = "DELETE FROM deeds WHERE wall < (SELECT wall FROM deeds ORDER BY wall DESC LIMIT 1 OFFSET ?)"


class Store:
    """The file of deeds, and its writer."""

    def __init__(self, path: Path, run: float, complain: Callable[[str], None]) -> None:
        self._path = path
        self._run = run
        self._complain = complain
        self._waiting: queue.SimpleQueue[Deed | None] = queue.SimpleQueue()
        self._writer = threading.Thread(target=self._write, name="store", daemon=True)

    def open(self) -> list[Deed]:
        """Start the writer; returns what is remembered, oldest first. An unreadable file is told, not raised."""
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            remembered = self._read()
        except (OSError, sqlite3.Error, ValueError, TypeError) as trouble:
            self._trouble(trouble)
            remembered = []
        self._writer.start()
        return remembered

    def keep(self, deed: Deed) -> None:
        """Write a deed, or write it anew."""
        self._waiting.put(deed)

    def close(self) -> None:
        """Write what is waiting and stop."""
        self._waiting.put(None)
        if self._writer.is_alive():
            self._writer.join(2.0)

    def _connect(self) -> sqlite3.Connection:
        base = sqlite3.connect(self._path, timeout=BUSY)
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("PRAGMA synchronous=FULL")
        base.execute(SCHEMA)
        return base

    def _read(self) -> list[Deed]:
        base = self._connect()
        with base:
            base.execute(FORGET, (KEPT,))
            rows = base.execute(READ, (REMEMBERED,)).fetchall()
        base.close()
        return [deed_of(row) for row in reversed(rows)]

    def _write(self) -> None:
        base: sqlite3.Connection | None = None
        over, written = False, 0
        while not over:
            batch = [self._waiting.get()]
            while not self._waiting.empty():
                batch.append(self._waiting.get())
            over = None in batch
            try:
                base = base or self._connect()
                with base:
                    base.executemany(WRITE, [row_of(deed, self._run) for deed in batch if deed is not None])
                    written += len(batch)
                    if written >= PRUNE:
                        base.execute(FORGET, (KEPT,))
                        written = 0
            except (OSError, sqlite3.Error) as trouble:
                self._trouble(trouble)
                base = None
        if base is not None:
            base.close()

    def _trouble(self, trouble: Exception) -> None:
        log.warning("%s: %s", self._path, trouble)
        self._complain("The history cannot be saved on disk now; it is kept in memory only. Check the data folder.")


def row_of(deed: Deed, run: float) -> tuple[Any, ...]:
    """A deed → its row; `run`: when its console started, so that two consoles never share a row."""
    told = {**vars(deed), "words": inert(deed.words), "numbers": msgspec.json.encode(deed.numbers).decode()}
    return (run, *(told[column] for column in COLUMNS[1:]))


def deed_of(row: tuple[Any, ...]) -> Deed:
    """A row → its deed; what was under way when the console went away has failed."""
    told: dict[str, Any] = dict(zip(COLUMNS[1:], row[1:], strict=True))
    told["numbers"] = msgspec.json.decode(told["numbers"], type=dict[str, float])
    deed = Deed(**told)
    if deed.state == "running":
        return replace(deed, state="failed", remark="The console ended before this did.")
    return deed


def inert(words: str) -> str:
    """Words that any text file can hold: what cannot be written in UTF-8 becomes a question mark."""
    return words.encode("utf-8", "replace").decode()
