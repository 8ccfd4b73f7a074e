"""Rows of the history lost when the console is killed: `python -m tests.benchmarks.history_kills [--kills 20]`.

A console on the simulator gets commands by REST as fast as it answers; after a random time (0.5 to 3 s) all its
processes get SIGKILL. A row is lost when its command was answered and is not in the history of the next console.
"""

import contextlib
import http.client
import json
import random
import signal
import sqlite3
import tempfile
import threading
import time
from pathlib import Path

import psutil

from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.running_console import Console

WORDS = ("turn left", "turn right", "stop moving", "continue 0.1 meters", "nonsense")


def answered(port: int, numbers: list[int], over: threading.Event) -> None:
    """Send commands until it is over; `numbers` gets the id of each that was answered with one."""
    chance = random.Random(port)
    with contextlib.suppress(OSError, http.client.HTTPException, json.JSONDecodeError):
        line = http.client.HTTPConnection("127.0.0.1", port, timeout=5)
        while not over.is_set():
            body = json.dumps({"text": chance.choice(WORDS)})
            headers = {"Content-Type": "application/json", "Origin": f"http://127.0.0.1:{port}"}
            line.request("POST", "/api/commands", body, headers)
            answer = json.load(line.getresponse())
            if "id" in answer:
                numbers.append(answer["id"])


def kill(folder: Path, after: float) -> tuple[int, int]:
    """One console and its end → commands answered, and how many of them the file does not have."""
    console = Console(folder)
    numbers: list[int] = []
    over = threading.Event()
    threads = [threading.Thread(target=answered, args=(console.port, numbers, over)) for _ in range(2)]
    try:
        for thread in threads:
            thread.start()
        time.sleep(after)
        family = [psutil.Process(console.process.pid), *console.children]
        for process in family:
            with contextlib.suppress(psutil.NoSuchProcess):
                process.send_signal(signal.SIGKILL)
        over.set()
        for thread in threads:
            thread.join()
    finally:
        console.close()
    with contextlib.closing(sqlite3.connect(folder / "history.sqlite")) as store:
        newest_run = store.execute("SELECT max(run) FROM deeds").fetchone()[0]
        stored = {row[0] for row in store.execute("SELECT id FROM deeds WHERE run = ?", (newest_run,))}
    return len(numbers), len(set(numbers) - stored)


def main(*, kills: int = 20, seed: int = 0) -> None:
    chance = random.Random(seed)
    total, lost = 0, 0
    for _ in range(kills):
        with tempfile.TemporaryDirectory() as folder:
            given, missing = kill(Path(folder), chance.uniform(0.5, 3.0))
        total, lost = total + given, lost + missing
    print_row({"kills": kills, "answered": total, "lost": lost})


if __name__ == "__main__":
    run_command(main)
