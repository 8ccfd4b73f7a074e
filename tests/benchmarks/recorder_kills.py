"""Recordings whose process is killed: `python -m tests.benchmarks.recorder_kills [--recorder 50] [--console 50]`.

The recorder: a process writes readings and is killed (SIGKILL) at a random instant; the file that is left is
recovered, and all that was written more than a second before has to be in it. The console: `beckon run` is killed
while it records; its recorder finishes the file, or the next start recovers it. Printed as JSON.
"""

import contextlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from core.geometry import Pose
from core.recording.mcap_recovery import recovered
from core.recording.mcap_writing import PART, McapRecording
from core.recording.ros_writing import RosEncoder
from core.sensors import SensorFrame, Wheels
from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import Console

BATCH_PERIOD_S = 0.05
LONGEST_S, SHORTEST_S = 2.5, 0.3  # until a recorder is killed
KEPT_AGE_S = 1.0  # from which a message must be there
RECOVERY_S = 60.0  # in which the next start has recovered a recording


def write_until_killed(path: Path) -> None:
    """Write readings as they come, for ever; every tenth batch nothing comes for a while."""
    recording, encoder = McapRecording(path), RosEncoder()
    number = 0
    while True:
        number += 1
        now = time.time()
        frame = SensorFrame(stamp=now, wheels=Wheels(odometry=Pose(number * 1e-3, 0, 0), speed=0.1, turn_rate=0.0))
        if number % 20 < 12:
            recording.add(encoder.readings(frame), now)
            with (path.parent / "written").open("ab") as told:
                told.write(b"%.6f\n" % now)
        recording.flush_when_due()
        time.sleep(BATCH_PERIOD_S)


def killed_recorder(chance: random.Random) -> dict[str, Any]:
    """Kill one recorder → how many of the messages that had to be there are missing."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        command = [sys.executable, "-m", "tests.benchmarks.recorder_kills", "--write", str(path)]
        child = subprocess.Popen(command, cwd=Path(__file__).parents[2])
        while not (path.parent / "written").exists():
            time.sleep(0.01)
        lived = chance.uniform(SHORTEST_S, LONGEST_S)
        time.sleep(lived)
        killed = time.time()
        child.kill()
        child.wait()
        due = [float(line) for line in (path.parent / "written").read_text().splitlines() if line]
        due = [one for one in due if killed - one > KEPT_AGE_S]
        whole = recovered(path.with_name(path.name + PART), {})
        times = set[int]()
        if whole is not None:
            with whole.path.open("rb") as file:
                times = {message.log_time // 1000 for _, _, message in make_reader(file).iter_messages()}
        missing = [one for one in due if not {round(one * 1e6) + off for off in (-1, 0, 1)} & times]
        return {"lived_s": round(lived, 2), "due": len(due), "missing": len(missing)}


def killed_consoles(chance: random.Random, count: int) -> Iterator[dict[str, Any]]:
    """Kill one console after another while it records, in one data folder → how much of its end [s] each lacks."""
    with tempfile.TemporaryDirectory() as folder:
        console = Console(Path(folder))
        try:
            for number in range(count):
                console.answer("/api/recordings/start", {"name": f"drive {number}"})
                time.sleep(chance.uniform(SHORTEST_S, LONGEST_S))
                killed = time.time()
                os.kill(console.process.pid, signal.SIGKILL)
                console.close()
                console = Console(Path(folder))
                lost = killed - kept_until(console, f"drive {number}")
                yield {"lost_s": round(lost, 2), "missing": int(lost > KEPT_AGE_S)}
        finally:
            console.close()


def kept_until(console: Console, name: str) -> float:
    """Unix time [s] of the last message of a recording when it is whole; 0 where it does not become so."""
    end = time.monotonic() + RECOVERY_S
    while time.monotonic() < end:
        rows: list[dict[str, Any]] = []
        with contextlib.suppress(TimeoutError):  # on a busy computer the recorder's process takes a while to start
            rows = console.get("/api/recordings")["recordings"]
        if whole := [row["started_s"] + row["seconds"] for row in rows if row["name"] == name and row["complete"]]:
            return whole[0]
        time.sleep(0.3)
    return 0.0


def shown(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """All rows, each of which is shown when it is there: the whole takes long."""
    found = list[dict[str, Any]]()
    for row in rows:
        found.append(row)
        sys.stderr.write(f"{row}\n")
    return found


def main(
    *,
    recorder: int = 50,
    console: int = 50,
    seed: int = 0,
    write: Path | None = None,  # be the recorder that is killed
) -> object:
    if write is not None:
        write_until_killed(write)
    chance = random.Random(seed)
    recorders = shown(killed_recorder(chance) for _ in range(recorder))
    consoles = shown(killed_consoles(chance, console))
    report = {
        name: {
            "kills": len(rows),
            "due": sum(row.get("due", 1) for row in rows),
            "missing": sum(row["missing"] for row in rows),
        }
        for name, rows in (("recorder", recorders), ("console", consoles))
    }
    return {**report, "consoles": consoles}


if __name__ == "__main__":
    run_command(main)
