"""The operator's key in a file of its own, so that it stays the same over restarts: `--token-file`."""

import os
import re
import secrets
from pathlib import Path

from core.errors import BadInput, Unwritable
from core.files import reason

KEY = re.compile(r"[A-Za-z0-9_~.-]{32,200}")  # stands in an address as it is


def read_token(path: Path) -> str:
    """The key in this file; a new one is written there when there is no file. Raises BadInput, Unwritable."""
    try:
        with path.open("rb") as file:
            mode, raw = os.fstat(file.fileno()).st_mode, file.read(1000)
    except FileNotFoundError:
        return _write_token(path)
    except OSError as trouble:
        raise BadInput(f"--token-file {path} cannot be read: {trouble.strerror}.") from None
    if mode & 0o077:
        raise BadInput(f"Others on this machine can read --token-file {path}; close it with: chmod 600 {path}")
    token = raw.decode("ascii", "replace").strip()
    if not KEY.fullmatch(token):
        raise BadInput(
            f"--token-file {path} holds no key: one line of 32 to 200 letters, digits, - _ . ~ and nothing else. "
            "Remove the file, and a new key is written there."
        )
    return token


def _write_token(path: Path) -> str:
    token = secrets.token_urlsafe(32)
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(token + "\n")
    except OSError as trouble:
        raise Unwritable(f"--token-file {path} could not be written: {reason(trouble)}") from None
    return token
