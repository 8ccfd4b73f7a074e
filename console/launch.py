"""The start of the command `beckon`; installed as a module of its own, so that it is found whatever is.

Another package or folder that is called `console` or `core` may stand before Beckon's own: then one sentence says so.
"""

import importlib.util
import os
import signal
import sys
from pathlib import Path

INTERRUPTED_CODE = 130
MARKS = {"console": "def beckon_version", "core": "The robot's perception and motion"}


def main() -> int:
    """Run the command `beckon`; returns its exit code."""
    if os.getpid() == 1:  # of a container: there a signal that nobody handles yet is lost
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    for name, mark in MARKS.items():
        place = found_at(name)
        if mark not in text_of(place):
            sys.stderr.write(
                f"beckon: {place or 'Nothing'} stands where Beckon's own package {name} should be. Install Beckon in "
                "an environment of its own (python3 -m venv), or remove the other one and install Beckon again.\n"
            )
            return 1
    try:
        from console.__main__ import main as run

        return run()
    except KeyboardInterrupt:  # while it was imported
        return INTERRUPTED_CODE


def found_at(name: str) -> str:
    """Return the file or folder that Python takes for a package; "": there is none."""
    spec = importlib.util.find_spec(name)
    if spec is None:
        return ""
    return spec.origin or next(iter(spec.submodule_search_locations or ()), "")


def text_of(place: str) -> str:
    """Return what a package's first file holds; "" for a folder without one."""
    path = Path(place)
    return path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
