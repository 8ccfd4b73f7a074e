"""The utterances that the transcription worker sends. It is not trusted: bounds are checked again."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from core.speech.recognition.decision import Decision, RecognizedUtterance
from core.speech.understanding.grammar import Refusal, command_of


def received(utterances: Iterable[RecognizedUtterance]) -> list[RecognizedUtterance]:
    """A worker's utterances as the console takes them: none asks for more than speech may."""
    return [replace(one, decision=within_bounds(one.decision)) for one in utterances]


def within_bounds(decision: Decision) -> Decision:
    """The decision with its command built again within the bounds of speech, or the rejection of that command."""
    given = decision.command
    if given is None or decision.verdict == "reject":
        return replace(decision, verdict="reject", command=None)
    command = command_of(given.name, given.numbers, spoken=True)
    if isinstance(command, Refusal):
        return Decision(
            verdict="reject", words=decision.words, reason=command.reason, suggestions=command.suggestions
        )
    return replace(decision, command=command)
