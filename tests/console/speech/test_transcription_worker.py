"""The worker's side of reading words: what outlasts one listener's turn."""

import numpy as np
import pytest

from console.speech import transcription_worker
from console.speech.transcription_worker import TranscriptionWorker
from core.speech.practice_voice import practice_voice
from core.speech.recognition.decision import Decision
from core.speech.recognition.engines import ENGINES, ActiveEngine
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.transcription.transcriber import REJECTION_MEMORY_S
from tests.core.speech.ears import padded, sure

GO = "stop at 2 and 1"


class Reader:
    """Reads the same whatever is said, and keeps what it was told."""

    def __init__(self, words: str = "") -> None:
        self.words = words
        self.told: list[tuple[str, ...]] = []

    def decide(self, utterance: Utterance) -> Decision:
        self.told.append(utterance.rejected)
        return sure(self.words)


@pytest.mark.parametrize(
    ("speakers", "known"),
    [((1, 1, 1), [(), (GO,), (GO,)]), ((1, 1, 2), [(), (GO,), ()]), ((1, 2, 1), [(), (GO,), ()])],
)
def test_an_order_that_was_held_back_is_known_in_the_next_turn_of_who_spoke(
    monkeypatch: pytest.MonkeyPatch, speakers: tuple[int, ...], known: list[tuple[str, ...]]
) -> None:
    pytest.importorskip("pocketsphinx", reason="Reading words needs pocketsphinx: pip install pocketsphinx")
    reader = Reader()
    monkeypatch.setattr(
        transcription_worker, "open_engine", lambda _: ActiveEngine(reader, ENGINES["sphinx"], "A test reads.")
    )
    worker = TranscriptionWorker()
    said = padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)).astype(np.float32)
    before, long_before = (GO, len(said) / RATE_HZ + 1.0), ("turn left", REJECTION_MEMORY_S + len(said) / RATE_HZ)
    rejected: tuple[list[tuple[str, float]], ...] = ([], [before, long_before], [])
    told = []
    for turn, speaker in enumerate(speakers):
        worker.begin(SpeechSettings(), held=True, speaker=speaker)
        worker.hear(said.tobytes(), RATE_HZ, 10.0 * turn, rejected=rejected[turn])
        worker.finish()
        told.append(reader.told[-1])
    assert told == known


def test_the_words_so_far_are_read_while_the_button_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pocketsphinx", reason="Reading words needs pocketsphinx: pip install pocketsphinx")
    engine = ActiveEngine(Reader(GO), ENGINES["sphinx"], "A test reads.")
    monkeypatch.setattr(transcription_worker, "open_engine", lambda _: engine)
    worker = TranscriptionWorker()
    worker.begin(SpeechSettings(), held=True)
    assert worker.read_so_far() == ""
    said = padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)).astype(np.float32)
    worker.hear(said.tobytes(), RATE_HZ, 0.0)
    assert worker.read_so_far() == GO
    assert [one.utterance.decision.words for one in worker.finish()] == [GO]
