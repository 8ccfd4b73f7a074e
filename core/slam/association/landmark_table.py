"""The landmark table L = (x, y, h, m): how landmarks come to be believed, and cease to be (section 4.1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from typing import Annotated, Any

import numpy as np

from core.geometry import wrap, wrap_all
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.setting import Meta, Section

GRAZING_ANGLE_RAD = math.radians(15)  # within the rim of its sector a corner's wall is seen too flat
SURE_RANGE_SHARE = 0.7  # of the range from which a corner was ever made out: from here it should be again
ON_WALLS = ("rise", "fall")  # kinds of edges that only the camera sees, in its field
STEADY_HITS = 20  # hits after which the opening is averaged no further


@dataclass(frozen=True)
class LandmarkSettings(Section):
    """Conditions under which a landmark is believed and dropped.

    Watch:
        probation: landmarks where nothing stands (then raise it)
        misses: landmarks that stay after what they were is gone (then lower it)
        most: time of an update in SLAM
    """

    at_once: int = 6  # with fewer landmarks one hit is enough: else it runs blind
    patience: int = 30  # [scans] time without a hit that a tentative landmark survives
    misses_share: float = 0.5  # misses that one hit makes up for
    behind: float = 5.0  # way per range at which a landmark was seen, after which it is left behind
    opening: float = math.radians(40)  # [rad] difference of a corner's openings in two sightings, at most
    most_on_walls: int = 80  # edges on walls among them
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


NO_IDENTITY = np.iinfo(np.int64).min
COLUMN_TYPES = {"int": np.int64, "str": np.int64, "float": np.float64, "bool": np.bool_}
COLUMNS = np.dtype(
    [(one.name, COLUMN_TYPES[str(one.type).removesuffix(" | None")]) for one in fields(LandmarkRecord)]
)
"""A record's fields: the kind by its number, NaN for no opening, NO_IDENTITY for none."""
HIT_COLUMNS = ["id", "opening", "farthest", "hits", "seen", "tentative"]  # what a further sighting needs to know


class LandmarkTable:
    """The rows, in the order of the filter's landmarks, kept by columns: what asks for all of them is one step."""

    def __init__(self, settings: LandmarkSettings | None = None) -> None:
        self.settings = settings or LandmarkSettings()
        self.travelled = 0.0  # [m] that the robot has driven
        self._rows: np.ndarray[Any, Any] = np.zeros(0, COLUMNS)
        self._kinds = ["", *ON_WALLS]  # their numbers are their places here
        self._next = 1
        self._distinct: set[frozenset[int]] = set()

    def __len__(self) -> int:
        return len(self._rows)

    def resume(self, records: Sequence[LandmarkRecord]) -> None:
        """Go on with these rows, of a map that was saved."""
        self._rows = np.array([self._columns(record) for record in records], COLUMNS)
        self.travelled = max((record.seen for record in records), default=0.0)
        self._next = 1 + max((record.id for record in records), default=0)

    @property
    def records(self) -> list[LandmarkRecord]:
        """The rows one by one, to be saved."""
        return [self._record(*row) for row in self._rows.tolist()]

    @property
    def believed(self) -> Array:
        """(N,) bool: whether each is past its probation."""
        return ~self._rows["tentative"]

    @property
    def corners(self) -> int:
        """Number of landmarks that are not edges on walls."""
        return len(self._rows) - int(self._on_walls.sum())

    @property
    def standing(self) -> Array:
        """(N,) bool: whether each belongs in the map: past its probation, or let off it and not doubted since.

        What was believed at once and then seen no more may have been nothing. It stays with the filter all the same,
        as the start of the map may hang on it.
        """
        rows, limits = self._rows, self.settings
        unconfirmed = (rows["identity"] == NO_IDENTITY) & (rows["hits"] < limits.probation)
        return ~rows["tentative"] & ~(unconfirmed & (rows["unseen"] > limits.patience))

    def alike(self, sightings: tuple[Sighting, ...], heading: float) -> Array:
        """Sightings, robot's heading → (M, N) bool: whether each can be that landmark by its kind and opening."""
        kinds, seen = self._rows["kind"], np.array([self._number_of(s.kind) for s in sightings])[:, None]
        same = (kinds == seen) | (kinds == 0) | (seen == 0)
        shown = np.array([math.nan if s.opening is None else s.opening + heading for s in sightings])[:, None]
        differ = np.cos(shown - self._rows["opening"]) < math.cos(self.settings.opening)
        return same & ~differ

    def has_room(self, sighting: Sighting) -> bool:
        """Return whether a landmark of this kind may still join."""
        return sighting.kind not in ON_WALLS or int(self._on_walls.sum()) < self.settings.most_on_walls

    def add(self, sighting: Sighting, heading: float) -> int:
        """A new row, seen once → its id."""
        record = LandmarkRecord(
            id=self._next,
            kind=sighting.kind,
            opening=None if sighting.opening is None else wrap(sighting.opening + heading),
            sector=sighting.sector,
            farthest=sighting.range,
            born=self.travelled,
            seen=self.travelled,
            identity=sighting.id,
            tentative=sighting.id is None and int(self.believed.sum()) >= self.settings.at_once,
        )
        self._next += 1
        self._rows = np.append(self._rows, np.array([self._columns(record)], COLUMNS))
        return record.id

    def hit(self, index: int, sighting: Sighting, heading: float) -> tuple[int, bool]:
        """Seen again → its id, and whether it is past its probation."""
        rows = self._rows
        number, opening, farthest, hits, seen, tentative = rows[index][HIT_COLUMNS].item()
        hits += 1
        if not rows["met_again"][index]:
            rows["met_again"][index] = self.travelled - seen > self.settings.behind * farthest
        rows["hits"][index], rows["unseen"][index], rows["seen"][index] = hits, 0, self.travelled
        rows["farthest"][index] = max(farthest, sighting.range)
        if sighting.opening is not None and not math.isnan(opening):
            off = wrap(sighting.opening + heading - opening)
            rows["opening"][index] = wrap(opening + off / min(hits, STEADY_HITS))
        if tentative and hits >= self.settings.probation:
            rows["tentative"][index] = tentative = False
        return number, not tentative

    def hits(self, index: int) -> int:
        """Return how often a landmark was seen."""
        return int(self._rows["hits"][index])

    def pass_over(self, indices: Array) -> None:
        """Landmarks (K,) were not seen in this scan."""
        self._rows["unseen"][indices] += 1

    def miss(self, indices: Array) -> None:
        """Landmarks (K,) were not seen where they should have been."""
        self._rows["misses"][indices] += 1

    @property
    def left_behind(self) -> Array:
        """(N,) bool: whether the robot has driven far since it saw each."""
        return self._is_behind(self._rows)

    @property
    def new(self) -> Array:
        """(N,) bool: whether each is believed and was never left behind, and has no given identity."""
        rows = self._rows
        return ~(rows["tentative"] | rows["met_again"] | self._is_behind(rows)) & (rows["identity"] == NO_IDENTITY)

    @property
    def identities(self) -> dict[int, int]:
        """Given identity → index of its row."""
        return {one: index for index, one in enumerate(self._rows["identity"].tolist()) if one != NO_IDENTITY}

    def expected(self, indices: Array, reaches: Array, bearings: Array) -> Array:
        """Return whether corners (K,) should be visible from `reaches` [m] away, at `bearings` [rad] from each."""
        rows = self._rows[indices]
        reachable = ~self._on_walls[indices] & (reaches <= SURE_RANGE_SHARE * rows["farthest"])
        off = np.abs(wrap_all(bearings - rows["opening"]))
        return reachable & (np.isnan(off) | (off < rows["sector"] - GRAZING_ANGLE_RAD))

    @property
    def lost(self) -> Array:
        """Indices of the landmarks that were missed too often, or waited too long to be seen again."""
        rows, limits = self._rows, self.settings
        waited = rows["tentative"] & (rows["unseen"] > limits.patience)
        return np.flatnonzero(waited | (rows["misses"] > limits.misses + limits.misses_share * rows["hits"]))

    def part(self, a: int, b: int) -> None:
        """Note that two landmarks were seen at once: they are never doubles."""
        self._distinct.add(self._pair(a, b))

    def may_be_doubles(self, a: int, b: int) -> bool:
        """Return whether two landmarks can be one: alike, and never seen at once."""
        first, second = self._rows[a], self._rows[b]
        if (
            first["tentative"]
            or second["tentative"]
            or (first["kind"] and second["kind"] and first["kind"] != second["kind"])
        ):
            return False
        if self._pair(a, b) in self._distinct:
            return False
        # none is known where it is NaN
        return not abs(wrap(float(first["opening"] - second["opening"]))) >= self.settings.opening

    def precedes(self, a: int, b: int) -> bool:
        """Return whether landmark `a` was seen last before `b` was seen first."""
        return bool(self._rows["seen"][a] < self._rows["born"][b])

    def join(self, a: int, b: int) -> None:
        """Row `b` becomes part of row `a`."""
        kept, gone = self._rows[a], self._rows[b]
        kept["hits"] += gone["hits"]
        for column, choose in (("misses", min), ("farthest", max), ("seen", max), ("unseen", min)):
            kept[column] = choose(kept[column], gone[column])
        kept["met_again"] |= kept["born"] != gone["born"]
        self.forget(b)

    def forget(self, index: int) -> None:
        """Row `index` goes."""
        gone = int(self._rows["id"][index])
        self._rows = np.delete(self._rows, index)
        self._distinct = {pair for pair in self._distinct if gone not in pair}

    @property
    def _on_walls(self) -> Array:
        kinds = self._rows["kind"]
        return (kinds > 0) & (kinds <= len(ON_WALLS))

    def _is_behind(self, rows: np.ndarray[Any, Any] | np.void) -> Any:
        return self.travelled - rows["seen"] > self.settings.behind * rows["farthest"]

    def _pair(self, a: int, b: int) -> frozenset[int]:
        return frozenset(self._rows["id"][[a, b]].tolist())

    def _number_of(self, kind: str) -> int:
        if kind not in self._kinds:
            self._kinds.append(kind)
        return self._kinds.index(kind)

    def _columns(self, record: LandmarkRecord) -> tuple[Any, ...]:
        _, _, opening, *between, identity = astuple(record)
        return (
            record.id,
            self._number_of(record.kind),
            math.nan if opening is None else opening,
            *between,
            NO_IDENTITY if identity is None else identity,
        )

    def _record(self, number: int, kind: int, opening: float, *others: Any) -> LandmarkRecord:
        *between, identity = others
        return LandmarkRecord(
            number,
            self._kinds[kind],
            None if math.isnan(opening) else opening,
            *between,
            identity=None if identity == NO_IDENTITY else identity,
        )
