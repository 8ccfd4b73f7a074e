"""The robot's microphones: listening, and the newest utterances."""

import msgspec

from console.access.roles import needs
from console.api import Behind, RequestBody, Who, router
from console.calibration.microphones import MicrophoneCalibration
from console.http.problems import Problem
from console.speech.room_transcription import RoomTranscriber, RoomUtterance
from console.speech.voice_commands import VoiceCommands
from core.robots.requests import SetListening

hearing = router("hearing", 404, 409, 503)


class Listening(msgspec.Struct, frozen=True, kw_only=True):
    """State of listening, and of obeying voices in the room."""

    listening: bool
    obeying: bool


class NewestHearing(Listening, frozen=True, kw_only=True):
    """The newest utterances near the robot, and what reads words."""

    microphones: bool
    trouble: str  # why words are not read; "": they are
    engine: str  # which engine reads words, and why; "": none has begun
    utterances: list[RoomUtterance]  # newest first


class ListeningRequest(RequestBody):
    """`listen`: the robot listens; `obey`: it also obeys voices in the room, which only who drives may ask."""

    listen: bool
    obey: bool | None = None


@hearing.get("/hearing")
@needs("viewer")
async def newest(behind: Behind) -> NewestHearing:
    """The newest utterances near the robot, newest first, which engine reads words, or why none does."""
    hearing_state = behind.snapshot.hearing if behind.snapshot is not None else None
    return NewestHearing(
        microphones=hearing_state is not None,
        listening=hearing_state is not None and hearing_state.listening,
        obeying=behind.parts[VoiceCommands].operator is not None,
        trouble=behind.parts[RoomTranscriber].trouble,
        engine=behind.parts[RoomTranscriber].engine,
        utterances=behind.parts[RoomTranscriber].shown(),
    )


@hearing.post("/hearing")
@needs("operator")
async def listen(asked: ListeningRequest, behind: Behind, who: Who) -> Listening:
    """Let the robot listen, or not. It listens by itself for a minute after a person in the simulated room spoke."""
    if behind.robot.profile.microphones is None:
        raise Problem(404, "This robot has no microphones.")
    if not asked.listen:
        behind.lease.check_not_anothers(who)
    if asked.obey is True and asked.listen:
        behind.parts[VoiceCommands].take_on(who)
    elif asked.obey is False or not asked.listen:
        behind.parts[VoiceCommands].release()
    behind.parts[MicrophoneCalibration].listening = asked.listen
    answer = await behind.ask(SetListening(on=asked.listen))
    behind.history.add("listen", who, words="on" if asked.listen else "off")
    return Listening(listening=answer.on, obeying=behind.parts[VoiceCommands].operator is not None)
