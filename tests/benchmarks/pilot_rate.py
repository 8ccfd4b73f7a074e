"""Whether the pilot keeps its 40 Hz while people watch: `python -m tests.benchmarks.pilot_rate [--viewers 5]`.

Lateness is how much later than the quickest of the last ten seconds a frame reached the pilot. The age of a state is
counted at a viewer from the instant of sensing, over the quickest state of the whole time. The robot obeys commands
meanwhile. With `--talk` someone beside it talks of something else all the time, and it is read, or unread. Figures go
to reports/pilot_rate.json.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import multiprocessing
import time
from typing import Annotated

import psutil
from websockets.asyncio.client import connect

from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import console

MOUTH = (1.2, 0.9)  # [m] where they stand
LOADED = 8.0  # [s] until the recognizer is loaded
TALKS = 3.9  # [s] a sentence lasts, and a breath
TALK = "the weather was rather nice yesterday and we went to the lake"
WORDS = ("turn left", "continue 1 meter", "turn right", "continue 1 meter", "turn right")


def look_on(port: int, viewers: int, seconds: float, told: multiprocessing.SimpleQueue[list[float]]) -> None:
    """So many viewers of state and camera in one process → the ages [ms] of the states they received."""

    async def one() -> list[float]:
        late: list[float] = []
        url, origin = f"ws://127.0.0.1:{port}/ws", f"http://127.0.0.1:{port}"
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds), connect(url, origin=origin, compression=None) as line:  # type: ignore[arg-type]
                async for message in line:
                    if isinstance(message, str) and '"state"' in message[:20]:
                        late.append(time.monotonic() - json.loads(message)["stamp_s"])
        return late

    async def all_of_them() -> list[float]:
        seen = await asyncio.gather(*(one() for _ in range(viewers)))
        quickest = min(min(each) for each in seen)
        return [1000 * (moment - quickest) for each in seen for moment in each]

    told.put(asyncio.run(all_of_them()))


def part(values: list[float], share: float) -> float:
    """The value that `share` of them do not exceed."""
    return round(sorted(values)[min(int(share * len(values)), len(values) - 1)], 1)


def campaign(viewers: int, seconds: float, talk: str) -> dict[str, object]:
    """One console, some viewers, commands one after the other; `talk`: "read" | "unread" | "" for none."""
    told: multiprocessing.SimpleQueue[list[float]] = multiprocessing.SimpleQueue()
    turn = 0
    with console() as running:
        while running.get("/api/health")["reasons"]:
            time.sleep(0.1)
        if talk:
            running.post("/api/sim/place", {"what": "person", "id": "Ann", "x_m": MOUTH[0], "y_m": MOUTH[1]})
            running.post("/api/hearing", {"listen": talk == "read", "obey": False})
            time.sleep(LOADED)
        watching = multiprocessing.Process(target=look_on, args=(running.port, viewers, seconds, told))
        watching.start()
        processes = {"console": psutil.Process(running.process.pid)}
        for child in running.children:
            processes["gate" if "gate" in " ".join(child.cmdline()) else "driver"] = child
        for process in processes.values():
            process.cpu_percent()
        ends, late, steps = time.monotonic() + seconds, [], []
        silent = 0.0  # from when on [s] nobody talks
        while time.monotonic() < ends - 3.0:
            if running.get("/api/state")["command"] is None or turn == 0:
                running.post("/api/commands", {"text": WORDS[turn % len(WORDS)]})
                turn += 1
            if talk and time.monotonic() > silent:
                running.post("/api/sim/say", {"text": TALK, "id": "Ann"})
                silent = time.monotonic() + TALKS
            time.sleep(2.0)
            health = running.get("/api/health")
            late.append(health["pilot_late_ms"]["p99"])
            steps.append(health["pilot_step_ms"]["p99"])
        busy = {name: round(process.cpu_percent()) for name, process in processes.items()}
        ages = told.get()
        watching.join()
    return {
        "viewers": viewers,
        "talk": talk,
        "seconds": seconds,
        "pilot_late_p99_ms": {"median": part(late, 0.5), "worst_ten_seconds": max(late)},
        "pilot_step_p99_ms": part(steps, 0.5),
        "state_age_ms": {"p50": part(ages, 0.5), "p99": part(ages, 0.99), "states": len(ages)},
        "states_per_second_and_viewer": round(len(ages) / viewers / seconds, 1),
        "processor_percent": busy,
    }


def main(*, viewers: int = 5, seconds: float = 60.0, talk: Annotated[str, ("read", "unread")] = "") -> object:
    return campaign(viewers, seconds, talk)


if __name__ == "__main__":
    run_command(main)
