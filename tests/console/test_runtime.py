"""What the console does when a part of it fails."""

import threading
import time
from pathlib import Path

import pytest

from console.control.link_monitor import HANGS
from console.part import BackgroundTask
from console.robot.pilot_thread import HUNG_S
from core.gate.suspend import SleepWatch
from core.pilot import Pilot
from core.sensors import SensorFrame
from core.snapshot import Snapshot
from tests.console.live import Live, hear


class Frail(Pilot):
    """The real pilot, until it is told to fall."""

    falls = 0

    def step(self, frame: SensorFrame, *, deaf: bool = False) -> Snapshot:
        if type(self).falls > 0:
            type(self).falls -= 1
            raise ZeroDivisionError("secret detail")
        return super().step(frame, deaf=deaf)


def make_frail(folder: Path) -> Live:
    live = Live(folder, make_pilot=lambda: Frail(live.robot.profile))
    return live


def test_a_pilot_that_fails_stops_the_robot_is_told_and_starts_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("console.control.pilot_supervisor.RESTART_PAUSE_S", 0.5)
    monkeypatch.setattr(Frail, "falls", 0)
    with make_frail(tmp_path) as live:
        live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
        number = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).json["id"]
        live.until(lambda: live.robot.status().w)
        Frail.falls = 1
        live.until(lambda: live.runtime.pilots.failure)
        assert live.robot.status().w == 0
        health = live.ask("GET", "/api/health")
        assert health.status == 503 and "pilot" in health.json["reasons"][0]
        assert "secret" not in health.body.decode()
        refused = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator)
        assert refused.status == 503
        assert live.ask("POST", "/api/stop", token=live.viewer).status == 200
        told = live.ask("GET", f"/api/commands/{number}", token=live.viewer).json
        assert told["state"] == "failed" and "pilot" in told["remark"]
        live.until(lambda: live.ask("GET", "/api/health").status == 200)
        with live.open() as line:
            notices = hear(line, "state")["notices"]
        assert any("The pilot failed" in notice["text"] for notice in notices)
    assert "secret detail" in caplog.text


def test_a_pilot_that_keeps_failing_stays_off_and_the_console_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("console.control.pilot_supervisor.RESTART_PAUSE_S", 0.02)
    monkeypatch.setattr(Frail, "falls", 0)
    with make_frail(tmp_path) as live:
        Frail.falls = 1000
        live.until(lambda: "stays off" in live.runtime.pilots.failure)
        assert live.ask("GET", "/api/health").status == 503
        assert live.ask("POST", "/api/stop", token=live.viewer).status == 200
        assert live.ask("GET", "/api/state", token=live.viewer).status == 200
        assert live.robot.status().v == 0


def test_without_a_pilot_the_gate_hears_no_heartbeat(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.control.pilot_supervisor.RESTART_PAUSE_S", 60)
    monkeypatch.setattr(Frail, "falls", 0)
    with make_frail(tmp_path) as live:
        beats: list[int] = []
        beat = live.robot.beat
        monkeypatch.setattr(live.robot, "beat", lambda: (beats.append(1), beat()))
        live.until(lambda: len(beats) > 5)
        Frail.falls = 1
        live.until(lambda: live.runtime.pilots.failure)
        live.on_loop(lambda: None)
        before = len(beats)
        live.on_loop(lambda: live.runtime._tick(0.0))
        assert len(beats) == before


def test_frames_come_less_often_while_the_robot_stands_and_nobody_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Live(tmp_path) as live:
        told = [True]
        monkeypatch.setattr(live.robot, "rest", told.append)
        live.until(lambda: not told[-1])  # it looks around
        live.until(lambda: told[-1])
        with live.open(token=live.viewer):
            live.until(lambda: not told[-1])
        live.until(lambda: told[-1])
        live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator)
        live.until(lambda: not told[-1])


class Slow(Pilot):
    """The real pilot, until it is caught in a step."""

    caught = threading.Event()
    caught.set()

    def step(self, frame: SensorFrame, *, deaf: bool = False) -> Snapshot:
        type(self).caught.wait()
        return super().step(frame, deaf=deaf)


def test_a_pilot_that_hangs_is_noticed_and_the_gate_hears_no_heartbeat(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("console.robot.pilot_thread.HUNG_SIMULATED_S", HUNG_S)  # as before a real robot
    live = Live(tmp_path, make_pilot=lambda: Slow(live.robot.profile))
    with live:
        live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
        number = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).json["id"]
        live.until(lambda: live.robot.status().w)
        Slow.caught.clear()
        try:
            live.until(lambda: live.robot.status().w == 0.0, HUNG_S + 1.5)
            health = live.until(lambda: not (told := live.ask("GET", "/api/health").json)["ok"] and told, 2.0)
            assert health["reasons"] == [HANGS]
            assert HANGS in [notice.text for notice in live.runtime.notifications.shown]
            beats: list[int] = []
            beat, live.robot.beat = live.robot.beat, lambda: beats.append(1)  # type: ignore[method-assign]
            time.sleep(0.2)
            live.robot.beat = beat  # type: ignore[method-assign]
            assert beats == []
            told = live.ask("GET", f"/api/commands/{number}", token=live.viewer).json
            assert told["state"] == "failed" and "pilot" in told["remark"]
            assert live.ask("GET", "/api/state", token=live.viewer).json["command"] is None
        finally:
            Slow.caught.set()
        live.until(lambda: live.ask("GET", "/api/health").status == 200)
        live.until(
            lambda: any(notice.text.startswith("The pilot goes on.") for notice in live.runtime.notifications.shown)
        )
        assert HANGS not in [notice.text for notice in live.runtime.notifications.shown]  # it is over
        assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).status == 202
        live.until(lambda: live.robot.status().w)


def test_what_was_ordered_before_the_machine_slept_does_not_go_on(tmp_path: Path) -> None:
    slept = [0.0]
    with Live(tmp_path) as live:
        live.runtime._sleep = SleepWatch(lambda: slept[0])
        live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
        number = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).json["id"]
        live.until(lambda: live.robot.status().w)
        slept[0] += 10.0
        live.until(lambda: live.robot.status().w == 0.0, 2.0)
        told = live.until(
            lambda: (
                (row := live.ask("GET", f"/api/commands/{number}", token=live.viewer).json)["state"] != "running"
                and row
            )
        )
        assert told["state"] == "failed" and "slept" in told["remark"]
        time.sleep(0.3)
        assert live.robot.status().w == 0.0
        assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).status == 202
        live.until(lambda: live.robot.status().w)


def test_a_console_that_is_told_to_end_stands_at_once_and_stays_so(tmp_path: Path) -> None:
    with Live(tmp_path) as live:
        live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
        live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator)
        live.until(lambda: live.robot.status().w)
        told = round(1e9 * live.robot.now)
        live.runtime.shut_down_soon()
        live.until(lambda: live.robot.status().w == 0.0, 2.0)
        rows = live.robot.writer.rows
        stopped = next(row for row in rows if row.event == "stop" and row.t_mono_ns >= told)
        assert stopped.t_mono_ns - told < 1e8
        answer = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator)
        assert answer.status == 503 and "ending" in answer.json["detail"]
        time.sleep(0.4)
        assert live.robot.status().w == 0.0


@pytest.mark.campaign
def test_what_was_under_way_when_the_link_was_lost_is_not_told_as_running(tmp_path: Path) -> None:
    with Live(tmp_path) as live:
        live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
        number = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).json["id"]
        under_way = live.until(lambda: live.runtime.snapshot.active_command and live.runtime.snapshot)
        live.robot.cut = True
        live.until(lambda: live.ask("GET", f"/api/commands/{number}", token=live.viewer).json["state"] == "failed")
        live.until(lambda: live.ask("GET", "/api/state", token=live.viewer).json["command"] is None)
        live.runtime.snapshot = under_way  # a step that took long comes after all
        live.until(lambda: live.ask("GET", "/api/state", token=live.viewer).json["command"] is None)
        live.robot.cut = False
        live.until(lambda: live.robot.link()[0] == "live")
        time.sleep(0.5)
        assert live.runtime.snapshot.active_command is None and live.robot.status().w == 0.0


def test_a_part_that_fails_is_among_the_notices(tmp_path: Path) -> None:
    async def fail() -> None:
        raise ZeroDivisionError("secret detail")

    live = Live(tmp_path)
    live.runtime.parts.add(BackgroundTask(fail))
    with live:
        live.until(lambda: any("ZeroDivisionError" in notice.text for notice in live.runtime.notifications.shown))
        assert not any("secret" in notice.text for notice in live.runtime.notifications.shown)


def test_a_lost_gate_or_driver_is_among_the_notices(live: Live) -> None:
    live.robot.alarm("The gate has ended. It is started again.")
    live.until(
        lambda: any(notice.text.startswith("The gate has ended.") for notice in live.runtime.notifications.shown)
    )


def test_what_was_done_is_remembered_over_a_restart(tmp_path: Path) -> None:
    with Live(tmp_path) as live:
        live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
        number = live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).json["id"]
    with Live(tmp_path) as again:
        rows = again.ask("GET", "/api/commands/history", token=again.viewer).json["commands"]
        assert rows[0]["id"] == number and rows[0]["state"] == "failed"
        assert rows[0]["remark"] == "The console ended before this did."
        fresh = again.ask("POST", "/api/commands", {"text": "stop"}, token=again.operator).json["id"]
        assert fresh > number


def test_a_data_folder_that_cannot_be_written_does_not_stop_the_console(tmp_path: Path) -> None:
    in_the_way = tmp_path / "file"
    in_the_way.write_text("no folder")
    with Live(in_the_way / "home") as live:
        assert live.ask("POST", "/api/commands", {"text": "stop"}, token=live.operator).status == 202
        live.until(
            lambda: any(
                "Nothing can be saved in the data folder" in notice.text
                for notice in live.runtime.notifications.shown
            )
        )


def wait_frames(live: Live, seconds: float = 0.3) -> None:
    """Until the robot's clock has gone on."""
    stamp = live.runtime.snapshot.stamp
    live.until(lambda: live.runtime.snapshot.stamp > stamp + seconds)


def test_every_picture_is_encoded_once_and_only_when_someone_looks(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    import console.camera_stream as module

    encoded: list[str] = []
    encode = module.cv2.imencode
    monkeypatch.setattr(module.cv2, "imencode", lambda *given: (encoded.append(given[0]), encode(*given))[1])
    live.until(lambda: not live.runtime.broadcaster.viewers)
    wait_frames(live)
    encoded.clear()
    wait_frames(live)
    assert ".jpg" not in encoded
    with live.open() as one, live.open() as two:
        number = live.runtime.broadcaster.slots.get("camera", (0, b""))[0]
        before = encoded.count(".jpg")
        for line in (one, two):
            for _ in range(5):
                next(message for message in line if isinstance(message, bytes))
        assert encoded.count(".jpg") - before <= live.runtime.broadcaster.slots["camera"][0] - number + 1
