"""Folders and files that a calibration leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from core.files import saving, write_atomic


def folder_at(out: Path) -> Path:
    """A folder to write to, made where it is missing. Raises Unwritable."""
    with saving(f"The folder {out} cannot be made"):
        out.mkdir(parents=True, exist_ok=True)
    return out


def write(path: Path, content: str | bytes) -> str:
    """Content into a file → where it lies. Raises Unwritable."""
    with saving(f"{path} cannot be written"):
        write_atomic(path, content)
    return str(path)


def write_all(out: Path, contents: Mapping[str, tuple[str, str | bytes]]) -> dict[str, str]:
    """Name and content of a file by its form → files in a folder; which is which, by form. Raises Unwritable."""
    folder = folder_at(out)
    return {form: write(folder / name, content) for form, (name, content) in contents.items()}
