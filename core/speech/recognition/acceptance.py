"""The decision about heard words: execute them whole or refuse them with a reason. Numbers are repeated."""

from __future__ import annotations

from core.commands.command import Command
from core.commands.stop_moving import START, STOP_MOVING
from core.message import message
from core.speech.recognition.recognizer import WordHypothesis
from core.speech.understanding.grammar import STOP_WORD, Refusal, understand

NO_COMMAND = "Somebody spoke, but that was no command."
UNFINISHED = "The sentence is not over yet."


@message
class RecognizedUtterance:
    """One utterance and what became of it."""

    begin: float  # [s]
    end: float  # [s]
    words: str  # as they were heard; "" where nothing was understood
    command: Command | None  # None: refused
    final: bool = True  # False: STOP, heard before the sentence was over
    reason: str = ""  # a sentence: why it was refused
    suggestions: tuple[str, ...] = ()
    suggested_command: str = ""  # the command that the words would be, had they been heard without a doubt
    uncertain: bool = False  # a number of the command may be another: it waits a moment, whatever it is

    @property
    def accepted(self) -> bool:
        """True when the robot acts on it."""
        return self.command is not None

    @property
    def echo(self) -> str:
        """The spoken reply: the command with its numbers, or the reason."""
        return self.command.heard_as if self.command is not None else self.reason


def judge(hypothesis: WordHypothesis) -> RecognizedUtterance:
    """Words that were heard → a command or a refusal. Only STOP gets through before the end, or in spite of doubt."""
    command, reason, suggestions = _verdict(hypothesis)
    suggested_command = _doubted(hypothesis) if command is None else ""
    return RecognizedUtterance(
        begin=hypothesis.begin,
        end=hypothesis.end,
        words=hypothesis.words,
        command=command,
        final=hypothesis.final,
        reason=reason,
        suggestions=(suggested_command,) if suggested_command else suggestions,
        suggested_command=suggested_command,
        uncertain=command is not None and hypothesis.uncertain,
    )


def _verdict(hypothesis: WordHypothesis) -> tuple[Command | None, str, tuple[str, ...]]:
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


def _doubted(hypothesis: WordHypothesis) -> str:
    """The command that was perhaps said: offered, never executed by itself; "" when it is not a command."""
    if not (hypothesis.final and hypothesis.doubt and hypothesis.words):
        return ""
    read = understand(hypothesis.words, spoken=True)
    return read.heard_as if isinstance(read, Command) and read.name != START.name else ""


def _stop(remark: str) -> Command:
    return Command(name=STOP_MOVING.name, numbers={}, heard_as=STOP_MOVING.words[0], remark=remark)
