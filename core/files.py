"""Files that must last: written whole or not at all, and on the disk before anything is said about them."""

import codecs
import contextlib
import errno
import fcntl
import hashlib
import json
import os
import secrets
import stat
import time
from collections.abc import Callable, Generator, Mapping
from pathlib import Path
from typing import IO

from core.errors import BadInput, Unwritable

UNFINISHED = ".new"  # ends the name of a file while it is written; a dot begins it
SEAL = "sha256"  # the key of a checksum
ABANDONED_S = 60.0  # after its last change nobody writes an unfinished file any more
LFS_POINTER = b"version https://git-lfs.github.com/spec/"  # begins what Git leaves in place of a large file
LFS_WORDS = "only points to the file, which Git LFS holds: fetch it with git lfs pull"
TRIAL_BYTES = 4096  # that are written to find out whether a folder can be written to

REMEDIES = {
    errno.ENOSPC: "Free some space on this disk and try again.",
    errno.EDQUOT: "Free some of your quota on this disk and try again.",
    errno.EROFS: "Mount the disk so that it can be written and try again.",
    errno.EFBIG: "Raise the limit on the size of files (ulimit -f) and try again.",
    errno.EIO: "The disk may be failing; check it.",
}


def text_of(content: bytes, name: str) -> str:
    """The bytes of a text file → its text, as editors of all systems write it: UTF-8, or UTF-16 with its mark.

    Letters of zero are no text, or UTF-16 without the mark. Raises BadInput that begins with `name`.
    """
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    with contextlib.suppress(UnicodeDecodeError):
        if wide or b"\0" not in content:
            return content.decode("utf-16" if wide else "utf-8-sig")
    raise BadInput(f"{name} is not a text file in UTF-8; save it again in UTF-8.")


def write_atomic(path: Path, content: bytes | str, mode: int = 0o666) -> None:
    """Replace a file: a crash or a power cut leaves the former content or the new one. Makes its folder.

    It is on the disk, and so is its name, when this returns. A device or a pipe is written to as it is. Raises
    OSError; what was written of the new file is removed then. `mode`: of the file from its first byte on.
    """
    with replacing(path, mode=mode) as file:
        file.write(content.encode() if isinstance(content, str) else content)


@contextlib.contextmanager
def replacing(path: Path, before: Callable[[], None] | None = None, mode: int = 0o666) -> Generator[IO[bytes]]:
    """A file to write to, which takes the place of `path` when all is written: as `write_atomic`, piece by piece.

    `before`: done when the new file is safe on the disk and the former one is still in its place.
    """
    path = path.resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists() and not path.is_file() and not path.is_dir():
        with path.open("wb") as file:
            yield file
        return
    fresh = unfinished(path)
    try:
        with open(fresh, "xb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        if before is not None:
            before()
        fresh.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            fresh.unlink()
        raise
    sync_folder(path.parent)


def unfinished(path: Path) -> Path:
    """A name for a file while it is written, beside its own: hidden, and removed by `remove_unfinished`."""
    return path.with_name(f".{path.name[-60:]}.{secrets.token_hex(4)}{UNFINISHED}")


def sync_folder(folder: Path) -> None:
    """Have the names in a folder on the disk. Raises OSError."""
    if os.name != "nt":
        sync(folder, os.O_RDONLY)


def sync(path: Path, mode: int = os.O_RDWR) -> None:
    """Have what was written to a file on the disk. Raises OSError."""
    opened = os.open(path, mode)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


@contextlib.contextmanager
def locked(path: Path) -> Generator[None]:
    """Hold a lock, a file that is made where it is missing: one process at a time. Raises OSError."""
    with os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o600)) as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def remove_unfinished(folder: Path) -> None:
    """Remove what a crash left half-written: unfinished files that have not changed for ABANDONED_S."""
    for left in folder.rglob(f".*{UNFINISHED}"):
        with contextlib.suppress(OSError):
            found = left.lstat()
            if stat.S_ISREG(found.st_mode) and abs(time.time() - found.st_mtime) > ABANDONED_S:
                left.unlink()


@contextlib.contextmanager
def saving(failure: str) -> Generator[None]:
    """Turn the OSError of a write into Unwritable, which begins with `failure` ("The map could not be saved")."""
    try:
        yield
    except OSError as trouble:
        raise Unwritable(f"{failure}: {reason(trouble)}") from None


def folder_at(out: Path) -> Path:
    """A folder to write to, made where it is missing. Raises Unwritable."""
    with saving(f"The folder {out} cannot be made"):
        out.mkdir(parents=True, exist_ok=True)
    return out


def save(path: Path, content: str | bytes) -> str:
    """Content into a file → where it lies. Raises Unwritable."""
    with saving(f"{path} cannot be written"):
        write_atomic(path, content)
    return str(path)


def save_all(out: Path, contents: Mapping[str, tuple[str, str | bytes]]) -> dict[str, str]:
    """Name and content of a file by its form → files in a folder; which is which, by form. Raises Unwritable."""
    folder = folder_at(out)
    return {form: save(folder / name, content) for form, (name, content) in contents.items()}


def reason(trouble: OSError) -> str:
    """Return why a write failed and what to do, to stand after a colon."""
    remedy = REMEDIES.get(trouble.errno or 0, "Check the folder and who may write to it.")
    return f"{trouble.strerror or trouble}. {remedy}"


def check_folder(folder: Path) -> None:
    """Make sure that files can be written below a folder, which need not exist yet; leaves nothing.

    Raises Unwritable with a sentence.
    """
    try:
        try_writing(_first_existing(folder))
    except OSError as trouble:
        failed = "made" if not os.path.lexists(folder) else "written to"
        raise Unwritable(f"The folder {folder} cannot be {failed}: {reason(trouble)}") from None


def check_file(path: Path) -> None:
    """Make sure that a file can be written. Raises Unwritable with a sentence."""
    if path.is_dir():
        raise Unwritable(f"{path} cannot be written: it is a folder. Give the name of a file.")
    check_folder(path.parent)


def try_writing(folder: Path) -> None:
    """Write a small file into a folder and remove it. Raises OSError."""
    probe = folder / f".{secrets.token_hex(4)}{UNFINISHED}"
    try:
        probe.write_bytes(bytes(TRIAL_BYTES))
    finally:
        probe.unlink(missing_ok=True)


def checksum(raw: bytes) -> str:
    """SHA-256 in hexadecimal digits."""
    return hashlib.sha256(raw).hexdigest()


def sealed(document: Mapping[str, object]) -> dict[str, object]:
    """A JSON object with the checksum of all the rest of it under SEAL."""
    return {**document, SEAL: _seal(document)}


def is_intact(document: Mapping[str, object]) -> bool | None:
    """Return whether a JSON object matches its checksum; None where it has none."""
    return None if SEAL not in document else document[SEAL] == _seal(document)


def _seal(document: Mapping[str, object]) -> str:
    rest = {name: value for name, value in document.items() if name != SEAL}
    return checksum(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode())


def _first_existing(folder: Path) -> Path:
    """The folder itself or the nearest one above it that exists. Raises OSError where that is no folder."""
    for place in (folder, *folder.absolute().parents):
        try:
            mode = place.stat().st_mode
        except FileNotFoundError:
            if place.is_symlink():
                raise NotADirectoryError(errno.ENOTDIR, "It is a link to nothing", str(place)) from None
            continue
        if not stat.S_ISDIR(mode):
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(place))
        return place
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(folder))
