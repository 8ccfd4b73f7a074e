"""The worker's side of reading words: what outlasts one listener's turn."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from console import words_desk
from console.words_desk import WordsDesk
from core.experiments.practice_voice import practice_voice
from core.speech.held_back import REMEMBERED
from core.speech.recognizer import Hypothesis, Utterance
from core.speech.settings import RATE, SpeechSettings
from tests.core.speech.ears import padded

GO = "stop at 2 and 1"


class Reader:
    """Reads nothing, and keeps what it was told."""

    def __init__(self) -> None:
        self.told: list[tuple[str, ...]] = []

    def read(self, utterance: Utterance) -> Hypothesis:
        self.told.append(utterance.held_back)
        return Hypothesis(words="", begin=utterance.begin, end=utterance.end)


def test_an_order_that_was_held_back_is_known_in_the_next_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    reader = Reader()
    monkeypatch.setattr(words_desk, "open_engine", lambda _: reader)
    desk, settings = WordsDesk(), asdict(SpeechSettings())
    said = padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE)).astype(np.float32).tobytes()
    for turn, held_back in enumerate(((), ((GO, 1.0),), (("turn left", REMEMBERED),))):
        desk.begin(settings, held=True)
        desk.feed(said, RATE, 10.0 * turn, held_back=held_back)
        desk.finish()
    assert reader.told[0] == () and reader.told[-2:] == [(GO,), (GO,)]
