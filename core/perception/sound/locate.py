"""Sound → direction: the method that works in rooms and next to a fan."""

import math

import numpy as np

from core.errors import BadInput
from core.message import Array
from core.perception.sound.direction import Direction
from core.perception.sound.least_squares import axes_of, fit_lags, lift, mirrored, on_sphere, placement
from core.perception.sound.paper import locate_as_printed
from core.perception.sound.plane_wave import PlaneWaveFit
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
from core.perception.sound.srp import Correlation, Peak, find_peak, grid_of
from core.perception.sound.tdoa import fit_plane_wave, pair_lags
from core.sensors.microphones import MicrophoneArray, Sound

DEFAULT = DirectionFindingSettings()
FEWEST_CELLS = 6.0  # weight of all fresh cells together, below which nothing was heard


def locate(
    sound: Sound,
    array: MicrophoneArray,
    *,
    speech_from: float | None = None,
    settings: DirectionFindingSettings = DEFAULT,
) -> Direction | None:
    """Locate the one talker of a sound; None when nothing fresh was heard.

    What precedes `speech_from` [s, the sound's clock] is taken for noise; without it, the quietest frames are.
    Raises BadInput when the sound does not fit the array, or its microphones lie in a line.
    """
    axes_of(array)
    if settings.form == "paper":
        end = sound.stamp + sound.duration
        return locate_as_printed(sound if speech_from is None else sound.part(speech_from, end), array)
    seen = spectra(array.heard(sound), sound.rate, settings)
    begin = None if speech_from is None else speech_from - sound.stamp
    noise = noise_of(seen, quiet_frames(seen, settings, begin), settings)
    fresh = cell_weights(over_noise(seen, noise), seen, settings)
    return direction_of(seen, fresh, noise, array, sound.stamp, settings)


def direction_of(
    seen: Spectra,
    fresh: Array,
    noise: Noise,
    array: MicrophoneArray,
    stamp: float,
    settings: DirectionFindingSettings,
) -> Direction | None:
    """Spectra and how much each cell counts (K, T) → a direction; None when too little counts."""
    amount = fresh.sum(0)
    if amount.sum() < FEWEST_CELLS:
        return None
    correlation = whitened(cross_spectra(seen, fresh, noise), seen, array, settings)
    if not correlation.total > 0:
        return None
    grid = grid_of(array, seen.rate, seen.size, settings.grid)
    lags = pair_lags(correlation, array)
    peak = find_peak(correlation, array, grid, _seeds(lags, array), settings.bands)
    steered = array.baselines @ axes_of(array).T / array.speed @ peak.within
    fit = fit_plane_wave(correlation, array, np.stack((steered, lags)), noise, settings.bands)
    return _declared(peak, fit, array, stamp + float(amount @ seen.times / amount.sum()), settings)


def whitened(cross: Array, seen: Spectra, array: MicrophoneArray, settings: DirectionFindingSettings) -> Correlation:
    """Cross spectra (K, M, M) → those of the pairs with their powers levelled, |G| to |G|^(1 - whitening)."""
    first, second = array.pairs.T
    pairs = cross[:, first, second]
    size = np.abs(pairs)
    return Correlation(
        values=pairs / np.maximum(size, 1e-12 * size.max() + 1e-300) ** settings.whitening,
        omega=2 * np.pi * seen.frequencies,
        size=seen.size,
        rate=seen.rate,
    )


def _seeds(lags: Array, array: MicrophoneArray) -> Array:
    """The robust least-squares direction of all pairs' lags (P,) [s], as a place to begin, (S, D)."""
    axes = axes_of(array)
    try:
        fit = fit_lags(array, array.pairs, lags)
    except BadInput:
        return np.zeros((0, len(axes)))
    return (fit.towards @ axes.T)[None]


def _declared(
    peak: Peak, fit: PlaneWaveFit, array: MicrophoneArray, stamp: float, settings: DirectionFindingSettings
) -> Direction:
    """The peak as a direction, with everything that makes it uncertain."""
    axes = axes_of(array)
    towards = lift(array, axes, peak.within)
    strength = min(1.0, max(0.0, peak.power))
    within = settings.spread**2 * peak.covariance + placement(array, axes)
    within += np.diag(fit.excess / array.axes[1][: len(axes)] ** 2)  # by least squares
    leaning = math.hypot(settings.speed_sd, settings.lean_sd * (1 - strength))
    on = on_sphere(array, axes, towards, within, leaning)
    least = settings.floor**2 + (settings.echo_sd * (1 - strength)) ** 2
    return Direction(
        stamp=stamp,
        towards=towards,
        covariance=on + least * np.eye(2),
        strength=strength,
        mirror=mirrored(array, towards),
        fit=fit,
    )


def sure(direction: Direction, settings: DirectionFindingSettings = DEFAULT) -> bool:
    """Return whether a direction is good enough to act on; the printed form knows no strength to judge it by."""
    strong = settings.form == "paper" or direction.strength >= settings.declared_strength
    agreed = direction.misfit <= settings.declared_misfit
    return strong and agreed and direction.azimuth_sd <= settings.declared_sd
