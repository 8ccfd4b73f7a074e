"""Speech recognition in an experiment: it takes the time that it needs on this machine, while the room goes on.

As in the console, sound that comes while a piece is being read waits, and is read with the next one.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

from core.sensors import SensorFrame
from core.sensors.microphones import Sound, joined
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.recognizer import StreamingRecognizer
from core.speech.settings import MOST_WAITING
from core.speech.transcription.piece_length import PieceLength

BEFORE = 1.0  # [s] of sound before listening starts that are read too: the noise before the words is known


class TimedListening:
    """Neither the robot nor the room is known here: a room that is left goes at once, with all that it heard."""

    def __init__(self, recognizer: StreamingRecognizer) -> None:
        self._recognizer = recognizer
        self._waiting: Sound | None = None
        self._piece = PieceLength()
        self._pending: Sequence[RecognizedUtterance] = ()  # what will be known at the end of the newest reading
        self._readings: list[tuple[float, float]] = []  # [s] robot's clock, from when to when

    def keep(self, frame: SensorFrame) -> None:
        """The sound of one frame; ears are never shut."""
        if frame.sound is not None:
            self._waiting = joined(self._waiting, frame.sound, MOST_WAITING)

    def begin(self) -> None:
        """Listen from now on; what was heard long before is forgotten."""
        sound, self._readings, self._pending = self._waiting, self._readings[-1:], ()
        if sound is not None:
            now = sound.stamp + sound.duration
            self._waiting = sound.part(now - BEFORE, now)

    def heard(self, now: float, speaking: bool) -> tuple[RecognizedUtterance, ...]:
        """Return the words that became known by `now` [s]; call it once for every frame.

        `speaking`: the robot hears a voice.
        """
        self._piece.follow(now, speaking)
        if self._readings and now < self._readings[-1][1]:
            return ()
        known, self._pending = self._pending, ()
        sound = self._waiting
        if sound is not None and sound.duration >= self._piece.seconds:
            self._waiting, begun = None, time.process_time()
            self._pending = self._recognizer.feed(sound)
            self._readings.append((now, now + time.process_time() - begun))
        return tuple(known)

    def reading(self, begin: float, end: float) -> float:
        """Time [s] that recognition was busy between two moments [s] since `begin`."""
        return sum(max(min(end, until) - max(begin, since), 0.0) for since, until in self._readings)
