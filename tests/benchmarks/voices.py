"""How well people are understood, by Whisper beside pocketsphinx: `python -m tests.benchmarks.voices --data FOLDER`.

FOLDER holds speech_human_digits (real human digits in synthetic sentences, and synthetic voices), speech_commands_tts
(commands and near misses) and speech_real (real speech that is no command). Every clip is one utterance, and the talk
is read once more as one long sound that the endpointer cuts. `--cut` lets the endpointer cut every clip, as `beckon
hear` does; `--noise` adds white noise, babble and recorded noise; `--every N` takes every Nth clip; `--misses` lists
what was not understood. Every wrong motion is listed. Delays are processor seconds of one thread.

`--odds` tells how often numbers are right by the confidence in them, for each speaker fitted to all others; people's
digits are also read deeper and slower, and higher and faster.

Both engines read the same clips in one run, with the thresholds that they have in use. Whisper's were chosen on these
clips and on `tests.benchmarks.accents`, and tried on other sentences, paces and pitches of its voices. pocketsphinx'
were chosen on speech_commands_tts and speech_real (`tests.benchmarks.words`).
"""

import json
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from core.message import Array
from core.pipelines.hear import PIECE_S
from core.sensors.microphones import Sound
from core.sensors.resampling import resampled
from core.speech.recognition.decision import Decision, RecognizedUtterance, Sentence, log_odds
from core.speech.recognition.engines import ENGINES, open_engine
from core.speech.recognition.recognizer import Recognizer, Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.transcription.transcriber import Transcriber
from core.speech.understanding.grammar import Refusal, understand
from core.speech.whisper.log_mel import log_mel
from core.speech.whisper.recognizer import MIN_RIGHT_PROBABILITY, WhisperRecognizer
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.word_hearing import listened, padded
from tests.benchmarks.word_scenes import Clip, clips_of, real, synthetic

RIGHT, REFUSED, STOPPED, WRONG = "right", "refused", "stopped", "WRONG"
RATIOS = (20, 10, 5)  # [dB] of the voice over the noise


def utterance(samples: Array) -> Utterance:
    sound = Sound(stamp=0.0, rate=RATE_HZ, samples=samples[:, None])
    return Utterance(sound=sound, begin=0.0, end=sound.duration)


def outcome(wanted: str, decision: Decision) -> str:
    """What became of words; `wanted` "": no command."""
    meant = understand(wanted, spoken=True) if wanted else Refusal("")
    command = decision.command
    if command is None:
        return RIGHT if isinstance(meant, Refusal) else REFUSED
    if not isinstance(meant, Refusal) and (command.name, dict(command.numbers)) == (meant.name, dict(meant.numbers)):
        return RIGHT
    return STOPPED if decision.stops else WRONG


def sets(data: Path) -> Iterator[tuple[str, str, Clip]]:
    """(set, the command that is wanted, clip)."""
    for kind, clip in clips_of(data / "speech_human_digits"):
        beyond = isinstance(understand(clip.text, spoken=True), Refusal)
        yield f"{kind}, beyond the bounds" if beyond else kind, clip.text, clip
    for clip in synthetic(data, "command"):
        beyond = isinstance(understand(clip.text, spoken=True), Refusal)
        yield "flite commands, beyond the bounds" if beyond else "flite commands", clip.text, clip
    for clip in synthetic(data, "near-miss"):
        yield "near misses", "", clip
    for kind, clip in real(data):
        yield f"real: {kind}", "", clip


def noisy(data: Path, every: int) -> Iterator[tuple[str, str, Clip]]:
    """Commands within the bounds in three noises, at three ratios."""
    noises = Noises(data)
    for clip in synthetic(data, "command")[:: max(every, 3)]:
        if not isinstance(understand(clip.text, spoken=True), Refusal):
            for name, samples in noises.around(clip.samples):
                yield name, clip.text, Clip(clip.name, clip.text, samples)


class Noises:
    """White noise, babble and recorded noise, at three ratios."""

    def __init__(self, data: Path) -> None:
        """`data` has speech_real in it."""
        self._recorded = [clip.samples for kind, clip in real(data) if kind == "noise"]
        self._talk = [clip.samples for kind, clip in real(data) if kind == "real-speech"]
        self._rng = np.random.default_rng(7)

    def around(self, samples: Array) -> Iterator[tuple[str, Array]]:
        """Samples (N,) → (the noise and its ratio, the sum (N,)), nine times."""
        length = len(samples)
        babble = sum(np.roll(np.resize(one / one.std(), length), self._rng.integers(length)) for one in self._talk)
        white = self._rng.normal(size=length)
        recorded = np.resize(self._recorded[int(self._rng.integers(len(self._recorded)))], length)
        for name, noise in (("white", white), ("babble", np.asarray(babble)), ("recorded", recorded)):
            for ratio in RATIOS:
                scale = np.std(samples) / np.std(noise) * 10 ** (-ratio / 20)
                yield f"{name} {ratio} dB", samples + scale * noise


WARPS = (0.86, 0.93, 1.0, 1.08, 1.17)  # of a voice's pitch, formants and pace together
BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)  # of the confidence


@dataclass(frozen=True)
class HeardNumber:
    """The best meaning of a sentence with numbers."""

    speaker: str
    log_odds: float  # [nats] that the engine gives it
    right: bool


def speaker_of(kind: str, name: str) -> str:
    """The person in a clip's name, else the voice of its kind."""
    return next((part for part in name.split("_") if part in ("george", "jackson", "lucas")), f"{kind} {name[:9]}")


def heard_numbers(recognizer: Recognizer, clips: Iterable[tuple[str, str, Clip]]) -> Iterator[HeardNumber]:
    """Of each clip with a command with numbers the best meaning that has numbers."""
    for kind, wanted, clip in clips:
        meant = Sentence(wanted).meaning
        for warp in WARPS if kind.startswith("digit") else (1.0,):
            samples = clip.samples if warp == 1.0 else resampled(clip.samples, RATE_HZ, round(warp * RATE_HZ))
            decision = recognizer.decide(utterance(samples))
            heard = Sentence(decision.words).meaning
            if meant[1] and heard[1]:
                nats = log_odds(decision.confidence)
                yield HeardNumber(speaker_of(kind, clip.name), nats, heard == meant)


def fitted(heard: list[HeardNumber]) -> tuple[float, float]:
    """Logistic regression of right on the engine's log odds → offset and slope; 0 and 1 where they are calibrated."""
    features = np.array([(1.0, one.log_odds) for one in heard])
    right = np.array([one.right for one in heard], dtype=float)
    weights, prior = np.array([0.0, 1.0]), np.diag([1e-6, 0.3])
    for _ in range(50):
        likely = 1 / (1 + np.exp(-features @ weights))
        curvature = features.T @ (features * (likely * (1 - likely))[:, None]) + prior
        weights = weights + np.linalg.solve(curvature, features.T @ (right - likely) - prior @ (weights - (0, 1)))
    return float(weights[0]), float(weights[1])


def reliability(heard: list[HeardNumber]) -> dict[str, Any]:
    """How often numbers are right, by the probability that a fit to all other speakers gives them."""
    told: list[tuple[float, bool]] = []
    for speaker in sorted({one.speaker for one in heard}):
        offset, slope = fitted([one for one in heard if one.speaker != speaker])
        own = [one for one in heard if one.speaker == speaker]
        told += [(1 / (1 + float(np.exp(-offset - slope * one.log_odds))), one.right) for one in own]
    table: dict[str, Any] = {"fit_to_all": [round(value, 2) for value in fitted(heard)]}
    for low, high in pairwise(BINS):
        within = [(likely, right) for likely, right in told if low <= likely < high]
        if within:
            likely, right = np.mean(within, axis=0)
            table[f"{low:g} to {high:g}"] = {"n": len(within), "told": round(likely, 3), "right": round(right, 3)}
    kept = [right for likely, right in told if likely >= MIN_RIGHT_PROBABILITY]
    return table | {"believed": len(kept), "wrong": kept.count(False), "of": sum(right for _, right in told)}


Decide = Callable[[Array], list[Decision]]
"""Samples (N,) of a clip → the decisions about it."""


def as_one(recognizer: Recognizer) -> Decide:
    """Every clip is one utterance."""
    return lambda samples: [recognizer.decide(utterance(samples))]


def as_cut(recognizer: Recognizer, settings: SpeechSettings) -> Decide:
    """The endpointer cuts every clip, as in `beckon hear`."""

    def decide(samples: Array) -> list[Decision]:
        ears = Transcriber(settings, recognizer=recognizer)
        heard: list[RecognizedUtterance] = []
        for piece in Sound(stamp=0.0, rate=RATE_HZ, samples=samples[:, None]).pieces(PIECE_S):
            heard += ears.feed(piece)
        return [one.decision for one in (*heard, *ears.finish()) if one.final]

    return decide


def outcome_of_all(wanted: str, decisions: list[Decision]) -> str:
    """What became of words that may have been cut into several utterances: the gravest, then the best."""
    found = {outcome(wanted, one) for one in decisions} or {REFUSED if wanted else RIGHT}
    return next(one for one in (WRONG, STOPPED, RIGHT, REFUSED) if one in found)


def measured(decide: Decide, clips: list[tuple[str, str, Clip]], misses: bool) -> dict[str, Any]:
    """Outcomes and delays of every set."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    delays: dict[str, list[float]] = defaultdict(list)
    for kind, wanted, clip in clips:
        begun = time.process_time()
        decisions = decide(clip.samples)
        delays[kind].append(time.process_time() - begun)
        result = outcome_of_all(wanted, decisions)
        counts[kind][result] += 1
        if result == WRONG or (misses and result != RIGHT):
            told = ", ".join(f"{one.echo} ({one.verdict})" for one in decisions)
            print_row(f"  {result} {kind}: {clip.name} “{clip.text}” → {told}")
    table = {}
    for kind, found in counts.items():
        p50, p95 = np.percentile(delays[kind], (50, 95))
        table[kind] = {"n": found.total(), **found, "p50_s": round(p50, 3), "p95_s": round(p95, 3)}
        print_row(f"  {kind:36}{json.dumps(table[kind])}")
    return table


def stages(recognizer: WhisperRecognizer, clips: list[tuple[str, str, Clip]]) -> dict[str, float]:
    """Median processor seconds of the stages of one utterance."""
    spent: dict[str, list[float]] = defaultdict(list)
    for _, _, clip in clips[:: max(len(clips) // 20, 1)]:
        begun = time.process_time()
        mel = log_mel(clip.samples)
        heard = time.process_time()
        recognizer.encode(mel)
        encoded = time.process_time()
        recognizer.search(clip.samples)
        spent["log mel"].append(heard - begun)
        spent["encoder"].append(encoded - heard)
        spent["joint search"].append(time.process_time() - encoded - (encoded - begun))
    return {stage: round(float(np.median(times)), 4) for stage, times in spent.items()}


def talk(recognizer: Recognizer, settings: SpeechSettings, data: Path) -> dict[str, Any]:
    """Real speech that is no command as one long sound, cut by the endpointer: what would have moved the robot."""
    clips = [clip for kind, clip in real(data) if kind not in ("real-digit", "noise")]
    sound = np.concatenate([padded(clip.samples, n, 0.6, 0.6) for n, clip in enumerate(clips)])
    told = [one.heard.decision for one in listened(Transcriber(settings, recognizer=recognizer), sound, 0.0)]
    moved = [one.echo for one in told if one.command is not None and not one.stops]
    return {"seconds": round(len(sound) / RATE_HZ), "pieces": len(told), "motions": moved}


def resident() -> float:
    """Memory of this process [MB]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1000


def main(
    *,
    data: Path,
    engines: Sequence[Annotated[str, ENGINES]] = tuple(ENGINES),
    every: int = 1,
    noise: bool = False,
    cut: bool = False,
    misses: bool = False,
    odds: bool = False,
) -> None:
    clips = list(sets(data))[::every]
    if noise:
        clips = list(noisy(data, every))
    for name in engines:
        settings = SpeechSettings(engine=name)
        before, begun = resident(), time.process_time()
        recognizer = open_engine(settings).recognizer
        print_row(f"{name}: opened in {time.process_time() - begun:.2f} s")
        if odds:
            print_row(f"  {json.dumps(reliability(list(heard_numbers(recognizer, clips))))}")
            continue
        decide = as_cut(recognizer, settings) if cut else as_one(recognizer)
        measured(decide, clips, misses)
        print_row(f"  {resident() - before:.0f} MB more than before, {resident():.0f} MB in all")
        if isinstance(recognizer, WhisperRecognizer):
            print_row(f"  stages [s]: {stages(recognizer, clips)}")
        if not noise:
            print_row(f"  real speech, cut by the endpointer: {talk(recognizer, settings, data)}")


if __name__ == "__main__":
    run_command(main)
