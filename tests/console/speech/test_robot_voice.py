"""The robot answers aloud, and does not hear itself."""

import asyncio
import base64
from functools import partial
from typing import Any

import numpy as np
import pytest

from console.speech.robot_voice import MAX_PLAY_DELAY_S, MAX_WAITING_S, MAX_WORDS_MOVING_S, TAIL_S, RobotVoice
from console.speech.room_transcription import RoomTranscriber
from core.errors import Refused
from core.sensors.microphones import Sound
from core.speech.synthesis import can_speak, speak
from tests.console.live import Live

RATE = 16_000
speaks = pytest.mark.skipif(not can_speak(), reason="nothing here speaks: pip install espeakng-loader")


class Clock:
    """Time that is told."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def lasting(seconds: float, clock: Clock) -> RobotVoice:
    """A robot whose every sentence lasts as long."""
    sound = Sound(stamp=0.0, rate=RATE, samples=np.zeros((round(seconds * RATE), 1)))
    return RobotVoice(lambda _text, _settings: sound, clock)


def test_nobody_is_listened_to_while_the_robot_speaks_and_a_moment_longer() -> None:
    clock = Clock()
    voice = lasting(2.0, clock)
    assert not voice.muted
    number, _ = asyncio.run(voice.say("turning left"))
    assert voice.muted and voice.deaf(5.0)
    clock.now += 2.0
    voice.hush(number)
    assert voice.muted
    clock.now += TAIL_S + 0.01
    assert not voice.muted and not voice.deaf(5.0)


def test_a_browser_that_never_tells_the_end_does_not_leave_the_robot_deaf() -> None:
    clock = Clock()
    voice = lasting(2.0, clock)
    asyncio.run(voice.say("turning left"))
    clock.now += MAX_PLAY_DELAY_S + 2.0 + TAIL_S + 0.01
    assert not voice.muted


def test_of_two_browsers_the_last_one_ends_the_silence() -> None:
    clock = Clock()
    voice = lasting(2.0, clock)
    first, _ = asyncio.run(voice.say("one"))
    second, _ = asyncio.run(voice.say("two"))
    voice.hush(first)
    clock.now += TAIL_S + 0.01
    assert voice.muted
    voice.hush(second)
    voice.hush(12345)
    clock.now += TAIL_S + 0.01
    assert not voice.muted


def test_nobody_talks_the_robot_deaf() -> None:
    voice = lasting(MAX_WAITING_S, Clock())
    with pytest.raises(Refused, match="say less"):
        asyncio.run(voice.say("and so on"))
    assert not voice.muted


def test_while_the_robot_moves_it_is_deaf_for_a_few_seconds_at_most() -> None:
    voice = lasting(MAX_WORDS_MOVING_S - MAX_PLAY_DELAY_S - TAIL_S + 0.1, Clock())
    with pytest.raises(Refused, match="no spoken STOP"):
        asyncio.run(voice.say("and so on", MAX_WORDS_MOVING_S))
    assert not voice.muted
    asyncio.run(voice.say("and so on"))
    assert voice.muted


def test_in_the_simulated_room_it_is_heard_by_the_robots_clock() -> None:
    voice = lasting(1.0, Clock())
    voice.in_room(7.0)
    assert voice.deaf(7.0 + TAIL_S / 2) and not voice.deaf(7.0 + 2 * TAIL_S)


def say(live: Live, text: str) -> Any:
    return live.ask("POST", "/api/voice", {"text": text}, token=live.operator)


@speaks
def test_an_answer_comes_as_sound_and_mutes_the_ears(live: Live) -> None:
    told = say(live, "Turn left.")
    assert told.status == 200
    assert len(base64.b64decode(told.json["pcm"])) == pytest.approx(
        2 * told.json["seconds"] * told.json["rate_hz"], abs=40
    )
    assert live.runtime.parts[RobotVoice].muted
    live.ask("POST", "/api/voice/hush", {"id": told.json["id"]}, token=live.operator)
    live.until(lambda: not live.runtime.parts[RobotVoice].muted)


@speaks
def test_the_robot_does_not_obey_what_it_says_itself_in_its_room(live: Live) -> None:
    def hearing() -> Any:
        return live.ask("GET", "/api/state", token=live.viewer).json["ears"]

    live.ask("POST", "/api/hearing", {"listen": True}, token=live.operator)
    live.until(lambda: hearing()["listening"])
    before = len(live.runtime.parts[RoomTranscriber].utterances)
    seconds = say(live, "stop moving")
    live.until(lambda: hearing()["muted"] and not hearing()["listening"])
    end = live.runtime.snapshot.stamp + seconds.json["seconds"] + 2.5  # type: ignore[union-attr]
    live.until(lambda: live.runtime.snapshot.stamp > end and hearing()["listening"], 60.0)  # type: ignore[union-attr]
    assert len(live.runtime.parts[RoomTranscriber].utterances) == before
    assert hearing()["voices"] == [] or min(one["age_s"] for one in hearing()["voices"]) > 2.0
    live.ask("POST", "/api/hearing", {"listen": False}, token=live.operator)


def test_where_nothing_speaks_a_sentence_says_what_to_install(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live.runtime.parts[RobotVoice], "_speaker", partial(speak, speakers=()))
    told = say(live, "turn left")
    assert told.status == 503 and "apt install espeak-ng" in told.json["detail"]


def test_viewers_do_not_make_the_robot_deaf(live: Live) -> None:
    assert live.ask("POST", "/api/voice", {"text": "hello"}, token=live.viewer).status == 403
    assert live.ask("POST", "/api/voice", {"text": "x" * 400}, token=live.operator).status == 422
