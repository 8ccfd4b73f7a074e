"""The camera's parameters from pictures of a chessboard (section 3.1, figure 3)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from core.calibration import homography
from core.calibration.board.board import Board
from core.calibration.camera import bundle_adjustment, consistency, suspects
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners, NormalEquations
from core.calibration.camera.consistency import BoardShape, PictureGroup, Variation
from core.calibration.camera.suspects import Figures, accuse, odd_lines
from core.calibration.levenberg_marquardt import FIRST_DAMPING
from core.calibration.projection import PAPER, PARAMETERS, Poses, model_of, vector_of
from core.errors import BadInput
from core.message import Array, message
from core.optics import CameraModel
from core.sensors.checks import Fault, fault

MOST_NAMES = 4  # of pictures in a sentence
MIN_BOARD_M, MAX_BOARD_M = 0.06, 2.5  # from corner to corner of a board that is held by hand


# Thresholds for corners and views that do not fit.
SOFT_LOSS_PX = 0.3  # [pixel] scale of the soft-L1 loss of the first solve
START_VIEWS = 100  # of the first solve, at most
START_CORNERS, START_CORNERS_OF_A_VIEW = 3000, 16  # corners of the first solve in all, and of each view at least
START_CLOSE, POSE_CLOSE = 1e-4, 1e-9  # shares of the cost that the first solve leaves, and a pose by itself
FLAT_VIEW_FACTOR = 8.0  # views this many times less flat than the median view wait until the camera is known
BAD_VIEW_FACTOR = 3.0  # a view this many times worse than the median view is left out
BAD_REST_FACTOR = 1.5  # the same for a view of which some corners have been left out already
BAD_CORNER_FACTOR = 5.0  # a corner this many times worse than the median corner is left out
NEGLIGIBLE_ERROR_PX = 0.1  # [pixel] errors below this never lead to leaving anything out
MAX_CORNERS_OUT_SHARE = 0.25  # a view that would lose a larger share of its corners is left out whole
MAX_SOLVE_ROUNDS = 4  # of leaving out and solving again
MIN_K3_GAIN = 0.01  # k3 has to lower the hold-out error by this share …
MIN_K3_SDS = 3.0  # … and to differ from zero by this many standard deviations
SURELY_LESS = 0.7  # share of these, of what the first order says, below which k3 is not solved for
HOLD_OUT_FOLDS = 10  # of the hold-out


@message
class ViewCorners:
    """The corners of one picture."""

    name: str
    corners: Array  # (N, 2) [pixel], in the board's order


@message
class ViewVerdict:
    """The outcome of one picture."""

    name: str
    used: bool
    rms: float  # [pixel], both axes together
    reason: str = ""  # why it is not used and what it would change, or what is odd about it; empty: nothing
    left_out: Array  # (K,) numbers of its corners that were left out


@message
class Calibration:
    """The camera, how sure we are, and what became of every view."""

    model: CameraModel
    free: tuple[str, ...]  # the parameters that were estimated, in the order of the covariance
    covariance: Array  # (P, P)
    noise: float  # [pixel] standard deviation of one corner coordinate
    rms: float  # [pixel], both axes together, over the corners that were used
    board: Board
    verdicts: tuple[ViewVerdict, ...]
    corners: Corners  # as they were used
    poses: Poses  # of the board in every view, camera_from_board
    deciding: str = ""  # a sentence about the view that decides a figure by itself; empty: none does
    warnings: tuple[str, ...] = ()  # the faults' sentences among them
    faults: tuple[Fault, ...] = ()
    undecided: str = ""  # why this camera must not be used; empty: it may be
    disagreement: float = 1.0  # times the deviations by which cameras from other pictures alike would differ

    @property
    def sds(self) -> dict[str, float]:
        """Standard deviation of every free parameter, by name."""
        return {
            name: float(sd) for name, sd in zip(self.free, np.sqrt(np.abs(np.diag(self.covariance))), strict=True)
        }

    @property
    def solution(self) -> BundleSolution:
        """Camera and poses as the bundle takes them."""
        return BundleSolution(vector_of(self.model), self.poses)

    @property
    def pose_sds(self) -> Array:
        """Standard deviations (M, 6) of `poses`: rotation about the camera's axes [rad], then translation [m]."""
        free = tuple(PARAMETERS.index(name) for name in self.free)
        found = bundle_adjustment.pose_covariances(self.corners, self.solution, free, self.covariance, self.noise)
        return np.sqrt(np.abs(np.diagonal(found, axis1=1, axis2=2)))

    @property
    def residuals(self) -> Array:
        """Projected minus seen (M, N, 2) [pixel] of every corner."""
        return bundle_adjustment.errors(self.corners, self.solution)

    @property
    def used(self) -> Array:
        """(M,) bool: the views that took part."""
        return self.corners.views_used


def calibrate(views: Sequence[ViewCorners], board: Board, size: tuple[int, int]) -> Calibration:
    """Pictures' corners and the picture's width and height [pixel] → the camera with its covariance.

    Raises BadInput with fewer than three views.
    """
    if len(views) < 3:
        raise BadInput(f"{len(views)} usable pictures are too few: at least 3 are needed, 10 to 20 are good.")
    if any(view.corners.shape != (board.count, 2) for view in views):
        raise BadInput(f"Every picture must have the {board.count} corners of the {board.name} board.")
    pixels = np.stack([view.corners for view in views])
    found = _consistently(Corners(board.points, pixels, np.ones(pixels.shape[:2], bool)), size)
    everything, corners, solution = found.everything, found.corners, found.solution
    free, known = PAPER, found.equations
    if _deserves_k3(corners, solution, known):
        free = (*PAPER, PARAMETERS.index("k3"))
        solution = bundle_adjustment.refine(corners, solution, free)
        known = consistency.equations(corners, solution)
    noise = bundle_adjustment.noise(corners, solution, free)
    of_board = () if found.shape is None else found.shape.unknowns
    precision = known.of((*free, *of_board)).precision.sum(axis=0)
    covariance = bundle_adjustment.covariance(precision, noise)[: len(free), : len(free)]
    covariance, doubts = _with_focal_doubt(corners, solution, free, covariance)
    used = np.flatnonzero(corners.views_used)
    left = 2 * int(np.count_nonzero(corners.used)) - 6 * len(used) - len(free)
    disagreement = consistency.disagreement(known.take(used).of(free), noise, left)
    if isinstance(found.part, Variation):
        widened = max(found.part.excess, 1.0)
        covariance, disagreement = covariance * widened, max(disagreement / np.sqrt(widened), 1.0)
    figures = suspects.figures(solution.camera, covariance)
    brought = suspects.with_each(corners, solution, free)
    verdicts = _verdicts(views, corners, everything, solution, board, figures, brought)
    faults = (
        *_faults(found, views, board),
        *doubts,
        *_off_centre(solution.camera, covariance, size),
        *_stretched(solution.camera, covariance),
        *_size_faults(board),
    )
    undecided = next((each.sentence for each in faults if each.code in UNDECIDED_CODES), "")
    deciding = ""
    if not undecided and np.count_nonzero(corners.views_used) >= suspects.MIN_VIEWS:
        deciding = _deciding(views, *suspects.without_each(corners, solution, known, free, noise), figures)
    squares = np.sum(bundle_adjustment.errors(corners, solution) ** 2, axis=2)[corners.used]
    sentences = tuple(each.sentence for each in faults)
    return Calibration(
        model=model_of(solution.camera, size),
        free=tuple(PARAMETERS[index] for index in free),
        covariance=covariance,
        noise=noise,
        rms=float(np.sqrt(squares.mean())),
        board=board,
        verdicts=_with_odd_part(verdicts, found.part, faults),
        corners=corners,
        poses=solution.poses,
        deciding=deciding,
        warnings=(*sentences, *_warnings(corners, found.focal_known), *([deciding] if deciding else [])),
        faults=faults,
        undecided=undecided,
        disagreement=float(disagreement),
    )


UNDECIDED_CODES = (
    *("camera.two_settings", "camera.focal_varies", "camera.middle_varies", "camera.skew"),
    *("camera.focal_undecided", "camera.one_tilt"),
)
LEFT_BY_VARIATION = 0.95  # share of the squared errors that two cameras leave, below which views vary instead
MAX_STRETCH_RATIO = 1.1  # of the focal lengths: no sensor has pixels that are less square
MAX_OFF_CENTRE = 0.15  # of the longer side of the picture that the lens may have its middle away from the picture's
MIN_TILT_DEG = 3.0  # between the boards of any two views: parallel boards do not tell the focal length


class _Found(NamedTuple):
    """The solution of views that agree with each other, and what did not agree."""

    everything: Corners
    corners: Corners  # as they are used
    solution: BundleSolution
    focal_known: bool
    equations: NormalEquations  # at this solution
    shape: BoardShape | None = None
    part: PictureGroup | Variation | None = None


def _consistently(everything: Corners, size: tuple[int, int]) -> _Found:
    """Solve; where two cameras, squares that are not square or a bent board explain the pictures far better, take
    that up.
    """
    found = _solve_robustly(everything, size)
    part = _part_of(found, size)
    flat, shaped, left = found, found, part
    while (rival := _with_shape(flat, shaped.shape, size, left is not None)) is not None:  # bent and askew, say
        shaped, left = rival
        if left is None:
            found, part = shaped, None
    if not isinstance(part, PictureGroup) or not part.is_minority(len(everything.pixels)):
        return found._replace(part=part)
    others = ~np.isin(np.arange(len(everything.pixels)), part.views)
    found = _solve_robustly(everything, size, others)
    again = consistency.find_variation(found.corners, found.solution, found.equations)  # the others may vary, too
    return found._replace(part=again or part)


def _with_shape(
    flat: _Found, shape: BoardShape | None, size: tuple[int, int], parted: bool
) -> tuple[_Found, PictureGroup | Variation | None] | None:
    """The solution with a board that differs from what is printed in one more way than in `shape`, in the way that
    explains all views best, and what it leaves.

    `flat`: the solution for a board as printed. `parted`: the views disagree so far; any bend is likelier than two
    cameras.
    """
    points, rivals = flat.everything.points, list[tuple[_Found, PictureGroup | Variation | None]]()
    diagonal = 2 * float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    least = {
        "board.unequal_squares": consistency.LEAST_ASPECT,
        "board.sheared": consistency.LEAST_SHEAR,
        "board.bent": 0.0 if parted else consistency.LEAST_BEND * diagonal,
    }
    known = {code: least[code] for code in least if shape is not None and code in shape.extents}
    for code in (each for each in least if each not in known):
        more = consistency.find_shape(known | {code: least[code]}, flat.corners, flat.solution, flat.equations)
        if more is not None:
            rival = _solve_robustly(flat.everything._replace(points=more.points), size)._replace(shape=more)
            rivals.append((rival, _part_of(rival, size)))
    whole = [each for each in rivals if each[1] is None] or rivals
    return min(
        whole, key=lambda each: bundle_adjustment.noise(each[0].corners, each[0].solution, PAPER), default=None
    )


def _part_of(found: _Found, size: tuple[int, int]) -> PictureGroup | Variation | None:
    """The views that another camera explains, those among them that were left out, or what varies among the views."""
    every, solution, known = found.corners, found.solution, found.equations
    out = ~every.views_used
    if out.any():
        every = every._replace(used=every.used | out[:, None])
        solution = BundleSolution(solution.camera, bundle_adjustment.refine_poses(every, solution))
        known = bundle_adjustment.equations(every, solution)
    part = consistency.find_part(every, solution, known, size)
    variation = consistency.find_variation(found.corners, found.solution, found.equations)
    if part is not None and variation is not None:
        if variation.code == "camera.rows_late" and not _moves_within(found, part):
            return part
        return variation if variation.left < LEFT_BY_VARIATION * part.left else part
    return part or variation


def _moves_within(found: _Found, part: PictureGroup) -> bool:
    """Return whether boards move within the part or the rest, too: else two cameras look like motion."""
    inside, used = np.isin(np.arange(len(found.corners.pixels)), part.views), found.corners.views_used
    for which, camera in ((inside & used, part.camera), (~inside & used, part.rest)):
        if np.count_nonzero(which) < consistency.MIN_VIEWS:
            continue
        some = found.corners.take(which)
        begun = BundleSolution(camera, found.solution.poses.take(which))
        poses = bundle_adjustment.refine_poses(some, begun)
        alone = bundle_adjustment.refine(some, BundleSolution(camera, poses), PAPER)
        left = consistency.find_variation(some, alone, consistency.equations(some, alone))
        if left is not None and left.code == "camera.rows_late":
            return True
    return False


def _with_focal_doubt(
    corners: Corners, solution: BundleSolution, free: tuple[int, ...], covariance: Array
) -> tuple[Array, tuple[Fault, ...]]:
    """Widen the covariance to what the likelihood itself says of the focal length, where little is known of it."""
    sd, focal = float(np.sqrt(covariance[0, 0])), float(solution.camera[0])
    normals = solution.poses.rotations[corners.views_used][:, :, 2]
    tilted = np.rad2deg(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0).min()))
    alike = () if tilted > MIN_TILT_DEG else (fault("camera.one_tilt", degrees=f"{tilted:.1f}"),)
    if sd < consistency.DOUBTFUL_FOCAL * focal:
        return covariance, alike
    around = consistency.focal_range(corners, solution, free, sd)
    wide = max(around.high - focal, focal - around.low) / 2
    if wide > consistency.MAX_SD_RATIO * sd:
        covariance = covariance * (wide / sd) ** 2
    if 2 * wide < consistency.WIDEST_FOCAL * focal:
        return covariance, alike
    doubt = fault("camera.focal_undecided", low=f"{around.low:.0f}", high=f"{around.high:.0f}")
    return covariance, (doubt,)


def _size_faults(board: Board) -> tuple[Fault, ...]:
    """Find a board that nobody holds by hand: its squares are in another unit than metres."""
    wide, high = (2 * half for half in board.half_size)
    if MIN_BOARD_M <= math.hypot(wide, high) <= MAX_BOARD_M:
        return ()
    size = {"wide": f"{wide:.2g}", "high": f"{high:.2g}", "square": f"{1e3 * board.square:g}"}
    return (fault("board.size", used=True, **size),)


def _stretched(camera: Array, covariance: Array) -> tuple[Fault, ...]:
    """The fault of pictures that are wider or higher than the sensor made them, if it is one."""
    to_ratio = np.array([1.0, -1.0]) / camera[:2]
    ratio, sd = camera[0] / camera[1], np.sqrt(to_ratio @ covariance[:2, :2] @ to_ratio)
    if abs(np.log(ratio)) - consistency.TWO_SDS * sd < np.log(MAX_STRETCH_RATIO):
        return ()
    return (fault("camera.stretched", used=True, ratio=f"{ratio:.2f}"),)


def _off_centre(camera: Array, covariance: Array, size: tuple[int, int]) -> tuple[Fault, ...]:
    """The fault of a lens that has its middle far from the picture's, if it is one."""
    middle = (np.array(size) - 1) / 2
    off = np.abs(camera[2:4] - middle) - consistency.TWO_SDS * np.sqrt(np.diag(covariance)[2:4])
    if np.all(off < MAX_OFF_CENTRE * max(size)):
        return ()
    at = "{:.0f}, {:.0f}"
    return (fault("camera.off_centre", used=True, seen=at.format(*camera[2:4]), middle=at.format(*middle)),)


def _faults(found: _Found, views: Sequence[ViewCorners], board: Board) -> tuple[Fault, ...]:
    faults: list[Fault] = []
    for code, extent in () if found.shape is None else found.shape.extents.items():
        wide = board.square * 1e3
        high = {"wide": f"{wide:.1f}", "high": f"{wide * (1 + extent):.1f}", "share": f"{100 * extent:+.2f}"}
        along, down = (board.columns - 1) * wide, (board.rows - 1) * wide
        diagonals = np.hypot(along + extent * down, down) - np.hypot(along - extent * down, down)
        askew = {"degrees": f"{abs(np.rad2deg(extent)):.2f}", "diagonals": f"{abs(diagonals):.1f}"}
        faults.append(fault(code, used=True, depth=f"{1e3 * extent:.1f}", **high, **askew))
    if isinstance(found.part, Variation):
        extent = found.part.extent
        values = {"share": f"{100 * extent:.1f}", "pixels": f"{extent:.1f}", "degrees": f"{abs(extent):.2f}"}
        values["depth"] = f"{1e3 * extent:.1f}"
        faults.append(fault(found.part.code, used=found.part.code not in UNDECIDED_CODES, **values))
    elif found.part is not None:
        part, count = found.part, len(views)
        others = [number for number in range(count) if number not in part.views]
        code = "camera.odd_part" if part.is_minority(count) else "camera.two_settings"
        faults.append(
            fault(
                code,
                odd=_names(views, part.views.tolist()),
                others=_names(views, others),
                odd_camera=_camera_words(part.camera),
                camera=_camera_words(part.rest),
                cause=part.cause,
            )
        )
    return tuple(faults)


def _names(views: Sequence[ViewCorners], numbers: Sequence[int]) -> str:
    names = ", ".join(views[number].name for number in numbers[:MOST_NAMES])
    return names if len(numbers) <= MOST_NAMES else f"{names} and {len(numbers) - MOST_NAMES} more"


def _camera_words(camera: Array) -> str:
    return f"f {camera[:2].mean():.1f} px, middle ({camera[2]:.1f}, {camera[3]:.1f})"


def _with_odd_part(
    verdicts: tuple[ViewVerdict, ...], part: PictureGroup | Variation | None, faults: tuple[Fault, ...]
) -> tuple[ViewVerdict, ...]:
    """The verdicts, with the cause for the views that another camera explains."""
    if not isinstance(part, PictureGroup) or not any(each.code == "camera.odd_part" for each in faults):
        return verdicts
    reason = f"it fits another camera ({_camera_words(part.camera)}): {part.cause}"
    return tuple(
        replace(each, used=False, reason=reason) if number in part.views else each
        for number, each in enumerate(verdicts)
    )


def _solve_robustly(everything: Corners, size: tuple[int, int], open_views: Array | None = None) -> _Found:
    """Soft loss first, then leave out what does not fit and finish with plain least squares.

    `open_views` (M,) bool: the only ones that may take part.
    """
    open_views = np.ones(len(everything.pixels), bool) if open_views is None else open_views
    mapping = homography.homographies(everything.points, everything.pixels)
    flat = _flat(everything, mapping) & open_views
    first = homography.start(everything.points, everything.pixels[flat], size, mapping[flat])
    some = _some_of(flat)
    begun = BundleSolution(first.camera, first.poses.take(some[flat]))
    part = _from_scratch(everything.take(some), begun, SOFT_LOSS_PX)
    solution = _with_all(_for_start(everything), part, some, mapping, SOFT_LOSS_PX, START_CLOSE)
    used = _fitting(everything, solution) & open_views[:, None]
    for _ in range(MAX_SOLVE_ROUNDS):
        kept = np.count_nonzero(used, axis=1) > 0
        some = Corners(everything.points, everything.pixels[kept], used[kept])
        part = bundle_adjustment.refine(some, BundleSolution(solution.camera, solution.poses.take(kept)), PAPER)
        if not used.all():
            part = _upright(some, part, None)
        solution = _with_all(everything, part, kept, mapping, SOFT_LOSS_PX, POSE_CLOSE)
        again = _fitting(everything, solution) & open_views[:, None]
        if np.array_equal(again, used):
            break
        used = again
    corners = Corners(everything.points, everything.pixels, used)
    return _Found(everything, corners, solution, first.focal_known, consistency.equations(corners, solution))


def _flat(everything: Corners, mapping: Array) -> Array:
    """(M,) bool: views whose corners look like a plane at all; the others would drag the first solve away.

    `mapping` (M, 3, 3): the homographies.
    """
    ground = np.column_stack((everything.points[:, :2], np.ones(len(everything.points))))
    image = ground @ np.swapaxes(mapping, 1, 2)
    error = np.median(np.linalg.norm(image[..., :2] / image[..., 2:] - everything.pixels, axis=2), axis=1)
    flat = error <= FLAT_VIEW_FACTOR * max(float(np.median(error)), NEGLIGIBLE_ERROR_PX)
    return flat if np.count_nonzero(flat) >= 3 else np.ones(len(error), bool)


def _some_of(flat: Array) -> Array:
    """(M,) bool: so many of these views as the first solve takes, picked at random but the same every time."""
    picked = np.random.default_rng(0).permutation(np.flatnonzero(flat))[:START_VIEWS]
    return np.isin(np.arange(len(flat)), picked)


def _for_start(corners: Corners) -> Corners:
    """Corners on which the solution begins: of many, some will do."""
    return corners.thinned(max(START_CORNERS // len(corners.pixels), START_CORNERS_OF_A_VIEW))


def _from_scratch(corners: Corners, begun: BundleSolution, soft: float) -> BundleSolution:
    """Both poses of every board, Levenberg-Marquardt, from what the homographies have begun with."""
    corners = _for_start(corners)
    poses = bundle_adjustment.refine_poses(corners, begun, soft=soft, steps=6, close=1e-3)
    solution = BundleSolution(begun.camera, poses)
    solution, _ = bundle_adjustment.rescue(corners, solution, soft=soft, ratio=1.0)
    solution = bundle_adjustment.refine(corners, solution, PAPER, soft=soft, close=START_CLOSE, damping=FIRST_DAMPING)
    return _upright(corners, solution, soft)


def _upright(corners: Corners, solution: BundleSolution, soft: float | None) -> BundleSolution:
    """Turn boards over where that fits better, and solve again, until none is left."""
    for _ in range(3):
        solution, turned = bundle_adjustment.rescue(corners, solution, soft=soft)
        if not turned.any():
            break
        solution = bundle_adjustment.refine(corners, solution, PAPER, soft=soft, close=START_CLOSE)
    return solution


def _with_all(
    everything: Corners, part: BundleSolution, kept: Array, mapping: Array, soft: float, close: float
) -> BundleSolution:
    """The kept views as solved; the poses of the others fitted to the camera that the kept ones gave.

    `mapping` (M, 3, 3): the homographies.
    """
    rotations, translations = np.empty((len(kept), 3, 3)), np.empty((len(kept), 3))
    rotations[kept], translations[kept] = part.poses
    if not kept.all():
        others = everything.take(~kept)
        guess = homography.board_poses(others.points, others.pixels, part.camera, mapping[~kept])
        guess = bundle_adjustment.refine_poses(
            others, BundleSolution(part.camera, guess), soft=soft, steps=30, close=close
        )
        turned, _ = bundle_adjustment.rescue(others, BundleSolution(part.camera, guess), soft=soft)
        rotations[~kept], translations[~kept] = turned.poses
    return BundleSolution(part.camera, Poses(rotations, translations))


def _fitting(everything: Corners, solution: BundleSolution) -> Array:
    """(M, N) bool: the corners that agree with the solution; nothing of a view that does not."""
    lengths = np.linalg.norm(bundle_adjustment.errors(everything, solution), axis=2)
    if len(lengths) < 4:
        return np.ones(lengths.shape, bool)
    typical = np.median(np.sqrt(np.mean(lengths**2, axis=1)))
    middle = np.median(np.median(lengths, axis=1))
    fits = lengths <= max(BAD_CORNER_FACTOR * middle, NEGLIGIBLE_ERROR_PX)
    rms = np.sqrt(np.sum(lengths**2 * fits, axis=1) / np.maximum(fits.sum(axis=1), 1))
    limit = np.where(fits.all(axis=1), BAD_VIEW_FACTOR, BAD_REST_FACTOR) * typical
    bad = (rms > np.maximum(limit, NEGLIGIBLE_ERROR_PX)) | ((~fits).mean(axis=1) > MAX_CORNERS_OUT_SHARE)
    fits[bad] = False
    return fits


def _deserves_k3(corners: Corners, solution: BundleSolution, known: NormalEquations) -> bool:
    """Return whether k3 is clearly not zero and improves the prediction of views that took no part in the fit."""
    kept = corners.views_used
    some = corners.take(kept)
    if len(some.pixels) < 6:
        return False
    paper = BundleSolution(solution.camera, solution.poses.take(kept))
    more = (*PAPER, PARAMETERS.index("k3"))
    precision, pull = known.of(more)
    spread = bundle_adjustment.covariance(precision.sum(axis=0), 1.0)
    noise = bundle_adjustment.noise(some, paper, PAPER)
    if abs((spread @ pull.sum(axis=0))[-1]) < SURELY_LESS * MIN_K3_SDS * np.sqrt(spread[-1, -1]) * noise:
        return False  # to first order it is far from that
    longer = bundle_adjustment.refine(some, paper, more)
    precision = bundle_adjustment.information(some, longer, more).sum(axis=0)
    sd = float(np.sqrt(bundle_adjustment.covariance(precision, bundle_adjustment.noise(some, longer, more))[-1, -1]))
    if abs(longer.camera[8]) < MIN_K3_SDS * sd:
        return False
    without, with_k3 = (hold_out_rms(some, each, free) for each, free in ((paper, PAPER), (longer, more)))
    return with_k3 < (1 - MIN_K3_GAIN) * without


def hold_out_rms(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> float:
    """[pixel]: error on views that took no part in estimating the camera; only their poses are fitted."""
    number = np.arange(len(corners.pixels)) % HOLD_OUT_FOLDS
    squares, count = 0.0, 0
    for fold in range(min(HOLD_OUT_FOLDS, len(number))):
        inside, outside = number != fold, number == fold
        fitted = bundle_adjustment.refine(
            corners.take(inside), BundleSolution(solution.camera, solution.poses.take(inside)), free
        )
        held = corners.take(outside)
        poses = bundle_adjustment.refine_poses(held, BundleSolution(fitted.camera, solution.poses.take(outside)))
        error = bundle_adjustment.errors(held, BundleSolution(fitted.camera, poses))
        squares += float(np.sum(np.sum(error**2, axis=2) * held.used))
        count += int(np.count_nonzero(held.used))
    return float(np.sqrt(squares / max(count, 1)))


def _verdicts(
    views: Sequence[ViewCorners],
    corners: Corners,
    everything: Corners,
    solution: BundleSolution,
    board: Board,
    known: Figures,
    brought: Mapping[int, Array],
) -> tuple[ViewVerdict, ...]:
    """The outcome of every view; `brought`: the figures (5,) [pixel] with each that is not used, by number."""
    errors = bundle_adjustment.errors(everything, solution)
    lengths = np.linalg.norm(errors, axis=2)
    rms = np.sqrt(np.mean(lengths**2, axis=1))
    typical = float(np.median(lengths[corners.used]))
    lines = odd_lines(errors.reshape(-1, board.rows, board.columns, 2), typical)
    verdicts: list[ViewVerdict] = []
    for number, view in enumerate(views):
        out = np.flatnonzero(~corners.used[number])
        used = len(out) < board.count
        if len(out):
            reason, certain = accuse(view.corners, number, solution, board, typical)
            if used:
                reason = f"used without {len(out)} of its corners: {reason}"
            elif number in brought:
                reason += f"; {suspects.words_with(brought[number], known, advise=not certain)}"
        else:
            reason = lines[number]
        verdicts.append(ViewVerdict(name=view.name, used=used, rms=float(rms[number]), reason=reason, left_out=out))
    return tuple(verdicts)


def _deciding(views: Sequence[ViewCorners], numbers: Array, others: Figures, known: Figures) -> str:
    """A sentence about the view that decides most, if that is too much; "" where none does.

    `others` (K, 5): the figures without each of the views of these numbers (K,).
    """
    most = int(np.argmax(suspects.sway(others, known).max(axis=1)))
    words = suspects.words_without(others.of(most), known)
    return words and f"{views[numbers[most]].name} {words}."


def _warnings(corners: Corners, focal_known: bool) -> tuple[str, ...]:
    found: list[str] = []
    used = int(np.count_nonzero(corners.views_used))
    if not focal_known:
        found.append(
            "Every board faces the camera, so the focal length is a guess: tilt the board by 20 to 50 degrees."
        )
    if used < 8:
        found.append(f"Only {used} pictures were used; with fewer than 8 the stated uncertainty is itself uncertain.")
    return tuple(found)
