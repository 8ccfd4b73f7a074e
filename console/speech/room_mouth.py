"""A browser's microphone at the mouth of a person in the simulated room.

What is said into it sounds there: it reaches the robot through the room's air, its microphones, its direction finder
and its recognizer, as the words of a person before a real robot do.
"""

import asyncio
import math
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from console.messages.audio import AUDIO_RATE_HZ
from console.speech.room_transcription import RoomTranscriber
from console.speech.voice_commands import ROOM, VoiceCommands
from core.errors import BeckonError, Refused
from core.message import Array
from core.robots import requests

NEAREST = "nearest"  # the speaker: the nearest person whom no wall hides
PIECE_BYTES = 4096  # of sound that are handed on at once, 0.13 s
MAX_REQUEST_BYTES = 64_000  # of one request to the driver
SILENCE = bytes(320)  # 10 ms: begins and ends a turn
NOBODY = "Nobody stands in the simulated room in whose voice you could speak. Choose another voice at the microphone."
HEARD_OUT_TIME_S = 2.0  # of the room's sound after the words, robot's clock, with which they have been read
MAX_TURN_WORDS_S = 60.0  # after the button was released in which words are still this turn's, at most
LOOK_PERIOD_S = 0.1  # between looks how far the room's sound is read


class RoomMouth:
    """One turn to speak, from the press until its words were heard. Lives on the event loop."""

    def __init__(
        self,
        wanted: str,
        ask: requests.Ask,
        transcriber: RoomTranscriber,
        voice_commands: VoiceCommands,
        trouble: Callable[[str], None],
    ) -> None:
        """`wanted`: who speaks, or NEAREST; `trouble`: called with a sentence when they cannot, with "" when all that
        was said has been read.
        """
        self.over = False  # the button was released
        self._wanted, self._ask, self._trouble = wanted, ask, trouble
        self._transcriber, self._voice_commands = transcriber, voice_commands
        self._waiting = bytearray(SILENCE)  # at once, so that the room's echo is known when words come
        self._news = asyncio.Event()
        self._news.set()
        self._hushed = False
        self._ended = math.inf  # [s] when the button was released
        self._task = asyncio.get_running_loop().create_task(self._speak())
        voice_commands.at_console = True

    @property
    def awaits_words(self) -> bool:
        """Return whether words that are heard now may be those of this turn."""
        return time.monotonic() < self._ended + MAX_TURN_WORDS_S

    def add(self, samples: Array) -> None:
        """Sound (N,) of full scale ±1."""
        if not self.over:
            self._waiting += np.round(np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes()
            if len(self._waiting) >= PIECE_BYTES:
                self._news.set()

    def rest(self) -> None:
        """The button was released; what was said before still sounds."""
        if not self.over:
            self.over, self._ended = True, time.monotonic()
            self._news.set()

    def hush(self) -> None:
        """Stopped: nothing that was said before sounds any more."""
        self._hushed = True
        self.close()

    def close(self) -> None:
        """The turn is over, and nothing of it is awaited."""
        self.rest()
        self._ended = -math.inf
        self._voice_commands.speaker = ROOM
        self._voice_commands.at_console = False

    async def _speak(self) -> None:
        try:
            name = await speaker_in_room(self._ask, self._wanted)
            if self._ended > -math.inf and (who := self._voice_commands.operator) is not None:
                self._voice_commands.speaker = replace(who, name=f"{who.name}, through {name}'s mouth")
            await self._ask(requests.SetListening(on=True))
            while True:
                await self._news.wait()
                self._news.clear()
                if self._hushed:
                    await self._ask(requests.Hush(id=name))
                    return
                sound, self._waiting = bytes(self._waiting[:MAX_REQUEST_BYTES]), self._waiting[MAX_REQUEST_BYTES:]
                over = self.over and not self._waiting
                said = await self._ask(
                    requests.Speak(id=name, pcm=sound or SILENCE, rate_hz=AUDIO_RATE_HZ, more=not over)
                )
                if over:
                    await self._read_out(self._transcriber.stamp + said.seconds)
                    return
                if self._waiting:
                    self._news.set()
        except BeckonError as refusal:
            if self._ended > -math.inf:
                self._trouble(str(refusal))

    async def _read_out(self, end: float) -> None:
        """Wait until the room's sound is read up to well after the words, which end at `end` [s], robot's clock."""
        while (
            self.awaits_words and self._transcriber.read_to < end + HEARD_OUT_TIME_S and not self._transcriber.trouble
        ):
            await asyncio.sleep(LOOK_PERIOD_S)
        if self._ended > -math.inf:
            self._trouble("")


async def speaker_in_room(ask: requests.Ask, wanted: str) -> str:
    """The person of that name, or the nearest. Raises Refused where there is nobody, Unavailable."""
    plan, truth = await ask(requests.ReadPlan()), await ask(requests.ReadTruth())
    people = [thing for thing in plan.things if isinstance(thing, requests.PlacedThing) and thing.what == "person"]
    near = sorted(
        people, key=lambda one: (hidden(plan, truth, one), math.hypot(one.x_m - truth.x_m, one.y_m - truth.y_m))
    )
    found = next((one for one in near if wanted in (one.id, NEAREST)), None)
    if found is None:
        raise Refused(NOBODY)
    return found.id


def hidden(plan: requests.FloorPlan, robot: requests.GroundTruth, person: requests.PlacedThing) -> bool:
    """Return whether a wall stands between the robot and a person."""
    here, there = (robot.x_m, robot.y_m), (person.x_m, person.y_m)
    reach = max(person.length_m, person.depth_m)  # the laser's walls hold the legs of the person, too
    for x0, y0, x1, y1 in (segment[:4] for segment in plan.segments):
        if min(math.dist(there, (x0, y0)), math.dist(there, (x1, y1))) > reach and _cross(
            here, there, (x0, y0), (x1, y1)
        ):
            return True
    return False


def _cross(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], d: tuple[float, float]) -> bool:
    def side(p: tuple[float, float], q: tuple[float, float], r: tuple[float, float]) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
