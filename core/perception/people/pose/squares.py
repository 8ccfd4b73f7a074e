"""Squares of a picture that a network looks at."""

import math

import cv2
import numpy as np

from core.message import Array, message
from core.perception.people.pose.landmarks import BodyLandmarks
from core.perception.people.pose.networks import LANDMARK_SIDE

FIRST_SIDE = 1.3  # statures: side of a square around someone of whom only the place is known
SECOND_SIDE = 2.5  # times the largest distance of a landmark from the hips


@message
class Square:
    """A square of the picture, which may reach out of it."""

    x: float  # [pixel] its middle
    y: float
    side: float  # [pixel]
    turn: float = 0.0  # [rad] by which it is turned clockwise, as seen in the picture


class ImagePyramid:
    """A picture and its halves, from which squares of any size are cut without aliasing."""

    def __init__(self, pixels: Array) -> None:
        """Pixels (H, W, 3) uint8."""
        self._levels = [pixels]

    @property
    def pixels(self) -> Array:
        """(H, W, 3) uint8."""
        return self._levels[0]

    @property
    def width(self) -> int:
        """[pixel]."""
        return self._levels[0].shape[1]

    @property
    def height(self) -> int:
        """[pixel]."""
        return self._levels[0].shape[0]

    def cut(self, square: Square, side: int = LANDMARK_SIDE) -> Array:
        """Cut a square → (side, side, 3) uint8, black beyond the picture."""
        level = max(0, math.floor(math.log2(max(square.side / side, 1.0))))
        matrix = picture_from_crop(square, side) / 2**level  # pyrDown keeps the middles of even pixels
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(self._level(level), matrix, (side, side), flags=flags)

    def _level(self, level: int) -> Array:
        while len(self._levels) <= level and min(self._levels[-1].shape[:2]) > 1:
            self._levels.append(cv2.pyrDown(self._levels[-1]))
        return self._levels[min(level, len(self._levels) - 1)]


def picture_from_crop(square: Square, side: int = LANDMARK_SIDE) -> Array:
    """The affine map (2, 3) from the pixels of a cut square to those of the picture."""
    c, s = math.cos(square.turn), math.sin(square.turn)
    turn = (square.side / side) * np.array([[c, -s], [s, c]])
    return np.column_stack((turn, np.array([square.x, square.y]) - turn @ np.array([side / 2, side / 2])))


def around_hips(found: BodyLandmarks) -> Square:
    """The square for a second look at someone who was found."""
    hips = found.hips
    reach = float(np.hypot(*(found.points - hips).T).max())
    return Square(x=float(hips[0]), y=float(hips[1]), side=SECOND_SIDE * max(reach, 1.0))
