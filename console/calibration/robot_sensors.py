"""Between a robot's profile and its calibration: which sensors the pilot looks through."""

from __future__ import annotations

from dataclasses import replace

from console.calibration.in_use import InUse
from console.calibration.laser_keeping import mount_told
from console.calibration.values import Told, camera_told
from console.problems import Problem
from console.wire_calibration import CalibrationSource
from core.calibration.mount import Mount
from core.geometry import Transform
from core.optics import CameraModel
from core.robots import Profile


def nominal_mount(profile: Profile) -> Transform:
    """The robot as built → laser_from_camera. It has both sensors."""
    assert profile.camera is not None
    return laser_in(profile).inverse() @ profile.camera.mounting


def calibrated(profile: Profile, in_use: InUse) -> tuple[Profile, str]:
    """The robot as built and what was accepted → the robot as calibrated, and why something is not used, or ''.

    A camera's calibration holds for one picture size; one of another size is left aside, and with it the mount, which
    was found through that camera.
    """
    camera, model, mount = profile.camera, in_use.camera, in_use.mount
    if camera is None or model is None:
        return profile, ""
    if (model.width, model.height) != (camera.model.width, camera.model.height):
        size, own = f"{model.width}x{model.height}", f"{camera.model.width}x{camera.model.height}"
        return profile, (
            f"The accepted camera calibration is for {size} pictures, this robot's camera gives {own}; it is not "
            "used. Calibrate at this size, or take the calibration back."
        )
    mounting = camera.mounting if mount is None or profile.laser is None else laser_in(profile) @ mount
    return replace(profile, camera=replace(camera, model=model, mounting=mounting)), ""


def laser_start(
    profile: Profile, source: CalibrationSource, model: CameraModel | None, height: float | None
) -> tuple[Told, Told]:
    """What a laser's session begins with: the camera in use and what is known about the mount, by `height` [m] or as
    built. Raises Problem 409 where the laser cannot be calibrated.
    """
    if source != "robot":
        raise Problem(409, "The laser is calibrated with the robot's own camera and laser: choose the robot.")
    if profile.laser is None:
        raise Problem(409, "This robot has no laser.")
    if model is None:
        raise Problem(409, "Calibrate the camera first; the laser is calibrated against it.")
    own = profile.camera.model if profile.camera is not None else None
    if own is None or (own.width, own.height) != (model.width, model.height):
        raise Problem(409, "The camera's calibration is for pictures of another size; calibrate the camera anew.")
    mount = Mount(nominal=nominal_mount(profile)) if height is None else Mount.measured(height)
    return camera_told(model), mount_told(mount)


def laser_in(profile: Profile) -> Transform:
    """robot_from_laser, in space."""
    assert profile.laser is not None
    return Transform.of_pose(profile.laser.mounting, profile.laser.height)
