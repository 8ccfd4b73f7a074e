"""Recordings of a drive: what is written, what can still be kept, and what is left after a loss."""

import asyncio
import errno
import json
import math
import os
import random
import shutil
import signal
import threading
import time
import unicodedata
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader

from console.access.roles import ANY_FILE
from console.http.problems import Problem
from console.maps.service import ITSELF
from console.recording.recorder import RecorderService
from console.recording.store import RecordingStore
from console.recording.work import RecorderWorker
from console.workers.worker import Worker, WorkerLost
from core.errors import Refused, Unwritable
from core.files import UNFINISHED, write_atomic
from core.geometry import Pose, wrap
from core.pipelines.slam import slam_log
from core.recording import excerpt, mcap_writing, open_log
from core.recording.drive import DriveRecording
from core.recording.frame_record import WHOLE_MAP
from core.recording.mcap_recovery import recovered
from core.recording.mcap_writing import McapRecording
from core.recording.ros import decode
from core.robots import Profile
from core.robots.connect import connect
from core.sensors import SensorFrame, Wheels
from core.slam.map.map_file import SavedMap
from tests.benchmarks.recorded_drive import by_mcap, doctor
from tests.benchmarks.recorder_kills import killed_recorder
from tests.console.live import Live, full_disk
from tests.console.recording.drives import BATCH, RecordedPilot

RAW = {"/scan", "/odom", "/tf", "/tf_static", "/camera/image/compressed", "/camera/camera_info", "/audio"}
RESULTS = {"/map", "/pose", "/landmarks", "/cmd_vel", "/beckon/events", "/beckon/state"}


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with Live(tmp_path_factory.mktemp("recorded"), no_auth=True, ring_s=120.0) as live:
        yield live


def ask(live: Live, method: str, path: str, body: Any = None) -> Any:
    return live.ask(method, f"/api/{path}", body)


def turned(live: Live) -> None:
    """One command from its beginning to its end."""
    assert ask(live, "POST", "commands", {"text": "turn left"}).status == 202
    live.until(lambda: live.runtime.snapshot.active_command is not None)
    live.until(lambda: live.runtime.snapshot.active_command is None, seconds=60.0)


@pytest.fixture(scope="module")
def recorded(live: Live) -> tuple[dict[str, Any], Path]:
    """A recorded turn: the answer to its end, and its file."""
    begun = ask(live, "POST", "recordings/start", {"name": "a turn", "note": "of the suite"})
    assert begun.status == 201 and begun.json["path"].endswith("a turn.mcap.part")
    assert ask(live, "POST", "recordings/start", {}).status == 409
    ask(live, "POST", "simulation/listening", {"on": True})
    turned(live)
    done = ask(live, "POST", "recordings/stop")
    assert done.status == 200, done.body
    return done.json, live.home / "recordings" / "a turn.mcap"


def test_a_drive_is_one_file_that_others_read_message_for_message(recorded: tuple[dict[str, Any], Path]) -> None:
    answer, path = recorded
    assert answer["complete"] and answer["name"] == "a turn" and answer["bytes"] == path.stat().st_size
    assert answer["messages"].keys() >= (RAW | RESULTS) - {"/audio"}
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None and summary.statistics is not None
    counted = {
        summary.channels[number].topic: count for number, count in summary.statistics.channel_message_counts.items()
    }
    assert counted == answer["messages"]
    with AnyReader([path]) as reader:
        read: dict[str, int] = {}
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
            read[connection.topic] = read.get(connection.topic, 0) + 1
    assert read == counted
    assert oct(path.stat().st_mode & 0o777) == "0o600"


def test_its_readings_are_those_that_came_and_it_plays_as_a_log(recorded: tuple[dict[str, Any], Path]) -> None:
    answer, path = recorded
    log = open_log(path)
    assert len(log.scans) >= answer["messages"]["/scan"] - 2
    assert log.laser is not None and log.laser.beams == 682
    assert log.report.faults == ()
    held = DriveRecording(path).latest(WHOLE_MAP, answer["seconds"])
    assert held is not None
    assert SavedMap.from_bytes(decode(held, held.kind).data.tobytes(), "of the turn").submaps >= 1


@pytest.mark.campaign
def test_it_goes_through_the_estimator_offline_scan_for_scan(recorded: tuple[dict[str, Any], Path]) -> None:
    answer, path = recorded
    found = slam_log(path)
    assert len(found.poses) == answer["messages"]["/scan"]
    with AnyReader([path]) as reader:
        of = [one for one in reader.connections if one.topic == "/pose"]
        live = [reader.deserialize(raw, one.msgtype).pose.pose for one, _, raw in reader.messages(of)][-1]
    turned = 2 * math.atan2(live.orientation.z, live.orientation.w)
    assert abs(wrap(found.poses[-1].heading - found.poses[0].heading)) > 1.0
    assert abs(wrap(found.poses[-1].heading - turned)) < 0.2


def test_its_command_stands_in_the_events(recorded: tuple[dict[str, Any], Path]) -> None:
    with AnyReader([recorded[1]]) as reader:
        of = [one for one in reader.connections if one.topic == "/beckon/events"]
        events = [reader.deserialize(raw, one.msgtype).data for one, _, raw in reader.messages(of)]
    assert any('"event": "command"' in one and "turn_left" in one for one in events)
    assert any('"event": "command_end"' in one and '"state": "done"' in one for one in events)


def test_recordings_are_listed_renamed_noted_taken_away_and_deleted(live: Live, recorded: Any) -> None:
    rows = ask(live, "GET", "recordings").json["recordings"]
    [row] = [row for row in rows if row["name"] == "a turn"]
    assert row["note"] == "of the suite" and row["complete"] and row["seconds"] > 1 and row["started_s"] > 1e9
    assert ask(live, "GET", "recordings/a%20turn").body == recorded[1].read_bytes()
    picture = ask(live, "GET", "recordings/a%20turn/picture")
    assert picture.headers["content-type"] == "image/jpeg" and picture.body.startswith(b"\xff\xd8")
    copy = live.home / "recordings" / "copy.mcap"
    shutil.copy(recorded[1], copy)
    assert ask(live, "PATCH", "recordings/copy", {"name": "other", "note": "n"}).status == 204
    assert ask(live, "PATCH", "recordings/other", {"name": "a turn"}).status == 409
    [row] = [row for row in ask(live, "GET", "recordings").json["recordings"] if row["name"] == "other"]
    assert row["note"] == "n"
    assert ask(live, "PATCH", "recordings/other", {"note": ""}).status == 204
    (live.home / "recordings" / "left.mcap.part").write_bytes(b"cut")
    (live.home / "recordings" / "other.mcap").write_bytes(b"damaged")
    rows = {row["name"]: row for row in ask(live, "GET", "recordings").json["recordings"]}
    assert (rows["a turn"]["robot"], rows["a turn"]["cause"]) == (live.robot.profile.name, "")
    assert ask(live, "GET", "recordings/other/picture").status == 404
    of_others = ask(live, "POST", "recordings/other/export", {"from_s": 0, "to_s": 1})
    assert of_others.status == 422 and "that Beckon made" in of_others.json["detail"]
    assert (rows["other"]["note"], rows["other"]["code"]) == ("", "recording.cut")
    assert (rows["left"]["complete"], rows["left"]["code"]) == (False, "recording.recovering")
    (live.home / "recordings" / "left.mcap.part").unlink()
    assert ask(live, "DELETE", "recordings/other").status == 204
    assert ask(live, "GET", "recordings/other").status == 404
    assert ask(live, "GET", "recordings/..%2Fsettings").status in (404, 422)
    assert ask(live, "POST", "recordings/stop").status == 409
    assert ask(live, "POST", "recordings/start", {"name": "../x"}).status == 422


def test_no_recording_is_deleted_while_nobody_knows_which_have_a_note(tmp_path: Path) -> None:
    (tmp_path / "recordings.json").write_bytes(b"{")
    (tmp_path / "recordings").mkdir()
    noted = tmp_path / "recordings" / "noted.mcap"
    noted.touch()
    os.truncate(noted, 200_000_000)
    with Live(tmp_path, no_auth=True) as live:
        store = live.runtime.parts[RecordingStore]
        store._settings = replace(store._settings, folder_gb=0.1)
        live.run(store.make_room())
        assert noted.is_file()
        assert any("so none is deleted" in one.text for one in live.runtime.notifications.shown)
        store._notes_readable = True
        live.run(store.make_room())
        assert not noted.exists()


def test_a_recording_from_elsewhere_is_kept_as_it_came_and_can_be_opened(live: Live, recorded: Any) -> None:
    def put(name: str, content: bytes) -> Any:
        return live.ask("PUT", f"/api/recordings/{name}", raw=content, headers={"Content-Type": ANY_FILE})

    content = recorded[1].read_bytes()
    taken = put("of%20mine.log", content)
    assert (taken.status, taken.json["url"]) == (201, "log:of mine.log"), taken.body
    assert (live.home / "recordings" / "of mine.log").read_bytes() == content
    assert "log:of mine.log" in ask(live, "GET", "robot/connection").json["opened_here"]
    assert put("of%20mine.log", b"another").status == 409
    assert put("a%20turn", b"another").status == 409, "two would have one name"
    assert ask(live, "PATCH", "recordings/of%20mine.log", {"name": "theirs", "note": "n"}).status == 204, "of a form"
    rows = {row["name"]: row for row in ask(live, "GET", "recordings").json["recordings"]}
    row = rows["theirs.log"]
    assert (row["file"], row["note"], row["bytes"], row["complete"]) == ("theirs.log", "n", len(content), True)
    assert rows["a turn"]["file"] == "a turn.mcap"
    assert "theirs.log" in [name for name, _, _ in live.runtime.parts[RecordingStore]._sizes()]
    assert ask(live, "DELETE", "recordings/theirs.log").status == 204
    assert not (live.home / "recordings" / "theirs.log").exists()
    nothing = put("x.mcap", b"")
    assert (nothing.status, nothing.json["detail"]) == (422, "x.mcap is empty; nothing was kept.")
    assert put("..%2Fx.log", b"x").status in (404, 415, 422)


def test_every_recording_has_a_file_of_its_own_however_its_name_ends_or_is_written(live: Live, recorded: Any) -> None:
    folder = live.home / "recordings"
    for name, content in (("x.mcap.mcap", b"one"), ("x.mcap", b"another")):
        (folder / name).write_bytes(content)
    assert (
        ask(live, "GET", "recordings/x.mcap").body == b"one" and ask(live, "GET", "recordings/x").body == b"another"
    )
    for status in (204, 404):
        assert ask(live, "DELETE", "recordings/x.mcap").status == status and (folder / "x.mcap").is_file()
    assert ask(live, "POST", "recordings/start", {"name": "y.mcap"}).json["name"] == "y"
    assert ask(live, "POST", "recordings/stop").status == 200
    assert ask(live, "PATCH", "recordings/y", {"name": "z.mcap"}).status == 204
    decomposed = quote(unicodedata.normalize("NFD", "Küche.log"))  # as macOS writes it
    taken = live.ask("PUT", f"/api/recordings/{decomposed}", raw=b"x", headers={"Content-Type": ANY_FILE})
    assert taken.json["url"] == "log:Küche.log", taken.body
    for name in ("x", "z", quote("Küche.log")):
        assert ask(live, "DELETE", f"recordings/{name}").status == 204


def test_of_two_that_are_given_one_name_at_once_one_is_refused_and_no_note_is_lost(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, rename, slow = live.runtime.parts[RecordingStore], Path.rename, [0.3, 0.0]

    def slowly(path: Path, target: Path) -> Path:
        time.sleep(0.2)
        return rename(path, target)

    def written(path: Path, content: bytes) -> None:
        time.sleep(slow.pop(0))  # the first to begin is the last to end
        write_atomic(path, content)

    async def at_once(*work: Coroutine[Any, Any, None]) -> list[BaseException | None]:
        return await asyncio.gather(*work, return_exceptions=True)

    for name in ("one", "two"):
        (live.home / "recordings" / f"{name}.mcap").write_bytes(name.encode())
    with monkeypatch.context() as busy:
        busy.setattr(Path, "rename", slowly)
        ends = live.run(at_once(*(store.rewrite(name, None, "same") for name in ("one", "two"))))
        assert [type(one) for one in ends] == [type(None), Problem]
        moved = live.run(at_once(*(store.rewrite("same", None, name) for name in ("here", "there"))))
        assert [getattr(one, "status", 0) for one in moved] == [0, 404]
        live.run(store.rewrite("here", None, "same"))
    assert (live.home / "recordings" / "same.mcap").read_bytes() == b"one"
    with monkeypatch.context() as busy:
        busy.setattr("console.recording.store.write_atomic", written)
        live.run(at_once(store.rewrite("same", "of one", None), store.rewrite("two", "of two", None)))
    notes = json.loads((live.home / "recordings.json").read_bytes())
    assert (notes["same"]["note"], notes["two"]["note"]) == ("of one", "of two")
    for name in ("same", "two"):
        assert ask(live, "DELETE", f"recordings/{name}").status == 204


def test_a_long_name_leaves_room_for_its_parts_in_every_script(live: Live, recorded: Any) -> None:
    recorder, name = live.runtime.parts[RecorderService], 80 * "地"
    assert ask(live, "POST", "recordings/start", {"name": name}).status == 201
    live.run(recorder._rotate())
    running = recorder.state.name
    assert running is not None and running.endswith("地 part 2")
    assert ask(live, "POST", "recordings/stop").status == 200
    cut = ask(live, "POST", "recordings/a%20turn/export", {"from_s": 0, "to_s": 1}).json["name"]
    (live.home / "recordings" / f"{cut}.mcap").rename(live.home / "recordings" / f"{75 * '地'}.mcap")
    cut = ask(live, "POST", f"recordings/{quote(75 * '地')}/export", {"from_s": 0, "to_s": 1})
    assert cut.status == 201, cut.body
    for one in (name, running, 75 * "地", cut.json["name"]):
        assert ask(live, "DELETE", f"recordings/{quote(one)}").status == 204


def test_of_two_who_have_the_same_made_at_once_both_get_it(live: Live, recorded: Any) -> None:
    def at_once(method: str, path: str, body: Any = None) -> list[Any]:
        with ThreadPoolExecutor(2) as pool:
            return list(pool.map(lambda _: ask(live, method, path, body), range(2)))

    parts = at_once("POST", "recordings/a%20turn/export", {"from_s": 0, "to_s": 1})
    assert [one.status for one in parts] == [201, 201] and len({one.json["name"] for one in parts}) == 2
    for one in parts:
        assert ask(live, "DELETE", f"recordings/{quote(one.json['name'])}").status == 204
    samples = at_once("POST", "recordings/samples/room")
    assert [(one.status, one.json["url"]) for one in samples] == [(201, "log:sample room.mcap")] * 2


def test_a_file_that_cannot_be_read_keeps_no_drive_from_being_recorded(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    (live.home / "calibration").mkdir(exist_ok=True)
    locked = live.home / "calibration" / "of-root.json"
    locked.write_bytes(b"{}")
    read = Path.read_bytes

    def refused(path: Path) -> bytes:
        if path == locked:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return read(path)

    monkeypatch.setattr(Path, "read_bytes", refused)
    assert ask(live, "POST", "recordings/start", {"name": "all the same"}).status == 201
    assert ask(live, "POST", "recordings/stop").status == 200
    locked.unlink()
    assert ask(live, "DELETE", "recordings/all%20the%20same").status == 204


def test_a_note_that_came_in_a_file_is_kept_as_any_other(live: Live, recorded: Any) -> None:
    part = ask(live, "POST", "recordings/a%20turn/export", {"from_s": 0, "to_s": 1}).json
    headers = {"Content-Type": ANY_FILE}
    assert live.ask("PUT", "/api/recordings/theirs.mcap", raw=recorded[1].read_bytes(), headers=headers).status == 201
    notes = json.loads((live.home / "recordings.json").read_bytes())
    for name in (part["name"], "theirs"):
        assert notes[name]["note"] == "of the suite", "without a note it would be deleted to make room"
        assert ask(live, "DELETE", f"recordings/{quote(name)}").status == 204


def test_a_part_whose_cutting_was_killed_is_cut_again(recorded: Any, tmp_path: Path) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    target = tmp_path / "part.mcap"
    with pytest.MonkeyPatch.context() as process:
        process.setattr(excerpt, "_copy", killed)
        process.setattr(McapRecording, "discard", lambda _: None)
        with pytest.raises(KeyboardInterrupt):
            excerpt.write_excerpt(recorded[1], target, 0.0, 1.0)
    [left] = tmp_path.iterdir()
    assert left.name.startswith(".") and left.name.endswith(UNFINISHED), (
        "nobody sees it, and the next start removes it"
    )
    assert excerpt.write_excerpt(recorded[1], target, 0.0, 1.0).path == target


def test_a_recording_that_ends_takes_the_place_of_no_other(tmp_path: Path) -> None:
    recording = McapRecording(tmp_path / "a.mcap")
    (tmp_path / "a.mcap").write_bytes(b"another")
    with pytest.raises(Unwritable, match="File exists"):
        recording.finish()
    assert (tmp_path / "a.mcap").read_bytes() == b"another" and (tmp_path / "a.mcap.part").is_file()


def test_nothing_takes_the_name_of_a_recording_that_runs(live: Live, recorded: Any) -> None:
    assert ask(live, "POST", "recordings/start", {"name": "runs"}).status == 201
    put = live.ask("PUT", "/api/recordings/runs.mcap", raw=b"another", headers={"Content-Type": ANY_FILE})
    renamed = ask(live, "PATCH", "recordings/a%20turn", {"name": "runs"})
    assert (put.status, renamed.status) == (409, 409)
    assert ask(live, "POST", "recordings/stop").status == 200
    path = live.home / "recordings" / "runs.mcap"
    assert make_reader(path.open("rb")).get_summary() is not None
    with pytest.raises(Unwritable, match="File exists"):
        McapRecording(path)
    assert ask(live, "DELETE", "recordings/runs").status == 204


def test_a_recording_begins_though_its_note_cannot_be_kept_and_ends_for_its_own_starter_alone(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = live.runtime.parts[RecorderService]
    with monkeypatch.context() as disk:
        disk.setattr("console.recording.store.write_atomic", full)
        assert ask(live, "POST", "recordings/start", {"name": "noted", "note": "a note"}).status == 201
    assert recorder._base == "noted"
    live.run(recorder.stop_own("of a route", ITSELF))
    assert recorder.state.name == "noted"
    live.run(recorder.stop_own("noted", ITSELF))
    assert recorder.state.name is None
    assert ask(live, "DELETE", "recordings/noted").status == 204


def full(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("step_s", [-3600.0, 3600.0])
def test_a_clock_that_is_set_neither_empties_the_ring_nor_lets_it_grow(tmp_path: Path, step_s: float) -> None:
    recorded = RecordedPilot(tmp_path / "drive.mcap", Profile(name="a robot", url=""), ring_s=2.0)
    for number in range(5 * BATCH):
        if number == 4 * BATCH:
            recorded.began_s += step_s
        recorded.step(SensorFrame(stamp=number / recorded.profile.rate))
    recorded.keep(tmp_path / "kept.mcap", 60.0)
    assert by_mcap(tmp_path / "kept.mcap")["/beckon/frame"] == pytest.approx(2.0 * recorded.profile.rate, abs=2)
    with (tmp_path / "kept.mcap").open("rb") as file:
        times = [one.log_time for _, _, one in make_reader(file).iter_messages()]
    assert max(times) - min(times) == pytest.approx(2e9, abs=2e8)
    recorded.leave()


def test_a_sample_is_recorded_once_and_plays(live: Live) -> None:
    made = ask(live, "POST", "recordings/samples/people")
    assert (made.status, made.json["url"]) == (201, "log:sample people.mcap"), made.body
    path = live.home / "recordings" / "sample people.mcap"
    robot, written = connect(f"log:{path}"), path.stat().st_mtime_ns
    assert robot.profile.duration == pytest.approx(12, abs=0.1)
    robot.close()
    assert ask(live, "POST", "recordings/samples/people").status == 201 and path.stat().st_mtime_ns == written
    assert ask(live, "POST", "recordings/samples/none").status == 422


def test_a_part_is_a_recording_of_its_own_with_what_held_at_its_beginning(live: Live, recorded: Any) -> None:
    answer, path = recorded
    begin, end = answer["seconds"] / 3, 2 * answer["seconds"] / 3
    part = ask(live, "POST", "recordings/a%20turn/export", {"from_s": begin, "to_s": end})
    assert part.status == 201, part.body
    assert part.json["seconds"] == pytest.approx(end - begin, abs=1.5)
    cut = live.home / "recordings" / f"{part.json['name']}.mcap"
    with AnyReader([path]) as whole, AnyReader([cut]) as less:
        inside = {(one.topic, at, bytes(raw)) for one, at, raw in whole.messages()}
        mine = [(one.topic, at, bytes(raw)) for one, at, raw in less.messages()]
        since = less.start_time
    assert [row for row in mine if row not in inside and row[1] > since] == []
    first = {topic for topic, at, _ in mine if at == since}
    assert first >= {"/tf_static", "/camera/camera_info", "/beckon/robot"}
    assert part.json["messages"].keys() >= RAW - {"/audio"}
    drive = DriveRecording(cut)
    assert sum(1 for _ in drive.moments()) == part.json["messages"]["/beckon/frame"]
    drive.close()
    film = ask(live, "GET", f"recordings/a%20turn/film.gif?from_s={begin}&to_s={end}")
    assert film.headers["content-type"] == "image/gif" and film.body.startswith(b"GIF8")
    for asked in ({"from_s": 5, "to_s": 4}, {"from_s": 9_000, "to_s": 9_001}):
        assert ask(live, "POST", "recordings/a%20turn/export", asked).status == 422
    assert ask(live, "POST", "recordings/absent/export", {"from_s": 0, "to_s": 1}).status == 404
    assert ask(live, "DELETE", f"recordings/{part.json['name'].replace(' ', '%20')}").status == 204


def test_what_just_happened_can_be_kept(live: Live, recorded: Any) -> None:
    kept = ask(live, "POST", "recordings/keep", {"seconds": 60, "note": "look at this"})
    assert kept.status == 201, kept.body
    assert kept.json["seconds"] > 1 and kept.json["messages"]["/scan"] > 5
    [row] = [row for row in ask(live, "GET", "recordings").json["recordings"] if row["name"] == kept.json["name"]]
    assert (row["note"], row["cause"], row["code"]) == ("look at this", kept.json["cause"], "recording.kept_by")
    assert ask(live, "POST", "halt").status == 200

    def notices() -> list[Any]:
        return [one for one in live.runtime.notifications.shown if one.cause == "kept"]

    live.until(lambda: notices())
    assert ask(live, "POST", "halt/reset").status == 200
    assert notices()[0].text.endswith(". The robot was halted."), "a sentence, which has its words in each language"
    state = ask(live, "GET", "state").json["recording"]
    assert (state["name"], state["ring_limit_s"]) == (None, 120.0) and state["ring_s"] > 1 and state["revision"] > 2
    history = [(row["what"], row["who"]) for row in ask(live, "GET", "audit").json["entries"]]
    asked = ("record", "stop_recording", "keep_recording", "delete_recording")
    assert {(what, "operator") for what in asked} <= set(history), history


def test_a_long_recording_goes_on_in_files_that_keep_its_note_and_the_oldest_of_no_note_goes_as_was_said(
    tmp_path: Path,
) -> None:
    def names() -> set[str]:
        return {path.stem for path in (tmp_path / "recordings").glob("*.mcap")}

    def said() -> list[str]:
        return [one.text for one in live.runtime.notifications.shown if "folder of recordings" in one.text]

    with Live(tmp_path, no_auth=True) as live:
        recorder, store = live.runtime.parts[RecorderService], live.runtime.parts[RecordingStore]
        recorder._settings = replace(recorder._settings, file_mb=1.0, ring_s=0.0)
        store._settings = replace(store._settings, folder_gb=0.1)
        assert ask(live, "POST", "recordings/start", {"name": "long", "note": "mine"}).status == 201
        for age, name in ((200, "older"), (100, "newer")):
            path = tmp_path / "recordings" / f"{name}.mcap"
            path.touch()
            os.truncate(path, 49_000_000)
            os.utime(path, (time.time() - age,) * 2)
        live.until(lambda: said())
        assert said()[0].endswith(
            "older, the oldest without a note, goes next. Give it a note to keep it, or download it."
        )
        assert {"older", "newer"} <= names()
        live.until(
            lambda: "older" not in names() and {"long", "long part 2", "long part 3"} <= names(), seconds=200.0
        )
        ask(live, "POST", "recordings/stop")
        rows = ask(live, "GET", "recordings").json["recordings"]
    parts = [row for row in rows if row["name"].startswith("long")]
    assert len(parts) >= 3 and {row["note"] for row in parts} == {"mine"} and "newer" in names()
    counts = sorted(row["messages"].get("/beckon/frame", 0) for row in parts)
    assert counts[-2] > 0 and all(row["complete"] for row in parts)  # the last one may just have begun
    assert any("older, the oldest without a note, is deleted" in one for one in said())


def test_a_killed_recorder_loses_a_second_and_the_rest_is_recovered(live: Live, recorded: Any) -> None:
    recorder = live.runtime.parts[RecorderService]
    assert ask(live, "POST", "recordings/start", {"name": "cut"}).status == 201
    live.until(lambda: recorder.state.seconds > 2.0, seconds=60.0)
    written = recorder.state
    os.kill(live.on_loop(lambda: recorder._worker.pid), signal.SIGKILL)
    live.until(lambda: recorder.state.name is None)
    live.until(lambda: not list((live.home / "recordings").glob("*.part")), seconds=60.0)
    assert any("The recorder was lost" in one.text for one in live.runtime.notifications.shown)
    [row] = [row for row in ask(live, "GET", "recordings").json["recordings"] if row["name"] == "cut"]
    assert row["complete"] and row["seconds"] > written.seconds - 2.0
    assert (row["code"], row["note"]) == ("recording.recovered", "")


def test_of_a_recorder_killed_at_any_instant_what_is_older_than_a_second_is_there() -> None:
    kills = [killed_recorder(random.Random(seed)) for seed in (1, 2)]
    assert [one["missing"] for one in kills] == [0, 0] and sum(one["due"] for one in kills) > 5


def test_a_recording_that_could_not_be_read_in_time_is_not_called_unfinished(
    live: Live, recorded: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copy(recorded[1], live.home / "recordings" / "slow.mcap")

    async def given_up(_worker: Worker, _job: object, *, budget: float) -> object:
        raise WorkerLost(f"That took longer than {budget} s.", killed=True)

    def slow() -> dict[str, Any]:
        rows = ask(live, "GET", "recordings").json["recordings"]
        return next(row for row in rows if row["name"] == "slow")

    with monkeypatch.context() as busy:
        busy.setattr(Worker, "ask", given_up)
        row = slow()
        assert (row["complete"], row["code"]) == (True, "recording.unread") and "took longer" in row["cause"]
    assert (slow()["cause"], slow()["seconds"] > 1) == ("", True)
    assert ask(live, "DELETE", "recordings/slow").status == 204


def test_a_file_that_was_just_taken_away_is_not_complete(tmp_path: Path) -> None:
    read = RecorderWorker().read(str(tmp_path / "gone.mcap"))
    assert (read.name, read.bytes, read.complete) == ("gone", 0, False)


def test_a_file_that_is_still_written_is_left_to_its_process(tmp_path: Path) -> None:
    recorded = RecordedPilot(tmp_path / "drive.mcap", Profile(name="a robot", url=""))
    for number in range(60):
        recorded.step(SensorFrame(stamp=number / 40))
    [left] = RecorderWorker().recover(str(tmp_path))
    assert (left.name, left.complete) == ("drive", False)
    recorded.finish()
    assert RecorderWorker().recover(str(tmp_path)) == []
    assert by_mcap(tmp_path / "drive.mcap")["/beckon/frame"] == 60 and doctor(tmp_path / "drive.mcap") == []


def test_what_has_come_is_written_though_the_console_is_gone_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that stands for a while: the recorder goes on taking what comes, and has all of it at its end."""
    stands = threading.Event()
    written = tmp_path / "drive.mcap"
    monkeypatch.setattr(mcap_writing, "FLUSH_PERIOD_S", 0.0)
    monkeypatch.setattr(os, "fsync", lambda _: stands.wait(30.0))
    recorded = RecordedPilot(written, Profile(name="a robot", url=""))
    recorded.hurries = True
    for number in range(5 * BATCH):
        recorded.step(SensorFrame(stamp=number / 40))
    assert not stands.is_set() and not written.exists()
    stands.set()
    recorded.leave()
    assert by_mcap(written)["/beckon/frame"] == 5 * BATCH


def test_on_a_full_disk_a_recording_ends_with_its_reason_and_is_recovered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcap_writing, "FLUSH_PERIOD_S", 0.0)
    recorded = RecordedPilot(tmp_path / "drive.mcap", Profile(name="a robot", url=""))
    frame = SensorFrame(stamp=0.0, wheels=Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0))
    written = 0
    with full_disk(most=20_000), pytest.raises(Unwritable, match="ends here: File too large"):
        for written in range(2000):
            recorded.step(replace(frame, stamp=written / 40))
    with pytest.raises(Refused):
        recorded.finish()
    with full_disk(most=(tmp_path / "drive.mcap.part").stat().st_size):
        [whole] = RecorderWorker().recover(str(tmp_path))
    taken = written + 1 - BATCH  # what was written is said with the batch after it; the schemas are half of the file
    assert 0.2 * taken < whole.messages["/beckon/frame"] <= taken
    assert [path.name for path in tmp_path.iterdir()] == ["drive.mcap"]
    assert by_mcap(tmp_path / "drive.mcap") == whole.messages and doctor(tmp_path / "drive.mcap") == []


def test_wherever_a_recording_is_cut_its_whole_chunks_are_recovered_again_and_again(tmp_path: Path) -> None:
    recorded = RecordedPilot(tmp_path / "drive.mcap", Profile(name="a robot", url=""))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mcap_writing, "FLUSH_PERIOD_S", 0.0)
        for number in range(60):
            recorded.step(SensorFrame(stamp=number / 40))
    recorded.finish()
    whole = (tmp_path / "drive.mcap").read_bytes()
    part, counts = tmp_path / "cut.mcap.part", []
    for cut in sorted(random.Random(4).sample(range(len(whole)), 12)):
        part.write_bytes(whole[:cut])
        found = recovered(part, {"cause": "cut"})
        counts.append(0 if found is None else found.messages["/beckon/frame"])
        if found is None:
            continue
        assert by_mcap(found.path) == found.messages and doctor(found.path) == []
        part.write_bytes(found.path.read_bytes()[: -random.Random(cut).randrange(1, 400)])  # killed meanwhile
        found.path.unlink()
        again = recovered(part, {"cause": "cut"})
        assert again is not None and again.messages == found.messages and doctor(again.path) == []
        again.path.unlink()
    assert counts == sorted(counts) and 0 <= counts[0] < counts[-1] <= 60


@pytest.mark.campaign
def test_of_two_who_begin_at_once_one_records_and_one_is_refused(live: Live, recorded: Any) -> None:
    with ThreadPoolExecutor(2) as pool:
        begun = list(pool.map(lambda name: ask(live, "POST", "recordings/start", {"name": name}), ("one", "two")))
    assert sorted(one.status for one in begun) == [201, 409]
    done = ask(live, "POST", "recordings/stop")
    assert done.json["name"] in ("one", "two")
    assert not list((live.home / "recordings").glob("*.part"))


def test_what_the_disk_refuses_is_told_and_ends_no_recorder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    (folder / "gone.mcap").symlink_to(folder / "nowhere")  # as one that was deleted between two looks
    (folder / "old.mcap").touch()
    os.truncate(folder / "old.mcap", 200_000_000)
    unlink = Path.unlink

    def refused(path: Path, missing_ok: bool = False) -> None:
        if path.parent == folder:
            raise OSError(errno.EROFS, "Read-only file system")
        unlink(path, missing_ok=missing_ok)

    with Live(tmp_path, no_auth=True) as live:
        recorder, store = live.runtime.parts[RecorderService], live.runtime.parts[RecordingStore]
        store._settings = replace(store._settings, folder_gb=0.1)

        def look() -> None:
            store.revision, recorder._disk_s = store.revision + 1, -math.inf
            recorder._wake.set()

        with monkeypatch.context() as patch:
            patch.setattr(Path, "unlink", refused)
            live.on_loop(look)
            live.until(lambda: any("Read-only file system" in one.text for one in live.runtime.notifications.shown))
        assert (folder / "old.mcap").exists()
        live.on_loop(look)
        live.until(lambda: not (folder / "old.mcap").exists())


def test_a_summary_without_its_channels_is_read_all_the_same(tmp_path: Path) -> None:
    with (tmp_path / "foreign.mcap").open("wb") as file:
        writer = Writer(file, repeat_channels=False)
        writer.start(library="beckon")
        channel = writer.register_channel("/scan", "json", writer.register_schema("Scan", "jsonschema", b"{}"))
        for at in (0, 2_000_000_000):
            writer.add_message(channel, at, b"{}", at)
        writer.finish()
    read = RecorderWorker().read(str(tmp_path / "foreign.mcap"))
    assert (read.complete, read.seconds, read.messages) == (True, 2.0, {})
    assert DriveRecording(tmp_path / "foreign.mcap").counts == {}
