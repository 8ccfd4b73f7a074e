"""A person as the simulated camera sees one: drawn once from every side, in any clothes, out of rounded limbs."""

import math
from functools import lru_cache

import numpy as np

from core.message import Array
from core.simulation.world import FOOT_SWING_M

VIEW_COUNT = 16  # sides from which a figure is drawn
STEP_PHASES = 8  # moments of a step
PIXELS_PER_METRE = 110.0  # pixels per metre
DRAWING_WIDTH_M = 1.60  # of the drawing: arms stretched out
PERSON_HEIGHT_M = 1.75  # of the person
DRAWING_HEIGHT_M = 2.05  # of the drawing: arms raised

Colour = tuple[int, int, int]
Point = tuple[float, float, float]  # forward, left, up [m]
Limb = tuple[Point, Point, float, float, Colour]  # from, to, radius at each end [m]

SKIN, HAIR, SHOES, DARK = (140, 176, 222), (38, 52, 74), (50, 46, 44), (40, 36, 36)
CLOTHES: dict[str, Colour] = {
    "red": (72, 96, 204),
    "blue": (120, 76, 52),
    "green": (84, 130, 66),
    "white": (222, 226, 228),
    "grey": (132, 130, 128),
    "black": (48, 44, 44),
    "yellow": (70, 190, 222),
    "brown": (62, 92, 122),
}
USUAL = ("red", "blue")  # shirt and trousers of a person without a request

ARMS: dict[str, tuple[Point, Point, Point, Point]] = {
    "": ((0.01, 0.26, 1.10), (0.09, 0.245, 0.80), (0.01, 0.26, 1.10), (0.09, 0.245, 0.80)),
    "wave": ((0.04, 0.42, 1.42), (0.06, 0.38, 1.74), (0.01, 0.26, 1.10), (0.09, 0.245, 0.80)),
    "up": ((0.03, 0.34, 1.58), (0.03, 0.30, 1.90), (0.03, 0.34, 1.58), (0.03, 0.30, 1.90)),
    "wide": ((0.0, 0.47, 1.36), (0.0, 0.74, 1.36), (0.0, 0.47, 1.36), (0.0, 0.74, 1.36)),
    "point": ((0.26, 0.23, 1.34), (0.54, 0.20, 1.34), (0.01, 0.26, 1.10), (0.09, 0.245, 0.80)),
    "hips": ((-0.04, 0.44, 1.16), (0.07, 0.21, 0.99), (-0.04, 0.44, 1.16), (0.07, 0.21, 0.99)),
    "crossed": ((0.06, 0.27, 1.12), (0.21, -0.08, 1.18), (0.06, 0.27, 1.10), (0.23, -0.08, 1.13)),
}
"""Gesture → elbow and hand of the left arm, then of the right one as in a mirror."""


def figure(view: int, look: str = "", gesture: str = "", stride: float = 0.0) -> Array:
    """The person seen from the direction `view` · 360°/VIEWS, counter-clockwise from ahead → (H, W, 4) uint8.

    Blue, green, red, opacity; row 0 at TOP metres, the last row on the floor, the body's axis in the middle.
    `look`, `gesture` and `stride` are those of a `Thing`.
    """
    return _drawn(view % VIEW_COUNT, look, gesture, round(STEP_PHASES * stride / math.tau) % STEP_PHASES)


@lru_cache(maxsize=400)
def _drawn(view: int, look: str, gesture: str, step: int) -> Array:
    side = view * 2 * np.pi / VIEW_COUNT
    rows, columns = round(DRAWING_HEIGHT_M * PIXELS_PER_METRE), round(DRAWING_WIDTH_M * PIXELS_PER_METRE)
    right = (np.arange(columns) + 0.5) / PIXELS_PER_METRE - DRAWING_WIDTH_M / 2
    up = DRAWING_HEIGHT_M - (np.arange(rows) + 0.5) / PIXELS_PER_METRE
    nearest = np.full((rows, columns), -np.inf)
    drawing = np.zeros((rows, columns, 4), np.uint8)
    for start, end, first, last, colour in _limbs(look, gesture, math.tau * step / STEP_PHASES):
        a, b = (_seen_from(side, *point) for point in (start, end))
        reach = max(first, last)
        area = (_between(up, a[2], b[2], reach), _between(right, a[0], b[0], reach))
        across, high = right[area[1]], up[area[0], None]
        run, rise = b[0] - a[0], b[2] - a[2]
        share = np.clip(((across - a[0]) * run + (high - a[2]) * rise) / max(run**2 + rise**2, 1e-9), 0.0, 1.0)
        radius = first + share * (last - first)
        x, y = across - a[0] - share * run, high - a[2] - share * rise
        bulge = np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0.0))
        depth = a[1] + share * (b[1] - a[1]) + bulge
        shows = (bulge > 0) & (depth > nearest[area])
        nearest[area][shows] = depth[shows]
        bright = 0.62 + 0.34 * bulge / radius + 0.14 * y / radius - 0.10 * x / radius
        drawing[area][shows, :3] = np.clip(bright[..., None] * colour, 0, 255)[shows]
        drawing[area][shows, 3] = 255
    drawing.setflags(write=False)
    return drawing


def _between(places: Array, one: float, other: float, reach: float) -> slice:
    low, high = min(one, other) - reach, max(one, other) + reach
    inside = np.flatnonzero((places >= low) & (places <= high))
    return slice(int(inside[0]), int(inside[-1]) + 1) if len(inside) else slice(0, 0)


def _limbs(look: str, gesture: str, stride: float) -> list[Limb]:
    shirt, trousers = (CLOTHES[name] for name in (look.split("/") if look else USUAL))
    limbs: list[Limb] = [
        ((0.0, 0.07, 0.90), (0.0, -0.07, 0.90), 0.105, 0.105, trousers),
        ((0.0, 0.06, 1.00), (0.0, -0.06, 1.00), 0.115, 0.115, shirt),
        ((0.0, 0.06, 1.05), (0.0, 0.09, 1.34), 0.115, 0.105, shirt),
        ((0.0, -0.06, 1.05), (0.0, -0.09, 1.34), 0.115, 0.105, shirt),
        ((0.0, 0.16, 1.37), (0.0, -0.16, 1.37), 0.075, 0.075, shirt),
        ((0.0, 0.0, 1.38), (0.0, 0.0, 1.50), 0.052, 0.050, SKIN),
        ((0.01, 0.0, 1.58), (0.01, 0.0, 1.64), 0.088, 0.095, SKIN),
        ((-0.03, 0.0, 1.60), (-0.012, 0.0, 1.66), 0.088, 0.098, HAIR),
        ((0.098, 0.035, 1.63), (0.098, 0.035, 1.632), 0.012, 0.012, DARK),
        ((0.098, -0.035, 1.63), (0.098, -0.035, 1.632), 0.012, 0.012, DARK),
        ((0.105, 0.0, 1.60), (0.108, 0.0, 1.585), 0.014, 0.016, SKIN),
    ]
    left_elbow, left_hand, right_elbow, right_hand = ARMS[gesture]
    swing = FOOT_SWING_M * math.sin(stride)
    for side, elbow, hand in ((1, left_elbow, left_hand), (-1, right_elbow, right_hand)):
        foot, knee = side * swing, 0.5 * side * swing + 0.06 * abs(math.sin(stride))
        limbs += [
            ((foot - 0.05, side * 0.10, 0.035), (foot + 0.14, side * 0.11, 0.03), 0.045, 0.038, SHOES),
            ((foot, side * 0.10, 0.07), (knee, side * 0.095, 0.46), 0.055, 0.07, trousers),
            ((knee, side * 0.095, 0.46), (0.0, side * 0.09, 0.85), 0.07, 0.085, trousers),
            *_arm(side, elbow, hand, -0.6 * side * swing, shirt),
        ]
    return limbs


def _arm(side: int, elbow: Point, hand: Point, swing: float, shirt: Colour) -> list[Limb]:
    joint = (elbow[0] + 0.5 * swing, side * elbow[1], elbow[2])
    tip = (hand[0] + swing, side * hand[1], hand[2])
    palm = tuple(at + 0.1 * (at - before) for at, before in zip(tip, joint, strict=True))
    return [
        ((0.0, side * 0.21, 1.36), joint, 0.058, 0.050, shirt),
        (joint, tip, 0.042, 0.036, SKIN),
        (tip, (palm[0], palm[1], palm[2]), 0.045, 0.040, SKIN),
    ]


def _seen_from(side: float, forward: float, left: float, up: float) -> Point:
    """A point of the body → to the viewer's right, towards the viewer, up [m]."""
    c, s = np.cos(side), np.sin(side)
    return float(left * c - forward * s), float(forward * c + left * s), up
