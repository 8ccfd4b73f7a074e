"""Seconds of the robot's sound, recorded on purpose; in the simulated room a person speaks meanwhile."""

import asyncio
import math

import numpy as np

from core.errors import BadInput, BeckonError, Refused, Unavailable
from core.robots.requests import Ask, ReadTruth, SetListening, Speak
from core.sensors.microphones import Sound, joined
from core.sensors.resampling import resampled
from core.speech.practice_voice import practice_voice
from core.speech.synthesis import VoiceSettings, speak

RECORDING_TIMEOUT_S = 20.0  # by the clock for a recording of any length
RATE_HZ = 16_000  # of speech in the simulated room
TRIED_DISTANCES_M = (1.5, 1.2, 0.9, 2.0, 0.6)  # that are tried
WORDS = "Here I am, here."
NAME = "demo"


class MicrophoneRecorder:
    """Lives on the event loop. One recording at a time."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._sound: Sound | None = None
        self._seconds = 0.0  # that are wanted; 0: nobody records
        self._news = asyncio.Event()

    def took(self, sound: Sound | None) -> None:
        """Take the sound of the robot's newest frame."""
        if sound is not None and self._seconds:
            self._sound = joined(self._sound, sound, self._seconds)
            self._news.set()

    async def record(self, seconds: float, listening: bool, say_from: float | None = None) -> Sound:
        """So many seconds [s] without a gap. `listening`: it listens already, and goes on listening afterwards.

        `say_from`: the azimuth [rad] from the simulated robot from which someone speaks meanwhile. Raises Refused
        while another recording is made, and Unavailable when no sound comes.
        """
        if self._seconds:
            raise Refused("A recording is being made already; wait a moment.")
        self._sound, self._seconds = None, seconds
        try:
            await self._ask(SetListening(on=True))
            if say_from is not None:
                await self._say(say_from)
            async with asyncio.timeout(RECORDING_TIMEOUT_S + seconds):
                while self._sound is None or self._sound.duration < seconds - 0.5 / self._sound.rate:
                    self._news.clear()
                    await self._news.wait()
            return self._sound
        except TimeoutError:
            raise Unavailable("No sound comes from the robot's microphones; are they connected?") from None
        finally:
            self._seconds = 0.0
            if not listening:
                await self._ask(SetListening(on=False))

    async def _say(self, azimuth: float) -> None:
        """Let a person speak from there, as far away as the room allows."""
        robot = await self._ask(ReadTruth())
        samples = await asyncio.to_thread(words)
        angle = robot.heading_rad + azimuth
        trouble: BeckonError = BadInput("Nobody can speak from there: the robot stands too close to the walls.")
        for distance in TRIED_DISTANCES_M:
            x, y = robot.x_m + distance * math.cos(angle), robot.y_m + distance * math.sin(angle)
            try:
                await self._ask(Speak(pcm=samples, x_m=x, y_m=y))
                return
            except BadInput as blocked:
                trouble = blocked
        raise trouble


def words() -> bytes:
    """Return a word of the demo: 16-bit samples at RATE; without text to speech a made-up voice."""
    try:
        sound = speak(WORDS, VoiceSettings())
        samples = resampled(sound.samples[:, 0], sound.rate, RATE_HZ)
    except Unavailable:
        samples = practice_voice(np.random.default_rng(0), 1.5, RATE_HZ)
    level = np.clip(0.3 * samples / np.abs(samples).max(), -1, 1)
    return np.round(32767 * level).astype("<i2").tobytes()
