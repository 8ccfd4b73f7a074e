"""How loud running sound is beside its own quiet moments: where nothing rises out of them, nobody speaks."""

from collections import deque

import numpy as np

from core.message import Array
from core.speech.settings import RATE_HZ

BLOCK_S = 0.05  # over which loudness is computed
LEVEL_MEMORY_S = 10.0  # in which the quietest blocks are sought
SILENT_POWER = 1e-8  # power that counts as silence whatever the noise


class Loudness:
    """Levels of the newest sound, block by block."""

    def __init__(self) -> None:
        self._levels: deque[float] = deque(maxlen=round(LEVEL_MEMORY_S / BLOCK_S))  # [dB]
        self._rest = np.zeros(0)

    def add(self, samples: Array) -> None:
        """Take in the next samples (N,)."""
        size = round(BLOCK_S * RATE_HZ)
        whole = np.concatenate((self._rest, samples))
        count = len(whole) // size
        self._rest = whole[count * size :]
        blocks = whole[: count * size].reshape(count, size)
        self._levels.extend((10 * np.log10(np.mean(blocks**2, axis=1) + SILENT_POWER)).tolist())

    def rise(self, seconds: float) -> float:
        """Return by how much [dB] the loudest block of the last `seconds` exceeds the quietest tenth of all."""
        if not self._levels:
            return 0.0
        levels = np.array(self._levels)
        return float(levels[-max(round(seconds / BLOCK_S), 1) :].max() - np.quantile(levels, 0.1))
