"""The simulated laser: rays through the world, noise, dropouts."""

import numpy as np

from core.message import Array
from core.sensors.laser import Laser, Scan
from core.simulation.world import Hits, World, cast


class SimulatedLaser:
    """Makes scans: every beam from where the robot was at its time, with noise and failures.

    Range noise has the standard deviation max(`floor_sd`, `share_sd` · range). A beam fails now and then
    (`dropout`), mostly where it grazes a surface, and always beyond the range.
    """

    GRAZING_COSINE = 0.14  # cosine of the angle of incidence below which beams begin to fail (82°)

    def __init__(
        self,
        laser: Laser,
        rng: np.random.Generator,
        *,
        floor_sd: float = 0.010,
        share_sd: float = 0.01,
        dropout: float = 0.004,
    ) -> None:
        self.laser, self._rng = laser, rng
        self._floor_sd, self._share_sd, self._dropout = floor_sd, share_sd, dropout
        self._angles = laser.angle_min + laser.angle_step * np.arange(laser.beams)
        self._cast: tuple[World, Array, Hits] | None = None  # the last world, beams and where they ended

    @property
    def duration(self) -> float:
        """From the first to the last beam [s]."""
        return self.laser.time_step * (self.laser.beams - 1)

    def scan(self, world: World, stamp: float, times: Array, poses: Array) -> Scan:
        """The scan that began at `stamp` [s] of a robot that at `times` (K,) [s] was at `poses` (K, 3).

        Headings in `poses` run on without jumps at ±π.
        """
        laser = self.laser
        at = stamp + laser.time_step * np.arange(laser.beams)
        x, y, heading = (np.interp(at, times, poses[:, axis]) for axis in range(3))
        c, s = np.cos(heading), np.sin(heading)
        forward, left = laser.mounting.x, laser.mounting.y
        origins = np.column_stack((x + c * forward - s * left, y + s * forward + c * left))
        direction = heading + laser.mounting.heading + self._angles
        rays = np.column_stack((np.cos(direction), np.sin(direction)))
        hits = self._hits(world, np.hstack((origins, rays)))
        return Scan(
            stamp=stamp,
            ranges=self._measured(hits.distance, hits.cosine),
            angle_min=laser.angle_min,
            angle_step=laser.angle_step,
            range_min=laser.range_min,
            range_max=laser.range_max,
            time_step=laser.time_step,
        )

    def _hits(self, world: World, beams: Array) -> Hits:
        """Beams (N, 4) from (x, y) [m] along unit vectors → where they end; a standing robot needs it only once."""
        if self._cast is None or self._cast[0] is not world or not np.array_equal(self._cast[1], beams):
            ends = cast(beams[:, :2], beams[:, 2:], world.laser_surfaces(self.laser.height), self.laser.range_max)
            self._cast = world, beams, ends
        return self._cast[2]

    def _measured(self, distance: Array, cosine: Array) -> Array:
        """True distances (N,) [m] and incidence (N,) → ranges (N,) [m] in mm steps, NaN where a beam fails."""
        noise, luck = self._rng.normal(size=len(distance)), self._rng.random(len(distance))
        grazing = np.clip(1 - cosine / self.GRAZING_COSINE, 0.0, 1.0)
        reached = (distance <= self.laser.range_max) & (luck >= self._dropout + 0.8 * grazing)
        seen = np.where(reached, distance, np.nan)
        ranges = np.round(seen + np.maximum(self._floor_sd, self._share_sd * seen) * noise, 3)
        return np.where((ranges >= self.laser.range_min) & (ranges <= self.laser.range_max), ranges, np.nan)
