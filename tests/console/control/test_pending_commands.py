"""A spoken order that waits: begun, dropped, replaced, and who may do which."""

import math
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from console.access.logins import Person
from console.control.command_freshness import Spoken
from console.control.command_preview import caller, preview
from console.control.pending_commands import PendingCommands
from console.http.problems import Problem
from console.scene.overlays.plan import DASH_M, PreviewLines, dashed, strokes_of
from console.speech.browser_microphone import BrowserMicrophone
from console.speech.room_transcription import RoomTranscriber
from core.commands.command import Command
from core.commands.confirmation_delay import RECOGNITION_TIME_S
from core.perception.people.voice_bearing import VoiceBearing
from core.speech.understanding.grammar import understand
from tests.console.live import Live, hear, say
from tests.core.speech.ears import confirming, sure, unsure

LONG = 600.0  # [s]: nothing begins by itself
SHORT = 3.0  # [s]: long enough for a busy console to tell of it


def read(words: str) -> Command:
    heard = understand(words)
    assert isinstance(heard, Command)
    return heard


def person(live: Live, token: str) -> Person:
    found = live.runtime.access.logins.bearer(token, 0.0)
    assert found is not None
    return found


def speak(live: Live, words: str, source: str = "voice", token: str = "", call: VoiceBearing | None = None) -> int:
    """Spoken by the operator → the number of the order that waits."""
    who = person(live, token or live.operator)
    live.ask("POST", "/api/lease", {"do": "acquire"}, token=token or live.operator)
    return live.on_loop(
        lambda: live.runtime.parts[PendingCommands].take(
            replace(sure(words), command=replace(read(words), call=call)), source, who, Spoken.now()
        )
    ).id


def shown(live: Live) -> Any:
    return live.ask("GET", "/api/state", token=live.viewer).json["pending_command"]


def newest(live: Live) -> dict[str, Any]:
    return live.ask("GET", "/api/commands/history?limit=1", token=live.viewer).json["commands"][0]


def ask(live: Live, what: str, number: int, token: str = "") -> Any:
    return live.ask("POST", f"/api/pending-command/{what}", {"id": number}, token=token or live.operator)


@pytest.fixture
def pending_commands(live: Live, monkeypatch: pytest.MonkeyPatch) -> Iterator[PendingCommands]:
    live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
    assert live.ask("POST", "/api/lease", {"do": "acquire"}, token=live.operator).status == 200
    monkeypatch.setattr(live.runtime.parts[PendingCommands], "delay", LONG)
    yield live.runtime.parts[PendingCommands]
    live.ask("POST", "/api/stop", token=live.operator)


@pytest.fixture
def rejected(pending_commands: PendingCommands, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The words of which it was told that someone did not want them."""
    told: list[str] = []
    monkeypatch.setattr(
        pending_commands, "when_rejected", [lambda pending_command: told.append(pending_command.words)]
    )
    return told


def test_a_far_order_waits_for_all_to_see_and_begins_by_itself(live: Live, pending_commands: PendingCommands) -> None:
    pending_commands.delay = SHORT
    with live.open(token=live.viewer) as line:
        number = speak(live, "continue 3 meters")
        told = hear(line, "state", true=lambda state: state["pending_command"])["pending_command"]
        hear(line, "state", true=lambda state: not state["pending_command"])
    assert (told["id"], told["numbers"], told["who"]) == (number, {"distance_m": 3.0}, "operator")
    assert 0 <= told["begins_in_s"] <= told["delay_s"] == SHORT
    assert math.dist(told["way"][0], told["goal"]) == pytest.approx(3.0, abs=0.05)
    row = live.until(lambda: newest(live) if newest(live)["name"] == "continue" else None)
    assert (row["source"], row["words"]) == ("voice", "continue 3 meters")


@pytest.mark.parametrize("how", ["dropped", "stopped"])
def test_who_reads_words_is_told_of_an_order_that_was_held_back(live: Live, rejected: list[str], how: str) -> None:
    number = speak(live, "continue 3 meters")
    ask(live, "drop", number) if how == "dropped" else live.ask("POST", "/api/stop", token=live.operator)
    live.until(lambda: rejected == ["continue 3 meters"])


@pytest.mark.parametrize("source", ["ears", "voice"])
def test_whose_words_were_held_back_reads_them_with_that_in_mind(
    live: Live, pending_commands: PendingCommands, monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    told: list[tuple[str, str]] = []
    worker = {"ears": live.runtime.parts[RoomTranscriber], "voice": live.runtime.parts[BrowserMicrophone]}
    for name, listener in worker.items():
        monkeypatch.setattr(listener._worker, "reject", lambda words, *_, name=name: told.append((name, words)))
    with live.open("/ws/audio") as own, live.open("/ws/audio") as other, live.open("/ws/audio", token=live.viewer):
        for page in (other, own):  # spoken at the second
            say(page, kind="listen", mode="held")
            hear(page, "listening")
            say(page, kind="rest")
            live.until(lambda: live.runtime.parts[BrowserMicrophone]._turn is None, seconds=30.0)
        ask(live, "drop", speak(live, "continue 3 meters", source))
        live.until(lambda: told == [(source, "continue 3 meters")])
    live.until(lambda: len(pending_commands.when_rejected) == 1)


@pytest.mark.parametrize("how", ["control was given away", "another map came"])
def test_an_order_that_ended_with_what_it_was_told_for_was_not_held_back(
    live: Live, pending_commands: PendingCommands, rejected: list[str], how: str
) -> None:
    speak(live, "continue 3 meters")
    if how == "another map came":
        live.on_loop(lambda: live.runtime.dispatcher.cancel("cancelled", "Another map was loaded."))
    else:
        assert live.ask("POST", "/api/lease", {"do": "release"}, token=live.operator).status == 200
    live.until(lambda: pending_commands.waiting is None)
    assert not rejected


def test_an_order_that_another_one_replaced_was_not_held_back(
    live: Live, pending_commands: PendingCommands, rejected: list[str]
) -> None:
    speak(live, "continue 3 meters")
    speak(live, "continue 2 meters")
    live.on_loop(lambda: pending_commands.forget("voice", "Nobody listens any more."))
    assert not rejected and pending_commands.waiting is None


def test_what_is_exact_and_near_begins_at_once(live: Live, pending_commands: PendingCommands) -> None:
    who = person(live, live.operator)
    entry = live.on_loop(lambda: pending_commands.take(sure("turn left"), "voice", who, Spoken.now()))
    assert newest(live)["id"] == entry.id and shown(live) is None


def test_numbers_that_were_not_heard_for_sure_wait_too(live: Live, pending_commands: PendingCommands) -> None:
    who = person(live, live.operator)
    waiting = live.on_loop(
        lambda: pending_commands.take(confirming("continue 0.5 meters"), "voice", who, Spoken.now())
    )
    assert shown(live)["id"] == waiting.id and shown(live)["uncertain"]
    speak(live, "stop at 1 and 0.5")
    assert not shown(live)["uncertain"]


def test_a_stop_that_was_not_heard_for_sure_does_not_wait(live: Live, pending_commands: PendingCommands) -> None:
    who = person(live, live.operator)
    entry = live.on_loop(lambda: pending_commands.take(confirming("stop moving"), "voice", who, Spoken.now()))
    assert newest(live)["id"] == entry.id and shown(live) is None


def test_rejected_words_neither_begin_nor_wait(live: Live, pending_commands: PendingCommands) -> None:
    who = person(live, live.operator)
    with pytest.raises(Problem) as refused:
        live.on_loop(lambda: pending_commands.take(unsure("turn left"), "voice", who, Spoken.now()))
    assert refused.value.status == 422 and "say it again" in refused.value.detail and shown(live) is None


def test_what_else_may_have_been_said_is_shown_with_what_waits(live: Live, pending_commands: PendingCommands) -> None:
    who = person(live, live.operator)
    decision = replace(confirming("continue 0.5 meters"), alternatives=(read("continue 1.5 meters"),))
    live.on_loop(lambda: pending_commands.take(decision, "voice", who, Spoken.now()))
    assert shown(live)["alternatives"] == ["continue 1.5 meters"]


def test_an_order_waits_on_while_someone_speaks(live: Live, pending_commands: PendingCommands) -> None:
    pending_commands.delay = 0.3
    who = person(live, live.operator)

    def spoken() -> float:
        waiting = pending_commands.take(sure("stop at 1 and 0.5"), "voice", who, Spoken.now())
        planned = waiting.when.begins
        pending_commands.hear()
        assert pending_commands.waiting is not None
        return pending_commands.waiting.when.begins - planned

    assert live.on_loop(spoken) == pytest.approx(RECOGNITION_TIME_S - 0.3, abs=0.1)
    live.until(lambda: shown(live) is None)
    assert newest(live)["name"] == "stop_at"
    live.on_loop(pending_commands.hear)  # nothing waits: nothing is put off
    assert pending_commands.waiting is None


def test_the_driver_begins_it_at_once_and_nobody_else(
    live: Live, pending_commands: PendingCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pending_commands, "delay", 30.0)  # longer than the questions take on a busy machine
    number = speak(live, "stop at 1 and 0.5")
    assert ask(live, "begin", number, live.viewer).status == 403
    other = live.runtime.access.logins.issue("other", "operator")
    told = ask(live, "begin", number, other)
    assert told.status == 409 and "who drives" in told.json["detail"]
    assert ask(live, "begin", number + 1).status == 404
    assert shown(live)["id"] == number
    begun = ask(live, "begin", number)
    assert begun.status == 202 and newest(live)["id"] == begun.json["entry"]
    late = ask(live, "drop", number)
    assert late.status == 404 and "has begun" in late.json["detail"]


def test_anybody_drops_it(live: Live, pending_commands: PendingCommands) -> None:
    assert ask(live, "drop", speak(live, "come here"), live.viewer).json["dropped"]
    row = newest(live)
    assert (row["name"], row["state"]) == ("come_here", "cancelled") and "Dropped by viewer" in row["remark"]
    assert shown(live) is None
    for wrong in ({}, {"id": "1"}, {"id": 0}, {"id": 1, "more": 1}):
        assert live.ask("POST", "/api/pending-command/drop", wrong, token=live.viewer).status == 422


@pytest.mark.parametrize("how", ["stop", "halt", "say stop", "skip", "a newer one", "hand", "lease", "sign out"])
def test_whatever_ends_what_is_under_way_drops_it(live: Live, pending_commands: PendingCommands, how: str) -> None:
    number = speak(live, "continue 4 meters")
    driver = person(live, live.operator)
    if how in ("stop", "halt"):
        live.ask("POST", f"/api/{how}", token=live.viewer)
    elif how == "say stop":
        live.ask("POST", "/api/commands", {"text": "stop"}, token=live.viewer)
    elif how == "skip":
        assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).status == 202
    elif how == "a newer one":
        assert speak(live, "come here") > number
    elif how == "hand":
        with live.open() as line:
            gate = hear(line, "state")["gate"]
            say(line, kind="drive", v=0.05, w=0, press=7, seq=1, nonce=gate["nonce"], epoch=gate["epoch"])
            hear(line, "state", true=lambda state: not state["pending_command"])
    elif how == "lease":
        live.ask("POST", "/api/lease", {"do": "release"}, token=live.operator)
    else:
        live.on_loop(lambda: live.runtime.dispatcher.forget(driver))
    waiting = live.runtime.parts[PendingCommands].waiting
    assert waiting is None or waiting.id != number
    rows = live.ask("GET", "/api/commands/history?limit=3", token=live.viewer).json["commands"]
    dropped = next(row for row in rows if row["numbers"] == {"distance_m": 4.0})
    assert dropped["state"] in ("cancelled", "pre-empted") and dropped["remark"].startswith("It had not begun: ")


def test_what_may_not_move_the_robot_does_not_wait(live: Live, pending_commands: PendingCommands) -> None:
    watcher = person(live, live.viewer)
    with pytest.raises(Problem) as refused:
        live.on_loop(lambda: pending_commands.take(sure("continue 3 meters"), "voice", watcher, Spoken.now()))
    assert refused.value.status == 403 and newest(live)["state"] == "refused" and shown(live) is None


def test_who_calls_is_shown_with_a_bearing_as_the_robot_stands(live: Live, pending_commands: PendingCommands) -> None:
    heading = live.runtime.snapshot.estimate.pose.heading
    call = VoiceBearing(stamp=live.runtime.snapshot.stamp, azimuth=heading + 1.0, sd=0.07, x=0.0, y=0.0)
    speak(live, "come here", "ears", call=call)
    told = shown(live)
    assert told["bearing_rad"] == pytest.approx(1.0, abs=0.1) and told["bearing_sd_rad"] == 0.07
    assert told["way"] == [] and told["goal"] is None


@pytest.mark.parametrize(
    ("words", "length"), [("turn right", 0.0), ("continue 2 meters", 2.0), ("follow wall", None)]
)
def test_what_is_foreseen_starts_at_the_robot(live: Live, words: str, length: float | None) -> None:
    command = understand(words)
    assert isinstance(command, Command)
    snapshot = live.runtime.snapshot
    seen = preview(command, snapshot, 0.1)
    strokes = strokes_of(seen, caller(command, snapshot), 0.1)
    if length is None:
        assert len(strokes) == 0
    elif length:
        assert np.hypot(*(seen.path[-1] - seen.path[0])) == pytest.approx(length)
    else:
        turned = math.remainder(seen.heading - snapshot.estimate.pose.heading, math.tau)
        assert turned == pytest.approx(-math.pi / 2)


class Lines:
    """What the scene keeps of strokes."""

    def add_line_segments(self, name: str, points: Any, colors: Any, **how: Any) -> SimpleNamespace:
        self.node = SimpleNamespace(points=points, colors=colors, visible=how["visible"])
        return self.node


def test_the_broken_lines_are_gone_when_nothing_waits_any_more(live: Live) -> None:
    waiting: list[Command] = []
    lines, snapshot = Lines(), live.runtime.snapshot
    intended = PreviewLines(lines, live.robot.profile, lambda: waiting[-1] if waiting else None)  # type: ignore[arg-type]
    for words, seen in (("", False), ("come here", False), ("continue 3 meters", True), ("", False)):
        told = understand(words)
        waiting = [told] if isinstance(told, Command) else []
        intended.show(snapshot)
        assert lines.node.visible is seen, words


def test_a_broken_line_keeps_to_its_way() -> None:
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    strokes = dashed(corner, DASH_M)
    lengths = np.hypot(*(strokes[:, 1] - strokes[:, 0]).T)
    assert (lengths <= DASH_M + 1e-9).all() and lengths.sum() == pytest.approx(1.0, abs=DASH_M)
    assert len(dashed(corner[:1], DASH_M)) == 0
