"""A recording of Beckon's own behind the console: shown as recorded, as computed now, and one over the other."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from core.commands.command import Command
from core.robots.requests import SetListening, Speak
from core.sensors.recordable import unpack_picture
from core.simulation.faulty_robot import open_robot
from core.speech.understanding.grammar import understand
from tests.console.live import Live
from tests.console.recording.drives import RecordedPilot, drive

FRAMES = 240


def acts(number: int, recorded: RecordedPilot) -> None:
    """A turn to the left, given by Ada."""
    command = understand("turn left")
    if number == 110 and isinstance(command, Command):
        recorded.pilot.tell(7, command, "typed", "Ada")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[RecordedPilot, Path]:
    path = tmp_path_factory.mktemp("drive") / "a turn.mcap"
    robot = open_robot("lab", seed=3, settings=None)
    robot.ask(SetListening(on=True))
    robot.ask(Speak(x_m=1.2, y_m=0.8, text="hello"))
    return drive(robot, path, FRAMES, acts), path


@pytest.fixture(scope="module")
def live(recording: tuple[RecordedPilot, Path], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with Live(tmp_path_factory.mktemp("replayed"), url=f"log:{recording[1]}", no_auth=True) as live:
        yield live


def steer(live: Live, action: str, **values: object) -> int:
    return live.ask("POST", "/api/playback", {"action": action, **values}).status


def test_it_shows_what_was_computed_that_day(live: Live, recording: tuple[RecordedPilot, Path]) -> None:
    then = {one.stamp: one for one in recording[0].snapshots}
    assert live.runtime.snapshot is not None
    assert steer(live, "seek", t_s=4.0) == 200
    live.until(lambda: (live.runtime.snapshot.progress or 0) > 0.6 and not live.runtime.snapshot.running)
    shown = live.runtime.snapshot
    same = then[shown.stamp]
    assert shown.estimate.pose == same.estimate.pose
    assert shown.active_command.who == "Ada" and shown.active_command.name == "turn_left"
    assert len(shown.scan_points) > 100 and shown.grid.log_odds.size and not shown.running
    assert live.ask("POST", "/api/commands", {"text": "turn left"}).status == 409
    assert live.ask("GET", "/api/state").json["playback"]["way"] == "recorded"


def test_its_marks_and_its_place_are_told(live: Live, recording: tuple[RecordedPilot, Path]) -> None:
    told = live.ask("GET", "/api/playback").json
    assert told["duration_s"] == pytest.approx((FRAMES - 1) / 40, abs=0.01)
    assert told["speed"] == 1.0 and told["ways"] == ["recorded", "computed"] and told["marks"] == []
    assert steer(live, "seek", t_s=-1.0) == steer(live, "seek") == steer(live, "speed", speed=21.0) == 422
    assert steer(live, "way", way="dreamt") == steer(live, "way") == 422


def test_computed_now_over_recorded_is_the_same_to_the_last_bit(live: Live) -> None:
    assert steer(live, "seek", t_s=0.0) == steer(live, "way", way="recorded", compare=True) == 200
    assert steer(live, "speed", speed=20.0) == steer(live, "play") == 200
    live.until(lambda: live.runtime.snapshot.progress == 1.0 and not live.runtime.snapshot.running, seconds=120.0)
    live.until(lambda: any(one.text == "The recording ends here." for one in live.runtime.notifications.shown))
    other = live.runtime.snapshot.other
    assert other.same and other.frames == FRAMES and other.worst == 0.0
    told = live.ask("GET", "/api/state").json["playback"]["comparison"]
    assert told["same"] and told["distance_m"] == 0.0 and told["frames"] == FRAMES
    assert steer(live, "way", way="computed") == 200
    live.until(lambda: live.runtime.snapshot.other is None)


def test_what_is_computed_from_a_place_on_begins_there(live: Live) -> None:
    assert steer(live, "way", way="computed", compare=True) == steer(live, "seek", t_s=3.0) == 200
    live.until(lambda: live.runtime.snapshot.other is not None and (live.runtime.snapshot.progress or 0) < 0.6)
    other = live.runtime.snapshot.other
    assert not other.same and other.distance < 1e-9 and other.frames == 1
    assert live.ask("GET", "/api/playback").json["computed_since_s"] == pytest.approx(3.0, abs=0.05)
    assert steer(live, "way", way="recorded") == 200


def test_a_part_of_what_plays_is_a_recording_of_its_own_and_a_film(live: Live) -> None:
    told = live.ask("POST", "/api/playback", {"action": "export", "from_s": 1.0, "to_s": 3.0})
    assert told.status == 200 and told.json["done"] == "export", told.body
    part = told.json["recording"]
    assert part["name"] == "a turn 1-3 s" and part["seconds"] == pytest.approx(2.0, abs=0.05)
    assert [path.name for path in (live.home / "recordings").iterdir()] == ["a turn 1-3 s.mcap"]
    assert live.ask("GET", "/api/recordings").json["recordings"][0]["messages"]["/beckon/frame"] == 81
    film = live.ask("GET", "/api/playback/film.webp?from_s=1&to_s=2")
    assert film.headers["content-type"] == "image/webp" and film.body.startswith(b"RIFF")
    for values in ({}, {"from_s": 3.0}, {"from_s": 3.0, "to_s": 1.0}, {"from_s": 900.0, "to_s": 901.0}):
        assert steer(live, "export", **values) == 422
    assert live.ask("GET", "/api/playback/film.webp?from_s=900&to_s=901").status == 422


@pytest.mark.campaign
def test_a_picture_is_there_wherever_one_seeks(live: Live) -> None:
    for place in (5.5, 0.7, 2.2):
        assert steer(live, "seek", t_s=place) == 200
        live.until(lambda place=place: abs((live.runtime.snapshot.progress or 0) * FRAMES / 40 - place) < 0.1)
        assert live.runtime.snapshot.view is not None
    assert unpack_picture(b"no picture") is None
