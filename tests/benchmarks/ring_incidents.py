"""What is kept by itself: `python -m tests.benchmarks.ring_incidents`.

A console on a simulated robot that stands for 90 s; then its bumper is pressed, and later it is halted. Printed as
JSON: of each recording that is kept its cause, the seconds in it before what caused it (at least 60), and the
recorder's share of a core while the robot rests.
"""

import json
import tempfile
import time
from pathlib import Path
from typing import Any

from core.recording.drive import DriveRecording, text_of
from tests.benchmarks.command import run_command
from tests.benchmarks.recorded_drive import recorder_of
from tests.benchmarks.running_console import Console

CONTACT_AFTER_S = 90.0  # of the robot's clock
HALT_PAUSE_S = 35.0  # after the first one: two incidents at once are one recording
PATIENCE_S = 120.0
EVENTS = {"recording.contact": "contact", "recording.halted": "gate"}  # code of the cause → the event


def kept(console: Console, count: int) -> list[dict[str, Any]]:
    """Wait for so many kept recordings → the list, the newest first."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        rows = [row for row in console.get("/api/recordings")["recordings"] if row["cause"] and row["complete"]]
        if len(rows) >= count:
            return rows
        time.sleep(1.0)
    raise TimeoutError(f"fewer than {count} recordings were kept")


def lead_s(folder: Path, row: dict[str, Any]) -> dict[str, Any]:
    """How long before what caused it a recording begins [s]."""
    drive = DriveRecording(folder / "recordings" / f"{row['name']}.mcap")
    wanted = EVENTS.get(row["code"], "trip")
    times = [one.logged for one in drive.every("/beckon/events") if json.loads(text_of(one))["event"] == wanted]
    drive.close()
    lead = times[-1] - drive.start if times else 0.0
    return {"cause": row["cause"], "seconds": round(row["seconds"], 1), "before_s": round(lead, 1)}


def main() -> object:
    """Wait, be touched, be halted."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        console = Console(folder, robot=f"sim:lab?faults=bumper,after:{CONTACT_AFTER_S:g}")
        try:
            kept(console, 1)
            recorder = recorder_of(console)
            spent, began = sum(recorder.cpu_times()[:2]), time.monotonic()
            time.sleep(HALT_PAUSE_S)
            share = (sum(recorder.cpu_times()[:2]) - spent) / (time.monotonic() - began)
            console.post("/api/halt")
            rows = kept(console, 2)
        finally:
            console.close()
        report = {"recorder_core_percent": round(100 * share, 1), "kept": [lead_s(folder, row) for row in rows]}
        return {**report, "faults": console.faults()}


if __name__ == "__main__":
    run_command(main)
