"""A ball that rolls along points, with them on its right."""

from __future__ import annotations

import numpy as np

from core.message import Array


def rolled(here: Array, contact: Array, wall: Array, radius: tuple[float, float], steps: tuple[float, int]) -> Array:
    """From beside a contact (2,) [m] on along the wall (C, 2) [m] → the line (P, 2) [m].

    `here` (2,) tells the side of the contact; `radius` [m]: of the line, and what the ball is larger; `steps`: how
    long one is [m], and how many.
    """
    size = sum(radius)
    away = here - contact
    place = contact + size * away / max(float(np.hypot(*away)), 1e-6)
    line: list[Array] = []
    for _ in range(steps[1]):
        place, out = _pushed_out(place, wall, size)
        line.append(place - radius[1] * out)
        place = place + steps[0] * np.array([out[1], -out[0]])
    return np.array(line)


def _pushed_out(place: Array, wall: Array, radius: float) -> tuple[Array, Array]:
    """A ball's centre (2,) [m] → the same so that it only touches the wall; the direction (2,) away from the wall."""
    for _ in range(2):
        place = _touching(place, wall, radius)[0]
    return _touching(place, wall, radius)


def _touching(place: Array, wall: Array, radius: float) -> tuple[Array, Array]:
    gaps = np.hypot(*(wall - place).T)
    nearest = int(gaps.argmin())
    out = (place - wall[nearest]) / max(float(gaps[nearest]), 1e-6)
    return wall[nearest] + radius * out, out
