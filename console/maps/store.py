"""Saved maps on the disk: a folder each, written aside and renamed, so that a half-written one never counts."""

import contextlib
import io
import json
import logging
import re
import secrets
import shutil
import tempfile
import unicodedata
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import msgspec

from console.maps.marks import MARKS
from core.errors import BadInput, Refused
from core.files import checksum, is_intact, saving, sealed, sync_folder, write_atomic
from core.sentences import Statement

log = logging.getLogger(__name__)

FORM_VERSION = 1
CARD = "card.json"
MAX_CARD_BYTES = 65536
MAX_NAME_LETTERS = 40  # letters of a name
NAME = re.compile(r"\w(?:[\w \-]*\w)?")
MEMBER = re.compile(r"(?:[\w-]+/)?[\w-]+\.\w+")  # a file of a packed map
MAX_MAP_BYTES = 500_000_000  # unpacked
ASIDE = ".new-"  # how the folder of a map begins that is being written


class SavedMapFacts(msgspec.Struct):
    name: str
    saved_s: float  # Unix time
    by: str  # who saved it
    robot: str  # whose it is
    resolution_m: float
    width_m: float
    height_m: float
    submaps: int
    landmarks: int
    closures: int


class MapInfo(SavedMapFacts):
    """The description of a saved map, as its folder holds it."""

    version: int = FORM_VERSION
    laser_height_m: float | None = None  # above the floor, of what drew it; None: not known
    frame: str = ""  # equal in maps with the same axes; "": not known
    files: dict[str, str] = {}  # name within the map's folder → checksum; maps of earlier consoles have none


@dataclass(frozen=True)
class StoredMap:
    card: MapInfo
    folder: Path
    changed: bool = False  # the card itself is not as it was saved


class NameTaken(Refused):
    """There is a map of that name already."""


class MapStore:
    """All saved maps below one folder. Its methods wait for the disk: call them from a thread, one at a time."""

    def __init__(self, base: Path) -> None:
        self._base = base

    def clean(self) -> None:
        """Remove unfinished maps, and maps that a newer one of the same name replaces."""
        for left in self._base.glob(f"{ASIDE}*"):
            shutil.rmtree(left, ignore_errors=True)
        newest = {kept.folder for kept in self.all()}
        for kept in self._readable():
            if kept.folder not in newest:
                shutil.rmtree(kept.folder, ignore_errors=True)

    def all(self) -> list[StoredMap]:
        """Every map, the newest first."""
        found: dict[str, StoredMap] = {}
        for kept in sorted(self._readable(), key=lambda kept: kept.card.saved_s):
            found[key_of(kept.card.name)] = kept
        return sorted(found.values(), key=lambda kept: -kept.card.saved_s)

    def find(self, name: str) -> StoredMap | None:
        """The map of this name; large and small letters are the same."""
        return next((kept for kept in self.all() if key_of(kept.card.name) == key_of(name)), None)

    def keep(self, card: MapInfo, write: Callable[[Path], None], *, replace: bool) -> None:
        """Save a map: `write` puts its files into the folder it is given. Raises NameTaken, Unwritable."""
        former = self.find(card.name)
        if former is not None and not replace:
            raise NameTaken(f"There is a map “{former.card.name}” already; choose another name, or replace it.")
        aside = self._base / f"{ASIDE}{secrets.token_hex(4)}"
        try:
            with saving("The map could not be saved, and nothing was changed"):
                aside.mkdir(parents=True)
                write(aside)
                found = [(name, path) for name, path in files_of(aside) if lasting(name)]
                card.files = {name: checksum(path.read_bytes()) for name, path in found}
                write_atomic(aside / CARD, json.dumps(sealed(msgspec.to_builtins(card)), indent=1))
                for path in filter(Path.is_dir, [*aside.rglob("*"), aside]):
                    sync_folder(path)
                aside.rename(self._base / f"{slug(card.name)}-{secrets.token_hex(4)}")
        except BaseException:
            shutil.rmtree(aside, ignore_errors=True)
            raise
        with saving("The map was saved, but a power cut may lose it"):
            sync_folder(self._base)
        if former is not None:
            self._leave(former)

    def rename(self, kept: StoredMap, name: str) -> None:
        """Call a map otherwise, in the place of one that has this name. Raises FileNotFoundError, Unwritable."""
        former, card = self.find(name), kept.folder / CARD
        if former is not None and former.folder == kept.folder:
            former = None  # large letters for small ones
        document = {**json.loads(card.read_bytes()), "name": name}
        with saving("The map could not be renamed"):
            write_atomic(card, json.dumps(document if kept.changed else sealed(document), indent=1))
        if former is not None:
            self._leave(former)

    def remove(self, kept: StoredMap) -> None:
        """For good: out of sight first, then piece by piece. Raises FileNotFoundError, Unwritable."""
        gone = self._base / f"{ASIDE}{secrets.token_hex(4)}"
        kept.folder.stat()
        with saving("The map could not be deleted"):
            kept.folder.rename(gone)
            sync_folder(self._base)
        shutil.rmtree(gone, ignore_errors=True)

    def _leave(self, kept: StoredMap) -> None:
        """Remove a map that is replaced, out of sight first: who reads it meanwhile finds it whole, or gone."""
        gone = self._base / f"{ASIDE}{secrets.token_hex(4)}"
        with contextlib.suppress(OSError):  # the newer of two is the one that counts
            kept.folder.rename(gone)
            shutil.rmtree(gone, ignore_errors=True)

    def checked(self, kept: StoredMap) -> Path:
        """The map's folder, when all in it is as it was saved. Raises BadInput that names the file, OSError."""
        for name in self._names(kept):
            self._read(kept, name)
        return kept.folder

    def packed(self, kept: StoredMap) -> IO[bytes]:
        """Everything of a map as a zip, at its beginning; its file is gone when it is closed.

        Raises BadInput that names a file which is not as it was saved, Unwritable, OSError.
        """
        failure = "The map could not be packed"
        with contextlib.ExitStack() as held:
            with saving(failure):
                packed: IO[bytes] = held.enter_context(tempfile.TemporaryFile(dir=self._base))
                box = held.enter_context(zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED))
            for name in self._names(kept):
                raw = self._read(kept, name)
                with saving(failure):
                    box.writestr(name, raw)
            with saving(failure):
                box.close()
            packed.seek(0)
            held.pop_all()
        return packed

    @staticmethod
    def unpacked(packed: bytes) -> tuple[MapInfo, dict[str, bytes]] | None:
        """Read what `packed` made → its card and its files; None for another zip. Raises BadInput."""
        try:
            with zipfile.ZipFile(io.BytesIO(packed)) as box:
                members = {one.filename: one for one in box.infolist()}
                if CARD not in members:
                    return None
                if sum(one.file_size for one in members.values()) > MAX_MAP_BYTES:
                    raise ValueError("too large")
                files = {name: box.read(name) for name in members}
            raw = files.pop(CARD)
            card = msgspec.json.decode(raw, type=MapInfo)
            named = {name: checksum(content) for name, content in files.items() if lasting(name)}
            intact = is_intact(json.loads(raw))  # None, and no checksums: of an earlier console
            whole = card.files == named if intact else intact is None and not card.files
            strange = any(".." in name or not MEMBER.fullmatch(name) for name in files)
            if not whole or strange or card.version != FORM_VERSION:
                raise ValueError("changed")
        except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError, ValueError, zlib.error):
            raise BadInput(Statement("maps.damaged_zip")) from None
        return card, files

    @staticmethod
    def _names(kept: StoredMap) -> list[str]:
        """All files of a map, also missing ones; for old maps, the files that are there."""
        return [CARD, *sorted({*kept.card.files, *(name for name, _ in files_of(kept.folder))})]

    @staticmethod
    def _read(kept: StoredMap, name: str) -> bytes:
        """A file of a map. Raises BadInput when it is not the one that was saved, OSError when the map is gone."""
        kept.folder.stat()
        path = kept.folder / name
        raw = path.read_bytes() if path.is_file() else b""
        changed = kept.changed if name == CARD else kept.card.files.get(name, checksum(raw)) != checksum(raw)
        if changed:
            raise BadInput(
                f"The saved map “{kept.card.name}” is damaged: {path} is not as it was saved. "
                "Restore this file from a backup, or delete the map and save it again."
            )
        return raw

    def _readable(self) -> Iterator[StoredMap]:
        for path in self._base.glob(f"*/{CARD}"):
            if path.parent.name.startswith(ASIDE):
                continue
            try:
                if path.stat().st_size > MAX_CARD_BYTES:
                    raise ValueError("too large")
                raw = path.read_bytes()
                card = msgspec.json.decode(raw, type=MapInfo)
                if card.version != FORM_VERSION or card.name != checked_name(card.name):
                    raise ValueError("of another version, or without a proper name")
            except (OSError, ValueError, BadInput, msgspec.MsgspecError) as trouble:
                log.warning("A saved map cannot be read: %s: %s", path, trouble)
                continue
            yield StoredMap(card, path.parent, changed=is_intact(json.loads(raw)) is False)


def checked_name(name: str) -> str:
    """A name as it is kept. Raises BadInput with what a name may be."""
    tidy = unicodedata.normalize("NFC", " ".join(name.split()))
    if not 0 < len(tidy) <= MAX_NAME_LETTERS or not NAME.fullmatch(tidy):
        raise BadInput(f"A name has 1 to {MAX_NAME_LETTERS} letters, digits, spaces, hyphens or underscores.")
    return tidy


def key_of(name: str) -> str:
    """Return the same key for two names that must not both exist."""
    return unicodedata.normalize("NFC", name).casefold()


def slug(name: str, otherwise: str = "map") -> str:
    """A name as every file system takes it: "Großes Büro" → "groes-buro"; `otherwise` where nothing is left."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-") or otherwise


def files_of(folder: Path) -> list[tuple[str, Path]]:
    """All files of a map but its card, by their names within its folder."""
    found = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}
    return [(name, path) for name, path in found.items() if name != CARD]


def lasting(name: str) -> bool:
    """Return whether a file of a map stays as it was saved: marks change later, and bear their own checksum."""
    return name != MARKS
