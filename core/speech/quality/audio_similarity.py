"""orig.wav against rev.wav: the additional estimation of section 5.1, by measures that others use too."""

import math
from importlib import import_module
from typing import TypedDict

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.install import install_packages
from core.message import Array, message
from core.sensors.microphones import Sound
from core.speech.quality.stoi import si_sdr, stoi
from core.speech.quality.time_alignment import RATE_HZ, AlignedRecordings, match

CLIPPED_LEVEL = 0.999  # of full scale, from which a sample counts as clipped
CLIPPED_SAMPLES = 3  # that many clipped samples together are clipping rather than a peak
FRAME_S = 0.02  # in which the level is measured
NOISE_PERCENTILE = 10  # percentile of the frames' levels that is the noise floor
SILENCE_DB = -120.0
MIN_COMPARED_SHARE = 0.9  # of the original, of which figures speak for all of it
PESQ_RATE_HZ = 16_000  # of its wide band


class HealthFigures(TypedDict):
    """The state of one recording."""

    sample_rate_hz: int
    channels: int
    duration_s: float
    level_dbfs: float  # RMS
    noise_floor_dbfs: float  # of its quietest tenth
    clipped_share: float  # of the samples, 0..1


class SimilarityFigures(TypedDict):
    """All measures of two recordings, as JSON."""

    stoi: float | None  # None: too short
    estoi: float | None
    si_sdr_db: float | None  # None: silence
    si_sdr_note: str
    pesq_wb: float | None  # None: see `pesq_reason`
    pesq_reason: str  # "" when there is a figure
    compared_share: float  # of the original, that both recordings hold
    compared_note: str  # what the figures leave out; "": nothing
    delay_s: float
    correlation: float
    inverted: bool
    level_change_db: float
    original: HealthFigures
    received: HealthFigures


@message
class AudioSimilarity:
    """The share of the original that is left in the received sound."""

    matched: AlignedRecordings
    figures: SimilarityFigures


def liken(original: Sound, received: Sound) -> AudioSimilarity:
    """Compare two recordings of the same speech. Raises BadInput as `match` does."""
    matched = match(original, received)
    (mos, reason), healths = _pesq(matched), (health(original), health(received))
    share = len(matched.original) / RATE_HZ / healths[0]["duration_s"]
    held = f"Only {100 * share:.0f} % of the original is in both recordings"
    figures: SimilarityFigures = {
        "stoi": stoi(matched.original, matched.received, RATE_HZ),
        "estoi": stoi(matched.original, matched.received, RATE_HZ, extended=True),
        "si_sdr_db": si_sdr(matched.original, matched.received),
        "si_sdr_note": "Reverberation counts as distortion in SI-SDR, however well the words are understood.",
        "pesq_wb": mos,
        "pesq_reason": reason,
        "compared_share": share,
        "compared_note": (
            "" if share > MIN_COMPARED_SHARE else f"{held}; the figures say nothing about the rest. Record all."
        ),
        "delay_s": matched.delay,
        "correlation": matched.correlation,
        "inverted": matched.inverted,
        "level_change_db": healths[1]["level_dbfs"] - healths[0]["level_dbfs"],
        "original": healths[0],
        "received": healths[1],
    }
    return AudioSimilarity(matched=matched, figures=figures)


def health(sound: Sound) -> HealthFigures:
    """A recording → its level, noise floor and clipping."""
    samples = np.asarray(sound.samples, float)
    length = max(1, round(FRAME_S * sound.rate))
    power = np.mean(samples**2, axis=1)
    whole = power[: len(power) // length * length].reshape(-1, length).mean(axis=1)
    return {
        "sample_rate_hz": sound.rate,
        "channels": sound.channels,
        "duration_s": sound.duration,
        "level_dbfs": _db(float(power.mean()) if len(power) else 0.0),
        "noise_floor_dbfs": _db(float(np.percentile(whole, NOISE_PERCENTILE)) if len(whole) else 0.0),
        "clipped_share": max((_clipped(channel) for channel in samples.T), default=0.0),
    }


def _clipped(channel: Array) -> float:
    full = np.abs(channel) >= CLIPPED_LEVEL
    if full.sum() < CLIPPED_SAMPLES:
        return 0.0
    whole = sliding_window_view(full, CLIPPED_SAMPLES).all(axis=1)
    return float(np.convolve(whole, np.ones(CLIPPED_SAMPLES), "full").astype(bool).mean())


def _db(power: float) -> float:
    return max(SILENCE_DB, 10 * math.log10(power)) if power > 0 else SILENCE_DB


def _pesq(matched: AlignedRecordings) -> tuple[float | None, str]:
    """PESQ (P.862.2, wide band) where its package is installed; it is no part of Beckon, its terms are its own."""
    try:
        package = import_module("pesq")
    except ImportError:
        return None, f"PESQ is not installed; it compiles where a C compiler is: {install_packages('pesq')}"
    try:
        return float(package.pesq(PESQ_RATE_HZ, matched.original, matched.received, "wb")), ""
    except (package.PesqError, ValueError):
        return None, "PESQ found no utterance in these recordings."
