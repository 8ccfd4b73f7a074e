"""Commands two metres away in noise and rooms: `python -m tests.benchmarks.noisy_voices --data FOLDER [--count 12]`.

FOLDER holds speech_commands_tts and speech_real. Each condition hears the same `count` commands within the bounds of
speech; both voices of the synthesizer take part. `--listeners` chooses who hears them: one microphone, or the array's
beam towards the direction that it finds itself, in the ways to form it; with "weighted" steady noise is taken out of
the beam first (Wiener's gain), "level 0.01" are the utterances of one microphone at a hundredth of the level. Sound
goes through the endpointer. Told: right, refused, stopped, and every wrong motion by name, and seconds of processor
time.
"""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from core.perception.sound.noise_reduction import without_noise
from core.sensors.microphones import Sound
from core.speech.recognition.decision import Decision
from core.speech.recognition.engines import ENGINES, open_engine
from core.speech.recognition.recognizer import Recognizer, StreamingRecognizer, Utterance
from core.speech.settings import PIECE_S, SpeechSettings
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber
from core.speech.understanding.grammar import Refusal, understand
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.voices import WRONG, outcome_of_all
from tests.benchmarks.word_hearing import ECHOES_KEPT, FirstOnly
from tests.benchmarks.word_scenes import ARRAY, Clip, Condition, real, scene, synthetic

NOISES = ("white", "babble", "recorded", "motors")
CONDITIONS = (
    Condition("clean"),
    *(Condition(f"{noise} {ratio} dB", noise, ratio) for noise in NOISES for ratio in (20, 10, 5)),
    *(Condition(f"room RT60 {rt60}", rt60=rt60) for rt60 in (0.3, 0.6)),
    Condition("room RT60 0.3, babble 20 dB", "babble", 20, 0.3),
)


@dataclass(frozen=True)
class Weighted:
    """A recognizer of utterances out of which steady noise was taken."""

    recognizer: Recognizer

    def decide(self, utterance: Utterance) -> Decision:
        sound = utterance.sound
        samples = without_noise(utterance.samples, sound.rate, len(utterance.before))
        return self.recognizer.decide(replace(utterance, sound=replace(sound, samples=samples[:, None])))


@dataclass(frozen=True)
class AtLevel:
    """A recognizer of utterances at another level."""

    recognizer: Recognizer
    factor: float

    def decide(self, utterance: Utterance) -> Decision:
        sound = utterance.sound
        return self.recognizer.decide(replace(utterance, sound=replace(sound, samples=self.factor * sound.samples)))


def one(settings: SpeechSettings, recognizer: Recognizer) -> StreamingRecognizer:
    """The first microphone."""
    return FirstOnly(Transcriber(settings, recognizer=recognizer))


LISTENERS = {
    "one microphone": one,
    "one microphone, weighted": lambda settings, recognizer: one(settings, Weighted(recognizer)),
    "level 0.01": lambda settings, recognizer: one(settings, AtLevel(recognizer, 0.01)),
    "array": lambda settings, recognizer: ArrayTranscriber(ARRAY, settings, recognizer=recognizer),
    "echoes kept": lambda settings, recognizer: ArrayTranscriber(
        ARRAY, settings, recognizer=recognizer, readings=ECHOES_KEPT
    ),
    "array, weighted": lambda settings, recognizer: ArrayTranscriber(
        ARRAY, settings, recognizer=Weighted(recognizer)
    ),
}


def decisions(ears: StreamingRecognizer, sound: Sound) -> list[Decision]:
    """All that is decided about a sound that comes in as from a room."""
    heard = [one for piece in sound.pieces(PIECE_S) for one in ears.feed(piece)]
    return [one.decision for one in (*heard, *ears.finish()) if one.final]


def within_bounds(data: Path, count: int) -> list[Clip]:
    """So many commands, from all over the set."""
    whole = [
        clip for clip in synthetic(data, "command") if not isinstance(understand(clip.text, spoken=True), Refusal)
    ]
    return [whole[round(place * (len(whole) - 1) / max(count - 1, 1))] for place in range(count)]


def main(
    *,
    data: Path,
    engine: Annotated[str, ENGINES] = "whisper",
    count: int = 12,  # commands in each condition
    listeners: Sequence[Annotated[str, LISTENERS]] = ("one microphone", "array"),
    conditions: str = "",  # only those with this in their names
) -> None:
    settings = SpeechSettings(engine=engine)
    recognizer = open_engine(settings).recognizer
    others = list(real(data))
    talk = [clip.samples for kind, clip in others if kind == "real-speech"]
    recorded = tuple(clip.samples for kind, clip in others if kind == "noise")
    clips = within_bounds(data, count)
    for condition in (one for one in CONDITIONS if conditions in one.name):
        sounds = [scene(clip, condition, talk, n, recorded) for n, clip in enumerate(clips)]
        for name in listeners:
            found: Counter[str] = Counter()
            begun = time.process_time()
            for clip, sound in zip(clips, sounds, strict=True):
                told = decisions(LISTENERS[name](settings, recognizer), sound)
                result = outcome_of_all(clip.text, told)
                found[result] += 1
                if result == WRONG:
                    heard = ", ".join(one.echo for one in told)
                    print_row(f"  WRONG {condition.name}, {name}: “{clip.text}” → {heard}")
            spent = round(time.process_time() - begun, 1)
            line = {"condition": condition.name, "listener": name, "of": len(clips), **found, "cpu_s": spent}
            print_row(line)


if __name__ == "__main__":
    run_command(main)
