"""What is done about words that were heard: obeyed whole, or refused with a reason. Numbers are said back."""

from __future__ import annotations

from core.commands.command import Command
from core.commands.stand import START, STOP_MOVING
from core.message import message
from core.speech.grammar import STOP_WORD, Refusal, understand
from core.speech.recognizer import Hypothesis

NO_COMMAND = "Somebody spoke, but that was no command."
UNFINISHED = "The sentence is not over yet."


@message
class Spoken:
    """One utterance and what became of it."""

    begin: float  # [s]
    end: float  # [s]
    words: str  # as they were heard; "" where nothing was understood
    command: Command | None  # None: refused
    final: bool = True  # False: STOP, heard before the sentence was over
    reason: str = ""  # a sentence: why it was refused
    suggestions: tuple[str, ...] = ()
    meant: str = ""  # the command that the words would be, had they been heard without a doubt
    unsure: bool = False  # a number of the command may be another: it waits a moment, whatever it is

    @property
    def accepted(self) -> bool:
        """Whether the robot does something about it."""
        return self.command is not None

    @property
    def echo(self) -> str:
        """What is said back: the command with its numbers, or the reason."""
        return self.command.heard_as if self.command is not None else self.reason


def judge(hypothesis: Hypothesis) -> Spoken:
    """Words that were heard → a command or a refusal. Only STOP gets through before the end, or in spite of doubt."""
    command, reason, suggestions = _verdict(hypothesis)
    meant = _doubted(hypothesis) if command is None else ""
    return Spoken(
        begin=hypothesis.begin,
        end=hypothesis.end,
        words=hypothesis.words,
        command=command,
        final=hypothesis.final,
        reason=reason,
        suggestions=(meant,) if meant else suggestions,
        meant=meant,
        unsure=command is not None and hypothesis.unsure,
    )


def _verdict(hypothesis: Hypothesis) -> tuple[Command | None, str, tuple[str, ...]]:
    sure = hypothesis.final and not hypothesis.doubt
    if sure and not hypothesis.words:
        return None, NO_COMMAND, ()
    if sure:
        read = understand(hypothesis.words, spoken=True)
        return (None, read.reason, read.suggestions) if isinstance(read, Refusal) else (read, "", ())
    why = hypothesis.doubt or UNFINISHED
    if STOP_WORD.search(hypothesis.words.lower()):
        return _stop(why if hypothesis.doubt else ""), "", ()
    heard = f" I heard “{hypothesis.words}”; say it again." if hypothesis.words and hypothesis.doubt else ""
    return None, why + heard, ()


def _doubted(hypothesis: Hypothesis) -> str:
    """What was perhaps said, to be offered and never obeyed by itself; "" where that is no command."""
    if not (hypothesis.final and hypothesis.doubt and hypothesis.words):
        return ""
    read = understand(hypothesis.words, spoken=True)
    return read.heard_as if isinstance(read, Command) and read.name != START.name else ""


def _stop(remark: str) -> Command:
    return Command(name=STOP_MOVING.name, numbers={}, heard_as=STOP_MOVING.words[0], remark=remark)
