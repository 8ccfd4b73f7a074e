import json

import numpy as np
import pytest

from core.calibration.files.mount_files import BACK, FORWARD, matrix, mount_entry, static_transform, urdf_joint
from core.calibration.files.mount_reading import LOOKS_UP, ON_ITS_SIDE, mount_doubts, parse_mount
from core.calibration.mount import FEW_POSES, Extrinsics, inverse_covariance
from core.calibration.projection import exponential
from core.errors import BadInput
from core.geometry import OPTICAL, Transform

MOUNT = Transform(rotation=exponential(np.array([[0.4, -0.3, 1.1]]))[0], translation=np.array([0.1, -0.2, 1e-5]))
BOTH = {"laser_from_camera": matrix(MOUNT).tolist(), "camera_from_laser": matrix(MOUNT.inverse()).tolist()}
RUN = "ros2 run tf2_ros static_transform_publisher"


def found(poses: int) -> Extrinsics:
    return Extrinsics(
        transform=MOUNT,
        covariance=np.diag([1e-4] * 6),
        used=np.ones(poses, bool),
        chi2=np.ones(poses),
        misfit=1.0,
        gain=np.ones(6),
        weak=(),
    )


def only(name: str) -> str:
    return json.dumps({name: BOTH[name]})


@pytest.mark.parametrize(
    "text",
    [
        static_transform(MOUNT),
        "#!/bin/sh\n" + static_transform(MOUNT).replace(" --", " \\\n  --") + "\n",
        static_transform(MOUNT.inverse(), "camera_optical_frame", "base_scan"),
        urdf_joint(MOUNT),
        urdf_joint(MOUNT.inverse(), "camera_optical_frame", "laser"),
        f'<robot name="r"><link name="laser"/><joint type="fixed"><parent link="base"/><child link="laser"/></joint>'
        f"{urdf_joint(MOUNT)}</robot>",
        json.dumps(BOTH),
        only("laser_from_camera"),
        only("camera_from_laser"),
        json.dumps({"extrinsics": mount_entry(found(3))}),
        json.dumps({BACK: mount_entry(found(3))[BACK]}),
        json.dumps({"rotation": MOUNT.rotation.tolist(), "translation_m": MOUNT.translation.tolist()}),
    ],
)
def test_every_form_that_is_written_comes_back(text: str) -> None:
    assert np.allclose(matrix(parse_mount(text)), matrix(MOUNT), atol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        f"{RUN} 1 2 3 0.5 0 0 laser camera",
        f"{RUN} 1 2 3 0 0 0.247403959 0.968912422 laser camera",
        "rosrun tf static_transform_publisher 1 2 3 0.5 0 0 laser camera 100",
        "rosrun tf static_transform_publisher 1 2 3 0 0 0.247403959 0.968912422 laser camera 100",
        f"{RUN} --x 1 --y 2 --z 3 --yaw 0.5 --frame-id laser --child-frame-id camera",
        f"{RUN} --frame-id=laser --child-frame-id=camera --x=1 --y=2 --z=3 --yaw=0.5",
    ],
)
def test_the_documented_forms_of_the_command_are_read(text: str) -> None:
    told = parse_mount(text)
    assert np.allclose(told.translation, [1, 2, 3])
    assert np.allclose(told.rotation, exponential(np.array([[0.0, 0.0, 0.5]]))[0], atol=1e-8)


def test_yaw_comes_before_pitch_and_roll_in_the_positional_form() -> None:
    named = f"{RUN} --roll 0.1 --pitch 0.2 --yaw 0.3 --frame-id laser --child-frame-id camera"
    positional = parse_mount(f"{RUN} 0 0 0 0.3 0.2 0.1 laser camera")
    assert np.allclose(parse_mount(named).rotation, positional.rotation)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello", "no mount"),
        (f"{RUN} --roll -90 --yaw -90 --frame-id laser --child-frame-id camera", "degrees"),
        (f"{RUN} --x 50 --z -80 --frame-id laser --child-frame-id camera", "in metres"),
        ("{}", "no mount"),
        (f"{RUN} 1 2 3 laser camera", "x y z yaw"),
        (f"{RUN} 1 2 nan 0 0 0 laser camera", "finite"),
        (f"{RUN} 1 2 3 0 0 0 2 laser camera", "length 1"),
        (f"{RUN} 1 2 3 0 0 0 base_link camera", "between laser and camera"),
        (f"{RUN} 1 2 3 0 0 0 laser camera_link", "optical frame"),
        (f"{RUN} --x 1 --speed 2 --frame-id laser --child-frame-id camera", "--speed"),
        (f"{RUN} --x --y 2", "needs a name"),
        ("<joint", "XML"),
        ("<!DOCTYPE x><joint/>", "entities"),
        ("<robot/>", "exactly one"),
        (urdf_joint(MOUNT).replace("fixed", "revolute"), "fixed"),
        (json.dumps(BOTH | {"camera_from_laser": BOTH["laser_from_camera"]}), "contradict"),
        (json.dumps({FORWARD: 2 * np.eye(4).tolist()}), "4x4"),
        (json.dumps({"rotation": [1], "translation_m": [[2]]}), "rotation"),
    ],
)
def test_what_is_no_mount_is_refused_in_words(text: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        parse_mount(text)


def test_a_mount_that_looks_up_or_lies_on_its_side_is_doubted() -> None:
    level = Transform(rotation=OPTICAL, translation=np.array([0.05, 0.0, -0.08]))
    raised = level @ Transform(rotation=exponential(np.array([[0.5, 0.0, 0.0]]))[0], translation=np.zeros(3))
    assert mount_doubts(level) == mount_doubts(raised) == []
    assert mount_doubts(level.inverse()) == [ON_ITS_SIDE]
    assert mount_doubts(Transform(rotation=np.eye(3), translation=level.translation)) == [LOOKS_UP]


def test_with_few_poses_the_doubled_uncertainty_is_also_the_one_that_is_kept() -> None:
    for poses, times in ((FEW_POSES - 1, 4), (FEW_POSES, 1)):
        kept = mount_entry(found(poses))["covariance_rxyz_txyz"]
        assert np.allclose(kept[FORWARD], times * found(poses).covariance)
        assert np.allclose(kept[BACK], inverse_covariance(MOUNT, times * found(poses).covariance))
