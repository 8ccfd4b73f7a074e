"""A browser's microphone: its sound goes up, transcripts come down, and only whole commands move the robot."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.connection import Connection

from console.control.command_freshness import CommandFreshness
from console.messages.audio import AUDIO_HEADER, AUDIO_KIND, AUDIO_RATE_HZ
from core.commands.confirmation_delay import MAX_OBEYED_AGE_S
from core.message import Array
from core.recording.sound_file import read_sound
from core.speech.recognition.recognizer import at_16_khz
from tests.console.live import Live, hear, say

PIECE = 3200  # samples: 0.2 s, so that nothing comes faster than is allowed


@pytest.fixture
def line(live: Live) -> Iterator[Connection]:
    dispatcher, words = live.runtime.dispatcher, CommandFreshness(live.runtime.lease)
    words.time, dispatcher.freshness = (
        dispatcher.freshness.time,
        words,
    )  # what was said here began before the stops of others
    with live.open("/ws/audio") as line:
        yield line


def pieces(samples: Array, begin: float = 0.0) -> Iterator[bytes]:
    """Sound as a browser sends it."""
    sixteen = np.clip(np.round(samples * 32767), -32768, 32767).astype("<i2")
    for number, at in enumerate(range(0, len(sixteen), PIECE)):
        header = AUDIO_HEADER.pack(AUDIO_KIND, number, 1000 * (begin + at / AUDIO_RATE_HZ))
        yield header + sixteen[at : at + PIECE].tobytes()


def speak(line: Connection, samples: Array, begin: float = 0.0) -> None:
    for piece in pieces(samples, begin):
        line.send(piece)


def held(line: Connection, samples: Array) -> Any:
    """Said with the button held → the final transcript."""
    say(line, kind="listen", mode="held")
    assert hear(line, "listening")["on"]
    quiet = 1e-4 * np.random.default_rng(0).normal(size=AUDIO_RATE_HZ // 2)
    speak(line, np.concatenate((quiet, samples, quiet)))
    say(line, kind="rest")
    return hear(line, "transcript", seconds=40, true=lambda told: told["final"])


def clip(folder: Path, name: str) -> Array:
    return at_16_khz(read_sound(folder / "speech_commands_tts" / name)).samples[:, 0]


def newest_deed(live: Live) -> Any:
    """The newest command that was said into the browser: the robot may still hear what was said in its room."""
    entries = live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"]
    return next(one for one in entries if one["source"] != "ears")


@pytest.mark.real_data
def test_a_command_that_is_said_runs_like_one_that_is_typed(live: Live, line: Connection, shared_data: Path) -> None:
    with live.open():  # the page's control socket
        said = held(line, clip(shared_data, "flite_slt_00.flac"))
    assert said["heard_as"] == "turn left"
    entry = newest_deed(live)
    assert (entry["source"], entry["name"]) == ("voice", "turn_left")
    if said["accepted"]:  # the delay is by this computer's clock; a simulator's waits for the reader
        assert said["reason"] == "" and entry["id"] == said["entry"]
    else:  # this machine is too slow to read words in time: nothing moves
        assert (
            said["delay_s"] > MAX_OBEYED_AGE_S - 1.0 and "too late" in said["reason"] and entry["state"] == "refused"
        )


@pytest.mark.real_data
def test_a_viewer_may_say_stop_and_nothing_else(live: Live, shared_data: Path) -> None:
    with live.open("/ws/audio", token=live.viewer) as line:
        said = held(line, clip(shared_data, "flite_slt_00.flac"))
        assert not said["accepted"] and "operator" in said["reason"]
        assert newest_deed(live)["state"] == "refused"
        stopped = held(line, clip(shared_data, "flite_slt_02.flac"))
        assert stopped["accepted"] and stopped["heard_as"] == "stop moving"


def test_noise_moves_nothing(live: Live, line: Connection) -> None:
    said = held(line, 0.1 * np.random.default_rng(1).normal(size=AUDIO_RATE_HZ))
    assert not said["accepted"] and said["reason"]


def test_one_at_a_time_speaks_to_the_robot(live: Live, line: Connection) -> None:
    with live.open("/ws/audio") as other:
        say(line, kind="listen", mode="open")
        assert hear(line, "listening")["on"]
        say(other, kind="listen", mode="held")
        told = hear(other, "listening")
        assert not told["on"] and "Someone else" in told["why"]
    say(line, kind="rest")
    assert not hear(line, "listening")["on"]


@pytest.mark.parametrize(
    ("message", "code"),
    [
        (b"\x02", 1009),
        (b"\x02" + bytes(15 + 9000), 1009),
        (AUDIO_HEADER.pack(1, 0, 0.0) + bytes(640), 1007),
        (AUDIO_HEADER.pack(AUDIO_KIND, 0, float("nan")) + bytes(640), 1007),
        ("nonsense", 1007),
        (json.dumps({"kind": "listen", "mode": "always"}), 1007),
    ],
)
def test_what_is_no_sound_ends_the_socket_with_a_reason(live: Live, message: bytes | str, code: int) -> None:
    with live.open("/ws/audio") as line:
        line.send(message)
        with pytest.raises(ConnectionClosed) as closed:
            line.recv(timeout=5)
        assert closed.value.rcvd is not None and closed.value.rcvd.code == code and closed.value.rcvd.reason


def test_who_signs_out_is_hung_up_on_without_another_message(live: Live, line: Connection) -> None:
    [(person, _)] = live.on_loop(lambda: list(live.runtime.sockets._open.values()))
    live.on_loop(lambda: live.runtime.sockets.close_of(person, 4001, "You signed out."))
    with pytest.raises(ConnectionClosed) as ended:
        while True:
            line.recv(timeout=60)
    assert ended.value.rcvd is not None and ended.value.rcvd.code == 4001


def test_a_flood_ends_the_socket(live: Live, line: Connection, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.api.audio_socket.MOST_PER_SECOND", 20)  # a busy computer takes no more in a second
    with pytest.raises(ConnectionClosed):
        for number in range(400):
            line.send(AUDIO_HEADER.pack(AUDIO_KIND, number, 20.0 * number) + bytes(640))
        line.recv(timeout=5)
