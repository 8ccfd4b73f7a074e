"""Several talkers at once, by glimpses: voices seldom collide, so in most short moments only one is in front."""

from dataclasses import replace

import numpy as np

from core.message import Array, message
from core.perception.sound.direction import Direction
from core.perception.sound.least_squares import axes_of
from core.perception.sound.locate import DEFAULT, direction_of, locate, whitened
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import (
    Noise,
    Spectra,
    cell_weights,
    cross_spectra,
    noise_of,
    over_noise,
    quiet_frames,
    spectra,
)
from core.perception.sound.srp import grid_of
from core.sensors.microphones import MicrophoneArray, Sound

GLIMPSE_SD = 0.12  # standard deviation with which glimpses of one talker are taken to scatter
FEWEST_CELLS = 15.0  # weight of the fresh cells of a glimpse
MIN_GLIMPSES = 3  # glimpses of a talker


@message
class Glimpses:
    """Short moments and the direction in front in each."""

    within: Array  # (W, D) along the array's axes
    weights: Array  # (W,)
    first: Array  # (W,) the frame where each begins


def talkers(
    sound: Sound,
    array: MicrophoneArray,
    *,
    most: int = 2,
    speech_from: float | None = None,
    settings: DirectionFindingSettings = DEFAULT,
) -> tuple[Direction, ...]:
    """Up to `most` simultaneous talkers, strongest first. Arguments as of `locate`; raises BadInput likewise.

    The paper's form knows of one.
    """
    if settings.form == "paper":
        one = locate(sound, array, speech_from=speech_from, settings=settings)
        return () if one is None else (one,)
    seen = spectra(array.heard(sound), sound.rate, settings)
    begin = None if speech_from is None else speech_from - sound.stamp
    noise = noise_of(seen, quiet_frames(seen, settings, begin), settings)
    fresh = cell_weights(over_noise(seen, noise), seen, settings)
    return share_out(seen, fresh, noise, array, sound.stamp, settings, most)


def share_out(
    seen: Spectra,
    fresh: Array,
    noise: Noise,
    array: MicrophoneArray,
    stamp: float,
    settings: DirectionFindingSettings,
    most: int,
) -> tuple[Direction, ...]:
    """Spectra and how much each cell counts (K, T) → one direction per talker, each from their own moments."""
    seen_at = glimpses(seen, fresh, noise, array, settings)
    groups = gathered(seen_at, settings, most)
    found: list[Direction] = []
    for group in groups if len(groups) > 1 else ():
        own = np.zeros(len(seen.times), bool)
        for first in seen_at.first[group]:
            own[first : first + settings.glimpse] = True
        one = direction_of(seen, fresh * own, noise, array, stamp, settings)
        if one is not None and all(np.linalg.norm(one.towards - other.towards) > settings.apart for other in found):
            found.append(one)
    if not found:
        one = direction_of(seen, fresh, noise, array, stamp, settings)
        return () if one is None else (one,)
    return tuple(found)


def glimpses(
    seen: Spectra, fresh: Array, noise: Noise, array: MicrophoneArray, settings: DirectionFindingSettings
) -> Glimpses:
    """The direction in front in every short moment, on the grid; moments without a clear one are left out."""
    grid = grid_of(array, seen.rate, seen.size, settings.grid)
    within: list[Array] = []
    weights: list[float] = []
    begins: list[int] = []
    for first in range(0, len(seen.times) - settings.glimpse + 1, settings.glimpse // 2):
        part = slice(first, first + settings.glimpse)
        if fresh[:, part].sum() < FEWEST_CELLS:
            continue
        moment = replace(seen, values=seen.values[:, :, part], times=seen.times[part])
        correlation = whitened(cross_spectra(moment, fresh[:, part], noise), seen, array, settings)
        powers = grid.powers(correlation.tables())
        best = int(np.argmax(powers))
        strength = float(powers[best]) / max(correlation.total, 1e-300)
        if strength > settings.glimpse_strength:
            within.append(grid.within[best])
            weights.append(strength**4)
            begins.append(first)
    dimensions = len(axes_of(array))
    return Glimpses(
        within=np.array(within).reshape(-1, dimensions), weights=np.array(weights), first=np.array(begins, int)
    )


def gathered(seen_at: Glimpses, settings: DirectionFindingSettings, most: int) -> list[Array]:
    """Glimpses → up to `most` groups (indices), heaviest first; each is dense and apart from the others."""
    left = np.ones(len(seen_at.weights), bool)
    centres: list[Array] = []
    groups: list[Array] = []
    gaps = np.linalg.norm(seen_at.within[:, None] - seen_at.within, axis=2)
    near = np.exp(-((gaps / GLIMPSE_SD) ** 2) / 2)
    while len(groups) < most and left.any():
        top = int(np.argmax(np.where(left, near @ (seen_at.weights * left), -1.0)))
        group = np.nonzero(left & (gaps[top] < settings.apart))[0]
        left[group] = False
        if seen_at.weights[group].sum() < settings.share * seen_at.weights.sum() or len(group) < MIN_GLIMPSES:
            break
        centre = seen_at.within[top]
        if all(np.linalg.norm(centre - other) > settings.apart for other in centres):
            centres.append(centre)
            groups.append(group)
    return groups
