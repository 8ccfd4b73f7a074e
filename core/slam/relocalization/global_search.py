"""Global search: a scan found anywhere on a map by correlative scan matching, coarse to fine, then checked for doubt.

The scan, turned to each of 120 headings, is correlated with an upper bound of the likelihood field; the best places
are searched finely, refined by Gauss-Newton, and checked against what the map knows to be free.
"""

import math
from collections.abc import Generator
from dataclasses import dataclass

import cv2
import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.slam.relocalization.search_pyramid import MAX_REACH_M, POOL_M, ScanView, SearchPyramid
from core.slam.scan_matching.likelihood_field import CELL_M

MIN_VIEW_POINTS = 25  # points of a view that can be searched with
MAX_BEAMS = 120  # of a view that are followed through the map
RING_M = (0.3, 0.75)  # aside: where a place that is pinned down fits clearly worse
PEAK_CELLS = 2  # coarse cells around a peak of the correlation that belong to it


# Thresholds of the search for a place.
SEARCH_HEADINGS = 120  # to which the scan is turned
PEAKS_PER_HEADING = 3  # of the correlation at each heading that are kept
MAX_FINE_PLACES = 48  # places that are looked at finely
MIN_APART_M = 0.45  # [m] between two of them that are alike in heading
MIN_APART_RAD = math.radians(5)  # [rad] between two of them at one place
FINE_POINTS = 100  # of the scan that the fine search looks at
MIN_CANDIDATE_SCORE = 0.5  # score from which a place is a candidate
MAX_CANDIDATES = 16  # candidates
CELLS_PER_STEP = 2e5  # cells transformed between two yields
PLACES_PER_STEP = 3  # places looked at finely between two yields


@dataclass(frozen=True)
class PoseFit:
    """The fit of a view at a pose."""

    pose: Pose
    score: float  # 0..1, mean field value at the view's points
    conflict: float  # 0..1, share of beams that went through a wall or ended in the middle of free floor


def search(
    pyramid: SearchPyramid, view: ScanView, least_score: float = MIN_CANDIDATE_SCORE
) -> Generator[None, None, list[PoseFit]]:
    """A view → where on the whole map it may have been taken, best first; yields between pieces of work.

    `least_score`: from which a place is a candidate.
    """
    if len(view.points) < MIN_VIEW_POINTS:
        return []
    places = yield from _correlate(pyramid, view)
    return (yield from _look_closer(pyramid, view, places, least_score))


def search_near(
    pyramid: SearchPyramid, view: ScanView, guess: Pose, reach: float, angle: float
) -> Generator[None, None, list[PoseFit]]:
    """The same within `reach` [m] and ±`angle` [rad] of a guess only; π: any heading."""
    if len(view.points) < MIN_VIEW_POINTS:
        return []
    few = _few(view)
    tile = 0.5
    steps = tile * np.arange(-math.ceil(reach / tile), math.ceil(reach / tile) + 1)
    places: list[tuple[float, Pose]] = []
    count = math.ceil(angle / math.radians(3))
    for turn in np.linspace(-angle, angle, 2 * count + 1):
        for x in steps:
            for y in steps:
                start = Pose(guess.x + float(x), guess.y + float(y), wrap(guess.heading + float(turn)))
                place = pyramid.field.search(few, start, tile / 2, 0.0, 0.1, 1.0)
                places.append((float(pyramid.field.cells_at(place.apply(few)).mean()), place))
        yield
    fits = yield from _look_closer(pyramid, view, places, MIN_CANDIDATE_SCORE)
    return [fit for fit in fits if guess.distance_to(fit.pose.x, fit.pose.y) <= reach + 0.3]


def judge(pyramid: SearchPyramid, view: ScanView, guess: Pose) -> PoseFit | None:
    """A view near a pose → how well it lies at the best pose thereabouts.

    None where no robot can stand, and where nothing was seen.
    """
    if not len(view.points):
        return None
    pose = pyramid.field.refine(view.points, guess)
    if not pyramid.standing(pose.pose.x, pose.pose.y):
        return None
    few = view.points[:: max(1, -(-len(view.points) // MAX_BEAMS))]
    start = pose.pose.apply(view.start[None])[0]
    ends, misses = pose.pose.apply(few), pose.pose.apply(view.misses)
    against = np.concatenate(
        [pyramid.crossed(start, ends) | (pyramid.known(ends) < 0), pyramid.crossed(start, misses)]
    )
    return PoseFit(pose.pose, pose.score, float(against.mean()))


def aside(pyramid: SearchPyramid, view: ScanView, pose: Pose) -> Array:
    """Scores (31, 31) of a view shifted by up to ±0.75 m from a pose in steps of 0.05 m; [15, 15]: not shifted."""
    shift = CELL_M * np.arange(-15, 16)
    offsets = np.stack(np.meshgrid(shift, shift, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    points = pose.apply(view.points[:: max(1, -(-len(view.points) // MAX_BEAMS))])
    return pyramid.field.cells_at(points[None] + offsets).mean(axis=1).reshape(31, 31)


def ring() -> Array:
    """(31, 31) bool: the shifts of `aside` that count as another place."""
    shift = CELL_M * np.arange(-15, 16)
    distance = np.hypot(shift[:, None], shift[None, :])
    return (distance >= RING_M[0]) & (distance <= RING_M[1])


def same(one: Pose, other: Pose, apart: float = 0.3, turned: float = math.radians(8)) -> bool:
    """Return whether two poses are one place."""
    return one.distance_to(other.x, other.y) < apart and abs(wrap(one.heading - other.heading)) < turned


def _few(view: ScanView) -> Array:
    return view.points[:: max(1, len(view.points) // FINE_POINTS)]


def _correlate(pyramid: SearchPyramid, view: ScanView) -> Generator[None, None, list[tuple[float, Pose]]]:
    """Coarse places, each with the bound of its score."""
    reach = np.hypot(view.points[:, 0], view.points[:, 1])
    points = view.points[reach < MAX_REACH_M]
    widest = 2 * math.ceil(float(reach[reach < MAX_REACH_M].max(initial=0.0)) / POOL_M) + 2
    rows, columns = pyramid.bound.shape
    size = (cv2.getOptimalDFTSize(rows + widest), cv2.getOptimalDFTSize(columns + widest))
    map_spectrum = pyramid.spectrum(size)
    yield
    places: list[tuple[float, Pose]] = []
    each = max(1, int(CELLS_PER_STEP / (size[0] * size[1])))
    for number in range(SEARCH_HEADINGS):
        heading = wrap(number * math.tau / SEARCH_HEADINGS)
        cells = np.floor(points @ rotation(heading).T / POOL_M).astype(int)
        raster = np.zeros(size, np.float32)
        np.add.at(raster, (cells[:, 1] % size[0], cells[:, 0] % size[1]), 1.0 / max(len(points), 1))
        product = cv2.mulSpectrums(map_spectrum, cv2.dft(raster), 0, conjB=True)
        bound = cv2.dft(product, flags=cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT)[:rows, :columns]
        bound = np.where(pyramid.standable, bound, np.float32(-1.0))
        for _ in range(PEAKS_PER_HEADING):
            _, score, _, (column, row) = cv2.minMaxLoc(bound)
            if score <= 0.0:
                break
            x, y = pyramid.field.origin + POOL_M * (np.array([column, row]) + 0.5)
            places.append((score, Pose(float(x), float(y), heading)))
            bound[
                max(0, row - PEAK_CELLS) : row + PEAK_CELLS + 1, max(0, column - PEAK_CELLS) : column + PEAK_CELLS + 1
            ] = -1.0
        if number % each == each - 1:
            yield
    return places


def _look_closer(
    pyramid: SearchPyramid, view: ScanView, places: list[tuple[float, Pose]], least_score: float
) -> Generator[None, None, list[PoseFit]]:
    """Coarse places → fits, best first, no two at one place."""
    few = _few(view)
    fits: list[PoseFit] = []
    for number, place in enumerate(_spaced(places)):
        found = pyramid.field.search(few, place, 0.3, math.radians(3), 0.1, math.radians(1.5))
        fit = judge(pyramid, view, pyramid.field.refine(few, found).pose)
        if fit is not None and fit.score >= least_score:
            fits.append(fit)
        if number % PLACES_PER_STEP == PLACES_PER_STEP - 1:
            yield
    kept: list[PoseFit] = []
    for fit in sorted(fits, key=lambda fit: -fit.score):
        if not any(same(fit.pose, better.pose) for better in kept):
            kept.append(fit)
    return kept[:MAX_CANDIDATES]


def _spaced(places: list[tuple[float, Pose]]) -> list[Pose]:
    kept: list[Pose] = []
    for _, place in sorted(places, key=lambda scored: -scored[0]):
        if len(kept) == MAX_FINE_PLACES:
            break
        if not any(same(place, better, MIN_APART_M, MIN_APART_RAD) for better in kept):
            kept.append(place)
    return kept
