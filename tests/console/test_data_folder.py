"""The data folder: refused at start where nothing can be kept, told while nothing can be kept, closed to others."""

import asyncio
import sqlite3
import stat
import time
from pathlib import Path
from typing import Any

import pytest

from console import data_folder
from console.__main__ import main
from console.control.notices import Notifications
from console.data_folder import DataFolder, prepare
from core.calibration.files.camera_files import ros_yaml
from core.errors import Unwritable
from core.optics import TABLE_3
from tests.console.live import Live, full_disk


def a_file(folder: Path) -> tuple[Path, str]:
    (folder / "home").write_text("")
    return folder / "home", "It is not a folder"


def below_a_file(folder: Path) -> tuple[Path, str]:
    (folder / "file").write_text("")
    return folder / "file" / "home", "Not a directory"


def no_disk(folder: Path) -> tuple[Path, str]:
    return Path("/proc/beckon"), "No such file or directory"


@pytest.mark.parametrize("place", [a_file, below_a_file, no_disk])
def test_a_console_does_not_start_where_nothing_can_be_kept(
    place: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, why = place(tmp_path)
    assert main(["run", "--no-browser", "--port", "0", "--data", str(folder)]) == 1
    told = capsys.readouterr()
    starts, trouble = told.err.splitlines()
    assert told.out == "" and starts == "Starting sim:lab…"
    assert f"data folder {folder}: {why}" in trouble and "--data DIR" in trouble


def test_a_console_does_not_start_on_a_full_disk(tmp_path: Path) -> None:
    with full_disk(), pytest.raises(Unwritable, match=r"data folder .*: File too large"):
        prepare(tmp_path / "home")


def test_what_is_kept_is_its_owners_alone_and_what_is_not_ours_is_left_alone(tmp_path: Path) -> None:
    prepare(tmp_path / "new" / "home")
    assert stat.S_IMODE((tmp_path / "new" / "home").stat().st_mode) == 0o700
    for shared in (False, True):
        home = tmp_path / f"home {shared}"
        (home / "people").mkdir(parents=True)
        (home / "recordings").mkdir()
        (home / "before-restore").mkdir()
        for name in ("history.sqlite", "recordings.json", "open.html"):
            (home / name).write_text("")
        if shared:
            (home / "thesis.tex").write_text("")
        for path in [home, *home.iterdir()]:
            path.chmod(0o755 if path.is_dir() else 0o644)
        prepare(home)
        modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in home.iterdir()}
        ours = dict.fromkeys(("people", "recordings", "before-restore"), 0o700)
        ours |= dict.fromkeys(("history.sqlite", "recordings.json", "open.html"), 0o600)
        assert modes == ours | ({"thesis.tex": 0o644} if shared else {})
        assert stat.S_IMODE(home.stat().st_mode) == (0o755 if shared else 0o700)


@pytest.fixture
def looks_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_folder, "LOOK_PERIOD_S", 0.05)
    monkeypatch.setattr(data_folder, "TROUBLED_LOOK_PERIOD_S", 0.05)


def health(live: Live) -> tuple[int, str]:
    reply = live.ask("GET", "/api/health")
    return reply.status, " ".join(reply.json["reasons"])


def save(live: Live, name: str) -> int:
    return live.ask("POST", "/api/maps", {"name": name}, token=live.operator).status


def shown(live: Live) -> list[tuple[str, str]]:
    return [(told.level, told.text) for told in live.runtime.notifications.shown if "data folder" in told.text]


def test_a_disk_that_fills_up_is_told_with_507_and_everywhere_until_it_is_over(
    looks_often: None, tmp_path: Path
) -> None:
    with Live(tmp_path / "home") as live:
        live.until(lambda: health(live)[0] == 200)
        token = live.operator
        camera = {"raw": ros_yaml(TABLE_3).encode(), "headers": {"Content-Type": "text/plain"}, "token": token}
        live.until(lambda: save(live, "before") == 201)
        with full_disk():
            live.until(lambda: health(live)[0] == 503)
            assert "Nothing can be saved in the data folder" in health(live)[1]
            saved = live.ask("POST", "/api/maps", {"name": "during"}, token=token)
            assert saved.status == 507 and "The map could not be saved: File too large" in saved.json["detail"]
            used = live.ask("POST", "/api/calibration/import", **camera)
            assert used.status == 507 and "The calibration could not be saved: File too large" in used.json["detail"]
            assert [level for level, _ in shown(live)] == ["error"]
            moved = live.ask("POST", "/api/commands", {"text": "turn left"}, token=token)
            assert moved.status == 202, "the disk does not stop a robot"
            assert live.ask("POST", "/api/stop", token=token).status == 200
        live.until(lambda: health(live)[0] == 200)
        live.until(lambda: shown(live) == [("info", "The data folder can be written again.")])
        assert [card["name"] for card in live.ask("GET", "/api/maps", token=token).json["maps"]] == ["before"]
        assert save(live, "after") == 201

    base = sqlite3.connect(tmp_path / "home" / "history.sqlite")
    rows = base.execute("SELECT words, what FROM deeds ORDER BY id").fetchall()
    base.close()
    assert ("turn left", "command") in rows and ("", "stop") in rows, "what met the full disk was written later"


def test_a_folder_that_is_removed_under_a_console_is_made_again(looks_often: None, tmp_path: Path) -> None:
    with Live(tmp_path / "home") as live:
        live.until(lambda: save(live, "lost") == 201)
        (tmp_path / "home").rename(tmp_path / "gone")  # at once: the console may write while a tree is removed
        assert save(live, "kept") == 201
        assert [card["name"] for card in live.ask("GET", "/api/maps", token=live.operator).json["maps"]] == ["kept"]
        assert health(live)[0] == 200


def test_an_answer_comes_when_its_row_is_on_disk(live: Live) -> None:
    base = sqlite3.connect(live.runtime.history._store._path)
    for text in ("turn left", "nonsense", "continue"):
        reply = live.ask("POST", "/api/commands", {"text": text}, token=live.operator)
        (row,) = base.execute("SELECT words, state FROM deeds ORDER BY id DESC LIMIT 1").fetchall()
        assert row[0] == text and (row[1] == "refused") == (reply.status != 202)
    base.close()


def test_a_stop_waits_for_no_disk(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.control.history.DISK_TIMEOUT_S", 2.0)
    base = sqlite3.connect(live.runtime.history._store._path)
    base.execute("BEGIN EXCLUSIVE")
    try:
        began = time.monotonic()
        assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).status == 202
        waited = time.monotonic() - began
        began = time.monotonic()
        assert live.ask("POST", "/api/stop", token=live.operator).status == 200
        assert time.monotonic() - began < 0.8 * waited
        assert waited > 1.5
    finally:
        base.rollback()
        base.close()


def test_a_disk_that_does_not_answer_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_folder, "DISK_TIMEOUT_S", 0.05)
    hangs = [True]

    def slow(folder: Path) -> None:
        while hangs[0]:
            time.sleep(0.01)

    monkeypatch.setattr(data_folder, "try_writing", slow)

    async def looks() -> None:
        folder = DataFolder(tmp_path, Notifications())
        await folder.look()
        assert "does not answer" in folder.trouble
        await folder.look()
        hangs[0] = False
        async with asyncio.timeout(30.0):
            while folder.trouble:
                await folder.look()

    asyncio.run(looks())
