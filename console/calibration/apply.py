"""Between a robot's profile and its calibration: which sensors the pilot looks through."""

from dataclasses import replace

import numpy as np

from console.calibration.calibration_store import CalibrationStore
from console.http.problems import Problem
from console.messages.calibration import CalibrationKind, CalibrationSource
from core.calibration.camera.uncertainty import map_pixels
from core.calibration.mount import Mount
from core.calibration.reports import target
from core.errors import BadInput
from core.geometry import Transform
from core.optics import CameraModel
from core.perception.landmarks.level_view import level_bounds
from core.robots import Profile
from core.sensors import Camera

SAME_CAMERA_RATIO = 3  # times the exactness asked of a camera's calibration, by which two may differ for one mount

Reasons = dict[CalibrationKind, str]


def nominal_mount(profile: Profile) -> Transform:
    """The robot as built → laser_from_camera. It has both sensors."""
    assert profile.camera is not None
    return laser_in(profile).inverse() @ profile.camera.mounting


def calibrated(profile: Profile, active: CalibrationStore) -> tuple[Profile, Reasons]:
    """The robot as built and the accepted calibrations → the robot as calibrated, and why one is not used, by kind.

    A camera's calibration holds for one picture size; one of another size is left aside. A mount holds for the camera
    it was found through: it is left aside where the robot now looks through another.
    """
    model, no_model = usable_model(profile, active)
    mount, no_mount = usable_mount(profile, model, active)
    reasons: Reasons = {}
    if no_model:
        reasons["camera"] = no_model
    if no_mount:
        reasons["laser"] = no_mount
    if profile.camera is None or model is None:
        return profile, reasons
    camera = profile.camera
    if model is not camera.model:
        camera = replace(camera, model=model, optics_known=True)
        if wrong := not_level(camera):
            reasons["camera"] = wrong
            return profile, reasons
    if mount is not None:
        mounted = replace(camera, mounting=laser_in(profile) @ mount, mounting_known=True)
        if wrong := not_level(mounted):
            reasons["laser"] = wrong
        else:
            camera = mounted
    return profile.with_camera(camera), reasons


def not_level(camera: Camera) -> str:
    """Why the robot cannot look through this camera; "" when it can."""
    try:
        level_bounds(camera)
    except BadInput as wrong:
        return str(wrong)
    return ""


def usable_model(profile: Profile, active: CalibrationStore) -> tuple[CameraModel | None, str]:
    """The camera that the robot looks through, accepted or as built, and why the accepted one is not used."""
    camera, accepted = profile.camera, active.camera
    if camera is None:
        return None, "" if accepted is None else "This robot has no camera; the accepted calibration is not used."
    if "camera" in active.left_out:
        return camera.model, active.left_out["camera"]
    if accepted is None or (accepted.width, accepted.height) == (camera.model.width, camera.model.height):
        return accepted or camera.model, ""
    size, own = f"{accepted.width}x{accepted.height}", f"{camera.model.width}x{camera.model.height}"
    return camera.model, (
        f"The accepted camera calibration is for {size} pictures, this robot's camera gives {own}; it is not "
        "used. Calibrate at this size, or take the calibration back."
    )


def usable_mount(
    profile: Profile, model: CameraModel | None, active: CalibrationStore
) -> tuple[Transform | None, str]:
    """The accepted mount for a robot that looks through `model`, and why it is not used."""
    mount, through = active.mount, active.mount_camera
    if mount is None or through is None:
        return None, ""
    if "laser" in active.left_out:
        return None, active.left_out["laser"]
    if model is None or profile.laser is None:
        return None, "The accepted mount is not used: this robot has not both a camera and a laser."
    if (through.width, through.height) != (model.width, model.height):
        return None, (
            f"The accepted mount was found through a camera with {through.width}x{through.height} pictures, the one "
            f"in use gives {model.width}x{model.height}; it is not used. Calibrate the laser again."
        )
    away = apart(through, model)
    if away > SAME_CAMERA_RATIO * target(model.width):
        return None, (
            f"The accepted mount was found through another camera calibration, {away:.1f} px from the one in use; it "
            "is not used. Calibrate the laser again, or take the camera's calibration back."
        )
    return mount, ""


def apart(one: CameraModel, other: CameraModel) -> float:
    """How far apart two cameras in one mount see the same things, in 95 % of the picture [pixel].

    Unlike `core.calibration.camera.uncertainty.difference` no turn of the camera is allowed for: the mount holds it.
    """
    pixels = map_pixels(one)
    ideal = one.undistort((pixels - (one.cx, one.cy)) / (one.fx, one.fy))
    seen = other.distort(ideal) * (other.fx, other.fy) + (other.cx, other.cy)
    away = np.linalg.norm(seen - pixels, axis=1)
    known = away[np.isfinite(away)]
    return float(np.quantile(known, 0.95)) if len(known) else float("inf")


def laser_start(
    profile: Profile, source: CalibrationSource, model: CameraModel | None, height: float | None
) -> tuple[CameraModel, Mount]:
    """Return the start of a laser's session: the camera in use and what is known of the mount, by `height` [m] or as
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
        raise Problem(409, "The camera's calibration is for pictures of another size; calibrate the camera again.")
    mount = Mount(nominal=nominal_mount(profile)) if height is None else Mount.measured(height)
    return model, mount


def laser_in(profile: Profile) -> Transform:
    """robot_from_laser, in space."""
    assert profile.laser is not None
    return Transform.of_pose(profile.laser.mounting, profile.laser.height)
