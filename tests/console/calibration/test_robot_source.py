"""Sessions that look at the robot: by themselves, on purpose, and with the simulated person."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from console.calibration.service import CalibrationService
from console.calibration.session import CalibrationSession
from core.calibration.files.camera_files import ros_yaml
from core.optics import TABLE_3
from tests.console.calibration.wizard import Wizard
from tests.console.live import Live

PANEL: dict[str, Any] = {"columns": 9, "rows": 6, "square_m": 0.03, "panel_m": [0.34, 0.25]}


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """A console of its own; what it leaves behind is no process."""
    with Live(tmp_path_factory.mktemp("robot")) as live:
        yield live
        bench = live.runtime.parts[CalibrationService]
        workers = live.on_loop(lambda: [bench.solver.pid, *(session.pid for session in bench.sessions.values())])
    assert not any(Path(f"/proc/{pid}").exists() for pid in workers if pid)


def show_demo(wizard: Wizard, on: bool) -> int:
    told = {"session": wizard.id, "on": on}
    return wizard.live.ask("POST", "/api/calibration/demo", told, token=wizard.live.operator).status


def test_the_demo_shows_the_board_and_views_are_taken_by_themselves(live: Live) -> None:
    wizard = Wizard(live, source="robot", board=PANEL)
    assert not wizard.told["live"]
    assert show_demo(wizard, on=True) == 200
    told = live.until(lambda: (now := wizard.told)["progress"]["views"] >= 1 and now)
    assert told["live"] and told["demo"] and told["size"] == [320, 256]
    assert told["advice"]["words"] and told["verdict"]["stamp_s"] > 0
    assert show_demo(wizard, on=False) == 200
    live.until(lambda: not wizard.told["demo"])
    assert wizard.post("live", {"on": False}).json["live"] is False
    empty = live.until(lambda: (verdict := wizard.post("capture").json)["kind"] == "nothing" and verdict)
    assert "board" in empty["words"]
    other = Wizard(live, source="robot")
    assert wizard.post("live", {"on": True}).json["live"]
    assert other.post("live", {"on": True}).json["live"]
    assert not wizard.told["live"]
    assert live.ask("DELETE", other.base, token=live.operator).status == 204
    assert not any(one.shown.live for one in live.runtime.parts[CalibrationService].sessions.values())


def test_nobody_steps_before_a_robot_that_drives(live: Live) -> None:
    """The board before its laser would cost it its place."""
    wizard = Wizard(live, source="robot", board=PANEL)
    bench = live.runtime.parts[CalibrationService]
    told = live.ask("POST", "/api/commands", {"text": "continue 1 meters"}, token=live.operator)
    assert told.status == 202
    live.until(lambda: bench._drives)
    assert show_demo(wizard, on=True) == 409
    assert live.ask("POST", "/api/stop", token=live.operator).status == 200
    live.until(lambda: not bench._drives)
    assert show_demo(wizard, on=True) == 200
    assert show_demo(wizard, on=False) == 200


def test_looking_ends_with_a_sentence_when_it_breaks_and_when_the_session_is_accepted(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    wizard = Wizard(live, source="robot")

    async def broken(*_: object, **__: object) -> None:
        raise ValueError("an accident")

    with monkeypatch.context() as accident:
        accident.setattr(CalibrationSession, "act", broken)
        assert wizard.post("live", {"on": True}).json["live"]
        live.until(lambda: not wizard.told["live"])
    assert "broke off" in wizard.told["verdict"]["words"] and not any(
        one.shown.live for one in live.runtime.parts[CalibrationService].sessions.values()
    )
    assert wizard.post("live", {"on": True}).json["live"]
    assert wizard.post("accept", {"force": True}).status == 409
    assert not wizard.told["live"]


def test_a_session_of_uploads_does_not_look_at_the_robot(live: Live) -> None:
    wizard = Wizard(live)
    assert wizard.post("live", {"on": True}).status == 409
    assert wizard.post("capture").status == 409


@pytest.mark.campaign
def test_the_laser_looks_at_the_empty_room_and_again_when_the_robot_was_moved(live: Live) -> None:
    headers = {"Content-Type": "text/plain"}
    text = ros_yaml(TABLE_3).encode()
    assert live.ask("POST", "/api/calibration/import", raw=text, headers=headers, token=live.operator).status == 200
    wizard = Wizard(live, "laser", "robot", board=PANEL)
    assert wizard.send(b"", "a.png").status == 409
    assert wizard.post("live", {"on": True}).status == 200
    known = live.until(lambda: (now := wizard.told)["progress"]["words"].startswith("10 more") and now, seconds=60)
    assert len(known["scan"]["points"]) > 100 and len(known["scan"]["background"]) > 100
    assert known["advice"]["words"]
    assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).status == 202
    live.until(lambda: "empty room" in wizard.told["progress"]["words"], seconds=60)
    live.ask("POST", "/api/stop", token=live.operator, headers={"Content-Length": "0"})
    assert wizard.post("background").status == 200


def test_a_session_that_saw_nothing_goes_when_another_of_its_kind_begins(live: Live) -> None:
    empty, pictures = Wizard(live, source="robot", board=PANEL), Wizard(live)
    fresh = Wizard(live, source="robot", board=PANEL)
    listed = live.ask("GET", "/api/calibration/sessions", token=live.viewer).json["sessions"]
    kept = {row["id"] for row in listed}
    assert empty.id not in kept, "there is nothing to go on with"
    assert {pictures.id, fresh.id} <= kept
