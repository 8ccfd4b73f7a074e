"""What following a person costs: `python -m tests.benchmarks.following_load [--seconds 30] [--engine pose|drawn]`.

A whole console on the simulator. It stands for a while and turns by command for a while; then Ann speaks, FOLLOW ME
is obeyed, and she walks to and fro at 0.2 m/s. Share of a core by each process (the console's holds the pilot; the
worker's the networks), and the p99 of the pilot's step, standing, turning and following.
"""

import contextlib
import os
import tempfile
import time
from collections.abc import Sequence
from typing import Annotated, Any

import psutil

from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import Console, console

START, TURNS = (2.0, 0.0), [(3.0, 0.3), (2.6, -0.3)]  # [m] where she stands, and between which she walks
WAKE, HEARD = 40.0, 10.0  # [s]
KINDS = {"core.robots.process": "driver", "core.gate.process": "gate", "console.workers.process": "worker"}


def until(true: Any, seconds: float, what: str) -> Any:
    """Wait → what it then is."""
    end = time.monotonic() + seconds
    while not (value := true()):
        if time.monotonic() > end:
            raise SystemExit(f"{what} did not come in {seconds:g} s.")
        time.sleep(0.1)
    return value


def named(running: Console) -> dict[str, psutil.Process]:
    """The processes of a console by what they do."""
    found = {"console": psutil.Process(running.process.pid)}
    for child in psutil.Process(running.process.pid).children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):
            words = " ".join(child.cmdline())
            kind = next((name for mark, name in KINDS.items() if mark in words), "")
            if kind:
                found[kind] = child
    return found


def load(running: Console, seconds: float, words: tuple[str, ...] = ()) -> dict[str, Any]:
    """Shares of a core [%], and the pilot's figures, over some time; `words` are commanded in turn meanwhile."""
    processes = named(running)
    before = {name: sum(process.cpu_times()[:2]) for name, process in processes.items()}
    began, ends = time.monotonic(), time.monotonic() + seconds
    steps: list[float] = []
    states: dict[str, int] = {}
    while time.monotonic() < ends:
        time.sleep(1.0)
        with contextlib.suppress(OSError):
            running.post("/api/lease", {"do": "renew"})
        if words and running.get("/api/state")["command"] is None:
            running.post("/api/commands", {"text": words[len(steps) % len(words)]})
        steps.append(running.get("/api/health")["pilot_step_ms"]["p99"])
        person = running.get("/api/state")["person"]
        state = "nobody" if person is None else "+".join(person["used"]) or person["state"]
        states[state] = states.get(state, 0) + 1
    spent = time.monotonic() - began
    busy: dict[str, float] = {}
    for name, process in processes.items():
        with contextlib.suppress(psutil.NoSuchProcess):
            busy[name] = round(100 * (sum(process.cpu_times()[:2]) - before[name]) / spent, 1)
    return {
        "core_percent": busy,
        "step_p99_ms": {"median": sorted(steps)[len(steps) // 2], "worst": max(steps)},
        "person": states,
    }


def newest(running: Console) -> dict[str, Any]:
    rows = running.get("/api/commands/history")["commands"]
    return next(row for row in rows if row["name"] == "follow_me")


def follow(running: Console, seconds: float) -> dict[str, Any]:
    """Stand, then follow."""
    until(lambda: not running.get("/api/health")["reasons"], WAKE, "the robot")
    until(lambda: not running.get("/api/state")["slam"]["looking_around"], WAKE, "the first look around")
    ann = {"what": "person", "id": "Ann", "x_m": START[0], "y_m": START[1], "heading_rad": 3.1, "clothes": "red/blue"}
    running.post("/api/sim/place", dict(ann))
    time.sleep(2.0)
    standing = load(running, seconds)
    turning = load(running, seconds, ("turn left", "turn right"))
    running.post("/api/commands", {"text": "stop"})
    running.post("/api/sim/say", {"text": "come on, follow me please", "id": "Ann"})
    until(lambda: (running.get("/api/state")["ears"] or {}).get("voices"), HEARD, "a voice")
    running.post("/api/commands", {"text": "follow me"})
    until(
        lambda: running.get("/api/state")["person"] is not None or newest(running)["state"] != "running",
        HEARD,
        "a person",
    )
    if newest(running)["state"] != "running":
        raise SystemExit(newest(running)["remark"])
    running.post("/api/sim/place", {**ann, "path_m": TURNS, "speed_m_s": 0.2, "again": True})
    time.sleep(1.0)
    following = load(running, seconds)
    return {
        "standing": standing,
        "turning": turning,
        "following": following,
        "command": {key: newest(running)[key] for key in ("state", "remark")},
    }


def main(*, seconds: float = 30.0, engine: Sequence[Annotated[str, ("pose", "drawn")]] = ()) -> object:
    report: dict[str, Any] = {"load_of_the_machine": round(os.getloadavg()[0], 1)}
    with tempfile.TemporaryDirectory() as nothing:
        for kind in engine or ("pose", "drawn"):
            hidden = {} if kind == "pose" else {"XDG_DATA_HOME": nothing}  # without the networks
            with console(environment=hidden) as running:
                report[kind] = follow(running, seconds)
    return report


if __name__ == "__main__":
    run_command(main)
