"""What is heard as a command and what is not: `python -m tests.benchmarks.words --data FOLDER [--parts talk near …]`.

FOLDER holds speech_real and speech_commands_tts. Parts: `talk` (real speech that is no command, beside the plain
grammar), `near` (synthetic commands and near misses), `numbers` (real digits), `noise` (commands two metres away in
noise and rooms: one microphone and the array), `stop` (delays). Sound goes through the endpoints, 20 ms at a time.
"""

import json
import math
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from core.speech.recognition.decision import Decision, Scores, Sentence, Thresholds, decide
from core.speech.recognition.recognizer import Recognizer, StreamingRecognizer, Utterance, pcm
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.decoder import grammar_decoder
from core.speech.sphinx.jsgf import plain_grammar, written
from core.speech.sphinx.recognizer import Sphinx, SphinxDictation
from core.speech.transcription.array_transcriber import READINGS, ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.word_hearing import (
    ECHOES_KEPT,
    FirstOnly,
    acted_on,
    listened,
    outcome,
    padded,
    rejections,
    uncertain,
)
from tests.benchmarks.word_scenes import ARRAY, CONDITIONS, LEAD, Clip, real, scene, synthetic

Listener = Literal["one microphone", "echoes kept", "array"]
LISTENERS: tuple[Listener, ...] = ("one microphone", "echoes kept", "array")


class PlainGrammar:
    """Whatever is said is the sentence of the grammar that fits best."""

    def __init__(self, settings: SpeechSettings) -> None:
        self._dictation = SphinxDictation(settings)

    def decide(self, utterance: Utterance) -> Decision:
        thresholds = Thresholds(reject=-math.inf, accept=-math.inf)
        return decide(Sentence(self._dictation.transcribe(utterance)), Scores(sentence=0.0), thresholds)


def share(count: int, of: int) -> str:
    return f"{count}/{of} = {100 * count / max(of, 1):.1f} %"


def talk(data: Path, settings: SpeechSettings, say: Callable[[str], None]) -> dict[str, Any]:
    """Real speech for all its length, as one long sound."""
    clips = [clip for kind, clip in real(data) if kind != "real-digit"]
    sound = np.concatenate([padded(clip.samples, n, 0.6, 0.6) for n, clip in enumerate(clips)])
    figures: dict[str, Any] = {"seconds": round(len(sound) / RATE_HZ, 1)}
    for name, recognizer in (("ours", Sphinx(settings)), ("plain grammar", PlainGrammar(settings))):
        begun = time.process_time()
        told = listened(Transcriber(settings, recognizer=recognizer), sound, 0.0)
        final = [one.heard for one in told if one.heard.final]
        passed = [one.decision.words for one in final if acted_on(one)]
        figures[name] = {
            "utterances": len(final),
            "accepted": len(passed),
            "accepted_words": passed,
            "per_hour": round(3600 * len(passed) / figures["seconds"]),
            "false_stops": sum(not one.heard.final for one in told),
            "rejected": [f"{one.decision.words}: {one.decision.reason}" for one in final if uncertain(one)],
            "real_time_factor": round((time.process_time() - begun) / figures["seconds"], 3),
        }
        say(f"talk, {name}: {json.dumps(figures[name])}")
    return figures


def near(data: Path, settings: SpeechSettings, say: Callable[[str], None]) -> dict[str, Any]:
    """Synthetic commands and near misses, clean."""
    transcriber = Transcriber(settings)
    figures: dict[str, Any] = {}
    delays: list[float] = []
    worked = audio = 0.0
    kept: Counter[str] = Counter()
    lost: list[tuple[str, ...]] = []
    for n, clip in enumerate(synthetic(data, "command")):
        samples = padded(clip.samples, n)
        begun = time.process_time()
        told = listened(transcriber, samples, 100.0 * n)
        worked, audio = worked + time.process_time() - begun, audio + len(samples) / RATE_HZ
        kept[outcome(told, clip.text)] += 1
        if outcome(told, clip.text) != "right":
            lost.append(
                (clip.name, clip.text, *(f"{one.heard.decision.words} {one.heard.decision.reason}" for one in told))
            )
        delays += [one.ready - (one.heard.end - 100.0 * n) for one in told if one.heard.final]
    figures["commands"] = dict(kept) | {"lost": lost}
    figures["word_end_to_result_s"] = {
        "median": round(float(np.median(delays)), 2),
        "p95": round(float(np.quantile(delays, 0.95)), 2),
    }
    figures["real_time_factor"] = round(worked / audio, 3)
    say(f"commands: {json.dumps(figures)}")
    passed, moving = [], 0
    clips = synthetic(data, "near")
    for n, clip in enumerate(clips):
        told = listened(transcriber, padded(clip.samples, n), 100.0 * n)
        for decision in (one.heard.decision for one in told if acted_on(one.heard)):
            passed.append((clip.text, decision.words))
            command = decision.command
            moving += command is not None and command.name not in ("stop_moving", "start")
    figures["near_misses"] = {"accepted": share(len(passed), len(clips)), "which": passed, "moving_today": moving}
    say(f"near misses: {json.dumps(figures['near_misses'])}")
    return figures


def numbers(data: Path, settings: SpeechSettings, say: Callable[[str], None]) -> dict[str, Any]:
    """Real digits, put in the place of the number of a synthetic "continue … meters"; and other real numbers."""
    transcriber = Transcriber(settings)
    host = next(clip for clip in synthetic(data, "command") if clip.text == "continue one meters")
    begin, end = hole(host)
    counted: dict[str, Counter[str]] = {}
    wrong: list[tuple[str, ...]] = []
    for n, clip in enumerate(clip for kind, clip in real(data) if kind == "real-digit"):
        level = np.abs(host.samples).max() / max(np.abs(clip.samples).max(), 1e-9)
        pause = np.zeros(int(0.08 * RATE_HZ))
        parts = (host.samples[:begin], pause, level * clip.samples, pause, host.samples[end:])
        told = listened(transcriber, padded(np.concatenate(parts), n), 100.0 * n)
        result = outcome(told, f"continue {clip.text} meters")
        counted.setdefault("all", Counter())[result] += 1
        counted.setdefault(clip.text, Counter())[result] += 1
        if result == "wrong":
            wrong.append((clip.name, *(one.heard.decision.words for one in told)))
    figures = {name: dict(one) for name, one in counted.items()} | {"which_wrong": wrong}
    say(f"real digits within a synthetic sentence: {json.dumps(figures)}")
    return figures


def hole(host: Clip) -> tuple[int, int]:
    """First and last sample of the number in "continue one meters"."""
    decoder = grammar_decoder(plain_grammar(), bestpath=False)
    decoder.start_utt()
    decoder.process_raw(pcm(host.samples), full_utt=True)
    decoder.end_utt()
    found = next(one for one in decoder.seg() if one.word.startswith("one"))
    return int(0.01 * found.start_frame * RATE_HZ), int(0.01 * (found.end_frame + 1) * RATE_HZ)


def noise(
    data: Path, settings: SpeechSettings, say: Callable[[str], None], every: int, only: str = ""
) -> dict[str, Any]:
    """Commands in noise and in rooms: one microphone, and the array's beams towards the direction it finds itself."""
    recognizer = Sphinx(settings)
    babble = [clip.samples for kind, clip in real(data) if kind == "real-speech"]
    clips = synthetic(data, "command")[::every]
    figures: dict[str, Any] = {}
    for condition in CONDITIONS:
        if only and only not in condition.name:
            continue
        counted: dict[Listener, Counter[str]] = {name: Counter() for name in LISTENERS}
        wrong: list[tuple[str, ...]] = []
        for n, clip in enumerate(clips):
            sound = scene(clip, condition, babble, n)
            for name in counted:
                told = listened(heard_by(name, settings, recognizer), sound.samples, 0.0)
                result = outcome(told, clip.text)
                counted[name][result] += 1
                counted[name].update(rejections(told, clip.text))
                if result == "wrong":
                    wrong.append(
                        (name, clip.text, *(one.heard.decision.words for one in told if acted_on(one.heard)))
                    )
        figures[condition.name] = {name: dict(one) for name, one in counted.items()} | {"which_wrong": wrong}
        say(f"{condition.name}: {json.dumps(figures[condition.name])}")
    return figures


def heard_by(name: Listener, settings: SpeechSettings, recognizer: Recognizer) -> StreamingRecognizer:
    """Who listens to all channels."""
    if name == "one microphone":
        return FirstOnly(Transcriber(settings, recognizer=recognizer))
    readings = READINGS if name == "array" else ECHOES_KEPT
    return ArrayTranscriber(ARRAY, settings, recognizer=recognizer, readings=readings)


def stop(data: Path, settings: SpeechSettings, say: Callable[[str], None]) -> dict[str, Any]:
    """How long after its last phoneme STOP is told, how long after its end the whole sentence, and what is missed."""
    transcriber = Transcriber(settings)
    after_word: list[float] = []
    after_sentence: list[float] = []
    begun, audio = time.process_time(), 0.0
    missed = 0
    clips = [clip for clip in synthetic(data, "command") if clip.text.startswith("stop ")]
    for n, clip in enumerate(clips):
        told = listened(transcriber, padded(clip.samples, n), 100.0 * n)
        early = [one for one in told if not one.heard.final]
        missed += not early
        audio += len(clip.samples) / RATE_HZ
        after_sentence += [one.ready - (one.heard.end - 100.0 * n) for one in told if one.heard.final]
        if early:
            after_word.append(early[0].ready - (end_of_stop(clip) + LEAD))
    figures = {
        "spotted": share(len(clips) - missed, len(clips)),
        "last_phoneme_to_stop_s": {
            "median": round(float(np.median(after_word)), 2),
            "worst": round(float(np.max(after_word)), 2),
        },
        "sentence_to_result_s": {
            "median": round(float(np.median(after_sentence)), 2),
            "worst": round(float(np.max(after_sentence)), 2),
        },
        "real_time_factor": round((time.process_time() - begun) / audio, 3),
    }
    say(f"stop: {json.dumps(figures)}")
    return figures


def end_of_stop(clip: Clip) -> float:
    """[s] from the clip's begin to the end of its word STOP, by aligning its own text; NaN where that fails."""
    decoder = grammar_decoder(written({}, clip.text), bestpath=False)
    decoder.start_utt()
    decoder.process_raw(pcm(clip.samples), full_utt=True)
    decoder.end_utt()
    aligned = [one.end_frame for one in decoder.seg() or () if one.word.startswith("stop")]
    return 0.01 * (aligned[0] + 1) if aligned else np.nan


def main(
    *,
    data: Path,
    parts: Sequence[str] = ("talk", "near", "numbers", "noise", "stop"),
    every: int = 1,  # in noise, only every so many of the commands
    only: str = "",  # in noise, only the conditions whose name holds this
    opinions: int = SpeechSettings.opinions,
) -> None:
    settings = SpeechSettings(opinions=opinions)

    for part in parts:
        if part == "noise":
            noise(data, settings, print_row, every, only)
        else:
            {"talk": talk, "near": near, "numbers": numbers, "stop": stop}[part](data, settings, print_row)


if __name__ == "__main__":
    run_command(main)
