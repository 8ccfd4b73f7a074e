"""Influence of one view: the camera with a view that is left out, and without one that is used.

A set of views can hang on one of them: the only one that is tilted decides the focal length, rightly or not. Where it
is left out because it disagrees with the others, the others may be wrong. So both are reported in numbers.
"""

import numpy as np

from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners, NormalEquations
from core.message import Array, message

NAMES = ("f", "fx", "fy", "cx", "cy")
MEANS = np.array([[0.5, 0.5, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""NAMES from fx, fy, cx, cy; f is what both axes have in common."""
MIN_VIEWS = 6  # views used, with which the stated standard deviations mean something
SMALL_CHANGE_SDS = 1.0  # standard deviations that are no change
DECISIVE_SDS = 3.0  # standard deviations by which one view may not move the answer, nor narrow them
MIN_SD_PX = 1e-9  # no figure is better known
MOST_WORK = 400  # views that are solved again in all
ADVICE = "show more tilted views to decide"


@message
class Figures:
    """The figures of a camera that people know."""

    values: Array  # (5,) [pixel] of NAMES
    sds: Array  # (5,) [pixel]

    def with_sd(self, number: int) -> str:
        """One of them with its standard deviation."""
        return f"{self.values[number]:.1f} ± {self.sds[number]:.1f}"


def figures(camera: Array, covariance: Array) -> Figures:
    """Camera (9,) and the covariance (P, P) of its free parameters, which begin with fx, fy, cx and cy."""
    spread = np.sum(MEANS @ covariance[..., :4, :4] * MEANS, axis=-1)
    return Figures(values=MEANS @ camera[:4], sds=np.sqrt(np.abs(spread)))


def with_each(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> dict[int, Array]:
    """Views of which no corner is used → by number, the NAMES' values (5,) [pixel] with that one too.

    Where there are many views, only the first that are left out are tried.
    """
    used = corners.views_used
    found: dict[int, Array] = {}
    for number in np.flatnonzero(~used)[: max(MOST_WORK // len(used), 1)]:
        one = np.arange(len(used)) == number
        some = Corners(corners.points, corners.pixels, corners.used | one[:, None]).take(used | one)
        refined = bundle_adjustment.refine(
            some, BundleSolution(solution.camera, solution.poses.take(used | one)), free
        )
        found[int(number)] = MEANS @ refined.camera[:4]
    return found


def without_each(
    corners: Corners, solution: BundleSolution, known: NormalEquations, free: tuple[int, ...], noise: float
) -> dict[int, Figures]:
    """Every view that is used → by number, what the others give without it, to first order.

    At the best solution the pulls of all views cancel out; without one the others give way to what it held. `known`:
    the equations at this solution.
    """
    used = np.flatnonzero(corners.views_used)
    precision, pull = known.of(free)
    doubts = bundle_adjustment.covariance(precision.sum(axis=0) - precision[used], 1.0)
    cameras = np.tile(solution.camera, (len(used), 1))
    cameras[:, list(free)] += (doubts @ pull[used, :, None])[..., 0]
    return {
        number: figures(camera, doubt)
        for number, camera, doubt in zip(used.tolist(), cameras, noise**2 * doubts, strict=True)
    }


def words_with(values: Array, known: Figures, *, advise: bool) -> str:
    """The change that a left-out view would make, to follow the reason; `advise`: it is unknown which is right."""
    sds = np.abs(values - known.values) / np.maximum(known.sds, MIN_SD_PX)
    most = _foremost(sds)
    if sds[most] < SMALL_CHANGE_SDS:
        return f"with it nothing would change: f stays {known.values[0]:.1f} px"
    words = f"with it {NAMES[most]} would be {values[most]:.1f} instead of {known.values[most]:.1f} px"
    words = f"{words}, {sds[most]:.0f} sd"
    return f"{words}: {ADVICE}" if advise and sds[most] > DECISIVE_SDS else words


def sway(others: Figures, known: Figures) -> Array:
    """(5,): how much a view decides, by what the `others` give: standard deviations that it moves, or narrows."""
    return np.maximum(np.abs(others.values - known.values), others.sds) / np.maximum(known.sds, MIN_SD_PX)


def words_without(others: Figures, known: Figures) -> str:
    """The figure that a used view decides by itself; "" for none."""
    swayed = sway(others, known)
    most = _foremost(swayed)
    if swayed[most] <= DECISIVE_SDS:
        return ""
    return (
        f"decides {NAMES[most]} by itself: without it {NAMES[most]} would be {others.with_sd(most)} px instead of "
        f"{known.with_sd(most)}; {ADVICE}"
    )


def _foremost(sds: Array) -> int:
    """The figure to report, by standard deviations (5,): f, where it moves nearly as much as any."""
    return 0 if sds[0] >= sds.max() / 2 else int(np.argmax(sds))
