"""Vosk as the engine (Kaldi): free dictation with the model folder that the user supplies, read strictly afterwards.

Its grammar mode is not used: it hears a command in everything, with confidence 1 (vosk-api, issues 741 and 1339).
"""

from __future__ import annotations

import json
from pathlib import Path

from core.errors import BadInput
from core.speech.recognition.engines import package
from core.speech.recognition.recognizer import Utterance, WordHypothesis, pcm
from core.speech.settings import RATE

LEAST = 0.6  # confidence of every word, below which the sentence is doubted
DOUBT = "I am not sure that I heard every word right."


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

    def read(self, utterance: Utterance) -> WordHypothesis:
        """Recognize all speech, in any words."""
        ended = self._recognizer.AcceptWaveform(pcm(utterance.samples))
        parts = [json.loads(self._recognizer.Result())] if ended else []
        parts.append(json.loads(self._recognizer.FinalResult()))
        sureness = [float(word["conf"]) for part in parts for word in part.get("result", ())]
        score = min(sureness, default=0.0)
        doubt = "That was longer than any command." if utterance.cut else DOUBT if score < LEAST else ""
        words = " ".join(text for part in parts if (text := str(part.get("text", ""))))
        return WordHypothesis(
            words=words, begin=utterance.begin, end=utterance.end, score=score, doubt=doubt if words else ""
        )
