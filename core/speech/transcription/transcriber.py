"""Decisions about sound as it comes: endpoints cut it, an engine decides about each utterance, STOP comes early."""

import re
from collections.abc import Iterable
from dataclasses import replace

from core.commands.stop_moving import START
from core.sensors.microphones import Sound
from core.speech.recognition.decision import Decision, RecognizedUtterance
from core.speech.recognition.endpointing import Endpointer, Held
from core.speech.recognition.engines import open_engine, open_keyword_spotter
from core.speech.recognition.recognizer import KeywordSpotter, Recognizer, Utterance
from core.speech.settings import SpeechSettings
from core.speech.understanding.numbers import NUMBER

LOOK_PIECE_S = 0.05  # of sound between two looks for a pause
LAST_NUMBER = re.compile(rf"(?i: {NUMBER}\W*)$")  # at the end of a sentence: decimals may follow
MAX_EARLY_S = 5.0  # of an utterance that is read in a pause; longer ones are no commands but talk


OBJECTION_TIME_S = 5.0  # after a sentence in which a STOP rejects it: it is read, said back, and waits meanwhile
REJECTION_MEMORY_S = 30.0  # after that


class RejectedCommands:
    """Observes every understood command: a person who speaks again most likely did not mean what was heard before.

    What a recognizer mishears it often mishears again, from the same place by the same voice. The STOP that follows
    or Cancel adds what the sound lacks: such a negative confirmation makes the same reading less likely.
    """

    def __init__(self) -> None:
        self._newest: RecognizedUtterance | None = None  # the newest command, while it is pending
        self._stopped: dict[str, float] = {}  # rejected words, and when [s]

    def hear(self, heard: RecognizedUtterance) -> None:
        """Note what was decided."""
        if heard.decision.command is None:
            return
        if not heard.decision.stops:
            self._newest = heard if heard.decision.waits else None
        elif self._newest is not None:
            if 0 <= heard.end - self._newest.end < OBJECTION_TIME_S:
                self._stopped[self._newest.decision.words] = heard.end
            self._newest = None

    def reject(self, words: str, now: float) -> None:
        """Note that a pending command was rejected by Cancel or by a button."""
        self._stopped[words] = now

    def words(self, now: float) -> tuple[str, ...]:
        """The sentences that were rejected not long before `now` [s], where an utterance began."""
        self._stopped = {words: then for words, then in self._stopped.items() if abs(now - then) < REJECTION_MEMORY_S}
        return tuple(words for words, then in self._stopped.items() if then <= now)


class Transcriber:
    """The streaming recognizer of this project, for any engine."""

    def __init__(
        self,
        settings: SpeechSettings | None = None,
        *,
        held: bool = False,
        recognizer: Recognizer | None = None,
        spotter: KeywordSpotter | None = None,
        rejected: RejectedCommands | None = None,
    ) -> None:
        """`held`: hold-to-talk, so the sound between two calls of `finish` is one utterance; else endpoints are
        sought. One recognizer may serve several transcribers in turn, and what one heard `rejected` the next may
        know. Raises Unavailable with a sentence.
        """
        chosen = settings or SpeechSettings()
        self._settings = chosen
        self._recognizer = recognizer or open_engine(chosen).recognizer
        self._spotter = spotter or open_keyword_spotter(chosen, self._recognizer)
        self._cutter = Held(chosen) if held else Endpointer(chosen)
        self._early: RecognizedUtterance | None = None
        self._rejected = RejectedCommands() if rejected is None else rejected

    @property
    def speaking_since(self) -> float | None:
        """Begin [s] of the utterance under way; None: there is none."""
        return self._cutter.speaking_since

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound → STOP at once, and the sentences that ended in it, as they were spoken: a long
        piece may hold a sentence and a STOP after it, which must not be overtaken. Raises BadInput.
        """
        heard = list(self._spotter.feed(sound))
        for piece in sound.pieces(LOOK_PIECE_S):
            heard += self._read(self._cutter.feed(piece))
            heard += self._read_early()
        return self._remembered(sorted(heard, key=lambda one: one.end))

    def _read_early(self) -> tuple[RecognizedUtterance, ...]:
        """Read the utterance under way in its pause → STOP, where that was in it."""
        so_far = self._cutter.so_far
        if so_far is None or self._is_early(so_far) or so_far.end - so_far.begin >= MAX_EARLY_S:
            return ()
        self._early = self._decided(so_far)
        if isinstance(self._cutter, Endpointer):
            self._cutter.hangover = self._hangover(self._early.decision)
        return (replace(self._early, final=False),) if self._early.decision.stops else ()

    def _hangover(self, decision: Decision) -> float:
        """The silence [s] that ends an utterance of which this is the decision so far."""
        if not _is_whole(decision):
            return self._settings.unfinished_hangover
        return self._settings.complete_hangover if _is_complete(decision) else self._settings.hangover

    def finish(self) -> tuple[RecognizedUtterance, ...]:
        """The sound ends here → the sentence that was under way."""
        return self._remembered(self._read(self._cutter.finish()))

    def words_so_far(self) -> str:
        """Return the utterance under way as a command, else in any words that the engine writes down; "": nothing."""
        utterance = self._cutter.under_way
        if utterance is None:
            return ""
        decision = self._decided(utterance).decision
        return decision.words or decision.heard

    def _remembered(self, heard: Iterable[RecognizedUtterance]) -> tuple[RecognizedUtterance, ...]:
        """Remember what was heard, for later rejections, and return it."""
        utterances = tuple(heard)
        for one in utterances:
            self._rejected.hear(one)
        return utterances

    def _read(self, utterances: tuple[Utterance, ...]) -> tuple[RecognizedUtterance, ...]:
        """Utterances that ended → what was said in them, as read in their last pause where that was a command."""
        early = self._early
        return tuple(
            early if early is not None and _is_whole(early.decision) and self._is_early(one) else self._decided(one)
            for one in utterances
        )

    def _decided(self, utterance: Utterance) -> RecognizedUtterance:
        known = replace(utterance, rejected=self._rejected.words(utterance.begin))
        return RecognizedUtterance(begin=utterance.begin, end=utterance.end, decision=self._recognizer.decide(known))

    def _is_early(self, utterance: Utterance) -> bool:
        """Return whether the utterance was read in its last pause, and nothing was said since."""
        return self._early is not None and (self._early.begin, self._early.end) == (utterance.begin, utterance.end)


def _is_whole(decision: Decision) -> bool:
    """Return whether words are a whole command. "Stop at two" stops, but may go on; "start" may be a half "stop"."""
    return decision.command is not None and not decision.command.remark and decision.command.name != START.name


def _is_complete(decision: Decision) -> bool:
    """Return whether nothing can follow: "stop" may go on with a place, and a number with its decimals."""
    return not decision.stops and LAST_NUMBER.search(decision.words) is None
