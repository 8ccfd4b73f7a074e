"""A floor's map as plain arrays and JSON: kept in files, and continued on another day."""

from __future__ import annotations

import io
import json
from pathlib import Path

import msgspec
import numpy as np

from core.errors import BadInput
from core.files import replacing, saving, write_atomic
from core.message import Array, message
from core.slam.association.landmark_table import LandmarkRecord
from core.slam.map.status import ClosureState

FORM_NUMBER = 1  # of the files; another number is not read
MAX_ARRAY_BYTES = 2_000_000_000  # bytes of all arrays together
WORDS, ARRAYS = "map.json", "map.npz"
CLOSURES = "bonds"  # the key of the loop closures in map.json

SHAPES: dict[str, tuple[str, ...]] = {
    "view_stamps": ("views",),
    "view_submaps": ("views",),
    "view_locals": ("views", "3"),
    "view_poses": ("views", "3"),
    "view_eyes": ("views", "2"),
    "view_beams": ("views",),
    "beam_ends": ("beams", "2"),
    "beam_hits": ("beams",),
    "driven_moves": ("ways", "3"),
    "driven_covariances": ("ways", "3", "3"),
    "tied_ends": ("ties", "2"),
    "tied_moves": ("ties", "3"),
    "tied_covariances": ("ties", "3", "3"),
    "link_ends": ("links", "3"),
    "link_moves": ("links", "3"),
    "link_covariances": ("links", "3", "3"),
    "link_scores": ("links", "2"),
}
"""Every array and its shape; the same word is the same number. Links' ends: closure, a, b; scores: score, stamp."""


class SavedClosure(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A loop closure; its links stand in the arrays and are counted within it, from 0."""

    id: int
    older: int  # submap
    newer: int  # submap
    next_door: bool
    state: ClosureState
    accepted: list[int]  # links
    shown: int | None  # link


class MapForm(msgspec.Struct, frozen=True):
    """Head of a map, which is read first."""

    form: int


class MapFacts(MapForm, frozen=True, forbid_unknown_fields=True):
    """All of a map that is no array: `map.json`."""

    resolution_m: float
    landmarks: list[list[LandmarkRecord]]  # of every submap
    closures: list[SavedClosure] = msgspec.field(name=CLOSURES)


@message
class SavedMap:
    """Everything that is known of a floor: submaps, views, graph, closures, tiles, landmarks with covariances.

    `arrays`: those of SHAPES, and for every submap k `tile_k` (rows, columns) log odds, `origin_k` (2,) [m],
    `places_k` (N, 2) [m], `covariance_k` (3 + 2N, 3 + 2N) of robot and landmarks as its filter measures them, and
    `pose_k` (3,) of the robot when it was there last.
    """

    arrays: dict[str, Array]
    facts: MapFacts

    @property
    def submaps(self) -> int:
        """Number of submaps."""
        return len(self.facts.landmarks)

    def to_files(self, folder: Path) -> None:
        """Write `map.json` and `map.npz` into a folder. Raises Unwritable."""
        with saving("The map could not be saved"):
            with replacing(folder / ARRAYS) as file:
                np.savez_compressed(file, allow_pickle=False, **self.arrays)
            facts = msgspec.to_builtins(self.facts, enc_hook=float)  # of numpy's numbers
            write_atomic(folder / WORDS, json.dumps(facts, indent=1))

    def to_bytes(self) -> bytes:
        """The whole map in one piece, for a recording."""
        file = io.BytesIO()
        facts = json.dumps(msgspec.to_builtins(self.facts, enc_hook=float)).encode()
        np.savez(file, allow_pickle=False, **self.arrays, **{WORDS: np.frombuffer(facts, np.uint8)})
        return file.getvalue()

    @staticmethod
    def from_bytes(content: bytes, name: str) -> SavedMap:
        """Read what `to_bytes` made. Raises BadInput."""
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as archive:
                arrays = {key: archive[key] for key in archive.files}
            words = json.loads(arrays.pop(WORDS).tobytes())
        except Exception:  # zipfile, json and numpy raise many kinds on damaged bytes
            raise BadInput(f"The map {name} is damaged.") from None
        return checked(SavedMap(arrays=arrays, facts=_facts(words, name)), name)

    @staticmethod
    def from_files(folder: Path) -> SavedMap:
        """Read what `to_files` wrote. Raises BadInput with a sentence for every fault."""
        try:
            words = json.loads((folder / WORDS).read_text(encoding="utf-8"))
            with np.load(folder / ARRAYS, allow_pickle=False) as archive:
                sizes = sum(member.file_size for member in archive.zip.infolist())
                if sizes > MAX_ARRAY_BYTES:
                    raise BadInput(f"The map {folder.name} is too large.")
                arrays = {name: archive[name] for name in archive.files}
        except BadInput:
            raise
        except OSError as trouble:
            raise BadInput(f"The map {folder.name} cannot be read: {trouble.strerror or trouble}.") from None
        except Exception:  # zipfile, zlib, json and numpy raise many kinds on damaged files
            raise BadInput(f"The map {folder.name} is damaged; save it again.") from None
        return checked(SavedMap(arrays=arrays, facts=_facts(words, folder.name)), folder.name)


def _facts(words: object, name: str) -> MapFacts:
    """Content of `map.json` → the facts. Raises BadInput."""
    try:
        if msgspec.convert(words, MapForm).form != FORM_NUMBER:
            raise BadInput(f"The map {name} is damaged: it is of another form.")
        return msgspec.convert(words, MapFacts)
    except msgspec.ValidationError:
        raise BadInput(f"The map {name} is damaged: parts of it are missing or wrong.") from None


def checked(saved: SavedMap, name: str) -> SavedMap:
    """The same map, if it holds together. Raises BadInput."""
    try:
        complaint = _complaint(saved)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError):
        complaint = "parts of it are missing"
    if complaint:
        raise BadInput(f"The map {name} is damaged: {complaint}.")
    return saved


def _complaint(saved: SavedMap) -> str:
    """Return what is inconsistent; "" if nothing is."""
    facts, arrays = saved.facts, saved.arrays
    if not 0.005 <= facts.resolution_m <= 1.0:
        return "its resolution cannot be"
    counts: dict[str, int] = {}
    return (
        _shape_complaint(arrays, counts)
        or _graph_complaint(saved, counts)
        or _closure_complaint(saved)
        or next((complaint for k in range(saved.submaps) if (complaint := _submap(saved, k))), "")
    )


def _shape_complaint(arrays: dict[str, Array], counts: dict[str, int]) -> str:
    """Return which array has the wrong shape, or ""; `counts` gets the lengths that the shapes name."""
    for key, shape in SHAPES.items():
        array = arrays[key]
        if array.dtype.kind not in "fiub" or array.ndim != len(shape):
            return f"{key} is no table of numbers"
        for expected, side in zip(shape, array.shape, strict=True):
            if (int(expected) if expected.isdigit() else counts.setdefault(expected, side)) != side:
                return f"{key} has the wrong length"
        if key != "beam_ends" and array.dtype.kind == "f" and not np.isfinite(array).all():
            return f"{key} has numbers that are not finite"
    return ""


def _graph_complaint(saved: SavedMap, counts: dict[str, int]) -> str:
    """Return what is inconsistent between views, submaps and the links between views, or ""."""
    arrays, views, rooms = saved.arrays, counts["views"], saved.submaps
    if views == 0 or rooms == 0 or counts["ways"] != views - 1:
        return "it is empty"
    if int(arrays["view_beams"].sum()) != counts["beams"] or (arrays["view_beams"] < 2).any():
        return "its scans are cut"
    if not _within(arrays["view_submaps"], rooms) or set(arrays["view_submaps"].tolist()) != set(range(rooms)):
        return "views lie in submaps that are not there"
    if not _within(arrays["tied_ends"], views) or not _within(arrays["link_ends"][:, 1:], views):
        return "its graph names views that are not there"
    return ""


def _closure_complaint(saved: SavedMap) -> str:
    """Return what is wrong with the closures and their links, or ""."""
    loop_closures = saved.facts.closures
    ends = saved.arrays["link_ends"][:, 0]
    if not _within(ends, len(loop_closures)):
        return "links belong to nothing"
    counted = np.bincount(ends, minlength=len(loop_closures)).tolist()
    for loop_closure, links in zip(loop_closures, counted, strict=True):
        shown = [] if loop_closure.shown is None else [loop_closure.shown]
        if any(not 0 <= k < links for k in (*loop_closure.accepted, *shown)):
            return "its closures are wrong"
    return ""


def _submap(saved: SavedMap, number: int) -> str:
    arrays, rows = saved.arrays, saved.facts.landmarks[number]
    size = 3 + 2 * len(rows)
    shapes = {"origin": (2,), "pose": (3,), "places": (len(rows), 2), "covariance": (size, size)}
    for key, shape in shapes.items():
        array = arrays[f"{key}_{number}"]
        if array.shape != shape or array.dtype.kind != "f" or not np.isfinite(array).all():
            return f"{key} of submap {number} is wrong"
    tile = arrays[f"tile_{number}"]
    if tile.ndim != 2 or tile.dtype.kind != "f" or not np.isfinite(tile).all():
        return f"the tile of submap {number} is wrong"
    return ""


def _within(numbers: Array, count: int) -> bool:
    return numbers.dtype.kind in "iu" and bool(((numbers >= 0) & (numbers < count)).all())
