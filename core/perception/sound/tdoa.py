"""Time differences of arrival (TDOA): the peak of a generalized cross-correlation (GCC-PHAT), between samples, within
what the array allows.
"""

from __future__ import annotations

import numpy as np

from core.message import Array
from core.perception.sound.srp import FINER, Correlation
from core.sensors.microphones import MicrophoneArray

SLACK = 0.5  # [samples] beyond the way between two microphones that a peak may lie


def pair_lags(correlation: Correlation, array: MicrophoneArray) -> Array:
    """Lead [s] of microphone j over i of each pair, (P,) (eq. 36 with limits and a parabola through the top)."""
    tables = correlation.tables()
    length, count = tables.shape
    reach = np.linalg.norm(array.baselines, axis=1) / array.speed * correlation.rate
    lags = np.arange(-(length // 2), length // 2)
    allowed = np.abs(lags)[:, None] <= (reach + SLACK) * FINER
    shifted = np.where(allowed, np.roll(tables, length // 2, axis=0), -np.inf)
    top = np.argmax(shifted, axis=0)
    pair = np.arange(count)
    place = (top + length - length // 2) % length
    before, here, after = tables[(place - 1) % length, pair], tables[place, pair], tables[(place + 1) % length, pair]
    bend = before - 2 * here + after
    shift = np.where(bend < 0, (before - after) / np.where(bend < 0, 2 * bend, 1.0), 0.0)
    best = (lags[top] + np.clip(shift, -1, 1)) / FINER
    return np.clip(best, -reach, reach) / correlation.rate
