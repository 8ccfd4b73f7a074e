"""A person as the simulated camera sees one: drawn once from all sides, out of rounded limbs."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from core.message import Array

VIEWS = 16
SCALE = 110.0  # pixels per metre
WIDTH = 0.90  # [m] of the drawing
TALL = 1.75  # [m]

SKIN, HAIR, SHIRT = (140, 176, 222), (38, 52, 74), (72, 96, 204)
TROUSERS, SHOES, DARK = (120, 76, 52), (50, 46, 44), (40, 36, 36)

# From, to (forward, left, up) [m], radius at each end [m], colour.
LIMBS: tuple[
    tuple[tuple[float, float, float], tuple[float, float, float], float, float, tuple[int, int, int]], ...
] = (
    ((-0.05, 0.10, 0.035), (0.14, 0.11, 0.03), 0.045, 0.038, SHOES),
    ((-0.05, -0.10, 0.035), (0.14, -0.11, 0.03), 0.045, 0.038, SHOES),
    ((0.0, 0.10, 0.07), (0.0, 0.09, 0.85), 0.055, 0.085, TROUSERS),
    ((0.0, -0.10, 0.07), (0.0, -0.09, 0.85), 0.055, 0.085, TROUSERS),
    ((0.0, 0.07, 0.90), (0.0, -0.07, 0.90), 0.105, 0.105, TROUSERS),
    ((0.0, 0.06, 1.00), (0.0, -0.06, 1.00), 0.115, 0.115, SHIRT),
    ((0.0, 0.06, 1.05), (0.0, 0.09, 1.34), 0.115, 0.105, SHIRT),
    ((0.0, -0.06, 1.05), (0.0, -0.09, 1.34), 0.115, 0.105, SHIRT),
    ((0.0, 0.16, 1.37), (0.0, -0.16, 1.37), 0.075, 0.075, SHIRT),
    ((0.0, 0.21, 1.36), (0.01, 0.26, 1.10), 0.058, 0.050, SHIRT),
    ((0.0, -0.21, 1.36), (0.01, -0.26, 1.10), 0.058, 0.050, SHIRT),
    ((0.01, 0.26, 1.10), (0.07, 0.25, 0.86), 0.042, 0.036, SKIN),
    ((0.01, -0.26, 1.10), (0.07, -0.25, 0.86), 0.042, 0.036, SKIN),
    ((0.07, 0.25, 0.83), (0.09, 0.245, 0.80), 0.045, 0.040, SKIN),
    ((0.07, -0.25, 0.83), (0.09, -0.245, 0.80), 0.045, 0.040, SKIN),
    ((0.0, 0.0, 1.38), (0.0, 0.0, 1.50), 0.052, 0.050, SKIN),
    ((0.01, 0.0, 1.58), (0.01, 0.0, 1.64), 0.088, 0.095, SKIN),
    ((-0.03, 0.0, 1.60), (-0.012, 0.0, 1.66), 0.088, 0.098, HAIR),
    ((0.098, 0.035, 1.63), (0.098, 0.035, 1.632), 0.012, 0.012, DARK),
    ((0.098, -0.035, 1.63), (0.098, -0.035, 1.632), 0.012, 0.012, DARK),
    ((0.105, 0.0, 1.60), (0.108, 0.0, 1.585), 0.014, 0.016, SKIN),
)


@lru_cache(maxsize=VIEWS)
def figure(view: int) -> Array:
    """The person seen from the direction `view` · 360°/VIEWS, counter-clockwise from ahead → (H, W, 4) uint8.

    Blue, green, red, opacity; row 0 at TALL metres, the last row on the floor, the body's axis in the middle.
    """
    side = view * 2 * np.pi / VIEWS
    rows, columns = round(TALL * SCALE), round(WIDTH * SCALE)
    right = (np.arange(columns) + 0.5) / SCALE - WIDTH / 2
    up = TALL - (np.arange(rows) + 0.5)[:, None] / SCALE
    nearest = np.full((rows, columns), -np.inf)
    drawing = np.zeros((rows, columns, 4), np.uint8)
    for start, end, first, last, colour in LIMBS:
        a, b = (_seen_from(side, *point) for point in (start, end))
        run, rise = b[0] - a[0], b[2] - a[2]
        share = np.clip(((right - a[0]) * run + (up - a[2]) * rise) / max(run**2 + rise**2, 1e-9), 0.0, 1.0)
        radius = first + share * (last - first)
        x, y = right - a[0] - share * run, up - a[2] - share * rise
        bulge = np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0.0))
        depth = a[1] + share * (b[1] - a[1]) + bulge
        shows = (bulge > 0) & (depth > nearest)
        nearest[shows] = depth[shows]
        bright = 0.62 + 0.34 * bulge / radius + 0.14 * y / radius - 0.10 * x / radius
        drawing[shows, :3] = np.clip(bright[..., None] * colour, 0, 255)[shows]
        drawing[shows, 3] = 255
    drawing.setflags(write=False)
    return drawing


def _seen_from(side: float, forward: float, left: float, up: float) -> tuple[float, float, float]:
    """A point of the body → to the viewer's right, towards the viewer, up [m]."""
    c, s = np.cos(side), np.sin(side)
    return float(left * c - forward * s), float(forward * c + left * s), up
