"""Which Beckon this is."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version


def beckon_version() -> str:
    """The installed version, or "unknown" when run from a bare checkout."""
    try:
        return version("beckon")
    except PackageNotFoundError:
        return "unknown"
