"""Consistency of the model: could one camera, and one board of square squares, have made all the pictures?

The solution of all views is compared with what explains them better: two cameras, each of its own part of the views
(a mixture), squares that are longer one way, a board that is bent, another focal length. Where a rival explains much
more than noise can, the standard deviations of the single camera mean nothing, however small they are. Two focal
lengths that lie near each other hardly raise the errors; they are found by an F-test over groups of views.
"""

from typing import NamedTuple

import numpy as np
import scipy

from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners, NormalEquations
from core.calibration.projection import PAPER, PARAMETERS, Poses
from core.message import Array, message

LEAST_SHARE = 0.2  # of the squared errors that a rival must explain …
LEAST_F = 30.0  # … and by how much more per unknown than noise does
ASPECT_SDS, LEAST_ASPECT = 6.0, 0.002  # a square's height over its width differs from 1 by so many sds and by so much
BY_ASPECT = (len(PARAMETERS),)  # number in `equations`
BY_BEND = tuple(range(len(PARAMETERS) + 1, len(PARAMETERS) + 4))  # numbers in `equations`
LEAST_BEND = 0.0015  # of a board's diagonal, from its lowest to its highest corner, from which it is called bent
MAX_NOISE_RATIO = 2.0  # a part that another camera explains errs at most so many times more than the others
MIN_VIEWS = 3  # views that determine a camera of their own
MIXTURE_STARTS = 24  # beginnings of the mixture
MAX_ROUNDS = 40  # of the mixture, at most
MINORITY = 1 / 3  # share of the views up to which the others decide
PRIOR = np.array(
    [0.3, 0.3, 0.1, 0.1, 0.3, 0.5, 0.03, 0.03]
)  # of f, f, width, width, k1, k2, p1, p2: another camera's
FALSE_ALARM_CHANCE = 3e-5  # of two focal lengths where there is one, over all ways to part the views
SHARE_IN_TIME, SHARE_SORTED = 0.6, 0.8  # of the differences between the views' focal lengths, that two explain
SMALL_MINORITY = 1 / 6  # the same as MINORITY, where no view by itself is known to be odd
OWN_LEAST = 1e-6  # of a view's scaled information: below this it says nothing of a direction
SAME_FOCAL = 0.01  # share by which the focal lengths of one lens setting differ at most
NEARER_SHARE = 0.5  # a turned or mirrored picture's middle lies so much nearer to the other camera's than to its own
DOUBTFUL_FOCAL = 0.01  # share of f: standard deviations above this are checked by the likelihood itself
MAX_SD_RATIO = 1.25  # times the linear deviation: up to this it stays
WIDEST_FOCAL = 0.25  # share of f by which it may be wrong (two sds) before it counts as not decided
FARTHEST_FOCAL = 8.0  # times f: no farther focal length is tried
TWO_SDS = 2.0  # root of the rise of the squared errors, in units of the noise


@message
class PictureGroup:
    """Views that another camera explains far better than the one of the others."""

    views: Array  # (K,) numbers
    camera: Array  # (9,) that explains them
    rest: Array  # (9,) the camera of the others
    cause: str  # in words
    minority: float = MINORITY

    def is_minority(self, count: int) -> bool:
        """Return whether the others are so many of `count` views that they decide."""
        return len(self.views) <= self.minority * count


@message
class Aspect:
    """Height of a square over its width, as the pictures say."""

    value: float
    sd: float


@message
class Bend:
    """A board that is not flat, as the pictures say."""

    points: Array  # (N, 3) [m] of its corners
    depth: float  # [m] from the lowest to the highest


class FocalRange(NamedTuple):
    """Focal lengths that fit about as well as the best: two standard deviations either way."""

    low: float  # [pixel]
    high: float  # [pixel]


class _Split(NamedTuple):
    """Views in two parts and what explains each."""

    labels: Array  # (M,) 0 or 1; 1 is the smaller part
    solutions: tuple[BundleSolution, BundleSolution]  # of all views with each camera
    costs: Array  # (2, M) [pixel²]
    cause: str


def find_part(corners: Corners, solution: BundleSolution, size: tuple[int, int]) -> PictureGroup | None:
    """Find the smaller part of the views, if two cameras explain all of them much better than one does.

    `corners`: of every view, those of views that were left out too. Views that no camera explains are passed over.
    """
    open_views = np.arange(len(corners.pixels))
    while len(open_views) > MIN_VIEWS:
        some = corners.take(open_views)
        split = _split(some, BundleSolution(solution.camera, solution.poses.take(open_views)), size)
        if split is None:
            return None
        noise = _noise(some, split, 0)
        odd = split.labels == 1
        if _noise(some, split, 1) <= MAX_NOISE_RATIO * noise:
            return _significant(some, split, solution, open_views)
        open_views = open_views[~odd]
    return None


def find_two_focal_lengths(corners: Corners, solution: BundleSolution, known: NormalEquations) -> PictureGroup | None:
    """Find the smaller part of the used views, if two focal lengths explain them beyond doubt; None: one does.

    F-test over groups of views: the gain of a second focal length over what the views' own cameras would still gain,
    which also counts what no camera explains (a board that is not flat, another lens). The views are parted at a
    moment, or by their own focal lengths; the number of ways to do so is paid for.
    """
    kept = np.flatnonzero(corners.views_used)
    count = len(kept)
    if count < 2 * MIN_VIEWS:
        return None
    some = BundleSolution(solution.camera, solution.poses.take(kept))
    test = _FocalTest(corners.take(kept), some, NormalEquations(*(each[kept] for each in known.of(PAPER))))
    for order, ways, share in (
        (np.arange(count), float(count), SHARE_IN_TIME),
        (np.argsort(test.own), 2.0 ** (count - 1), SHARE_SORTED),
    ):
        gains = test.gains(order)[1:-2]  # of the first two views, the first three, ...
        gain, odd = float(gains.max()), np.isin(np.arange(count), order[: 2 + int(gains.argmax())])
        if gain > share * test.most_gain and ways * test.chance(gain) < FALSE_ALARM_CHANCE:
            odd = odd if 2 * odd.sum() <= count else ~odd
            rest, camera = test.cameras(odd)
            return PictureGroup(views=kept[odd], camera=camera, rest=rest, cause=ZOOMED, minority=SMALL_MINORITY)
    return None


class _FocalTest:
    """The quadratic costs of views about their common camera, and what a second focal length gains."""

    def __init__(self, some: Corners, pooled: BundleSolution, equations: NormalEquations) -> None:
        self._camera = pooled.camera
        self._precision, self._pull = equations
        self._spread = bundle_adjustment.covariance(self._precision.sum(axis=0), 1.0)
        self._along = np.zeros(len(PAPER))
        self._along[:2] = pooled.camera[:2]  # change with the logarithm of f
        by_view = self._precision @ self._along  # (M, P)
        stiff, force = np.maximum(by_view @ self._along, 1e-300), self._pull @ self._along
        self.own = -force / stiff  # (M,) logarithm of f
        self.most_gain = self._gain_of_own_focal_lengths(by_view, stiff, force)
        self._own_gain, self._own_freedom = _gain_of_own_cameras(self._precision, self._pull)
        freedom = 2 * np.count_nonzero(some.used) - 6 * len(some.pixels) - self._own_freedom
        self._noise = (float(_costs(some, pooled).sum()) - self._own_gain) / max(freedom, 1)  # [pixel²]

    def _gain_of_own_focal_lengths(self, by_view: Array, stiff: Array, force: Array) -> float:
        """Every view's focal length eliminated first, by the slope and curvature of its cost, then the camera."""
        pull = self._pull.sum(axis=0)
        rest = (self._pull - by_view * (force / stiff)[:, None]).sum(axis=0)
        scale = np.sqrt(np.diag(self._spread))  # what is left says nothing of a change of all focal lengths
        level = (self._precision.sum(axis=0) - by_view.T @ (by_view / stiff[:, None])) * np.outer(scale, scale)
        step = np.linalg.pinv(level, rcond=1e-9, hermitian=True) @ (rest * scale)
        return float(np.sum(force**2 / stiff) + step @ (rest * scale) - pull @ self._spread @ pull)

    def gains(self, order: Array) -> Array:
        """(M,): by how much a focal length of their own for the first views in `order` lowers the cost [pixel²]."""
        by_step = np.cumsum((self._precision @ self._along)[order], axis=0)
        force = np.cumsum(self._pull[order] @ self._along) - by_step @ self._spread @ self._pull.sum(axis=0)
        stiff = by_step @ self._along - np.sum(by_step @ self._spread * by_step, axis=1)
        return force**2 / np.maximum(stiff, 1e-300)

    def chance(self, gain: float) -> float:
        """Return how likely so much is gained where there is one focal length."""
        freedom = self._own_freedom - len(PAPER) - 1
        between = max((self._own_gain - gain) / freedom, self._noise)
        return float(scipy.special.fdtrc(1, freedom, gain / max(between, 1e-300)))

    def cameras(self, odd: Array) -> tuple[Array, Array]:
        """Return the cameras (9,) of the others and of the views `odd`."""
        by_step = self._precision[odd].sum(axis=0) @ self._along
        force = self._along @ self._pull[odd].sum(axis=0) - by_step @ self._spread @ self._pull.sum(axis=0)
        apart = -force / (self._along @ by_step - by_step @ self._spread @ by_step)
        pull = self._pull.sum(axis=0) + self._precision[odd].sum(axis=0) @ self._along * apart
        rest, other = self._camera.copy(), self._camera.copy()
        rest[list(PAPER)] -= self._spread @ pull
        other[list(PAPER)] = rest[list(PAPER)] + apart * self._along
        return rest, other


def _significant(some: Corners, split: _Split, solution: BundleSolution, open_views: Array) -> PictureGroup | None:
    """The part, if two cameras explain much more than noise would give them."""
    pooled = bundle_adjustment.refine(
        some, BundleSolution(split.solutions[0].camera, split.solutions[0].poses), PAPER
    )
    before = float(_costs(some, pooled).sum())
    after = float(np.choose(split.labels, split.costs).sum())
    if not _explains(some, before, after) or _chance_of_parts(some, split, before - after) > FALSE_ALARM_CHANCE:
        return None
    return PictureGroup(
        views=open_views[split.labels == 1],
        camera=split.solutions[1].camera,
        rest=split.solutions[0].camera,
        cause=split.cause,
    )


def _chance_of_parts(some: Corners, split: _Split, gain: float) -> float:
    """Return how likely two cameras gain so much [pixel²] where there is one that explains no view quite."""
    own_gain, freedom = 0.0, -2 * len(PAPER)
    for label, solution in enumerate(split.solutions):
        which = split.labels == label
        part = BundleSolution(solution.camera, solution.poses.take(which))
        more, known = _gain_of_own_cameras(*bundle_adjustment.equations(some.take(which), part).of(PAPER))
        own_gain, freedom = own_gain + more, freedom + known
    between = max(own_gain / max(freedom, 1), 1e-300)
    ways = 2.0 ** (len(some.pixels) - 1)
    return ways * float(scipy.special.fdtrc(len(PAPER), max(freedom, 1), gain / len(PAPER) / between))


def _gain_of_own_cameras(precision: Array, pull: Array) -> tuple[float, int]:
    """The gain of a camera of its own for every view in all [pixel²], and the number of its unknowns."""
    scale = 1 / np.sqrt(np.maximum(np.einsum("mii->mi", precision), 1e-300))
    values, vectors = np.linalg.eigh(precision * scale[:, :, None] * scale[:, None, :])
    parts = np.einsum("mij,mi->mj", vectors, pull * scale)
    known = values > OWN_LEAST
    return float(np.sum(parts[known] ** 2 / values[known])), int(known.sum())


def _explains(some: Corners, before: float, after: float) -> bool:
    freedom = max(2 * np.count_nonzero(some.used) - 2 * len(PAPER) - 6 * len(some.pixels), 1)
    gain = before - after
    return gain > LEAST_SHARE * before and gain / len(PAPER) > LEAST_F * after / freedom


def _split(some: Corners, solution: BundleSolution, size: tuple[int, int]) -> _Split | None:
    """The two parts that two cameras explain best: by the quadratic costs first, then solved in full."""
    solution = BundleSolution(solution.camera, bundle_adjustment.refine_poses(some, solution))
    labels = _mixture(some, solution)
    if labels is None:
        return None
    split = None
    for _ in range(6):
        split = _solved(some, solution, labels, size)
        again = np.argmin(split.costs, axis=0)
        if np.array_equal(again, split.labels) or not 0 < again.sum() <= len(again) / 2:
            break
        labels = again
    return split


def _mixture(some: Corners, solution: BundleSolution) -> Array | None:
    """(M,) 0 or 1: the parts whose own cameras lower the cost most, to second order; None where none does much."""
    precision, pull = bundle_adjustment.equations(some, solution).of(PAPER)
    costs = _costs(some, solution)
    most = float(costs.sum())
    if not _explains(some, most, max(most - _gain_of_own_cameras(precision, pull)[0], 1e-12 * most)):
        return None  # not even a camera of its own for every view would explain that much
    noise = float(np.median(costs / np.maximum(2 * some.used.sum(axis=1) - 6, 1)))
    scale = np.array([*solution.camera[:2], *[2 * solution.camera[2]] * 2, 1, 1, 1, 1])
    prior = np.diag(noise / (PRIOR * scale) ** 2)
    whole = _best_step(precision, pull, prior)
    before = float((costs + _gains(precision, pull, whole)).sum())
    lone = _gains(precision, pull, -np.linalg.solve(precision + prior, pull[..., None])[..., 0], own=True)
    rng = np.random.default_rng(0)
    begun = [np.arange(len(costs)) == number for number in np.argsort(lone)[: MIXTURE_STARTS // 2]]
    begun += [rng.random(len(costs)) < 0.5 for _ in range(MIXTURE_STARTS // 2)]
    tried = [_settled(precision, pull, prior, labels) for labels in begun]
    least, labels = min(tried, key=lambda each: each[0])
    after = float(costs.sum()) + least
    return labels if _explains(some, before, max(after, 1e-12 * before)) else None


def _settled(precision: Array, pull: Array, prior: Array, odd: Array) -> tuple[float, Array]:
    """Assign views and solve parts in turn → the change of the cost, and (M,) 0 or 1, 1 the smaller part."""
    change = np.zeros((2, len(pull)))
    for _ in range(MAX_ROUNDS):
        if odd.all() or not odd.any():
            return 0.0, np.zeros(len(pull), int)
        steps = [_best_step(precision[part], pull[part], prior) for part in (~odd, odd)]
        change = np.stack([_gains(precision, pull, step) for step in steps])
        again = change[1] < change[0]
        if np.array_equal(again, odd):
            break
        odd = again
    odd = odd if odd.sum() <= len(odd) / 2 else ~odd
    return float(change.min(axis=0).sum()), odd.astype(int)


def _best_step(precision: Array, pull: Array, prior: Array) -> Array:
    return -np.linalg.solve(precision.sum(axis=0) + prior, pull.sum(axis=0))


def _gains(precision: Array, pull: Array, step: Array, *, own: bool = False) -> Array:
    """(M,): change of every view's cost by a step (P,) of the camera, or by its `own` step (M, P)."""
    if own:
        return np.einsum("mp,mpq,mq->m", step, precision, step) + 2 * np.sum(pull * step, axis=1)
    return np.einsum("p,mpq,q->m", step, precision, step) + 2 * pull @ step


def _solved(some: Corners, solution: BundleSolution, labels: Array, size: tuple[int, int]) -> _Split:
    """Solve both parts; a part too small for a camera of its own gets the one that a cause would give it."""
    odd = labels == 1
    rest = _with_camera(some, solution, _refined(some, solution, ~odd))
    few = some.take(odd)
    tried = [
        (_with_camera(few, BundleSolution(rest.camera, rest.poses.take(odd)), camera), cause)
        for camera, cause in _other_settings(few, rest.camera, rest.poses.take(odd), size)
    ]
    best, cause = min(tried, key=lambda each: float(_costs(few, each[0]).sum()))
    camera = best.camera
    if odd.sum() >= MIN_VIEWS:
        camera = _refined(some, solution, odd)
        cause = _cause(camera, rest.camera, size)
    other = _with_camera(some, rest, camera)
    return _Split(labels, (rest, other), np.stack([_costs(some, each) for each in (rest, other)]), cause)


def _refined(some: Corners, solution: BundleSolution, which: Array) -> Array:
    """The camera (9,) of a part of the views."""
    part = BundleSolution(solution.camera, solution.poses.take(which))
    return bundle_adjustment.refine(some.take(which), part, PAPER).camera


def _with_camera(some: Corners, solution: BundleSolution, camera: Array) -> BundleSolution:
    """The views' poses fitted to another camera."""
    moved = _zoomed(solution.poses, camera[0] / solution.camera[0])
    return BundleSolution(camera, bundle_adjustment.refine_poses(some, BundleSolution(camera, moved), steps=30))


def _zoomed(poses: Poses, factor: float) -> Poses:
    """Boards as far away as a camera with `factor` times the focal length sees them alike."""
    return Poses(poses.rotations, poses.translations * np.array([1.0, 1.0, factor]))


def _other_settings(few: Corners, camera: Array, poses: Poses, size: tuple[int, int]) -> list[tuple[Array, str]]:
    """The cameras that the pictures would have had if they had been turned, mirrored or zoomed."""
    found = [(_moved(camera, focal, middle), cause) for focal, middle, cause in _turned(camera, size)]
    zoomed = camera
    for _ in range(8):  # Gauss-Newton in the logarithm of f
        here = _with_camera(few, BundleSolution(camera, poses), zoomed)
        precision, pull = bundle_adjustment.equations(few, here).of((0, 1))
        along = zoomed[:2]
        step = -float(along @ pull.sum(axis=0)) / max(float(along @ precision.sum(axis=0) @ along), 1e-300)
        zoomed = _moved(zoomed, zoomed[:2] * np.exp(np.clip(step, -0.3, 0.3)), zoomed[2:4])
    return [*found, (zoomed, ZOOMED)]


ZOOMED = "zoom or focus was moved"


def _turned(camera: Array, size: tuple[int, int]) -> list[tuple[Array, Array, str]]:
    """Focal lengths (2,), principal point (2,) and cause of pictures that were turned or mirrored."""
    focal, middle = camera[:2], camera[2:4]
    across, down = np.array(size) - 1 - middle
    found = [
        (focal, np.array([across, down]), "the pictures were turned by half a turn"),
        (focal, np.array([across, middle[1]]), "the pictures were mirrored"),
        (focal, np.array([middle[0], down]), "the pictures were mirrored upside down"),
    ]
    if size[0] == size[1]:
        quarter = "the pictures were turned by a quarter"
        found += [
            (focal[::-1], np.array([down, middle[0]]), quarter),
            (focal[::-1], np.array([middle[1], across]), quarter),
        ]
    return found


def _moved(camera: Array, focal: Array, middle: Array) -> Array:
    return np.concatenate((focal, middle, camera[4:]))


def _cause(camera: Array, rest: Array, size: tuple[int, int]) -> str:
    """Describe what makes one camera of the other."""
    if abs(np.log(camera[:2].mean() / rest[:2].mean())) > SAME_FOCAL:
        return ZOOMED
    apart = float(np.linalg.norm(camera[2:4] - rest[2:4]))
    away, cause = min(
        (float(np.linalg.norm(middle - camera[2:4])), cause) for _, middle, cause in _turned(rest, size)
    )
    return cause if away < NEARER_SHARE * apart else "another camera, or its lens was moved"


def equations(corners: Corners, solution: BundleSolution) -> NormalEquations:
    """The normal equations of PARAMETERS, the squares' aspect (BY_ASPECT) and the board's bend (BY_BEND)."""
    points, bends = corners.points, _bends(corners.points)
    return bundle_adjustment.equations(
        corners, solution, (points * (0.0, 1.0, 0.0), *(each[:, None] * (0.0, 0.0, 1.0) for each in bends.T))
    )


def find_aspect(corners: Corners, solution: BundleSolution, known: NormalEquations) -> Aspect | None:
    """The squares' height over their width, if it is not 1 beyond doubt; `known`: the equations at this solution."""
    noise = bundle_adjustment.noise(corners, solution, PAPER)
    found, scaled, sd = 1.0, corners, 1.0
    for turn in range(4):
        precision, pull = (known if turn == 0 else equations(scaled, solution)).of((*PAPER, *BY_ASPECT))
        covariance = bundle_adjustment.covariance(precision.sum(axis=0), 1.0)
        step, sd = float(-(covariance @ pull.sum(axis=0))[-1]), float(np.sqrt(covariance[-1, -1]))
        if turn == 0 and abs(step) < max(LEAST_ASPECT / 2, ASPECT_SDS / 2 * sd * noise):
            return None
        found *= 1 + step
        scaled = corners._replace(points=corners.points * (1.0, found, 1.0))
        solution = bundle_adjustment.refine(scaled, solution, PAPER)
    sd *= bundle_adjustment.noise(scaled, solution, PAPER)
    if abs(found - 1) < max(ASPECT_SDS * sd, LEAST_ASPECT):
        return None
    return Aspect(value=found, sd=sd)


def find_bend(
    corners: Corners, solution: BundleSolution, known: NormalEquations, least_bend: float = LEAST_BEND
) -> Bend | None:
    """The board's shape by heights of second order across it, if the used views show beyond doubt that it is bent, by
    so much of its diagonal at least. `known`: the equations at this solution.
    """
    flat, bends = corners.points, _bends(corners.points)
    found, curved = np.zeros(bends.shape[1]), corners
    covariance = np.zeros((0, 0))
    least = least_bend * 2 * float(np.linalg.norm(flat - flat.mean(axis=0), axis=1).max())
    for turn in range(3):
        precision, pull = (known if turn == 0 else equations(curved, solution)).of((*PAPER, *BY_BEND))
        covariance = bundle_adjustment.covariance(precision.sum(axis=0), 1.0)
        found = found - (covariance @ pull.sum(axis=0))[len(PAPER) :]
        if turn == 0 and np.ptp(bends @ found) < least / 2:
            return None
        curved = corners._replace(points=_raised(flat, bends @ found))
        solution = bundle_adjustment.refine(curved, solution, PAPER)
    noise = bundle_adjustment.noise(curved, solution, PAPER)
    own = covariance[len(PAPER) :, len(PAPER) :] * noise**2
    depth = float(np.ptp(bends @ found))
    if depth < least or found @ np.linalg.solve(own, found) < LEAST_F * len(found):
        return None
    return Bend(points=curved.points, depth=depth)


def _bends(points: Array) -> Array:
    """(N, 3): heights of a board whose corners (N, 3) are bent along, across and askew, in half its diagonal."""
    away = points[:, :2] - points[:, :2].mean(axis=0)
    size = float(np.linalg.norm(away, axis=1).max())
    x, y = (away / size).T
    return size * np.column_stack((x * x, y * y, x * y))


def _raised(points: Array, heights: Array) -> Array:
    return points + heights[:, None] * (0.0, 0.0, 1.0)


def focal_range(corners: Corners, solution: BundleSolution, free: tuple[int, ...], sd: float) -> FocalRange:
    """The focal lengths that fit the used views, by the likelihood: where little is known, it is no parabola.

    `sd` [pixel]: the linear one, the first step.
    """
    kept = corners.views_used
    some, here = corners.take(kept), BundleSolution(solution.camera, solution.poses.take(kept))
    others = tuple(number for number in free if number != 0)
    noise = bundle_adjustment.noise(some, here, free) ** 2
    tried = [(float(here.camera[0]), float(_costs(some, here).sum()), here)]
    for sign in (-1, 1):
        tried = _walked(some, tried, others, noise, sign * max(sd / here.camera[0], DOUBTFUL_FOCAL))
    tried.sort(key=lambda each: each[0])
    focal = np.array([each[0] for each in tried])
    rise = np.array([each[1] for each in tried])
    rise = np.sqrt(np.maximum(rise - rise.min(), 0) / noise)
    inside = np.flatnonzero(rise <= TWO_SDS)
    low = np.interp(TWO_SDS, rise[inside[0] :: -1][:2], focal[inside[0] :: -1][:2])
    high = np.interp(TWO_SDS, rise[inside[-1] :][:2], focal[inside[-1] :][:2])
    return FocalRange(float(low), float(high))


def _walked(
    some: Corners,
    tried: list[tuple[float, float, BundleSolution]],
    others: tuple[int, ...],
    noise: float,
    step: float,
) -> list[tuple[float, float, BundleSolution]]:
    """Solve for other focal lengths, farther and farther, until they fit no more."""
    first = tried[0][0]
    focal, here = first, tried[0][2]
    tried = list(tried)
    while 1 / FARTHEST_FOCAL < focal / first < FARTHEST_FOCAL:
        factor = float(np.exp(step))
        camera = here.camera.copy()
        camera[:2] *= factor
        camera[4:6] *= (factor**2, factor**4)
        here = _with_camera(some, here, camera)
        here = bundle_adjustment.refine(some, here, others)
        focal, cost = float(here.camera[0]), float(_costs(some, here).sum())
        tried.append((focal, cost, here))
        if cost > min(each[1] for each in tried) + 2 * TWO_SDS**2 * noise:
            break
        step *= 1.3
    return tried


def _costs(corners: Corners, solution: BundleSolution) -> Array:
    """(M,) [pixel²] of every view."""
    return np.sum(np.sum(bundle_adjustment.errors(corners, solution) ** 2, axis=2) * corners.used, axis=1)


def _noise(some: Corners, split: _Split, part: int) -> float:
    """[pixel] of a corner's coordinate in one part."""
    which = split.labels == part
    freedom = 2 * np.count_nonzero(some.used[which]) - 6 * which.sum()
    return float(np.sqrt(split.costs[part][which].sum() / max(freedom, 1)))
