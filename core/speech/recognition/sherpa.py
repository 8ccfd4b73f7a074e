"""sherpa-onnx as the engine: a streaming transducer from the model folder that the user supplies, read strictly."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.speech.recognition.decision import TOO_LONG, Decision, Scores, Sentence, Thresholds, decide
from core.speech.recognition.engines import package
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE

PARTS = ("encoder", "decoder", "joiner")
THRESHOLDS = Thresholds(reject=-math.inf, accept=-math.inf)  # it gives no scores: only the grammar rejects
TAIL = 0.5  # [s] of silence that a streaming model wants behind the last word


class Sherpa:
    """Dictation by a transducer in ONNX."""

    def __init__(self, folder: Path) -> None:
        """Loads the model. Raises Unavailable without the package, BadInput when the folder holds no model."""
        sherpa = package("sherpa_onnx", "sherpa-onnx")
        files = {part: _file(folder, f"{part}*.onnx") for part in PARTS} | {"tokens": _file(folder, "tokens.txt")}
        try:
            self._recognizer = sherpa.OnlineRecognizer.from_transducer(
                **files, num_threads=1, sample_rate=RATE, decoding_method="modified_beam_search"
            )
        except Exception:
            raise BadInput(f"{folder.name!r} holds no streaming transducer that sherpa-onnx can load.") from None

    def decide(self, utterance: Utterance) -> Decision:
        """Read all speech strictly as a command."""
        objection = TOO_LONG if utterance.cut else ""
        return decide(
            Sentence(self.transcribe(utterance)), Scores(sentence=math.nan), THRESHOLDS, objection=objection
        )

    def transcribe(self, utterance: Utterance) -> str:
        """Write down all speech, in any words."""
        stream = self._recognizer.create_stream()
        stream.accept_waveform(RATE, utterance.samples.astype(np.float32))
        stream.accept_waveform(RATE, np.zeros(round(TAIL * RATE), np.float32))
        stream.input_finished()
        while self._recognizer.is_ready(stream):
            self._recognizer.decode_stream(stream)
        return str(self._recognizer.get_result(stream)).strip().lower()


def _file(folder: Path, pattern: str) -> str:
    """The one file of that pattern; the smaller, quantised one where there are two. Raises BadInput."""
    found = sorted(folder.glob(pattern), key=lambda path: path.stat().st_size)
    if not found:
        raise BadInput(f"{folder.name!r} holds no {pattern}; a sherpa-onnx transducer has encoder, decoder, joiner.")
    return str(found[0])
