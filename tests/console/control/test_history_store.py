"""Deeds on disk: none lost, none invented."""

import asyncio
import shutil
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from console.access.logins import Person
from console.control.history import REFUSED_ALLOWANCE, VIEWER_ALLOWANCE, VIEWERS_ALLOWANCE, History
from console.control.history_store import MAX_KEPT_ENTRIES, MAX_REMEMBERED_ENTRIES
from tests.console.live import full_disk

ANNA = Person("a", "Anna")
REPOSITORY = Path(__file__).parents[3]


def opened(folder: Path) -> History:
    history = History(folder, lambda _: None)
    history.open()
    return history


def test_deeds_come_back_as_they_were(tmp_path: Path) -> None:
    history = opened(tmp_path)
    entry = history.add(
        "command", ANNA, state="running", source="rest", words="turn left", numbers={"angle_rad": 1.5}
    )
    history.end(entry.id, "done", "As asked.")
    history.close()
    again = opened(tmp_path)
    (row,) = again.newest_first(commands_only=True)
    again.close()
    assert (row.id, row.state, row.remark, row.numbers) == (entry.id, "done", "As asked.", {"angle_rad": 1.5})
    assert row.who == "Anna" and row.ended is not None and row.ended >= row.wall


def test_a_deed_ends_once(tmp_path: Path) -> None:
    history = opened(tmp_path)
    entry = history.add("command", ANNA, state="running")
    history.end(entry.id, "cancelled", "first")
    history.end(entry.id, "done", "second")
    found = history.find(entry.id)
    history.close()
    assert found is not None and found.state == "cancelled" and found.remark == "first"


def test_what_cannot_be_written_in_utf8_is_kept_readable(tmp_path: Path) -> None:
    history = opened(tmp_path)
    history.add("command", ANNA, words="half \ud800 a character \x00 '); DROP TABLE deeds; --", remark="\udfff")
    history.close()
    again = opened(tmp_path)
    (row,) = again.newest_first(commands_only=True)
    again.close()
    assert row.words == "half ? a character \x00 '); DROP TABLE deeds; --"


def test_memory_stays_bounded_and_what_runs_is_not_forgotten(tmp_path: Path) -> None:
    history = opened(tmp_path)
    running = history.add("command", ANNA, state="running")
    for _ in range(3 * MAX_REMEMBERED_ENTRIES):
        history.add("command", ANNA)
    assert len(history.newest_first(commands_only=False)) == MAX_REMEMBERED_ENTRIES
    history.end(running.id, "done", "")
    found = history.find(running.id)
    history.close()
    assert found is not None and found.state == "done"
    assert MAX_KEPT_ENTRIES > MAX_REMEMBERED_ENTRIES


def test_two_consoles_on_one_folder_do_not_overwrite_each_other(tmp_path: Path) -> None:
    one, other = opened(tmp_path), opened(tmp_path)
    one.add("command", ANNA, words="of one")
    other.add("command", ANNA, words="of the other")
    one.close()
    other.close()
    again = opened(tmp_path)
    words = {entry.words for entry in again.newest_first(commands_only=True)}
    again.close()
    assert words == {"of one", "of the other"}


def test_a_damaged_file_is_told_and_does_not_stop_the_console(tmp_path: Path) -> None:
    (tmp_path / "history.sqlite").write_bytes(b"this is no database" * 100)
    told: list[str] = []
    history = History(tmp_path, told.append)
    history.open()
    history.add("command", ANNA)
    history.close()
    assert told and "cannot be read" in told[0] and "cannot be saved" in told[1]


def test_the_file_is_written_for_the_worst(tmp_path: Path) -> None:
    history = opened(tmp_path)
    history.add("command", ANNA)
    history.close()
    base = sqlite3.connect(tmp_path / "history.sqlite")
    assert base.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    assert base.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    base.close()


def test_the_file_stays_bounded_while_the_console_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.control.history_store.MAX_KEPT_ENTRIES", 50)
    monkeypatch.setattr("console.control.history_store.PRUNE_ROWS", 100)
    history = opened(tmp_path)
    for _ in range(30):
        for _ in range(20):
            history.add("stop", ANNA)
        time.sleep(0.005)
    history.close()
    base = sqlite3.connect(tmp_path / "history.sqlite")
    assert base.execute("SELECT COUNT(*) FROM deeds").fetchone()[0] <= 50 + 100
    base.close()


def test_the_revision_counts_commands_and_the_newest_can_be_asked_for(tmp_path: Path) -> None:
    history = opened(tmp_path)
    for number in range(5):
        history.add("command", ANNA, words=str(number))
        history.add("stop", ANNA)
    assert history.revision == 5
    assert [entry.words for entry in history.newest_first(commands_only=True, limit=2)] == ["4", "3"]
    history.close()


def on_disk(folder: Path) -> list[str]:
    """The words of all rows that another program finds, by number."""
    base = sqlite3.connect(folder / "history.sqlite")
    rows = base.execute("SELECT words FROM deeds ORDER BY id").fetchall()
    base.close()
    return [words for (words,) in rows]


def test_rows_that_met_a_full_disk_are_written_when_it_has_room_again(tmp_path: Path) -> None:
    told: list[str] = []
    history = History(tmp_path, told.append)
    history.open()
    history.add("stop", ANNA, words="before")
    asyncio.run(history.settled())
    with full_disk(1024):
        for number in range(10):
            history.add("command", ANNA, words=f"meanwhile {number}")
            asyncio.run(history.settled())
        assert [words for words in told if "cannot be saved" in words] == told and len(told) == 1
        assert on_disk(tmp_path) == ["before"]
    end = time.monotonic() + 10
    while len(on_disk(tmp_path)) < 11 and time.monotonic() < end:
        time.sleep(0.05)
    assert on_disk(tmp_path) == ["before", *(f"meanwhile {number}" for number in range(10))]
    history.close()
    assert told[1:] == [""], "that it is over is told"


def test_a_history_that_was_removed_is_begun_again(tmp_path: Path) -> None:
    history = opened(tmp_path / "home")
    history.add("stop", ANNA, words="before")
    asyncio.run(history.settled())
    shutil.rmtree(tmp_path / "home")
    history.add("stop", ANNA, words="after")
    asyncio.run(history.settled())
    assert on_disk(tmp_path / "home") == ["after"]
    history.close()


ACKNOWLEDGES = """
import asyncio, sys
from pathlib import Path
from console.control.history import History
from console.access.logins import Person

async def add() -> None:
    history = History(Path(sys.argv[1]), print)
    history.open()
    for _ in range(100_000):
        deeds = [history.add("command", Person("a", "Anna")) for _ in range(3)]
        await history.settled()
        print(deeds[-1].id, flush=True)

asyncio.run(add())
"""


def test_a_row_that_was_acknowledged_outlives_a_kill(tmp_path: Path) -> None:
    for kill in range(3):
        with subprocess.Popen(
            [sys.executable, "-c", ACKNOWLEDGES, str(tmp_path)], cwd=REPOSITORY, stdout=subprocess.PIPE, text=True
        ) as writer:
            assert writer.stdout is not None
            last = [writer.stdout.readline() for _ in range(5 + 4 * kill)][-1]
            writer.kill()
            said = writer.stdout.read().rpartition("\n")[0].split()
        acknowledged = int(said[-1] if said else last)
        base = sqlite3.connect(tmp_path / "history.sqlite")
        assert base.execute("SELECT MAX(id) FROM deeds").fetchone()[0] >= acknowledged
        base.close()


def test_nobody_waits_long_for_a_disk_that_does_not_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.control.history.DISK_TIMEOUT_S", 0.6)
    history = opened(tmp_path)
    history.add("stop", ANNA)
    asyncio.run(history.settled())
    base = sqlite3.connect(tmp_path / "history.sqlite")
    base.execute("BEGIN EXCLUSIVE")
    history.add("stop", ANNA)
    began = time.monotonic()
    asyncio.run(history.settled())
    assert 0.5 < time.monotonic() - began < 10.0
    base.rollback()
    base.close()
    history.close()
    assert len(on_disk(tmp_path)) == 2


def test_the_order_is_that_of_the_deeds_whatever_the_clock_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([5000.0, 5001.0, 1000.0, 1001.0, 9000.0, 9001.0])
    fake = SimpleNamespace(time=lambda: next(clock), monotonic=time.monotonic)
    monkeypatch.setattr("console.control.history.time", fake)
    history = opened(tmp_path)
    words = ["first", "second", "third, the clock was set back", "fourth", "fifth, and forward"]
    for said in words:
        history.add("command", ANNA, words=said)
    history.close()
    monkeypatch.undo()
    again = opened(tmp_path)
    assert [entry.words for entry in again.newest_first(commands_only=True)] == words[::-1]
    assert again.add("command", ANNA).id == 6
    again.close()


def test_a_viewer_does_not_fill_the_history(tmp_path: Path) -> None:
    history = opened(tmp_path)
    history.add("command", ANNA, words="turn left")
    many = [Person(f"v{number}", "Eve", "viewer") for number in range(5)]
    for number in range(2000):
        entry = history.add("command", many[number % 5], state="refused", words="x" * 2000)
        assert history.find(entry.id) == entry
    rows = history.newest_first(commands_only=False)
    assert len(rows) <= 1 + VIEWERS_ALLOWANCE[0] + 5 and rows[-1].words == "turn left"
    counts = [entry.remark for entry in rows if "more by the same person" in entry.remark]
    assert len(counts) == 5 and sum(int(remark.split()[1]) for remark in counts) + len(rows) - 6 == 2000
    history.close()
    again = opened(tmp_path)
    assert [entry.remark for entry in again.newest_first(commands_only=False)] == [entry.remark for entry in rows]
    again.close()


def test_a_stop_of_a_viewer_that_has_no_row_of_its_own_runs_and_ends(tmp_path: Path) -> None:
    history = opened(tmp_path)
    viewer = Person("v", "Eve", "viewer")
    for _ in range(100):
        entry = history.add("command", viewer, state="running", words="stop")
        history.end(entry.id, "done", "Stopped.")
    found = history.find(entry.id)
    assert found is not None and found.state == "done"
    assert len(history.newest_first(commands_only=True)) == VIEWER_ALLOWANCE[0] + 1
    history.close()


def test_what_moves_the_robot_is_always_written_down_and_refusals_of_one_operator_are_counted(tmp_path: Path) -> None:
    history = opened(tmp_path)
    for number in range(3 * REFUSED_ALLOWANCE[0]):
        history.add("command", ANNA, state="refused")
        history.add("command", ANNA, words=f"obeyed {number}")
    history.close()
    words = on_disk(tmp_path)
    assert sum(said.startswith("obeyed") for said in words) == 3 * REFUSED_ALLOWANCE[0]
    assert len(words) < 5 * REFUSED_ALLOWANCE[0]
