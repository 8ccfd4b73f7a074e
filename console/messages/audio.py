"""The socket `/ws/audio`: sound of a browser's microphone up, recognized words down."""

import struct
from typing import Literal

import msgspec

Struct = msgspec.Struct

AUDIO_HEADER = struct.Struct("<B3xId")  # kind 2, number of the piece, milliseconds of the browser's clock
AUDIO_KIND = 2
AUDIO_RATE_HZ = 16_000
MOST_BYTES = 8192  # of one message

ListenMode = Literal["held", "open"]


class AudioMessage(Struct, tag_field="kind", forbid_unknown_fields=True):
    """Base of what a browser may say here."""


class Listen(AudioMessage, tag="listen"):
    """Speech follows: until `rest` (the button is held), or cut into utterances by its silences (open).

    `seen`: `seq` of the newest state that the page has (0: none), which dates the sound that is sent next.
    `speaker`, in the simulator: the sound comes from the mouth of this person in the room, "nearest" for the nearest
    one in sight; "", or nobody there: it comes from no place in the room.
    """

    mode: ListenMode
    seen: int = 0
    speaker: str = ""


class Rest(AudioMessage, tag="rest"):
    """The button was let go, or the microphone closed."""


AudioUp = Listen | Rest


class ListeningMessage(Struct, tag_field="kind", tag="listening"):
    """`on`: words are read now; otherwise the reason why not."""

    on: bool
    why: str = ""


class Transcript(Struct, tag_field="kind", tag="transcript"):
    """Words that were heard, and what came of them."""

    id: int
    words: str  # "" where nothing was understood
    final: bool  # false: a STOP before the sentence was over
    accepted: bool
    heard_as: str  # the command as it was understood, with its numbers; "" when refused
    reason: str  # a sentence; "" when accepted
    suggestions: list[str]
    confidence: float  # 0 to 1 that the words are right
    seconds: float  # of speech
    delay_s: float  # from the end of the sound that it needed to this message
    entry: int | None = None  # its row in the history
    pending_command: int | None = None  # it waits: `pending_command` of the state has it
    code: str | None = None  # of the sentence in `reason`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


class PartialTranscript(Struct, tag_field="kind", tag="partial"):
    """The words so far of a sentence under way; they mean nothing yet."""

    words: str


class AllRead(Struct, tag_field="kind", tag="read"):
    """All that was said in a turn has been read: no words of it come any more."""


AudioDown = ListeningMessage | PartialTranscript | Transcript | AllRead
