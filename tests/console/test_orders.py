"""Orders through the one dispatcher, over REST, with the real gate and the real pilot behind it."""

import io
import json
import math
import time
import zipfile
from typing import Any

import numpy as np
import pytest
import yaml

from console.access.logins import Person
from core.errors import Refused, Unavailable
from tests.console.live import Live, hear, say


def order(live: Live, text: str, token: str | None = None) -> Any:
    return live.ask("POST", "/api/commands", {"text": text}, token=token or live.operator)


def ended(live: Live, number: int, seconds: float = 30.0) -> dict[str, Any]:
    def over() -> Any:
        told = live.ask("GET", f"/api/commands/{number}", token=live.operator).json
        return told if told["state"] != "running" else None

    return live.until(over, seconds)


def truth(live: Live) -> dict[str, float]:
    return live.ask("GET", "/api/sim/truth", token=live.operator).json


def settled(live: Live) -> None:
    """The still start is over."""
    live.until(lambda: not live.runtime.snapshot.slam.looking_around)


def stood(live: Live) -> None:
    """Half a second of the robot's time has passed."""
    begun = live.runtime.snapshot.stamp
    live.until(lambda: live.runtime.snapshot.stamp > begun + 0.5)


def test_turn_left_turns_by_ninety_degrees_and_the_history_says_so(live: Live) -> None:
    settled(live)
    before = truth(live)
    answer = order(live, "turn left")
    assert answer.status == 202
    told = answer.json
    assert told["heard_as"] == "turn left" and told["source"] == "rest" and told["command"]["name"] == "turn_left"
    assert answer.headers["location"] == f"commands/{told['id']}"
    end = ended(live, told["id"])
    assert end["state"] == "done", end["remark"]
    time.sleep(0.3)
    turned = math.remainder(truth(live)["heading_rad"] - before["heading_rad"] - math.pi / 2, math.tau)
    assert abs(math.degrees(turned)) < 2
    rows = live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"]
    row = next(one for one in rows if one["source"] != "ears")  # it may still hear what was said in its room
    assert (row["id"], row["state"], row["who"]) == (told["id"], "done", "operator"), row
    assert row["duration_s"] > 0


def test_the_last_command_wins_and_the_former_is_pre_empted(live: Live) -> None:
    settled(live)
    first = order(live, "turn left").json["id"]
    second = order(live, "turn right").json["id"]
    assert ended(live, first)["state"] == "pre-empted"
    live.ask("POST", "/api/stop", token=live.viewer)
    told = ended(live, second)
    assert told["state"] == "cancelled" and "viewer" in told["remark"]


@pytest.mark.parametrize(
    "text", ["continue 99 metres", "fly", "", "turn left and then jump", "x" * 1900, "ｔｕｒｎ", "<b>"]
)
def test_what_is_not_understood_is_refused_with_a_sentence_and_suggestions(live: Live, text: str) -> None:
    answer = order(live, text)
    assert answer.status == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json["reason"] and bool(answer.json["suggestions"]) == ("99" not in text)
    assert text == "" or text not in answer.body.decode()
    row = live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"][0]
    assert row["state"] == "refused" and row["words"] == text and row["remark"] == answer.json["reason"]


def test_only_the_driver_drives_and_taking_over_stops_and_is_told(live: Live) -> None:
    settled(live)
    logins = live.runtime.access.logins
    other = logins.issue("Bert", "operator")
    number = order(live, "turn left").json["id"]
    refused = order(live, "turn right", other)
    assert refused.status == 409 and "operator drives now" in refused.json["detail"]
    assert live.ask("POST", "/api/lease", {"do": "acquire"}, token=other).status == 409
    assert live.ask("POST", "/api/lease", {"do": "release"}, token=other).status == 409
    epoch = live.ask("GET", "/api/lease", token=live.viewer).json["epoch"]
    taken = live.ask("POST", "/api/lease", {"do": "take"}, token=other)
    assert taken.status == 200 and taken.json["holder"] == "Bert" and taken.json["epoch"] == epoch + 1
    told = ended(live, number)
    assert told["state"] == "cancelled" and "Bert took over" in told["remark"]
    live.until(lambda: live.robot.status().epoch == epoch + 1 and live.robot.status().state == "armed")
    assert live.robot.status().v == 0 and live.robot.status().w == 0
    assert order(live, "turn left").status == 409
    assert any("Bert took over" in notice.text for notice in live.runtime.notifications.shown)
    assert order(live, "turn right", other).status == 202
    assert live.ask("POST", "/api/lease", {"do": "release"}, token=other).json["holder"] is None
    live.until(lambda: live.robot.status().state == "disarmed")


def test_a_halt_stays_and_its_reset_moves_nothing(live: Live) -> None:
    settled(live)
    number = order(live, "turn left").json["id"]
    live.until(lambda: live.robot.status().w)
    assert live.ask("POST", "/api/halt", token=live.viewer).status == 200
    assert ended(live, number)["state"] == "cancelled"
    live.until(lambda: live.robot.status().state == "halted")
    refused = order(live, "turn left")
    assert refused.status == 409 and "halted" in refused.json["detail"]
    assert order(live, "stop moving", live.viewer).status == 202
    assert live.ask("POST", "/api/halt/reset", token=live.viewer).status == 403
    other = live.runtime.access.logins.issue("Cleo", "operator")
    assert live.ask("POST", "/api/halt/reset", token=other).status == 409
    assert live.ask("POST", "/api/halt/reset", token=live.operator).status == 200
    live.until(lambda: live.robot.status().state == "armed")
    stood(live)
    before = truth(live)
    stood(live)
    after = truth(live)
    assert [after[key] for key in ("x_m", "y_m", "heading_rad")] == pytest.approx(
        [before[key] for key in ("x_m", "y_m", "heading_rad")], abs=2e-3
    )
    assert live.ask("POST", "/api/halt/reset", token=live.operator).status == 409
    assert order(live, "turn left").status == 202


def test_a_reset_that_the_gate_refuses_is_not_announced_as_done(live: Live) -> None:
    assert live.ask("POST", "/api/halt", token=live.operator).status == 200
    live.robot.deaf = True
    try:
        refused = live.ask("POST", "/api/halt/reset", token=live.operator)
        assert refused.status == 503 and "not reset" in refused.json["detail"]
    finally:
        live.robot.deaf = False
    live.robot.stuck = "the halt could not be lifted: Read-only file system"
    try:
        assert live.ask("POST", "/api/halt/reset", token=live.operator).status == 200
        told = live.until(
            lambda: [one.text for one in live.runtime.notifications.shown if "still halted" in one.text]
        )
    finally:
        live.robot.stuck = ""
    assert told == ["The robot is still halted: the halt could not be lifted: Read-only file system."]
    entries = live.ask("GET", "/api/audit", token=live.operator).json["entries"]
    row = next(entry for entry in entries if entry["what"] == "halt_reset")
    assert row["state"] == "failed" and "Read-only" in row["remark"]
    assert live.ask("POST", "/api/halt/reset", token=live.operator).status == 200
    live.until(lambda: live.runtime.notifications.shown[-1].text == "operator reset the halt.")


def test_every_stop_acts_whatever_its_number(live: Live) -> None:
    settled(live)
    with live.open() as line:
        for query in ("?press=4711", "?press=4711", "", "?press=nonsense", "?press=4712", "?press=4711"):
            number = order(live, "turn left").json["id"]
            assert live.ask("POST", f"/api/stop{query}", token=live.operator).json == {"stopped": True}
            assert ended(live, number)["state"] == "cancelled"
            number = order(live, "turn left").json["id"]
            say(line, kind="stop", press=4711)
            assert ended(live, number)["state"] == "cancelled"


def test_a_press_of_stop_that_comes_by_two_ways_is_recorded_once(live: Live) -> None:
    settled(live)

    def stops() -> int:
        rows = live.ask("GET", "/api/audit", token=live.operator).json["entries"]
        return sum(row["what"] == "stop" for row in rows)

    time.sleep(1.1)  # of more than three a second some are not recorded
    before = stops()
    with live.open() as line:
        say(line, kind="stop", press=4713)
        say(line, kind="echo", t=1)
        hear(line, "echo")
    assert live.ask("POST", "/api/stop?press=4713", token=live.operator).status == 200
    assert stops() == before + 1
    assert live.ask("POST", "/api/stop?press=4714", token=live.operator).status == 200
    assert stops() == before + 2


def test_a_press_of_halt_goes_two_ways_and_is_recorded_once(live: Live) -> None:
    settled(live)

    def halts() -> int:
        rows = live.ask("GET", "/api/audit", token=live.operator).json["entries"]
        return sum(row["what"] == "halt" for row in rows)

    time.sleep(1.1)  # of more than three a second some are not recorded
    before = halts()
    with live.open() as line:
        say(line, kind="halt", press=4715)
        say(line, kind="echo", t=1)
        hear(line, "echo")
    assert live.ask("POST", "/api/halt?press=4715", token=live.operator).json["latched"]
    assert halts() == before + 1
    assert live.ask("POST", "/api/halt?press=nonsense", token=live.operator).json["halted"]
    assert halts() == before + 2
    assert live.ask("POST", "/api/halt/reset", token=live.operator).status == 200
    live.until(lambda: live.robot.status().state != "halted")


def test_a_halt_is_answered_when_it_is_on_disk_or_says_that_it_is_not(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    pending = [1, 2, 3]
    with monkeypatch.context() as late:
        late.setattr(live.robot, "halt_is_latched", lambda: not pending or pending.pop() == 0)
        assert live.ask("POST", "/api/halt", token=live.viewer).json == {"halted": True, "latched": True}
        assert pending == []

    def full() -> None:
        raise Unavailable("The halt could not be saved: No space left on device.")

    monkeypatch.setattr(live.robot, "halt_is_latched", lambda: False)
    monkeypatch.setattr(live.robot, "latch_halt", full)
    told = live.ask("POST", "/api/halt", token=live.viewer)
    assert told.status == 200 and told.json["latched"] is False and "No space left" in told.json["why"]
    with live.open() as line:
        say(line, kind="halt")
        answer = hear(line, "answer")
        assert not answer["ok"] and answer["status"] == 507 and "No space left" in answer["detail"]
    assert any("may forget it" in notice.text for notice in live.runtime.notifications.shown)


def test_the_history_can_be_asked_for_in_part(live: Live) -> None:
    for _ in range(3):
        order(live, "stop moving")
    rows = live.ask("GET", "/api/commands/history?limit=2", token=live.viewer).json["commands"]
    assert len(rows) == 2 and rows[0]["id"] > rows[1]["id"]
    for wrong in ("0", "501", "many"):
        assert live.ask("GET", f"/api/commands/history?limit={wrong}", token=live.viewer).status == 422


def test_a_stop_acts_whatever_its_body_is(live: Live) -> None:
    settled(live)
    for raw, headers in (
        (b"", {}),
        (b"{", {}),
        (b"\xff" * 100, {"Content-Type": "text/plain"}),
        (b"{}", {}),
        (b"x" * 3_000_000, {}),
    ):
        number = order(live, "turn left").json["id"]
        live.until(lambda: live.robot.status().w)
        try:
            assert live.ask("POST", "/api/stop", raw=raw, headers=headers, token=live.viewer).status == 200
        except (BrokenPipeError, ConnectionResetError):
            assert len(raw) > 1_000_000
        assert ended(live, number)["state"] == "cancelled"


def test_the_last_word_of_many_is_stop(live: Live) -> None:
    settled(live)
    for _ in range(10):
        for text in ("turn left", "turn right", "continue 1 meters"):
            order(live, text)
        stopped = live.ask("POST", "/api/stop", token=live.viewer)
        assert stopped.status == 200
        sent = len(live.robot.orders)
        time.sleep(0.15)
        assert not any(order.v or order.w for order in live.robot.orders[sent:])
        assert live.robot.status().v == 0 and live.robot.status().w == 0


def test_a_hand_on_the_keys_ends_a_goal_for_good(live: Live) -> None:
    settled(live)
    with live.open() as line:
        say(line, kind="command", text="turn left", source="typed", ref=1)
        number = hear(line, "answer")["id"]
        state = hear(line, "state", true=lambda told: told["gate"]["w_rad_s"] > 0)
        for seq, v in enumerate((0.0, 0.05, 0.05, 0.05), start=1):
            gate = state["gate"]
            say(line, kind="drive", v=v, w=0, press=99, seq=seq, nonce=gate["nonce"], epoch=gate["epoch"])
            state = hear(line, "state")
        told = ended(live, number)
        assert told["state"] == "pre-empted" and "by hand" in told["remark"]
        live.until(lambda: live.robot.status().w == 0)


def test_a_lease_without_anybody_behind_it_lapses(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    settled(live)
    monkeypatch.setattr("console.control.lease.GRACE_S", 0.3)
    order(live, "turn left")
    live.ask("POST", "/api/stop", token=live.operator)
    live.until(lambda: live.runtime.lease.holder is None, 5)
    live.until(lambda: live.robot.status().state == "disarmed", 5)


def test_an_order_by_rest_keeps_its_lease_while_it_runs(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    settled(live)
    monkeypatch.setattr("console.control.lease.GRACE_S", 1.0)
    number = order(live, "turn left").json["id"]
    time.sleep(1.8)
    assert live.runtime.lease.holder is not None
    told = live.ask("GET", f"/api/commands/{number}", token=live.viewer).json
    assert told["state"] == "running", told["remark"]


@pytest.mark.parametrize("after", [0.0, 0.4])
def test_a_trip_of_the_gate_fails_what_is_under_way(live: Live, after: float) -> None:
    settled(live)
    number = order(live, "turn left").json["id"]
    live.until(lambda: live.robot.status().w)
    time.sleep(after)
    with live.robot._lock:
        live.robot.gate._trip("a test pulled the plug", live.robot._now)
    told = ended(live, number)
    assert told["state"] == "failed" and "a test pulled the plug" in told["remark"]


def test_what_the_pilot_refuses_stands_in_the_history_and_is_not_under_way(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    settled(live)

    def refuse(*_: object) -> None:
        raise Refused("Not now: the robot looks for its place.")

    monkeypatch.setattr(live.runtime.dispatcher.pilot, "tell", refuse)
    answer = order(live, "continue 1 meter")
    assert answer.status == 409 and "looks for its place" in answer.json["detail"]
    newest = live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"][0]
    assert (newest["state"], newest["remark"]) == ("refused", "Not now: the robot looks for its place.")
    assert not live.runtime.dispatcher.busy_besides(())


def test_state_has_the_keys_that_others_build_on(live: Live) -> None:
    told = live.ask("GET", "/api/state", token=live.viewer).json
    assert {"stamp_s", "pose", "dead_reckoning", "velocity", "landmarks", "direction", "command", "robot"} <= set(
        told
    )
    assert {"x_m", "y_m", "heading_rad", "cov"} == set(told["pose"])
    assert np.array(told["pose"]["cov"]).shape == (3, 3)
    assert {"url", "link", "age_s"} <= set(told["robot"])
    assert told["truth"] is not None


def test_the_map_comes_as_nav2_reads_it_and_as_a_picture(live: Live) -> None:
    live.until(lambda: live.runtime.snapshot.grid.log_odds.size)
    answer = live.ask("GET", "/api/map", token=live.viewer)
    assert answer.status == 200 and answer.headers["content-type"] == "application/zip"
    box = zipfile.ZipFile(io.BytesIO(answer.body))
    told = yaml.safe_load(box.read("map.yaml"))
    assert told["image"] == "map.pgm" and told["free_thresh"] == 0.196 and told["negate"] == 0
    magic, size, _, pixels = box.read("map.pgm").split(b"\n", 3)
    columns, rows = map(int, size.split())
    assert magic == b"P5" and len(pixels) == rows * columns and set(pixels) <= {0, 205, 254}
    assert {0, 205, 254} == set(pixels)
    picture = live.ask("GET", "/api/map.png", token=live.viewer)
    assert picture.status == 200 and picture.body.startswith(b"\x89PNG")


def test_things_are_placed_in_the_simulated_room_and_taken_away(live: Live) -> None:
    placed = live.ask("POST", "/api/sim/place", {"what": "box", "x_m": 1.4, "y_m": 1.4}, token=live.operator)
    assert placed.status == 201
    assert any(thing["id"] == placed.json["id"] for thing in plan(live)["things"])
    assert live.ask("POST", "/api/sim/remove", {"id": placed.json["id"]}, token=live.operator).status == 200
    assert not any(thing["id"] == placed.json["id"] for thing in plan(live)["things"])
    outside = live.ask("POST", "/api/sim/place", {"what": "box", "x_m": 900.0, "y_m": 0.0}, token=live.operator)
    assert outside.status == 422 and outside.json["detail"]


def plan(live: Live) -> dict[str, Any]:
    return live.ask("GET", "/api/sim/plan", token=live.viewer).json


def test_a_robot_that_is_no_recording_is_not_played(live: Live) -> None:
    refused = live.ask("POST", "/api/playback", {"action": "pause"}, token=live.operator)
    assert refused.status == 409 and "recording" in refused.json["detail"]


def test_a_part_of_the_console_that_ended_is_a_reason_of_health(live: Live) -> None:
    settled(live)
    live.until(lambda: live.ask("GET", "/api/health").status == 200)

    async def failing() -> None:
        raise AttributeError

    live.on_loop(lambda: live.runtime.keep(failing()))
    try:
        live.until(lambda: live.ask("GET", "/api/health").status == 503)
        reasons = live.ask("GET", "/api/health").json["reasons"]
        assert reasons == ["A part of the console failed (AttributeError). Restart the console."]
    finally:
        live.runtime.failure = ""


def test_a_robot_that_is_gone_takes_no_orders_and_health_says_so(live: Live) -> None:
    settled(live)
    number = order(live, "turn left").json["id"]
    live.robot.cut = True
    try:
        live.until(lambda: live.ask("GET", "/api/health").status == 503)
        assert live.ask("GET", "/api/health").json["reasons"]
        assert order(live, "turn right").status == 503
        assert order(live, "stop moving").status == 202
        assert ended(live, number)["state"] == "failed"
    finally:
        live.robot.cut = False
    live.until(lambda: live.ask("GET", "/api/health").status == 200)


def test_names_and_words_of_people_are_kept_as_they_are_and_never_in_the_log(live: Live, caplog: Any) -> None:
    live.on_loop(lambda: live.runtime.history.add("lease", Person("x", "<img src=x>\u001b[31m", "viewer")))
    newest = live.ask("GET", "/api/audit", token=live.operator)
    assert json.loads(newest.body)["entries"][0]["who"] == "<img src=x>\u001b[31m"
    assert newest.headers["content-type"] == "application/json"
    assert "img" not in caplog.text
