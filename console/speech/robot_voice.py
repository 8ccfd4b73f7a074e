"""The robot's voice: what it says aloud, and how long nobody is listened to because of it.

A browser plays the voice. While it does, and a moment longer, the robot's ears and microphones left open hear
nothing: otherwise the robot would take its own words for a command.
"""

import asyncio
import time
from collections.abc import Callable

from console.part import Part
from core.errors import Refused
from core.sensors.microphones import Sound
from core.settings import Settings
from core.speech.synthesis import VoiceSettings, speak

TAIL_S = 0.3  # after the last word: the room still sounds, and sound is on its way
MAX_PLAY_DELAY_S = 1.0  # that a browser may take until it plays
MAX_WAITING_S = 20.0  # that may be waiting to be said: nobody talks the robot deaf for longer
MAX_WORDS_MOVING_S = 6.0  # the same while it moves: no spoken STOP is heard meanwhile


class RobotVoice(Part):
    """Speaks, and knows until when it is heard. `deaf` and `muted` may be asked from any thread."""

    def __init__(
        self,
        speaker: Callable[[str, VoiceSettings], Sound] = speak,
        clock: Callable[[], float] = time.monotonic,
        settings: VoiceSettings | None = None,
    ) -> None:
        self.settings = settings or VoiceSettings()
        self._speaker, self._clock = speaker, clock
        self._until: dict[int, float] = {}  # [s] until when each utterance is heard
        self._end = 0.0  # [s] until when any is
        self._room = 0.0  # [s] of the robot's clock: until then it is heard in the simulated room
        self._newest = 0

    def adopt(self, settings: Settings) -> None:
        self.settings = settings.voice

    @property
    def muted(self) -> bool:
        """True while microphones left open are not listened to."""
        return self._clock() < self._end

    def deaf(self, stamp: float) -> bool:
        """Return whether sound that the robot heard up to `stamp` [s] of its own clock is not listened to."""
        return self.muted or stamp < self._room

    async def say(self, text: str, most: float = MAX_WAITING_S) -> tuple[int, Sound]:
        """A text → its number and how it sounds; from now on nobody is listened to until it is over, `most` [s].

        Raises BadInput, Refused, and Unavailable where nothing speaks.
        """
        sound = await asyncio.to_thread(self._speaker, text, self.settings)
        now = self._clock()
        end = now + MAX_PLAY_DELAY_S + sound.duration + TAIL_S
        if end > now + most:
            moving = " while the robot moves: no spoken STOP would be heard meanwhile" if most < MAX_WAITING_S else ""
            raise Refused(f"That takes longer than {most:g} s to say{moving}; say less at once.")
        self._newest += 1
        self._until[self._newest] = end
        self._settle(now)
        return self._newest, sound

    def hush(self, number: int) -> None:
        """The browser has played it, or broke it off."""
        now = self._clock()
        if number in self._until:
            self._until[number] = min(self._until[number], now + TAIL_S)
            self._settle(now)

    def in_room(self, until: float) -> None:
        """The simulated room hears it until `until` [s] of the robot's clock."""
        self._room = max(self._room, until + TAIL_S)

    def _settle(self, now: float) -> None:
        self._until = {number: until for number, until in self._until.items() if until > now}
        self._end = max(self._until.values(), default=0.0)
