"""A voice in the simulated room, from the request to the words that are shown."""

import base64
import importlib.util
import math
from functools import partial
from typing import Any

import numpy as np
import pytest

from core.install import install_extra
from core.speech.practice_voice import practice_voice
from core.speech.synthesis import can_speak, speak
from tests.console.live import Live

needs_words = pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None, reason="words need pocketsphinx: pip install pocketsphinx"
)


def babble(seconds: float) -> str:
    """A made-up voice as the request wants it."""
    voice = practice_voice(np.random.default_rng(3), seconds, 16_000)
    return base64.b64encode((4000 * voice).clip(-32768, 32767).astype("<i2").tobytes()).decode()


def say(live: Live, **wish: Any) -> Any:
    return live.ask("POST", "/api/sim/say", {"x_m": 2.0, "y_m": 1.0, **wish}, token=live.operator)


def state(live: Live) -> dict[str, Any]:
    return live.ask("GET", "/api/state", token=live.viewer).json


def utterances(live: Live) -> list[dict[str, Any]]:
    return live.ask("GET", "/api/hearing", token=live.viewer).json["utterances"]


@pytest.mark.campaign
@needs_words
def test_a_voice_is_heard_where_it_is_and_what_it_says_is_judged(live: Live) -> None:
    known = {told["id"] for told in utterances(live)}
    robot = live.ask("GET", "/api/sim/truth", token=live.operator).json
    told = say(live, pcm=babble(1.0))
    assert (told.status, told.json["seconds"]) == (202, 1.0)
    assert told.json["obeyed"] is False and "not obeyed" in told.json["note"]
    assert state(live)["chapter"] == "ours"
    heard = live.until(lambda: state(live)["direction"])
    towards = math.atan2(1.0 - robot["y_m"], 2.0 - robot["x_m"])
    assert math.remainder(heard["azimuth_world_rad"] - towards, math.tau) == pytest.approx(0.0, abs=0.15)
    assert heard["sd_heard_rad"] > 0
    one = live.until(lambda: [told for told in utterances(live) if told["id"] not in known])[0]
    assert not one["accepted"], one
    assert one["reason"]
    assert one["azimuth_rad"] == pytest.approx(heard["azimuth_rad"], abs=0.3)
    newest = live.ask("GET", "/api/commands/history?limit=1", token=live.viewer).json["commands"][0]
    assert (newest["source"], newest["state"], newest["who"]) == ("ears", "refused", "a voice in the room")


def test_long_sounds_go_through_in_pieces(live: Live) -> None:
    told = say(live, pcm=babble(6.0), id="Ann")
    assert (told.status, told.json["id"]) == (202, "Ann")
    assert told.json["seconds"] > 5.5


@pytest.mark.skipif(not can_speak(), reason="nothing here speaks: pip install espeakng-loader")
def test_text_is_spoken(live: Live) -> None:
    told = say(live, text="turn left")
    assert told.status == 202
    assert 0.3 < told.json["seconds"] < 2


def test_where_nothing_speaks_a_sentence_says_what_to_install(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.api.simulation.speak", partial(speak, speakers=()))
    told = say(live, text="turn left")
    assert told.status == 503
    assert install_extra("voice") in told.json["detail"]


@pytest.mark.parametrize(
    ("wish", "sentence"),
    [
        ({}, "text, or pcm"),
        ({"text": "…"}, "nothing to say"),
        ({"text": "stop", "voice": "klingon"}, "voice must be one of"),
        ({"pcm": "AAAA", "x_m": 900.0}, "Nobody can speak from there"),
        ({"pcm": "????"}, "base64"),
    ],
)
def test_what_cannot_be_said_is_told(live: Live, wish: dict[str, Any], sentence: str) -> None:
    told = say(live, **wish)
    assert told.status == 422
    assert sentence in told.json["detail"]


def test_viewers_do_not_speak_and_nobody_speaks_too_much(live: Live) -> None:
    wish = {"text": "stop", "x_m": 1.0, "y_m": 1.0}
    assert live.ask("POST", "/api/sim/say", wish, token=live.viewer).status == 403
    assert say(live, text="stop " * 200).status == 422


def test_the_robot_listens_when_asked_to(live: Live) -> None:
    assert live.ask("POST", "/api/hearing", {"listen": True}, token=live.viewer).status == 403
    told = live.ask("POST", "/api/hearing", {"listen": True}, token=live.operator)
    assert (told.status, told.json) == (200, {"listening": True, "obeying": False})
    assert live.until(lambda: state(live)["ears"]["level_dbfs"]) < 0
    assert live.ask("POST", "/api/hearing", {"listen": False}, token=live.operator).json == {
        "listening": False,
        "obeying": False,
    }
