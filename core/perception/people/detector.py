"""Picture and direction → who stands there: rectangles in whose head part the sound falls, weighed by eq. 34."""

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from core.message import Array, message
from core.perception.people.appearance import Appearance, PersonProfile, alike, colours_seen
from core.perception.people.parts import (
    BODY_COLUMNS,
    CEILING_M,
    CELL_PX,
    CELLS_PER_METRE,
    HIGHEST_SHIFT,
    LOWEST_SHIFT,
    MODEL_HEIGHT_M,
    PARTS,
    BodySegment,
    PeopleSettings,
)
from core.perception.people.vertical_plane import VerticalPlanes, columns_of

FILE = Path(__file__).with_name("general.npz")


class PartModel(NamedTuple):
    """Classifier of one part: likelihood = logistic(offset + sum of weights · (cells - usual))."""

    part: BodySegment
    usual: Array  # (rows, columns, DIRECTIONS): the mean over people and everything else
    weights: Array  # (rows, columns, DIRECTIONS)
    offset: float


@cache
def general_model() -> tuple[PartModel, ...]:
    """The model of any person, in the order of PARTS."""
    with np.load(FILE) as stored:
        return tuple(
            PartModel(
                part,
                stored[f"{part.name}_usual"].astype(np.float32),
                stored[f"{part.name}_weights"].astype(np.float32),
                float(stored[f"{part.name}_offset"]),
            )
            for part in PARTS
        )


def likelihoods(model: PartModel, cells: Array, valid: Array, rises: range) -> tuple[Array, Array]:
    """Cells (ROWS, C, DIRECTIONS) of a compared view, which of them are in the picture (ROWS, C), by how many cells
    the part may lie higher than the model's (a range that goes up by ones) → the part's log odds for every rise and
    every place along (R, C - columns + 1), and the share of the part that is in the picture, the same shape. What is
    not in the picture says nothing.
    """
    part = model.part
    band = slice(part.top - rises[-1], part.top - rises[0] + part.rows)
    seen = valid[band].astype(np.float32)
    shown = cells[band] * seen[:, :, None]
    size = (part.rows, part.columns)
    windows = np.lib.stride_tricks.sliding_window_view(shown, size, axis=(0, 1))  # (R, P, D, rows, columns)
    here = np.lib.stride_tricks.sliding_window_view(seen, size)  # (R, P, rows, columns)
    many = windows.shape[:2]
    weights = model.weights.transpose(2, 0, 1).ravel()
    usual = (model.usual * model.weights).sum(axis=2).ravel()
    area = here.reshape(*many, -1)
    odds = windows.reshape(*many, -1) @ weights - area @ usual + model.offset
    return odds[::-1], area.mean(axis=2)[::-1]


DIRECTION_COUNT = 9  # of an edge, over half a turn
MIN_GRADIENT = 6.0  # grey levels per pixel: weaker gradients are mostly noise
MAX_HISTOGRAM = 0.4


def edge_cells(pixels: Array) -> Array:
    """Picture (H, W, 3) uint8, both sides multiples of CELL → (H / CELL, W / CELL, DIRECTIONS) float32, 0 to 1.

    Histograms of oriented gradients (Dalal and Triggs 2005): per pixel the channel that changes most, its direction
    shared by the two nearest bins, the cells levelled by their neighbourhood.
    """
    rows, columns = pixels.shape[0] // CELL_PX, pixels.shape[1] // CELL_PX
    dx = cv2.Sobel(pixels, cv2.CV_32F, 1, 0, ksize=1)
    dy = cv2.Sobel(pixels, cv2.CV_32F, 0, 1, ksize=1)
    strongest = (dx * dx + dy * dy).argmax(axis=2)[:, :, None]
    gx, gy = (np.take_along_axis(d, strongest, axis=2)[:, :, 0] for d in (dx, dy))
    size, angle = cv2.cartToPolar(gx, gy)
    place = angle * np.float32(DIRECTION_COUNT / np.pi) - np.float32(0.5)
    low = np.floor(place)
    share = place - low
    first = low.astype(np.int32) % DIRECTION_COUNT
    second = (first + 1) % DIRECTION_COUNT
    row, column = np.arange(pixels.shape[0]) // CELL_PX, np.arange(pixels.shape[1]) // CELL_PX
    cell = (row[:, None] * columns + column[None, :]) * DIRECTION_COUNT
    total = rows * columns * DIRECTION_COUNT
    sums = np.bincount((cell + first).ravel(), (size * (1 - share)).ravel(), total)
    sums += np.bincount((cell + second).ravel(), (size * share).ravel(), total)
    histograms = sums.reshape(rows, columns, DIRECTION_COUNT).astype(np.float32)
    energy = cv2.blur(np.square(histograms).sum(axis=2), (3, 3), borderType=cv2.BORDER_REPLICATE)
    level = np.sqrt(energy + np.float32((MIN_GRADIENT * CELL_PX) ** 2))
    return np.minimum(histograms / level[:, :, None], MAX_HISTOGRAM)


SHIFTS = tuple(range(LOWEST_SHIFT, HIGHEST_SHIFT + 1))
MIN_SHOWN_SHARE = 0.3  # share of a part in the picture below which it says nothing
BODY = BODY_COLUMNS / 2 / CELLS_PER_METRE  # [m] half the width of the rectangle
MAX_PLANE_HALF_RAD = 0.6  # to either side of one direction that a plane is true for


@message
class SeenPart:
    """One part of a rectangle."""

    name: str  # "head" | "torso" | "feet"
    likelihood: float | None  # K_i of eq. 34; None: not in the picture
    box: tuple[float, float, float, float]  # left, top, right, bottom [pixel]; it may reach out of the picture


@message
class Rectangle:
    """A person in the picture."""

    value: float  # K of eq. 34, of the parts that are in the picture
    shown: float  # 0..1: weight of the parts that are in the picture
    distance: float  # [m] from the camera, where it meets the floor
    bearing: float  # [rad] robot frame, from the camera
    height: float  # [m] of the person, ±6 cm
    parts: tuple[SeenPart, ...]
    centre: tuple[float, float]  # [pixel] the rectangle's centroid, taken for the centre of mass (section 4.2)
    box: tuple[float, float, float, float]  # left, top, right, bottom [pixel] of the whole body
    bearing_sd: float | None = None  # [rad]; None: as good as the rectangles of a vertical plane are
    looks: Appearance | None = None  # None: look at the plane where they stand
    landmarks: Array | None = None  # (33, 2) [pixel]; NaN: not seen; None: a model without landmarks found them
    rank: float = 0.0  # how well it fits beyond K, for choosing
    stranger: bool = False  # a person, but not the one who was asked for


def find_people(
    boards: VerticalPlanes,
    bearing: float,
    half: float,
    settings: PeopleSettings,
    *,
    distances: Sequence[float] | None = None,
    who: PersonProfile | None = None,
) -> tuple[Rectangle, ...]:
    """People within `half` [rad] of `bearing` [rad, robot frame], best first; only those over the threshold.

    `distances` [m] from the camera: where the laser sees something to look at; None: everywhere. `who`: only this
    person counts. The floor is taken to be level.
    """
    planes = every_distance(settings).tolist() if distances is None else distances
    found = everybody(boards, (bearing, half), planes, settings, who)
    return apart([one for one in found if not one.stranger], settings)


def everybody(
    boards: VerticalPlanes,
    towards: tuple[float, float],
    distances: Sequence[float],
    settings: PeopleSettings,
    who: PersonProfile | None = None,
) -> list[Rectangle]:
    """All rectangles over the threshold on planes at these distances [m], `towards` a bearing and half a width [rad];
    a person other than `who` is a stranger.
    """
    bearing, half = towards
    found: list[Rectangle] = []
    for distance in distances:
        wide = min(half, MAX_PLANE_HALF_RAD)
        found += _at_distance(boards, bearing, wide, float(distance), settings, who)
    return found


def every_distance(settings: PeopleSettings) -> Array:
    """Distances [m] from the camera, so close to each other that no person fits between them."""
    count = math.ceil(math.log(settings.farthest / settings.nearest) / math.log(settings.ratio)) + 1
    return np.geomspace(settings.nearest, settings.farthest, count)


def _at_distance(
    boards: VerticalPlanes,
    bearing: float,
    half: float,
    distance: float,
    settings: PeopleSettings,
    who: PersonProfile | None,
) -> list[Rectangle]:
    """The best rectangles on one plane, at most one per body's width."""
    aside = distance * math.tan(half) + settings.head_half
    reach = aside + BODY
    pixels, valid = boards.cut(distance, bearing, reach)
    if not valid.any():
        return []
    cells = edge_cells(pixels)
    left = (
        columns_of(reach) / 2 / CELLS_PER_METRE
        - (np.arange(cells.shape[1] - BODY_COLUMNS + 1) + BODY_COLUMNS / 2) / CELLS_PER_METRE
    )
    allowed = np.abs(left) <= aside
    values, ranks, weight, likely, inside = _weighed(general_model(), cells, valid)
    rank = np.where(allowed, ranks, -np.inf)  # (shifts, places)
    found: list[Rectangle] = []
    while True:
        shift, place = np.unravel_index(int(rank.argmax()), rank.shape)
        if not np.isfinite(rank[shift, place]) or sum(not one.stranger for one in found) >= 3:
            return found
        fit = _Fit(
            distance=math.hypot(distance, left[place]),
            bearing=bearing + math.atan2(left[place], distance),
            shift=SHIFTS[shift],
            value=float(values[shift, place]),
            rank=float(rank[shift, place]),
            shown=float(weight[shift, place]),
            likelihoods=likely[:, shift, place],
            shares=inside[:, shift, place],
        )
        person = _person_at(fit, boards, settings, who)
        if person is not None:
            found.append(person)
        elif rank[shift, place] < 0:
            return found
        rank[:, max(0, place - BODY_COLUMNS // 2) : place + BODY_COLUMNS // 2 + 1] = -np.inf


class _Fit(NamedTuple):
    """A place on a plane, and how well a body fits there."""

    distance: float  # [m] from the camera
    bearing: float  # [rad]
    shift: int  # [cell] by which the body is higher than the model's
    value: float  # K
    rank: float
    shown: float  # 0..1: weight of the parts that are in the picture
    likelihoods: Array  # (3,): K_i of the parts
    shares: Array  # (3,): of the parts that are in the picture


def _person_at(
    fit: _Fit, boards: VerticalPlanes, settings: PeopleSettings, who: PersonProfile | None
) -> Rectangle | None:
    """The person at that place, a stranger where it is not the one in the search list; None: nobody."""
    height = MODEL_HEIGHT_M + fit.shift / CELLS_PER_METRE
    enough = _threshold(fit.shown, settings)
    value, rank, likelihoods = fit.value, fit.rank, fit.likelihoods
    known = who is None and value >= enough
    if who is not None and _liked(1.0, likelihoods, fit.shares)[0] >= enough:  # else no colours make it that one
        like = alike(who.looks, colours_seen(boards, fit.distance, fit.bearing, height))
        liked = _liked(like, likelihoods, fit.shares)
        if liked[0] >= enough and like >= settings.alike:
            known, (value, rank, likelihoods) = True, liked
    if not known and value < enough:
        return None
    box = _box(boards, fit.distance, fit.bearing, (height, 0.0), BODY)
    return Rectangle(
        value=value,
        shown=fit.shown,
        distance=fit.distance,
        bearing=fit.bearing,
        height=height,
        parts=tuple(
            _seen_part(boards, part, fit.distance, fit.bearing, fit.shift, float(k), float(share))
            for part, k, share in zip(PARTS, likelihoods, fit.shares, strict=True)
        ),
        centre=((box[0] + box[2]) / 2, (box[1] + box[3]) / 2),
        box=box,
        rank=rank,
        stranger=not known,
    )


def _liked(like: float, single: Array, shares: Array) -> tuple[float, float, Array]:
    """Probability by looks, K_i (3,) and the parts' shares in the picture (3,) → K, its log odds and K_i of a person
    in the search list: every K_i includes that probability.
    """
    both = np.sqrt(single * like)
    weights = np.array([part.weight for part in PARTS]) * shares
    weights = weights / weights.sum()
    odds = np.log(np.clip(both, 1e-6, None)) - np.log(np.clip(1 - both, 1e-6, None))
    return float(weights @ both), float(weights @ odds), both


def _weighed(models: tuple[PartModel, ...], cells: Array, valid: Array) -> tuple[Array, Array, Array, Array, Array]:
    """For every shift of the crown and every place along: K (S, P), its log odds (S, P), the weight in the picture
    (S, P), K_i and the shares of the parts (3, S, P).
    """
    count = cells.shape[1] - BODY_COLUMNS + 1
    odds, shares = (np.empty((len(models), len(SHIFTS), count)) for _ in range(2))
    for number, model in enumerate(models):
        first = (BODY_COLUMNS - model.part.columns) // 2
        rises = [round(model.part.rise * shift) for shift in SHIFTS]
        found, share = likelihoods(model, cells, valid, range(rises[0], rises[-1] + 1))
        rows = np.array(rises) - rises[0]
        odds[number], shares[number] = found[rows, first : first + count], share[rows, first : first + count]
    shares = np.where(shares >= MIN_SHOWN_SHARE, shares, 0.0)
    single = 1 / (1 + np.exp(-np.clip(odds, -30, 30)))
    weights = shares * np.array([model.part.weight for model in models])[:, None, None]
    shown = weights.sum(axis=0)
    safe = np.maximum(shown, 1e-9)
    rank = np.where(shown > 0, (weights * odds).sum(axis=0) / safe, -np.inf)
    return (weights * single).sum(axis=0) / safe, rank, shown, single, shares


def _threshold(shown: float, settings: PeopleSettings) -> float:
    """The less is in the picture, the surer that must be."""
    lack = max(0.0, 1 - shown / settings.enough) if settings.enough > 0 else 0.0
    return settings.threshold + lack * (settings.threshold_of_feet - settings.threshold)


def _seen_part(
    boards: VerticalPlanes,
    part: BodySegment,
    distance: float,
    bearing: float,
    shift: int,
    likelihood: float,
    share: float,
) -> SeenPart:
    rise = part.rise * shift / CELLS_PER_METRE
    top = CEILING_M - part.top / CELLS_PER_METRE + rise
    bottom = max(0.0, top - part.rows / CELLS_PER_METRE)
    box = _box(boards, distance, bearing, (top, bottom), part.columns / 2 / CELLS_PER_METRE)
    return SeenPart(name=part.name, likelihood=likelihood if share > 0 else None, box=box)


def _box(
    boards: VerticalPlanes, distance: float, bearing: float, levels: tuple[float, float], half: float
) -> tuple[float, float, float, float]:
    """A rectangle on the plane, from one level [m] to the other, in the picture."""
    model = boards.camera.model
    places = np.array([(side * half, level) for level in np.linspace(*levels, 5) for side in (1, -1)])
    found = boards.pixels_of(distance, bearing, places)
    found = found[np.isfinite(found).all(axis=1)]
    if not len(found):
        return (0.0, 0.0, float(model.width), 0.0)
    low, high = found.min(axis=0), found.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def apart(found: list[Rectangle], settings: PeopleSettings) -> tuple[Rectangle, ...]:
    """The best of those that stand in each other's place."""
    kept: list[Rectangle] = []
    for one in sorted(found, key=lambda rectangle: -rectangle.rank * rectangle.shown**0.25):
        if all(_gap(one, other) > settings.overlap for other in kept):
            kept.append(one)
    return tuple(kept)


def _gap(one: Rectangle, other: Rectangle) -> float:
    """Distance between two [m] across the line of sight: along it a picture is hardly informative."""
    return min(one.distance, other.distance) * abs(math.sin(one.bearing - other.bearing))
