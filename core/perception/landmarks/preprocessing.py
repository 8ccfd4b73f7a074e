"""Preprocessing of a picture before edge detection: light, contrast, smoothing."""

import cv2
import numpy as np

from core.message import Array, message


@message
class Preprocessing:
    """Preprocessing steps before edge detection; the defaults do nothing."""

    gain: float = 1.0  # on the light, before it is rounded to grey levels
    gamma: float = 1.0  # on the result: below 1 lifts the darks
    contrast: float = 1.0  # on gradients; below 1 where even the smoothing leaves too much noise
    along: float = 1.0  # times Canny's smoothing, along upright edges
    across: float = 1.0  # and across them

    @property
    def idle(self) -> bool:
        """True when no step does anything."""
        return (self.gain, self.gamma, self.contrast, self.along, self.across) == (1.0, 1.0, 1.0, 1.0, 1.0)

    def grey(self, pixels: Array) -> Array:
        """Picture (H, W, 3) or (H, W) uint8 → grey (H, W) uint8, brightened before anything is rounded."""
        if self.gain == 1.0:
            grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if pixels.ndim == 3 else pixels
        elif pixels.ndim == 3:
            grey = cv2.transform(pixels, self.gain * np.array([[0.114, 0.587, 0.299]]))
        else:
            grey = cv2.convertScaleAbs(pixels, alpha=self.gain)
        if self.gamma != 1.0:
            curve = 255 * (np.arange(256) / 255) ** self.gamma
            grey = cv2.LUT(grey, np.round(curve).astype(np.uint8))
        return grey

    def slope(self, level: float) -> float:
        """Factor by which gain and gamma enlarge a small difference at grey level `level`."""
        reached = min(max(self.gain * level, 1.0), 255.0)
        return self.gain * self.gamma * (reached / 255) ** (self.gamma - 1)


NOTHING = Preprocessing()
