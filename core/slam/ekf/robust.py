"""Robust weights for the sightings of one update: each is judged by the others, and the prediction by all."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
import scipy

from core.message import Array

MAX_ROUNDS = 3  # in which trust is withdrawn, at most
WEIGHT_EXPONENT = 1.5  # with which it falls beyond the limit


@dataclass(frozen=True)
class SlipThresholds:
    """When the sightings overrule the prediction: the robot was pushed, or its wheels slipped."""

    slip_odd: float = 16.3  # [χ²] squared distance of a sighting that contradicts the prediction; 99.97 % at 2 dof
    # [χ²] squared distance up to which it fits once the robot may be elsewhere; 99 % at 2 dof
    slip_agree: float = 9.21
    slip_fewest: int = 3  # sightings that must agree on where the robot is
    slip_share: float = 0.5  # share of the sightings, at least, that contradict before and agree afterwards
    slip_place_sd: float = 0.5  # [m] sd of the place after a slip
    slip_heading_sd: float = math.radians(20)  # [rad] sd of the heading after a slip

    @property
    def unnoticed(self) -> Array:
        """Covariance (3, 3) of the unreported move, in the robot's frame."""
        return np.diag([self.slip_place_sd**2, self.slip_place_sd**2, self.slip_heading_sd**2])


def mahalanobis(innovation: Array, residuals: Array) -> Array:
    """Innovation covariance (2M, 2M), residuals (M, 2) → squared distance (M,) of each from what the others say.

    The others' residuals have a common cause where the robot is not quite where it was predicted; what they share is
    taken off. With S the covariance and ν the residuals, (S⁻¹ν)_i has the covariance (S⁻¹)_ii.
    """
    root, failed = scipy.linalg.lapack.dpotrf(innovation, lower=1)
    if failed:
        raise ValueError("The innovation covariance is not positive definite.")
    pulls, _ = scipy.linalg.lapack.dpotrs(root, residuals.ravel(), lower=1)
    inverse, _ = scipy.linalg.lapack.dpotri(root, lower=1)
    diagonal = inverse.diagonal()
    a, b, c = diagonal[::2], inverse.diagonal(-1)[::2], diagonal[1::2]
    u, v = pulls[::2], pulls[1::2]
    return (c * u * u - 2 * b * u * v + a * v * v) / np.maximum(a * c - b * b, 1e-300)


def with_noise(state: Array, noises: Array) -> Array:
    """Covariance (2M, 2M) that comes from the state, and of the sightings (M, 2, 2) → their sum, symmetric."""
    count = len(noises)
    total = 0.5 * (state + state.T)
    total.reshape(count, 2, count, 2)[np.arange(count), :, np.arange(count), :] += noises
    return total


def trust(innovation: Array, noises: Array, residuals: Array, odd: Array, limit: float) -> Array:
    """Soft gate: S (2M, 2M), the sightings' noise in it (M, 2, 2), residuals (M, 2), distances² (M,) → weights.

    The weights (M,) ≥ 1 go on the sightings' covariances. A sighting odder than `limit` is trusted less, not thrown
    away: a hard gate would refuse every later sighting of what moved, and lock the filter out. Were they judged one
    by one, sightings that all err alike because the prediction does would lose their say just when they are right.
    """
    weights = np.ones(len(residuals))
    for turn in range(MAX_ROUNDS):
        if turn:
            odd = mahalanobis(with_noise(innovation, (weights - 1.0)[:, None, None] * noises), residuals)
        beyond = odd > limit
        if not beyond.any():
            break
        weights[beyond] *= (odd[beyond] / limit) ** WEIGHT_EXPONENT
    return weights


def displaced(innovation: Array, residuals: Array, odd: Array, moved: Array, settings: SlipThresholds) -> bool:
    """Return whether most sightings contradict the prediction but agree once the robot may be elsewhere.

    S (2M, 2M), residuals (M, 2), their squared Mahalanobis distances `odd` (M,); `moved` (2M, 2M): the part that
    doubt in the robot's place adds to S. A few sightings of the wrong landmarks do not do that.
    """
    least = max(settings.slip_fewest, settings.slip_share * len(odd))
    if np.count_nonzero(odd > settings.slip_odd) < least:
        return False
    agree = settings.slip_agree
    return _agreeing(innovation, residuals, agree) < least <= _agreeing(innovation + moved, residuals, agree)


def _agreeing(innovation: Array, residuals: Array, limit: float) -> int:
    """Count the sightings that are left when the worst is removed repeatedly until none is beyond `limit`."""
    kept = np.arange(len(residuals))
    while len(kept) > 1:
        rows = (2 * kept[:, None] + np.arange(2)).ravel()
        odd = mahalanobis(innovation[np.ix_(rows, rows)], residuals[kept])
        worst = int(odd.argmax())
        if odd[worst] <= limit:
            break
        kept = np.delete(kept, worst)
    return len(kept)


MIN_SIGHTINGS = 5  # sightings before anything is said of what is usual
MEDIAN = 2 * math.log(2)  # of a squared distance in two dimensions, when all is as it should be


class AdaptiveGate:
    """The median of the latest squared distances between sightings and what was expected.

    A soft gate trusts less what lies off. But when most sightings lie off, it is not they that are wrong, and a
    filter that went on distrusting them would lock itself out at the end of a long loop. Where a scan has several
    sightings they show that by themselves; this is for those with one or two.
    """

    def __init__(self, memory: int, slack: float) -> None:
        """`memory`: sightings; `slack`: times what the filter promises that counts as usual."""
        self._lately: deque[float] = deque(maxlen=memory)
        self._promised = slack * MEDIAN

    @property
    def factor(self) -> float:
        """Factor by which the soft gate is wider at present; 1: not at all."""
        if len(self._lately) < MIN_SIGHTINGS:
            return 1.0
        return max(1.0, float(np.median(self._lately)) / self._promised)

    def note(self, distances: list[float]) -> None:
        """Squared distances of the newest sightings."""
        self._lately.extend(distances)
