"""Check that the array is wired as its profile says: faults of channels, in words.

Channels and microphones are counted from 1 in sentences, as on the boards.
"""

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import field
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.perception.sound.direction import Direction
from core.perception.sound.locate import DEFAULT, whitened
from core.perception.sound.plane_wave import PlaneWaveFit, explain
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import (
    Spectra,
    cell_weights,
    cross_spectra,
    noise_of,
    over_noise,
    quiet_frames,
    spectra,
)
from core.perception.sound.srp import STEPS_PER_SAMPLE, Correlation
from core.perception.sound.utterances import directions, utterances
from core.sensors.checks import Fault, fault
from core.sensors.microphones import MicrophoneArray, Sound

# Find the likely cause where no plane wave explains what the microphones heard. Every cause is a hypothesis on
# where the microphones sit (two exchanged, one in the middle because it is a sum of all) or when they hear (one
# late). The one under which plane waves explain the times of all utterances is the likely one.

LATE = np.arange(1, 101) * 4e-6  # [s] that are tried
MAX_MISFIT = 1.5  # times the expected misfit: a cause that leaves more is none

CauseKind = Literal["foreign", "sharing", "processed", "swapped", "late", "misfit"]


@message
class Cause:
    """A cause of a contradiction."""

    kind: CauseKind
    microphones: tuple[int, ...]  # in the array's order, from 0
    misfit: float  # that is left with it, of what is expected
    late: float = 0.0  # [s]


def likely_causes(fits: Sequence[PlaneWaveFit], array: MicrophoneArray) -> tuple[Cause, ...]:
    """Fits of utterances that no plane wave explains → the likely causes, the likeliest first; one at least."""
    foreign = np.flatnonzero(np.mean([one.foreign for one in fits], axis=0) > 0.5)
    if len(foreign):
        return (Cause(kind="foreign", microphones=tuple(foreign.tolist()), misfit=0.0),)
    sharing = Counter(one.sharing for one in fits if one.sharing)
    if 2 * sharing.total() > len(fits):
        return (Cause(kind="sharing", microphones=sharing.most_common(1)[0][0], misfit=0.0),)
    found = sorted(_hypotheses(fits, array), key=lambda one: one.misfit)
    found = [one for one in found if one.misfit <= MAX_MISFIT]
    alone = any(one.kind == "late" and len(one.microphones) == 1 for one in found)
    found = [one for one in found if one.kind != "late" or not alone or len(one.microphones) == 1]
    if not found:
        return (Cause(kind="misfit", microphones=(), misfit=math.inf),)
    return tuple(found)


def _hypotheses(fits: Sequence[PlaneWaveFit], array: MicrophoneArray) -> Iterator[Cause]:
    numbers, count = range(len(array.positions)), len(array.positions)
    if np.mean([one.residual_sd / one.expected_sd for one in fits]) > MAX_MISFIT:
        yield from _elsewhere(fits, array)
    for few in (*itertools.combinations(numbers, 1), *itertools.combinations(numbers, 2)):
        if len(few) < count - 1:  # all but one late is one early
            yield _late(fits, few, array)


def _elsewhere(fits: Sequence[PlaneWaveFit], array: MicrophoneArray) -> Iterator[Cause]:
    """Microphones that sit elsewhere than the profile says; noise alone does not tell that."""
    positions, numbers = array.positions, range(len(array.positions))
    for pair in itertools.combinations(numbers, 2):
        moved = positions.copy()
        moved[list(pair)] = positions[list(pair[::-1])]
        yield Cause(kind="swapped", microphones=pair, misfit=_left(fits, moved, array))
    shifted = np.vstack((positions.mean(0), positions[:-1]))  # the sum comes first, and the rest behind it
    yield Cause(kind="processed", microphones=(0,), misfit=_left(fits, shifted, array))
    for number in numbers:
        moved = positions.copy()
        moved[number] = np.delete(positions, number, axis=0).mean(0)
        yield Cause(kind="processed", microphones=(number,), misfit=_left(fits, moved, array))


def _left(fits: Sequence[PlaneWaveFit], positions: Array, array: MicrophoneArray) -> float:
    """Misfit that is left with the microphones at other positions (M, 3), of what is expected."""
    total, freedom = _misfit(fits, positions, array, np.zeros((len(positions), 1)))
    return math.sqrt(float(total[0] / freedom[0])) if freedom[0] else math.inf


def _late(fits: Sequence[PlaneWaveFit], few: tuple[int, ...], array: MicrophoneArray) -> Cause:
    """Microphones that are late by the same time in all utterances: the least time that explains them."""
    late = np.zeros((len(array.positions), len(LATE)))
    late[list(few)] = LATE * array.speed
    total, freedom = _misfit(fits, array.positions, array, late)
    left = np.where(freedom > 1, np.sqrt(total / np.maximum(freedom - 1, 1)), np.maximum(1.0, np.sqrt(total)))
    left = np.maximum(left, _misfit_in_noise(fits, late))
    least = int(np.argmax(left <= left.min() + 0.2))
    return Cause(kind="late", microphones=few, misfit=float(left[least]), late=float(LATE[least]))


def _misfit(
    fits: Sequence[PlaneWaveFit], positions: Array, array: MicrophoneArray, late: Array
) -> tuple[Array, Array]:
    """Lateness (M, N) [m] of the microphones → squared misfit (N,) of all utterances, and its freedom (N,)."""
    places = positions @ array.axes[0][: len(fits[0].within)].T
    total, freedom = np.zeros(late.shape[1]), np.zeros(late.shape[1], int)
    for one in fits:
        _, residuals, free = explain(places, one.times[:, None] + late)
        total += np.sum(residuals**2, axis=0) / one.expected_sd**2
        freedom += free
    return total, freedom


def _misfit_in_noise(fits: Sequence[PlaneWaveFit], late: Array) -> Array:
    """Lateness (M, N) [m] of the microphones → misfit (N,) of the noise from everywhere, of what is expected."""
    heard = [one.noise_times[:, None] + late for one in fits if one.noise_times is not None]
    if not heard:
        return np.zeros(late.shape[1])
    squares = np.mean([np.sum((one - one.mean(0)) ** 2, axis=0) for one in heard], axis=0)
    return np.sqrt(squares / (len(late) - 1)) / fits[0].expected_noise_sd


DEAD_LEVEL = 1e-5  # level of full scale, below which a channel is dead
FAINT_SHARE = 0.05  # of the others' level
IDENTICAL_CORRELATION = 0.99999  # correlation at lag 0
CLIPPED_SHARE = 1e-4  # of the samples in runs at the channel's limit
COMMON_COHERENCE = 0.25  # mean coherence of the noise of a processed channel with each other one, at least
FEWEST_BINS = 8  # of the spectrum, from which that is known
VALLEY_SHARE = 0.3  # of all that two channels share, from which they swing against each other
ABOVE_COSINE = 0.4  # cosine of the elevation below which a voice is nearly straight above
CONTRADICTED = 1 / 3  # of all utterances, from which the array is at fault


@message
class ArrayFault:
    """One thing that is wrong, or worth knowing."""

    kind: str  # one of the table of checks is "array.KIND" there; others: same place, flat, short
    channels: tuple[int, ...]  # of the sound, counted from 0
    sentence: str
    serious: bool = True  # directions cannot be trusted; False: a limit that one should know
    values: dict[str, str] = field(default_factory=dict[str, str])  # in the sentence, by their names

    @property
    def fault(self) -> Fault:
        """The same with its code."""
        return Fault(code=f"array.{self.kind}", sentence=self.sentence, used=not self.serious, values=self.values)


def check(
    sound: Sound,
    array: MicrophoneArray,
    settings: DirectionFindingSettings = DEFAULT,
    found: Sequence[Direction] | None = None,
) -> tuple[ArrayFault, ...]:
    """A sound with some speech in it → everything that looks wrong; `found`: its directions, where they are known.

    Raises BadInput where they do not fit.
    """
    samples = array.heard(sound)
    try:
        seen = spectra(samples, sound.rate, settings)
    except BadInput as trouble:
        short = ArrayFault(kind="short", channels=array.channels, sentence=str(trouble), serious=False)
        return (*_geometry(array), short)
    faults = [*_geometry(array), *_levels(samples, array), *_clipped(samples, array), *_identical(samples, array)]
    if any(one.serious for one in faults) or array.dimensions < 2:
        return tuple(faults)
    together = _together(seen, array, settings)
    if not together:
        if found is None:
            found = directions(sound, array, settings) if utterances(sound, array, settings) else ()
        contradicted = contradiction(found, array, settings)
        together = _scale(found, array) if contradicted is None else [contradicted]
    return (*faults, *together)


def contradiction(
    found: Sequence[Direction], array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> ArrayFault | None:
    """Directions of utterances → the likely cause, where a third of them or more contradict a plane wave."""
    fits = [one.fit for one in found if one.fit is not None]
    wrong = [one for one in fits if one.misfit > settings.declared_misfit]
    if not wrong or len(wrong) < CONTRADICTED * len(fits):
        return None
    causes = likely_causes(wrong, array)
    kind = causes[0].kind
    same = [one for one in causes if one.kind == kind]
    channels = tuple(sorted({array.channels[number] for one in same for number in one.microphones}))
    others = [_in_words(one, array) for one in causes if one.kind != kind][:2]
    values = {
        "channels": " or ".join(_named([array.channels[number] for number in one.microphones]) for one in same[:3]),
        "also": f" (or {', or '.join(others)})" if others else "",
        "late": f"{1e3 * float(np.median([one.late for one in same])):.2f}",
    }
    return _wrong(kind, channels, **values)


def _scale(found: Sequence[Direction], array: MicrophoneArray) -> list[ArrayFault]:
    """A flat array that hears every voice from nearly straight above is likely smaller than its profile says."""
    lengths = [float(np.linalg.norm(one.fit.within)) for one in found if one.fit is not None]
    if not lengths or array.dimensions > 2 or max(lengths) > ABOVE_COSINE:
        return []
    return [_wrong("scale", array.channels, False, times=f"{1 / max(float(np.median(lengths)), 1e-3):.0f}")]


def _in_words(cause: Cause, array: MicrophoneArray) -> str:
    channels = _named([array.channels[number] for number in cause.microphones])
    if cause.kind == "late":
        return f"channel {channels} {1e3 * cause.late:.2f} ms late"
    return f"channel {channels} processed" if cause.kind == "processed" else f"channels {channels} exchanged"


def _wrong(kind: str, at: tuple[int, ...], serious: bool = True, /, **values: str) -> ArrayFault:
    """A fault of the table of checks at some channels."""
    named = {"channels": _named(at), "also": "", **values}
    found = fault(f"array.{kind}", used=not serious, **named)
    return ArrayFault(kind=kind, channels=at, sentence=found.sentence, serious=serious, values=found.values)


def _named(channels: Sequence[int]) -> str:
    words = [str(channel + 1) for channel in channels]
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)


def _geometry(array: MicrophoneArray) -> list[ArrayFault]:
    faults: list[ArrayFault] = []
    for (first, second), baseline in zip(array.pairs, array.baselines, strict=True):
        if np.linalg.norm(baseline) < 1e-4:
            faults.append(
                ArrayFault(
                    kind="same place",
                    channels=(array.channels[first], array.channels[second]),
                    sentence=f"The profile puts microphones {first + 1} and {second + 1} at the same place.",
                    serious=False,
                )
            )
    if array.dimensions == 2:
        words = "All microphones lie in a plane: the side from which a sound comes cannot be determined."
        if abs(array.normal[2]) > 0.99:
            words = "All microphones lie in a plane: azimuths are good, elevations are ± and rough near the horizon."
        faults.append(ArrayFault(kind="flat", channels=array.channels, sentence=words, serious=False))
    if array.dimensions < 2:
        faults.append(_wrong("line", array.channels))
    return faults


def _levels(samples: Array, array: MicrophoneArray) -> list[ArrayFault]:
    level = np.std(samples, axis=0)
    usual = float(np.median(level))
    faults: list[ArrayFault] = []
    for channel, here in zip(array.channels, level, strict=True):
        if here < DEAD_LEVEL:
            faults.append(_wrong("dead", (channel,)))
        elif here < FAINT_SHARE * usual:
            faults.append(_wrong("faint", (channel,), times=f"{usual / here:.0f}"))
    return faults


def _clipped(samples: Array, array: MicrophoneArray) -> list[ArrayFault]:
    faults: list[ArrayFault] = []
    for channel, heard in zip(array.channels, samples.T, strict=True):
        limit = float(np.abs(heard).max())
        at_limit = np.abs(heard) >= 0.999 * limit
        runs = at_limit[2:] & at_limit[1:-1] & at_limit[:-2]
        if limit > 0.01 and np.mean(runs) > CLIPPED_SHARE:
            share = f"{100 * np.mean(at_limit):.1f}"
            faults.append(_wrong("clipped", (channel,), share=share))
    return faults


def _identical(samples: Array, array: MicrophoneArray) -> list[ArrayFault]:
    """Channels that carry one microphone twice, whatever their gains."""
    centred = samples - samples.mean(0)
    size = np.linalg.norm(centred, axis=0)
    alike = np.abs(centred.T @ centred) > IDENTICAL_CORRELATION * np.outer(size, size)
    left = [number for number in range(len(size)) if size[number] > DEAD_LEVEL]
    faults: list[ArrayFault] = []
    while left:
        group = [number for number in left if alike[left[0], number]]
        left = [number for number in left if number not in group]
        if len(group) > 1:
            faults.append(_wrong("identical", tuple(array.channels[number] for number in group)))
    return faults


def _together(seen: Spectra, array: MicrophoneArray, settings: DirectionFindingSettings) -> list[ArrayFault]:
    """Faults that only the channels together show: one that holds the others' noise, one with its wires crossed."""
    noise = noise_of(seen, quiet_frames(seen, settings), settings)
    summed = _summed(noise.cross, seen.frequencies, array)
    if summed:
        return summed
    cross = cross_spectra(seen, cell_weights(over_noise(seen, noise), seen, settings), noise)
    return _inverted(whitened(cross, seen, array, settings), array)


def _summed(noise: Array, frequencies: Array, array: MicrophoneArray) -> list[ArrayFault]:
    """A channel in which the noise of all others is: a sum of the microphones, as a processed channel is.

    Where sound is shorter than twice the way between microphones, diffuse noise has nothing in common at them, and
    their own noise never has.
    """
    apart = float(np.linalg.norm(array.baselines, axis=1).min())
    high = noise[frequencies > array.speed / (2 * max(apart, 1e-6))]
    if len(high) < FEWEST_BINS or len(array.positions) < 3:
        return []
    power = np.real(np.diagonal(high, axis1=1, axis2=2))
    common = np.mean(np.real(high) / np.sqrt(power[:, :, None] * power[:, None, :] + 1e-300), axis=0)
    for number in range(len(common)):
        others = np.delete(np.arange(len(common)), number)
        rest = common[np.ix_(others, others)][np.triu_indices(len(others), 1)]
        if common[number, others].min() > COMMON_COHERENCE and rest.max() < COMMON_COHERENCE / 2:
            return [_wrong("processed", (array.channels[number],))]
    return []


def _inverted(correlation: Correlation, array: MicrophoneArray) -> list[ArrayFault]:
    """Channels of opposite sign: their correlations with most others have a deep valley where a top belongs."""
    tables = correlation.tables() / np.maximum(np.abs(correlation.values).sum(0), 1e-300)
    reach = np.linalg.norm(array.baselines, axis=1) / array.speed * correlation.rate * STEPS_PER_SAMPLE
    lags = np.minimum(np.arange(len(tables)), len(tables) - np.arange(len(tables)))
    inside = lags[:, None] <= reach + STEPS_PER_SAMPLE
    top = np.where(inside, tables, -np.inf).max(0)
    valley = np.where(inside, -tables, -np.inf).max(0)
    count = len(array.positions)
    opposite = np.zeros((count, count))
    first, second = array.pairs.T
    deep = (valley > 1.3 * top) & (valley > VALLEY_SHARE)
    opposite[first, second] = opposite[second, first] = np.where(deep, 1.0, 0.0)
    wrong = [number for number in range(count) if opposite[number].sum() > (count - 1) / 2]
    return [_wrong("inverted", (array.channels[number],)) for number in wrong[:1]]
