"""faster-whisper as the engine: free dictation with the model folder that the user supplies, then read strictly.

Whisper writes whole sentences with capitals, commas and digits; `understand` reads them as if they had been typed.
It is given no hot words: they make it hear commands in noise.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.speech.recognition.decision import TOO_LONG, Decision, Scores, Sentence, Thresholds, decide, log_odds
from core.speech.recognition.engines import package
from core.speech.recognition.recognizer import Utterance

FILES = ("model.bin", "config.json", "tokenizer.json")
THRESHOLDS = Thresholds(reject=0.0, accept=-math.inf)
"""Log-odds: the mean probability of the text and that of speech, the lower of which must be 0.5 or more."""


class FasterWhisper:
    """Dictation by a Whisper model in CTranslate2's form."""

    def __init__(self, folder: Path) -> None:
        """Loads the model. Raises Unavailable without the package, BadInput when the folder holds no model."""
        whisper = package("faster_whisper", "faster-whisper")
        absent = [name for name in FILES if not (folder / name).is_file()]
        if absent:  # the package would fetch some of them from the net
            raise BadInput(f"{folder.name!r} is no whole faster-whisper model: {' and '.join(absent)} are missing.")
        try:
            self._model = whisper.WhisperModel(
                str(folder), device="cpu", compute_type="int8", cpu_threads=1, local_files_only=True
            )
        except Exception:
            raise BadInput(f"{folder.name!r} holds no model that faster-whisper can load.") from None

    def decide(self, utterance: Utterance) -> Decision:
        """Read all speech strictly as a command."""
        words, likely, silent = self._read(utterance)
        margin = log_odds(min(math.exp(likely), 1.0 - silent))
        objection = TOO_LONG if utterance.cut else ""
        return decide(
            Sentence(words), Scores(sentence=likely, over_second_best=margin), THRESHOLDS, objection=objection
        )

    def transcribe(self, utterance: Utterance) -> str:
        """Write down all speech, in any words."""
        return self._read(utterance)[0]

    def _read(self, utterance: Utterance) -> tuple[str, float, float]:
        """Words, the mean log probability of the least likely part, and the highest probability of no speech."""
        found, _ = self._model.transcribe(
            utterance.samples.astype(np.float32),
            language="en",
            beam_size=5,
            temperature=0.0,
            condition_on_previous_text=False,
        )
        parts = list(found)
        words = " ".join(part.text.strip() for part in parts)
        likely = min((float(part.avg_logprob) for part in parts), default=-math.inf)
        return words, likely, max((float(part.no_speech_prob) for part in parts), default=1.0)
