"""Vertical edges in a picture, as bearings (Canny, Hough; section 4.1)."""

from __future__ import annotations

from core.message import Array, message


@message
class Edge:
    """A vertical edge in the newest picture."""

    top: Array  # (2,) pixel in the picture as the camera delivers it
    bottom: Array  # (2,) pixel
    bearing: float  # [rad] in the robot frame
    matched: bool = False  # confirms a laser corner
