"""The camera's mount in files: static transform, URDF joint, 4x4 both ways, and back from our own JSON."""

from collections.abc import Mapping
from typing import Any, TypedDict

import numpy as np
import scipy

from core.calibration.files.camera_files import number
from core.calibration.mount import Extrinsics, inverse_covariance
from core.errors import BadInput
from core.geometry import Transform
from core.message import Array

LASER, CAMERA = "laser", "camera_optical_frame"
MAX_MOUNT_DISTANCE_M = 5.0  # between camera and laser on one robot
FORWARD, BACK = "P_laser = R P_camera + t", "P_camera = R P_laser + t"

Rows = list[list[float]]


# (4, 4) of both directions
MountMatrices = TypedDict("MountMatrices", {"P_laser = R P_camera + t": Rows, "P_camera = R P_laser + t": Rows})


class MountEntry(MountMatrices):
    """The mount as it stands in our own JSON."""

    covariance_rxyz_txyz: dict[str, Rows]  # (6, 6) by direction
    chi2_per_freedom: float
    not_known: list[str]
    from_ruler: dict[str, str]
    poses_used: int


def static_transform(laser_from_camera: Transform, parent: str = LASER, child: str = CAMERA) -> str:
    """The ROS 2 command that publishes the mount: the pose of the child in the parent, exactly eq. 11."""
    x, y, z = laser_from_camera.translation
    qx, qy, qz, qw = scipy.spatial.transform.Rotation.from_matrix(laser_from_camera.rotation).as_quat()
    numbers = {"x": x, "y": y, "z": z, "qx": qx, "qy": qy, "qz": qz, "qw": qw}
    words = " ".join(f"--{name} {number(value)}" for name, value in numbers.items())
    return f"ros2 run tf2_ros static_transform_publisher {words} --frame-id {parent} --child-frame-id {child}"


def urdf_joint(laser_from_camera: Transform, parent: str = LASER, child: str = CAMERA) -> str:
    """The fixed joint of a URDF. Its angles are singular at a pitch of 90 degrees; the quaternion is the truth."""
    xyz = " ".join(number(value) for value in laser_from_camera.translation)
    rpy = " ".join(
        number(value)
        for value in scipy.spatial.transform.Rotation.from_matrix(laser_from_camera.rotation).as_euler("xyz")
    )
    return (
        f'<joint name="{parent}_to_{child}" type="fixed">\n  <parent link="{parent}"/>\n  <child link="{child}"/>\n'
        f'  <origin xyz="{xyz}" rpy="{rpy}"/>\n</joint>\n'
    )


def matrix(transform: Transform) -> Array:
    """(4, 4)."""
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = transform.rotation, transform.translation
    return whole


def mount_entry(found: Extrinsics) -> MountEntry:
    """The mount as it stands in our own JSON: both directions, each with its covariance as it is shown."""
    return {
        **both_ways(found.transform),
        "covariance_rxyz_txyz": {
            FORWARD: found.shown_covariance.tolist(),
            BACK: inverse_covariance(found.transform, found.shown_covariance).tolist(),
        },
        "chi2_per_freedom": found.misfit,
        "not_known": list(found.unknown),
        "from_ruler": found.from_ruler,
        "poses_used": int(np.count_nonzero(found.used)),
    }


def both_ways(laser_from_camera: Transform) -> MountMatrices:
    """The 4x4 matrices of both directions, under the names of our own JSON."""
    return {FORWARD: matrix(laser_from_camera).tolist(), BACK: matrix(laser_from_camera.inverse()).tolist()}


def read_mount(entry: Mapping[str, object]) -> Transform:
    """The entry of our own JSON → laser_from_camera. Raises BadInput where it is no rigid transform."""
    if FORWARD not in entry:
        raise BadInput(f"The mount needs a 4x4 matrix under '{FORWARD}'.")
    return rigid(entry[FORWARD])


def rigid(rows: Any) -> Transform:
    """A 4x4 matrix as lists → transform. Raises BadInput where it is no rigid transform."""
    try:
        whole = np.array(rows, dtype=float)
    except (ValueError, TypeError):
        raise BadInput("The mount is not a 4x4 matrix of numbers.") from None
    if whole.shape != (4, 4) or not np.all(np.isfinite(whole)) or not np.allclose(whole[3], [0, 0, 0, 1]):
        raise BadInput("The mount is not a 4x4 matrix of finite numbers that ends in 0 0 0 1.")
    turn = whole[:3, :3]
    if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) or np.linalg.det(turn) < 0:
        raise BadInput("The mount's rotation is not a rotation.")
    if np.abs(whole[:3, 3]).max() > MAX_MOUNT_DISTANCE_M:
        raise BadInput(
            f"The mount puts the camera more than {MAX_MOUNT_DISTANCE_M:g} m from the laser; is it in metres?"
        )
    return Transform(rotation=turn, translation=whole[:3, 3])
