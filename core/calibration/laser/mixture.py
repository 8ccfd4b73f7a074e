"""A turn and a shift estimated from pairs, many of which are wrong: a mixture of true pairs and chance ones."""

from __future__ import annotations

import math

import numpy as np

from core.message import Array, message
from core.perception.landmarks.edge_pairs import WINDOW

SHIFT_SD = 0.01  # [m] how far a mount is thought to move sideways before anything is seen
TURN_SD = math.radians(4)  # [rad]
BIAS = math.radians(0.12)  # [rad] sd by which one corner and its edge may disagree for good: frames, rounded walls
MAX_ROUNDS = 25
CONVERGED_STEP_RAD = 1e-5  # a round that changes less is the last one
BIN = math.radians(0.25)


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

    turn: float  # [rad]
    turn_sd: float
    shift: float  # [m]
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
    prior = np.diag([1 / TURN_SD**2, 1 / SHIFT_SD**2])
    many = int((np.bincount(own, pairs.weight * belongs) > 1.0).sum())
    if many < 3:
        return None
    inward = np.linalg.inv((rows.T * weights) @ rows + prior)
    sums = np.column_stack([np.bincount(own, weights * rest * row) for row in rows.T])
    middle = sums.T @ sums * many / (many - 2)
    seen = inward @ (middle + prior) @ inward
    levers = np.column_stack([np.bincount(own, weights * row) for row in rows.T])
    thought = inward @ (BIAS**2 * levers.T @ levers) @ inward + inward
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
    edges = np.arange(-WINDOW, WINDOW + BIN, BIN)
    counts, _ = np.histogram(-pairs.off, edges, weights=pairs.weight)
    counts = np.convolve(counts, [0.5, 1.0, 0.5], "same")
    return [0.0, float(edges[int(counts.argmax())] + 0.5 * BIN)]


def _climb(pairs: Gathered, rows: Array, answer: Array) -> tuple[Array, Array, float]:
    """One start → (turn, shift), the share (N,) with which each pair belongs together, and the log likelihood."""
    prior = np.diag([1 / TURN_SD**2, 1 / SHIFT_SD**2])
    share, chance = 0.5, 1 / (2 * WINDOW)
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
