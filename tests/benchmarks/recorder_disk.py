"""A recording on a disk that becomes full: `python -m tests.benchmarks.recorder_disk` (as root: it mounts a tmpfs).

Once it ends before the disk is full (`free_mb` as it is set), once the disk takes no more. Printed as JSON: what
people were told, whether the robot is driven all the same, what of the recording is there after the next start, and
every traceback in the log.
"""

import contextlib
import os
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import Console

DISK_MB, LEFT_MB = 48, 3  # of the disk, and left to the recording
PATIENCE_S = 90.0
BYTES_PER_MB = 1_000_000


@contextlib.contextmanager
def small_disk() -> Iterator[Path]:
    """A tmpfs of its own."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_MB}m", "tmpfs", folder], check=True)
        try:
            yield Path(folder)
        finally:
            subprocess.run(["umount", "-l", folder], check=True)


def until(true: Callable[[], Any], what: str) -> Any:
    """Wait for something to be the case → what it then is."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        with contextlib.suppress(TimeoutError):  # a busy computer answers late
            if found := true():
                return found
        time.sleep(0.3)
    raise TimeoutError(what)


def is_turned(console: Console) -> bool:
    """A turn is begun and ends as it should."""
    told = console.answer("/api/commands", {"text": "turn left"})
    path = f"/api/commands/{told['id']}"

    def ended() -> str:
        state = console.get(path)["state"]
        return state if state in ("done", "failed", "cancelled") else ""

    return until(ended, "the turn ends") == "done"


def filled(home: Path, free_mb: float) -> dict[str, Any]:
    """Record until the disk has no more."""
    (home / "settings.toml").write_text(f"[recording]\nfree_mb = {free_mb}\nring_s = 0\n")
    console = Console(home)
    try:
        time.sleep(5.0)
        console.answer("/api/recordings/start", {"name": "drive"})
        until(lambda: console.get("/api/recorder")["seconds"] > 2.0, "it records")
        stat = os.statvfs(home)
        size = stat.f_bavail * stat.f_frsize - LEFT_MB * BYTES_PER_MB
        (home / "filler").write_bytes(bytes(max(size, 0)))
        seconds = [0.0]

        def over() -> bool:
            now = console.get("/api/recorder")
            seconds[0] = max(seconds[0], now["seconds"])
            return now["name"] is None

        until(over, "the recording ends")
        time.sleep(3.0)
        told = [one["text"] for one in console.get("/api/state")["notices"] if one["level"] != "info"]
        turned = is_turned(console)
        alive = console.get("/api/health").get("status", "answers")
        whole = sorted(path.name for path in (home / "recordings").iterdir())
        (home / "filler").unlink()
        faults = console.faults()
    finally:
        console.close()
    again = Console(home)
    try:
        rows = until(
            lambda: [row for row in again.get("/api/recordings")["recordings"] if row["complete"]], "it is recovered"
        )
        left = [path.name for path in (home / "recordings").glob("*.part")]
    finally:
        again.close()
    return {
        "free_mb": free_mb,
        "told": told,
        "turned": turned,
        "health": alive,
        "files_while_it_is_full": whole,
        "recorded_s": round(seconds[0], 1),
        "recovered_s": round(max(row["seconds"] for row in rows), 1),
        "cause": rows[0]["cause"],
        "parts_left": left,
        "faults": faults,
    }


def main() -> object:
    """Both ways to the end of a disk."""
    report: list[dict[str, Any]] = []
    for free_mb in (20.0, 0.0):
        with small_disk() as home:
            report.append(filled(home, free_mb))
    return report


if __name__ == "__main__":
    run_command(main)
