"""The stored history: entries with their person and their end. SQLite, written by a thread of its own.

Recording never waits, but a caller may ask when all of it is on disk. Rows that pile up meanwhile are
committed together, with `synchronous=FULL`; rows that the disk refused are kept and written when it takes them again.
"""

import logging
import queue
import sqlite3
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import msgspec

from core.sentences import SentenceCode, Statement, code_of, coded

log = logging.getLogger(__name__)

MAX_REMEMBERED_ENTRIES = 500  # entries kept at hand
MAX_KEPT_ENTRIES = 100_000  # entries kept on disk
PRUNE_ROWS = 1000  # rows written between two times that the oldest are forgotten
BUSY_TIMEOUT_S = 5.0  # to wait for another console that writes to the same file
RETRY_S = 1.0  # after which rows that the disk refused are tried again
MOST_WAITING = 20_000  # of those rows; beyond, the oldest are lost


@dataclass(frozen=True)
class HistoryEntry:
    """One row: an event that gives, takes, bounds or ends motion, with its person, time, and end."""

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


UNSAVED = (
    "The history cannot be saved on disk now; it is kept in memory, and written when the disk takes it again. "
    "Check the data folder."
)
COLUMNS = ("run", *(column.name for column in fields(HistoryEntry)), SAID := "said")  # the code of the remark
TABLE = "deeds"  # in files that exist
SCHEMA = f"CREATE TABLE IF NOT EXISTS {TABLE} ({', '.join(COLUMNS)}, PRIMARY KEY (run, id))"
WRITE = f"INSERT OR REPLACE INTO {TABLE} VALUES ({', '.join('?' * len(COLUMNS))})"
READ = f"SELECT * FROM {TABLE} ORDER BY id DESC, run DESC LIMIT ?"
FORGET = f"DELETE FROM {TABLE} WHERE id < (SELECT id FROM {TABLE} ORDER BY id DESC LIMIT 1 OFFSET ?)"


class HistoryStore:
    def __init__(self, path: Path, run: float, complain: Callable[[str], None]) -> None:
        """`complain`, from any thread: why rows are not on disk, and "" when they are again."""
        self._path = path
        self._run = run
        self._complain = complain
        self._waiting: queue.SimpleQueue[HistoryEntry | Future[bool] | None] = queue.SimpleQueue()
        self._kept, self._safe = 0, 0  # rows given to it, and how many of them were on disk when it was last idle
        self._refused: dict[int, HistoryEntry] = {}  # what the disk did not take yet, by number
        self._lost = 0  # rows that were too many to wait
        self.trouble = ""  # why nothing is written now
        self._writer = threading.Thread(target=self._write, name="store", daemon=True)

    def open(self) -> list[HistoryEntry]:
        """Start the writer; return the stored entries, oldest first. An unreadable file is reported, not raised."""
        try:
            remembered = self._read()
        except (OSError, sqlite3.Error, ValueError, msgspec.MsgspecError) as trouble:
            self._failed(trouble, "The history of before cannot be read; check history.sqlite in the data folder.")
            remembered = []
        self._writer.start()
        return remembered

    def keep(self, entry: HistoryEntry) -> None:
        self._kept += 1
        self._waiting.put(entry)

    def settled(self) -> Future[bool] | None:
        """Done when all entries so far are on disk (True) or refused by it (False); None when they are there."""
        if self._safe == self._kept:
            return None
        settled: Future[bool] = Future()
        self._waiting.put(settled)
        return settled

    def close(self) -> None:
        self._waiting.put(None)
        if self._writer.is_alive():
            self._writer.join(2.0)

    def _connect(self) -> sqlite3.Connection:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        base = sqlite3.connect(self._path, timeout=BUSY_TIMEOUT_S)
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("PRAGMA synchronous=FULL")
        base.execute(SCHEMA)
        if SAID not in (column for _, column, *_ in base.execute(f"PRAGMA table_info({TABLE})")):
            base.execute(f"ALTER TABLE {TABLE} ADD COLUMN {SAID}")  # a file of before there were codes
        return base

    def _read(self) -> list[HistoryEntry]:
        base = self._connect()
        with base:
            base.execute(FORGET, (MAX_KEPT_ENTRIES,))
            rows = base.execute(READ, (MAX_REMEMBERED_ENTRIES,)).fetchall()
        base.close()
        return [entry_of(row) for row in reversed(rows)]

    def _write(self) -> None:
        base: sqlite3.Connection | None = None
        over, written, kept, tried = False, 0, 0, 0.0
        while not over:
            batch = self._next_batch()
            over = None in batch
            rows = [one for one in batch if isinstance(one, HistoryEntry)]
            kept += len(rows)
            self._refused |= {entry.id: entry for entry in rows}
            if time.monotonic() - tried >= RETRY_S or not self.trouble or over:
                tried = time.monotonic()
                due = written + len(rows) >= PRUNE_ROWS
                base = self._attempt(base, forget=due)
                written = 0 if due else written + len(rows)
            if not self._refused:
                self._safe = kept
            for one in batch:
                if isinstance(one, Future) and one.set_running_or_notify_cancel():
                    one.set_result(not self._refused)
        if base is not None:
            base.close()

    def _next_batch(self) -> list[HistoryEntry | Future[bool] | None]:
        batch: list[HistoryEntry | Future[bool] | None] = []
        try:
            batch.append(self._waiting.get(timeout=RETRY_S if self._refused else None))
            while True:
                batch.append(self._waiting.get_nowait())
        except queue.Empty:
            return batch

    def _attempt(self, base: sqlite3.Connection | None, *, forget: bool) -> sqlite3.Connection | None:
        try:
            if base is not None and not self._path.exists():  # the file was removed: rows written there are lost
                base.close()
                base = None
            base = base or self._connect()
            with base:
                base.executemany(WRITE, [row_of(entry, self._run) for entry in self._refused.values()])
                if forget:
                    base.execute(FORGET, (MAX_KEPT_ENTRIES,))
        except (OSError, sqlite3.Error) as trouble:
            self._failed(trouble, UNSAVED)
            return None
        self._refused.clear()
        if self.trouble:
            log.info("The history is written again; %d rows were lost.", self._lost)
            self.trouble = ""
            self._complain("")
        return base

    def _failed(self, trouble: Exception, words: str) -> None:
        while len(self._refused) > MOST_WAITING:
            del self._refused[next(iter(self._refused))]
            self._lost += 1
        if self.trouble != words:
            log.warning("%s: %s", self._path, trouble)
            self.trouble = words
            self._complain(words)


def row_of(entry: HistoryEntry, run: float) -> tuple[Any, ...]:
    """An entry → its row; `run`: when its console started, so that two consoles never share a row."""
    numbers, said = (msgspec.json.encode(one).decode() for one in (entry.numbers, code_of(entry.remark)))
    columns = {**vars(entry), "numbers": numbers, SAID: said}
    values = (columns[column] for column in COLUMNS[1:])
    return (run, *(inert(value) if isinstance(value, str) else value for value in values))


def entry_of(row: tuple[Any, ...]) -> HistoryEntry:
    """A row → its entry; a command that was under way when the console ended has failed."""
    columns: dict[str, object] = dict(zip(COLUMNS[1:], row[1:], strict=True))
    columns["numbers"] = msgspec.json.decode(str(columns["numbers"]))
    said = msgspec.json.decode(str(columns.pop(SAID) or "[null,null]"), type=SentenceCode)
    entry = msgspec.convert(columns, HistoryEntry)
    if entry.state == "running":
        return replace(entry, state="failed", remark=Statement("command.console_ended"))
    return replace(entry, remark=coded(entry.remark, said))


def inert(words: str) -> str:
    """Words that any text file can hold: what cannot be written in UTF-8 becomes a question mark."""
    return words.encode("utf-8", "replace").decode()
