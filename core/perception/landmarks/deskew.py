"""A scan taken on the move, put back into the robot frame of one instant."""

import numpy as np

from core.message import Array
from core.sensors import Laser, Scan, Wheels


def drift(elapsed: Array, speed: float, turn_rate: float) -> tuple[Array, Array, Array]:
    """Elapsed times (N,) [s] on an arc of constant twist → x (N,), y (N,) [m] and turn (N,) [rad] after them."""
    turn = turn_rate * elapsed
    half = 0.5 * turn
    chord = speed * elapsed * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half), turn


def beam_ends(scan: Scan, laser: Laser, wheels: Wheels | None, at: float) -> tuple[Array, Array]:
    """Scan → beam ends (N, 2) [m] in the robot frame at time `at` [s], and which of them hit something (N,) bool.

    Every beam is carried from its own time to `at` with the wheels' constant twist (none: as if at rest).
    Ends are NaN where nothing was measured; a beam that met nothing (inf) ends at `range_max` and is no hit.
    """
    hits = scan.valid
    ranges = np.where(hits, scan.ranges, np.where(np.isposinf(scan.ranges), scan.range_max, np.nan))
    angles = scan.angles + laser.mounting.heading
    x = laser.mounting.x + ranges * np.cos(angles)
    y = laser.mounting.y + ranges * np.sin(angles)
    if wheels is not None and (wheels.speed != 0.0 or wheels.turn_rate != 0.0):
        ahead, aside, turn = drift(scan.times - at, wheels.speed, wheels.turn_rate)
        c, s = np.cos(turn), np.sin(turn)
        x, y = ahead + c * x - s * y, aside + s * x + c * y
    return np.column_stack((x, y)), hits


def deskew(scan: Scan, laser: Laser, wheels: Wheels | None, at: float) -> tuple[Array, Array]:
    """Scan → points hit (M, 2) [m] in the robot frame at time `at` [s], and their beams (M,)."""
    ends, hits = beam_ends(scan, laser, wheels, at)
    return ends[hits], np.flatnonzero(hits)
