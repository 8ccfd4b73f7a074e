"""The pose of the camera on the laser: P_laser = R P_camera + t (eq. 11).

Eq. 13 sums the distances of laser points from the camera's plane; there the noisy point also multiplies the unknown
rotation, which biases the answer with few poses. Here both sides are compared where the noise is, in range space
(see plane_pairs), and whitened by the covariances of the beams and of the board's pose.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy

from core.calibration.laser.plane_pairs import (
    UNKNOWNS_COUNT,
    Guess,
    Pair,
    StackedPairs,
    behind,
    chi_squares,
    residuals_of,
    stack,
    whitening,
)
from core.calibration.levenberg_marquardt import minimise
from core.calibration.mount import NAMES, Extrinsics, Mount
from core.calibration.projection import cross_matrices
from core.errors import BadInput
from core.geometry import Transform
from core.message import Array

MAX_CORRECTION_RAD = np.deg2rad(45)  # a mount turned by more is another one, not a better estimate of this one
FIRST_MISFIT = 1000.0  # at first: the mount is believed until the data have shown how well they agree …
MISFIT_ROUNDS = 5  # … which takes so many turns
FITTED_GAIN = 0.5  # gain below which a direction is not counted as fitted
LEAST_LEFT = 4  # poses that stay when others are left out


# Thresholds of the solve.
SOFT_LOSS_SDS = 3.0  # [standard deviations] scale of the soft-L1 loss while outliers may still be in
OUTLIER_CHI2 = 14.0  # chi-square of a pose (2 dof, 99.9 %), in units of the typical, above which it is left out
MIN_KEPT_SHARE = 0.6  # of the poses that stay, however bad
KNOWN_GAIN = 0.7  # a direction counts as known when the data shrink the sd of the mount by this share
RIVAL_COST_SHARE = 0.5  # another start wins only if its cost is below this share of the nominal mount's


@dataclass(frozen=True)
class Freedom:
    """Unknowns besides the six of the pose."""

    offset: bool = False  # the laser's range offset
    scale: bool = False  # the board's size

    @property
    def mask(self) -> Array:
        """(8,) bool."""
        return np.array([True] * 6 + [self.offset, self.scale])


class Minimum(NamedTuple):
    """The result of one minimisation."""

    guess: Guess
    information: Array  # (8, 8)
    cost: float


@dataclass
class ExtrinsicsProblem:
    """The pairs and what is known beforehand."""

    pairs: Sequence[Pair]
    mount: Mount
    free: Array  # (8,) bool
    used: Array = field(default_factory=lambda: np.zeros(0, bool))  # (M,)
    turned: bool = False  # another mount than the nominal one

    @property
    def measured(self) -> dict[str, str]:
        """The measured values of the mount, unless the data have shown it to be another one."""
        return {} if self.turned else self.mount.from_ruler

    def seen(self) -> StackedPairs:
        """The pairs that take part."""
        return stack([pair for pair, used in zip(self.pairs, self.used, strict=True) if used])


def solve(
    pairs: Sequence[Pair],
    mount: Mount | None = None,
    *,
    start: Transform | None = None,
    freedom: Freedom | None = None,
) -> Extrinsics:
    """Planes seen by both sensors → laser_from_camera with its covariance.

    Directions that the data leave open are named in `weak` and stay at the mount's nominal value within its sd.
    Raises BadInput with fewer than three pairs.
    """
    if len(pairs) < 3:
        raise BadInput(
            f"{len(pairs)} usable poses of the board are too few: at least 3 are needed, 10 to 20 are good."
        )
    freedom = freedom or Freedom()
    problem = ExtrinsicsProblem(pairs, mount or Mount(), freedom.mask, np.ones(len(pairs), bool))
    if start is None:
        start = _search(problem)
    answer, misfit = _without_outliers(problem, Guess(start.rotation, start.translation))
    gain = _gain(problem, answer.information)
    weak = tuple(name for name, value in zip(NAMES, gain, strict=True) if value < KNOWN_GAIN)
    if not weak:
        answer = _settle(problem, answer.guess)
        misfit = _misfit(problem, answer.guess, 0)
        answer = answer._replace(information=answer.information / max(1.0, misfit))
    covariance = np.linalg.pinv(answer.information[np.ix_(problem.free, problem.free)], hermitian=True)
    extra = list(np.sqrt(np.diag(covariance))[6:])
    scale = (answer.guess.scale, float(extra.pop())) if freedom.scale else None
    return Extrinsics(
        transform=Transform(rotation=answer.guess.rotation, translation=answer.guess.translation),
        covariance=covariance[:6, :6],
        used=problem.used,
        chi2=chi_squares(stack(pairs), answer.guess),
        misfit=misfit,
        gain=gain,
        weak=weak,
        measured=problem.measured,
        offset=(answer.guess.offset, float(extra.pop())) if freedom.offset else None,
        scale=scale,
    )


def _search(problem: ExtrinsicsProblem) -> Transform:
    """The nominal mount, or one of the 24 axis-aligned rotations if that explains the data far better.

    A rotation found that way replaces the nominal mount as the witness for what the data leave open.
    """
    nominal = problem.mount.nominal
    near, _ = _believing(problem, Guess(nominal.rotation, nominal.translation))
    least, best = float(np.median(chi_squares(problem.seen(), near))), nominal.rotation
    if least < OUTLIER_CHI2:
        return nominal
    least *= RIVAL_COST_SHARE
    turns = scipy.spatial.transform.Rotation.create_group("O").as_matrix()
    for turn in turns:
        other = _settle(problem, Guess(turn, np.zeros(3)), soft=SOFT_LOSS_SDS).guess
        middle = float(np.median(chi_squares(problem.seen(), other)))
        if middle < least and not behind(problem.seen(), other):
            least, best = middle, other.rotation
    if scipy.spatial.transform.Rotation.from_matrix(best @ nominal.rotation.T).magnitude() < MAX_CORRECTION_RAD:
        return nominal
    axes = turns[int(np.argmax(np.trace(turns @ best.T, axis1=1, axis2=2)))]
    problem.mount = Mount(nominal=Transform(rotation=axes, translation=np.zeros(3)), spread=problem.mount.spread)
    problem.turned = True
    return problem.mount.nominal


def _believing(problem: ExtrinsicsProblem, guess: Guess) -> tuple[Guess, float]:
    """Solve with the mount as a witness that is believed until the data have shown how well they agree."""
    misfit = FIRST_MISFIT
    for _ in range(MISFIT_ROUNDS):
        guess = _settle(problem, guess, soft=SOFT_LOSS_SDS, misfit=misfit, rounds=1).guess
        misfit = _typical(chi_squares(problem.seen(), guess))
    return guess, misfit


def _without_outliers(problem: ExtrinsicsProblem, guess: Guess) -> tuple[Minimum, float]:
    """Solve with the mount as a witness, leave out the pose that fits worst, solve again, while there is one."""
    while True:
        guess, misfit = _believing(problem, guess)
        worst = _worst(problem, guess)
        if worst is None:
            break
        problem.used[worst] = False
    misfit = max(misfit, FIRST_MISFIT / 10)
    for _ in range(MISFIT_ROUNDS):
        answer = _settle(problem, guess, misfit=misfit, rounds=1)
        guess = answer.guess
        misfit = _misfit(problem, guess, int(np.count_nonzero(_gain(problem, answer.information) < FITTED_GAIN)))
    return _settle(problem, guess, misfit=misfit, rounds=1), misfit


def _settle(
    problem: ExtrinsicsProblem,
    guess: Guess,
    *,
    soft: float | None = None,
    misfit: float | None = None,
    rounds: int = 4,
) -> Minimum:
    """Whiten, minimise, whiten again; with a `misfit` the mount takes part and the data weigh 1/misfit."""
    seen, mask, fit = problem.seen(), problem.free.astype(float), None
    shrink = 1 / np.sqrt(max(1.0, misfit or 1.0))
    for _ in range(rounds):
        residual_function = residuals_of(seen, whitening(seen, guess))

        def model(state: Guess, residual_function: object = residual_function) -> tuple[Array, Array]:
            residuals, slope = residual_function(state)  # type: ignore[operator]
            residuals, slope = residuals * shrink, slope * shrink * mask
            if misfit is not None:
                away, away_slope = _from_mount(problem.mount, state)
                residuals, slope = np.concatenate((residuals, away)), np.concatenate((slope, away_slope))
            return residuals, slope

        fit = minimise(model, guess, Guess.moved, soft=soft, iterations=30)
        guess = fit.state
    assert fit is not None
    return Minimum(guess, fit.information, fit.cost)


def _from_mount(mount: Mount, guess: Guess) -> tuple[Array, Array]:
    """Distance from the nominal mount in its standard deviations (6,) and the derivative (6, 8)."""
    turned = scipy.spatial.transform.Rotation.from_matrix(guess.rotation @ mount.nominal.rotation.T).as_rotvec()
    away = np.concatenate((turned, guess.translation - mount.nominal.translation))
    slope = np.zeros((6, UNKNOWNS_COUNT))
    cross = cross_matrices(turned)
    slope[:3, :3] = np.eye(3) - cross / 2 + cross @ cross / 12
    slope[3:, 3:6] = np.eye(3)
    return away / mount.sds, slope / mount.sds[:, None]


def _worst(problem: ExtrinsicsProblem, guess: Guess) -> int | None:
    """The pair that fits worst, if it is an outlier and enough others stay."""
    left = int(np.count_nonzero(problem.used))
    if left <= max(LEAST_LEFT, MIN_KEPT_SHARE * len(problem.pairs)):
        return None
    chi2 = np.where(problem.used, chi_squares(stack(problem.pairs), guess), 0.0)
    worst = int(np.argmax(chi2))
    return worst if chi2[worst] > OUTLIER_CHI2 * _typical(chi2[problem.used]) else None


def _typical(chi2: Array) -> float:
    """Chi-squares of two degrees of freedom → by how much the stated noise is too small, unmoved by outliers."""
    return max(1.0, float(np.median(chi2)) / 1.386)  # the median of chi-square with 2 dof


def _misfit(problem: ExtrinsicsProblem, guess: Guess, open_directions: int) -> float:
    """Chi-square per degree of freedom; 1 where no degree of freedom is left. Open directions explain nothing."""
    seen = problem.seen()
    whitened, _ = residuals_of(seen, whitening(seen, guess))(guess)
    unknowns = int(np.count_nonzero(problem.free)) - open_directions
    freedom = int(seen.ranks.sum()) + len(seen.points) - unknowns
    return float(whitened @ whitened) / freedom if freedom > 0 else 1.0


def _gain(problem: ExtrinsicsProblem, information: Array) -> Array:
    """Information (8, 8) of data and mount together → (6,): by how much the data shrink the sds of the mount."""
    free = problem.free
    sds = np.sqrt(np.diag(np.linalg.pinv(information[np.ix_(free, free)], hermitian=True)))[:6]
    return 1 - sds / problem.mount.sds
