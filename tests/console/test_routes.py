"""Routes over REST, on the simulated robot: stops in their order, and a stated end for all that goes wrong."""

import asyncio
import json
import math
import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest

from console.access.logins import Person
from console.maps.marks import RouteMark, RouteStop
from console.maps.routes import FILE, LOST, LOW, RouteRun, RouteService, seconds_until_open
from console.maps.service import MapService
from console.speech.robot_voice import RobotVoice
from core.errors import Unwritable
from core.pilot import Pilot
from core.sensors import SensorFrame
from core.sentences import Statement, code_of
from core.slam.map.status import LostStatus
from core.snapshot import Snapshot
from tests.console.live import MORE, Live
from tests.console.test_slam_api import LOST as LOST_STATUS


def call(live: Live, method: str, path: str, body: Any = None, *, status: int = 200, token: str = "") -> Any:
    answer = live.ask(method, path, body, token=token or live.operator)
    assert answer.status == status, answer.body
    return answer.json if answer.body else None


class Doubting(Pilot):
    """A pilot that says what the test gives it of its battery and its place; all else is real."""

    battery: float | None = None
    lost: LostStatus | None = None

    def step(self, frame: SensorFrame, **how: Any) -> Snapshot:
        snapshot = super().step(frame, **how)
        return replace(snapshot, battery=self.battery, floor=replace(snapshot.floor, lost=self.lost))


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    live = Live(tmp_path_factory.mktemp("routes"), pace=2.0)
    live.runtime._make_pilot = lambda: Doubting(live.robot.profile)
    with live:
        live.until(lambda: not live.runtime.snapshot.slam.looking_around, 60)
        for name, x, y in (("desk", 0.06, 0.0), ("sofa", 0.12, 0.0), ("door", 0.18, 0.0)):
            call(live, "POST", "/api/places", {"name": name, "x_m": x, "y_m": y}, status=201)
        stops = [{"place": name} for name in ("desk", "sofa", "door")]
        call(live, "POST", "/api/routes", {"name": "round", "stops": stops}, status=201)
        call(live, "POST", "/api/routes", {"name": "patrol", "stops": stops[:2], "loop": True}, status=201)
        waits = [{"place": "desk", "action": "wait_for_continue"}, {"place": "sofa", "wait_s": 3600.0}]
        call(live, "POST", "/api/routes", {"name": "slowly", "stops": waits}, status=201)
        yield live


@pytest.fixture
def live(opened: Live) -> Iterator[Live]:
    opened.calm()
    doubting(opened).battery, doubting(opened).lost = None, None
    opened.until(lambda: opened.runtime.snapshot.floor.lost is None and opened.runtime.snapshot.battery is None)
    yield opened
    opened.ask("POST", "/api/route/stop", {}, token=opened.operator)


def doubting(live: Live) -> Doubting:
    pilot = live.runtime.dispatcher.pilot
    assert isinstance(pilot, Doubting)
    return pilot


def progress(live: Live) -> Any:
    return call(live, "GET", "/api/route")


def comes_to(live: Live, state: str, seconds: float = 90) -> Any:
    return live.until(lambda: (told := progress(live))["state"] == state and told, seconds)


def start(live: Live, name: str) -> None:
    told = call(live, "POST", f"/api/routes/{name}/start", {"unattended": True}, status=202)
    assert (told["state"], told["stop"], told["owner"]) == ("driving", 1, "operator")


def stays(live: Live, state: str) -> None:
    """Nothing goes on by itself for a second of the robot."""
    begun = live.runtime.snapshot.stamp
    rows = live.robot.writer.rows
    live.until(lambda: live.robot.status().v == 0.0)
    first = len(rows)
    live.until(lambda: live.runtime.snapshot.stamp > begun + 1.0)
    assert progress(live)["state"] == state
    assert all(row.v == 0.0 for row in rows[first:])


def test_all_stops_are_driven_to_in_their_order_and_stand_in_the_history(live: Live) -> None:
    start(live, "round")
    call(live, "POST", "/api/routes/patrol/start", {}, status=409)
    told = comes_to(live, "ended", 200)
    assert told["reason"] == "All stops were reached." and (told["stop"], told["of"]) == (3, 3)
    true = call(live, "GET", "/api/sim/truth")
    assert math.hypot(true["x_m"] - 0.18, true["y_m"]) < 0.1
    words = [row["words"] for row in call(live, "GET", "/api/audit")["entries"] if row["what"] == "route"]
    stops = [f"round: stop {n} of 3, {name}" for n, name in ((3, "door"), (2, "sofa"), (1, "desk"))]
    assert [one for one in words if one in stops] == stops


@pytest.mark.campaign
def test_it_pauses_goes_on_skips_waits_and_stops(live: Live) -> None:
    start(live, "slowly")
    told = comes_to(live, "waiting")
    assert told["stop"] == 1 and "continue" in told["reason"]
    call(live, "POST", "/api/route/resume", {})
    live.until(lambda: progress(live)["stop"] == 2)
    assert call(live, "POST", "/api/route/pause", {})["state"] == "paused"
    stays(live, "paused")
    assert call(live, "POST", "/api/route/resume", {})["state"] == "driving"
    comes_to(live, "waiting")
    told = call(live, "POST", "/api/route/skip", {})
    assert told["state"] == "ended" and told["skipped"] == 1
    for act in ("pause", "resume", "skip", "stop"):
        call(live, "POST", f"/api/route/{act}", {}, status=409)
    start(live, "patrol")
    assert call(live, "POST", "/api/route/stop", {}, token=live.viewer)["state"] == "ended"
    stays(live, "ended")


TOUCHED = Statement("pilot.touched")


def base_fails(live: Live, why: str) -> None:
    frame = SensorFrame(stamp=live.runtime.snapshot.stamp, trouble=why)
    live.on_loop(lambda: live.runtime.parts[RouteService].on_snapshot(live.runtime.snapshot, frame))
    doubting(live).cancel("failed", why)


ENDS: dict[str, tuple[Callable[[Live], Any], str, str]] = {
    "STOP": (lambda live: call(live, "POST", "/api/stop", {}, token=live.viewer), "paused", "viewer"),
    "lost pose": (lambda live: setattr(doubting(live), "lost", LOST_STATUS), "paused", LOST),
    "operator gone": (
        lambda live: live.on_loop(lambda: live.runtime.dispatcher.forget(live.runtime.lease.holder)),
        "paused",
        "signed out",
    ),
    "a trip of the gate": (
        lambda live: live.on_loop(lambda: live.runtime.dispatcher.cancel("failed", "The gate stopped it.")),
        "ended",
        "The gate stopped it.",
    ),
    "a touch": (lambda live: doubting(live).cancel("failed", TOUCHED), "paused", TOUCHED),
    "the base does not answer": (lambda live: base_fails(live, "It does not answer."), "paused", "does not answer"),
    "the pilot fails": (
        lambda live: live.on_loop(lambda: live.runtime.dispatcher.ended_without_pilot("The pilot failed.")),
        "ended",
        "The pilot failed.",
    ),
    "a zone is drawn": (
        lambda live: call(
            live,
            "POST",
            "/api/zones",
            {"name": "hole", "kind": "keep_out", "points_m": [[2.0, 2.0], [2.2, 2.0], [2.2, 2.2]]},
            status=201,
        ),
        "paused",
        "zone",
    ),
}


@pytest.mark.parametrize("fault", ENDS)
def test_each_fault_has_its_stated_end_and_nothing_moves_after_it(live: Live, fault: str) -> None:
    inject, state, why = ENDS[fault]
    start(live, "patrol")
    inject(live)
    assert why in comes_to(live, state)["reason"]
    stays(live, state)


@pytest.mark.campaign
def test_another_command_pauses_a_route_and_it_stays_so_when_that_is_done(live: Live) -> None:
    start(live, "patrol")
    call(live, "POST", "/api/commands", {"text": "turn left"}, status=202)
    assert "turn left" in comes_to(live, "paused")["reason"]
    live.until(lambda: live.runtime.snapshot.active_command is None, 30)
    stays(live, "paused")


def test_a_newer_command_that_is_refused_leaves_the_route_driving_and_its_stop_stops(live: Live) -> None:
    call(live, "POST", "/api/places", {"name": "window", "x_m": 3.0, "y_m": 0.0}, status=201)
    call(live, "POST", "/api/routes", {"name": "afar", "stops": [{"place": "window"}]}, status=201)
    service, history = live.runtime.parts[RouteService], live.runtime.history
    start(live, "afar")
    run = service.run_now
    assert run is not None
    number = run.command
    live.until(lambda: live.robot.status().v > 0.0)
    newer = call(live, "POST", "/api/commands", {"text": "stop at 19 and 19"}, status=202)
    assert live.until(lambda: (one := history.find(newer["id"])).state != "running" and one).state == "refused"
    live.until(lambda: not run.reason)
    assert (run.state, run.command) == ("driving", number)
    call(live, "POST", "/api/route/stop", {})
    stays(live, "ended")


@pytest.mark.campaign
def test_a_low_battery_lets_the_stop_be_reached_and_no_further(live: Live) -> None:
    start(live, "patrol")
    doubting(live).battery = 0.1
    told = comes_to(live, "paused")
    assert told["reason"] == LOW and told["stop"] == 1
    stays(live, "paused")
    assert call(live, "POST", "/api/route/resume", {}, status=409)["detail"] == LOW


def test_a_blocked_stop_is_tried_again_and_then_ends_or_is_left_out(live: Live) -> None:
    service = live.runtime.parts[RouteService]
    for name, state in (("round", "ended"), ("patrol", "driving")):
        start(live, name)
        run = service.run_now
        assert run is not None

        def block(run: RouteRun = run) -> None:
            live.runtime.dispatcher.pilot.cancel("failed", "The way is blocked.")  # type: ignore[union-attr]

        for tries in (1, 2):
            block()
            live.until(lambda run=run, tries=tries: run.tries == tries)
            assert run.command is None and "tried again" in run.reason
            run.until = 0.0
            live.until(lambda run=run: run.command is not None)
        block()
        live.until(lambda run=run, state=state: run.stop == 1 or run.state == "ended")
        assert run.state == state
        live.ask("POST", "/api/route/stop", {}, token=live.operator)


def test_a_route_of_unknown_places_or_names_is_refused(live: Live) -> None:
    call(live, "POST", "/api/routes", {"name": "x", "stops": [{"place": "moon"}]}, status=404)
    call(live, "POST", "/api/routes", {"name": "round", "stops": [{"place": "desk"}]}, status=409)
    call(live, "POST", "/api/routes/none/start", {}, status=404)
    call(live, "POST", "/api/routes/round/start", {}, status=403, token=live.viewer)


def test_a_renamed_place_stays_in_its_routes_and_a_removed_one_is_named(live: Live) -> None:
    service = live.runtime.parts[RouteService]
    start(live, "round")
    call(live, "POST", "/api/route/pause", {})
    call(live, "PATCH", "/api/places/door", {"name": "garden"})
    assert service.run_now is not None and service.run_now.route.stops[2].place == "garden"
    call(live, "POST", "/api/route/stop", {})
    (row,) = [one for one in call(live, "GET", "/api/routes")["routes"] if one["name"] == "round"]
    assert [one["place"] for one in row["stops"]] == ["desk", "sofa", "garden"]
    call(live, "DELETE", "/api/places/garden", status=204)
    refused = call(live, "POST", "/api/routes/round/start", {}, status=404)
    assert "“garden”" in refused["detail"] and refused["code"] == "routes.no_place"
    call(live, "POST", "/api/places", {"name": "garden", "x_m": 0.18, "y_m": 0.0}, status=201)
    call(live, "PATCH", "/api/places/garden", {"name": "door"})
    call(live, "POST", "/api/routes/round/start", {}, status=202)
    call(live, "POST", "/api/route/stop", {})


def test_after_a_restart_it_stands_as_interrupted(live: Live) -> None:
    service = live.runtime.parts[RouteService]
    run = RouteRun(RouteMark("round", (RouteStop("desk"), RouteStop("sofa"))), Person("1", "Ada"), True, stop=1)
    live.until(lambda: service._writing is None)
    (live.home / FILE).write_text(json.dumps(msgspec.to_builtins(run)))
    live.run(service.open())
    told = progress(live)
    assert (told["state"], told["stop"], told["name"]) == ("ended", 2, "round") and "started again" in told["reason"]
    stays(live, "ended")


@pytest.mark.parametrize(
    "spoilt", ['{"stop": 9}', '{"stop": -3}', '{"route": {"name": "x", "stops": []}}', "[" * 99_999]
)
def test_a_spoilt_file_of_the_running_route_is_passed_over(live: Live, spoilt: str) -> None:
    service = live.runtime.parts[RouteService]
    live.until(lambda: service._writing is None)
    run = RouteRun(RouteMark("round", (RouteStop("desk"), RouteStop("sofa"))), Person("1", "Ada"), True)
    whole = json.dumps(msgspec.to_builtins(run) | json.loads(spoilt)) if spoilt.startswith("{") else spoilt
    (live.home / FILE).write_text(whole)
    before = progress(live)
    live.run(service.open())
    assert progress(live) == before


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"stops": [{"place": "desk"}]}, "routes.turns_on_the_spot"),
        ({"stops": [{"place": "desk"}, {"place": "desk"}]}, "routes.turns_on_the_spot"),
        ({"begins": "08:30", "ends": "08:30"}, "routes.no_hours"),
    ],
)
def test_rounds_without_a_way_or_a_time_are_refused(live: Live, change: dict[str, Any], code: str) -> None:
    asked = {"name": "x", "stops": [{"place": "desk"}, {"place": "sofa"}], "loop": True}
    assert call(live, "POST", "/api/routes", asked | change, status=422)["code"] == code


def test_a_slow_disk_holds_no_route_and_gets_the_newest(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    service, free, written = live.runtime.parts[RouteService], threading.Event(), list[str]()

    def slowly(path: Path, content: str) -> None:
        free.wait(MORE)
        written.append(json.loads(content)["state"])

    live.until(lambda: service._writing is None)
    monkeypatch.setattr("console.maps.routes.write_atomic", slowly)
    rows = live.robot.writer.rows
    first = len(rows)
    start(live, "patrol")
    live.until(lambda: any(row.v > 0.0 for row in rows[first:]))
    call(live, "POST", "/api/route/pause", {})
    call(live, "POST", "/api/route/stop", {})
    told = live.runtime.notifications.shown[-1].text
    assert told == Statement("routes.tells", name="patrol", why="Ended by operator.") and code_of(told).code
    assert not written
    free.set()
    live.until(lambda: service._writing is None)
    assert written == ["driving", "ended"]


def test_a_picture_at_a_stop_is_of_that_stop_or_none_is_kept(live: Live) -> None:
    service = live.runtime.parts[RouteService]
    noted: list[tuple[str, str]] = []
    live.until(lambda: service._picture is not None)

    async def takes(age: float) -> None:
        """The route goes on at once."""
        run = RouteRun(RouteMark("snap", (RouteStop("desk"), RouteStop("sofa"))), Person("1", "operator"), True)
        assert service._picture is not None
        image, pose = service._picture
        service._picture = replace(image, stamp=service._stamp - age), pose
        asyncio.get_running_loop().call_soon(setattr, run, "stop", 1)
        await service._take_picture(run, run.here)

    service.when_noted.append(lambda words, remark: noted.append((words, remark)))
    for age in (0.0, 60.0, -60.0):  # the last is of before the robot's clock began again
        live.run(takes(age))
    service.when_noted.pop()
    (name,) = [one.name for one in service.pictures.glob("snap-*-1.jpg")]
    at = "snap: stop 1 of 2, desk"
    assert noted == [(at, Statement("routes.picture", name=name))] + 2 * [(at, Statement("routes.no_camera"))]
    (service.pictures / name).unlink()


def test_it_speaks_at_a_stop_each_time_and_drives_on_when_it_is_silent_again(live: Live) -> None:
    service, voice = live.runtime.parts[RouteService], live.runtime.parts[RobotVoice]
    route = RouteMark("tour", (RouteStop("desk", action="say", text="Hello"), RouteStop("sofa")))
    run = RouteRun(route, Person("1", "operator", "operator"), unattended=True)

    def arrives() -> int:
        service._act(run)
        return live.runtime.notifications.shown[-1].id

    first = live.on_loop(arrives)
    assert live.on_loop(arrives) > first, "a browser says each notice once"
    voice._end, run.state = math.inf, "waiting"
    live.on_loop(lambda: (setattr(service, "run_now", run), service.tick(time.monotonic())))
    assert run.state == "waiting" and run.stop == 0
    voice._end = 0.0
    live.on_loop(lambda: service.tick(time.monotonic()))
    assert run.stop == 1


@pytest.mark.campaign
def test_actions_at_stops_say_record_and_take_pictures_and_stand_in_the_history(live: Live) -> None:
    stops = [
        {"place": "desk", "action": "say", "text": "Good morning"},
        {"place": "sofa", "action": "take_a_picture"},
        {"place": "desk", "action": "record", "wait_s": 0.2},
    ]
    call(live, "POST", "/api/routes", {"name": "acts", "stops": stops}, status=201)
    call(live, "POST", "/api/routes", {"name": "x", "stops": [{"place": "desk", "action": "say"}]}, status=422)
    start(live, "acts")
    assert comes_to(live, "ended", 200)["reason"] == "All stops were reached."
    (name,) = live.until(lambda: call(live, "GET", "/api/route/pictures")["pictures"])
    jpeg = live.ask("GET", f"/api/route/pictures/{name}", token=live.viewer).body
    assert (
        jpeg[:4] == b"\xff\xd8\xff\xfe"
        and b'"place": "sofa"' in jpeg[:400]
        and cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).shape[2] == 3
    )
    call(live, "GET", "/api/route/pictures/none.jpg", status=404)

    notes = live.until(lambda: len(found := call(live, "GET", "/api/route")["notes"]) > 5 and found)
    assert {note["place"] for note in notes} == {"desk", "sofa"} and {note["state"] for note in notes} == {"done"}
    (taken,) = [note for note in notes if note["picture"]]
    assert (taken["stop"], taken["place"], taken["picture"]) == (2, "sofa", name)

    def remarks() -> str:
        rows = call(live, "GET", "/api/audit")["entries"]
        return " ".join(row["remark"] for row in rows if row["what"] == "route")

    live.until(lambda: "Good morning" in remarks() and name in remarks() and "has begun" in remarks())
    live.until(lambda: any("acts" in one["note"] for one in call(live, "GET", "/api/recordings")["recordings"]), 60)


def test_pictures_are_listed_newest_first_and_one_that_is_gone_meanwhile_is_left_out(live: Live) -> None:
    folder = live.runtime.parts[RouteService].pictures
    folder.mkdir(parents=True, exist_ok=True)
    names = ("zz-old.jpg", "aa-new.jpg")
    for second, name in enumerate(names):
        (folder / name).write_bytes(b"")
        os.utime(folder / name, (second, second))
    (folder / "gone.jpg").symlink_to(folder / "removed")  # listed, but no more there when it is looked at
    listed = call(live, "GET", "/api/route/pictures")["pictures"]
    assert "gone.jpg" not in listed and [name for name in listed if name in names] == [*reversed(names)]
    for name in (*names, "gone.jpg"):
        (folder / name).unlink()


def test_it_is_started_paused_and_resumed_by_words(live: Live) -> None:
    said = ("start the route patrol", "pause", "go on", "stop moving", "go on")
    for words, state in zip(said, ("driving", "paused", "driving", "paused", "driving"), strict=True):
        entry = call(live, "POST", "/api/commands", {"text": words}, status=202)
        assert progress(live)["state"] == state and entry["command"]["name"].endswith(("_route", "stop_moving"))
    call(live, "POST", "/api/commands", {"text": "start the route patrol"}, status=409)
    call(live, "POST", "/api/commands", {"text": "start the route nowhere"}, status=422)
    call(live, "POST", "/api/commands", {"text": "follow wall"}, status=202)
    call(live, "POST", "/api/commands", {"text": "pause"}, status=202)

    def follows() -> str:
        history = call(live, "GET", "/api/commands/history")["commands"]
        return next(one["state"] for one in history if one["words"] == "follow wall")

    live.until(lambda: follows() == "cancelled")
    assert progress(live)["state"] == "paused"


@pytest.mark.parametrize("kept", [True, False])
def test_a_route_that_runs_follows_a_new_name_before_it_is_on_the_disk_and_back_where_it_was_not_kept(
    live: Live, monkeypatch: pytest.MonkeyPatch, kept: bool
) -> None:
    maps, writes = live.runtime.parts[MapService], threading.Event()
    keep = maps._keep_marks

    async def slow(*marks: Any, **how: Any) -> None:
        await asyncio.to_thread(writes.wait, 60)
        if not kept:
            raise Unwritable("The disk is full.")
        await keep(*marks, **how)

    call(live, "POST", "/api/places", {"name": "bench", "x_m": 0.1, "y_m": 0.0}, status=201)
    call(live, "POST", "/api/routes", {"name": "linger", "stops": [{"place": "bench", "wait_s": 60.0}]}, status=201)
    start(live, "linger")
    monkeypatch.setattr(maps, "_keep_marks", slow)
    change = threading.Thread(
        target=lambda: live.ask("PATCH", "/api/places/bench", {"name": "table"}, token=live.operator)
    )
    change.start()
    run = live.runtime.parts[RouteService].run_now
    assert run is not None
    live.until(lambda: any(one["name"] == "table" for one in call(live, "GET", "/api/places")["places"]))
    assert run.here.place == "table"
    writes.set()
    change.join()
    assert run.here.place == ("table" if kept else "bench")
    monkeypatch.undo()
    call(live, "POST", "/api/route/stop", {})
    call(live, "DELETE", "/api/routes/linger", status=204)
    call(live, "DELETE", f"/api/places/{run.here.place}", status=204)


@pytest.mark.campaign
def test_rounds_begin_within_their_hours_only(live: Live) -> None:
    service = live.runtime.parts[RouteService]
    stops = [{"place": "desk"}]
    hours = {"loop": True, "begins": "08:30", "ends": "17:00", "every_min": 30.0}
    call(live, "POST", "/api/routes", {"name": "hours", "stops": stops, **hours}, status=201)
    for wrong in ({"begins": "8:30"}, {"ends": ""}, {"loop": False}):
        call(live, "POST", "/api/routes", {"name": "x", "stops": stops, **hours, **wrong}, status=422)
    night = time.mktime((2026, 3, 2, 22, 0, 0, 0, 0, -1))
    service.clock = lambda: night
    try:
        told = call(live, "POST", "/api/routes/hours/start", {"unattended": True}, status=202)
        assert told["state"] == "waiting" and "08:30" in told["reason"]
        stays(live, "waiting")
        service.clock = lambda: night + 10.5 * 3600
        assert service.run_now is not None
        live.until(lambda: service.run_now.rounds == 1, 60)
        told = comes_to(live, "waiting")
        assert "09:00" in told["reason"]
        call(live, "POST", "/api/stop", {})
        assert call(live, "POST", "/api/route/resume", {})["state"] == "driving", "the next round begins at once"
        live.until(lambda: service.run_now.rounds == 2, 60)
    finally:
        service.clock = time.time


def test_between_two_rounds_there_is_no_stop_to_leave_out(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    night = time.mktime((2026, 3, 2, 22, 0, 0, 0, 0, -1))
    monkeypatch.setattr(live.runtime.parts[RouteService], "clock", lambda: night)
    shift = {"name": "shift", "stops": [{"place": "desk"}, {"place": "sofa"}], "loop": True}
    call(live, "POST", "/api/routes", {**shift, "begins": "08:30", "ends": "17:00"}, status=201)
    call(live, "POST", "/api/routes/shift/start", {"unattended": True}, status=202)
    assert "next round" in call(live, "POST", "/api/route/skip", {}, status=409)["detail"]
    assert (progress(live)["state"], progress(live)["stop"]) == ("waiting", 1)
    assert call(live, "POST", "/api/route/resume", {})["state"] == "driving"
    run = live.runtime.parts[RouteService].run_now
    assert run is not None and not run.rests and run.round_at == night


def test_a_round_that_is_begun_after_a_pause_counts_from_then(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    service = live.runtime.parts[RouteService]
    night = time.mktime((2026, 3, 2, 22, 0, 0, 0, 0, -1))
    monkeypatch.setattr(service, "clock", lambda: night)
    late = {"name": "late", "stops": [{"place": "desk"}], "loop": True, "begins": "08:30", "ends": "17:00"}
    call(live, "POST", "/api/routes", {**late, "every_min": 60.0}, status=201)
    call(live, "POST", "/api/routes/late/start", {"unattended": True}, status=202)
    assert call(live, "POST", "/api/route/pause", {})["state"] == "paused"
    noon = night + 14 * 3600
    monkeypatch.setattr(service, "clock", lambda: noon)
    assert call(live, "POST", "/api/route/resume", {})["state"] == "driving"
    assert service.run_now is not None and service.run_now.round_at == noon


def test_rounds_go_on_after_the_clock_was_set_back(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    service, now = live.runtime.parts[RouteService], 1e9
    hourly = RouteMark("hourly", (RouteStop("desk"),), loop=True, every_min=60.0)
    run = RouteRun(hourly, Person("a", "anna"), unattended=True, round_at=now + 1e8)
    monkeypatch.setattr(service, "clock", lambda: now)
    assert live.on_loop(lambda: service._rest(run)) == 3600.0
    monkeypatch.setattr(service, "clock", lambda: now + 600)
    assert live.on_loop(lambda: service._rest(run)) == 3000.0


def test_hours_may_lie_over_midnight() -> None:
    at = time.mktime((2026, 3, 2, 23, 0, 0, 0, 0, -1))
    assert seconds_until_open("22:00", "06:00", at) == seconds_until_open("", "", at) == 0.0
    assert seconds_until_open("22:00", "06:00", at + 8 * 3600) == 15 * 3600
    assert seconds_until_open("08:30", "17:00", at) == 9.5 * 3600
