"""The decision about one utterance: carry it out, confirm it first, or reject it. All engines make it in `decide`.

An engine gives the sentence that fits best and three numbers: how well it fits, by how much better than free text,
and by how much better than the nearest other command. What is confirmed waits for the confirmation delay; what is
rejected moves nothing, and its alternatives are offered ("Did you mean …?"). Numbers are repeated.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Literal

from core.commands import has_said_numbers, needs_confirmation, spec_of
from core.commands.command import Command
from core.commands.routes import PAUSE_ROUTE
from core.commands.stop_moving import START, STOP_MOVING
from core.message import message
from core.sentences import Statement
from core.speech.understanding.grammar import OwnPhrases, Refusal, parse, says_stop

Verdict = Literal["accept", "confirm", "reject"]

MOST_OFFERED = 2  # commands instead of words that are none
NO_COMMAND = Statement("words.no_command")
NOT_SURE = "I am not sure that I heard every word right."
MORE_SAID = "More may have been said than these words."
TOO_LONG = "That was longer than any command."
NO_WHOLE_NUMBER = "I did not hear the whole number."
MORE_DIGITS = "I may have missed a part of the numbers."
TOO_MANY_DECIMALS = "Spoken numbers have one point, and two digits behind it at most."
OBJECTIONS = {
    NOT_SURE: Statement("words.not_sure"),
    MORE_SAID: Statement("words.more_said"),
    TOO_LONG: Statement("words.longer"),
    NO_WHOLE_NUMBER: Statement("words.not_whole_number"),
    MORE_DIGITS: Statement("words.more_digits"),
    TOO_MANY_DECIMALS: Statement("words.too_many_decimals"),
}  # against words, and how each is said with them


@message
class Decision:
    """The command of an utterance, and whether the robot may do it."""

    verdict: Verdict
    command: Command | None = None  # None exactly where it is rejected
    confidence: float = 0.0  # 0 to 1 that the words are right; calibrated for the numbers that Whisper hears
    alternatives: tuple[Command, ...] = ()  # that may have been said instead, the likeliest first; never carried out
    words: str = ""  # as they were heard; "" where no command was
    reason: str = ""  # a sentence: why it is rejected
    suggestions: tuple[str, ...] = ()  # words that the grammar would understand instead of rejected ones
    heard: str = ""  # what was said instead of a command, in any words, where the engine writes that down
    said: tuple[float, float] | None = None  # [s] sound's clock: from when to when, where others talked besides

    @property
    def waits(self) -> bool:
        """True where the command is said back and waits for the confirmation delay: uncertain words, a far way, and
        every number and name, because no voice is so sure that it is never another. What moves nothing never does.
        """
        if self.command is None or not spec_of(self.command.name).moves:
            return False
        particular = has_said_numbers(self.command) or self.command.place != ""
        return self.verdict == "confirm" or particular or needs_confirmation(self.command)

    @property
    def stops(self) -> bool:
        """True where the robot stops, whatever it does: "pause" is no less a STOP where there are routes."""
        return self.command is not None and self.command.name in (STOP_MOVING.name, PAUSE_ROUTE.name)

    @property
    def echo(self) -> str:
        """The spoken reply: the command with its numbers, or the reason."""
        return self.command.heard_as if self.command is not None else self.reason

    @property
    def offered(self) -> tuple[str, ...]:
        """The commands, in words, that a rejected utterance most likely was, the likeliest first."""
        return tuple(one.heard_as for one in self.alternatives[:MOST_OFFERED]) if self.command is None else ()

    @property
    def did_you_mean(self) -> tuple[str, ...]:
        """Words to offer where it is rejected: what may have been said, else what would be understood."""
        if self.command is not None:
            return ()
        return tuple(one.heard_as for one in self.alternatives) or self.suggestions


def said_back(decision: Decision, own: OwnPhrases = ()) -> Decision:
    """The decision about words that were surely meant for the robot: those that are no command are said back too.

    `own`: phrases that are understood beside the vocabulary.
    """
    if decision.words or not decision.heard:
        return decision
    read = Sentence(decision.heard, own).spoken
    offered = read.suggestions if isinstance(read, Refusal) else (read.heard_as,)
    suggestions = offered[:MOST_OFFERED]
    return replace(decision, words=decision.heard, reason=not_a_command(decision.heard), suggestions=suggestions)


def not_a_command(heard: str) -> str:
    """Say words back, in a sentence."""
    return Statement("words.heard_no_command", words=heard.rstrip(" .,!?"))


@message
class RecognizedUtterance:
    """One utterance and the decision about it."""

    begin: float  # [s] of the speech, on its sound's clock
    end: float  # [s]
    decision: Decision
    final: bool = True  # False: STOP, heard before the sentence was over

    @property
    def said(self) -> tuple[float, float]:
        """From when to when [s] its words were said; others may have talked in the utterance."""
        return self.decision.said or (self.begin, self.end)


class Sentence:
    """Words as an engine wrote them down, and what they mean: parsed here, and nowhere behind it."""

    def __init__(self, words: str, own: OwnPhrases = ()) -> None:
        self.words = words
        parsed = parse(words, own)
        self.spoken = parsed.bounded(spoken=True)  # the command within the bounds of speech, or why it is none
        self.typed = parsed.bounded(spoken=False)  # the same within those of typed words

    @property
    def meaning(self) -> tuple[str, tuple[tuple[str, float], ...]]:
        """The command's name and numbers, equal for "meter" and "meters"; the words, where they are no command."""
        command = self.typed
        return (self.words, ()) if isinstance(command, Refusal) else (command.name, tuple(command.numbers.items()))


@message
class Scores:
    """How well a sentence fits the sound. Margins are log-likelihood ratios; ∞ where the engine knows no rival."""

    sentence: float  # [nats] as the engine counts
    over_free_text: float = math.inf  # [nats] by which it fits better than the best free text
    over_second_best: float = math.inf  # [nats] by which it fits better than the nearest other command


@message
class Thresholds:
    """From which margins an engine's sentences are believed."""

    reject: float  # [nats] over the second best, below which the words are rejected
    accept: float  # [nats] over the second best, above which the command is carried out; between them it is confirmed
    scale: float = 1.0  # [nats] of a margin that make the odds e times better: frames of sound are not independent


def decide(
    sentence: Sentence,
    scores: Scores,
    thresholds: Thresholds,
    *,
    objection: str = "",
    others: Iterable[Sentence] = (),
) -> Decision:
    """Decide about the sentence that fits best.

    `objection`: a sentence, why these words must not move the robot however well they fit; "": none. `others`: the
    sentences that fit nearly as well, the best first. Only STOP gets through in spite of an objection.
    """
    words = sentence.words
    confidence = _logistic(min(scores.over_free_text, scores.over_second_best) / thresholds.scale)
    if not words or scores.over_free_text <= 0:
        return no_command(confidence if words else 0.0)
    if not objection and scores.over_second_best < thresholds.reject:
        objection = NOT_SURE
    if objection:
        return _rejected(sentence, confidence, objection, others)
    read = sentence.spoken
    if isinstance(read, Refusal):
        return Decision(
            verdict="reject", confidence=confidence, words=words, reason=read.reason, suggestions=read.suggestions
        )
    return Decision(
        verdict="accept" if scores.over_second_best > thresholds.accept else "confirm",
        command=read,
        confidence=confidence,
        alternatives=_commands(others),
        words=words,
    )


def no_command(confidence: float = 0.0) -> Decision:
    """Reject speech that is no sentence of the grammar; `confidence` in the one that fits best."""
    return Decision(verdict="reject", confidence=confidence, reason=NO_COMMAND)


def stop(words: str = "stop", *, confidence: float = 1.0, remark: str = "") -> Decision:
    """STOP, whatever else was said; `remark`: a sentence for the operator."""
    command = Command(name=STOP_MOVING.name, numbers={}, heard_as=STOP_MOVING.words[0], remark=remark)
    return Decision(verdict="accept", command=command, confidence=confidence, words=words)


def _rejected(sentence: Sentence, confidence: float, objection: str, others: Iterable[Sentence]) -> Decision:
    if says_stop(sentence.words):
        return stop(sentence.words, confidence=confidence, remark=objection)
    return Decision(
        verdict="reject",
        confidence=confidence,
        alternatives=_commands((sentence, *others)),
        words=sentence.words,
        reason=OBJECTIONS[objection](words=sentence.words),
    )


def _commands(sentences: Iterable[Sentence]) -> tuple[Command, ...]:
    """Those of the sentences that are commands within the bounds of speech, but for START: it changes nothing."""
    read = (sentence.spoken for sentence in sentences)
    return tuple(one for one in read if isinstance(one, Command) and one.name != START.name)


def log_odds(probability: float) -> float:
    """A probability from 0 to 1 → [nats]."""
    if not 0.0 < probability < 1.0:
        return math.inf if probability >= 1.0 else -math.inf
    return math.log(probability / (1.0 - probability))


def _logistic(logit: float) -> float:
    return 0.5 + 0.5 * math.tanh(logit / 2)
