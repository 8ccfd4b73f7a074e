"""Check that the camera still sits on the laser as it was calibrated, from corners and edges met on the way."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.edge_pairs import WINDOW_RAD, EdgePair
from core.sensors import Camera
from core.setting import Meta, Section

# A turn and a shift estimated from pairs, many of which are wrong: a mixture of true pairs and chance ones.

SHIFT_SD_M = 0.01  # how far a mount is thought to move sideways before anything is seen
TURN_SD_RAD = math.radians(4)
EDGE_BIAS_SD_RAD = math.radians(0.12)  # by which a corner and its edge may disagree for good: frames, rounded walls
MAX_ROUNDS = 25
CONVERGED_STEP_RAD = 1e-5  # a round that changes less is the last one
BEARING_BIN_RAD = math.radians(0.25)


@message
class Gathered:
    """Pairs as columns (N,)."""

    off: Array  # [rad]
    sd: Array  # [rad]
    lever: Array  # [1/m]
    weight: Array  # 0..1: what is old counts less
    corner: Array  # int: which corner it was


@message
class TransformFit:
    """The turn and the shift that the pairs agree on."""

    turn: float  # [rad] counter-clockwise
    turn_sd: float
    shift: float  # [m] to the left of where it looks
    shift_sd: float
    apparent: float  # [rad] the turn that looks like both together at the usual distance: known best
    apparent_sd: float
    pairs: int  # that belong together
    corners: int  # that they come from


def fit(pairs: Gathered) -> TransformFit | None:
    """Pairs → the turn and shift, by expectation maximisation from the likeliest start; None for too few.

    off = -turn - shift * lever + noise for true pairs; chance pairs spread evenly over the window. Pairs of one
    corner share its errors, so the covariance is summed by corner (the sandwich form: Liang and Zeger, Biometrika
    73, 1986).
    """
    if len(pairs.off) < 8:
        return None
    rows = np.column_stack((np.ones(len(pairs.off)), pairs.lever))
    tries = [_climb(pairs, rows, np.array([turn, 0.0])) for turn in _starts(pairs)]
    answer, belongs, _ = max(tries, key=lambda one: one[2])
    _, own = np.unique(pairs.corner, return_inverse=True)
    weights = pairs.weight * belongs / pairs.sd**2
    rest = -pairs.off - rows @ answer
    prior = np.diag([1 / TURN_SD_RAD**2, 1 / SHIFT_SD_M**2])
    many = int((np.bincount(own, pairs.weight * belongs) > 1.0).sum())
    if many < 3:
        return None
    inward = np.linalg.inv((rows.T * weights) @ rows + prior)
    sums = np.column_stack([np.bincount(own, weights * rest * row) for row in rows.T])
    middle = sums.T @ sums * many / (many - 2)
    seen = inward @ (middle + prior) @ inward
    levers = np.column_stack([np.bincount(own, weights * row) for row in rows.T])
    thought = inward @ (EDGE_BIAS_SD_RAD**2 * levers.T @ levers) @ inward + inward
    sds = np.sqrt(np.maximum(np.diag(seen), np.diag(thought)))
    usual = weights @ rows / weights.sum()
    return TransformFit(
        turn=float(answer[0]),
        turn_sd=float(sds[0]),
        shift=float(answer[1]),
        shift_sd=float(sds[1]),
        apparent=float(usual @ answer),
        apparent_sd=math.sqrt(max(usual @ seen @ usual, usual @ thought @ usual)),
        pairs=int((belongs > 0.5).sum()),
        corners=many,
    )


def _starts(pairs: Gathered) -> list[float]:
    """Turns [rad] to begin with: none, and where the pairs gather."""
    edges = np.arange(-WINDOW_RAD, WINDOW_RAD + BEARING_BIN_RAD, BEARING_BIN_RAD)
    counts, _ = np.histogram(-pairs.off, edges, weights=pairs.weight)
    counts = np.convolve(counts, [0.5, 1.0, 0.5], "same")
    return [0.0, float(edges[int(counts.argmax())] + 0.5 * BEARING_BIN_RAD)]


def _climb(pairs: Gathered, rows: Array, answer: Array) -> tuple[Array, Array, float]:
    """One start → (turn, shift), the share (N,) with which each pair belongs together, and the log likelihood."""
    prior = np.diag([1 / TURN_SD_RAD**2, 1 / SHIFT_SD_M**2])
    share, chance = 0.5, 1 / (2 * WINDOW_RAD)
    belongs = np.zeros(len(rows))
    likelihood = -math.inf
    for _ in range(MAX_ROUNDS):
        rest = -pairs.off - rows @ answer
        true = share * np.exp(-0.5 * (rest / pairs.sd) ** 2) / (math.sqrt(2 * math.pi) * pairs.sd)
        both = true + (1 - share) * chance
        belongs = true / both
        likelihood = float(pairs.weight @ np.log(both)) - 0.5 * float(answer @ prior @ answer)
        share = min(0.95, max(0.05, float(pairs.weight @ belongs / pairs.weight.sum())))
        weights = pairs.weight * belongs / pairs.sd**2
        before = answer
        answer = np.linalg.solve((rows.T * weights) @ rows + prior, (rows.T * weights) @ -pairs.off)
        if abs(answer[0] - before[0]) < CONVERGED_STEP_RAD:
            break
    return answer, belongs, likelihood


@dataclass(frozen=True)
class DriftSettings(Section):
    """Criteria of a moved mount.

    Watch:
        turned: warnings of a turned mount; raise it for false ones
        shifted: warnings of a shifted mount; raise it for false ones
        lasting: time until such a warning
    """

    step: float = 0.04  # [m] way between two looks: at rest they are all the same
    turn: float = math.radians(3)  # [rad] turn between two looks, where the way is shorter
    looks: int = 200  # looks that are kept
    half_life: float = 60.0  # [looks] age at which a look counts half
    every: float = 1.0  # [s] time between two estimates
    apart: float = 0.4  # [m] corners closer together than this are one corner
    corners: int = 4  # different corners, at least, before anything is reported
    sure: float = 3.0  # [sd] significance of a reported change
    calm: float = 0.5  # share of the thresholds below which an alarm is over
    turned: Annotated[float, Meta("rad", 1e-4, 0.5, "a smaller turn of the mount does not matter")] = math.radians(
        0.3
    )
    shifted: Annotated[float, Meta("m", 0.001, 0.5, "a smaller shift of the mount does not matter")] = 0.015
    lasting: Annotated[float, Meta("s", 0, 60, "time that a change must be seen before it is reported")] = 3.0


@message
class Drift(TransformFit):
    """Estimated difference of the camera's mount from the calibration in use."""

    alarm: bool = False
    words: str = ""


class MountWatch:
    """Gathers pairs of corner and edge while the robot drives. Owned by the pilot."""

    def __init__(self, settings: DriftSettings | None = None) -> None:
        self._settings = settings or DriftSettings()
        self.drift: Drift | None = None  # None: not enough was seen
        self._forget(None)

    def _forget(self, camera: Camera | None) -> None:
        self._camera = camera
        self._looks: deque[list[tuple[EdgePair, int]]] = deque(maxlen=self._settings.looks)
        self._places: list[Array] = []  # (2,) [m] of corners that were met, world
        self._last: Pose | None = None
        self._estimated = -math.inf
        self._suspected: float | None = None  # [s] since when
        self.alarm = ""  # the warning for the operator; its first figures stay, as it is reported once
        self.drift = None

    def watch(self, stamp: float, pose: Pose, pairs: tuple[EdgePair, ...], camera: Camera | None) -> None:
        """The pairs of one scan, seen from `pose` in the world. A new calibration of the camera starts again."""
        if camera is not self._camera:
            self._forget(camera)
        if not pairs or not self._moved(pose):
            return
        self._last = pose
        places = pose.apply(np.array([pair.position for pair in pairs]))
        self._looks.append([(pair, self._place(place)) for pair, place in zip(pairs, places, strict=True)])
        if stamp - self._estimated >= self._settings.every:
            self._estimated = stamp
            self._estimate(stamp)

    def _moved(self, pose: Pose) -> bool:
        last, settings = self._last, self._settings
        if last is None:
            return True
        turned = abs(math.remainder(pose.heading - last.heading, math.tau))
        return pose.distance_to(last.x, last.y) >= settings.step or turned >= settings.turn

    def _place(self, place: Array) -> int:
        if self._places:
            away = np.hypot(*(np.array(self._places) - place).T)
            if away.min() < self._settings.apart:
                return int(away.argmin())
        self._places.append(place)
        return len(self._places) - 1

    def _estimate(self, stamp: float) -> None:
        settings = self._settings
        rows = [
            (pair.off, pair.sd, pair.lever, 0.5 ** (age / settings.half_life), place)
            for age, look in enumerate(reversed(self._looks))
            for pair, place in look
        ]
        off, sd, lever, weight, place = np.array(rows).T
        found = fit(Gathered(off=off, sd=sd, lever=lever, weight=weight, corner=place.astype(int)))
        if found is None or found.corners < settings.corners:
            self.drift = None
            return
        self.drift = self._judged(stamp, found)

    def _judged(self, stamp: float, found: TransformFit) -> Drift:
        """The estimate, and whether it is an alarm: only after it lasted, and then until it is clearly over."""
        settings, before = self._settings, self.drift is not None and self.drift.alarm
        ease = settings.calm if before else 1.0
        moved = _beyond(found.apparent, found.apparent_sd, settings.turned * ease, settings.sure * ease)
        shifted = _beyond(found.shift, found.shift_sd, settings.shifted, settings.sure)
        self._suspected = (stamp if self._suspected is None else self._suspected) if moved else None
        alarm = self._suspected is not None and (before or stamp - self._suspected >= settings.lasting)
        words = _words(found, shifted) if alarm else ""
        self.alarm = (self.alarm or words) if alarm else ""
        return Drift(**vars(found), alarm=alarm, words=words)


def _beyond(value: float, sd: float, matters: float, sure: float) -> bool:
    return abs(value) > matters and abs(value) > sure * sd


def _words(found: TransformFit, shifted: bool) -> str:
    """The alarm in words: a turn, as long as nothing separates it from a shift that looks alike."""
    if shifted:
        side = "left" if found.shift > 0 else "right"
        said = f"moved by {100 * abs(found.shift):.1f} ± {100 * found.shift_sd:.1f} cm to the {side}"
        if abs(found.turn) > 3 * found.turn_sd:
            said += f" and turned by {math.degrees(found.turn):+.1f}° ± {math.degrees(found.turn_sd):.1f}°"
    else:
        side = "left" if found.apparent > 0 else "right"
        turn, sd = math.degrees(abs(found.apparent)), math.degrees(found.apparent_sd)
        said = f"turned by {turn:.1f}° ± {sd:.1f}° to the {side}"
    return f"The camera seems to have {said} on its mount; calibrate the laser again."
