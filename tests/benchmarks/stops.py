"""STOP in a quiet room, by both spotters: `python -m tests.benchmarks.stops [--count 200]`.

"stop", "stop moving" and "stop at 2 and 1" by the English voices of espeak-ng, at three levels and three paces, as
sound comes from a browser: 0.1 s at a time. Told for each spotter: how many were missed by the whole chain (spotter,
pauses, end of the utterance), and the time from the last phoneme of "stop" to the decision, processor time included
as if one core were free. `--data FOLDER` adds false STOPs in an hour of talk (speech_real).
"""

import time
from itertools import cycle, islice, product
from pathlib import Path
from typing import Any

import numpy as np

from console.speech.browser_microphone import MICROPHONE_PIECE_S
from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import KeywordSpotter, for_words
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.keyword_spotting import SphinxKeywordSpotter
from core.speech.synthesis import ENGLISH_VOICES, VoiceSettings, speak
from core.speech.transcription.transcriber import Transcriber
from core.speech.whisper.keyword_spotting import WhisperKeywordSpotter
from core.speech.whisper.recognizer import WhisperRecognizer
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.word_hearing import padded
from tests.benchmarks.word_scenes import LEAD, Clip, real
from tests.benchmarks.words import end_of_stop

TEXTS = ("stop", "stop moving", "stop at 2 and 1")
SPOKEN = {"stop at 2 and 1": "stop at two and one"}  # as the aligner reads it
PACES = (120, 150, 180)  # [words/min]
LEVELS = (0.9, 0.3, 0.1)  # of full scale


def spoken(text: str, voice: str, pace: int, level: float) -> Clip:
    settings = VoiceSettings(speed=pace)
    object.__setattr__(settings, "voice", voice)  # more voices than the console offers
    samples = for_words(speak(text, settings)).samples[:, 0]
    return Clip(
        f"{voice}, {pace} words/min, {level}", SPOKEN.get(text, text), level * samples / np.abs(samples).max()
    )


def stopped_at(transcriber: Transcriber, samples: Array) -> float | None:
    """When [s] the chain decides to stop, had the sound come in as it is spoken; None: never."""
    ready = 0.0
    for piece in Sound(stamp=0.0, rate=RATE_HZ, samples=samples[:, None]).pieces(MICROPHONE_PIECE_S):
        begun = time.process_time()
        heard = transcriber.feed(piece)
        ready = max(ready, piece.stamp + piece.duration) + time.process_time() - begun
        if any(one.decision.stops or one.decision.words.startswith("stop at") for one in heard):
            return ready
    return ready if any(one.decision.stops for one in transcriber.finish()) else None


def false_stops(transcriber: Transcriber, data: Path) -> dict[str, Any]:
    """STOPs in real speech without the word."""
    clips = [clip for kind, clip in real(data) if kind not in ("real-digit", "noise")]
    sound = np.concatenate([padded(clip.samples, n, 0.6, 0.6) for n, clip in enumerate(clips)])
    whole = Sound(stamp=0.0, rate=RATE_HZ, samples=sound[:, None])
    begun = time.process_time()
    count = sum(one.decision.stops for piece in whole.pieces(MICROPHONE_PIECE_S) for one in transcriber.feed(piece))
    return {
        "stops": count,
        "seconds": round(whole.duration),
        "real_time_factor": round((time.process_time() - begun) / whole.duration, 3),
    }


def main(*, count: int = 200, data: Path | None = None) -> None:
    settings = SpeechSettings(engine="whisper")
    recognizer = open_engine(settings).recognizer
    assert isinstance(recognizer, WhisperRecognizer)
    kinds = zip(cycle(product(ENGLISH_VOICES, TEXTS)), cycle(product(PACES, LEVELS)), strict=False)
    clips = [spoken(text, voice, *how) for (voice, text), how in islice(kinds, count)]
    for name in ("pocketsphinx", "Whisper"):

        def spotter(name: str = name) -> KeywordSpotter:
            return SphinxKeywordSpotter(settings) if name == "pocketsphinx" else WhisperKeywordSpotter(recognizer)

        after: list[float] = []
        missed: list[str] = []
        for n, clip in enumerate(clips):
            transcriber = Transcriber(settings, recognizer=recognizer, spotter=spotter())
            told = stopped_at(transcriber, padded(clip.samples, n))
            if told is None:
                missed.append(f"{clip.name}: {clip.text}")
            else:
                after.append(told - LEAD - end_of_stop(clip))
        after = [one for one in after if np.isfinite(one)]  # those whose word could be aligned
        p50, p95 = np.percentile(after, (50, 95)) if after else (np.nan, np.nan)
        line: dict[str, Any] = {"spotter": name, "of": len(clips), "aligned": len(after), "missed": missed}
        line |= {"p50_s": round(float(p50), 2), "p95_s": round(float(p95), 2), "worst_s": round(max(after), 2)}
        if data is not None:
            listening = Transcriber(settings, recognizer=recognizer, spotter=spotter())
            line["talk"] = false_stops(listening, data)
        print_row(line)


if __name__ == "__main__":
    run_command(main)
