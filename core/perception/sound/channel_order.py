"""Which channel is which microphone: the order in which utterances from known directions make sense.

One utterance leaves mirror images of the array; two from different sides ("stand in front, then to the left") leave
one order. Every order of up to six channels is tried.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from core.errors import BadInput
from core.geometry import wrap_all
from core.message import Array, message
from core.perception.sound.direction import sphere
from core.perception.sound.least_squares import axes_of
from core.perception.sound.locate import DEFAULT, whitened
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import cell_weights, cross_spectra, noise_of, over_noise, quiet_frames, spectra
from core.perception.sound.srp import STEPS_PER_SAMPLE, Correlation
from core.sensors.microphones import MicrophoneArray, Sound

MAX_CHANNELS = 6  # channels, of which all orders are tried
STANDS = math.radians(6)  # [rad] how far a person stands from the asked direction, as a standard deviation
MOUTH_ELEVATION_RAD, MOUTH_SD = 0.3, 0.35  # [rad] elevation of a mouth above the array
SHARE_WEIGHT = 60.0  # of the share of sound that an order explains, against misses of the known directions
MIN_SCORE_MARGIN = 3.0  # by which the best order's score must exceed the next
GRID_DIRECTIONS = 1500  # directions over the sphere


@message
class ChannelOrder:
    """The channels in the order of the array's positions."""

    channels: tuple[int, ...]
    margin: float  # score of the best order above the next; as a difference of log-likelihoods
    certain: bool
    sentence: str


def find_order(
    utterances: Sequence[tuple[Sound, float]], array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> ChannelOrder:
    """Sounds and the azimuths [rad] they came from → the order of the array's channels. Raises BadInput."""
    count = len(array.positions)
    if not utterances:
        raise BadInput("The order of channels needs utterances from known directions; two are best.")
    if count > MAX_CHANNELS:
        raise BadInput(f"Orders of at most {MAX_CHANNELS} channels can be tried; this array has {count}.")
    axes_of(array)
    orders = np.array(list(itertools.permutations(range(count))))
    scores = np.zeros(len(orders))
    grid = _directions(array, GRID_DIRECTIONS)
    bearing, up = np.arctan2(grid[:, 1], grid[:, 0]), np.arcsin(np.clip(grid[:, 2], -1, 1))
    for sound, azimuth in utterances:
        correlation = correlation_of(sound, array, settings)
        share = _agreements(correlation, array, orders, grid) / max(correlation.total, 1e-300)
        top = share.argmax(1)
        missed = (wrap_all(bearing[top] - azimuth) / STANDS) ** 2 + ((up[top] - MOUTH_ELEVATION_RAD) / MOUTH_SD) ** 2
        scores += SHARE_WEIGHT * share.max(1) - missed / 2
    ranking = np.argsort(-scores)
    best, margin = orders[ranking[0]], float(scores[ranking[0]] - scores[ranking[1]])
    channels = tuple(array.channels[number] for number in best)
    certain = margin > MIN_SCORE_MARGIN and len(utterances) > 1
    words = f"The channels are {', '.join(str(channel + 1) for channel in channels)}, counted from 1."
    if not certain:
        words += " Another order fits nearly as well; say it once more from another side."
    return ChannelOrder(channels=channels, margin=margin, certain=certain, sentence=words)


def correlation_of(sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings) -> Correlation:
    """The whitened correlations of a sound's fresh cells, noise from its quietest frames."""
    seen = spectra(array.heard(sound), sound.rate, settings)
    noise = noise_of(seen, quiet_frames(seen, settings), settings)
    return whitened(
        cross_spectra(seen, cell_weights(over_noise(seen, noise), seen, settings), noise), seen, array, settings
    )


def _agreements(correlation: Correlation, array: MicrophoneArray, orders: Array, towards: Array) -> Array:
    """Steered power (O, G) of every order (O, M) in every direction (G, 3)."""
    tables = correlation.tables()
    count = len(array.positions)
    number = np.zeros((count, count), int)
    first, second = array.pairs.T
    number[first, second] = number[second, first] = np.arange(len(first))
    lead = towards @ (array.baselines / array.speed * correlation.rate * STEPS_PER_SAMPLE).T  # (G, P) [steps]
    power = np.zeros((len(orders), len(towards)))
    for pair, (i, j) in enumerate(array.pairs):
        one, other = orders[:, i], orders[:, j]
        turned = np.where(one < other, 1, -1)  # a table read from the other side
        places = np.round(turned[:, None] * lead[:, pair]).astype(int) % len(tables)
        power += tables[places, number[one, other][:, None]]
    return power


def _directions(array: MicrophoneArray, count: int) -> Array:
    """Directions (G, 3) over the sphere; of a flat array's, the half above its plane."""
    grid = sphere(count)
    return grid if array.dimensions == 3 else grid[grid @ array.normal >= 0]
