"""Networks without weights: whatever is white in a picture is an upright body, whose landmarks are known."""

import numpy as np

from core.message import Array

STANCE = np.array(
    [
        *[(0.0, 0.05)] * 7,  # nose and eyes: across and down, in statures from the crown
        (-0.04, 0.06),
        (0.04, 0.06),  # ears
        *[(0.0, 0.09)] * 2,
        (-0.11, 0.18),
        (0.11, 0.18),  # shoulders
        (-0.13, 0.32),
        (0.13, 0.32),
        *[(-0.13, 0.45), (0.13, 0.45)] * 4,
        (-0.06, 0.47),
        (0.06, 0.47),  # hips
        (-0.06, 0.72),
        (0.06, 0.72),
        *[(-0.06, 0.95), (0.06, 0.95)] * 3,
    ]
)
SEEN, HIDDEN = 6.0, -6.0  # logits


class StickNetworks:
    """Answers as the landmark network does."""

    name = "sticks"
    detects = False

    def __init__(self) -> None:
        self.runs = 0

    def landmarks(self, crop: Array) -> tuple[Array, float]:
        self.runs += 1
        rows, columns = np.nonzero(crop[:, :, 0] > 128)
        told = np.zeros((39, 5))
        told[:, 3:] = HIDDEN
        if len(rows) < 20:
            return told, 0.01
        tall = rows.max() - rows.min() + 1
        told[:33, :2] = (columns.min() + columns.max()) / 2, rows.min()
        told[:33, :2] += tall * STANCE
        told[:33, 3:] = SEEN
        return told, 0.95

    def faces(self, square: Array) -> tuple[Array, Array]:
        raise AssertionError("there is no detector here")


def white_body(width: int, height: int, column: float, top: float, stature: float) -> Array:
    """A picture (H, W, 3) with one white body."""
    picture = np.zeros((height, width, 3), np.uint8)
    half = 0.12 * stature
    left, right, bottom = round(column - half), round(column + half), round(top + stature)
    picture[max(round(top), 0) : max(bottom, 0), max(left, 0) : max(right, 0)] = 255
    return picture
