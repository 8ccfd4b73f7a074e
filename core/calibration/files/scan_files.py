"""Laser scans in files: PCD (ascii and binary) and CSV of angle and range, or of x and y."""

import codecs
import csv
import math
import re
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import wrap_all
from core.message import Array
from core.sensors.checks import refusal

MOST_BYTES = 32 * 2**20
MOST_POINTS = 2_000_000
SAME_BEAM_ANGLE_RAD = 1e-4  # bearings closer than this belong to the same beam
UNITS = {"rad": 1.0, "deg": math.pi / 180, "degrees": math.pi / 180, "m": 1.0, "cm": 0.01, "mm": 1e-3, "inch": 0.0254}
MAX_VIEW_RAD = 2 * math.pi + 0.1  # from the first to the last beam
KINDS = {"F4": "<f4", "F8": "<f8", "I1": "<i1", "I2": "<i2", "I4": "<i4", "U1": "<u1", "U2": "<u2", "U4": "<u4"}


def read_scans(path: Path) -> tuple[Array, Array]:
    """A file of one or more scans of a still scene → bearings (B,) [rad], rising, and ranges (K, B) [m], NaN = none.

    A new scan begins where the bearing jumps back, or where a `scan` column changes. Raises BadInput.
    """
    if path.stat().st_size > MOST_BYTES:
        raise BadInput(f"{path.name} is larger than {MOST_BYTES // 2**20} MB; that is no scan.")
    scans = _read_pcd(path) if path.suffix.lower() == ".pcd" else _read_csv(path)
    scans = [scan[np.all(np.isfinite(scan), axis=1) & (scan[:, 1] > 0)] for scan in scans]
    scans = [scan for scan in scans if len(scan) >= 3]
    if not scans:
        raise BadInput(f"{path.name} holds no scan: at least 3 measured beams are needed.")
    return _on_common_beams(scans)


def polar(points: Array) -> Array:
    """Points (N, 2) [m] → bearing [rad] and range [m] (N, 2)."""
    return np.column_stack((np.arctan2(points[:, 1], points[:, 0]), np.hypot(points[:, 0], points[:, 1])))


def _on_common_beams(scans: list[Array]) -> tuple[Array, Array]:
    """Scans of (bearing, range) → all bearings that occur, and every scan on them."""
    every = np.sort(np.concatenate([scan[:, 0] for scan in scans]))
    bearings = every[np.concatenate(([True], np.diff(every) > SAME_BEAM_ANGLE_RAD))]
    ranges = np.full((len(scans), len(bearings)), np.nan)
    for row, scan in enumerate(scans):
        place = np.clip(np.searchsorted(bearings, scan[:, 0] + SAME_BEAM_ANGLE_RAD) - 1, 0, len(bearings) - 1)
        ranges[row, place] = scan[:, 1]
    return bearings, ranges


def _read_csv(path: Path) -> list[Array]:
    rows = _rows(path.read_bytes())
    if len(rows) > MOST_POINTS:
        raise BadInput(f"{path.name} has more than {MOST_POINTS} lines; that is no scan.")
    columns = [] if not rows or number_in(rows[0][0]) is not None else [_column(name) for name in rows.pop(0)]
    columns = columns or [("angle", 1.0), ("range", 1.0)]
    names = [name for name, _ in columns]
    table = np.array(
        [[number_in(cell) for cell in row[: len(names)]] for row in rows if len(row) >= len(names)], float
    )
    if not len(table):
        raise BadInput(f"{path.name} holds no numbers; columns angle [rad] and range [m], or x and y [m], are read.")
    table = table * [unit for _, unit in columns]
    if {"angle", "range"} <= set(names):
        points = table[:, [names.index("angle"), names.index("range")]]
        around = wrap_all(points[:, 0])  # 0 to 2π as well as -π to π
        breaks = np.flatnonzero((np.diff(points[:, 0]) < -0.1) & (np.diff(around) < -0.1)) + 1
        angles = points[np.isfinite(points[:, 0]), 0]
        if len(angles) and np.ptp(angles) > MAX_VIEW_RAD:
            first, last = f"{angles.min():.4g}", f"{angles.max():.4g}"
            raise refusal("laser.degrees", path.name, first=first, last=last)
        points[:, 0] = around
    elif {"x", "y"} <= set(names):
        points, breaks = polar(table[:, [names.index("x"), names.index("y")]]), np.empty(0, int)
    else:
        raise BadInput(f"{path.name} needs columns angle [rad] and range [m], or x and y [m].")
    if "scan" in names:
        breaks = np.flatnonzero(np.diff(table[:, names.index("scan")]) != 0) + 1
    return np.split(points, breaks)


def _rows(content: bytes) -> list[list[str]]:
    """The cells of a table, whatever stands between them: commas, semicolons, tabs or blanks; without comments.

    Beside semicolons and tabs a comma is that of a decimal fraction, as spreadsheets of many countries write it.
    """
    encoding = "utf-16" if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else "utf-8-sig"
    lines = [line.strip() for line in content.decode(encoding, "replace").splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    between = next((sign for sign in ";\t," if lines and sign in lines[0]), " ")
    if between in ";\t":
        lines = [line.replace(",", ".") for line in lines]
    return list(csv.reader(lines, delimiter=between, skipinitialspace=True))


def _column(name: str) -> tuple[str, float]:
    """A column's heading → its name and its unit [rad, m]: 'range_mm', 'Range [mm]' → 'range', 0.001."""
    words = [word for word in re.split(r"[\s_\[\]()]+", name.strip().lower()) if word]
    unit = UNITS.get(words[-1], 0.0) if len(words) > 1 else 0.0
    word = "_".join(words[:-1] if unit else words)
    names = {"theta": "angle", "bearing": "angle", "azimuth": "angle", "r": "range", "distance": "range"}
    return names.get(word, word), unit or 1.0


def number_in(text: str) -> float | None:
    """A text as a number; None: it is none."""
    try:
        return float(text)
    except ValueError:
        return None


def _read_pcd(path: Path) -> list[Array]:
    head, names, kinds, counts = 0, [""], [""], [1]
    count, form = 0, ""
    content = path.read_bytes()
    while not form:
        end = content.find(b"\n", head)
        if end < 0 or head > 4096:
            raise BadInput(f"{path.name} is no PCD file: its header does not end.")
        word, *values = content[head:end].decode("ascii", "replace").split() or ["#"]
        head = end + 1
        match word:
            case "FIELDS":
                names = values
            case "SIZE":
                kinds = values
            case "TYPE":
                kinds = [letter + size for letter, size in zip(values, kinds, strict=False)]
            case "COUNT":
                counts = [int(value) for value in values if value.isdigit()]
            case "POINTS":
                count = int(values[0]) if values and values[0].isdigit() else 0
            case "DATA":
                form = values[0] if values else "?"
            case _:
                pass
    if not {"x", "y"} <= set(names) or not 0 < count <= MOST_POINTS or any(each != 1 for each in counts):
        raise BadInput(f"{path.name} needs the single fields x and y and between 1 and {MOST_POINTS} points.")
    return [polar(_pcd_table(path, content[head:], names, kinds, count, form))]


def _pcd_table(path: Path, body: bytes, names: list[str], kinds: list[str], count: int, form: str) -> Array:
    """The fields x and y (N, 2) of a PCD file's body."""
    if form == "ascii":
        rows = [line.split() for line in body.decode("ascii", "replace").splitlines()]
        x, y = names.index("x"), names.index("y")
        points = [(number_in(row[x]), number_in(row[y])) for row in rows if len(row) >= len(names)]
        table = np.array(points, float).reshape(-1, 2)
    elif form == "binary" and len(kinds) == len(names) and set(kinds) <= set(KINDS):
        layout = np.dtype([(name, KINDS[kind]) for name, kind in zip(names, kinds, strict=True)])
        if len(body) < count * layout.itemsize:
            raise BadInput(f"{path.name} is cut off: {count} points are announced.")
        points = np.frombuffer(body, layout, count)
        table = np.column_stack((points["x"], points["y"])).astype(float)
    else:
        raise BadInput(f"{path.name} is written as '{form[:20]}'; ascii and binary PCD are read.")
    return table
