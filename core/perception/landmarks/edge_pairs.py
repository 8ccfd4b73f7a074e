"""Which vertical edge may belong to which corner, and by how much the two disagree: what a turned camera shows in."""

import math

import numpy as np

from core.geometry import Pose, wrap_all
from core.message import Array, message
from core.perception.landmarks.corners import Corner
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.sensors import Camera

WINDOW_RAD = math.radians(6.0)
"""[rad] Pairs that disagree by more are no pairs; a camera that was turned further than that sees nothing match."""


@message
class EdgePair:
    """A corner, and an edge that stands near the bearing at which the camera should see it."""

    position: Array  # (2,) [m] of the corner in the robot frame
    off: float  # [rad] bearing of the edge less that of the corner, both from where the camera is believed to be
    sd: float  # [rad] of `off` for a pair that belongs together
    lever: float  # [1/m] by how much a camera further left would see the corner further right: cos(bearing) / range


def edge_pairs(
    corners: tuple[Corner, ...], edges: tuple[ImageEdge, ...], moved: Pose, camera: Camera, settings: EdgeSettings
) -> tuple[EdgePair, ...]:
    """All pairs within the window. `moved`: where the picture was taken, in the corners' frame.

    Not only the nearest edge of a corner: that choice would pull every disagreement towards zero. Edges that are
    none of a corner's spread over the window; those that are its own gather at one disagreement.
    """
    if not corners or not edges:
        return ()
    eye = moved.apply(camera.mounting.translation[None, :2])[0]
    shown = np.array([edge.bearing for edge in edges]) + moved.heading
    pairs: list[EdgePair] = []
    for corner in corners:
        seen = corner.position - eye
        reach = max(float(np.hypot(*seen)), 1e-3)
        bearing = math.atan2(seen[1], seen[0])
        slope = np.array([-seen[1], seen[0]]) / reach**2
        variance = float(slope @ corner.covariance @ slope)
        variance += settings.bearing_sd**2 + (settings.shift_share * moved.heading) ** 2
        off = wrap_all(shown - bearing)
        lever = math.cos(bearing - moved.heading) / reach
        pairs += [
            EdgePair(position=corner.position, off=float(one), sd=math.sqrt(variance), lever=lever)
            for one in off[np.abs(off) < WINDOW_RAD]
        ]
    return tuple(pairs)
