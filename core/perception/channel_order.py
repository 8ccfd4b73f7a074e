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
from core.message import Array, message
from core.perception.sound.direction import sphere, unit
from core.perception.sound.least_squares import axes_of
from core.perception.sound.locate import DEFAULT, whitened
from core.perception.sound.settings import HearingSettings
from core.perception.sound.spectra import cross_spectra, freshness, noise_of, quiet_frames, spectra, strangeness
from core.perception.sound.steered import FINER, Correlation
from core.sensors.microphones import MicrophoneArray, Sound

MOST = 6  # channels, of which all orders are tried
UNSURE = math.radians(8)  # [rad] by which a person stands beside the direction that they were asked for
ELEVATIONS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # [rad] of a mouth above the array
CLEAR = 1.005  # by which the best order must beat the next
PLAUSIBLE = 1.1  # by which another order must beat the given one, to doubt it without known directions


@message
class Order:
    """The channels in the order of the array's positions."""

    channels: tuple[int, ...]
    margin: float  # of the best order over the next best; 1: as good
    certain: bool
    sentence: str


def find_order(
    utterances: Sequence[tuple[Sound, float]], array: MicrophoneArray, settings: HearingSettings = DEFAULT
) -> Order:
    """Sounds and the azimuths [rad] they came from → the order of the array's channels. Raises BadInput."""
    count = len(array.positions)
    if not utterances:
        raise BadInput("The order of channels needs utterances from known directions; two are best.")
    if count > MOST:
        raise BadInput(f"Orders of at most {MOST} channels can be tried; this array has {count}.")
    axes_of(array)
    orders = np.array(list(itertools.permutations(range(count))))
    scores = np.zeros(len(orders))
    for sound, azimuth in utterances:
        towards = np.array(
            [
                unit(azimuth + aside, up)
                for aside in (-UNSURE, -UNSURE / 2, 0, UNSURE / 2, UNSURE)
                for up in ELEVATIONS
            ]
        )
        correlation = correlation_of(sound, array, settings)
        scores += _agreements(correlation, array, orders, towards).max(1) / max(correlation.total, 1e-300)
    ranking = np.argsort(-scores)
    best, margin = orders[ranking[0]], float(scores[ranking[0]] / max(scores[ranking[1]], 1e-300))
    channels = tuple(array.channels[number] for number in best)
    certain = margin > CLEAR and len(utterances) > 1
    words = f"The channels are {', '.join(str(channel + 1) for channel in channels)}, counted from 1."
    if not certain:
        words += " Another order fits nearly as well; say it once more from another side."
    return Order(channels=channels, margin=margin, certain=certain, sentence=words)


def correlation_of(sound: Sound, array: MicrophoneArray, settings: HearingSettings) -> Correlation:
    """The whitened correlations of a sound's fresh cells, noise from its quietest frames."""
    seen = spectra(array.heard(sound), sound.rate, settings)
    noise = noise_of(seen, quiet_frames(seen, settings), settings)
    return whitened(
        cross_spectra(seen, freshness(strangeness(seen, noise), seen, settings), noise), seen, array, settings
    )


def _agreements(correlation: Correlation, array: MicrophoneArray, orders: Array, towards: Array) -> Array:
    """Steered power (O, G) of every order (O, M) in every direction (G, 3)."""
    tables = correlation.tables()
    count = len(array.positions)
    number = np.zeros((count, count), int)
    first, second = array.pairs.T
    number[first, second] = number[second, first] = np.arange(len(first))
    lead = towards @ (array.baselines / array.speed * correlation.rate * FINER).T  # (G, P) [steps]
    power = np.zeros((len(orders), len(towards)))
    for pair, (i, j) in enumerate(array.pairs):
        one, other = orders[:, i], orders[:, j]
        turned = np.where(one < other, 1, -1)  # a table read from the other side
        places = np.round(turned[:, None] * lead[:, pair]).astype(int) % len(tables)
        power += tables[places, number[one, other][:, None]]
    return power


def better_order(correlation: Correlation, array: MicrophoneArray, lags: Array) -> tuple[int, ...] | None:
    """An order that fits one talker anywhere much better than the given one; None when the given one is plausible.

    Orders that only turn or mirror the array fit equally well and are not found. `lags` (P,) [s] must not all be 0.
    """
    count = len(array.positions)
    if not 4 <= count <= MOST or not np.any(lags):
        return None
    grid = sphere(300)
    grid = grid if array.dimensions == 3 else grid[grid @ array.normal >= 0]
    orders = np.array(list(itertools.permutations(range(count))))
    scores = _agreements(correlation, array, orders, grid).max(1)
    best = int(np.argmax(scores))
    if scores[best] < PLAUSIBLE * max(float(scores[0]), 1e-300):
        return None
    closest = np.nonzero(scores > 0.98 * scores[best])[0]
    moved = [int(np.count_nonzero(orders[one] != np.arange(count))) for one in closest]
    return tuple(int(channel) for channel in orders[closest[int(np.argmin(moved))]])
