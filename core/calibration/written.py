"""Folders and files that a calibration leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from core.errors import Unavailable


def folder_at(out: Path) -> Path:
    """A folder to write to, made where it is missing. Raises Unavailable."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as trouble:
        raise Unavailable(f"The folder {out} cannot be made: {trouble.strerror or trouble}.") from None
    return out


def write(path: Path, content: str | bytes) -> str:
    """Content into a file → where it lies. Raises Unavailable."""
    try:
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    except OSError as trouble:
        raise Unavailable(f"{path} cannot be written: {trouble.strerror or trouble}.") from None
    return str(path)


def write_all(out: Path, texts: Mapping[str, tuple[str, str]]) -> dict[str, str]:
    """Name and text of a file by its form → files in a folder; which is which, by form. Raises Unavailable."""
    folder = folder_at(out)
    return {form: write(folder / name, text) for form, (name, text) in texts.items()}
