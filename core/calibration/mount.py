"""The camera's mount on the laser: what is known before and after calibrating."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from core.calibration.laser.plane_pairs import Guess
from core.calibration.projection import cross_matrices
from core.geometry import OPTICAL, Transform
from core.message import Array, message

NAMES = ("roll", "pitch", "yaw", "forward", "sideways", "height")
"""The six unknowns: turns about the laser's x, y, z axes and shifts along them."""

FEW_POSES = 10  # poses below which scatter was up to three times the computed sd, so the sd is doubled
LOOSE_TURN, LOOSE_SHIFT = np.deg2rad(3), 0.05  # [rad], [m]: how well a mount is known by looking at it
CLOSE_TURN, CLOSE_SHIFT = np.deg2rad(1), 0.01  # [rad], [m]: below this a direction was measured
FREE_TURN, FREE_SHIFT = np.deg2rad(10), 0.3  # [rad], [m]: as good as nothing


@message
class Mount:
    """Prior knowledge of the mount, without calibrating: laser_from_camera and its standard deviations."""

    nominal: Transform = Transform(rotation=OPTICAL, translation=np.zeros(3))
    spread: tuple[float, ...] = (LOOSE_TURN, LOOSE_TURN, LOOSE_TURN, LOOSE_SHIFT, LOOSE_SHIFT, LOOSE_SHIFT)

    @property
    def sds(self) -> Array:
        """(6,) [rad, m] in the order of NAMES."""
        return np.array(self.spread)

    @property
    def from_ruler(self) -> dict[str, str]:
        """Directions known well enough without any board, and how they were measured."""
        closely = [sd < (CLOSE_TURN if number < 3 else CLOSE_SHIFT) for number, sd in enumerate(self.spread)]
        return {
            name: "as level" if number < 3 else "by ruler"
            for number, (name, close) in enumerate(zip(NAMES, closely, strict=True))
            if close
        }

    @staticmethod
    def measured(height: float, height_sd: float = 0.005, level_sd: float = np.deg2rad(0.5)) -> Mount:
        """For upright boards: the camera's height above the laser [m] by ruler, level to within `level_sd` [rad]."""
        nominal = Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, height]))
        return Mount(nominal=nominal, spread=(level_sd, level_sd, FREE_TURN, FREE_SHIFT, FREE_SHIFT, height_sd))


@message
class Extrinsics:
    """The answer, how sure it is, and what the data leave open."""

    transform: Transform  # laser_from_camera
    covariance: Array  # (6, 6) in the order of NAMES, inflated by the misfit
    used: Array  # (M,) bool: the pairs that took part
    chi2: Array  # (M,) of every pair, scaled to two degrees of freedom
    misfit: float  # chi-square per degree of freedom; 1 where the stated noise explains the residuals
    gain: Array  # (6,): 1 - sd / sd of the mount alone
    weak: tuple[str, ...]  # the NAMES that the data leave open; there the mount's nominal value speaks
    measured: dict[str, str] = field(default_factory=dict[str, str])  # the NAMES that were, and how: Mount.witnessed
    offset: tuple[float, float] | None = None  # [m] range offset and its sd, when asked for
    scale: tuple[float, float] | None = None  # board size factor and its sd, when asked for

    @property
    def sds(self) -> Array:
        """(6,) [rad, m] in the order of NAMES."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def from_ruler(self) -> dict[str, str]:
        """Directions that the data leave open and that are known all the same → how they were measured."""
        return {name: method for name, method in self.measured.items() if name in self.weak}

    @property
    def unknown(self) -> tuple[str, ...]:
        """The NAMES that neither data nor measurement determine."""
        return tuple(name for name in self.weak if name not in self.measured)

    @property
    def shown_covariance(self) -> Array:
        """(6, 6): as it is shown and kept; with few poses the standard deviations are doubled."""
        return self.covariance * (4.0 if np.count_nonzero(self.used) < FEW_POSES else 1.0)

    @property
    def guess(self) -> Guess:
        """As the residuals take it."""
        offset, scale = (
            (0.0 if self.offset is None else self.offset[0]),
            (1.0 if self.scale is None else self.scale[0]),
        )
        return Guess(self.transform.rotation, self.transform.translation, offset, scale)


def inverse_covariance(transform: Transform, covariance: Array) -> Array:
    """Covariance (6, 6) of a_from_b → that of b_from_a; both in the axes of the frame they lead to."""
    back = transform.rotation.T
    slope = np.zeros((6, 6))
    slope[:3, :3] = slope[3:, 3:] = -back
    slope[3:, :3] = -back @ cross_matrices(transform.translation)
    return slope @ covariance @ slope.T
