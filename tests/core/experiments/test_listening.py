"""Ears in an experiment: what is said is known when the reading of it is over, not before."""

from collections.abc import Callable

import numpy as np
import pytest

from core.errors import BadInput
from core.experiments.spoken_room import NOISE_BEFORE_S, TimedListening, length_of_words
from core.sensors import SensorFrame
from core.sensors.microphones import Sound
from core.speech.recognition.decision import RecognizedUtterance, stop
from core.speech.settings import MAX_WAITING_S

RATE = 16_000


class Slow:
    """A recognizer that takes half a second for everything, and hears STOP in it."""

    def __init__(self, clock: list[float]) -> None:
        self.fed: list[tuple[float, float]] = []
        self._clock = clock

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        self.fed.append((round(sound.stamp, 3), round(sound.duration, 3)))
        self._clock[0] += 0.5
        return (RecognizedUtterance(begin=sound.stamp, end=sound.stamp + sound.duration, decision=stop()),)

    def finish(self) -> tuple[RecognizedUtterance, ...]:
        return ()


@pytest.fixture
def passing(monkeypatch: pytest.MonkeyPatch) -> tuple[TimedListening, Slow, Callable[..., tuple[float, ...]]]:
    """Ears, their recognizer, and what lets a frame of 0.1 s pass → ends of what is known then."""
    clock = [0.0]
    monkeypatch.setattr("core.experiments.spoken_room.time.process_time", lambda: clock[0])
    slow = Slow(clock)
    ears = TimedListening(slow)

    def frame(now: float, speaking: bool = False) -> tuple[float, ...]:
        sound = Sound(stamp=now - 0.1, rate=RATE, samples=np.zeros((RATE // 10, 1)))
        ears.keep(SensorFrame(stamp=now, sound=sound))
        return tuple(round(one.end, 3) for one in ears.heard(now, speaking))

    return ears, slow, frame


def test_words_are_known_when_they_have_been_read_and_sound_waits_meanwhile(passing) -> None:
    ears, slow, frame = passing
    known = {now: told for n in range(1, 15) if (told := frame(now := round(0.1 * n, 3)))}
    assert known == {0.7: (0.2,), 1.2: (0.7,)}
    assert slow.fed == [(0.0, 0.2), (0.2, 0.5), (0.7, 0.5)]
    assert ears.reading(0.0, 1.0) == pytest.approx(0.8)
    assert ears.reading(0.3, 0.5) == pytest.approx(0.2)


def test_while_someone_speaks_and_shortly_after_less_sound_waits(passing) -> None:
    _, slow, frame = passing
    for n in range(1, 40):
        frame(round(0.1 * n, 3), speaking=n == 1)
    assert slow.fed[:2] == [(0.0, 0.1), (0.1, 0.5)]
    assert min(length for _, length in slow.fed[2:]) >= 0.2


def test_what_waited_long_is_forgotten_when_someone_begins_to_listen(passing) -> None:
    ears, slow, frame = passing
    for n in range(1, 31):
        ears.keep(
            SensorFrame(stamp=0.1 * n, sound=Sound(stamp=0.1 * n - 0.1, rate=RATE, samples=np.zeros((1600, 1))))
        )
    ears.begin()
    frame(3.1)
    assert slow.fed == [(3.0 - NOISE_BEFORE_S, NOISE_BEFORE_S + 0.1)]
    assert ears.reading(0.0, 9.0) == pytest.approx(0.5)
    assert MAX_WAITING_S > NOISE_BEFORE_S


def test_words_end_where_the_sound_is_loud_last() -> None:
    samples = np.zeros(RATE, "<i2")
    samples[2000:8000] = 1000
    samples[8000:] = 10
    assert length_of_words(samples.tobytes(), RATE) == pytest.approx(0.5)
    assert length_of_words(samples.tobytes(), 2 * RATE) == pytest.approx(0.25)
    with pytest.raises(BadInput, match="nothing to be heard"):
        length_of_words(bytes(2 * RATE), RATE)
