"""The scene's colours: middle tones that stand out on dark and on light alike. Red stays reserved for faults."""

import numpy as np

from core.message import Array

Colour = tuple[int, int, int]

WALL: Colour = (104, 121, 148)
FREE: Colour = (120, 150, 190)
GRID: Colour = (112, 122, 138)
SCAN: Colour = (20, 184, 166)  # teal
POSE: Colour = (14, 165, 233)  # cyan: where the robot believes to be
TRAIL: Colour = (56, 149, 211)
GHOST: Colour = (224, 133, 55)  # orange: what the wheels alone believe
OTHER: Colour = (217, 70, 130)  # raspberry: the other way of a recording
PLAN: Colour = (203, 75, 208)  # magenta: where it wants to go
CONVEX: Colour = (34, 172, 92)
CONCAVE: Colour = (124, 92, 240)
CLOSURE: Colour = (236, 72, 133)  # rose: a place that was recognised
DOUBT: Colour = (217, 140, 20)  # amber: not used, or doubtful
VOICE: Colour = (214, 84, 190)  # a voice
OWN_MAP: Colour = (150, 120, 60)  # ochre: what the robot's own navigation says
ROOM: Colour = (96, 165, 250)
UNSURE: Colour = (142, 148, 160)
BODY: Colour = (233, 236, 241)
TRIM: Colour = (58, 64, 76)
TYRE: Colour = (34, 37, 44)


def faded(colour: Colour, part: float) -> Colour:
    """`part` (0..1) of a colour, the rest is that of what is not sure."""
    r, g, b = (round(part * full + (1 - part) * grey) for full, grey in zip(colour, UNSURE, strict=True))
    return r, g, b


PREVIEW: Colour = faded(PLAN, 0.6)  # where a spoken command would go, before it begins


def as_drawn(colours: Array) -> Array:
    """Colours (N, 3) → line colours; the browser shows a line brighter than its values (sRGB as linear)."""
    return np.round(255 * (colours / 255.0) ** 2.2).astype(np.uint8)
