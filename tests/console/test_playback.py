"""A real recording behind the console: played, paused, sought, and never driven."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.console.live import Live, hear, say

pytestmark = pytest.mark.real_data


@pytest.fixture(scope="module")
def walk(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    recording = next((shared_data / "urg04lx_handheld").glob("*.mcap"))
    with Live(tmp_path_factory.mktemp("walk"), url=f"log:{recording}") as live:
        yield live


def steer(walk: Live, do: str, value: float | None = None) -> int:
    length = walk.runtime.robot.profile.duration or 0.0
    values = {"speed": value} if do == "speed" else {"t_s": None if value is None else value * length}
    body = {"action": do} if value is None else {"action": do, **values}
    return walk.ask("POST", "/api/playback", body, token=walk.operator).status


def test_it_pauses_goes_on_and_jumps(walk: Live) -> None:
    assert steer(walk, "pause") == 200
    walk.until(lambda: not walk.runtime.snapshot.running)
    assert steer(walk, "seek", 0.5) == 200
    walk.until(lambda: 0.49 < (walk.runtime.snapshot.progress or 0) < 0.55)
    assert steer(walk, "speed", 4.0) == 200
    assert walk.ask("GET", "/api/state", token=walk.viewer).json["robot"]["speed"] == pytest.approx(4.0, abs=0.05)
    assert steer(walk, "speed", 10.0) == 200  # its laser turns ten times a second: more would lose scans
    assert walk.ask("GET", "/api/state", token=walk.viewer).json["robot"]["speed"] == pytest.approx(4.0, abs=0.05)
    assert "4 times" in walk.runtime.notifications.shown[-1].text
    with walk.open() as line:
        say(line, kind="playback", action="play", ref=9)
        assert hear(line, "answer") == {"kind": "answer", "ref": 9, "ok": True, "status": 200}
        walk.until(lambda: (walk.runtime.snapshot.progress or 0) > 0.6)
        say(line, kind="playback", action="seek", t_s=700.0, ref=10)
        assert hear(line, "answer", true=lambda told: told["ref"] == 10)["status"] == 422
    assert len(walk.runtime.snapshot.scan_points) > 100


@pytest.mark.parametrize(("do", "value"), [("speed", None), ("seek", None), ("speed", 1e9), ("seek", -1.0)])
def test_values_out_of_bounds_are_refused(walk: Live, do: str, value: float | None) -> None:
    assert steer(walk, do, value) == 422


def test_a_recording_is_not_driven_and_a_stop_is_no_fault(walk: Live) -> None:
    refused = walk.ask("POST", "/api/commands", {"text": "turn left"}, token=walk.operator)
    assert refused.status == 409 and "recording" in refused.json["detail"]
    assert walk.ask("POST", "/api/lease", {"do": "acquire"}, token=walk.operator).status == 409
    stopped = walk.ask("POST", "/api/commands", {"text": "stop"}, token=walk.viewer)
    assert stopped.status == 202
    told = walk.ask("GET", f"/api/commands/{stopped.json['id']}", token=walk.viewer).json
    assert told["state"] == "done"
    assert walk.ask("POST", "/api/stop", token=walk.viewer).status == 200
    assert walk.ask("GET", "/api/sim/truth", token=walk.viewer).status == 404
    assert walk.ask("POST", "/api/playback", {"action": "pause"}, token=walk.viewer).status == 403
    part = {"action": "export", "from_s": 0.0, "to_s": 1.0}
    assert walk.ask("POST", "/api/playback", part, token=walk.operator).status == 409, "Beckon did not record it"
    assert walk.ask("GET", "/api/playback/film.webp?from_s=0&to_s=1", token=walk.viewer).status == 404


def test_the_picture_of_the_map_grows(walk: Live) -> None:
    walk.until(lambda: walk.runtime.snapshot.grid.log_odds.size)
    assert walk.ask("GET", "/api/map.png", token=walk.viewer).body.startswith(b"\x89PNG")
