"""What a worker sends is not trusted."""

import math
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from console.speech.transcription_client import received
from console.speech.transcription_worker import ReadUtterance, TranscriptionWorker
from console.workers.job import LENGTH, JobResult, answer_decoder, packed
from core.commands.command import Command
from core.sentences import code_of
from core.speech.recognition.decision import Decision, RecognizedUtterance
from tests.core.speech.ears import confirming, sure, unsure


def packed_answer(decision: Decision) -> bytes:
    """As it goes into the pipe."""
    utterance = RecognizedUtterance(begin=1.0, end=2.5, decision=decision)
    return packed(JobResult([ReadUtterance(utterance, code_of(decision.reason))]))[LENGTH.size :]


def sent(decision: Decision) -> list[ReadUtterance]:
    """As it comes out of the pipe."""
    answer = answer_decoder(TranscriptionWorker.hear).decode(packed_answer(decision))
    assert isinstance(answer, JobResult)
    return answer.result


@pytest.mark.parametrize("made", [sure, confirming, unsure])
def test_a_decision_crosses_the_border_whole(made: Any) -> None:
    given = made("continue two meters")
    (one,) = received(sent(given))
    assert (one.begin, one.end, one.final) == (1.0, 2.5, True)
    fields = ("verdict", "confidence", "words", "reason", "offered", "did_you_mean", "echo")
    assert [getattr(one.decision, name) for name in fields] == [getattr(given, name) for name in fields]
    assert code_of(one.decision.reason) == code_of(given.reason)


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        (Command(name="continue", numbers={"distance_m": 12.0}, heard_as="continue 12 meters"), "by voice"),
        (Command(name="continue", numbers={"distance_m": math.inf}, heard_as="continue"), "not finite"),
        (Command(name="levitate", numbers={}, heard_as="levitate"), "no such command"),
    ],
)
def test_a_command_beyond_the_bounds_of_speech_is_rejected_with_the_reason(command: Command, reason: str) -> None:
    (one,) = received(sent(Decision(verdict="accept", command=command, words="what was said")))
    assert (one.decision.verdict, one.decision.command) == ("reject", None)
    assert reason in one.decision.reason and one.decision.words == "what was said"


def test_a_rejection_brings_no_command_along() -> None:
    command = sure("turn left").command
    (one,) = received(sent(replace(unsure("turn left"), command=command)))
    assert one.decision.command is None


def test_an_answer_of_another_form_is_refused() -> None:
    answer = msgspec.msgpack.decode(packed_answer(sure("turn left")))
    answer["result"][0]["utterance"]["decision"]["verdict"] = "obey"
    with pytest.raises(msgspec.ValidationError):
        answer_decoder(TranscriptionWorker.hear).decode(msgspec.msgpack.encode(answer))
