"""Consistency of the model: could one camera, and one board of square squares, have made all the pictures?

The solution of all views is compared with what explains them better: two cameras, each of its own part of the views
(a mixture), squares that are longer one way or off a right angle, a board that is bent, another focal length. Where a
rival explains much more than noise can, the standard deviations of the single camera mean nothing, however small they
are. What hardly raises the errors (a focal length or a principal point that differs from view to view, a board that
moves while its rows are read or gives way in the hand, skew) is found by tests of the score.
"""

from typing import NamedTuple

import numpy as np
import scipy

from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners, NormalEquations
from core.calibration.projection import BY_ROW, PAPER, PARAMETERS, Poses
from core.message import Array, message

LEAST_SHARE = 0.2  # of the squared errors that a rival must explain …
LEAST_F = 30.0  # … and by how much more per unknown than noise does
LEAST_STRENGTH = 36.0  # square of the standard deviations by which a board's shape differs, per unknown
LEAST_ASPECT = 0.002  # by which a square's height over its width differs from 1
LEAST_SHEAR = 0.002  # by which a column moves along the rows, per unit of its length
SHAPES = {
    "board.unequal_squares": (len(PARAMETERS),),
    "board.sheared": (len(PARAMETERS) + 1,),
    "board.bent": tuple(range(len(PARAMETERS) + 2, len(PARAMETERS) + 5)),
}
"""Numbers of a board's unknowns in `equations`, by the code of their check."""
SHAPE_TURNS = 3  # of solving for a board's shape and the camera by turns
LEAST_BEND = 0.0015  # of a board's diagonal, from its lowest to its highest corner, from which it is called bent
MAX_NOISE_RATIO = 2.0  # a part that another camera explains errs at most so many times more than the others
MIN_VIEWS = 3  # views that determine a camera of their own
MINORITY = 1 / 3  # share of the views up to which the others decide
PRIOR = np.array(
    [0.3, 0.3, 0.1, 0.1, 0.3, 0.5, 0.03, 0.03]
)  # of f, f, width, width, k1, k2, p1, p2: another camera's
FALSE_ALARM_CHANCE = 3e-5  # of two cameras, or a variation, where there is none, over all ways that are tried
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
    left: float  # [pixel²] of the squared errors, per degree of freedom

    def is_minority(self, count: int) -> bool:
        """Return whether the others are so many of `count` views that they decide."""
        return len(self.views) <= MINORITY * count


@message
class BoardShape:
    """A board that is not as printed, as the pictures say."""

    points: Array  # (N, 3) [m] of its corners
    extents: dict[str, float]  # by code: height of a square over its width, less 1; shear; or of a bend [m]
    unknowns: tuple[int, ...]  # numbers in `equations`


@message
class Variation:
    """A difference from view to view, or something that no camera has."""

    code: str  # of the check
    extent: float  # share of f; of the principal point, or the corners [pixel]; of a skew [degree]; of a bend [m]
    excess: float  # times what noise gains
    left: float  # [pixel²] of the squared errors, per degree of freedom


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


def find_part(
    corners: Corners, solution: BundleSolution, known: NormalEquations, size: tuple[int, int]
) -> PictureGroup | None:
    """Find the smaller part of the views, if two cameras explain all of them much better than one does.

    `corners`: of every view, those of views that were left out too, each in its best pose; `known`: the equations at
    this solution. Views that no camera explains are passed over.
    """
    open_views = np.arange(len(corners.pixels))
    while len(open_views) > MIN_VIEWS:
        some = corners.take(open_views)
        here = BundleSolution(solution.camera, solution.poses.take(open_views))
        split = _split(some, here, known.take(open_views), size)
        if split is None:
            return None
        noise = _noise(some, split, 0)
        odd = split.labels == 1
        if _noise(some, split, 1) <= MAX_NOISE_RATIO * noise:
            return _significant(some, split, open_views)
        open_views = open_views[~odd]
    return None


def find_variation(corners: Corners, solution: BundleSolution, known: NormalEquations) -> Variation | None:
    """Find what differs from view to view, or is as in no camera, if it does so beyond doubt in the used views.

    `known`: the `equations` at this solution.

    Score tests of a focal length, a principal point, a motion and a bend of the board of its own for every view, and
    of a skew for all, against what the views' own cameras, motions and bends gain besides. That also counts what no
    camera explains (another lens); the board's shape up to second order, in its plane and out of it, is allowed for.
    """
    kept = np.flatnonzero(corners.views_used)
    some, here = corners.take(kept), BundleSolution(solution.camera, solution.poses.take(kept))
    known = known.take(kept)
    unit = np.eye(known.pull.shape[1])
    none, common, motion = unit[:, :0], unit[:, : 1 - BY_ROW], unit[:, 1 - BY_ROW :]
    bends = unit[:, SHAPES["board.bent"]]
    square, whole = (_gain(known, none, each) for each in (common[:, :-1], common))
    most = _gain(known, np.hstack((unit[:, : len(PAPER)], motion, bends)), common)
    cost, count = float(_costs(some, here).sum()), 2 * np.count_nonzero(some.used) - 6 * len(kept)
    noise = max((cost - most.amount) / max(count - most.freedom, 1), 1e-300)  # [pixel²]
    tried = {"camera.skew": whole}
    chances = {"camera.skew": _chance_of_gain(whole, square, _rest(most, whole, noise))}
    for code, own in (
        ("camera.focal_varies", unit[:, :2] @ here.camera[:2, None]),  # changes with the logarithm of f
        ("camera.middle_varies", unit[:, 2:4]),
        ("camera.rows_late", motion),
        ("board.flexes", bends),
    ):
        tried[code] = _gain(known, own, common)
        rest = _rest(most, tried[code], noise)
        chances[code] = min(
            _chance_of_gain(tried[code], whole, rest), _chance(*_score(known, own, common, whole), rest)
        )
    least = np.log(FALSE_ALARM_CHANCE / 2 / len(chances))
    beyond = {code: tried[code] for code, chance in chances.items() if chance < least}
    if not beyond:
        return None
    code, gain = min(beyond.items(), key=lambda each: 2 * each[1].freedom - each[1].amount / noise)  # Akaike
    left = (cost - gain.amount) / max(count - gain.freedom, 1)
    if code == "camera.skew":
        extent = float(np.rad2deg(np.arctan(gain.common[-1] / here.camera[1])))
    elif code == "camera.rows_late":
        extent = float(np.sqrt((gain.amount - whole.amount) / np.count_nonzero(some.used)))
    else:
        weights = np.einsum("mii->m", gain.information)
        if code == "board.flexes":
            squares = weights * np.ptp(gain.own @ _bends(some.points).T, axis=1) ** 2
        else:
            squares = np.einsum("mi,mij,mj->m", gain.own, gain.information, gain.own) * gain.own.shape[1]
        extent = float(np.sqrt(squares.sum() / weights.sum()))
    excess = (gain.amount - whole.amount) / max(gain.freedom - whole.freedom, 1) / noise
    return Variation(code=code, extent=extent, excess=excess, left=left)


class _Gain(NamedTuple):
    """The gain of unknowns of every view's own, and of some that all have in common, to second order."""

    amount: float  # [pixel²]
    freedom: int  # number of the unknowns that the views tell
    common: Array  # (S,) best step
    own: Array  # (M, K) best steps
    information: Array  # (M, K, K) [1/pixel²] of the own ones


def _gain(known: NormalEquations, own: Array, common: Array) -> _Gain:
    """Eliminate unknowns of every view's own (P, K), then solve for common ones (P, S), all by their directions."""
    information = own.T @ known.precision @ own
    scale = 1 / np.sqrt(np.maximum(np.einsum("mii->mi", information), 1e-300))
    values, vectors = np.linalg.eigh(information * scale[:, :, None] * scale[:, None, :])
    determined = values > OWN_LEAST
    root = scale[:, :, None] * vectors * (determined / np.sqrt(np.where(determined, values, 1.0)))[:, None, :]
    force = np.einsum("mkj,mk->mj", root, known.pull @ own)
    mixed = common.T @ known.precision @ own @ root
    whole = common.T @ known.precision.sum(axis=0) @ common
    size = 1 / np.sqrt(np.maximum(np.diag(whole), 1e-300))
    level = (whole - np.tensordot(mixed, mixed, ((0, 2), (0, 2)))) * np.outer(size, size)
    pull = (known.pull.sum(axis=0) @ common - np.tensordot(mixed, force, ((0, 2), (0, 1)))) * size
    inverse = np.linalg.pinv(level, rcond=1e-9, hermitian=True)  # what is left may say nothing of what all share
    step = -size * (inverse @ pull)
    return _Gain(
        amount=float(np.sum(force**2) + pull @ inverse @ pull),
        freedom=int(determined.sum()) + round(np.sum(inverse * level)),
        common=step,
        own=-np.einsum("mkj,mj->mk", root, force + step @ mixed),
        information=information,
    )


def _score(known: NormalEquations, own: Array, common: Array, base: _Gain) -> tuple[float, Array]:
    """The squares of the pulls on unknowns of every view's own (P, K), where the common ones (P, S) are best, and the
    weights of χ² of one degree of which noise makes them at most.
    """
    level = own.T @ known.precision @ own
    scale = 1 / np.sqrt(np.maximum(np.diag(level.sum(axis=0)), 1e-300))
    pull = (known.pull @ own + own.T @ known.precision @ common @ base.common) * scale
    return float(np.sum(pull**2)), np.linalg.eigvalsh(level * np.outer(scale, scale)).ravel()


def _rest(most: _Gain, gain: _Gain, noise: float) -> tuple[float, int]:
    """Return what the views gain besides, per unknown [pixel²], and the number of these unknowns."""
    freedom = max(most.freedom - gain.freedom, 1)
    return max((most.amount - gain.amount) / freedom, noise), freedom


def _chance_of_gain(gain: _Gain, base: _Gain, rest: tuple[float, int]) -> float:
    """Return the logarithm of how likely so much more than `base` is gained where it is noise."""
    return _chance(gain.amount - base.amount, np.ones(max(gain.freedom - base.freedom, 1)), rest)


def _chance(amount: float, weights: Array, rest: tuple[float, int]) -> float:
    """Return the logarithm of how likely a sum of weighted χ² of one degree is as great, measured by the rest.

    Saddle point approximation of Lugannani and Rice, for the sum minus `amount` times the rest's χ².
    """
    between, freedom = rest
    share = amount / between / freedom
    if share * freedom <= float(weights.sum()):
        return 0.0

    def slope(at: float) -> float:
        return float(np.sum(weights / (1 - 2 * weights * at))) - freedom * share / (1 + 2 * share * at)

    at = float(scipy.optimize.brentq(slope, 0.0, (1 - 1e-9) / (2 * weights.max())))
    height = float(np.sum(np.log1p(-2 * weights * at)) + freedom * np.log1p(2 * share * at))  # -2 x the cumulant
    curve = np.sum((weights / (1 - 2 * weights * at)) ** 2) + freedom * (share / (1 + 2 * share * at)) ** 2
    root, along = np.sqrt(height), at * np.sqrt(2 * curve)
    return float(scipy.special.log_ndtr(-root - np.log(along / root) / root)) if root > 1 else 0.0


def _significant(some: Corners, split: _Split, open_views: Array) -> PictureGroup | None:
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
        left=after / _freedom(some),
    )


def _chance_of_parts(some: Corners, split: _Split, gain: float) -> float:
    """Return how likely two cameras gain so much [pixel²] where there is one that explains no view quite."""
    own_gain, freedom = 0.0, -2 * len(PAPER)
    for label, solution in enumerate(split.solutions):
        which = split.labels == label
        part = BundleSolution(solution.camera, solution.poses.take(which))
        own = _gain_of_own_cameras(bundle_adjustment.equations(some.take(which), part).of(PAPER))
        own_gain, freedom = own_gain + own.amount, freedom + own.freedom
    between = max(own_gain / max(freedom, 1), 1e-300)
    ways = 2.0 ** (len(some.pixels) - 1)
    return ways * float(scipy.special.fdtrc(len(PAPER), max(freedom, 1), gain / len(PAPER) / between))


def _gain_of_own_cameras(known: NormalEquations) -> _Gain:
    unit = np.eye(known.pull.shape[1])
    return _gain(known, unit, unit[:, :0])


def disagreement(known: NormalEquations, noise: float, freedom: int) -> float:
    """How many times as much as the corners' noise lets them the views' own cameras differ, as deviations; 1 where
    they do not beyond doubt.

    `known`: the equations of the used views by the free parameters, `noise` [pixel] with its degrees of freedom.
    """
    own = _gain_of_own_cameras(known)
    degrees = own.freedom - known.pull.shape[1]
    if degrees < 1:
        return 1.0
    ratio = own.amount / degrees / max(noise, 1e-12) ** 2
    beyond_doubt = float(scipy.special.fdtrc(degrees, max(freedom, 1), ratio)) < FALSE_ALARM_CHANCE
    return float(np.sqrt(ratio)) if beyond_doubt else 1.0


def _explains(some: Corners, before: float, after: float) -> bool:
    gain = before - after
    return gain > LEAST_SHARE * before and gain / len(PAPER) > LEAST_F * after / _freedom(some)


def _freedom(some: Corners) -> int:
    """Degrees of freedom of the errors where two cameras explain the views."""
    return max(2 * int(np.count_nonzero(some.used)) - 2 * len(PAPER) - 6 * len(some.pixels), 1)


def _split(some: Corners, solution: BundleSolution, known: NormalEquations, size: tuple[int, int]) -> _Split | None:
    """The two parts that two cameras explain best: by the quadratic costs first, then solved in full."""
    labels = _mixture(some, solution, known.of(PAPER))
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


def _mixture(some: Corners, solution: BundleSolution, known: NormalEquations) -> Array | None:
    """(M,) 0 or 1: the parts whose own cameras lower the cost most, to second order; None where none does much.

    Views of another camera pull its way, however their boards are held. So the views are put in order along every
    direction of their pulls at the common camera, and parted where two cameras gain most; 1 is the smaller part.
    """
    (precision, pull), costs = known, _costs(some, solution)
    most = float(costs.sum())
    if not _explains(some, most, max(most - _gain_of_own_cameras(known).amount, 1e-12 * most)):
        return None  # not even a camera of its own for every view would explain that much
    noise = float(np.median(costs / np.maximum(2 * some.used.sum(axis=1) - 6, 1)))
    scale = PRIOR * np.array([*solution.camera[:2], *[2 * solution.camera[2]] * 2, 1, 1, 1, 1])
    prior, whole, force = np.diag(noise / scale**2), precision.sum(axis=0), pull.sum(axis=0)
    pulls = pull - precision @ np.linalg.solve(whole + prior, force)
    pulls = np.linalg.solve(np.linalg.cholesky(whole + prior), pulls.T).T  # what is noise is alike in all directions
    gain, part = 0.0, np.empty(0, int)
    for direction in np.linalg.svd(pulls, full_matrices=False)[2]:
        order = np.argsort(pulls @ direction)
        first = np.cumsum(precision[order], axis=0)[:-1], np.cumsum(pull[order], axis=0)[:-1]
        gains = _gains(first[0] + prior, first[1]) + _gains(whole - first[0] + prior, force - first[1])
        count = int(np.argmax(gains)) + 1
        if gains[count - 1] > gain:
            gain, part = (
                float(gains[count - 1]),
                min(order[:count], order[count:], key=lambda each: (len(each), 0 in each)),
            )
    before = most - float(_gains(whole + prior, force))
    labels = np.isin(np.arange(len(costs)), part).astype(int)
    return labels if _explains(some, before, max(most - gain, 1e-12 * before)) else None


def _gains(precision: Array, pull: Array) -> Array:
    """(…): by how much the cost falls with the best step of the camera (…, P)."""
    return np.sum(pull * np.linalg.solve(precision, pull[..., None])[..., 0], axis=-1)


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
    zoom = np.array([1.0, 1.0, camera[0] / solution.camera[0]])  # boards as far away as it sees them alike
    moved = Poses(solution.poses.rotations, solution.poses.translations * zoom)
    return BundleSolution(camera, bundle_adjustment.refine_poses(some, BundleSolution(camera, moved), steps=30))


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
    if abs(np.log(camera[:2].mean() / rest[:2].mean())) > SAME_FOCAL:
        return ZOOMED
    apart = float(np.linalg.norm(camera[2:4] - rest[2:4]))
    away, cause = min(
        (float(np.linalg.norm(middle - camera[2:4])), cause) for _, middle, cause in _turned(rest, size)
    )
    return cause if away < NEARER_SHARE * apart else "another camera, or its lens was moved"


def equations(corners: Corners, solution: BundleSolution) -> NormalEquations:
    """The normal equations of PARAMETERS, of the board's SHAPES, of bends in its plane, and by the picture's row."""
    in_plane = [each[:, None] * axis for each in _bends(corners.points).T for axis in np.eye(3)[:2]]
    return bundle_adjustment.equations(corners, solution, (*_shapes(corners.points), *in_plane), rows=True)


def _shapes(points: Array) -> list[Array]:
    """Displacements (N, 3) of a board's corners (N, 3) per unit of SHAPES: taller squares, shear, then bends."""
    return [
        points * (0.0, 1.0, 0.0),
        points[:, [1, 0, 2]] * (1.0, 0.0, 0.0),
        *(each[:, None] * (0.0, 0.0, 1.0) for each in _bends(points).T),
    ]


def find_shape(
    least: dict[str, float], corners: Corners, solution: BundleSolution, known: NormalEquations
) -> BoardShape | None:
    """The board's shape in some of the SHAPES, if the used views show beyond doubt that it is not as printed in each
    of them, by an extent of `least`. `known`: the equations at this solution.
    """
    unknowns = tuple(number for code in least for number in SHAPES[code])
    shaped, extents = corners, dict[str, float]()
    own = {code: np.isin(unknowns, SHAPES[code]) for code in least}
    forms, found = np.stack(_shapes(corners.points))[np.array(unknowns) - len(PARAMETERS)], np.zeros(len(unknowns))
    for turn in range(SHAPE_TURNS + 1):
        precision, pull = (known if turn == 0 else equations(shaped, solution)).of((*PAPER, *unknowns))
        covariance = bundle_adjustment.covariance(precision.sum(axis=0), 1.0)
        found, share = found - (covariance @ pull.sum(axis=0))[len(PAPER) :], (turn + 1) / (SHAPE_TURNS + 1)
        spread = covariance[len(PAPER) :, len(PAPER) :] * bundle_adjustment.noise(shaped, solution, PAPER) ** 2
        for code, which in own.items():
            part = found[which]
            extents[code] = float(part[0] if len(part) == 1 else np.ptp(part @ forms[which, :, 2]))
            strength = float(part @ np.linalg.solve(spread[np.ix_(which, which)], part)) / len(part)
            if abs(extents[code]) < least[code] * share or strength < LEAST_STRENGTH * share:
                return None
        shaped = corners._replace(points=corners.points + np.tensordot(found, forms, 1))
        solution = bundle_adjustment.refine(shaped, solution, PAPER)
    return BoardShape(points=shaped.points, extents=extents, unknowns=unknowns)


def _bends(points: Array) -> Array:
    """(N, 3): heights of a board whose corners (N, 3) are bent along, across and askew, in half its diagonal."""
    away = points[:, :2] - points[:, :2].mean(axis=0)
    size = float(np.linalg.norm(away, axis=1).max())
    x, y = (away / size).T
    return size * np.column_stack((x * x, y * y, x * y))


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
