"""Voice activity detection (VAD): frames in which enough of the spectrum stands out of the noise."""

from collections import deque
from typing import Literal

import numpy as np

from core.message import Array
from core.perception.sound.settings import DirectionFindingSettings

Change = Literal["", "begins", "ends"]
RECENT_FRAMES = 5  # frames among which the onset is sought


def active_share(power: Array, settings: DirectionFindingSettings) -> Array:
    """Power over noise (K, T) → share of the bins that stand out, (T,)."""
    return np.mean(power > settings.evidence, axis=0)


class VoiceActivityDetector:
    """Tells begin and end of utterances, frame by frame."""

    def __init__(self, settings: DirectionFindingSettings) -> None:
        self._settings = settings
        self._recent: deque[tuple[float, bool]] = deque(maxlen=RECENT_FRAMES)
        self.last_active = 0.0
        self.begin: float | None = None  # [s] of the present utterance; None: silence

    def step(self, share: float, time: float) -> Change:
        """One frame at `time` [s] → what it changes."""
        active = share > self._settings.active_share
        self._recent.append((time, active))
        if active:
            self.last_active = time
        if self.begin is None:
            actives = [when for when, was in self._recent if was]
            if len(actives) < self._settings.onset_frames:
                return ""
            self.begin = actives[0]
            return "begins"
        if time - self.last_active < self._settings.hangover:
            return ""
        self.begin = None
        self._recent.clear()
        return "ends"
