"""A camera in files: ROS camera_info, OpenCV, Kalibr and our own JSON, written to the letter and read with care."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypedDict

import cv2
import numpy as np

from core.calibration.files.yaml_reading import read_yaml
from core.calibration.lens_check import check_lens
from core.errors import BadInput
from core.message import Array
from core.optics import CameraModel

MOST_BYTES = 2**20
PLUMB_BOB = ("plumb_bob", "radtan", "opencv", "brown_conrady", "")


class CameraEntry(TypedDict):
    """The camera as it stands in our own JSON."""

    name: str
    image_size: list[int]  # width, height
    K: list[list[float]]
    dist_model: str
    dist: list[float]


def ros_yaml(model: CameraModel, name: str = "camera", *, crop: bool = True) -> str:
    """ROS camera_info. `crop`: P as ROS's own calibrator fills it, all pixels valid; else P is K."""
    projection = np.zeros((3, 4))
    size = (model.width, model.height)
    projection[:, :3] = (
        cv2.getOptimalNewCameraMatrix(model.matrix, model.distortion, size, 0)[0] if crop else model.matrix
    )
    parts = [
        f"image_width: {model.width}\nimage_height: {model.height}\ncamera_name: {plain_name(name)}",
        _ros_matrix("camera_matrix", model.matrix),
        "distortion_model: plumb_bob",
        _ros_matrix("distortion_coefficients", model.distortion[None]),
        _ros_matrix("rectification_matrix", np.eye(3)),
        _ros_matrix("projection_matrix", projection),
    ]
    return "\n".join(parts) + "\n"


def opencv_yaml(model: CameraModel, *, board: tuple[int, int, float] | None = None, rms: float | None = None) -> str:
    """OpenCV's FileStorage form, which both OpenCV 4 and 5 read. `board`: columns, rows, square [m]."""
    lines = ["%YAML:1.0", "---", f"image_width: {model.width}", f"image_height: {model.height}"]
    if board is not None:
        lines += [f"board_width: {board[0]}", f"board_height: {board[1]}", f"square_size: {number(board[2])}"]
    lines += _opencv_matrix("camera_matrix", model.matrix)
    lines += _opencv_matrix("distortion_coefficients", model.distortion[:, None])
    if rms is not None:
        lines.append(f"avg_reprojection_error: {number(rms)}")
    return "\n".join(lines) + "\n"


def kalibr_yaml(model: CameraModel, topic: str = "/camera/image_raw") -> str:
    """Kalibr's camchain. Its radtan model has exactly four coefficients: raises BadInput for a camera with k3."""
    if model.k3 != 0:
        raise BadInput("Kalibr's radtan model has no k3; calibrate without k3 to export to Kalibr.")
    intrinsics = _list((model.fx, model.fy, model.cx, model.cy))
    return (
        f"cam0:\n  camera_model: pinhole\n  intrinsics: {intrinsics}\n  distortion_model: radtan\n"
        f"  distortion_coeffs: {_list(model.distortion[:4])}\n  resolution: [{model.width}, {model.height}]\n"
        f"  rostopic: {topic}\n"
    )


def camera_entry(model: CameraModel, name: str = "camera") -> CameraEntry:
    """The camera as it stands in our own JSON."""
    return {
        "name": plain_name(name),
        "image_size": [model.width, model.height],
        "K": model.matrix.tolist(),
        "dist_model": "plumb_bob",
        "dist": model.distortion.tolist(),
    }


def read_camera(path: Path) -> CameraModel:
    """A camera file in any of the four forms → the camera. Raises BadInput with what is wrong with it."""
    if not path.is_file():
        raise BadInput(f"There is no camera file {path.name}.")
    if path.stat().st_size > MOST_BYTES:
        raise BadInput(f"{path.name} is larger than 1 MB; that is no camera file.")
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise BadInput(f"{path.name} is not a text file.") from None
    try:
        return parse_camera(text)
    except BadInput as wrong:
        raise BadInput(f"{path.name}: {wrong}") from None


def parse_camera(text: str) -> CameraModel:
    """The text of a camera file → the camera. Raises BadInput."""
    document = read_json(text) if text.lstrip().startswith("{") else read_yaml(text)
    if isinstance(document.get("camera"), dict):
        document = document["camera"]
    if isinstance(document.get("cam0"), dict):
        return _from_kalibr(document["cam0"])
    if "camera_matrix" in document:
        return _from_matrices(document)
    if "K" in document:
        return _model(document.get("image_size"), document["K"], document.get("dist"), document.get("dist_model"))
    if "fx" in document:
        return _from_names(document)
    raise BadInput("It holds no camera: expected ROS camera_info, OpenCV, Kalibr or Beckon's own JSON.")


def read_json(text: str) -> dict[str, Any]:
    """Text → JSON object; NaN and infinities are refused. Raises BadInput."""
    try:
        value = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as wrong:
        raise BadInput(f"it is not valid JSON ({str(wrong)[:80]})") from None
    if not isinstance(value, dict):
        raise BadInput("it is not a JSON object")
    return value


def number(value: float) -> str:
    """A number with all its digits and a decimal point: PyYAML reads '1e-5' as text."""
    text = repr(float(value))
    return re.sub(r"^([-+]?\d+)e", r"\1.0e", text)


def plain_name(name: str) -> str:
    """A name that needs no quoting in any of the forms."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "_", name).strip("_.-") or "camera"


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is not a number")


def _list(values: Sequence[float] | Array) -> str:
    return "[" + ", ".join(number(value) for value in values) + "]"


def _ros_matrix(name: str, matrix: Array) -> str:
    rows, columns = matrix.shape
    return f"{name}:\n  rows: {rows}\n  cols: {columns}\n  data: {_list(matrix.ravel())}"


def _opencv_matrix(name: str, matrix: Array) -> list[str]:
    rows, columns = matrix.shape
    data = ", ".join(number(value) for value in matrix.ravel())
    return [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {columns}", "   dt: d", f"   data: [ {data} ]"]


def _from_matrices(document: dict[str, Any]) -> CameraModel:
    """ROS camera_info and OpenCV's form share their names."""
    size = [document.get("image_width"), document.get("image_height")]
    kind = document.get("distortion_model", document.get("camera_model", ""))
    distortion = document.get("distortion_coefficients")
    return _model(size, _matrix(document["camera_matrix"]), None if distortion is None else _matrix(distortion), kind)


def _from_kalibr(camera: dict[str, Any]) -> CameraModel:
    if camera.get("camera_model") != "pinhole":
        raise BadInput("Only Kalibr's pinhole cameras are read.")
    numbers = _numbers(camera.get("intrinsics"), "intrinsics", (4,))
    matrix = [[numbers[0], 0, numbers[2]], [0, numbers[1], numbers[3]], [0, 0, 1]]
    return _model(camera.get("resolution"), matrix, camera.get("distortion_coeffs"), camera.get("distortion_model"))


def _from_names(document: dict[str, Any]) -> CameraModel:
    """Read the output of `calibrate camera --json`."""
    fx, fy, cx, cy = (document.get(name) for name in ("fx", "fy", "cx", "cy"))
    coefficients = [document.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3")]
    return _model(document.get("image_size"), [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]], coefficients, "")


def _model(size: Any, matrix: Any, distortion: Any, kind: Any) -> CameraModel:
    """Check and assemble."""
    width, height = _numbers(size, "image size", (2,))
    if width != int(width) or height != int(height) or not (16 <= width <= 20000 and 16 <= height <= 20000):
        raise BadInput("the image size must be two whole numbers of pixels")
    camera = np.array(_numbers(matrix, "camera matrix", (9,))).reshape(3, 3)
    if not np.array_equal(camera[2], [0, 0, 1]) or camera[1, 0] != 0 or camera[0, 1] != 0:
        raise BadInput("the camera matrix must read [fx 0 cx; 0 fy cy; 0 0 1]")
    if str(kind or "").lower() not in PLUMB_BOB:
        raise BadInput(f"the distortion model '{str(kind)[:30]}' is not read; plumb_bob (k1 k2 p1 p2 k3) is")
    terms = _numbers(distortion, "distortion", (0, 4, 5, 8, 12, 14)) if distortion is not None else []
    if any(terms[5:]):
        raise BadInput("distortion beyond k1 k2 p1 p2 k3 is not read")
    k1, k2, p1, p2, k3 = (list(terms[:5]) + [0.0] * 5)[:5]
    fx, fy, cx, cy = (float(camera[place]) for place in ((0, 0), (1, 1), (0, 2), (1, 2)))
    if not (fx > 0 and fy > 0 and 0 < cx < width and 0 < cy < height):
        raise BadInput("focal lengths must be positive and the principal point must lie in the picture")
    model = CameraModel(
        width=int(width), height=int(height), fx=fx, fy=fy, cx=cx, cy=cy, k1=k1, k2=k2, p1=p1, p2=p2, k3=k3
    )
    check_lens(model)
    return model


def _matrix(entry: Any) -> Any:
    """ROS's and OpenCV's matrices are mappings with `data`."""
    return entry.get("data") if isinstance(entry, dict) else entry


def _numbers(entry: Any, what: str, counts: tuple[int, ...]) -> list[float]:
    """A list, perhaps of lists, of finite numbers of one of the right lengths."""
    if entry is None:
        raise BadInput(f"it does not say the {what}")
    flat: list[Any] = []
    for item in entry if isinstance(entry, list) else [entry]:
        flat.extend(item if isinstance(item, list) else [item])
    if any(isinstance(item, bool) or not isinstance(item, int | float) for item in flat):
        raise BadInput(f"the {what} holds something that is not a number")
    if not all(np.isfinite(item) for item in flat):
        raise BadInput(f"the {what} holds NaN or infinity")
    if len(flat) not in counts:
        raise BadInput(f"the {what} has {len(flat)} numbers; expected {' or '.join(map(str, counts))}")
    return [float(item) for item in flat]
