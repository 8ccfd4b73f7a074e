"""How a person looks, in numbers: colours of the clothes part by part, proportions, height; and whether two are one.

Whether two sights are of the same person is asked as a likelihood ratio of two normal distributions (Köstinger et al.
2012 learn them; here they have few parameters, chosen on one half of the photographs). The light between two sights
changes the brightness of all parts by one factor and their tint by another; what is left differs part by part.
"""

import math
from collections import deque

import numpy as np

from core.message import Array, message
from core.perception.people.parts import (
    CEILING_M,
    CELL_PX,
    CELLS_PER_METRE,
    MODEL_HEIGHT_M,
    PARTS,
    PIXELS_PER_METRE,
    BodySegment,
)
from core.perception.people.vertical_plane import VerticalPlanes

TONE_COUNT = 4  # of a part: medians of log blue, log green, log red, and the spread of log brightness
LIMB_COUNT = 3  # proportions: log of the legs', the arms' and the neck's length in lengths of the torso
DARK_NOISE_GREY = 12.0  # [grey levels] added before the logarithm: noise of the dark
SPREAD_PERCENTS = (15, 85)  # [%] quantiles between which the brightness of a part spreads
LIGHT_SD, TINT_SD = 0.25, 0.08  # of the logarithms, between two sights of one person, of all parts together
PART_SD = (0.3, 0.12, 0.12)  # head, torso, feet: each by itself; a head shows its face or its hair
OTHERS_SD, OTHERS_TINT_SD = 0.7, 0.15  # between two people, of each part
PATTERN_SD, OTHERS_PATTERN_SD = 0.25, 0.42  # of the spread: one person's, and two people's
LIMB_SD = (0.12, 0.15, 0.18)  # of one person's proportions in two sights: people turn and bend
OTHERS_LIMB_SD = (0.14, 0.17, 0.23)  # between two people
HEIGHT_SD, OTHERS_HEIGHT_SD = 0.07, 0.12  # [m] the same of heights by laser and camera
MIN_LOG_RATIO = -2.0  # of a log likelihood ratio of proportions or height: a bent knee alone makes nobody a stranger
VIEW_HALF_M = 0.25  # of a view to either side in which colours are looked at
MIN_SHOWN_SHARE = 0.3  # share of a part in the picture from which its colours count
MIN_PART_PIXELS = 8  # pixels of a part


@message
class Appearance:
    """One person's looks as far as they are known; NaN where they are not."""

    colours: Array  # (3, TONE_COUNT): head, torso, feet
    proportions: Array  # (LIMB_COUNT,)
    height: float = math.nan  # [m] by the laser's distance and the camera

    @property
    def known(self) -> bool:
        """Return whether anything can be compared."""
        return bool(np.isfinite(self.colours[1:]).any())


@message
class PersonProfile:
    """A person who was taught."""

    name: str
    looks: Appearance
    pictures: int  # from how many


NO_LIMBS = np.full(LIMB_COUNT, np.nan)


def likelihood_ratio(who: Appearance, seen: Appearance) -> float:
    """Log likelihood ratio: these are the same person, against two people; 0 where nothing can be compared."""
    off = who.colours - seen.colours
    parts = np.flatnonzero(np.isfinite(off[:, :3]).all(axis=1)).tolist()
    if not parts:
        return 0.0
    total = _normal_ratio(off[parts, :3].ravel(), *_covariances(tuple(parts)))
    total += _ratio(off[:, 3], PATTERN_SD, OTHERS_PATTERN_SD)
    total += max(MIN_LOG_RATIO, _ratio(who.proportions - seen.proportions, LIMB_SD, OTHERS_LIMB_SD))
    return total + max(MIN_LOG_RATIO, _ratio(np.array([who.height - seen.height]), HEIGHT_SD, OTHERS_HEIGHT_SD))


def alike(who: Appearance, seen: Appearance) -> float:
    """Probability by looks alone that two are the same person, 0..1; 0.5 where nothing can be compared."""
    return 1 / (1 + math.exp(-min(max(likelihood_ratio(who, seen), -30.0), 30.0)))


def mean_of(looks: list[Appearance]) -> Appearance:
    """Several sights of one person → what they have in common; what none of them shows is NaN."""
    heights = np.array([[one.height] for one in looks])
    return Appearance(
        colours=_mean(np.array([one.colours for one in looks])),
        proportions=_mean(np.array([one.proportions for one in looks])),
        height=float(_mean(heights)[0]),
    )


def colours_seen(boards: VerticalPlanes, distance: float, bearing: float, height: float) -> Appearance:
    """The colours of who stands there, `distance` [m] and `bearing` [rad] from the camera, so tall [m]; NaN for a
    part that is not in the picture.
    """
    pixels, valid = boards.cut(distance, bearing, VIEW_HALF_M)
    inside = np.repeat(np.repeat(valid, CELL_PX, axis=0), CELL_PX, axis=1)
    shift = round((height - MODEL_HEIGHT_M) * CELLS_PER_METRE)
    rows: list[Array] = []
    for part in PARTS:
        region, shown = region_of(part, pixels, inside, shift)
        enough = shown.size and shown.mean() >= MIN_SHOWN_SHARE
        rows.append(tones_of(region, shown) if enough else np.full(TONE_COUNT, np.nan))
    return Appearance(colours=np.array(rows), proportions=NO_LIMBS)


def region_of(part: BodySegment, pixels: Array, inside: Array, shift: int) -> tuple[Array, Array]:
    """The core of a part in a compared view with the body in its middle, and which of its pixels count."""
    middle, half = pixels.shape[1] / 2, part.core / 2 * PIXELS_PER_METRE
    top = (part.top - round(part.rise * shift) + 0.15 * part.rows) * CELL_PX
    bottom = min(top + 0.75 * part.rows * CELL_PX, CEILING_M * PIXELS_PER_METRE)
    area = (slice(round(top), round(bottom)), slice(round(middle - half), round(middle + half)))
    return pixels[area], inside[area]


def tones_of(pixels: Array, shown: Array) -> Array:
    """Pixels (H, W, 3) uint8 and which count (H, W) bool → (TONES,); NaN where too few count."""
    counted = pixels[shown]
    if len(counted) < MIN_PART_PIXELS:
        return np.full(TONE_COUNT, np.nan)
    logs = LOGS[counted]
    low, high = np.percentile(logs.mean(axis=1), SPREAD_PERCENTS)
    return np.append(np.median(logs, axis=0), high - low)


LOGS = np.log(np.arange(256) + DARK_NOISE_GREY)


def _covariances(parts: tuple[int, ...]) -> tuple[Array, Array]:
    """Of the differences of colours of these parts (3 · parts): one person's, and two people's."""
    count = len(parts)
    every, channels = np.ones((3 * count, 3 * count)), np.kron(np.ones((count, count)), np.eye(3))
    apart = np.kron(np.diag([PART_SD[part] ** 2 for part in parts]), 0.5 * np.eye(3) + 0.5)
    same = LIGHT_SD**2 * every + TINT_SD**2 * channels + apart
    other = np.kron(np.eye(count), OTHERS_SD**2 * np.ones((3, 3)) + OTHERS_TINT_SD**2 * np.eye(3))
    return same, same + other


def _normal_ratio(off: Array, same: Array, other: Array) -> float:
    squares = off @ np.linalg.solve(same, off) - off @ np.linalg.solve(other, off)
    return float(-0.5 * (squares + np.linalg.slogdet(same)[1] - np.linalg.slogdet(other)[1]))


def _ratio(off: Array, same_sd: float | tuple[float, ...], other_sd: float | tuple[float, ...]) -> float:
    """The same of independent numbers; NaN says nothing."""
    same, other = np.square(same_sd), np.square(same_sd) + np.square(other_sd)
    each = -0.5 * (off**2 / same - off**2 / other + np.log(same / other))
    return float(np.nansum(each))


def _mean(rows: Array) -> Array:
    known = np.isfinite(rows)
    count = known.sum(axis=0)
    return np.where(count > 0, np.where(known, rows, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)


NEAR_LEGS_M = 0.6  # between the person and other legs, within which a picture may show either of them
DOUBT_TIME_S = 4.0  # after that, in which the person may be on the legs of another
SURE_RATIO = 1.0  # log likelihood ratio of looks from which people elsewhere may be the person
RATIO_MARGIN = 1.5  # by which that ratio is larger than at the place where the person was thought to be
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
