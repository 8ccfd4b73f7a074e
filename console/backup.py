"""The data folder as one file, and back: all that is Beckon's in it but models, and recordings on request."""

import contextlib
import hashlib
import io
import json
import os
import shutil
import sqlite3
import tarfile
import tempfile
import time
import zlib
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Any, cast

from console import beckon_version
from console.data_folder import OURS, locked
from core.errors import BadInput, Unwritable
from core.files import UNFINISHED, reason, replacing

MANIFEST = "beckon-backup.json"
BACKUP_FORMAT = 1
DATABASE = "history.sqlite"
NEVER_KEPT = ("models", "lock", "driver.lock", "access.lock", "before-restore", "open.html")  # made again, or of here
HALT, FLEET = "halt.", "fleet"  # begins the latch of a halt, here or in a fleet's folder: only a person ends it
RECORDINGS = "recordings"
MAX_MANIFEST_BYTES = 64 << 20
BLOCK_BYTES = 1 << 20
MAX_TRIES = 3  # to pack a folder in which files go meanwhile
MAX_DATE_S = 1 << 33  # that a file may bear


@dataclass(frozen=True)
class BackupReport:
    file: Path
    files: int
    bytes: int
    left_out: tuple[str, ...] = ()


def write_backup(home: Path, file: Path, *, recordings: bool = False) -> BackupReport:
    """Pack a data folder into `file` (.tar.gz), also while a console runs on it.

    Raises BadInput where there is none, Unwritable.
    """
    if not home.is_dir():
        raise BadInput(f"There is no data folder {home}; name it with --data DIR.")
    try:
        with replacing(file, mode=0o600) as written:  # keys of logins are in it
            rows = _written_box(home, written, recordings)
    except (OSError, sqlite3.Error) as trouble:
        why = reason(trouble) if isinstance(trouble, OSError) else f"{trouble}."
        raise Unwritable(f"The backup {file} could not be written: {why}") from None
    left = () if recordings or not (home / RECORDINGS).is_dir() else (RECORDINGS,)
    return BackupReport(file, len(rows), sum(row["bytes"] for row in rows), left)


def _written_box(home: Path, written: IO[bytes], recordings: bool) -> list[dict[str, Any]]:
    """Pack everything → the rows of the manifest. Begins again where a file is gone: what replaced it has its place.

    Raises OSError, sqlite3.Error.
    """
    for tries_left in reversed(range(MAX_TRIES)):
        rows: list[dict[str, Any]] = []
        try:
            with tarfile.open(fileobj=written, mode="w:gz") as box:
                for path in _kept(home, recordings):
                    with _content(path) as content:
                        changed_s = os.fstat(content.fileno()).st_mtime
                        rows.append(_packed(box, path.relative_to(home).as_posix(), content, changed_s))
                made = {"format": BACKUP_FORMAT, "beckon": beckon_version(), "made_s": round(time.time(), 3)}
                manifest = json.dumps({**made, "files": rows}, indent=1).encode()
                _packed(box, MANIFEST, io.BytesIO(manifest), time.time())
        except FileNotFoundError:
            if not tries_left or not written.seekable():
                raise
            written.seek(0)
            written.truncate()
        else:
            return rows
    raise AssertionError("the last try returns or raises")


def restore_backup(file: Path, home: Path, *, replace: bool = False) -> BackupReport:
    """Put a backup into a data folder that no console uses; nothing is changed unless all of it is sound.

    With `replace`, what is there moves into its folder `before-restore`. Raises BadInput for a file that is no sound
    backup or a folder that is not empty, Unavailable while a console runs, Unwritable.
    """
    fresh = not home.exists()
    try:
        with contextlib.ExitStack() as held:
            held.enter_context(locked(home))
            if (home / FLEET).is_dir():
                held.enter_context(locked(home / FLEET))
            # beside the folder nothing may be writable: a volume, a service's folder
            name = held.enter_context(tempfile.TemporaryDirectory(prefix=".restore-", suffix=UNFINISHED, dir=home))
            staged = Path(name) / "home"
            rows = _unpacked(file, staged)
            _swap(staged, home, replace)
    except OSError as trouble:
        raise Unwritable(f"The backup could not be put back into {home}: {reason(trouble)}") from None
    except BadInput:
        if fresh:
            shutil.rmtree(home, ignore_errors=True)
        raise
    return BackupReport(file, len(rows), sum(row["bytes"] for row in rows))


def _lasts(name: str) -> bool:
    return name not in NEVER_KEPT and not name.endswith(UNFINISHED) and not name.startswith(HALT)


def _kept(home: Path, recordings: bool) -> Iterator[Path]:
    for top in sorted(home.iterdir()):
        if not OURS.fullmatch(top.name) or not _lasts(top.name):
            continue
        if top.name == RECORDINGS and not recordings:
            continue
        files = sorted(top.rglob("*")) if top.is_dir() else [top]
        for path in files:
            journal = path.name.startswith(f"{DATABASE}-")  # the database itself is copied whole
            unfinished = path.name.startswith(".") and path.name.endswith(UNFINISHED)
            halt = path.parent == home / FLEET and path.name.startswith(HALT)
            if path.is_file() and not (path.is_symlink() or journal or unfinished or halt):
                yield path


@contextlib.contextmanager
def _content(path: Path) -> Generator[IO[bytes]]:
    """Return a file to read; of the database a copy that is whole while it is written to."""
    if path.name != DATABASE:
        with path.open("rb") as content:
            yield content
        return
    with tempfile.TemporaryDirectory(prefix="beckon-") as folder:
        copy = Path(folder) / DATABASE
        with contextlib.closing(sqlite3.connect(path)) as source, contextlib.closing(sqlite3.connect(copy)) as target:
            source.backup(target)
        with copy.open("rb") as content:
            yield content


def _packed(box: tarfile.TarFile, name: str, content: IO[bytes], changed_s: float) -> dict[str, Any]:
    """Add a file that was changed then (Unix time) → its row of the manifest."""
    digest = hashlib.sha256()
    with tempfile.SpooledTemporaryFile(max_size=8 * BLOCK_BYTES) as steady:  # it may grow while it is read
        size = 0
        while block := content.read(BLOCK_BYTES):
            digest.update(block)
            size += len(block)
            steady.write(block)
        steady.seek(0)
        entry = tarfile.TarInfo(name)
        entry.size, entry.mode, entry.mtime = size, 0o600, int(changed_s)
        box.addfile(entry, cast(IO[bytes], steady))
    return {"name": name, "bytes": size, "sha256": digest.hexdigest()}


def _unpacked(file: Path, folder: Path) -> list[dict[str, Any]]:
    """Unpack into a new folder and compare every checksum → rows of the manifest. Raises BadInput."""
    try:
        opened = file.open("rb")
    except OSError as trouble:
        raise BadInput(f"The backup {file} cannot be read: {trouble.strerror}.") from None
    folder.mkdir(mode=0o700)
    text: bytes | None = None
    found: dict[str, str] = {}
    try:
        with opened, tarfile.open(fileobj=opened, mode="r:gz") as box:
            for entry in box:
                content = box.extractfile(entry) if entry.isfile() else None
                if content is None:
                    raise BadInput(
                        f"{file.name} holds something that is no file ({entry.name[:60]!r}): no backup of Beckon."
                    )
                if entry.name == MANIFEST:
                    text = content.read(MAX_MANIFEST_BYTES)
                else:
                    found[entry.name] = _written(folder / _inside(entry.name, file), content, entry.mtime)
    except (tarfile.TarError, EOFError, zlib.error, OSError) as trouble:
        if isinstance(trouble, OSError) and trouble.errno is not None:
            raise
        raise BadInput(f"{file.name} is damaged or no backup of Beckon: it cannot be unpacked whole.") from None
    rows = _read_manifest(file, text)
    if {row["name"]: row["sha256"] for row in rows} != found:
        raise BadInput(f"{file.name} is damaged: its files are not those that were kept. Nothing was changed.")
    return rows


def _read_manifest(file: Path, text: bytes | None) -> list[dict[str, Any]]:
    """The rows of a manifest. Raises BadInput."""
    try:
        manifest = json.loads(text or b"")
        form, version, rows = manifest["format"], str(manifest["beckon"]), list(manifest["files"])
        rows = [{"name": str(row["name"]), "bytes": int(row["bytes"]), "sha256": str(row["sha256"])} for row in rows]
    except (ValueError, KeyError, TypeError):
        raise BadInput(
            f"{file.name} is no backup of Beckon, or it ends early: its list of files is missing."
        ) from None
    if form != BACKUP_FORMAT:
        raise BadInput(
            f"{file.name} was made by Beckon {version[:20]}, in a form that this one does not know: update Beckon."
        )
    return rows


def _inside(name: str, file: Path) -> PurePosixPath:
    """The place of an entry in the data folder. Raises BadInput for one that would lie elsewhere."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or not path.parts or not OURS.fullmatch(path.parts[0]):
        raise BadInput(f"{file.name} holds {name[:60]!r}, which is no file of Beckon's: nothing was changed.")
    return path


def _written(path: Path, content: IO[bytes], changed_s: float) -> str:
    """Write a file that only its owner reads, with the date that it had → its checksum.

    The oldest recordings go first where there is no room, and pictures are listed by their dates.
    """
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    digest = hashlib.sha256()
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        while block := content.read(BLOCK_BYTES):
            digest.update(block)
            file.write(block)
        file.flush()
        if 0 <= changed_s < MAX_DATE_S:
            os.utime(file.fileno(), (changed_s, changed_s))
        os.fsync(file.fileno())
    return digest.hexdigest()


def _swap(staged: Path, home: Path, replace: bool) -> None:
    """Move every entry of `staged` into `home`, which is locked, or none.

    Raises BadInput where something is in the way, OSError.
    """
    present = [path for path in home.iterdir() if OURS.fullmatch(path.name) and _lasts(path.name)]
    if present and not replace:
        names = ", ".join(sorted(path.name for path in present)[:4])
        raise BadInput(
            f"The data folder {home} is not empty ({names}): choose another with --data DIR, or --replace keeps what "
            "is there beside it."
        )
    before = home / "before-restore"
    if present and before.exists():
        raise BadInput(f"{before} is still there from an earlier restore: move it away first.")
    for old in (staged / FLEET).glob(f"{HALT}*"):  # of a backup of an earlier version
        old.unlink()
    halts = [*(home / FLEET).glob(f"{HALT}*")]
    if halts:
        (staged / FLEET).mkdir(mode=0o700, exist_ok=True)
    moves = [(path, staged / FLEET / path.name) for path in halts] + [(path, before / path.name) for path in present]
    moves += [(path, home / path.name) for path in staged.iterdir() if _lasts(path.name)]
    with contextlib.ExitStack() as back:
        if present:
            before.mkdir(mode=0o700)
            back.callback(before.rmdir)
        for path, target in moves:
            path.rename(target)
            back.callback(target.rename, path)
        back.pop_all()
