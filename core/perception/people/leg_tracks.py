"""Legs near the followed person that are not theirs: all have tracks, so that who crosses keeps their own legs.

The legs of a scan are shared out among the person and the others, the surest match first, no leg twice.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.people.camera_geometry import in_world
from core.perception.people.legs import LegCluster

MAX_LEGS_DISTANCE_M = 2.5  # from the person: farther away legs are nobody's
MIN_BODY_GAP_M = 0.3  # from legs that were shared out already: nearer ones are part of the same body
MISSED_COST = 7.0  # cost (squared distance and log determinant of its covariance) from which legs are another's
POSITION_SD, SPEED_SD = 0.1, 0.5  # [m], [m/s] of a new track
MAX_UNSEEN_S = 1.2  # without legs, after which a track ends
POSITION_GAIN, SPEED_GAIN = 0.5, 0.25  # of the alpha-beta filter
FIRM_SCANS = 3  # scans from which a track counts
MIN_WALKED_M = 0.25  # from which legs are a person's: furniture stands
MAX_LEGS_AGE_S = 0.4  # since legs were seen, for which a picture can show who stands on them
LOOK_REACH_M = 2.0  # from the person: who is farther away is not looked at
MAX_LOOKED_AT = 3  # of those that are looked at, the nearest


@dataclass(eq=False)
class LegTrack:
    """A person or something else that stands like legs."""

    place: Array  # (2,) [m] world
    velocity: Array  # (2,) [m/s]
    stamp: float  # [s] of the place
    measured: float  # [s]
    age: int = 1  # scans in which it was seen
    walked: float = 0.0  # [m] at most, away from where it began
    sights: int = 0  # pictures in a row that showed the followed person here
    is_stranger: bool = False  # the newest picture of who stands here showed another's looks

    def __post_init__(self) -> None:
        self._began, self.since = self.place, self.stamp

    @property
    def speed(self) -> float:
        """[m/s]."""
        return float(np.hypot(*self.velocity))

    def predicted(self, stamp: float) -> tuple[Array, Array]:
        """Predict the place (2,) at `stamp`, and the covariance (2, 2) [m²]."""
        passed = stamp - self.stamp
        speed = SPEED_SD if self.age < FIRM_SCANS else 0.5 * SPEED_SD
        hidden = stamp - self.measured
        sd = np.hypot(POSITION_SD, speed * hidden)
        return self.place + passed * self.velocity, sd**2 * np.eye(2)

    def take(self, place: Array, stamp: float) -> None:
        """Correct by legs that were seen (alpha-beta filter)."""
        passed = max(stamp - self.stamp, 1e-3)
        expected = self.place + passed * self.velocity
        off = place - expected
        self.place = expected + POSITION_GAIN * off
        self.velocity = self.velocity + SPEED_GAIN * off / max(passed, 0.05)
        self.stamp = self.measured = stamp
        self.age += 1
        self.walked = max(self.walked, float(np.hypot(*(self.place - self._began))))


class OtherLegs:
    """The others around the person."""

    def __init__(self) -> None:
        self._tracks: list[LegTrack] = []

    def share_out(
        self,
        stamp: float,
        pose: Pose,
        standers: Sequence[LegCluster],
        person: tuple[Array, Array],
        limits: tuple[float, float],
        barred: Sequence[LegCluster] = (),
    ) -> LegCluster | None:
        """Legs of one scan → those of the person, who is expected at a place (2,) with a covariance (2, 2), world.

        `limits`: reach [m] and gate (chi-square) around that place; `barred`: not the person's, as a picture shows.
        None: the person shows no legs.
        """
        reach, gate = limits
        anothers = frozenset[int]().union(*(one.pieces for one in barred))
        seen = [(one, *in_world(one, pose)) for one in standers]
        seen = [one for one in seen if np.hypot(*(one[1] - person[0])) < MAX_LEGS_DISTANCE_M]
        self._tracks = [one for one in self._tracks if stamp - one.measured < MAX_UNSEEN_S]
        matches: list[tuple[float, int, int]] = []  # cost, number of the track (0: the person), of the legs
        for number, (place, covariance) in enumerate([person, *(one.predicted(stamp) for one in self._tracks)]):
            for column, (legs, at, spread) in enumerate(seen):
                free = not legs.pieces & anothers and not any(legs is one for one in barred)
                if number > 0 or (free and np.hypot(*(at - place)) <= reach):
                    matches.append((_cost(at - place, covariance + spread, gate), number, column))
        own: LegCluster | None = None
        matched: set[int] = set()
        used: set[int] = set()  # pieces of the scan
        taken: list[Array] = []
        for cost, number, column in sorted(matches):
            legs, at, _ = seen[column]
            if cost >= MISSED_COST or number in matched or legs.pieces & used:
                continue
            matched.add(number)
            used |= legs.pieces
            taken.append(at)
            if number == 0:
                own = legs
            else:
                self._tracks[number - 1].take(at, stamp)
        for legs, at, _ in sorted(seen, key=lambda one: -one[0].legs):
            if not legs.pieces & used and all(np.hypot(*(at - other)) > MIN_BODY_GAP_M for other in taken):
                self._tracks.append(LegTrack(place=at, velocity=np.zeros(2), stamp=stamp, measured=stamp))
                used |= legs.pieces
                taken.append(at)
        return own

    def near(self, place: Array, stamp: float, *, walking: bool) -> list[LegTrack]:
        """Return those who were seen just now near a place (2,) [m], world, nearest first; `walking`: no others."""
        seen = [
            one
            for one in self._tracks
            if stamp - one.measured < MAX_LEGS_AGE_S and (one.walked >= MIN_WALKED_M or not walking)
        ]
        order = sorted((float(np.hypot(*(one.place - place))), number) for number, one in enumerate(seen))
        return [seen[number] for far, number in order if far < LOOK_REACH_M][:MAX_LOOKED_AT]

    def heir(self, place: Array, stamp: float, reach: float, since: float) -> LegTrack | None:
        """Return the one track near a place (2,) [m], world, that may be of legs last seen as the person's at `since`
        [s]: it began later, is seen now and is no stranger's. None: there is none, or several.
        """
        found = [
            one
            for one in self._tracks
            if one.since > since and one.measured == stamp and one.age >= FIRM_SCANS and not one.is_stranger
        ]
        found = [one for one in found if np.hypot(*(one.place - place)) < reach]
        return found[0] if len(found) == 1 else None

    def remove(self, track: LegTrack) -> None:
        """Forget a track: its legs are the person's."""
        self._tracks.remove(track)


def _cost(off: Array, spread: Array, gate: float) -> float:
    """Squared Mahalanobis distance and log determinant; MISSED beyond the gate."""
    (a, b), (_, d) = spread.tolist()
    x, y = off.tolist()
    determinant = max(a * d - b * b, 1e-12)
    square = (d * x * x - 2 * b * x * y + a * y * y) / determinant
    return square + math.log(determinant) if square < gate else MISSED_COST
