"""The followed person's looks, and by them whose legs are theirs after people came close to each other."""

import math
from collections import deque

import numpy as np

from core.message import Array
from core.perception.people.appearance import Appearance, likelihood_ratio

NEAR_LEGS_M = 0.6  # between the person and other legs, within which a picture may show either of them
DOUBT_TIME_S = 4.0  # after that, in which the person may be on the legs of another
SURE_RATIO = 1.0  # log likelihood ratio of looks from which people elsewhere may be the person …
RATIO_MARGIN = 1.5  # … if it is so much larger than at the place where the person was thought to be
MIN_SIGHTS = 2  # pictures in a row that show the person at other legs until those are theirs
MAX_SIGHTS, SIGHT_PERIOD_S = 25, 0.2  # that are remembered, and between them: five seconds of undoubted following
SETTLED_SIGHTS = 8  # of them, from which on who looks different is a stranger
PART_SIGHTS = 3  # of a part of the body, from which it counts; one picture may have shown a wall


class Identity:
    """One person's looks since they were locked on: the median of what was seen while nobody else was meant."""

    def __init__(self, least: float) -> None:
        """`least`: the probability by looks alone below which it is not the person."""
        self.least = math.log(least / (1 - least)) if 0 < least < 1 else math.copysign(math.inf, least - 0.5)
        self._sights: deque[Appearance] = deque(maxlen=MAX_SIGHTS)
        self._looks: Appearance | None = None
        self._learned = self._doubted = -math.inf  # [s]

    @property
    def is_settled(self) -> bool:
        """Return whether the looks are known well enough to call a person a stranger."""
        return len(self._sights) >= SETTLED_SIGHTS

    def ratio(self, seen: Appearance | None) -> float:
        """Log likelihood ratio that these are the person's looks; 0 where nothing can be compared."""
        return 0.0 if self._looks is None or seen is None else likelihood_ratio(self._looks, seen)

    def is_strange(self, seen: Appearance | None) -> bool:
        """Return whether these are another's looks."""
        return self.ratio(seen) < self.least

    def doubt(self, stamp: float) -> None:
        """Note that whose legs are whose is not sure now."""
        self._doubted = stamp

    def is_doubtful(self, stamp: float) -> bool:
        """Return whether the person's legs may be another's."""
        return stamp - self._doubted < DOUBT_TIME_S

    def learn(self, seen: Appearance | None, stamp: float) -> None:
        """Learn looks that legs, followed without a doubt, show to be the person's."""
        if seen is None or stamp - self._learned < SIGHT_PERIOD_S or self.is_doubtful(stamp):
            return
        if self.is_settled and self.is_strange(seen):
            return
        self._learned = stamp
        self._sights.append(seen)
        self._looks = Appearance(
            colours=_typical(np.array([one.colours for one in self._sights])),
            proportions=_typical(np.array([one.proportions for one in self._sights])),
            height=float(_typical(np.array([[one.height] for one in self._sights]))[0]),
        )


def _typical(rows: Array) -> Array:
    """Median (…) of rows (N, …), each number by itself; NaN for what is known from too few of them."""
    known = np.isfinite(rows)
    enough = known.sum(axis=0) >= min(PART_SIGHTS, len(rows))
    return np.where(enough, np.ma.median(np.ma.masked_array(rows, ~known), axis=0).filled(np.nan), np.nan)
