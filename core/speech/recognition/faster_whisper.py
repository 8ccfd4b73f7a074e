"""faster-whisper as the engine: free dictation with the model folder that the user supplies, then read strictly.

Whisper writes whole sentences with capitals, commas and digits; `understand` reads them as if they had been typed.
It is given no hot words: they make it hear commands in noise.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.speech.recognition.engines import package
from core.speech.recognition.recognizer import Utterance, WordHypothesis

FILES = ("model.bin", "config.json", "tokenizer.json")
LEAST_LIKELY = math.log(0.5)  # mean log probability of the text, below which it is doubted
MOST_SILENT = 0.5  # probability of no speech, above which the text was made up
DOUBT = "I am not sure that I heard every word right."


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

    def read(self, utterance: Utterance) -> WordHypothesis:
        """Recognize all speech, in any words."""
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
        silent = max((float(part.no_speech_prob) for part in parts), default=1.0)
        uncertain = likely < LEAST_LIKELY or silent > MOST_SILENT
        doubt = "That was longer than any command." if utterance.cut else DOUBT if uncertain else ""
        return WordHypothesis(
            words=words,
            begin=utterance.begin,
            end=utterance.end,
            score=likely if math.isfinite(likely) else None,
            doubt=doubt if words else "",
        )
