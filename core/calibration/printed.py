"""The chapter's own forms of calibration: eq. 13 for the mount, eq. 44 for the distortion's coefficients."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np

from core.calibration.laser.plane_pairs import Guess, PointPair, points_off, stack
from core.calibration.laser.planes import Plane
from core.calibration.levenberg_marquardt import minimise
from core.calibration.mount import Extrinsics
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel

PARAMETER_COUNT = 6  # turn and shift


class Equation44(TypedDict):
    """Coefficients in both forms of eq. 44, f being the mean focal length in pixels."""

    f_px: float
    k1_r: float  # f³ k1, as in Table 3
    k2_r: float  # f⁵ k2
    k1_t: float  # f² p1
    k2_t: float  # f² p2
    k1: float  # of eq. 4 [1/pixel³]
    k2: float  # [1/pixel⁵]
    p1: float  # of eq. 5 [1/pixel²]
    p2: float  # [1/pixel²]


def equation_44(model: CameraModel) -> Equation44:
    """A camera → its coefficients as eq. 44 has them.

    Table 3's numbers, and ours, multiply normalised coordinates. The factors as printed belong to no form of eq. 4-5:
    metric image coordinates would need f², f⁴ and f. They are an output only, and nothing is computed with them.
    """
    f = (model.fx + model.fy) / 2
    return {
        "f_px": f,
        "k1_r": model.k1,
        "k2_r": model.k2,
        "k1_t": model.p1,
        "k2_t": model.p2,
        "k1": model.k1 / f**3,
        "k2": model.k2 / f**5,
        "p1": model.p1 / f**2,
        "p2": model.p2 / f**2,
    }


def mount_by_equation_13(found: Extrinsics, boards: Sequence[tuple[Plane, Array]]) -> Extrinsics:
    """Planes that the camera saw, and the points (K, 3) [m] that the laser measured on each → the mount.

    The sum of squared distances of the points from the planes is minimised, all points alike, from the mount `found`;
    what the points leave open stays there. The covariance is that of the points' scatter and, since all points of a
    board have its error in common, of the planes', and grows as `found` does where both contradict each other.
    """
    alike = np.eye(3)
    pairs = [PointPair(plane=plane, point=point, covariance=alike) for plane, points in boards for point in points]
    seen = stack(pairs)

    def model(guess: Guess) -> tuple[Array, Array]:
        off, slope = points_off(seen, guess)
        return off, slope[:, :PARAMETER_COUNT]

    def move(guess: Guess, step: Array) -> Guess:
        return guess.moved(np.concatenate((step, (0.0, 0.0))))

    fit = minimise(model, Guess(found.transform.rotation, found.transform.translation), move)
    variance, bread = fit.cost / max(len(pairs) - PARAMETER_COUNT, 1), np.linalg.pinv(fit.information, hermitian=True)
    spread, first = variance * fit.information, 0
    for plane, points in boards:
        in_camera = (points - fit.state.translation) @ fit.state.rotation
        by_plane = np.column_stack((in_camera, np.full(len(points), -1.0)))
        together = fit.jacobian[first : first + len(points)].T @ by_plane
        spread, first = spread + together @ plane.covariance @ together.T, first + len(points)
    return replace(
        found,
        transform=Transform(rotation=fit.state.rotation, translation=fit.state.translation),
        covariance=max(found.misfit, 1.0) * bread @ spread @ bread,
        misfit=1.0,
        offset=None,
        scale=None,
    )
