"""What one turn of the event loop takes at most, in processor time: `python -m tests.benchmarks.loop_share`.

Unlike the time until an answer this hardly depends on what else the machine does. The console runs in this process,
each attack of `attacker` in one of its own.
"""

import asyncio.events
import contextlib
import gc
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.benchmarks.attacker import STRANGERS
from tests.benchmarks.command import print_row, run_command
from tests.console.live import Live

KEYED = ("flood", "within", "pings")  # who signs in as a viewer
ATTACK = 8.0  # [s]


class Share:
    """What the loop's thread spends on its callbacks."""

    def __init__(self) -> None:
        self.worst = self.total = 0.0  # [s]


@contextlib.contextmanager
def watched(loop_thread: int) -> Iterator[Share]:
    """Time every callback of the loop that runs in this thread."""
    share, handle = Share(), asyncio.events.Handle
    run: Any = handle._run

    def timed(self: Any) -> None:
        if threading.get_ident() != loop_thread:
            run(self)
            return
        begun = time.thread_time()
        run(self)
        took = time.thread_time() - begun
        share.worst, share.total = max(share.worst, took), share.total + took

    gc.collect()
    gc.disable()  # the console itself freezes what is loaded at its start
    handle._run = timed  # type: ignore[method-assign]
    try:
        yield share
    finally:
        handle._run = run  # type: ignore[method-assign]
        gc.enable()


def main() -> None:
    """Print a row for each attack."""
    with tempfile.TemporaryDirectory() as folder, Live(Path(folder)) as live:
        assert live._thread.ident is not None
        for kind in STRANGERS:
            key = (live.viewer,) if kind in KEYED else ()
            command = [sys.executable, "-m", "tests.benchmarks.attacker", kind, str(live.port), *key]
            with watched(live._thread.ident) as share, subprocess.Popen(command) as attacker:
                time.sleep(ATTACK)
                attacker.kill()
            told = f"worst callback {1000 * share.worst:6.1f} ms, {1000 * share.total / ATTACK:5.0f} ms of a second"
            print_row(f"{kind:10}{told}")


if __name__ == "__main__":
    run_command(main)
