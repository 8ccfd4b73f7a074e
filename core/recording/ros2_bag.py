"""ROS 2 bags: a `.db3` file, or a folder of `.db3` and `.mcap` files with or without its metadata.yaml."""

import re
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from core.errors import BadInput
from core.recording import mcap_file
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings
from core.recording.ros import Envelope
from core.recording.source import open_file, unpack

ZSTD = b"\x28\xb5\x2f\xfd"  # a message that was packed by itself begins so
MOST_STEPS = 2_000  # of the progress callback, one every 100 000 instructions of the database
COUNT = re.compile(r"^( *)message_count: *(\d+) *$", re.MULTILINE)
TROUBLES = (sqlite3.Error, ValueError, OverflowError)  # even the words of a complaint may be damaged
DIGITS = re.compile(r"(\d+)")
PACKED = re.compile(r"compression_mode: *[\"']?file", re.IGNORECASE)


def folder_messages(folder: Path, settings: LogSettings, tally: ReadReport) -> Iterator[Envelope]:
    """Every message of a bag's folder, file after file. Raises BadInput when there is none."""
    found = (path for path in folder.iterdir() if path.suffix in (".db3", ".mcap") and path.is_file())
    files = sorted(
        found, key=lambda path: [int(part) if part.isdecimal() else part for part in DIGITS.split(path.name)]
    )
    text = _metadata(folder / "metadata.yaml")
    if not files:
        if PACKED.search(text) or any(path.suffix in (".zstd", ".zst") for path in folder.iterdir()):
            raise BadInput(f"The files of {folder.name} are packed as a whole; unpack them first: zstd -d *.zstd.")
        raise BadInput(f"{folder.name} holds no .db3 or .mcap file.")
    declared = 0
    for path in files:
        tally.declared = None
        tally.files += 1
        yield from (messages if path.suffix == ".db3" else mcap_file.messages)(path, settings, tally)
        declared += tally.declared or 0
    counts = [(len(indent), int(count)) for indent, count in COUNT.findall(text)]
    tally.declared = min(counts, key=lambda pair: pair[0])[1] if counts else declared or None


def messages(path: Path, settings: LogSettings, tally: ReadReport) -> Iterator[Envelope]:
    """Every message of a `.db3` file in the order it was written. Raises BadInput when it is none."""
    with open_file(path, settings.largest_file) as file:
        if file.read(16) != b"SQLite format 3\0":
            raise BadInput(f"{path.name} is not a ROS 2 bag: it is no SQLite database.")
    base = _open(path, settings)
    budget = max(50 * path.stat().st_size, 4 * settings.largest_block)  # [bytes] that packed messages may unpack to
    try:
        topics = _topics(base, path)
        tally.declared = _count(base)
        for topic, stamp, content in base.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY rowid"):
            if topic not in topics or not isinstance(content, bytes) or not isinstance(stamp, int):
                tally.skip("it is damaged")
                continue
            name, kind, encoding = topics[topic]
            if content.startswith(ZSTD):
                content = _unpacked(content, min(budget, settings.largest_block), tally)
                budget -= len(content)
            yield Envelope(name, kind, encoding, stamp * 1e-9, content)
    except TROUBLES as problem:
        tally.skip("the database is cut or damaged here")
        tally.warn(f"The database says: {str(problem)[:100]}.")
    finally:
        base.close()


def _open(path: Path, settings: LogSettings) -> sqlite3.Connection:
    """A read-only connection that runs nothing the file brings along. Raises BadInput."""
    for mode in ("mode=ro", "mode=ro&immutable=1"):
        steps = iter(range(MOST_STEPS))
        try:
            base = sqlite3.connect(f"{path.resolve().as_uri()}?{mode}", uri=True)
            base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, settings.largest_block)
            base.set_progress_handler(lambda steps=steps: next(steps, None) is None, 100_000)
            base.text_factory = lambda content: content.decode("utf-8", "replace")  # pyright: ignore[reportUnknownLambdaType]
            base.execute("PRAGMA trusted_schema = OFF")
            kinds = dict(base.execute("SELECT name, type FROM sqlite_master WHERE name IN ('topics', 'messages')"))
        except TROUBLES:
            continue
        if kinds == {"topics": "table", "messages": "table"}:
            return base
        base.close()
        raise BadInput(f"{path.name} is a database, but not a ROS 2 bag: it has no tables topics and messages.")
    raise BadInput(f"{path.name} is a damaged database; nothing in it can be read.")


def _topics(base: sqlite3.Connection, path: Path) -> dict[Any, tuple[str, str, str]]:
    try:
        rows = base.execute("SELECT id, name, type, serialization_format FROM topics LIMIT 10000").fetchall()
    except TROUBLES as problem:
        raise BadInput(f"The list of topics of {path.name} is damaged: {str(problem)[:100]}.") from problem
    return {number: (str(name), str(kind), str(encoding)) for number, name, kind, encoding in rows}


def _count(base: sqlite3.Connection) -> int | None:
    try:
        return int(base.execute("SELECT count(*) FROM messages").fetchone()[0])
    except TROUBLES:
        return None


def _unpacked(content: bytes, limit: int, tally: ReadReport) -> bytes:
    try:
        return unpack(content, "zstd", limit, limit)
    except BadRecord as problem:
        tally.skip(str(problem))
        return b""


def _metadata(path: Path) -> str:
    """The bag's description, read as text: only its count of messages matters."""
    try:
        with path.open("rb") as file:
            return file.read(1_000_000).decode("utf-8", "replace")
    except OSError:
        return ""
