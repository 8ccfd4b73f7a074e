"""The colours of a body, part by part: they distinguish one person from another (section 4.2)."""

from __future__ import annotations

import cv2
import numpy as np

from core.message import Array, message
from core.perception.people.parts import CEILING, CELL, CELLS_PER_METRE, PARTS, SCALE, TALL, Part
from core.perception.people.vertical_plane import VerticalPlanes

HUES, GREYS = 12, 6  # bins of colours, and of what has none
COLOURLESS = 45  # saturation below which a pixel has no colour
WASHED = 0.003  # share added to every bin: light changes
HALF = 0.25  # [m] of a view to either side in which colours are looked at
SHOWN = 0.3  # share of a part in the picture from which its colours count
LEARNT = 0.1  # share by which what is remembered follows what is seen


@message
class PersonProfile:
    """One person's colours, part by part: what no stranger shares by chance."""

    name: str
    colours: Array  # (3, HUES + GREYS): head, torso, feet; every row sums to 1, or is NaN where it was never seen
    pictures: int  # from how many
    shape: float = 0.0  # height of the contour over the shoulders' width; 0: not measured


def colours_seen(boards: VerticalPlanes, distance: float, bearing: float, height: float) -> Array:
    """The colours (3, HUES + GREYS) of who stands there, `distance` [m] and `bearing` [rad] from the camera, so tall
    [m]; NaN for a part that is not in the picture.
    """
    pixels, valid = boards.cut(distance, bearing, HALF)
    inside = np.repeat(np.repeat(valid, CELL, axis=0), CELL, axis=1)
    shift = round((height - TALL) * CELLS_PER_METRE)
    rows: list[Array] = []
    for part in PARTS:
        region, shown = region_of(part, pixels, inside, shift)
        enough = shown.size and shown.mean() >= SHOWN
        rows.append(shares_of(region, shown) if enough else np.full(HUES + GREYS, np.nan))
    return np.array(rows)


def alikeness(who: PersonProfile, seen: Array) -> Array:
    """Colours (3, HUES + GREYS) → how alike each part is, (3,) 0 to 1 (Bhattacharyya); NaN for what is not known."""
    return np.sqrt(seen * who.colours).sum(axis=1) ** 2


def alike(who: PersonProfile, seen: Array) -> float:
    """The same for torso and legs together; 1 when nothing can be compared."""
    both = alikeness(who, seen)[1:]
    return float(np.nanmean(both)) if np.isfinite(both).any() else 1.0


def remembered(seen: Array, before: PersonProfile | None) -> PersonProfile:
    """Mix the colours seen now (3, HUES + GREYS) into the known profile."""
    if before is None:
        return PersonProfile(name="", colours=seen, pictures=1)
    old = np.where(np.isnan(before.colours), seen, before.colours)
    mixed = np.where(np.isnan(seen), old, (1 - LEARNT) * old + LEARNT * seen)
    return PersonProfile(name=before.name, colours=mixed, pictures=before.pictures + 1)


def region_of(part: Part, pixels: Array, inside: Array, shift: int) -> tuple[Array, Array]:
    """The core of a part in a compared view with the body in its middle, and which of its pixels count."""
    middle, half = pixels.shape[1] / 2, part.core / 2 * SCALE
    top = (part.top - round(part.rise * shift) + 0.15 * part.rows) * CELL
    bottom = min(top + 0.75 * part.rows * CELL, CEILING * SCALE)
    area = (slice(round(top), round(bottom)), slice(round(middle - half), round(middle + half)))
    return pixels[area], inside[area]


def shares_of(pixels: Array, shown: Array) -> Array:
    """Pixels (H, W, 3) and which count (H, W) bool → shares of hues and of greys (HUES + GREYS,)."""
    hue, saturation, value = cv2.split(cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_BGR2HSV))
    greys = HUES + value.astype(int) * GREYS // 256
    bins = np.where(saturation >= COLOURLESS, hue.astype(int) * HUES // 180, greys)
    counts = np.bincount(bins[shown], minlength=HUES + GREYS).astype(float)
    counts += WASHED * max(1.0, float(counts.sum()))
    return counts / counts.sum()
