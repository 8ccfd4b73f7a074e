"""Two recordings of the same speech, orig.wav and rev.wav, brought to one rate and one beginning."""

import math

import numpy as np
import scipy

from core.errors import BadInput
from core.message import Array, message
from core.sensors.microphones import Sound
from core.sensors.resampling import resampled

RATE_HZ = 16_000  # at which recordings are compared
MIN_RECORDING_S = 0.5  # of speech that can be compared
MAX_RECORDING_S = 600.0
LEAST_MATCH = 0.1  # correlation at the best delay, below which it is not the same speech


@message
class AlignedRecordings:
    """The part that both recordings hold, sample by sample."""

    original: Array  # (N,) at RATE_HZ
    received: Array  # (N,) at RATE_HZ
    delay: float  # [s] by which the received speech begins later
    correlation: float  # 0..1 at that delay
    inverted: bool  # the received one is upside down; it was turned


def match(original: Sound, received: Sound) -> AlignedRecordings:
    """Resample both to 16 kHz, find the delay by cross-correlation, keep what both hold.

    Raises BadInput when a recording is silent, too short or too long, or when the two have nothing in common.
    """
    ours, theirs = (at_rate(one, RATE_HZ) for one in (original, received))
    for name, samples in (("original", ours), ("received", theirs)):
        if not MIN_RECORDING_S <= len(samples) / RATE_HZ <= MAX_RECORDING_S:
            raise BadInput(
                f"The {name} recording is {len(samples) / RATE_HZ:.1f} s long; "
                f"{MIN_RECORDING_S:g} to {MAX_RECORDING_S:g} s can be compared."
            )
        if not np.std(samples) > 0:
            raise BadInput(f"The {name} recording is silent; record it again.")
    shift, peak = _delay(ours, theirs)
    if abs(peak) < LEAST_MATCH:
        raise BadInput("The two recordings have nothing in common; are they of the same speech?")
    begin, end = max(0, -shift), min(len(ours), len(theirs) - shift)
    if (end - begin) / RATE_HZ < MIN_RECORDING_S:
        raise BadInput(f"The two recordings share less than {MIN_RECORDING_S:g} s; record all of the speech in both.")
    part = theirs[begin + shift : end + shift]
    return AlignedRecordings(
        original=ours[begin:end],
        received=math.copysign(1.0, peak) * part,
        delay=shift / RATE_HZ,
        correlation=abs(peak),
        inverted=peak < 0,
    )


def at_rate(sound: Sound, rate: int) -> Array:
    """A sound as one channel (N,) at `rate` [Hz], without offset; of several channels the mean."""
    samples = np.asarray(sound.samples, float).mean(axis=1)
    if len(samples):
        samples = samples - samples.mean()
    return resampled(samples, sound.rate, rate)


def _delay(ours: Array, theirs: Array) -> tuple[int, float]:
    """Samples by which `theirs` is later, and the correlation there, -1..1 of the part that overlaps."""
    size = int(scipy.fft.next_fast_len(len(ours) + len(theirs), real=True) or 0)
    table = np.fft.irfft(np.conj(np.fft.rfft(ours, size)) * np.fft.rfft(theirs, size), size)
    best = int(np.argmax(np.abs(table)))
    shift = best if best < len(theirs) else best - size
    begin, end = max(0, -shift), min(len(ours), len(theirs) - shift)
    energy = np.sum(ours[begin:end] ** 2) * np.sum(theirs[begin + shift : end + shift] ** 2)
    return shift, float(table[best] / math.sqrt(energy)) if energy > 0 else 0.0
