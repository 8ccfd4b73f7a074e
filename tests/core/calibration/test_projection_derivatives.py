import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.calibration.projection import Poses, cross_matrices, linearise, model_of, project, vector_of
from core.message import Array
from core.optics import TABLE_3, CameraModel
from tests.core.calibration.seen_boards import BOARD, some_poses

CURVED = CameraModel(
    width=640, height=480, fx=519.3, fy=518.9, cx=331.1, cy=229.4, k1=0.114, k2=0.193, p1=-0.0027, p2=0.0037, k3=-1.1
)


def moved(camera: Array, poses: Poses, step: Array) -> tuple[Array, Poses]:
    return camera + step[:9], poses.moved(step[None, 9:])


@pytest.mark.parametrize("model", [TABLE_3, CURVED], ids=["table 3", "with k3"])
def test_derivatives_equal_finite_differences(model: CameraModel) -> None:
    camera, poses = vector_of(model), some_poses(1, seed=3)
    linear = linearise(camera, poses, BOARD.points)
    told = np.concatenate((linear.by_camera[0], linear.by_pose[0]), axis=1)
    for column in range(15):
        step = np.zeros(15)
        step[column] = 1e-6 * max(1.0, abs(camera[column]) if column < 4 else 1.0)
        ahead, back = (project(*moved(camera, poses, sign * step), BOARD.points)[0].T.ravel() for sign in (1, -1))
        difference = (ahead - back) / (2 * step[column])
        assert np.allclose(told[:, column], difference, rtol=1e-5, atol=1e-5 * np.abs(difference).max())


def test_projection_agrees_with_opencv() -> None:
    poses = some_poses(5, seed=1)
    ours = project(vector_of(CURVED), poses, BOARD.points)
    for rotation, translation, pixels in zip(*poses, ours, strict=True):
        turned = Rotation.from_matrix(rotation).as_rotvec()
        theirs = cv2.projectPoints(BOARD.points, turned, translation, CURVED.matrix, CURVED.distortion)[0]
        assert np.allclose(pixels, theirs.reshape(-1, 2), atol=1e-9)


def test_linearising_projects_the_same_pixels() -> None:
    camera, poses = vector_of(TABLE_3), some_poses(4)
    assert np.allclose(linearise(camera, poses, BOARD.points).pixels, project(camera, poses, BOARD.points))


def test_cross_matrices_cross() -> None:
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(5, 3)), rng.normal(size=(5, 3))
    assert np.allclose((cross_matrices(one) @ other[:, :, None])[..., 0], np.cross(one, other))


def test_a_camera_survives_the_way_through_its_vector() -> None:
    back = model_of(vector_of(CURVED), (640, 480))
    assert np.array_equal(vector_of(back), vector_of(CURVED)) and (back.width, back.height) == (640, 480)
