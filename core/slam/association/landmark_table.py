"""The landmark table L = (x, y, h, m): how landmarks come to be believed, and cease to be (section 4.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from core.geometry import wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.setting import Meta, Section, ThresholdSet

GRAZE = math.radians(15)  # within the rim of its sector a corner's wall is seen too flat
SURE_RANGE_SHARE = 0.7  # of the range from which a corner was ever made out: from here it should be again
ON_WALLS = ("rise", "fall")  # kinds of edges that only the camera sees, in its field
STEADY_HITS = 20  # hits after which the opening is averaged no further


@dataclass(frozen=True)
class LandmarkThresholds(ThresholdSet):
    """When a landmark is tentative, left behind, or another one."""

    at_once: int = 6  # with fewer landmarks one hit is enough: else it runs blind
    patience: int = 30  # [scans] time without a hit that a tentative landmark survives
    misses_share: float = 0.5  # misses that one hit makes up for
    behind: float = 5.0  # way per range at which a landmark was seen, after which it is left behind
    opening: float = math.radians(40)  # [rad] difference of a corner's openings in two sightings, at most
    most_on_walls: int = 80  # edges on walls among them


@dataclass(frozen=True)
class LandmarkSettings(LandmarkThresholds, Section):
    """Conditions under which a landmark is believed and dropped.

    Watch:
        probation: landmarks where nothing stands (then raise it)
        misses: landmarks that stay after what they were is gone (then lower it)
        most: time of an update in Plots
    """

    probation: Annotated[int, Meta("", 1, 50, "hits before a landmark may correct the pose")] = 3
    misses: Annotated[float, Meta("", 0, 1000, "a landmark is dropped when m > misses + misses_share · h")] = 2.0
    most: Annotated[int, Meta("", 10, 2000, "landmarks in all")] = 1000


@dataclass
class LandmarkRecord:
    """One row: everything about a landmark but its place, which the filter has."""

    id: int
    kind: str
    opening: float | None  # [rad] world
    sector: float  # [rad]
    farthest: float  # [m] from which it was seen
    hits: int = 1
    misses: int = 0
    unseen: int = 0  # scans since the last hit
    born: float = 0.0  # [m] that the robot had driven when it was seen first
    seen: float = 0.0  # [m] ... and last
    met_again: bool = False  # seen again after it had been left behind
    tentative: bool = True
    identity: int | None = None  # given by who knows it (experiments)


class LandmarkTable:
    """The rows, in the order of the filter's landmarks."""

    def __init__(self, settings: LandmarkSettings | None = None) -> None:
        self.settings = settings or LandmarkSettings()
        self.rows: list[LandmarkRecord] = []
        self.travelled = 0.0  # [m] that the robot has driven
        self._next = 1
        self._distinct: set[frozenset[int]] = set()

    def resume(self, rows: list[LandmarkRecord]) -> None:
        """Go on with these rows, of a map that was saved."""
        self.rows = rows
        self.travelled = max((row.seen for row in rows), default=0.0)
        self._next = 1 + max((row.id for row in rows), default=0)

    @property
    def believed(self) -> int:
        """Number of landmarks past their probation."""
        return sum(not row.tentative for row in self.rows)

    @property
    def corners(self) -> int:
        """Number of landmarks that are not edges on walls."""
        return sum(row.kind not in ON_WALLS for row in self.rows)

    def stands(self, row: LandmarkRecord) -> bool:
        """Return whether a landmark belongs in the map: past its probation, or let off it and not doubted since.

        What was believed at once and then seen no more may have been nothing. It stays with the filter all the same,
        as the start of the map may hang on it.
        """
        unconfirmed = row.identity is None and row.hits < self.settings.probation
        return not row.tentative and not (unconfirmed and row.unseen > self.settings.patience)

    def alike(self, sightings: tuple[Sighting, ...], heading: float) -> Array:
        """Sightings, robot's heading → (M, N) bool: whether each can be that landmark by its kind and opening."""
        kinds = np.array([row.kind for row in self.rows])
        seen = np.array([sighting.kind for sighting in sightings])[:, None]
        same = (kinds == seen) | (kinds == "") | (seen == "")
        openings = np.array([math.nan if row.opening is None else row.opening for row in self.rows])
        shown = np.array([math.nan if s.opening is None else s.opening + heading for s in sightings])[:, None]
        differ = np.abs((shown - openings + np.pi) % (2 * np.pi) - np.pi) > self.settings.opening
        return same & ~differ

    def has_room(self, sighting: Sighting) -> bool:
        """Return whether a landmark of this kind may still join."""
        return sighting.kind not in ON_WALLS or len(self.rows) - self.corners < self.settings.most_on_walls

    def add(self, sighting: Sighting, heading: float) -> LandmarkRecord:
        """A new row, seen once."""
        row = LandmarkRecord(
            id=self._next,
            kind=sighting.kind,
            opening=None if sighting.opening is None else wrap(sighting.opening + heading),
            sector=sighting.sector,
            farthest=sighting.range,
            born=self.travelled,
            seen=self.travelled,
            identity=sighting.id,
        )
        row.tentative = sighting.id is None and self.believed >= self.settings.at_once
        self._next += 1
        self.rows.append(row)
        return row

    def hit(self, index: int, sighting: Sighting, heading: float) -> None:
        """Seen again."""
        row = self.rows[index]
        row.met_again = row.met_again or self._is_behind(row)
        row.hits, row.unseen, row.seen = row.hits + 1, 0, self.travelled
        row.farthest = max(row.farthest, sighting.range)
        if sighting.opening is not None and row.opening is not None:
            off = wrap(sighting.opening + heading - row.opening)
            row.opening = wrap(row.opening + off / min(row.hits, STEADY_HITS))
        if row.tentative and row.hits >= self.settings.probation:
            row.tentative = False

    @property
    def left_behind(self) -> Array:
        """(N,) bool: whether the robot has driven far since it saw each."""
        return np.array([self._is_behind(row) for row in self.rows], dtype=bool)

    def is_new(self, index: int) -> bool:
        """Return whether the landmark is believed and was never left behind, and has no given identity."""
        row = self.rows[index]
        return not (row.tentative or row.met_again or self._is_behind(row)) and row.identity is None

    def _is_behind(self, row: LandmarkRecord) -> bool:
        return self.travelled - row.seen > self.settings.behind * row.farthest

    def expected(self, index: int, reach: float, bearing: float) -> bool:
        """Return whether a corner should be visible from `reach` [m] away, at the robot's `bearing` [rad] from it."""
        row = self.rows[index]
        if row.kind in ON_WALLS or reach > SURE_RANGE_SHARE * row.farthest:
            return False
        return row.opening is None or abs(wrap(bearing - row.opening)) < row.sector - GRAZE

    def is_lost(self, index: int) -> bool:
        """Return whether the landmark has been missed too often, or waited too long to be seen again."""
        row, limits = self.rows[index], self.settings
        if row.tentative and row.unseen > limits.patience:
            return True
        return row.misses > limits.misses + limits.misses_share * row.hits

    def part(self, a: int, b: int) -> None:
        """Note that two landmarks were seen at once: they are never doubles."""
        self._distinct.add(frozenset((self.rows[a].id, self.rows[b].id)))

    def may_be_doubles(self, a: int, b: int) -> bool:
        """Return whether two landmarks can be one: alike, and never seen at once."""
        first, second = self.rows[a], self.rows[b]
        if first.tentative or second.tentative or (first.kind and second.kind and first.kind != second.kind):
            return False
        if frozenset((first.id, second.id)) in self._distinct:
            return False
        if first.opening is None or second.opening is None:
            return True
        return abs(wrap(first.opening - second.opening)) < self.settings.opening

    def join(self, a: int, b: int) -> None:
        """Row `b` becomes part of row `a`."""
        kept, gone = self.rows[a], self.rows[b]
        kept.hits, kept.misses = kept.hits + gone.hits, min(kept.misses, gone.misses)
        kept.farthest = max(kept.farthest, gone.farthest)
        kept.seen, kept.unseen = max(kept.seen, gone.seen), min(kept.unseen, gone.unseen)
        kept.met_again = kept.met_again or kept.born != gone.born
        self.forget(b)

    def forget(self, index: int) -> None:
        """Row `index` goes."""
        gone = self.rows.pop(index).id
        self._distinct = {pair for pair in self._distinct if gone not in pair}
