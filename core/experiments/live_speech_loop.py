"""The loop of Figs. 10 and 11 with a real loudspeaker and a real microphone, in the room where they stand.

The text is spoken by synthetic voices. The person's path is that sound itself (orig.wav); the robot's is what its
microphone makes of it after the loudspeaker and the room (rev.wav). A recognizer of any words reads both, and eq.
41-46 compare them.
"""

from collections.abc import Callable, Sequence

import numpy as np

from core.errors import BadInput, Unavailable
from core.experiments.speech_loop import RATE_HZ, LoopResult, SpokenTrack, lag_of, run_loop, track_of
from core.experiments.speech_quality import TEXT, spoken
from core.message import Array
from core.speech.quality.word_alignment import phrases_of
from core.speech.recognition.engines import open_free_dictation
from core.speech.settings import SpeechSettings
from core.speech.synthesis import NO_VOICE, can_speak

RECORD_AFTER_S = 1.5  # of recording after the last word
PLAYED_PEAK = 0.7  # of full scale, that is played
MOST_PHRASES = 60
MIN_RMS = 1e-4  # RMS of full scale: what is fainter is no recording

Air = Callable[[Array], Array]
"""Plays a sound (N,) at RATE → what was recorded meanwhile (M,) at RATE."""


class LiveSpeechLoop:
    """One text and the sound of it."""

    def __init__(self, text: str = "", *, seed: int = 0) -> None:
        """`text`: phrases that end at a line's end or a semicolon; "": commands. Raises BadInput, Unavailable."""
        if not can_speak():
            raise Unavailable(NO_VOICE)
        phrases: Sequence[str] = [" ".join(words) for words in phrases_of(text)] if text else TEXT
        if not 1 <= len(phrases) <= MOST_PHRASES:
            raise BadInput(f"The text has {len(phrases)} phrases; 1 to {MOST_PHRASES} can be spoken.")
        self._dictation = open_free_dictation(SpeechSettings())
        said = spoken(np.random.default_rng(seed), phrases)
        track = track_of(phrases, [one.dry for one in said])
        loudest = float(np.abs(track.samples).max())
        self.track = SpokenTrack(
            phrases=track.phrases, samples=PLAYED_PEAK / loudest * track.samples, begins=track.begins
        )

    @property
    def played(self) -> Array:
        """The sound that is played, (N,) at RATE, with the silence in which the last echo dies away."""
        return np.concatenate((self.track.samples, np.zeros(round(RECORD_AFTER_S * RATE_HZ))))

    def through(self, air: Air) -> LoopResult:
        """Play and record it → both texts, compared. Raises BadInput where nothing was recorded."""
        return self.compared(air(self.played))

    def compared(self, recorded: Array) -> LoopResult:
        """Take a recording (M,) at RATE of the sound while it was played → both texts, compared. Raises BadInput."""
        if len(recorded) < RATE_HZ or not float(np.sqrt(np.mean(recorded**2))) > MIN_RMS:
            raise BadInput(
                "The microphone recorded next to nothing. Check that it and the loudspeaker are on and not muted."
            )
        return run_loop(self._dictation, self.track, self.track.samples, recorded, lag_of(self.track, recorded))
