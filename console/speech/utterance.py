"""The message between the transcription worker and the console: an utterance and the decision about it."""

from __future__ import annotations

import msgspec

from core.commands.command import Command
from core.speech.recognition.acceptance import RecognizedUtterance
from core.speech.understanding.grammar import Refusal, command_of


class UtteranceMessage(msgspec.Struct, frozen=True):
    """An utterance; times [s] are those of its sound's clock. The worker is not trusted: bounds are checked again."""

    begin: float
    end: float
    words: str
    final: bool = True
    name: str | None = None  # of the command; None: refused
    numbers: dict[str, float] = {}
    heard_as: str = ""
    reason: str = ""
    suggestions: tuple[str, ...] = ()
    suggested_command: str = ""
    uncertain: bool = False  # a number may have been another

    @property
    def command(self) -> Command | Refusal:
        """The command within the bounds of speech, or why there is none."""
        return Refusal(self.reason) if self.name is None else command_of(self.name, self.numbers, spoken=True)


def utterance_message(said: RecognizedUtterance) -> UtteranceMessage:
    """Build the message of an utterance."""
    command = said.command
    return UtteranceMessage(
        begin=said.begin,
        end=said.end,
        words=said.words,
        final=said.final,
        name=None if command is None else command.name,
        numbers={} if command is None else dict(command.numbers),
        heard_as="" if command is None else command.heard_as,
        reason=said.reason,
        suggestions=said.suggestions,
        suggested_command=said.suggested_command,
        uncertain=said.uncertain,
    )
