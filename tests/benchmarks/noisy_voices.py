"""Commands two metres away in noise and rooms: `python -m tests.benchmarks.noisy_voices --data FOLDER [--count 12]`.

FOLDER holds speech_commands_tts and speech_real. Each condition hears the same `count` commands within the bounds of
speech; both voices of the synthesizer take part. One microphone, and the array's beam towards the direction that it
finds itself; sound goes through the endpointer. Told: right, refused, stopped, and every wrong motion by name.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from pathlib import Path

from core.sensors.microphones import Sound
from core.speech.recognition.decision import Decision
from core.speech.recognition.engines import ENGINES, open_engine
from core.speech.recognition.recognizer import Recognizer, StreamingRecognizer
from core.speech.settings import PIECE, SpeechSettings
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber
from core.speech.understanding.grammar import Refusal, understand
from tests.benchmarks.voices import WRONG, outcome_of_all
from tests.benchmarks.word_hearing import FirstOnly
from tests.benchmarks.word_scenes import ARRAY, Condition, real, scene, synthetic

NOISES = ("white", "babble", "recorded", "motors")
CONDITIONS = (
    Condition("clean"),
    *(Condition(f"{noise} {ratio} dB", noise, ratio) for noise in NOISES for ratio in (20, 10, 5)),
    *(Condition(f"room RT60 {rt60}", rt60=rt60) for rt60 in (0.3, 0.6)),
    Condition("room RT60 0.3, babble 20 dB", "babble", 20, 0.3),
)
LISTENERS = ("one microphone", "array")


def listener(name: str, settings: SpeechSettings, recognizer: Recognizer) -> StreamingRecognizer:
    """Who listens to all channels."""
    if name == "array":
        return ArrayTranscriber(ARRAY, settings, recognizer=recognizer)
    return FirstOnly(Transcriber(settings, recognizer=recognizer))


def decisions(ears: StreamingRecognizer, sound: Sound) -> list[Decision]:
    """All that is decided about a sound that comes in as from a room."""
    heard = [one for piece in sound.pieces(PIECE) for one in ears.feed(piece)]
    return [one.decision for one in (*heard, *ears.finish()) if one.final]


def main() -> None:
    """Print a JSON object for every condition and listener."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--engine", choices=tuple(ENGINES), default="whisper")
    parser.add_argument("--count", type=int, default=12, help="commands in each condition")
    chosen = parser.parse_args()
    settings = SpeechSettings(engine=chosen.engine)
    recognizer = open_engine(settings).recognizer
    others = list(real(chosen.data))
    talk = [clip.samples for kind, clip in others if kind == "real-speech"]
    recorded = tuple(clip.samples for kind, clip in others if kind == "noise")
    whole = [
        clip
        for clip in synthetic(chosen.data, "command")
        if not isinstance(understand(clip.text, spoken=True), Refusal)
    ]
    clips = whole[:: max(len(whole) // chosen.count, 1)][: chosen.count]
    for condition in CONDITIONS:
        sounds = [scene(clip, condition, talk, n, recorded) for n, clip in enumerate(clips)]
        for name in LISTENERS:
            found: Counter[str] = Counter()
            for clip, sound in zip(clips, sounds, strict=True):
                told = decisions(listener(name, settings, recognizer), sound)
                result = outcome_of_all(clip.text, told)
                found[result] += 1
                if result == WRONG:
                    heard = ", ".join(one.echo for one in told)
                    sys.stdout.write(f"  WRONG {condition.name}, {name}: “{clip.text}” → {heard}\n")
            line = {"condition": condition.name, "listener": name, "of": len(clips), **found}
            sys.stdout.write(json.dumps(line) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
