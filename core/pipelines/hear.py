"""Sound files and recordings through the robot's ears, offline: where voices were, and what they said."""

import contextlib
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypedDict

import numpy as np

from core.errors import BadInput, Unavailable
from core.geometry import wrap
from core.perception.sound.array_diagnostics import check
from core.perception.sound.direction import Direction
from core.perception.sound.locate import sure
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.utterances import directions
from core.pilot.recorded_drive import robot_of
from core.pipelines.listen import WordReader
from core.progress import UNSEEN, WorkProgress
from core.recording.drive import DriveRecording, is_drive
from core.recording.read_report import ReadReport
from core.recording.recorded_senses import is_recording, recorded_sound
from core.recording.recording import RecordingReport
from core.recording.sound_file import missing_share, read_sound
from core.sensors.checks import CHECKS, Fault, FoundFault, fault, found_faults
from core.sensors.microphones import MAX_SAMPLE, MicrophoneArray, Sound
from core.settings import Settings
from core.speech.recognition.decision import RecognizedUtterance, Verdict
from core.speech.recognition.engines import ActiveEngine, open_engine
from core.speech.recognition.recognizer import check_channel

PIECE_S = 0.5  # of sound that are recognised at once
AROUND_S = 0.3  # by which a direction may lie outside the utterance that it belongs to
FAINTER_DB = 20.0  # below the loudest channel, from which on one is taken to be unused
MIN_WHOLE_NUMBER_PEAK = 8.0  # times full scale, from which samples are taken for whole numbers written as fractions
MAX_MISSING_SHARE = 0.01  # of a file's samples, announced in its header
QUIET_S, MIN_UNBROKEN_S, MAX_QUIET_LEVEL = 0.1, 1.0, 0.25  # of every second of speech so much is below that level
MAX_ELEVATION_SD_RAD = 0.5  # sd beyond which an elevation is not reported


class HeardDirection(TypedDict):
    """A direction, as JSON."""

    t_s: float
    azimuth_rad: float
    elevation_rad: float | None
    elevation_ambiguous: bool
    ambiguity: str
    sd_rad: float
    strength: float
    sure: bool


class HeardUtterance(TypedDict):
    """An utterance, as JSON."""

    t0_s: float
    t1_s: float
    words: str
    accepted: bool
    verdict: Verdict
    confidence: float
    command: dict[str, str | float] | None  # name, and its numbers with their units
    reason: str
    alternatives: list[str]
    suggestions: list[str]
    azimuth_rad: float | None


class HeardStop(TypedDict):
    """A STOP that was heard before its sentence was over, as JSON."""

    t0_s: float
    t1_s: float


class HeardRecording(TypedDict):
    """All that was heard in one recording, as JSON."""

    directions: list[HeardDirection]
    utterances: list[HeardUtterance]
    stops: list[HeardStop]
    engine: str  # which recognizer read the words, and why that one
    words_from: str
    warnings: list[str]
    faults: list[FoundFault]  # their sentences are among the warnings
    channels: int
    sample_rate_hz: int
    audio_s: float
    processing_s: float


class UnreadRecording(TypedDict):
    """A recording among several that cannot be read, as JSON."""

    error: str
    directions: list[HeardDirection]  # none
    utterances: list[HeardUtterance]  # none
    audio_s: None
    processing_s: None


class RecordingTranscriber:
    """Hears one recording after another with the same ears."""

    def __init__(self, settings: Settings, array: MicrophoneArray | None = None) -> None:
        """Without an array there are words only. Raises Unavailable when there is neither array nor recognizer."""
        self._settings, self._array = settings, array
        self._engine: ActiveEngine | None = None
        self.wordless = ""  # why there are no words
        try:
            self._engine = open_engine(settings.speech)
        except Unavailable as absent:
            if array is None:
                raise
            self.wordless = str(absent)

    def hear(self, path: Path, channel: int | None = None, progress: WorkProgress = UNSEEN) -> HeardRecording:
        """One file → directions and utterances. Words are read in `channel`; without one from the array's beam
        towards each voice, where the array is sound, else in its first microphone, else in the first channel that
        is not much fainter than the loudest one.

        Raises BadInput with a sentence.
        """
        began = time.perf_counter()
        given, recorded = self._read(path, progress)
        if channel is not None:
            check_channel(given, channel)
        sound, faults = in_full_scale(given)
        faults += [*unbroken(sound), *recorded.faults]
        found: tuple[Direction, ...] = ()
        warnings = list(dict.fromkeys((*recorded.warnings, *(one.sentence for one in faults))))
        beam, finding = False, self._settings.direction_finding
        array = self._array or recorded_array(path)
        if array is not None:
            found = directions(sound, array, finding)
            contradictions = check(sound, array, finding, found)
            warnings += [one.sentence for one in contradictions]
            faults += [one.fault for one in contradictions if one.fault.code in CHECKS]
            beam = channel is None and array.dimensions >= 2 and all(one.used for one in faults)
        words = channel
        if words is None:
            words = array.channels[0] if array is not None else first_heard(sound)
        if array is None and not sound.samples[:, words].any():
            faults.append(fault("array.dead", channels=words + 1))
            warnings.append(faults[-1].sentence)
        said, stops = self._words(sound, array, None if beam else words, path.name, progress)
        if self.wordless:
            warnings.append(self.wordless)
        return {
            "directions": [
                _direction(one, array, finding, believed=all(each.used for each in faults)) for one in found
            ],
            "utterances": [_utterance(one, found) for one in said],
            "stops": [{"t0_s": one.begin, "t1_s": one.end} for one in stops],
            "engine": self.wordless or (self._engine.why if self._engine is not None else ""),
            "words_from": "beam" if beam else f"channel {words}",
            "warnings": warnings,
            "faults": found_faults(faults),
            "channels": sound.channels,
            "sample_rate_hz": sound.rate,
            "audio_s": sound.duration,
            "processing_s": time.perf_counter() - began,
        }

    def _read(self, path: Path, progress: WorkProgress) -> tuple[Sound, RecordingReport]:
        """A file's sound, and what its reader says of it; of a recording its sound from 0 s on. Raises BadInput."""
        tally = ReadReport(path)
        if not is_recording(path):
            sound = read_sound(path)
            if (missing := missing_share(path)) > MAX_MISSING_SHARE:
                tally.fault("sound.cut", used=True, share=f"{100 * missing:.0f}")
            return sound, tally.report("sound")
        sound = recorded_sound(path, self._settings.log, tally, progress)
        return replace(sound, stamp=0.0), tally.report("recording")

    def _words(
        self, sound: Sound, array: MicrophoneArray | None, channel: int | None, name: str, progress: WorkProgress
    ) -> tuple[list[RecognizedUtterance], list[RecognizedUtterance]]:
        """Utterances, and STOPs that were heard before their sentence was over; without a channel from the beam."""
        if self._engine is None:
            return [], []
        reader = WordReader(self._settings, self._engine, array if channel is None else None, channel or 0)
        heard: list[RecognizedUtterance] = []
        for piece in progress.each(list(reader.prepared(sound).pieces(PIECE_S)), name):
            heard += reader.transcriber.feed(piece)
        heard += reader.transcriber.finish()
        return [said for said in heard if said.final], [said for said in heard if not said.final]


def recorded_array(path: Path) -> MicrophoneArray | None:
    """The microphones of the robot that Beckon recorded; None for a file of elsewhere, or a robot without them."""
    if not is_drive(path):
        return None
    with contextlib.suppress(BadInput):  # it does not say, or cannot be read
        drive = DriveRecording(path)
        try:
            return robot_of(drive).used.microphones
        finally:
            drive.close()
    return None


def hear_each(
    paths: Sequence[Path],
    settings: Settings,
    array: MicrophoneArray | None = None,
    channel: int | None = None,
    progress: WorkProgress = UNSEEN,
) -> Iterator[tuple[str, HeardRecording | UnreadRecording]]:
    """Hear recordings one after another → the name of each, and its answer as soon as it is known.

    Raises Unavailable, and of a single recording that cannot be read BadInput, with a sentence.
    """
    hearer = RecordingTranscriber(settings, array)
    distinct = list(dict.fromkeys(paths))
    names = [path.name for path in distinct]
    for number, path in enumerate(distinct):
        try:
            found = hearer.hear(path, channel, progress.part(number, len(distinct)))
        except BadInput as refusal:
            if len(paths) == 1:
                raise
            found = UnreadRecording(error=str(refusal), directions=[], utterances=[], audio_s=None, processing_s=None)
        yield path.name if names.count(path.name) == 1 else str(path), found


def first_heard(sound: Sound) -> int:
    """Return the first channel that is within FAINTER of the loudest one; 0 in a sound without samples."""
    if not sound.samples.size:
        return 0
    power = np.mean(sound.samples**2, axis=0)  # (C,)
    return int(np.argmax(power >= power.max() * 10 ** (-FAINTER_DB / 10)))


def in_full_scale(sound: Sound) -> tuple[Sound, list[Fault]]:
    """A sound whose samples are numbers of 16, 24 or 32 bits → the same within ±1, and what is said about it."""
    peak = float(np.abs(sound.samples).max(initial=0.0))
    if not MIN_WHOLE_NUMBER_PEAK < peak <= MAX_SAMPLE:  # more is no sound, and refused
        return sound, []
    full = next(2.0 ** (bits - 1) for bits in (16, 24, 32) if peak <= 2.0 ** (bits - 1))
    units = fault("sound.units", used=True, peak=f"{peak:.0f}", full=f"{full:.0f}")
    return Sound(stamp=sound.stamp, rate=sound.rate, samples=sound.samples / full), [units]


def unbroken(sound: Sound) -> list[Fault]:
    """List what is said about a sound that is never quiet, as no speech is: noise, or numbers of another kind."""
    length = round(QUIET_S * sound.rate)
    pieces = len(sound.samples) // length
    if pieces * QUIET_S < MIN_UNBROKEN_S:
        return []
    squares = np.square(sound.samples[: pieces * length]).reshape(pieces, -1).mean(1)
    return [fault("sound.unbroken", used=True)] if math.sqrt(squares.min()) > MAX_QUIET_LEVEL else []


def _direction(
    one: Direction, array: MicrophoneArray | None, settings: DirectionFindingSettings, *, believed: bool
) -> HeardDirection:
    return {
        "t_s": one.stamp,
        "azimuth_rad": wrap(one.azimuth),
        "elevation_rad": one.elevation if one.elevation_sd < MAX_ELEVATION_SD_RAD else None,
        "elevation_ambiguous": one.mirror is not None,
        "ambiguity": one.ambiguity if array is not None else "",
        "sd_rad": one.azimuth_sd,
        "strength": one.strength,
        "sure": believed and sure(one, settings),
    }


def _utterance(said: RecognizedUtterance, found: Sequence[Direction]) -> HeardUtterance:
    begin, end = said.said
    near = [one for one in found if begin - AROUND_S <= one.stamp <= end + AROUND_S]
    best = max(near, key=lambda one: one.strength, default=None)
    decision, command = said.decision, said.decision.command
    return {
        "t0_s": said.begin,
        "t1_s": said.end,
        "words": decision.words,
        "accepted": command is not None,
        "verdict": decision.verdict,
        "confidence": decision.confidence,
        "command": None if command is None else {"name": command.name, **command.numbers},
        "reason": decision.reason,
        "alternatives": [one.heard_as for one in decision.alternatives],
        "suggestions": list(decision.did_you_mean),
        "azimuth_rad": None if best is None else wrap(best.azimuth),
    }
