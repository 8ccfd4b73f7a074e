import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from core.calibration.files.camera_files import (
    camera_entry,
    kalibr_yaml,
    number,
    opencv_yaml,
    parse_camera,
    read_camera,
    ros_yaml,
)
from core.calibration.files.mount_files import (
    BACK,
    FORWARD,
    matrix,
    mount_entry,
    read_mount,
    static_transform,
    urdf_joint,
)
from core.calibration.files.yaml_reading import read_yaml
from core.calibration.mount import Extrinsics
from core.calibration.projection import exponential, vector_of
from core.errors import BadInput
from core.geometry import Transform
from core.optics import TABLE_3, CameraModel
from core.sensors.checks import CHECKS

WITH_K3 = CameraModel(
    width=640, height=480, fx=519.26845842, fy=518.89359517, cx=331.1, cy=229.4, k1=0.11, k3=-1.0954
)


@st.composite
def lenses(draw: st.DrawFn) -> CameraModel:
    """Any size, any principal point, a focal length and a distortion that a lens may have."""
    width = draw(st.integers(16, 4000))
    height = draw(st.integers(max(16, width // 3), min(4000, 3 * width)))
    fx = max(width, height) * draw(st.floats(1.0, 8.0))
    return CameraModel(
        width=width,
        height=height,
        fx=fx,
        fy=fx * draw(st.floats(0.9, 1.1)),
        cx=width * draw(st.floats(0.4, 0.6)),
        cy=height * draw(st.floats(0.4, 0.6)),
        k1=draw(st.floats(-0.3, 0.3)),
        k2=draw(st.floats(-0.1, 0.1)),
        p1=draw(st.floats(-1e-3, 1e-3)),
        p2=draw(st.floats(-1e-3, 1e-3)),
    )


@settings(deadline=None, max_examples=50)
@given(model=lenses())
def test_every_form_comes_back_to_the_last_digit(model: CameraModel) -> None:
    forms = (
        ros_yaml(model),
        opencv_yaml(model, board=(9, 6, 0.025), rms=0.2),
        kalibr_yaml(model),
        json.dumps({"camera": camera_entry(model)}),
        json.dumps(camera_entry(model)),
    )
    for text in forms:
        back = parse_camera(text)
        assert np.array_equal(vector_of(back), vector_of(model))
        assert (back.width, back.height) == (model.width, model.height)


def test_what_the_command_line_prints_is_read_back() -> None:
    told = {"image_size": [320, 256], "fx": 301.5, "fy": 303.2, "cx": 155.5, "cy": 139.3, "k1": -0.43, "k2": 0.24}
    model = parse_camera(json.dumps(told))
    assert (model.fx, model.k2, model.p1, model.k3) == (301.5, 0.24, 0.0, 0.0)


def test_opencv_reads_our_form(tmp_path: Path) -> None:
    path = tmp_path / "camera.yml"
    path.write_text(opencv_yaml(WITH_K3, board=(9, 6, 0.025)))
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert np.array_equal(storage.getNode("camera_matrix").mat(), WITH_K3.matrix)
    assert np.array_equal(storage.getNode("distortion_coefficients").mat().ravel(), WITH_K3.distortion)
    assert storage.getNode("board_width").real() == 9


def test_our_form_of_opencv_is_read_back_after_opencv_wrote_it(tmp_path: Path) -> None:
    path = tmp_path / "camera.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", WITH_K3.matrix)
    storage.write("distortion_coefficients", WITH_K3.distortion.reshape(5, 1))
    storage.release()
    assert np.allclose(vector_of(read_camera(path)), vector_of(WITH_K3), rtol=1e-15)


def test_ros_gets_every_key_it_requires() -> None:
    document = read_yaml(ros_yaml(TABLE_3))
    assert list(document) == [
        "image_width",
        "image_height",
        "camera_name",
        "camera_matrix",
        "distortion_model",
        "distortion_coefficients",
        "rectification_matrix",
        "projection_matrix",
    ]
    assert document["camera_name"] == "camera" and document["distortion_coefficients"]["cols"] == 5
    assert document["projection_matrix"]["rows"] == 3 and len(document["projection_matrix"]["data"]) == 12


def test_yaml_agrees_with_the_common_reader() -> None:
    yaml = pytest.importorskip(
        "yaml", reason="PyYAML is not installed here; our reader is tested by round trips alone"
    )
    for text in (
        ros_yaml(TABLE_3),
        kalibr_yaml(TABLE_3),
        "a: 1\nb:\n  - 1.5\n  - -2.0e-3\nc: {x: 1, y: [1,2, 3], z: 'q'}\nd:\n- [1,2]\n- [3,\n   4]\n",
        'e: "a # b" # c\n',
        "top:\n  inner:\n    deep: [1.0, -2.5e+3]\n  other: text with spaces\nlast: ~\n",
    ):
        assert read_yaml(text) == yaml.safe_load(text)


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_every_number_has_a_decimal_point_and_all_its_digits(value: float) -> None:
    text = number(value)
    assert float(text) == value and "." in text


def test_kalibr_cannot_hold_k3() -> None:
    with pytest.raises(BadInput, match="k3"):
        kalibr_yaml(WITH_K3)


GOOD = {"image_size": [640, 480], "K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]], "dist": [0, 0, 0, 0]}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"image_size": None}, "image size"),
        ({"image_size": [640]}, "image size"),
        ({"image_size": [640.5, 480]}, "whole numbers"),
        ({"K": [[500, 0, 320], [0, 500, 240]]}, "6 numbers"),
        ({"K": [[500, 3, 320], [0, 500, 240], [0, 0, 1]]}, "camera matrix must read"),
        ({"K": [[-500, 0, 320], [0, 500, 240], [0, 0, 1]]}, "positive"),
        ({"K": [[500, 0, 720], [0, 500, 240], [0, 0, 1]]}, "principal point"),
        ({"K": [[500, 0, "320"], [0, 500, 240], [0, 0, 1]]}, "not a number"),
        ({"K": [[True, 0, 320], [0, 500, 240], [0, 0, 1]]}, "not a number"),
        ({"dist": [0, 0, 0]}, "3 numbers"),
        ({"dist": [0, 0, 0, 0, 0, 0.1, 0, 0]}, "beyond"),
        ({"dist_model": "equidistant"}, "equidistant"),
        ({"K": None}, "camera matrix"),
        ({"K": [0] * 9}, "not calibrated"),
        ({"K": [500, 0, 0.5, 0, 500, 0.5, 0, 0, 1]}, "in pixels"),
        ({"K": [4.2, 0, 320, 0, 4.2, 240, 0, 0, 1], "dist": [-0.25, 0.09, 0, 0, 0]}, "field of view across is 178"),
        ({"dist": [0.0, -5e-4, 1e-3, 0.06, -0.05]}, "in this order"),
        ({"K": [52000, 0, 320, 0, 52000, 240, 0, 0, 1]}, "field of view across is 0.705"),
        ({"dist": [25.0, 9.0, 0, 0, 0]}, "far beyond"),
        ({"dist": None, "dist_model": "plumb_bob"}, "write zeros"),
        ({"dist": None, "distortionCoefs": [0.1, 0, 0, 0, 0]}, "write zeros"),
    ],
)
def test_a_camera_file_that_makes_no_sense_is_refused_in_words(change: dict[str, object], words: str) -> None:
    with pytest.raises(BadInput, match=words):
        parse_camera(json.dumps(GOOD | change))


LENS = {"fx": 520.0, "fy": 520.0, "cx": 322.0, "cy": 236.0, "k1": -0.25, "k2": 0.09, "p1": 5e-4, "p2": -4e-4}
TERMS, ROW = [-0.25, 0.09, 5e-4, -4e-4], [520.0, 0.0, 322.0, 0.0, 520.0, 236.0, 0.0, 0.0, 1.0]
ECHO = {"height": 480, "width": 640, "distortion_model": "plumb_bob", "D": [*TERMS, 0.0], "K": ROW}
ROS = {
    "image_width": 640,
    "image_height": 480,
    "camera_matrix": {"rows": 3, "cols": 3, "data": ROW},
    "distortion_model": "plumb_bob",
    "distortion_coefficients": {"rows": 1, "cols": 8, "data": [*TERMS, 0.0, 0.0, 0.0, 0.0]},
}
KALIBR = {
    "camera_model": "pinhole",
    "intrinsics": [520.0, 520.0, 322.0, 236.0],
    "distortion_model": "radtan",
    "distortion_coeffs": TERMS,
    "resolution": [640, 480],
}
PHOTONVISION = {
    "resolution": {"width": 640.0, "height": 480.0},
    "cameraIntrinsics": {"rows": 3, "cols": 3, "type": 6, "data": ROW},
    "distCoeffs": {"rows": 1, "cols": 8, "type": 6, "data": [*TERMS, 0.0, 0.0, 0.0, 0.0]},
    "lensmodel": "LENSMODEL_OPENCV",
}
LIMELIGHT = {
    "img_size": [640, 480],
    "camera_matrix": [ROW[:3], ROW[3:6], ROW[6:]],
    "distortion_coefficients": [TERMS],
}
XML = """<?xml version="1.0"?>
<opencv_storage>
<!-- flags: +fix_aspectRatio -->
<image_width>640</image_width> <image_height>480</image_height> <fisheye_model>{fisheye}</fisheye_model>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
<data> 520. 0. 322. 0. 5.2000000000000000e+02 236. 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>4</rows><cols>1</cols><dt>d</dt>
<data> -2.5e-01 9.e-02 5.0e-04 -4e-04</data></distortion_coefficients>
</opencv_storage>"""
REALSENSE = {"width": 640, "height": 480, "fx": 520, "fy": 520, "ppx": 322, "ppy": 236, "coeffs": [0.1, 0, 0, 0, 0]}
OCAM = "#polynomial coefficients for the DIRECT mapping function (ocam_model.ss in MATLAB)\n5 -200.0 0.0 1e-3"


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(ECHO),
        "\n".join(f"{name.lower()}: {json.dumps(entry)}" for name, entry in ECHO.items()) + "\n---\n",
        "\n".join(f"{name}: {json.dumps(entry)}" for name, entry in ECHO.items()) + "\n---\nheight: 2\n---\n",
        json.dumps(ROS),
        json.dumps(ROS | {"distortion_model": "rational_polynomial"}),
        json.dumps({"cam0": KALIBR}),
        json.dumps(
            KALIBR | {"sensor_type": "camera", "rate_hz": 20, "distortion_model": "radial-tangential"}
        ),  # EuRoC's
        opencv_yaml(CameraModel(width=640, height=480, **LENS))
        .replace("image_w", "image_W")
        .replace("image_h", "image_H")
        .replace("camera_matrix", "Camera_Matrix")
        .replace("distortion_coefficients", "Distortion_Coefficients"),
        json.dumps(PHOTONVISION),
        json.dumps(LIMELIGHT | {"distortion_coefficients": [[*TERMS, 0.0]]}),
        XML.format(fisheye=0),
        json.dumps(ECHO | {"K": [520.0, 1e-13, 322.0, 0.0, 520.0, 236.0, 0.0, 0.0, 1.0]}),
        json.dumps(ECHO | {"K": [2.0 * number for number in ROW]}),
        json.dumps(LENS | {"width": 640, "height": 480, "model": "brown_conrady"}),
    ],
)
def test_the_same_lens_is_read_from_what_other_programs_write(text: str) -> None:
    model = parse_camera(text)
    assert (model.width, model.height, model.k3) == (640, 480, 0.0)
    assert {name: getattr(model, name) for name in LENS} == LENS


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        (opencv_yaml(TABLE_3) + "fisheye_model: 1\n", "camera.other_model", {"model": "fisheye"}),
        (XML.format(fisheye=1), "camera.other_model", {"model": "fisheye"}),
        (
            json.dumps({"cam0": KALIBR | {"distortion_model": "equidistant"}}),
            "camera.other_model",
            {"model": "equidis"},
        ),
        (json.dumps({"cam0": KALIBR | {"camera_model": "omni"}}), "camera.other_model", {"model": "omni"}),
        (
            json.dumps({"cam0": KALIBR | {"camera_model": "ds", "intrinsics": [1, 2, 3, 4, 5, 6]}}),
            "camera.other_model",
            {},
        ),
        (json.dumps({"value0": {"intrinsics": [{"camera_type": "kb4"}]}}), "camera.other_model", {"model": "kb4"}),
        (OCAM, "camera.other_model", {"model": "Scaramuzza"}),
        (json.dumps({"cam0": KALIBR | {"distortion_model": None}}), "camera.unnamed_model", {}),
        (json.dumps(ECHO | {"distortion_model": "", "D": TERMS}), "camera.unnamed_model", {}),
        (json.dumps(LIMELIGHT), "camera.unnamed_model", {}),
        (json.dumps(ECHO | {"D": [*TERMS, 0.0, 0.1, 0.0, 0.0]}), "camera.rational", {}),
        (json.dumps(ECHO | {"width": 2560, "height": 1920}), "camera.binned", {"width": "2560x1920"}),
        (json.dumps(ECHO | {"width": 1920, "height": 1080}), "camera.binned", {"width": "1920x1080"}),
        (
            json.dumps(ECHO | {"width": 480, "height": 640}),
            "camera.swapped_size",
            {"size": "middle of a picture of 640"},
        ),
        (json.dumps(LENS | {"width": 640, "height": 480, "k4": 0.3}), "camera.rational", {}),
        (json.dumps(REALSENSE | {"model": "kannala_brandt4"}), "camera.other_model", {"model": "kannala"}),
        (json.dumps(REALSENSE | {"model": "distortion.inverse_brown_conrady"}), "camera.other_model", {}),
    ],
)
def test_a_file_for_another_lens_model_or_size_is_refused_by_its_name(
    text: str, code: str, values: dict[str, str]
) -> None:
    with pytest.raises(BadInput) as told:
        parse_camera(text)
    assert CHECKS[code].sentence.split("{")[0] in str(told.value)
    assert all(value in str(told.value) for value in values.values())


def test_realsense_cameras_without_distortion_are_read_whatever_their_model() -> None:
    told = REALSENSE | {"model": "distortion.inverse_brown_conrady", "coeffs": [0.0] * 5}
    model = parse_camera(json.dumps(told))
    assert (model.cx, model.cy, model.fx, model.distortion.any()) == (322.0, 236.0, 520.0, False)


def test_of_several_cameras_none_is_taken() -> None:
    with pytest.raises(BadInput, match=r"2 cameras \(cam0, cam1\)"):
        parse_camera(json.dumps({"cam1": KALIBR, "cam0": KALIBR}))
    assert parse_camera(json.dumps({"cam1": KALIBR})).fx == 520.0


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(ROS | {"distortion_coefficients": {"rows": 1, "cols": 5, "data": [*TERMS, 0.0, 0.0, 0.0, 0.0]}}),
        '<?xml version="1.0"?><!DOCTYPE l [<!ENTITY a "b">]><opencv_storage><cols>&a;</cols></opencv_storage>',
        "<opencv_storage><camera_matrix>",
        '{"image_size":[640,480],"K":[[NaN,0,320],[0,500,240],[0,0,1]]}',
        '{"image_size":[640,480],"K":[[Infinity,0,320],[0,500,240],[0,0,1]]}',
        "image_width: 640\nimage_height: 480\ncamera_matrix: {data: [.nan, 0, 1, 0, 1, 1, 0, 0, 1]}",
        "a: &a [1, 1]\nb: [*a, *a]",
        "<<: {a: 1}",
        "a: 1\na: 2",
        "a: [1, 2",
        "a: |\n  text",
        "- 1\n- 2",
        "",
        "[" * 5000,
        "{" + '"a":{' * 2000,
        "a:\n" + "".join(f"{' ' * n}b:\n" for n in range(1, 60)) + " " * 60 + "c: 1",
    ],
)
def test_hostile_text_is_refused_in_words(text: str) -> None:
    with pytest.raises(BadInput) as told:
        parse_camera(text)
    assert len(str(told.value)) < 200


def some_mount() -> Extrinsics:
    turn = exponential(np.array([[0.4, -0.3, 1.1]]))[0]
    transform = Transform(rotation=turn, translation=np.array([0.1, -0.2, 1e-5]))
    return Extrinsics(
        transform=transform,
        covariance=np.diag([1e-4] * 6),
        used=np.ones(4, bool),
        chi2=np.ones(4),
        misfit=1.2,
        gain=np.ones(6),
        weak=("height",),
    )


def test_the_static_transform_is_equation_11() -> None:
    found = some_mount()
    words = static_transform(found.transform).split()
    told = {name.removeprefix("--"): value for name, value in zip(words[4::2], words[5::2], strict=True)}
    shift = [float(told[name]) for name in "xyz"]
    turn = Rotation.from_quat([float(told[name]) for name in ("qx", "qy", "qz", "qw")]).as_matrix()
    assert np.allclose(turn, found.transform.rotation) and np.allclose(shift, found.transform.translation)
    assert told["frame-id"] == "laser" and told["child-frame-id"] == "camera_optical_frame"


def test_the_urdf_joint_turns_about_fixed_axes_roll_pitch_yaw() -> None:
    found = some_mount()
    text = urdf_joint(found.transform)
    roll, pitch, yaw = map(float, text.split('rpy="')[1].split('"')[0].split())

    def about(axis: int, angle: float) -> np.ndarray:
        return exponential(angle * np.eye(3)[axis : axis + 1])[0]

    assert np.allclose(about(2, yaw) @ about(1, pitch) @ about(0, roll), found.transform.rotation)


def test_the_mount_comes_back_from_its_entry_both_ways() -> None:
    found = some_mount()
    entry = json.loads(json.dumps(mount_entry(found)))
    back = read_mount(entry)
    assert np.array_equal(back.rotation, found.transform.rotation)
    assert np.array_equal(back.translation, found.transform.translation)
    assert np.allclose(np.array(entry[BACK]) @ matrix(found.transform), np.eye(4), atol=1e-12)
    assert entry["not_known"] == ["height"]


@pytest.mark.parametrize("spoil", ["scale", "flip", "nan", "shape", "missing"])
def test_a_mount_that_is_no_rigid_transform_is_refused(spoil: str) -> None:
    entry = mount_entry(some_mount())
    whole = np.array(entry[FORWARD])
    if spoil == "scale":
        whole[:3, :3] *= 1.01
    elif spoil == "flip":
        whole[:3, 0] *= -1
    elif spoil == "nan":
        whole[0, 3] = np.nan
    elif spoil == "shape":
        whole = whole[:3]
    with pytest.raises(BadInput):
        read_mount({} if spoil == "missing" else entry | {FORWARD: whole.tolist()})


def test_keys_that_are_numbers_or_dates_are_passed_over() -> None:
    text = "7: a\n2026-01-01: b\nimage_size: [640, 480]\nK: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\n"
    assert parse_camera(text).fx == 500.0
    with pytest.raises(BadInput, match="no camera"):
        parse_camera("7: a\n")
