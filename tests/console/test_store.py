"""Deeds on disk: none lost, none invented."""

from __future__ import annotations

import sqlite3
import time
from pathlib import Path

import pytest

from console.history import History
from console.logins import Person
from console.store import KEPT, REMEMBERED

ANNA = Person("a", "Anna")


def opened(folder: Path) -> History:
    history = History(folder, lambda _: None)
    history.open()
    return history


def test_deeds_come_back_as_they_were(tmp_path: Path) -> None:
    history = opened(tmp_path)
    deed = history.add("command", ANNA, state="running", source="rest", words="turn left", numbers={"angle_rad": 1.5})
    history.end(deed.id, "done", "As asked.")
    history.close()
    again = opened(tmp_path)
    (row,) = again.newest_first(commands_only=True)
    again.close()
    assert (row.id, row.state, row.remark, row.numbers) == (deed.id, "done", "As asked.", {"angle_rad": 1.5})
    assert row.who == "Anna" and row.ended is not None and row.ended >= row.wall


def test_a_deed_ends_once(tmp_path: Path) -> None:
    history = opened(tmp_path)
    deed = history.add("command", ANNA, state="running")
    history.end(deed.id, "cancelled", "first")
    history.end(deed.id, "done", "second")
    found = history.find(deed.id)
    history.close()
    assert found is not None and found.state == "cancelled" and found.remark == "first"


def test_what_cannot_be_written_in_utf8_is_kept_readable(tmp_path: Path) -> None:
    history = opened(tmp_path)
    history.add("command", ANNA, words="half \ud800 a character \x00 '); DROP TABLE deeds; --")
    history.close()
    again = opened(tmp_path)
    (row,) = again.newest_first(commands_only=True)
    again.close()
    assert row.words == "half ? a character \x00 '); DROP TABLE deeds; --"


def test_memory_stays_bounded_and_what_runs_is_not_forgotten(tmp_path: Path) -> None:
    history = opened(tmp_path)
    running = history.add("command", ANNA, state="running")
    for _ in range(3 * REMEMBERED):
        history.add("command", ANNA, state="refused")
    assert len(history.newest_first(commands_only=False)) == REMEMBERED
    history.end(running.id, "done", "")
    found = history.find(running.id)
    history.close()
    assert found is not None and found.state == "done"
    assert KEPT > REMEMBERED


def test_two_consoles_on_one_folder_do_not_overwrite_each_other(tmp_path: Path) -> None:
    one, other = opened(tmp_path), opened(tmp_path)
    one.add("command", ANNA, words="of one")
    other.add("command", ANNA, words="of the other")
    one.close()
    other.close()
    again = opened(tmp_path)
    words = {deed.words for deed in again.newest_first(commands_only=True)}
    again.close()
    assert words == {"of one", "of the other"}


def test_a_damaged_file_is_told_and_does_not_stop_the_console(tmp_path: Path) -> None:
    (tmp_path / "history.sqlite").write_bytes(b"this is no database" * 100)
    told: list[str] = []
    history = History(tmp_path, told.append)
    history.open()
    history.add("command", ANNA)
    history.close()
    assert told and "cannot be saved" in told[0]


def test_the_file_is_written_for_the_worst(tmp_path: Path) -> None:
    history = opened(tmp_path)
    history.add("command", ANNA)
    history.close()
    base = sqlite3.connect(tmp_path / "history.sqlite")
    assert base.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    assert base.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    base.close()


def test_the_file_stays_bounded_while_the_console_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.store.KEPT", 50)
    monkeypatch.setattr("console.store.PRUNE", 100)
    history = opened(tmp_path)
    for _ in range(30):
        for _ in range(20):
            history.add("stop", ANNA)
        time.sleep(0.005)
    history.close()
    base = sqlite3.connect(tmp_path / "history.sqlite")
    assert base.execute("SELECT COUNT(*) FROM deeds").fetchone()[0] <= 50 + 100 + 20
    base.close()


def test_the_revision_counts_commands_and_the_newest_can_be_asked_for(tmp_path: Path) -> None:
    history = opened(tmp_path)
    for number in range(5):
        history.add("command", ANNA, words=str(number))
        history.add("stop", ANNA)
    assert history.revision == 5
    assert [deed.words for deed in history.newest_first(commands_only=True, limit=2)] == ["4", "3"]
    history.close()
