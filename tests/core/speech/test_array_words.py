"""Words from an array: what the engine is given to read."""

from functools import cache

import numpy as np
import pytest

from core.errors import BadInput
from core.sensors.microphones import RESPEAKER_ODAS, Sound
from core.speech.recognition.decision import Decision
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber
from tests.core.perception.voices import far_voice
from tests.core.speech.ears import sure


@pytest.fixture(autouse=True)
def without_spotters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody looks for STOP: it takes as long as the sound lasts, and here only what the engine reads counts."""
    monkeypatch.setattr("core.speech.transcription.transcriber.open_keyword_spotter", lambda *_: Silent())
    monkeypatch.setattr("core.speech.transcription.array_transcriber.has_sphinx", lambda: False)


class Silent:
    """A spotter that finds nothing."""

    def feed(self, sound: Sound) -> tuple[()]:
        return ()


class Scribe:
    """An engine that writes down what it was given."""

    def __init__(self) -> None:
        self.given: list[Utterance] = []

    def decide(self, utterance: Utterance) -> Decision:
        self.given.append(utterance)
        return sure("")


@cache
def spoken(ratio: float, seconds: float = 1.2) -> Sound:
    """A voice from 1.0 rad, with half a second of noise before and a second behind."""
    voice = far_voice(RESPEAKER_ODAS, 1.0, 0.2, ratio=ratio, duration=seconds, stamp=20.0)
    noise = far_voice(RESPEAKER_ODAS, 1.0, ratio=ratio, duration=1.5, seed=5).samples[: RATE_HZ // 2]
    return Sound(stamp=20.0, rate=RATE_HZ, samples=np.concatenate((noise, voice.samples, noise[::-1], noise)))


def pieces(sound: Sound) -> list[Sound]:
    count = round(sound.duration / 0.02)
    return [sound.part(sound.stamp + 0.02 * n, sound.stamp + 0.02 * (n + 1)) for n in range(count)]


def test_the_beam_has_less_noise_than_one_microphone_and_the_same_bounds():
    one, many = Scribe(), Scribe()
    single, whole = Transcriber(recognizer=one), ArrayTranscriber(RESPEAKER_ODAS, recognizer=many)
    for piece in pieces(spoken(15.0)):
        single.feed(Sound(stamp=piece.stamp, rate=RATE_HZ, samples=piece.samples[:, :1]))
        whole.feed(piece)
    alone, beamed = one.given[-1], many.given[-3]  # the others are read in other ways
    assert (alone.begin, alone.end) == (beamed.begin, beamed.end)
    assert len(alone.samples) == pytest.approx(len(beamed.samples), abs=2)

    def clarity(utterance: Utterance) -> float:
        return float(utterance.samples.std() / utterance.before[: RATE_HZ // 4].std())

    assert clarity(beamed) > 1.3 * clarity(alone)


@pytest.mark.parametrize(
    ("seconds", "read", "understood"),
    [
        (1.2, ("", "", "come here"), "come here"),
        (1.2, ("", "stop"), "stop"),
        (1.2, ("", "start", ""), ""),  # single words have to be understood every time
        (1.2, ("come here",), "come here"),
        (2.4, ("", "come here"), "come here"),
        pytest.param(1.2, ("", "come here"), "come here", marks=pytest.mark.campaign),
        pytest.param(1.2, ("", "", ""), "", marks=pytest.mark.campaign),
        pytest.param(2.4, ("", ""), "", marks=pytest.mark.campaign),
    ],
)
def test_a_sentence_that_is_not_understood_is_read_in_other_ways(seconds, read, understood):
    class Reader(Scribe):
        """Reads its sentences in turn of each piece of sound, which is read in its pause and may be at its end."""

        def decide(self, utterance: Utterance) -> Decision:
            super().decide(utterance)
            again = [one.end for one in self.given].count(utterance.end)
            return sure(read[(again - 1) % len(read)])

    reader = Reader()
    ears = ArrayTranscriber(RESPEAKER_ODAS, recognizer=reader)
    told = [one for piece in pieces(spoken(15.0, seconds)) for one in ears.feed(piece)]
    told += ears.finish()
    assert told[-1].decision.words == understood
    given = [one for one in reader.given if one.end == reader.given[-1].end]
    assert len(given) in (len(read), 2 * len(read))
    ways = given[-len(read) :]
    assert len({one.before.std() for one in ways}) == len(ways)
    if len(read) == 3:  # the last is the plain beam, with more of the noise before the words
        assert ways[2].before.std() > 1.05 * ways[0].before.std()


class Asked:
    """Listens to the beam for STOP, and keeps until when [s] it was asked."""

    def __init__(self) -> None:
        self.until: list[float] = []

    def wants(self, since: float, now: float) -> bool:
        return True

    def find(self, beam: Sound, since: float) -> tuple[()]:
        self.until.append(beam.stamp + beam.duration)
        return ()


@pytest.mark.campaign
def test_a_long_piece_of_sound_is_searched_for_stop_as_short_ones_are():
    """Sound waits while words are read; a sentence may end in what has come meanwhile."""
    at_once, little_by_little = (ArrayTranscriber(RESPEAKER_ODAS, recognizer=Scribe()) for _ in range(2))
    sound, asked = spoken(15.0), (Asked(), Asked())
    at_once._stop_in_noise, little_by_little._stop_in_noise = asked
    at_once.feed(sound)
    for piece in sound.pieces(0.05):
        little_by_little.feed(piece)
    assert len(asked[0].until) > 10
    assert asked[0].until == pytest.approx(asked[1].until)


def test_sound_that_does_not_fit_the_array_is_refused():
    ears = ArrayTranscriber(RESPEAKER_ODAS, recognizer=Scribe())
    with pytest.raises(BadInput, match="channel"):
        ears.feed(Sound(stamp=0.0, rate=RATE_HZ, samples=np.zeros((320, 1))))
    with pytest.raises(BadInput, match="16000 Hz"):
        ears.feed(Sound(stamp=0.0, rate=48_000, samples=np.zeros((960, 4))))
