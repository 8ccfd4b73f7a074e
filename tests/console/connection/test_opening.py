"""Another robot at the same address: read before anything ends, from the right folders, and no map is lost."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from console.connection.reach import Reach
from console.connection.service import ConnectionService
from console.maps.service import LAST_BUT_ONE, LAST_MAP, MapService
from core.geometry import Pose
from tests.console.live import Live, Reply
from tests.core.recording.log_writers import carmen_lines


@pytest.fixture
def leaving(live: Live, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """URLs for which the console would have ended."""
    left: list[str] = []
    connection = live.runtime.parts[ConnectionService]
    monkeypatch.setattr(connection, "leave", lambda: left.append(connection.other))
    yield left
    connection.other, connection.reach = "", Reach()


@pytest.fixture(scope="module")
def recordings(shared_live: Live) -> Path:
    folder = shared_live.home / "recordings"
    folder.mkdir()
    (folder / "walk.log").write_text("\n".join(carmen_lines()))
    (folder / "damaged.mcap").write_bytes(b"nothing")
    (folder / "sightings.log").write_text("no scans at all\n")
    os.mkfifo(folder / "pipe.log")
    return folder


def opened(live: Live, url: str, token: str | None = None) -> Reply:
    return live.ask("POST", "/api/robot/open", {"url": url}, token=token or live.operator)


def test_a_recording_that_cannot_be_used_ends_nothing_and_says_why(
    live: Live, recordings: Path, leaving: list[str]
) -> None:
    for name, words in {
        "damaged.mcap": "not an MCAP file",
        "sightings.log": "",
        "pipe.log": "There is no recording pipe.log",
        "absent.mcap": "There is no recording absent.mcap",
        "~nosuchuser/x.mcap": "There is no recording x.mcap",
    }.items():
        answer = opened(live, f"log:{name}")
        assert answer.status == 422 and words in answer.json["detail"], (name, answer.json)
        row = live.runtime.history.newest_first(commands_only=False)[0]
        assert (row.words, row.state, row.remark) == (f"log:{name}", "failed", answer.json["detail"])
    assert live.runtime.parts[ConnectionService].other == "" and leaving == []


def test_operators_open_recordings_from_their_folders_and_administrators_from_everywhere(
    live: Live, recordings: Path, leaving: list[str], tmp_path: Path
) -> None:
    elsewhere = tmp_path / "walk.log"
    elsewhere.write_text((recordings / "walk.log").read_text())
    for url in (f"log:{elsewhere}", "log:/etc/hostname", "log:/etc/absent", "log:../console.log", "log:~/.bashrc"):
        assert opened(live, url).status in (403, 422)
    assert str(recordings) in opened(live, f"log:{elsewhere}").json["detail"]
    assert live.runtime.parts[ConnectionService].other == ""

    assert opened(live, f"log:{elsewhere}", live.admin).json["url"] == f"log:{elsewhere}"
    live.until(lambda: leaving == [f"log:{elsewhere}"])
    live.runtime.parts[ConnectionService].reach = Reach([str(tmp_path)])
    assert opened(live, f"log:{elsewhere}").status == 202
    assert opened(live, "log:walk.log").json["url"] == f"log:{recordings / 'walk.log'}"
    live.until(lambda: len(leaving) == 3)


def test_a_map_that_was_not_saved_is_kept_when_the_console_ends_and_one_that_was_is_not(
    live: Live, recordings: Path
) -> None:
    maps = live.runtime.parts[MapService]

    def names() -> list[str]:
        return [one["name"] for one in live.ask("GET", "/api/maps", token=live.viewer).json["maps"]]

    def keep(name: str) -> None:
        live.run(maps.keep_unsaved(name))

    def come_a_long_way() -> None:
        live.until(lambda: maps._kept_at is not None)
        maps._kept_at = Pose(5.0, 5.0, 0.0) @ maps.snapshot.estimate.pose
        live.until(lambda: maps.shown.unsaved)

    live.on_loop(lambda: maps._stands_kept())
    keep(LAST_MAP)
    assert LAST_MAP not in names() and maps.shown.unsaved is False
    come_a_long_way()
    keep("before opening walk.log, again/and again, with a name that is much too long for a map")
    assert names()[0] == "before opening walk log again and again"[:40].strip() and not maps.shown.unsaved

    before = live.run(maps.autosaved())  # it keeps a map that is unsaved, and unsaved it remains
    assert before is False
    come_a_long_way()
    assert live.run(maps.autosaved()) and names()[0] == LAST_MAP and maps.shown.unsaved
    assert live.run(maps.autosaved()) is False  # it stands

    maps._earlier_kept, maps._name = False, None  # as a console that finds it
    keep(LAST_MAP)
    assert names()[:2] == [LAST_MAP, LAST_BUT_ONE]
    live.on_loop(lambda: maps._stands_kept())
