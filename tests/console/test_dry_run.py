"""A film instead of a webcam behind the console: COME HERE and FOLLOW ME show what a robot would do."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import pytest

from console.people.look_service import LookService
from core.perception.people.looking import ImmediateLook
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.detector import PoseDetector
from tests.console.live import Live
from tests.core.perception.stick_figures import StickNetworks, white_body
from tests.core.recording.log_writers import START, robot_messages, two, write_mcap


def film(path: Path) -> Path:
    """A person who stands there, for a second, again and again."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (640, 480))
    for _ in range(10):
        writer.write(white_body(640, 480, 420.0, 80.0, 300.0))
    writer.release()
    return path


@pytest.fixture
def webcam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Live]:
    look = ImmediateLook(PoseDetector(StickNetworks(), PeopleSettings()))
    monkeypatch.setattr(LookService, "for_pilot", look)
    with Live(tmp_path / "home", url=f"camera://{film(tmp_path / 'film.avi')}") as live:
        live.until(lambda: live.runtime.snapshot is not None and live.runtime.snapshot.view is not None)
        yield live


def test_who_is_before_the_camera_is_boxed_and_nothing_is_asked_of_the_gate(webcam: Live) -> None:
    robot = webcam.runtime.robot.profile
    assert robot.dry_run and not robot.drives
    told = webcam.ask("POST", "/api/commands", {"text": "come here"}, token=webcam.operator)
    assert told.status == 202
    person = webcam.until(
        lambda: (now := webcam.ask("GET", "/api/state", token=webcam.viewer).json["person"]) and now["camera"] and now
    )
    head = next(part for part in person["parts"] if part["name"] == "head")
    left, _, right, _ = head["box_px"]
    assert left < 420 < right
    state = webcam.ask("GET", "/api/state", token=webcam.viewer).json
    assert state["command"]["remark"].startswith("Dry run: I see you") and state["goal"] is not None
    assert webcam.robot.orders == []

    for text in ("turn left", "continue 1 meter", "follow wall"):
        refused = webcam.ask("POST", "/api/commands", {"text": text}, token=webcam.operator)
        assert refused.status == 409 and "show what they would do" in refused.json["detail"]
    assert webcam.ask("POST", "/api/commands", {"text": "come here"}, token=webcam.viewer).status == 403

    assert webcam.ask("POST", "/api/commands", {"text": "stop"}, token=webcam.viewer).status == 202
    webcam.until(lambda: webcam.ask("GET", "/api/state", token=webcam.viewer).json["person"] is None)
    first = webcam.ask("GET", f"/api/commands/{told.json['id']}", token=webcam.viewer).json
    assert first["state"] in ("cancelled", "pre-empted")


COMPRESSED = "sensor_msgs/msg/CompressedImage"


def recording(path: Path) -> Path:
    """A robot that drives an arc for ten seconds, with someone in its pictures."""
    jpeg = cv2.imencode(".jpg", white_body(640, 480, 420.0, 80.0, 300.0))[1].ravel()
    seen = [
        (
            "/camera/compressed",
            COMPRESSED,
            START + 0.2 * number,
            two.types[COMPRESSED](header=two.header(START + 0.2 * number, "eye"), format="jpeg", data=jpeg),
        )
        for number in range(50)
    ]
    return write_mcap(path, sorted([*robot_messages(two, scans=100), *seen], key=lambda one: one[2]))


@pytest.mark.campaign
def test_a_recording_with_pictures_shows_what_a_robot_would_have_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(LookService, "for_pilot", ImmediateLook(PoseDetector(StickNetworks(), PeopleSettings())))
    with Live(tmp_path / "home", url=f"log:{recording(tmp_path / 'drive.mcap')}") as live:
        profile = live.runtime.robot.profile
        assert profile.dry_run and profile.camera is not None and profile.camera.model.width == 640
        assert live.ask("POST", "/api/playback", {"action": "play"}, token=live.operator).status == 200
        assert live.ask("POST", "/api/commands", {"text": "follow me"}, token=live.operator).status == 202
        person = live.until(lambda: live.ask("GET", "/api/state", token=live.viewer).json["person"])
        assert len(person["landmarks_px"]) == 33 and person["picture_age_s"] is not None
        assert live.robot.orders == []
