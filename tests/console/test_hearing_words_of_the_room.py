"""What the robot's own ears put into the history of what voices in the room said."""

import asyncio
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from console.control.command_freshness import CommandFreshness, RobotTime, Spoken
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.pending_commands import PendingCommands
from console.speech.room_transcription import RoomTranscriber
from console.speech.voice_commands import ROOM, VoiceCommands
from core.gate import Twist
from core.sensors.microphones import RESPEAKER_ODAS, Sound
from core.speech.recognition.decision import RecognizedUtterance
from tests.core.speech.ears import sure

NOTHING, STOP, TURN = (
    RecognizedUtterance(begin=0.0, end=0.0, decision=sure(words)) for words in ("", "stop", "turn left")
)


class Reads:
    """A worker that hears what it is told to, one utterance with every piece of sound."""

    def __init__(self) -> None:
        self.utterances: list[RecognizedUtterance] = []

    async def begun(self) -> bool:
        return True

    async def feed(self, samples: Any, rate: int, stamp: float) -> list[RecognizedUtterance]:
        return [replace(self.utterances.pop(0), begin=stamp, end=stamp + 0.2)]


def new_transcriber(dispatcher: Any, history: History) -> RoomTranscriber:
    """The transcriber of the robot's ears, whose words nobody has taken on."""
    lease, notifications = Lease(), Notifications()
    dispatcher.when_cancelled = []
    pending_commands = PendingCommands(dispatcher, lease, history, notifications)
    voice_commands = VoiceCommands(dispatcher, lease, pending_commands, history, notifications)
    return RoomTranscriber(voice_commands, pending_commands, dispatcher, notifications)


def hear(
    utterances: list[RecognizedUtterance],
    stamps: list[float],
    transcriber: RoomTranscriber,
    worker: Reads,
    *,
    moving: bool = False,
) -> None:
    """One utterance with each piece of sound, at these times [s] of the robot's clock."""
    worker.utterances = list(utterances)

    async def listen() -> None:
        for number, stamp in enumerate(stamps):
            sound = Sound(stamp=stamp, rate=16_000, samples=np.zeros((3200, 4)))
            snapshot: Any = SimpleNamespace(stamp=stamp, hearing=None, velocity=Twist(0.2 if moving else 0.0, 0.0))
            transcriber.feed(snapshot, sound, RESPEAKER_ODAS)
            while len(worker.utterances) > len(stamps) - 1 - number:
                await asyncio.sleep(0)
            await asyncio.sleep(0.01)

    asyncio.run(listen())


def test_stop_is_obeyed_when_the_robot_was_started_anew_and_its_clock_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker, stops = Reads(), list[str]()
    monkeypatch.setattr("console.speech.room_transcription.TranscriptionClient", lambda: worker)
    words = SimpleNamespace(stopped_by=lambda _: None, time=RobotTime())
    dispatcher = SimpleNamespace(stop=lambda who, source: stops.append(source), freshness=words)
    transcriber = new_transcriber(dispatcher, History(tmp_path, lambda _: None))
    told = list[str]()
    transcriber.when_heard.append(
        lambda outcome, voice: told.append(f"{outcome.heard}: {outcome.utterance.decision.words}")
    )
    hear([STOP, STOP, STOP, TURN], [100.0, 100.2, 1.0, 3.0], transcriber, worker)
    assert stops == ["ears", "ears"]  # the second is the same word's, heard again
    assert told == ["stop: stop", "stopped: stop", "stop: stop", "words: turn left"]


def test_words_that_were_read_while_the_robot_started_anew_are_of_before_and_hold_no_later_stop_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Slow(Reads):
        async def feed(self, samples: Any, rate: int, stamp: float) -> list[RecognizedUtterance]:
            words = await super().feed(samples, rate, stamp)
            if stamp > 50.0:
                snapshot: Any = SimpleNamespace(stamp=1.0, hearing=None, velocity=Twist(0.0, 0.0))
                transcriber.feed(snapshot, None, None)
            return words

    worker, stops = Slow(), list[str]()
    monkeypatch.setattr("console.speech.room_transcription.TranscriptionClient", lambda: worker)
    words = SimpleNamespace(stopped_by=lambda _: None, time=RobotTime())
    dispatcher = SimpleNamespace(stop=lambda who, source: stops.append(source), freshness=words)
    transcriber = new_transcriber(dispatcher, History(tmp_path, lambda _: None))
    said: list[Spoken] = []
    transcriber.when_heard.append(lambda outcome, voice: said.append(outcome.said))
    hear([STOP, TURN], [100.0, 2.0], transcriber, worker)
    assert stops == ["ears"] and transcriber.read_to == pytest.approx(2.2)
    hear([STOP], [3.0], transcriber, worker)
    assert stops == ["ears", "ears"]
    assert said[0].ended == transcriber._time.former_end < said[1].ended
    transcriber._hear(replace(TURN, begin=99.0, end=100.0))  # over with the first sound of the new clock
    assert said[-1].ended == transcriber._time.former_end


def test_talk_on_and_on_stands_in_the_history_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = Reads()
    monkeypatch.setattr("console.speech.room_transcription.TranscriptionClient", lambda: worker)
    history = History(tmp_path, lambda _: None)
    transcriber = new_transcriber(SimpleNamespace(freshness=CommandFreshness(Lease())), history)
    history.open()
    hear([NOTHING, NOTHING, NOTHING, TURN, NOTHING, NOTHING], [0.2 * n for n in range(6)], transcriber, worker)
    told = [entry.words for entry in reversed(history.newest_first(commands_only=True))]
    assert told == ["", "turn left", ""]
    history.add("command", ROOM, words="stop")
    hear([NOTHING, NOTHING], [2.0, 2.2], transcriber, worker)
    told = [entry.words for entry in reversed(history.newest_first(commands_only=True))]
    assert told == ["", "turn left", "", "stop", ""]  # what came between parts them
    history.add("command", ROOM, words="continue")
    hear([NOTHING, NOTHING], [3.0, 3.2], transcriber, worker, moving=True)
    assert history.newest_first(commands_only=True)[0].words == "continue"  # those are the robot's own motors
    history.close()
    assert len(transcriber.utterances) == 10


@pytest.mark.parametrize("broken", [np.nan, np.inf, 1e300])
def test_a_piece_that_is_no_numbers_is_a_gap_and_not_the_end_of_all_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, broken: float
) -> None:
    worker, stops = Reads(), list[str]()
    monkeypatch.setattr("console.speech.room_transcription.TranscriptionClient", lambda: worker)
    words = CommandFreshness(Lease())
    dispatcher = SimpleNamespace(stop=lambda who, source: stops.append(source), freshness=words)
    transcriber = new_transcriber(dispatcher, History(tmp_path, lambda _: None))
    piece = Sound(stamp=1.0, rate=16_000, samples=np.full((3200, 4), broken))
    snapshot: Any = SimpleNamespace(stamp=1.0, hearing=None, velocity=Twist(0.0, 0.0))
    transcriber.feed(snapshot, piece, RESPEAKER_ODAS)
    assert transcriber.trouble == ""
    hear([STOP], [1.2], transcriber, worker)
    assert stops == ["ears"]


def test_words_are_as_old_as_their_sound_whenever_the_console_takes_it(tmp_path: Path) -> None:
    """Sensed at 1000 s of our clock, taken by the console ten seconds late."""
    transcriber = new_transcriber(
        SimpleNamespace(freshness=CommandFreshness(Lease())), History(tmp_path, lambda _: None)
    )
    came: list[Spoken] = []
    transcriber.when_heard.append(lambda outcome, voice: came.append(outcome.said))
    for stamp in (4.0, 5.0, 6.0):
        snapshot: Any = SimpleNamespace(stamp=stamp, hearing=None, velocity=Twist(0.0, 0.0))
        transcriber.feed(snapshot, None, None, 1000.0 + 1.5 * (stamp - 5.0))  # the robot's clock is slow
    transcriber._hear(replace(TURN, begin=4.2, end=4.8))
    transcriber._hear(replace(TURN, begin=7.0, end=7.5))  # after all that is known of its clock
    said, late = came
    assert (said.began, said.ended) == pytest.approx((999.2, 999.8))
    assert late.ended == 1001.5
