"""Vosk as the engine (Kaldi): free dictation with the model folder that the user supplies, read strictly afterwards.

Its grammar mode is not used: it hears a command in everything, with confidence 1 (vosk-api, issues 741 and 1339).
"""

from __future__ import annotations

import json
import math
from pathlib import Path

from core.errors import BadInput
from core.speech.recognition.decision import TOO_LONG, Decision, Scores, Sentence, Thresholds, decide, log_odds
from core.speech.recognition.engines import package
from core.speech.recognition.recognizer import Utterance, pcm
from core.speech.settings import RATE

LEAST = 0.6  # confidence of every word, below which the sentence is rejected
THRESHOLDS = Thresholds(reject=math.log(LEAST / (1 - LEAST)), accept=-math.inf)  # as log-odds


class Vosk:
    """Dictation by a Vosk model."""

    def __init__(self, folder: Path) -> None:
        """Loads the model. Raises Unavailable without the package, BadInput when the folder holds no model."""
        vosk = package("vosk", "vosk")
        vosk.SetLogLevel(-1)
        try:
            model = vosk.Model(model_path=str(folder))
        except Exception:
            raise BadInput(f"{folder.name!r} holds no model of Vosk; its folder has am/, conf/ and graph/.") from None
        self._recognizer = vosk.KaldiRecognizer(model, RATE)
        self._recognizer.SetWords(True)

    def decide(self, utterance: Utterance) -> Decision:
        """Read all speech strictly as a command; the least certain word says how sure that is."""
        words, least = self._read(utterance)
        scores = Scores(sentence=least, over_second_best=log_odds(least))
        return decide(Sentence(words), scores, THRESHOLDS, objection=TOO_LONG if utterance.cut else "")

    def transcribe(self, utterance: Utterance) -> str:
        """Write down all speech, in any words."""
        return self._read(utterance)[0]

    def _read(self, utterance: Utterance) -> tuple[str, float]:
        """Words, and the confidence of the least certain one (0 without words)."""
        ended = self._recognizer.AcceptWaveform(pcm(utterance.samples))
        parts = [json.loads(self._recognizer.Result())] if ended else []
        parts.append(json.loads(self._recognizer.FinalResult()))
        confidences = [float(word["conf"]) for part in parts for word in part.get("result", ())]
        words = " ".join(text for part in parts if (text := str(part.get("text", ""))))
        return words, min(confidences, default=0.0)
