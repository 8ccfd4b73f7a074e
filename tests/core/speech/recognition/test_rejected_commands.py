"""What was held back when it was heard is less likely when it is heard again."""

from collections.abc import Callable

import numpy as np
import pytest

from core.speech.practice_voice import practice_voice
from core.speech.recognition.decision import Decision, RecognizedUtterance
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ
from core.speech.transcription.transcriber import OBJECTION_TIME_S, REJECTION_MEMORY_S, RejectedCommands, Transcriber
from tests.core.speech.ears import confirming, listened, padded, sure, unsure

GO = "stop at two and one"  # waits a moment, however surely it was heard


def heard(
    words: str, end: float, *, final: bool = True, decided: Callable[[str], Decision] = sure
) -> RecognizedUtterance:
    return RecognizedUtterance(begin=end - 1.0, end=end, decision=decided(words), final=final)


def after(*told: RecognizedUtterance) -> RejectedCommands:
    memory = RejectedCommands()
    for one in told:
        memory.hear(one)
    return memory


def test_a_stop_soon_after_an_order_holds_it_back_for_a_while():
    memory = after(heard(GO, 10.0), heard("stop", 13.0, final=False), heard("stop moving", 13.3))
    assert memory.words(14.0) == (GO,)
    assert memory.words(13.0 + REJECTION_MEMORY_S - 0.1) == (GO,)
    assert memory.words(13.0 + REJECTION_MEMORY_S) == ()


def test_what_is_held_back_twice_is_remembered_with_what_was_heard_instead():
    other = "continue three meters"
    memory = after(heard(GO, 10.0), heard("stop", 12.0), heard(other, 15.0, decided=confirming), heard("stop", 17.0))
    assert set(memory.words(20.0)) == {GO, other}


@pytest.mark.parametrize(
    "told",
    [
        (heard(GO, 10.0), heard("stop", 10.0 + OBJECTION_TIME_S)),  # it was under way already
        (heard(GO, 10.0, decided=unsure), heard("stop", 12.0)),  # it was not obeyed
        (heard("turn right", 10.0), heard("stop", 12.0)),  # it began at once: that ended it
        (heard(GO, 8.0), heard("turn left", 10.0), heard("stop", 12.0)),
        (heard(GO, 10.0), heard("nonsense", 11.0)),
        (heard("stop", 10.0), heard("stop", 11.0)),
        (heard("stop", 9.0), heard(GO, 10.0)),
    ],
)
def test_nothing_else_holds_an_order_back(told):
    assert after(*told).words(12.0) == ()


def test_an_utterance_that_is_read_again_after_its_stop_forgets_nothing():
    """STOP is heard in a pause, and the sentence goes on: it began before that."""
    memory = after(heard(GO, 10.0), heard("stop", 12.0))
    assert memory.words(11.5) == ()
    assert memory.words(13.0) == (GO,)


def test_another_clock_forgets():
    memory = after(heard(GO, 1000.0), heard("stop", 1002.0))
    assert memory.words(3.0) == ()


class Reader:
    """Reads its sentences, one in each utterance, and keeps what it was told of each."""

    def __init__(self, *sentences: str) -> None:
        self.sentences, self.told, self.begun = list(sentences), [], None

    def decide(self, utterance: Utterance) -> Decision:
        if utterance.begin != self.begun:  # else it was read in a pause already
            self.begun = utterance.begin
            self.told.append(utterance.rejected)
        return sure(self.sentences[len(self.told) - 1])


def test_who_reads_words_is_told_what_was_held_back_just_before():
    pytest.importorskip("pocketsphinx", reason="Reading words needs pocketsphinx: pip install pocketsphinx")
    reader = Reader(GO, "stop moving", GO)
    said = padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ))
    told = listened(Transcriber(recognizer=reader), np.concatenate((said, said, said)))
    assert [one.decision.words for one in told if one.final] == [GO, "stop moving", GO]
    assert reader.told == [(), (), (GO,)]


def test_what_is_held_back_otherwise_is_remembered_too():
    memory = after(heard(GO, 10.0))
    memory.reject(GO, 11.0)
    assert memory.words(11.0 + REJECTION_MEMORY_S - 0.1) == (GO,)
    assert memory.words(11.0 + REJECTION_MEMORY_S) == ()


def test_from_one_press_of_the_button_to_the_next_it_is_not_forgotten():
    pytest.importorskip("pocketsphinx", reason="Reading words needs pocketsphinx: pip install pocketsphinx")
    said = padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ))
    reader, memory = Reader(GO, "stop moving", GO), RejectedCommands()
    for press in range(3):
        turn = Transcriber(held=True, recognizer=reader, rejected=memory)
        listened(turn, said, stamp=press * len(said) / RATE_HZ)
    assert reader.told[-1] == (GO,)
