"""Place of the caller: RANSAC over audio-visual coordinates, gathered from all poses in which the robot looked.

A voice gives a bearing, a picture a bearing and a rough distance, legs a place. Samples of them propose places, and a
place is believed for what agrees with it: a voice that was heard with the words, and someone who was seen. At a
wall's echo nobody stands, and another talker has less of the words.
"""

import itertools
import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from core.geometry import Pose, Ray, wrap, wrap_all
from core.message import Array, message
from core.perception.people.fusion import GATE_CHI2, Sense, along
from core.perception.people.legs import find_standers
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing
from core.perception.sound.triangulation import crossing

BODY_SD_M = 0.1  # of a mouth or a head beside the middle of the legs
MIN_DISTANCE_M = 0.3  # of a caller from where they were perceived
MOST_PAIRS = 500
BELIEVED_COORDINATES = 3.0  # coordinates of one sense after which more of them change nothing
SHARES: dict[Sense, float] = {"sound": 1.0, "camera": 0.5, "laser": 0.2}
"""Weight of each sense: the voice says who called, a picture that a person is there, legs may be a chair's."""
MAX_ROUNDS = 10
GUESSED_SD_SHARE = 0.15  # share of a distance that only the picture gives
LEGS_SD_M = 0.07  # of a place that the laser gives
LEGS_WEIGHT = 0.5  # weight of two legs that no picture showed to be a person's
WEDGE_SDS = 3.0  # sd of a voice's direction within which legs are kept
MIN_TURN_RAD, MIN_MOVE_M = 0.1, 0.1  # between two poses from which coordinates are gathered
MAX_COORDINATES = 300  # coordinates


@message
class Coordinate:
    """Perception of one sense from one pose."""

    sense: Sense
    stamp: float  # [s]
    ray: Ray
    distance: float | None = None  # [m] along the ray; None: a bearing alone
    distance_sd: float = 1.0  # [m]
    weight: float = 1.0  # 0..1 how sure the sense is that this is a person, or the one who spoke


@message
class Consensus:
    """A place on which coordinates agree."""

    position: Array  # (2,) [m] world
    score: float
    used: tuple[int, ...]  # which of the coordinates agree


def consensus(coordinates: Sequence[Coordinate]) -> Consensus | None:
    """Find the place on which most agree; None where no voice agrees with anything that was seen."""
    if not coordinates:
        return None
    table = _Table(coordinates)
    best: Consensus | None = None
    for place in _proposed(coordinates):
        found = table.judged(place)
        if found is not None and (best is None or found.score > best.score):
            best = found
    return None if best is None else table.judged(table.refined(best)) or best


class GatheredCoordinates:
    """The coordinates of one command, from all poses since it was given."""

    def __init__(self, calls: Sequence[VoiceBearing]) -> None:
        """`calls`: the bearings that were heard in its words; those of one moment have one stamp."""
        self._calls = tuple(calls)
        self._voices = [Coordinate(sense="sound", stamp=one.stamp, ray=one.ray, weight=one.strength) for one in calls]
        self._seen: deque[Coordinate] = deque(maxlen=MAX_COORDINATES)
        self._gathered: Pose | None = None

    def agreed(self) -> Consensus | None:
        """Return the place on which they agree."""
        return consensus([*self._voices, *self._seen])

    def is_new(self, pose: Pose) -> bool:
        """Return whether nothing was gathered near this pose yet; it counts as gathered then."""
        before = self._gathered
        near = before is not None and before.distance_to(pose.x, pose.y) < MIN_MOVE_M
        if before is not None and near and abs(wrap(before.heading - pose.heading)) < MIN_TURN_RAD:
            return False
        self._gathered = pose
        return True

    def add_legs(self, stamp: float, pose: Pose, points: Array) -> None:
        """Gather things that stand like legs in a voice's direction; `points` (N, 2) [m] of a scan, robot frame."""
        for legs in find_standers(points):
            x, y = pose.apply(legs.place[None])[0].tolist()
            if not any(abs(wrap(one.ray.bearing_to(x, y) - one.azimuth)) < WEDGE_SDS * one.sd for one in self._calls):
                continue
            sd = LEGS_SD_M / max(legs.distance, LEGS_SD_M)
            ray = Ray(x=pose.x, y=pose.y, azimuth=pose.heading + legs.bearing, sd=sd)
            weight = LEGS_WEIGHT * legs.legs / 2
            self._seen.append(
                Coordinate(
                    sense="laser", stamp=stamp, ray=ray, distance=legs.distance, distance_sd=LEGS_SD_M, weight=weight
                )
            )

    def add_person(self, person: TrackedPerson) -> None:
        """Gather a person who was seen in a picture, as far away as the other senses say."""
        ray, rectangle = person.camera, person.rectangle
        if ray is None or rectangle is None or "camera" not in person.used:
            return
        x, y = person.position.tolist()
        far = math.hypot(x - ray.x, y - ray.y)
        self._seen.append(
            Coordinate(
                sense="camera",
                stamp=person.stamp,
                ray=ray,
                distance=far,
                distance_sd=LEGS_SD_M if "laser" in person.used else GUESSED_SD_SHARE * far,
                weight=min(rectangle.value, 1.0),
            )
        )


class _Table:
    """The coordinates as columns."""

    def __init__(self, coordinates: Sequence[Coordinate]) -> None:
        rows = [
            (one.ray.x, one.ray.y, one.ray.azimuth, one.ray.sd, one.distance or math.nan, one.distance_sd, one.weight)
            for one in coordinates
        ]
        self._origins = np.array(rows)[:, :2]
        self._azimuths, self._sds, self._distances, self._distance_sds, self._weights = np.array(rows).T[2:]
        self._senses: Array = np.array([one.sense for one in coordinates])
        self._stamps = np.array([one.stamp for one in coordinates])

    def judged(self, place: Array) -> Consensus | None:
        """How well a place (2,) is supported; None without a voice, or without anything that was seen."""
        miss = self._misses(place)
        # the same probability with a distance
        gates = np.where(np.isnan(self._distances), GATE_CHI2, GATE_CHI2 + 2.8)
        gains = self._weights * np.maximum(0.0, 1 - miss / gates)
        sums: dict[Sense, float] = {sense: self._support(sense, gains) for sense in SHARES}
        if not sums["sound"] or not sums["camera"] + sums["laser"]:
            return None
        score = sum(SHARES[sense] * support for sense, support in sums.items())
        return Consensus(position=place, score=score, used=tuple(np.flatnonzero(gains > 0).tolist()))

    def _support(self, sense: Sense, gains: Array) -> float:
        own = self._senses == sense
        if sense == "sound":
            moments = set(self._stamps[own].tolist())
            return sum(float(gains[own & (self._stamps == one)].max()) for one in moments) / max(len(moments), 1)
        agree = gains[own][gains[own] > 0]
        return float(agree.mean()) * min(len(agree) / BELIEVED_COORDINATES, 1.0) if len(agree) else 0.0

    def refined(self, found: Consensus) -> Array:
        """Least squares over what agrees (Gauss-Newton) → the place (2,)."""
        place, chosen = found.position, np.array(found.used)
        origins, known = self._origins[chosen], ~np.isnan(self._distances[chosen])
        for _ in range(MAX_ROUNDS):
            away = place - origins
            far = np.maximum(np.hypot(*away.T), MIN_DISTANCE_M)
            across = np.stack((-away[:, 1], away[:, 0]), axis=1) / far[:, None] ** 2
            gap = wrap_all(self._azimuths[chosen] - np.arctan2(away[:, 1], away[:, 0]))
            slopes = across / self._sds[chosen, None]
            errors = gap / self._sds[chosen]
            ahead = (away / far[:, None])[known] / self._distance_sds[chosen, None][known]
            short = ((self._distances[chosen] - far) / self._distance_sds[chosen])[known]
            step, *_ = np.linalg.lstsq(np.vstack((slopes, ahead)), np.concatenate((errors, short)), rcond=None)
            place = place + step
            if float(np.hypot(*step)) < 1e-4:
                break
        return place if np.isfinite(place).all() else found.position

    def _misses(self, place: Array) -> Array:
        """Squared Mahalanobis distance (N,) of every coordinate from a place (2,)."""
        away = place - self._origins
        far = np.maximum(np.hypot(*away.T), MIN_DISTANCE_M)
        gap = wrap_all(self._azimuths - np.arctan2(away[:, 1], away[:, 0]))
        across = gap**2 / (self._sds**2 + (BODY_SD_M / far) ** 2)
        return across + np.nan_to_num((self._distances - far) / self._distance_sds) ** 2


def _proposed(coordinates: Sequence[Coordinate]) -> list[Array]:
    """The places of minimal samples: one coordinate with a distance, or two bearings that cross."""
    places = [along(one.ray, one.distance)[0] for one in coordinates if one.distance is not None]
    rays = [np.array([one.ray.x, one.ray.y, one.ray.azimuth]) for one in coordinates if one.sense != "laser"]
    pairs = list(itertools.combinations(rays, 2))
    crossings = [crossing(*pair) for pair in pairs[:: max(1, len(pairs) // MOST_PAIRS)]]
    return [*places, *(place for place in crossings if place is not None)]
