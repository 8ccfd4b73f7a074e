"""Find the likely cause where no plane wave explains what the microphones heard.

Every cause is a hypothesis on where the microphones sit (two exchanged, one in the middle because it is a sum of all)
or when they hear (one late). The one under which plane waves explain the times of all utterances is the likely one.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from core.message import Array, message
from core.perception.sound.plane_wave import PlaneWaveFit, explain
from core.sensors.microphones import MicrophoneArray

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
