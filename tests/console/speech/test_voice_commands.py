"""Words of voices in the room, taken on by a driver: which are obeyed, and what holds them back."""

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from console.access.logins import Person
from console.control.pending_commands import PendingCommands
from console.speech.listener import BESIDE_STOP, SpokenOutcome
from console.speech.room_transcription import RoomTranscriber, RoomUtterance
from console.speech.transcription_client import within_bounds
from console.speech.voice_commands import HIGHER, NOT_OBEYED, VoiceCommands
from core.commands import SPECS
from core.commands.command import Command, CommandSpec
from core.commands.routes import PAUSE_ROUTE, START_ROUTE
from core.errors import Refused
from core.navigation.places import NamedPlace
from core.snapshot import VoiceDirection
from core.speech.recognition.decision import Decision, RecognizedUtterance, stop
from core.speech.understanding.grammar import parse, understand
from core.speech.understanding.place_names import place_phrases
from tests.console.live import Live
from tests.core.speech.ears import sure


def listen(live: Live, obey: bool, token: str = "") -> Any:
    return live.ask("POST", "/api/hearing", {"listen": True, "obey": obey}, token=token or live.operator)


def decision(words: str) -> Decision:
    """These words, as they come from a worker that knows no bounds of speech."""
    heard = understand(words)
    assert isinstance(heard, Command)
    return within_bounds(Decision(verdict="accept", command=heard, words=words))


def said(live: Live, words: str, age: float = 0.0, own: tuple[float, float] | None = None) -> str:
    """Words are said from now on, or were `age` [s] ago → why nothing is done about it.

    `own`: from when to when [s] the words were said, where others talked too.
    """
    transcriber = live.runtime.parts[RoomTranscriber]
    begin = transcriber.stamp + 0.1
    live.until(lambda: transcriber.stamp > begin + 0.1)
    end = transcriber.stamp - age
    one = RecognizedUtterance(begin=end - 0.1, end=end, decision=replace(decision(words), said=own))
    came: list[SpokenOutcome] = []

    def hear() -> str:
        transcriber._voices = (voice(end),)
        transcriber.when_heard.append(lambda outcome, _: came.append(outcome))
        transcriber._hear(one)
        transcriber.when_heard.pop()
        return came[0].reason

    return live.on_loop(hear)


def voice(stamp: float) -> VoiceDirection:
    return VoiceDirection(
        id=1,
        stamp=stamp,
        age=0.0,
        azimuth=0.0,
        azimuth_world=0.0,
        sd=0.05,
        sd_heard=0.05,
        elevation=None,
        strength=1.0,
        heard_at=np.zeros(2),
    )


def newest(live: Live) -> dict[str, Any]:
    return live.ask("GET", "/api/commands/history?limit=1", token=live.viewer).json["commands"][0]


@pytest.fixture
def spoken(live: Live) -> Any:
    live.until(lambda: live.runtime.snapshot and not live.runtime.snapshot.slam.looking_around)
    live.until(lambda: not live.runtime.dispatcher.busy_besides(()))
    yield live.runtime.parts[VoiceCommands]
    live.ask("POST", "/api/stop", token=live.operator)
    live.ask("POST", "/api/hearing", {"listen": False}, token=live.operator)


def test_nothing_is_obeyed_until_a_driver_takes_words_on(live: Live, spoken: VoiceCommands) -> None:
    assert said(live, "turn left") == NOT_OBEYED
    assert listen(live, True, live.viewer).status == 403
    told = listen(live, True)
    assert (told.status, told.json) == (200, {"listening": True, "obeying": True})
    assert said(live, "turn left") == ""
    row = live.until(lambda: newest(live) if newest(live)["source"] == "ears" else None)
    assert (row["name"], row["who"]) == ("turn_left", "operator")
    assert not listen(live, False).json["obeying"]
    assert said(live, "turn left") == NOT_OBEYED


def test_who_lost_control_has_taken_no_words_on_when_it_comes_back(live: Live, spoken: VoiceCommands) -> None:
    def lease(do: str, token: str) -> int:
        return live.ask("POST", "/api/lease", {"do": do}, token=token).status

    other = live.runtime.access.logins.issue("second operator", "operator")
    assert listen(live, True).json["obeying"] and live.ask("GET", "/api/hearing", token=live.viewer).json["obeying"]
    assert lease("take", other) == 200
    live.until(lambda: not live.ask("GET", "/api/hearing", token=live.viewer).json["obeying"])
    assert lease("release", other) == lease("acquire", live.operator) == 200
    assert said(live, "turn left") == NOT_OBEYED


def test_late_words_and_those_below_a_hand_are_not_obeyed(live: Live, spoken: VoiceCommands) -> None:
    assert listen(live, True).status == 200
    assert "too late" in said(live, "turn left", age=4.0)
    assert "5 metres" in said(live, "continue 12 meters")
    typed = live.ask("POST", "/api/commands", {"text": "turn right"}, token=live.operator)
    assert typed.status == 202
    assert said(live, "turn left") == HIGHER


def test_what_came_too_late_begins_when_a_person_confirms_it_and_a_stop_takes_the_offer_away(
    live: Live, spoken: VoiceCommands
) -> None:
    def offered() -> Any:
        return live.ask("GET", "/api/state", token=live.viewer).json["late_command"]

    def confirm(number: int, token: str) -> int:
        return live.ask("POST", "/api/pending-command/begin", {"id": number}, token=token).status

    listen(live, True)
    assert offered() is None
    assert "too late" in said(live, "turn left", age=4.0)
    late = live.until(offered)
    assert late["heard_as"] == "turn left" and confirm(late["id"], live.viewer) == 403
    assert confirm(late["id"], live.operator) == 202
    row = live.until(lambda: newest(live) if newest(live)["name"] == "turn_left" else None)
    assert (row["source"], row["state"]) == ("ears", "running")
    assert offered() is None and confirm(late["id"], live.operator) == 404
    assert "too late" in said(live, "turn right", age=4.0)
    late = live.until(offered)
    live.on_loop(lambda: live.runtime.parts[PendingCommands].left(Person("c", "Carl")))
    assert offered() == late, "another person's page closed"
    live.ask("POST", "/api/stop", token=live.operator)
    assert live.until(lambda: offered() is None) and confirm(late["id"], live.operator) == 404


def test_what_goes_to_a_person_waits_a_moment_and_stop_holds_it_back(
    live: Live, spoken: VoiceCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    pending_commands = live.runtime.parts[PendingCommands]
    assert pending_commands.delay == 2.0
    monkeypatch.setattr(pending_commands, "delay", 600.0)
    assert listen(live, True).status == 200
    before = newest(live)["id"]
    assert said(live, "come here", own=(1.25, 1.5)) == ""  # someone else talked in the same utterance
    waiting = pending_commands.waiting
    assert waiting is not None and waiting.source == "ears" and waiting.command.call is not None
    assert waiting.command.said == (1.25, 1.5)
    live.ask("POST", "/api/stop", token=live.viewer)
    pending_commands.delay = 0.2
    assert said(live, "follow me") == ""
    live.until(lambda: newest(live)["id"] > before and newest(live)["name"] == "follow_me")
    rows = live.ask("GET", "/api/commands/history?limit=5", token=live.viewer).json["commands"]
    told = [row["state"] for row in rows if row["id"] > before and row["name"] == "come_here"]
    assert told == ["cancelled"]


def test_what_waits_is_dropped_when_voices_are_obeyed_no_more(
    live: Live, spoken: VoiceCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live.runtime.parts[PendingCommands], "delay", 600.0)
    assert listen(live, True).status == 200
    assert said(live, "continue 3 meters") == ""
    assert listen(live, False).status == 200
    assert live.runtime.parts[PendingCommands].waiting is None
    assert "no more" in newest(live)["remark"]


def test_words_in_which_a_stop_was_heard_are_written_down(live: Live, spoken: VoiceCommands) -> None:
    """As "follow me" that the spotter took for STOP: the robot stops, and nobody's words vanish."""
    assert listen(live, True).status == 200
    transcriber = live.runtime.parts[RoomTranscriber]
    end = transcriber.stamp
    early = RecognizedUtterance(begin=end - 1.0, end=end - 0.4, decision=stop(), final=False)
    whole = RecognizedUtterance(begin=end - 1.0, end=end, decision=decision("follow me"))
    live.on_loop(lambda: transcriber._hear(early))
    live.on_loop(lambda: transcriber._hear(whole))
    row = newest(live)
    assert (row["words"], row["state"], row["remark"]) == ("follow me", "refused", BESIDE_STOP)
    again = RecognizedUtterance(begin=end - 1.0, end=end + 0.1, decision=stop("stop moving"))
    live.on_loop(lambda: transcriber._hear(again))
    assert newest(live)["id"] == row["id"]  # that stop has its row


def test_words_are_let_go_with_the_wheel(live: Live, spoken: VoiceCommands) -> None:
    assert listen(live, True).status == 200
    holder = live.runtime.lease.holder
    assert holder is not None
    live.on_loop(lambda: live.runtime.dispatcher.forget(holder))
    live.until(lambda: "no longer drives" in live.runtime.notifications.shown[-1].text)
    assert said(live, "turn left") == NOT_OBEYED


def test_commands_that_were_rejected_as_uncertain_are_offered_as_long_as_they_are_fresh(
    live: Live, spoken: VoiceCommands
) -> None:
    transcriber = live.runtime.parts[RoomTranscriber]
    both = ("turn left", "turn right")
    for age, offered in ((0.5, [*both]), (60.0, [])):
        end = transcriber.stamp - age
        one = RoomUtterance(
            1, end - 0.8, end, "turn left", False, None, "I am not sure.", None, None, "reject", 0.5, both
        )
        live.on_loop(lambda one=one: transcriber.utterances.append(one))
        assert live.ask("GET", "/api/state", token=live.viewer).json["ears"]["suggested_commands"] == offered


def test_until_words_are_read_the_state_says_so(live: Live, spoken: VoiceCommands) -> None:
    pytest.importorskip("pocketsphinx", reason="Reading words needs pocketsphinx: pip install pocketsphinx")

    def starting() -> bool:
        return live.ask("GET", "/api/state", token=live.viewer).json["ears"]["starting"]

    worker = live.runtime.parts[RoomTranscriber]._worker
    live.on_loop(worker.kill)
    assert starting()
    assert listen(live, True).status == 200
    live.until(lambda: not starting(), seconds=120.0)  # a worker stands back on a busy machine


def test_what_the_pilot_does_not_do_now_is_told_and_the_ears_go_on(
    live: Live, spoken: VoiceCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a voice at once, and by an order that waited: both end refused, with a notice; nobody falls deaf."""

    def not_now(*_: object) -> None:
        raise Refused("Not now: I look for my place.")

    assert listen(live, True).status == 200
    monkeypatch.setattr(live.runtime.dispatcher.pilot, "tell", not_now)
    monkeypatch.setattr(live.runtime.parts[PendingCommands], "delay", 0.05)
    for words, why in (("turn left", "Not now: I look for my place."), ("come here", "")):
        assert said(live, words) == why
        row = live.until(lambda words=words: newest(live) if newest(live)["heard_as"] == words else None)
        assert (row["state"], row["remark"]) == ("refused", "Not now: I look for my place.")
    assert live.runtime.parts[RoomTranscriber].trouble == "" and live.runtime.parts[PendingCommands].waiting is None


def test_a_spoken_command_is_parsed_once(live: Live, spoken: VoiceCommands, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is recognized; from there a command travels."""
    listen(live, True)
    calls: list[str] = []

    def counted(words: str, *own: Any) -> Any:
        calls.append(words)
        return parse(words, *own)

    for module in [name for name in sys.modules if name.startswith(("core.", "console."))]:
        if getattr(sys.modules[module], "parse", None) is parse:
            monkeypatch.setattr(sys.modules[module], "parse", counted)
    heard = within_bounds(sure("turn left"))
    monkeypatch.setitem(globals(), "decision", lambda words: heard)
    assert said(live, "turn left") == ""
    assert newest(live)["name"] == "turn_left" and calls == ["turn left"]


NAMED_PLACES = (
    NamedPlace(name="sofa", x_m=9.0, y_m=9.0),
    NamedPlace(name="round", x_m=1.0, y_m=1.0),  # a place and a route of one name
    NamedPlace(name="round", x_m=0.0, y_m=0.0, route=True),
)


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_every_command_that_words_can_mean_comes_through_the_bounds_of_speech(spec: CommandSpec) -> None:
    """A saved route makes "pause" a command of its own; lost on the way, it would neither pause nor stop."""
    own = place_phrases(NAMED_PLACES)
    meant = [one.pattern for one in own if one.kind is spec] + [spec.example] * (spec is not START_ROUTE)
    for words in meant:
        command = understand(words, own=own)
        assert isinstance(command, Command) and command.name == spec.name
        heard = within_bounds(Decision(verdict="accept", command=command, words=words), NAMED_PLACES)
        assert heard.verdict == "accept" and heard.command is not None
        given, kept = command, heard.command
        assert (kept.name, kept.numbers, kept.place) == (given.name, given.numbers, given.place)
    nowhere = Command(name=START_ROUTE.name, numbers={}, heard_as="start the route")
    assert within_bounds(Decision(verdict="accept", command=nowhere, words="start the route")).command is None


@pytest.mark.parametrize("obey", [True, False])
def test_a_voice_that_pauses_stops_whatever_moves_the_robot(
    live: Live, spoken: VoiceCommands, monkeypatch: pytest.MonkeyPatch, obey: bool
) -> None:
    """A saved route makes "pause" a command of its own; it stops no less than without routes."""
    pause = understand("pause", own=place_phrases(NAMED_PLACES))
    assert isinstance(pause, Command) and pause.name == PAUSE_ROUTE.name
    monkeypatch.setitem(globals(), "decision", lambda words: Decision(verdict="accept", command=pause, words=words))
    listen(live, obey)
    assert live.runtime.snapshot is not None
    far = 3 if live.runtime.snapshot.estimate.pose.x < 1.0 else -1
    typed = live.ask("POST", "/api/commands", {"text": f"stop at {far} and 0"}, token=live.operator)
    assert typed.status == 202
    assert said(live, "pause") == ""
    entry = live.until(lambda: (one := live.runtime.history.find(typed.json["id"])).state != "running" and one)
    assert entry.state == "cancelled"
    assert (
        entry.remark == "The robot heard “stop” in the room, or a word like it. If nobody said it, send it on again."
    )
    live.until(lambda: live.robot.status().v == 0.0)


def test_why_a_sentence_only_stopped_stays_with_the_stop() -> None:
    heard = within_bounds(stop("stop at nine and nine", remark="“stop at 9 and 9” was not carried out."))
    assert heard.command is not None and heard.command.remark == "“stop at 9 and 9” was not carried out."
