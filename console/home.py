"""Where Beckon keeps what must last."""

from __future__ import annotations

import os
from pathlib import Path


def home_folder(chosen: str | Path | None = None) -> Path:
    """`--data DIR`, else $BECKON_HOME, else the user's data folder."""
    if chosen:
        return Path(chosen).expanduser()
    if own := os.environ.get("BECKON_HOME"):
        return Path(own).expanduser()
    base = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    return Path(base).expanduser() / "beckon"
