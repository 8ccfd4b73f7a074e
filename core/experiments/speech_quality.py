"""Loss of speech quality in the robot's hearing (section 6.3): Fig. 17, then a sweep over noise and distance.

The loop of Figs. 10 and 11 in the simulated room: a text is spoken, once close to a quiet microphone (the person's
path) and once somewhere in the room (the robot's path). The same recognizer reads both sounds, and then texts and
recordings are compared. The sentences of Fig. 17 go through it as well, read by a recognizer of any words; that run's
recordings and texts are kept under the paper's names.
"""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np

from core.errors import Unavailable
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, FileContents, as_csv, best_and_worst, grouped, stored
from core.experiments.speech_loop import LoopResult, padded, read, run_loop, save_loop, track_of
from core.install import install_extra
from core.message import Array, message
from core.sensors.microphones import Sound
from core.sensors.resampling import resampled
from core.simulation.acoustics.shoebox import ShoeboxRoom, heard, impulse_responses, pink_noise
from core.speech.practice_voice import practice_voice
from core.speech.quality.audio_similarity import AudioSimilarity, liken
from core.speech.quality.marked_text import FIGURE_17_PERSON, FIGURE_17_ROBOT, MarkedFigures, unmarked
from core.speech.quality.marked_text import as_json as marks_json
from core.speech.quality.osqe import QualityFigures, SpeechQuality, compare
from core.speech.quality.osqe import as_json as quality_json
from core.speech.quality.report import page
from core.speech.quality.word_alignment import phrases_of
from core.speech.recognition.engines import chosen, open_dictation, open_free_dictation
from core.speech.recognition.recognizer import Dictation
from core.speech.settings import SpeechSettings
from core.speech.synthesis import can_speak, drawn_voice, speak

RATE_HZ = 16_000
TEXT = (
    "turn left",
    "turn right",
    "continue two meters",
    "stop moving",
    "stop at one and three",
    "follow me",
    "continue four meters",
    "come here",
    "follow wall",
    "stop at two and minus one",
    "turn left",
    "continue one point five meters",
)
PHRASES = 3 * len(TEXT)  # that are said, unless another number is asked for

ABOUT = About(
    title="Figure 17: quality of speech perception",
    reproduces="Figure 17 and equations 41-46: a text spoken by synthetic voices near the mouth and to the robot, "
    "read by the same recognizer. The counts of the chapter's own two texts agree by construction: they are read "
    "from the print.",
    runs=PHRASES,
    counts="phrases",
    base_s=1.4,
    run_s=2.3,
)
NOISE_RATIOS_DB = (30.0, 20.0, 10.0, 5.0, 0.0)  # voice over noise at the robot, 1 m away on the floor
DISTANCES_M = (0.5, 1.0, 2.0, 3.0, 4.0)  # [m] on the floor: a mouth is higher than the ear; with the quietest noise
ROOM = ShoeboxRoom((7.0, 5.5, 2.7), 0.3)
EAR = np.array([1.2, 1.4, 0.3])  # [m] in the room
PERSON_NOISE = 1e-3  # of the voice's power: a headset
VOICE_RMS = 0.05  # RMS of the voice
SHOWN_ROOM = {"room": "7 x 5.5 x 2.7 m, RT60 0.3 s", "distance": "2 m on the floor", "noise": "30 dB"}  # of the page
NOTHING_SPEAKS = f"Nothing here speaks, so that only recordings are compared: {install_extra('voice')}"


@message
class Setting:
    """One place and noise."""

    sweep: str  # "noise" | "distance"
    ratio: float  # [dB]
    distance: float  # [m] on the floor


FIGURE_17_PLACE = Setting(sweep="distance", ratio=NOISE_RATIOS_DB[0], distance=2.0)
FIGURE_17_PHRASES = tuple(" ".join(words) for words in phrases_of(unmarked(FIGURE_17_PERSON)))
FIGURE_17_NOTE = (
    "Hand-marked: how many words are marked is the paper's, so that OSQE agrees with it by construction; which ones"
    " is ours: the print lost its marks. Spoken: the same sentences by synthetic voices, recorded in the simulated"
    " room 2 m from the robot with noise 30 dB below the voice, and read by a recognizer of any words."
)
SETTINGS = (
    *(Setting(sweep="noise", ratio=ratio, distance=1.0) for ratio in NOISE_RATIOS_DB),
    *(Setting(sweep="distance", ratio=NOISE_RATIOS_DB[0], distance=distance) for distance in DISTANCES_M),
)


@message
class SpokenPhrase:
    """One phrase of the text as a dry sound."""

    text: str
    voice: str  # of espeak-ng; "": made up
    pace: int  # [words/min]
    dry: Array  # (N,) at RATE_HZ, RMS VOICE_RMS


def spoken(rng: np.random.Generator, phrases: Sequence[str]) -> list[SpokenPhrase]:
    """The phrases said, each by a voice drawn from all English ones at its natural pace ± 15 %.

    Without text to speech it is a made-up voice, of which nothing can be read.
    """
    said: list[SpokenPhrase] = []
    for text in phrases:
        drawn = drawn_voice(rng)
        if can_speak():
            sound = speak(text, drawn)
            dry = resampled(sound.samples[:, 0], sound.rate, RATE_HZ)
            voice, pace = drawn.voice, drawn.speed
        else:
            dry = practice_voice(rng, 0.35 * len(text.split()) + 0.3, RATE_HZ)
            voice, pace = "", 0
        said.append(SpokenPhrase(text=text, voice=voice, pace=pace, dry=VOICE_RMS * dry / np.std(dry)))
    return said


def speaker_of(said: Sequence[SpokenPhrase]) -> str:
    """By what phrases were said, in words."""
    voices = {one.voice for one in said}
    if voices == {""}:
        return "made up: pulses and hiss through resonances, without words"
    return f"espeak-ng, {len(voices)} of its English voices"


def responses_at(place: Setting) -> Array:
    """Impulse response from a mouth there to the robot's first microphone, (1, L)."""
    aside = place.distance / math.sqrt(2)
    mouth = EAR + np.array([aside, aside, 0.0])
    mouth[2] = min(1.5, EAR[2] + place.distance)
    return impulse_responses(ROOM, mouth, EAR[None], RATE_HZ, np.random.default_rng(1))


def received_at(rng: np.random.Generator, dry: Array, responses: Array, ratio: float) -> Array:
    """A dry sound (N,) → what the microphone hears of it, with the room's noise `ratio` [dB] below a voice at 1 m."""
    noise = pink_noise(rng, 1, len(dry), RATE_HZ)[0]
    return heard(dry, responses)[:, 0] + VOICE_RMS * 10 ** (-ratio / 20) * noise


def close_by(dictation: Dictation, said: Sequence[SpokenPhrase], seed: int) -> str:
    """Recognize all phrases from the person's own microphone (stt.txt)."""
    rng = np.random.default_rng(seed)
    return "; ".join(read(dictation, at_headset(rng, padded(one.dry))) for one in said)


def at_headset(rng: np.random.Generator, dry: Array) -> Array:
    """A voice (N,) into the person's own microphone."""
    return dry + VOICE_RMS * math.sqrt(PERSON_NOISE) * rng.normal(size=len(dry))


def figure_17(dictation: Dictation, seed: int, phrases: Sequence[str] = FIGURE_17_PHRASES) -> LoopResult:
    """The sentences of Fig. 17 through the loop: both paths, as the robot hears them from FIGURE_17_PLACE."""
    rng = np.random.default_rng((seed, 17))
    said = spoken(rng, phrases)
    track = track_of(phrases, [one.dry for one in said])
    person = at_headset(rng, track.samples)
    robot = received_at(rng, track.samples, responses_at(FIGURE_17_PLACE), FIGURE_17_PLACE.ratio)
    return run_loop(dictation, track, person, robot)


def measure(
    dictation: Dictation | None, said: Sequence[SpokenPhrase], person: str, responses: Array, ratio: float, seed: int
) -> tuple[SpeechQuality | None, AudioSimilarity]:
    """All phrases from one place, of which the impulse `responses` (1, L) and the noise `ratio` [dB] are given: the
    texts compared, where there is a recognizer, and the recordings.
    """
    rng = np.random.default_rng(seed)  # the same noise everywhere, so that only the place makes a difference
    clean = [padded(one.dry) for one in said]
    received = [received_at(rng, sound, responses, ratio) for sound in clean]
    whole = [Sound(stamp=0.0, rate=RATE_HZ, samples=np.concatenate(some)[:, None]) for some in (clean, received)]
    similarity = liken(*whole)
    if dictation is None:
        return None, similarity
    robot = "; ".join(read(dictation, sound) for sound in received)
    return compare("; ".join(one.text for one in said), person, robot), similarity


class PlaceFigures(TypedDict):
    """The figures of one place, as JSON; those of the words only where there is a recognizer."""

    sweep: str
    snr_db: float
    distance_m: float  # on the floor
    stoi: float | None
    estoi: float | None
    si_sdr_db: float | None
    erroneous_words_person: NotRequired[int]
    erroneous_words_robot: NotRequired[int]
    osqe_d: NotRequired[int]
    osqe_r: NotRequired[float | None]
    osqe_r_bounded: NotRequired[float]
    commands_exact: NotRequired[int]  # by the robot


class SpokenPhraseFigures(TypedDict):
    """The voice that said one phrase, and how the phrase arrived, as JSON."""

    text: str
    voice: str
    pace_words_min: int
    erroneous_words_person: int
    erroneous_words_robot: int  # at all places together


class VoiceWords(TypedDict):
    """The words of one voice, as JSON."""

    phrases: int
    words: int  # of them, once for every place
    robot_right_rate: float  # share of them that are no error of the robot's path


class SpeechQualityResult(ExperimentResult):
    """The result, as JSON."""

    figure_17: MarkedFigures
    figure_17_spoken: QualityFigures | None  # the same sentences through the loop
    figure_17_note: str
    figure_17_missing: str  # why they were not spoken; "" when they were
    recognizer: str  # of the sweep, in words
    phrases: int
    words: int
    voice: str  # in words
    said: list[SpokenPhraseFigures]  # every phrase; without words none
    voices: dict[str, VoiceWords]
    best_voice: str  # "": without words there is none
    worst_voice: str
    words_missing: str  # why there are no words; "" when there are
    sweep: list[PlaceFigures]


def row(place: Setting, quality: SpeechQuality | None, similarity: AudioSimilarity) -> PlaceFigures:
    """The figures of one place."""
    fields: PlaceFigures = {
        "sweep": place.sweep,
        "snr_db": place.ratio,
        "distance_m": place.distance,
        "stoi": similarity.figures["stoi"],
        "estoi": similarity.figures["estoi"],
        "si_sdr_db": similarity.figures["si_sdr_db"],
    }
    if quality is None:
        return fields
    score = quality.score
    return {
        **fields,
        "erroneous_words_person": score["erroneous_words_person"],
        "erroneous_words_robot": score["erroneous_words_robot"],
        "osqe_d": score["osqe_d"],
        "osqe_r": score["osqe_r"],
        "osqe_r_bounded": score["osqe_r_bounded"],
        "commands_exact": sum(quality.robot.exact),
    }


class PlaceRun(TypedDict):
    """One place: figures, errors by phrase on both paths (none without a recognizer), and its page where shown."""

    figures: PlaceFigures
    person_errors: list[int]
    robot_errors: list[int]
    page: str


def plan(*, runs: int | None = None, seed: int = 0) -> ExperimentPlan:
    """Plan Fig. 17 and every place; `runs` phrases (36) are spoken. JSON, CSV and one place's page."""
    count = runs or PHRASES
    batch = RunBatch(partial(_work, seed, count), len(SETTINGS), PlaceRun)
    return ExperimentPlan((batch,), partial(_result, seed, count))


def _work(seed: int, count: int, number: int) -> PlaceRun:
    dictation, _ = _dictation()
    said = _said(seed, count)
    person = "" if dictation is None else _person(seed, count)
    place = SETTINGS[number]
    quality, similarity = measure(dictation, said, person, responses_at(place), place.ratio, seed)
    shown = place == FIGURE_17_PLACE
    return {
        "figures": row(place, quality, similarity),
        "person_errors": [] if quality is None else list(quality.person.errors_of_phrases),
        "robot_errors": [] if quality is None else list(quality.robot.errors_of_phrases),
        "page": page(quality, similarity, {"voice": speaker_of(said), **SHOWN_ROOM}) if shown else "",
    }


@lru_cache(maxsize=1)
def _said(seed: int, count: int) -> list[SpokenPhrase]:
    return spoken(np.random.default_rng(seed), [TEXT[number % len(TEXT)] for number in range(count)])


@lru_cache(maxsize=1)
def _person(seed: int, count: int) -> str:
    return close_by(open_dictation(SpeechSettings()), _said(seed, count), seed)


def _result(seed: int, count: int, out: Path | None, done: list[PlaceRun]) -> SpeechQualityResult:
    said = _said(seed, count)
    dictation, why_not = _dictation()
    loop, not_free = _figure_17_spoken(seed, count)
    arrived = phrase_figures(said, done)
    voices = voice_figures(arrived, len(SETTINGS))
    best, worst = (
        best_and_worst({name: one["robot_right_rate"] for name, one in voices.items()}) if voices else ("", "")
    )
    result: SpeechQualityResult = {
        "text": "\n".join((*figure_17_lines(loop), *remarks(voices))),
        "figure_17": marks_json(FIGURE_17_PERSON, FIGURE_17_ROBOT),
        "figure_17_spoken": None if loop is None else quality_json(loop.quality),
        "figure_17_note": FIGURE_17_NOTE,
        "figure_17_missing": not_free,
        "recognizer": "" if dictation is None else chosen(SpeechSettings()).says,
        "phrases": count,
        "words": sum(len(words) for one in said for words in phrases_of(one.text)),
        "seed": seed,
        "voice": speaker_of(said),
        "said": arrived,
        "voices": voices,
        "best_voice": best,
        "worst_voice": worst,
        "words_missing": why_not,
        "sweep": [one["figures"] for one in done],
        "files": {},
    }
    shown = next((one["page"] for one in done if one["page"]), "")
    page: FileContents = {"page": ("speech_quality.html", shown)} if shown else {}
    stored(result, out, "speech_quality", {"csv": ("speech_quality.csv", as_csv(result["sweep"])), **page})
    if out is not None and loop is not None:
        result["files"] |= save_loop(out, loop)
    return result


def phrase_figures(said: Sequence[SpokenPhrase], places: Sequence[PlaceRun]) -> list[SpokenPhraseFigures]:
    """Every phrase with its voice and its errors; none where no words were read."""
    if not places or not places[0]["robot_errors"]:
        return []
    robot = np.sum([one["robot_errors"] for one in places], axis=0).tolist()
    person = places[0]["person_errors"]
    return [
        {
            "text": one.text,
            "voice": one.voice,
            "pace_words_min": one.pace,
            "erroneous_words_person": person[number],
            "erroneous_words_robot": robot[number],
        }
        for number, one in enumerate(said)
    ]


def voice_figures(arrived: Sequence[SpokenPhraseFigures], places: int) -> dict[str, VoiceWords]:
    """How many words of every voice arrive at the robot, over all places."""
    figures: dict[str, VoiceWords] = {}
    for name, some in sorted(grouped(arrived, lambda one: one["voice"]).items()):
        words = places * sum(len(part) for one in some for part in phrases_of(one["text"]))
        wrong = sum(one["erroneous_words_robot"] for one in some)
        figures[name] = {"phrases": len(some), "words": words, "robot_right_rate": max(1 - wrong / words, 0.0)}
    return figures


def remarks(voices: Mapping[str, VoiceWords]) -> list[str]:
    """Every voice in a line, the best and the worst last."""
    lines = [
        f"voice {name}: {100 * one['robot_right_rate']:.0f} % of {one['words']} words right at the robot"
        for name, one in sorted(voices.items(), key=lambda item: -item[1]["robot_right_rate"])
    ]
    return [*lines, f"best {lines[0]}", f"worst {lines[-1]}"] if lines else []


def figure_17_lines(loop: LoopResult | None) -> list[str]:
    """Fig. 17 by hand and through the loop, side by side."""
    by_hand = marks_json(FIGURE_17_PERSON, FIGURE_17_ROBOT)
    columns: list[tuple[str, MarkedFigures | QualityFigures]] = [("hand-marked", by_hand)]
    if loop is not None:
        columns.append(("spoken", quality_json(loop.quality)))
    lines = [f"{'Fig. 17':12}{'person':>8}{'robot':>8}{'OSQE_D':>8}{'OSQE_R':>8}{'words':>8}"]
    for name, one in columns:
        ratio = "-" if one["osqe_r"] is None else f"{one['osqe_r']:.2f}"
        errors = f"{one['erroneous_words_person']:8}{one['erroneous_words_robot']:8}"
        lines.append(f"{name:12}{errors}{one['osqe_d']:+8}{ratio:>8}{one['words']:8}")
    return [*lines, FIGURE_17_NOTE, ""]


def _figure_17_spoken(seed: int, most: int) -> tuple[LoopResult | None, str]:
    """Fig. 17 through the loop, at most so many phrases of it; or None and why not."""
    if not can_speak():
        return None, NOTHING_SPEAKS
    try:
        return figure_17(open_free_dictation(SpeechSettings()), seed, FIGURE_17_PHRASES[:most]), ""
    except Unavailable as absent:
        return None, f"Fig. 17 is not spoken: {absent}"


def _dictation() -> tuple[Dictation | None, str]:
    """A recognizer and "", or None and why there are no words to compare."""
    if not can_speak():
        return None, NOTHING_SPEAKS
    try:
        return open_dictation(SpeechSettings()), ""
    except Unavailable as absent:
        return None, str(absent)
