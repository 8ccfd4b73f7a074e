"""What surprises have been usual of late: whether it is the sightings that err, or the filter."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

FEWEST = 5  # sightings before anything is said of what is usual
MEDIAN = 2 * math.log(2)  # of a squared distance in two dimensions, when all is as it should be


class Usual:
    """The median of the latest squared distances between sightings and what was expected.

    A soft gate trusts what surprises less. But when most sightings surprise, it is not they that are wrong, and a
    filter that went on distrusting them would lock itself out at the end of a long loop. Where a scan has several
    sightings they tell that by themselves; this is for those with one or two.
    """

    def __init__(self, memory: int, slack: float) -> None:
        """`memory`: sightings; `slack`: times what the filter promises that counts as usual."""
        self._lately: deque[float] = deque(maxlen=memory)
        self._promised = slack * MEDIAN

    @property
    def factor(self) -> float:
        """How much wider the soft gate stands at present, 1: not at all."""
        if len(self._lately) < FEWEST:
            return 1.0
        return max(1.0, float(np.median(self._lately)) / self._promised)

    def note(self, distances: list[float]) -> None:
        """Squared distances of the newest sightings."""
        self._lately.extend(distances)
