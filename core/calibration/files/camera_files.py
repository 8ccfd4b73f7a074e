"""A camera in files: ROS camera_info, OpenCV, Kalibr and our own JSON, written to the letter and read with care."""

import json
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypedDict

import cv2
import numpy as np

from core.calibration.files.yaml_reading import read_yaml
from core.errors import BadInput
from core.files import text_of
from core.message import Array
from core.optics import CameraModel
from core.sensors.checks import UnusableReading, fault, faults_of, refusal

MOST_BYTES = 2**20
PLUMB_BOB = ("plumb_bob", "radtan", "radial-tangential", "opencv", "opencv4", "opencv5", "brown_conrady", "none")
RATIONAL = ("rational_polynomial", "rational", "opencv8", "opencv12")  # with zeros from k4 on it is plumb_bob
PINHOLE = ("pinhole", "")
INVERSE = "inverse_brown_conrady"  # of RealSense; with zeros it is plumb_bob
MODEL_NAMES = (
    "camera_model",
    "camera_type",
    "distortion_model",
    "model_type",
    "lensmodel",
    "Camera.type",
    "projection",
    "model",
    "lens_model",
)
OTHER_MODEL = re.compile(r"fish|equi|kannala|brandt|omni|ocam|mei|eucm|sphere|theta|unified|inverse", re.IGNORECASE)
DISTORTION_KEY = re.compile(r"(?!.*model)(dist(?!a)|.*distor|.*coef)", re.IGNORECASE)  # other names of these numbers
MATRIX_KEYS = ("camera_matrix", "Camera_Matrix", "K", "k", "cameraIntrinsics", "cameraMatrix")
DISTORTION_LIST_KEYS = (
    "distortion_coefficients",
    "Distortion_Coefficients",
    "D",
    "d",
    "dist",
    "distCoeffs",
    "cameraExtrinsics",  # PhotonVision's name for them in older files
    "distortion_coeffs",
    "dist_coeffs",
    "coeffs",
    "distortion",
)
WIDTH_HEIGHT_KEYS = (
    ("image_width", "image_height"),
    ("width", "height"),
    ("img_width", "img_height"),
    ("image_Width", "image_Height"),  # with Camera_Matrix, as OpenCV's sample wrote it up to 2.4
)
SIZE_KEYS = ("image_size", "resolution", "img_size", "imageSize")
MIN_SHRINK_RATIO = 1.45  # the picture's middle over the principal point, from which a picture was shrunk …
MAX_ASPECT_RATIO = 1.45  # … by binning, where it is alike across and down, but for 4:3 and 16:9
MIN_SWAPPED_SHARE = 0.1  # of a side from the middle of which the principal point lies where the sides are exchanged …
MAX_RIGHT_SHARE = 0.06  # … and of the other side, then
MAX_SKEW_PX = 1e-3  # in a matrix that some programs print with the rest of a division
CAMERA_NAME = "camera"


class CameraEntry(TypedDict):
    """The camera as it stands in our own JSON."""

    name: str
    image_size: list[int]  # width, height
    K: list[list[float]]
    dist_model: str
    dist: list[float]


def ros_yaml(model: CameraModel) -> str:
    """ROS camera_info; P as ROS's own calibrator fills it, all pixels valid."""
    projection = np.zeros((3, 4))
    size = (model.width, model.height)
    projection[:, :3] = cv2.getOptimalNewCameraMatrix(model.matrix, model.distortion, size, 0)[0]
    parts = [
        f"image_width: {model.width}\nimage_height: {model.height}\ncamera_name: {CAMERA_NAME}",
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


def kalibr_yaml(model: CameraModel) -> str:
    """Kalibr's camchain. Its radtan model has exactly four coefficients: raises BadInput for a camera with k3."""
    if model.k3 != 0:
        raise BadInput("Kalibr's radtan model has no k3; calibrate without k3 to export to Kalibr.")
    intrinsics = _list((model.fx, model.fy, model.cx, model.cy))
    return (
        f"cam0:\n  camera_model: pinhole\n  intrinsics: {intrinsics}\n  distortion_model: radtan\n"
        f"  distortion_coeffs: {_list(model.distortion[:4])}\n  resolution: [{model.width}, {model.height}]\n"
        "  rostopic: /camera/image_raw\n"
    )


def camera_entry(model: CameraModel) -> CameraEntry:
    """The camera as it stands in our own JSON."""
    return {
        "name": CAMERA_NAME,
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
    text = text_of(path.read_bytes(), path.name)
    try:
        return parse_camera(text)
    except BadInput as wrong:
        faults = faults_of(wrong, path.name) or (fault("camera.malformed", path.name, what=str(wrong).rstrip(".")),)
        raise UnusableReading(f"{path.name}: {wrong}", faults) from None


def parse_camera(text: str) -> CameraModel:
    """The text of a camera file → the camera. Raises BadInput.

    Read are ROS camera_info (also from `topic echo`), OpenCV in YAML and XML, Kalibr, PhotonVision and our own.
    """
    begins = text.lstrip("\ufeff \t\r\n")
    if begins.startswith("#") and "ocam_model" in text:
        raise _other_model("ocam_model (Scaramuzza's OCamCalib)")
    if begins.startswith("<"):
        document = _read_xml(begins)
    else:
        document = read_json(begins) if begins.startswith("{") else read_yaml(_first_document(text))
    if len(several := sorted(name for name in _names(document) if re.fullmatch(r"cam\d+", name))) > 1:
        raise BadInput(
            f"It holds {len(several)} cameras ({', '.join(several[:4])}); leave only the one that is meant"
        )
    for wrapping in ("camera", *several):
        if isinstance(document.get(wrapping), dict):
            document = document[wrapping]
    if "fx" in document:  # the output of `calibrate camera --json`
        fx, fy = document["fx"], document.get("fy")
        cx, cy = (document.get(name, document.get(f"pp{name[1]}")) for name in ("cx", "cy"))  # RealSense's names
        terms: Any = [document.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")]
        terms = terms if "k1" in document else _distortion(document)
        return _model(_size(document), [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]], terms, _kind(document))
    if not any(name in document for name in (*MATRIX_KEYS, "intrinsics")):
        named = _named_model(document)
        if named:
            raise _other_model(named)
        raise BadInput("It holds no camera: expected ROS camera_info, OpenCV, Kalibr or Beckon's own JSON.")
    matrix = _first(document, MATRIX_KEYS) or _kalibr_matrix(document)
    return _model(_size(document), matrix, _distortion(document), _kind(document))


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
    return re.sub(r"^([-+]?\d+)e", r"\1.0e", repr(float(value)))


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


def _first_document(text: str) -> str:
    """The first of several YAML documents: `topic echo` ends each with a line of three dashes."""
    lines = text.splitlines(keepends=True)
    ends = [number for number, line in enumerate(lines) if line.rstrip() in ("---", "...")]
    begun = next((number for number, line in enumerate(lines) if line.strip() and line[0] not in "%#-"), len(lines))
    return "".join(lines[: next((number for number in ends if number > begun), len(lines))])


def _read_xml(text: str) -> dict[str, Any]:
    """OpenCV's FileStorage as XML → its top mapping. Raises BadInput."""
    if "<!" in text.replace("<!--", ""):
        raise BadInput("its XML declares entities; OpenCV's camera files hold none")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as wrong:
        raise BadInput(f"it is not valid XML (line {wrong.position[0]})") from None
    return {node.tag: _xml_value(node) for node in root}


def _xml_value(node: ElementTree.Element) -> Any:
    if len(node):
        return {child.tag: _xml_value(child) for child in node}
    words = (node.text or "").split()
    try:
        numbers: list[Any] = [json.loads(re.sub(r"\.(?=$|[eE])", ".0", word)) for word in words]  # OpenCV's "520."
    except ValueError:
        return " ".join(words)
    return numbers[0] if len(numbers) == 1 and node.tag != "data" else numbers


def _first(document: dict[str, Any], names: Sequence[str]) -> Any:
    """The first entry that is there. A matrix is a list, or a mapping of rows, cols and data. Raises BadInput."""
    name = next((each for each in names if document.get(each) is not None), "")
    entry = document.get(name)
    if not isinstance(entry, dict):
        return entry
    data, rows, columns = entry.get("data"), entry.get("rows"), entry.get("cols")
    if isinstance(data, list) and isinstance(rows, int) and isinstance(columns, int) and rows * columns != len(data):
        raise BadInput(
            f"{name} announces {rows} x {columns} numbers and holds {len(data)}; which are meant is unclear"
        )
    return data


def _kalibr_matrix(document: dict[str, Any]) -> Any:
    """Kalibr's four intrinsics as a matrix; None where there are none."""
    if "intrinsics" not in document:
        return None
    _kind(document)  # other projections have more numbers
    fx, fy, cx, cy = _numbers(document["intrinsics"], "intrinsics", (4,))
    return [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]


def _names(document: dict[Any, Any]) -> list[str]:
    """The keys of a document that are texts: YAML has numbers and dates for keys, too."""
    return [name for name in document if isinstance(name, str)]


def _distortion(document: dict[str, Any]) -> Any:
    """The distortion's numbers; None where nothing in the file speaks of any. Raises BadInput."""
    terms, kind = _first(document, DISTORTION_LIST_KEYS), _kind(document)
    if terms is None and (kind not in ("", "none") or any(map(DISTORTION_KEY.match, _names(document)))):
        raise BadInput(f"It holds no list {DISTORTION_LIST_KEYS[0]}; write zeros there if the lens has no distortion")
    return terms


def _size(document: dict[str, Any]) -> Any:
    for width, height in WIDTH_HEIGHT_KEYS:
        if width in document or height in document:
            return [document.get(width), document.get(height)]
    entry = next((document[name] for name in SIZE_KEYS if document.get(name) is not None), None)
    return [entry.get("width"), entry.get("height")] if isinstance(entry, dict) else entry


def _kind(document: dict[str, Any]) -> str:
    """The distortion's model as the file names it, "" where it does not. Raises BadInput for another projection."""
    if "fisheye_model" in document:
        return "fisheye" if document["fisheye_model"] else "plumb_bob"
    camera = _lower(document.get("camera_model", document.get("lensmodel")))
    named = _lower(document.get("distortion_model", document.get("dist_model")))
    if camera not in (*PINHOLE, *PLUMB_BOB, *RATIONAL):
        raise _other_model(camera)  # Kalibr names the projection too: omni, ds, eucm
    if named or camera not in PINHOLE:
        return named or camera
    others = (_lower(document.get(name)) for name in MODEL_NAMES)
    return next((one for one in others if OTHER_MODEL.search(one)), "")


def _lower(entry: Any) -> str:
    return str(entry or "").strip().lower().removeprefix("lensmodel_").removeprefix("distortion.")


def _named_model(document: Any) -> str:
    """The camera model that a file of another form names, or ''."""
    if isinstance(document, list):
        return next(filter(None, (_named_model(each) for each in document)), "")
    if not isinstance(document, dict):
        return ""
    for name, entry in document.items():
        if name in MODEL_NAMES and isinstance(entry, str) and _lower(entry) not in (*PLUMB_BOB, *PINHOLE):
            return entry[:30]
        if isinstance(entry, dict | list) and (found := _named_model(entry)):
            return found
    return ""


def _other_model(named: str) -> BadInput:
    return refusal("camera.other_model", model=named[:40])


def _model(size: Any, matrix: Any, distortion: Any, kind: str) -> CameraModel:
    width, height = _numbers(size, "image size", (2,))
    if width != int(width) or height != int(height) or not (16 <= width <= 20000 and 16 <= height <= 20000):
        raise BadInput("the image size must be two whole numbers of pixels")
    fx, fy, cx, cy = _pinhole(matrix)
    k1, k2, p1, p2, k3 = (list(_terms(distortion, kind)[:5]) + [0.0] * 5)[:5]
    if not (fx > 0 and fy > 0 and 1 < cx < width and 1 < cy < height):
        raise BadInput("focal lengths must be positive and the principal point must lie in the picture, in pixels")

    def off(wide: float, high: float) -> float:
        return max(abs(cx / wide - 0.5), abs(cy / high - 0.5))

    if off(width, height) > MIN_SWAPPED_SHARE and off(height, width) < MAX_RIGHT_SHARE:
        raise refusal("camera.swapped_size", width=int(width), height=int(height), seen=f"({cx:.0f}, {cy:.0f})")
    smaller = (width / (2 * cx), height / (2 * cy))
    if min(smaller) > MIN_SHRINK_RATIO and max(smaller) < MAX_ASPECT_RATIO * min(smaller):
        times = f"{sum(smaller) / 2:.1f}"
        raise refusal("camera.binned", width=int(width), height=int(height), times=times)
    model = CameraModel(
        width=int(width), height=int(height), fx=fx, fy=fy, cx=cx, cy=cy, k1=k1, k2=k2, p1=p1, p2=p2, k3=k3
    )
    check_lens(model)
    return model


def _pinhole(matrix: Any) -> tuple[float, float, float, float]:
    camera = np.array(_numbers(matrix, "camera matrix", (9,))).reshape(3, 3)
    if not camera.any():
        raise BadInput("the camera matrix is all zeros: the camera was not calibrated when the file was written")
    camera /= camera[2, 2] or 1.0
    if not np.array_equal(camera[2], [0, 0, 1]) or np.abs(camera[[1, 0], [0, 1]]).max() > MAX_SKEW_PX:
        raise BadInput("the camera matrix must read [fx 0 cx; 0 fy cy; 0 0 1]")
    return float(camera[0, 0]), float(camera[1, 1]), float(camera[0, 2]), float(camera[1, 2])


def _terms(distortion: Any, kind: str) -> list[float]:
    """The distortion's numbers, if they are plumb_bob's or the same lens under another name. Raises BadInput."""
    if kind not in (*PLUMB_BOB, *RATIONAL, INVERSE, ""):
        raise _other_model(kind)
    terms = _numbers(distortion, "distortion", (0, 4, 5, 8, 12, 14)) if distortion is not None else []
    if kind == INVERSE and any(terms):
        raise _other_model(kind)
    if not kind and len(terms) == 4 and any(terms):
        raise refusal("camera.unnamed_model")
    if any(terms[5:]):
        raise refusal("camera.rational")
    return terms


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


MIN_VIEW, MAX_VIEW = np.radians(2.0), np.radians(160.0)  # field of view across and down; the longest zooms have 2°
MAX_ASPECT = 3.0  # between the focal lengths across and down
MAX_COEFFICIENT = 1e9
MAX_STRETCH = 1.6  # by the distortion, of the way from the picture's middle
MAX_ASIDE = 0.06  # of the picture's longer side, by which p1 and p2 move a point
MAX_ERROR_PX = 1.0  # there and back
MAX_UNREACHED = 0.1  # share of the picture, in its corners, that no ray may reach
BEYOND_LENSES = (
    "A distortion coefficient is far beyond that of any lens; check k1, k2, p1, p2 and k3, which stand in this order."
)
GRID_POINTS = 33  # points across and down, the rim included


def check_lens(model: CameraModel) -> None:
    """Raise BadInput for a camera whose distortion cannot be inverted over its picture or that no lens has."""
    if not 1 / MAX_ASPECT <= model.fx / model.fy <= MAX_ASPECT:
        raise BadInput(f"The focal lengths fx and fy differ by more than a factor of {MAX_ASPECT:g}; check both.")
    if np.abs(model.distortion).max() > MAX_COEFFICIENT:
        raise BadInput(BEYOND_LENSES)
    u, v = np.linspace(0, model.width, GRID_POINTS), np.linspace(0, model.height, GRID_POINTS)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    with np.errstate(all="ignore"):
        rays = model.unproject(pixels)
        back = model.distort(rays) * (model.fx, model.fy) + (model.cx, model.cy)
        reached = (np.abs(back - pixels).max(axis=1) < MAX_ERROR_PX).reshape(GRID_POINTS, GRID_POINTS)
    lost = 1.0 - float(reached.mean())
    middle = slice(GRID_POINTS // 4, -(GRID_POINTS // 4))
    if lost > MAX_UNREACHED or not reached[middle, middle].all():
        share = f"{100 * lost:.0f} % of the picture"
        raise BadInput(f"The camera's distortion cannot be inverted in {share}; calibrate the camera again.")
    angles = np.arctan(np.where(reached[..., None], rays.reshape(GRID_POINTS, GRID_POINTS, 2), np.nan))
    for name, angle, wide in (
        ("across", angles[GRID_POINTS // 2, :, 0], model.width / model.fx),
        ("down", angles[:, GRID_POINTS // 2, 1], model.height / model.fy),
    ):
        view = max(float(np.nanmax(angle) - np.nanmin(angle)), 2 * float(np.arctan(wide / 2)))
        if not MIN_VIEW <= view <= MAX_VIEW:
            low, high = np.degrees((MIN_VIEW, MAX_VIEW))
            raise BadInput(
                f"The camera's field of view {name} is {np.degrees(view):.3g} degrees; this model holds for "
                f"{low:g} to {high:g}. Check fx, fy and the distortion, or calibrate the camera again."
            )
    x, y = rays[reached.ravel()].T
    square = x * x + y * y
    aside = np.hypot(
        model.fx * (2 * model.p1 * x * y + model.p2 * (square + 2 * x * x)),
        model.fy * (2 * model.p2 * x * y + model.p1 * (square + 2 * y * y)),
    )
    stretch = 1 + square * (model.k1 + square * (model.k2 + square * model.k3))
    if aside.max() > MAX_ASIDE * max(model.width, model.height) or stretch.max() > MAX_STRETCH:
        raise BadInput(BEYOND_LENSES)
