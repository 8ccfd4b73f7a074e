"""Check that the array is wired as its profile says: faults of channels, in words.

Channels and microphones are counted from 1 in sentences, as on the boards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.perception.sound.channel_order import better_order
from core.perception.sound.locate import DEFAULT, whitened
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
from core.perception.sound.srp import FINER, Correlation
from core.perception.sound.tdoa import pair_lags
from core.sensors.microphones import MicrophoneArray, Sound

DEAD = 1e-5  # level of full scale, below which a channel is dead
FAINT = 0.05  # of the others' level
IDENTICAL = 0.99999  # correlation at lag 0
CLIPPED_SHARE = 1e-4  # of the samples in runs at the channel's limit
COHERENT = 0.25  # mean coherence that a microphone has with at least one other


@message
class ArrayFault:
    """One thing that is wrong, or worth knowing."""

    kind: str  # dead | faint | identical | same place | clipped | foreign | inverted | swapped | flat | line | short
    channels: tuple[int, ...]  # of the sound, counted from 0
    sentence: str
    serious: bool = True  # directions cannot be trusted; False: a limit that one should know


def check(
    sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> tuple[ArrayFault, ...]:
    """A sound with some speech in it → everything that looks wrong. Raises BadInput where they do not fit."""
    samples = array.heard(sound)
    try:
        seen = spectra(samples, sound.rate, settings)
    except BadInput as trouble:
        short = ArrayFault(kind="short", channels=array.channels, sentence=str(trouble), serious=False)
        return (*_geometry(array), short)
    faults = [*_geometry(array), *_levels(samples, array), *_clipped(samples, array), *_identical(samples, array)]
    if any(fault.serious for fault in faults) or array.dimensions < 2:
        return tuple(faults)
    return (*faults, *_together(seen, array, settings))


def _named(channels: Sequence[int]) -> str:
    words = [str(channel + 1) for channel in channels]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


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
        words = "All microphones lie in a line; a direction needs at least three that do not."
        faults.append(ArrayFault(kind="line", channels=array.channels, sentence=words))
    return faults


def _levels(samples: Array, array: MicrophoneArray) -> list[ArrayFault]:
    level = np.std(samples, axis=0)
    usual = float(np.median(level))
    faults: list[ArrayFault] = []
    for channel, here in zip(array.channels, level, strict=True):
        if here < DEAD:
            words = (
                f"Channel {channel + 1} is dead: it holds no sound. Is the microphone connected, the channel right?"
            )
            faults.append(ArrayFault(kind="dead", channels=(channel,), sentence=words))
        elif here < FAINT * usual:
            times = usual / here
            words = f"Channel {channel + 1} is {times:.0f} times fainter than the others; is its microphone covered?"
            faults.append(ArrayFault(kind="faint", channels=(channel,), sentence=words))
    return faults


def _clipped(samples: Array, array: MicrophoneArray) -> list[ArrayFault]:
    faults: list[ArrayFault] = []
    for channel, heard in zip(array.channels, samples.T, strict=True):
        limit = float(np.abs(heard).max())
        at_limit = np.abs(heard) >= 0.999 * limit
        runs = at_limit[2:] & at_limit[1:-1] & at_limit[:-2]
        if limit > 0.01 and np.mean(runs) > CLIPPED_SHARE:
            words = f"Channel {channel + 1} is clipped: {100 * np.mean(at_limit):.1f} % at its limit. Lower the gain."
            faults.append(ArrayFault(kind="clipped", channels=(channel,), sentence=words))
    return faults


def _identical(samples: Array, array: MicrophoneArray) -> list[ArrayFault]:
    """Channels that carry one microphone twice, whatever their gains."""
    centred = samples - samples.mean(0)
    size = np.linalg.norm(centred, axis=0)
    alike = np.abs(centred.T @ centred) > IDENTICAL * np.outer(size, size)
    left = [number for number in range(len(size)) if size[number] > DEAD]
    faults: list[ArrayFault] = []
    while left:
        group = [number for number in left if alike[left[0], number]]
        left = [number for number in left if number not in group]
        if len(group) > 1:
            channels = tuple(array.channels[number] for number in group)
            words = f"Channels {_named(channels)} are identical: one microphone is recorded more than once."
            faults.append(ArrayFault(kind="identical", channels=channels, sentence=words))
    return faults


def _together(seen: Spectra, array: MicrophoneArray, settings: DirectionFindingSettings) -> list[ArrayFault]:
    """Faults that only the channels together show: a foreign one, one with its wires crossed, two exchanged."""
    noise = noise_of(seen, quiet_frames(seen, settings), settings)
    cross = cross_spectra(seen, cell_weights(over_noise(seen, noise), seen, settings), noise)
    foreign = _foreign(cross, array)
    if foreign:
        return foreign
    correlation = whitened(cross, seen, array, settings)
    inverted = _inverted(correlation, array)
    if inverted:
        return inverted
    return _swapped(correlation, array)


def _foreign(cross: Array, array: MicrophoneArray) -> list[ArrayFault]:
    """Channels that share no sound with any other: a playback or a processed channel."""
    power = np.real(np.diagonal(cross, axis1=1, axis2=2))
    power = np.maximum(power, 1e-12 * power.max() + 1e-150)
    smooth = np.abs(cross.sum(0)) / np.sqrt(np.outer(power.sum(0), power.sum(0)))
    fine = np.mean(np.abs(cross) / np.sqrt(power[:, :, None] * power[:, None, :]), axis=0)
    shared = np.maximum(smooth, np.minimum(fine, 1.0)) * (1 - np.eye(len(smooth)))
    faults: list[ArrayFault] = []
    for channel, most in zip(array.channels, shared.max(1), strict=True):
        if most < COHERENT:
            words = f"Channel {channel + 1} shares no sound with the others; is it a playback or processed channel?"
            faults.append(ArrayFault(kind="foreign", channels=(channel,), sentence=words))
    return faults


def _inverted(correlation: Correlation, array: MicrophoneArray) -> list[ArrayFault]:
    """Channels of opposite sign: their correlations with most others have a deep valley where a top belongs."""
    tables = correlation.tables()
    reach = np.linalg.norm(array.baselines, axis=1) / array.speed * correlation.rate * FINER
    lags = np.minimum(np.arange(len(tables)), len(tables) - np.arange(len(tables)))
    inside = lags[:, None] <= reach + FINER
    top = np.where(inside, tables, -np.inf).max(0)
    valley = np.where(inside, -tables, -np.inf).max(0)
    count = len(array.positions)
    opposite = np.zeros((count, count))
    first, second = array.pairs.T
    opposite[first, second] = opposite[second, first] = np.where(valley > 1.3 * top, 1.0, 0.0)
    wrong = [number for number in range(count) if opposite[number].sum() > (count - 1) / 2]
    return [
        ArrayFault(
            kind="inverted",
            channels=(array.channels[number],),
            sentence=f"Channel {array.channels[number] + 1} has its wires crossed: it swings against all others.",
        )
        for number in wrong[:1]
    ]


def _swapped(correlation: Correlation, array: MicrophoneArray) -> list[ArrayFault]:
    """Another order of the channels that fits one talker much better."""
    order = better_order(correlation, array, pair_lags(correlation, array))
    if order is None:
        return []
    moved = tuple(array.channels[number] for number in range(len(order)) if order[number] != number)
    words = (
        f"Channels {_named(moved)} seem to be exchanged: no direction fits this order. "
        "Find the order with two utterances from known directions."
    )
    return [ArrayFault(kind="swapped", channels=moved, sentence=words)]
