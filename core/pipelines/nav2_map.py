"""The occupancy map as Nav2's map server reads it: a YAML text and a picture; written, and read in three modes."""

import io
import math
import struct
import zipfile
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np

from core.calibration.files.pgm import HeadMismatch, in_8_bits, pgm_size, read_pgm
from core.calibration.files.yaml_reading import read_yaml
from core.errors import BadInput
from core.files import text_of
from core.message import Array
from core.sentences import Statement
from core.slam.map.occupancy import OccupancyGrid

Nav2Mode = Literal["trinary", "scale", "raw"]

OCCUPIED_PIXEL, FREE_PIXEL, UNKNOWN_PIXEL = 0, 254, 205
OCCUPIED_VALUE, FREE_VALUE, UNKNOWN_VALUE = 100, 0, -1  # of nav_msgs/OccupancyGrid

OCCUPIED_ABOVE = 0.65  # probability from which a cell is drawn occupied
FREE_BELOW = 0.35  # probability up to which a cell is drawn free: one passing beam alone does not clear it

# Nav2 turns pixels into (255 - pixel) / 255, so unknown is 0.19608: with the often copied 0.25 it would load as free.
THRESHOLDS = "occupied_thresh: 0.65\nfree_thresh: 0.196\n"

MAX_PIXELS = 25_000_000
MAX_YAML_BYTES = 65_536
MAX_PICTURE_BYTES = 200_000_000  # unpacked
FAR_M = 100_000.0
MIN_CELL_M, MAX_CELL_M = 0.001, 1.0
TRUE_WORDS, FALSE_WORDS = ("1", "true", "yes", "y", "on"), ("0", "false", "no", "n", "off")  # as Nav2 reads them
MAC_SIDE_FILE = "._"  # how the names of files begin that macOS puts beside others in a zip
PICTURE_ENDINGS = (".pgm", ".png", ".bmp")
PNG_HEAD, BMP_HEAD = b"\x89PNG\r\n\x1a\n", b"BM"
SURE_LOG_ODDS = 4.0  # of a cell that a map says to be occupied or free
EVEN_LOG_ODDS = 0.01  # of a cell of 50 %: it is known, and neither


@dataclass(frozen=True, eq=False)
class Nav2Cells:
    """A map or a mask as Nav2's map server has it after loading."""

    values: Array  # (rows, columns) int8: 0 to 100, -1 unknown; row 0 lies at the lowest y
    resolution: float  # [m]
    origin: tuple[float, float, float]  # x, y [m] of the outer corner of the first cell, and its turn [rad]
    mode: Nav2Mode = "trinary"
    remark: str = ""  # a sentence on what may be meant otherwise


def map_pixels(grid: OccupancyGrid) -> Array:
    """Grid → picture (rows, columns) uint8, row 0 at the top, that is at the highest y."""
    pixels = np.full(grid.log_odds.shape, UNKNOWN_PIXEL, np.uint8)
    pixels[grid.log_odds >= _log_odds(OCCUPIED_ABOVE)] = OCCUPIED_PIXEL
    pixels[grid.log_odds <= _log_odds(FREE_BELOW)] = FREE_PIXEL
    return pixels[::-1]


def nav2_map(grid: OccupancyGrid) -> tuple[str, bytes]:
    """Grid → (YAML text that names the picture map.pgm, the picture as binary PGM).

    Layout of Nav2's map_io: mode trinary, origin of the lower left corner as [x, y, yaw] in metres and radians.
    """
    return map_yaml(grid, "map.pgm", "trinary"), pgm(map_pixels(grid))


def map_yaml(grid: OccupancyGrid, image: str, mode: Nav2Mode) -> str:
    """The YAML of a picture that has a cell for each of the grid's."""
    x, y = (float(v) for v in grid.origin)
    return (
        f"image: {image}\nmode: {mode}\nresolution: {grid.resolution:.9f}\n"
        f"origin: [{x:.9f}, {y:.9f}, 0.0]\nnegate: 0\n{THRESHOLDS}"
    )


def pgm(pixels: Array) -> bytes:
    """Picture (rows, columns) uint8 → binary PGM."""
    rows, columns = pixels.shape
    return f"P5\n{columns} {rows}\n255\n".encode() + pixels.tobytes()


# read


def read_nav2_zip(packed: bytes) -> Nav2Cells:
    """Read a zip that holds one YAML and the picture that it names. Raises BadInput."""
    try:
        with zipfile.ZipFile(io.BytesIO(packed)) as box:
            files = ((one.filename.rsplit("/", 1)[-1], one) for one in box.infolist() if not one.is_dir())
            members = {name: one for name, one in files if not name.startswith(MAC_SIDE_FILE)}
            texts = [name for name in members if name.lower().endswith((".yaml", ".yml"))]
            pictures = [name for name in members if name.lower().endswith(PICTURE_ENDINGS)]
            if len(texts) != 1 or not pictures:
                raise BadInput(Statement("nav2.zip"))
            text = _member(box, members[texts[0]], MAX_YAML_BYTES)
            named = str(_settings(text).get("image", "")).replace("\\", "/").rsplit("/", 1)[-1]
            if named not in members and len(pictures) > 1:
                raise BadInput(Statement("nav2.zip"))
            picture = _member(box, members.get(named, members[pictures[0]]), MAX_PICTURE_BYTES)
    except (
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        NotImplementedError,
        RuntimeError,
        EOFError,
        OSError,
        ValueError,
    ):
        raise BadInput(Statement("nav2.zip")) from None
    return read_nav2_map(text, picture)


def read_nav2_map(text: bytes, picture: bytes) -> Nav2Cells:
    """YAML and picture → the cells, by the rules of Nav2's map_io. Raises BadInput with what is wrong.

    Shade s of a pixel: the mean of its channels (in trinary also of its opacity); occupancy p = 1 - s, with `negate`
    p = s. Trinary: occupied for p ≥ occupied_thresh, free for p ≤ free_thresh. Scale: in between 0 to 100, and what
    is not opaque is unknown. Raw: the pixel itself where it is at most 100; `negate` and thresholds do not count.
    """
    settings = _settings(text)
    mode: Any = settings.get("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        raise BadInput(Statement("nav2.bad_key", key="mode", value=mode))
    resolution = _number(settings, "resolution", 0.0, FAR_M)
    if not MIN_CELL_M <= resolution <= MAX_CELL_M:
        raise BadInput(Statement("nav2.cell_size", metres=f"{resolution:g}"))
    free, occupied = (_number(settings, key, 0.0, 1.0) for key in ("free_thresh", "occupied_thresh"))
    if free >= occupied:
        raise BadInput(Statement("nav2.thresholds", free=f"{free:g}", occupied=f"{occupied:g}"))
    negate = str(settings.get("negate", 0)).lower()
    if negate not in TRUE_WORDS + FALSE_WORDS:
        raise BadInput(Statement("nav2.bad_key", key="negate", value=settings["negate"]))
    pixels = _pixels(picture)
    shade, opaque = _shades(pixels, mode)
    p = shade if negate in TRUE_WORDS else 1.0 - shade
    values = np.full(shade.shape, UNKNOWN_VALUE, np.int8)
    if mode == "raw":
        level = np.rint(shade * 255)
        values[level <= OCCUPIED_VALUE] = level[level <= OCCUPIED_VALUE]
    else:
        if mode == "scale":
            values[:] = np.rint(np.clip((p - free) / (occupied - free), 0.0, 1.0) * OCCUPIED_VALUE)
        values[p >= occupied] = OCCUPIED_VALUE
        values[p <= free] = FREE_VALUE
        if mode == "scale":
            values[~opaque] = UNKNOWN_VALUE
    remark = ""
    if mode == "trinary":
        grey = (pixels[..., : 1 if pixels.shape[2] < 3 else 3] == UNKNOWN_PIXEL).all(axis=2)
        if (floor := grey & (values == FREE_VALUE)).any():
            kept = math.floor(1000 * float(p[floor].min())) / 1000
            remark = Statement(
                "nav2.grey_is_floor", count=np.count_nonzero(floor), free=f"{free:g}", kept=f"{kept:g}"
            )
    return Nav2Cells(np.ascontiguousarray(values[::-1]), resolution, _origin(settings), mode, remark)


def laid_out(cells: Nav2Cells, resolution: float) -> OccupancyGrid:
    """The cells on the lattice of a map of this resolution [m], whose axes are those of Nav2's frame.

    Each takes the nearest cell: nothing is blended, so a thin wall stays, and occupied ones always leave a cell. With
    the same resolution and no turn every cell is kept, at most half a cell aside.
    """
    log_odds = _evidence(cells.values)
    rows, columns = log_odds.shape
    x, y, turn = cells.origin
    if math.isclose(cells.resolution, resolution, rel_tol=1e-6) and turn == 0.0:
        origin = np.rint(np.array([x, y]) / resolution) * resolution
        return OccupancyGrid(revision=1, resolution=resolution, origin=origin, log_odds=log_odds)
    c, s = math.cos(turn), math.sin(turn)
    onto = np.array([[c, -s], [s, c]])
    corners = np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]]) * cells.resolution @ onto.T + (x, y)
    low = np.floor(corners.min(axis=0) / resolution + 1e-9).astype(int)
    high = np.ceil(corners.max(axis=0) / resolution - 1e-9).astype(int)
    if float(np.prod((high - low).astype(float))) > MAX_PIXELS:
        raise BadInput(Statement("nav2.too_large", width=high[0] - low[0], height=high[1] - low[1], most=MAX_PIXELS))
    centres = (np.indices((high - low)[::-1])[::-1].reshape(2, -1).T + low + 0.5) * resolution
    source = np.floor((centres - (x, y)) @ onto / cells.resolution).astype(int)
    inside = ((source >= 0) & (source < (columns, rows))).all(axis=1)
    laid = np.zeros(len(centres), np.float32)
    laid[inside] = log_odds[source[inside, 1], source[inside, 0]]
    laid = laid.reshape((high - low)[::-1])
    walls = np.argwhere(log_odds >= _log_odds(OCCUPIED_ABOVE))
    places = (walls[:, ::-1] + 0.5) * cells.resolution @ onto.T + (x, y)
    column, row = (np.floor(places / resolution).astype(int) - low).T
    laid[row, column] = np.maximum(laid[row, column], log_odds[walls[:, 0], walls[:, 1]])
    return OccupancyGrid(revision=1, resolution=resolution, origin=low * resolution, log_odds=laid)


def _evidence(values: Array) -> Array:
    """Values → log odds float32; unknown 0."""
    p = np.clip(values.astype(float) / OCCUPIED_VALUE, 1e-6, 1 - 1e-6)
    odds = np.clip(np.log(p / (1 - p)), -SURE_LOG_ODDS, SURE_LOG_ODDS)
    odds[np.abs(odds) < EVEN_LOG_ODDS] = EVEN_LOG_ODDS
    return np.where(values == UNKNOWN_VALUE, 0.0, odds).astype(np.float32)


def _member(box: zipfile.ZipFile, member: zipfile.ZipInfo, most: int) -> bytes:
    with box.open(member) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise BadInput(Statement("nav2.zip"))
    return content


def _settings(text: bytes) -> dict[str, Any]:
    try:
        return read_yaml(text_of(text, "It"))
    except BadInput as wrong:
        raise BadInput(Statement("nav2.yaml", why=str(wrong))) from None


def _number(settings: dict[str, Any], key: str, low: float, high: float) -> float:
    if key not in settings:
        raise BadInput(Statement("nav2.no_key", key=key))
    value = settings[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise BadInput(Statement("nav2.bad_key", key=key, value=value))
    return float(value)


def _origin(settings: dict[str, Any]) -> tuple[float, float, float]:
    if "origin" not in settings:
        raise BadInput(Statement("nav2.no_key", key="origin"))
    origin = settings["origin"]
    sound = isinstance(origin, list) and len(origin) == 3
    if not sound or any(
        isinstance(one, bool) or not isinstance(one, int | float) or not abs(one) <= FAR_M for one in origin
    ):
        raise BadInput(Statement("nav2.bad_key", key="origin", value=origin))
    if abs(origin[2]) > math.tau:
        raise BadInput(Statement("nav2.turn", turn=f"{origin[2]:g}"))
    return float(origin[0]), float(origin[1]), float(origin[2])


def _pixels(picture: bytes) -> Array:
    """PGM, PNG or BMP → (rows, columns, channels) uint8; a fourth channel is the opacity. Raises BadInput."""
    size = pgm_size(picture)
    if size is not None:
        _check_size(*size[:2])
        try:
            return read_pgm(picture)[..., None]
        except HeadMismatch:
            raise BadInput(Statement("nav2.pgm_head", width=size[0], height=size[1], most=size[2])) from None
        except ValueError:
            raise BadInput(Statement("nav2.picture")) from None
    width, height = 0, 0
    if picture[:8] == PNG_HEAD and len(picture) >= 24:
        width, height = struct.unpack(">II", picture[16:24])
    elif picture[:2] == BMP_HEAD and len(picture) >= 26:
        width, height = map(abs, struct.unpack("<ii", picture[18:26]))
    _check_size(width, height)
    try:
        pixels = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None or pixels.shape[:2] != (height, width):
        raise BadInput(Statement("nav2.picture"))
    return in_8_bits(pixels, (255, 65535)).reshape(height, width, -1)


def _check_size(width: int, height: int) -> None:
    if width < 1 or height < 1:
        raise BadInput(Statement("nav2.picture"))
    if width * height > MAX_PIXELS:
        raise BadInput(Statement("nav2.too_large", width=width, height=height, most=MAX_PIXELS))


def _shades(pixels: Array, mode: Nav2Mode) -> tuple[Array, Array]:
    channels = pixels.shape[2]
    colours = pixels if channels in (1, 3) else pixels[..., :-1]
    opacity = np.full(pixels.shape[:2], 255, np.uint8) if channels in (1, 3) else pixels[..., -1]
    shade = colours.mean(axis=2, dtype=np.float64)
    if mode == "trinary" and channels in (2, 4):
        shade = (3.0 * shade + opacity) / 4.0
    return shade / 255.0, opacity == 255


def _log_odds(probability: float) -> float:
    return math.log(probability / (1 - probability))
