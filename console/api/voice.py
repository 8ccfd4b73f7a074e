"""The robot's voice: answers spoken aloud in the browser that asks for them."""

import contextlib
from typing import Annotated

import msgspec
from msgspec.structs import replace
from pydantic import Field

from console.access.roles import needs
from console.api import Behind, Operator, RequestBody, part, router
from console.api.simulation import speak_in_pieces
from console.runtime import Runtime
from console.speech.robot_voice import MAX_WAITING_S, MAX_WORDS_MOVING_S, RobotVoice
from core.errors import BeckonError
from core.robots.requests import ReadTruth, Speak
from core.sensors.microphones import Sound
from core.speech.synthesis import pcm

MAX_CHARACTERS = 300  # characters
LOUDSPEAKER_ABOVE_M = 0.35  # of the simulated robot's loudspeaker above its microphones
NAME = "robot"
ECHO_LAG_S = 1.5  # until the simulated room has worked out its first echo

voice = router("voice", 409, 503)
SpokenAnswers = Annotated[RobotVoice, part(RobotVoice)]


class SpeechRequest(RequestBody):
    """The text to say."""

    text: str = Field(min_length=1, max_length=MAX_CHARACTERS)


class PlayedRequest(RequestBody):
    """Which utterance was played to its end, or broken off."""

    id: int = Field(ge=0, le=2**53)


class SpokenAnswer(msgspec.Struct, frozen=True):
    """The sound of a text."""

    id: int
    seconds: float
    rate_hz: int
    pcm: bytes  # 16-bit samples of one channel


class VoiceState(msgspec.Struct, frozen=True):
    """State of muting: nobody is listened to while the robot speaks."""

    muted: bool


@voice.post("/voice")
@needs("operator")
async def say(asked: SpeechRequest, behind: Behind, voice: SpokenAnswers, _: Operator) -> SpokenAnswer:
    """A text → 16-bit samples of one channel in base64, to be played at once; meanwhile nobody is listened to.

    While someone drives, only the operator in control makes the robot speak: it hears no STOP meanwhile.
    """
    moves = behind.snapshot is not None and behind.snapshot.active_command is not None
    number, sound = await voice.say(asked.text, MAX_WORDS_MOVING_S if moves else MAX_WAITING_S)
    await in_room(behind, sound)
    return SpokenAnswer(number, round(sound.duration, 3), sound.rate, pcm(sound))


@voice.post("/voice/hush")
@needs("operator")
async def hush(asked: PlayedRequest, voice: SpokenAnswers) -> VoiceState:
    """It was said: listening goes on in a moment."""
    voice.hush(asked.id)
    return VoiceState(voice.muted)


async def in_room(behind: Runtime, sound: Sound) -> None:
    """A simulated robot that listens is heard in its room as well, and does not take its own words for a command."""
    snapshot, array = behind.snapshot, behind.robot.profile.microphones
    heard = snapshot.hearing if snapshot is not None else None
    if (
        not behind.robot.profile.simulated
        or array is None
        or snapshot is None
        or heard is None
        or not heard.listening
    ):
        return
    behind.parts[RobotVoice].in_room(snapshot.stamp + ECHO_LAG_S + sound.duration)
    with contextlib.suppress(BeckonError):  # no room for a loudspeaker, or too many talk: only the browser is heard
        here = await behind.ask(ReadTruth())
        place = Speak(id=NAME, x_m=here.x_m, y_m=here.y_m, z_m=array.height + LOUDSPEAKER_ABOVE_M)
        await speak_in_pieces(behind.ask, replace(place, pcm=pcm(sound), rate_hz=sound.rate))
