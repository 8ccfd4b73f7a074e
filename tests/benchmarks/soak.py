"""Random orders for minutes on a running console: `python -m tests.benchmarks.soak [--seconds 600] [--seed 0]`.

`long_life` is the same for hours, by turns with a patrol, while every drive is recorded and viewers look on.

Typed, clicked, spoken in the simulated room and driven by hand, some contradicting each other within a moment, some
nonsense, with people who come and go, while a browser's socket looks on. Told: the trace checker's complaints, every
notice with how often it came, how orders ended and with which remarks, answers that are a server's error, and the
memory of every process, each minute.
"""

import contextlib
import json
import random
import re
import threading
import time
import urllib.error
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import psutil
from scipy.stats import theilslopes
from websockets.sync.client import connect

from core.gate import check, read_trace
from core.robots.requests import FloorPlan
from core.settings import Settings
from tests.benchmarks.command import run_command
from tests.benchmarks.real_sessions import occupied_cells, to_surfaces
from tests.benchmarks.running_console import Console, console, watch

TYPED = ("turn left", "turn right", "continue {x:.1f} meters", "stop at {x:.1f} and {y:.1f}", "stop moving", "fly",
         "follow wall", "come here", "follow me", "continue {far:.0f} meters", "")  # fmt: skip
SPOKEN = ("turn left", "turn right", "come here", "follow me", "stop moving", "the weather is fine today")
EVERY = 60.0  # [s] the memory is read
PATIENCE_S = 60.0  # with an answer, beside whatever else the machine does
DAY_S = 86_400.0
WARM_UP_MIN = 30  # of a long life, after which everything has been loaded
GROWING_FILES = ("recordings", "gate.csv")  # what the recording that runs and the measurement itself write
VIEWER_COUNT = 5  # of a long life, and one who reads nothing
PATROL = {"hall": (3.0, 2.0), "crossing": (8.0, -0.1), "corner": (11.4, 0.2)}  # [m] places of sim:floor
TURN_MIN = 5  # minutes of random orders, then as many of the patrol
CONTRADICTION = 0.3  # share of orders that another one follows at once
PAUSES = (0.2, 6.0)  # [s] between two orders


class Soak:
    """One operator with many ideas."""

    def __init__(self, running: Console, seed: int) -> None:
        self._running = running
        self._chance = random.Random(seed)
        self.answers: Counter[str] = Counter()
        self.notices: Counter[str] = Counter()
        self._seen: set[int] = set()
        self.over = threading.Event()

    def look_on(self) -> None:
        """A viewer: every notice that is ever shown."""
        origin = f"http://127.0.0.1:{self._running.port}"
        with connect(f"ws{origin[4:]}/ws", origin=origin, max_size=None, compression=None, proxy=None) as line:  # type: ignore[arg-type]
            while not self.over.is_set():
                message = line.recv(timeout=10)
                if not isinstance(message, str) or not message.startswith('{"kind":"state"'):
                    continue
                for notice in json.loads(message)["notices"]:
                    if notice["id"] not in self._seen:
                        self._seen.add(notice["id"])
                        self.notices[plain(notice["text"])] += 1

    def order(self) -> None:
        chance = self._chance
        how = chance.choice(("typed", "typed", "click", "say", "say", "people", "stop"))
        x, y = chance.uniform(-2.0, 2.0), chance.uniform(-2.0, 2.0)
        if how == "typed":
            text = chance.choice(TYPED).format(x=x, y=y, far=chance.uniform(5, 200))
            self._post("/api/commands", {"text": text})
        elif how == "click":
            self._post("/api/commands", {"text": f"stop at {x:.2f} and {y:.2f}"})
        elif how == "say":
            self._post("/api/sim/say", {"text": chance.choice(SPOKEN), "x_m": x, "y_m": y})
        elif how == "people":
            wish = {"what": "person", "id": chance.choice(("Ann", "Bob")), "x_m": x, "y_m": y}
            self._post("/api/sim/place", wish)
        else:
            self._post("/api/stop", {})

    def run(self, seconds: float) -> None:
        """Until the time is over."""
        self._post("/api/hearing", {"listen": True, "obey": True})
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.order()
            if self._chance.random() > CONTRADICTION:
                time.sleep(self._chance.uniform(*PAUSES))
            if not self._running.get("/api/hearing", PATIENCE_S)["obeying"]:
                self._post("/api/hearing", {"listen": True, "obey": True})

    def patrol(self, seconds: float) -> None:
        """A route round and round, with people who come, go and talk about the weather."""
        self._post("/api/routes/patrol/start", {"unattended": True})
        self._post("/api/route/resume", {})  # where an order paused it
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            x, y = self._chance.uniform(-1.0, 3.5), self._chance.uniform(1.5, 3.4)
            self._post("/api/sim/place", {"what": "person", "id": "Ann", "x_m": x, "y_m": y})
            self._post("/api/sim/say", {"text": SPOKEN[-1], "x_m": x, "y_m": y})
            time.sleep(min(left, self._chance.uniform(5.0, 15.0)))

    def begin_recording(self) -> None:
        """A new recording in the place of the last one."""
        self._post("/api/recordings/stop", {})
        for one in self._running.get("/api/recordings", PATIENCE_S)["recordings"]:
            self._running.delete(f"/api/recordings/{one['name']}")
        self._post("/api/recordings/start", {"name": "drive"})

    def prepare_patrol(self) -> None:
        """Name the places of the route."""
        for name, (x, y) in PATROL.items():
            self._running.answer("/api/places", {"name": name, "x_m": x, "y_m": y, "heading_rad": None})
        stops = [{"place": name, "wait_s": 2.0} for name in PATROL]
        self._running.answer("/api/routes", {"name": "patrol", "stops": stops, "loop": True})

    def _post(self, path: str, body: dict[str, Any]) -> None:
        try:
            status = str(self._running.post(path, body))
        except urllib.error.HTTPError as refused:
            status = str(refused.code)
        except OSError as trouble:
            status = f"599 {type(trouble).__name__}"
        self.answers[f"{path} {status}"] += 1


def plain(text: str) -> str:
    """A sentence without its numbers, so that equal ones are counted together."""
    return re.sub(r"-?\d+(\.\d+)?", "#", text)


def processes(running: Console) -> Iterator[tuple[str, psutil.Process]]:
    """Each process of the console, by what it is."""
    console = psutil.Process(running.process.pid)
    for one in (console, *console.children(recursive=True)):
        with contextlib.suppress(psutil.NoSuchProcess):
            words = one.cmdline()
            worker = next((word.partition("=")[2] for word in words if word.startswith("--worker=")), "")
            yield worker or (words[words.index("-m") + 1] if "-m" in words else "other"), one


def memory(running: Console) -> dict[str, float]:
    """[MB] of every process, by what it is."""
    told: Counter[str] = Counter()
    for name, one in processes(running):
        with contextlib.suppress(psutil.NoSuchProcess):
            told[name] += one.memory_info().rss / 1e6
    return dict(told)


def disk(folder: Path) -> dict[str, float]:
    """[MB] of the data folder, by its first level; the trace of the gate is the measurement's own."""
    told: Counter[str] = Counter()
    for path in folder.rglob("*"):
        with contextlib.suppress(OSError):
            if path.is_file():
                told[path.relative_to(folder).parts[0]] += path.stat().st_size / 1e6
    return dict(told)


def reading(running: Console, minute: int) -> dict[str, Any]:
    descriptors: Counter[str] = Counter()
    threads: Counter[str] = Counter()
    for name, one in processes(running):
        with contextlib.suppress(psutil.NoSuchProcess):
            descriptors[name] += one.num_fds()
            threads[name] += one.num_threads()
    plan = msgspec.convert(running.get("/api/sim/plan", PATIENCE_S), FloorPlan)
    off = to_surfaces(occupied_cells(running), plan)
    return {
        "minute": minute,
        "memory_mb": {name: round(value, 1) for name, value in memory(running).items()},
        "descriptors": dict(descriptors),
        "threads": dict(threads),
        "disk_mb": {name: round(value, 3) for name, value in disk(running.trace.parent).items()},
        "pose_error_m": running.get("/api/state", PATIENCE_S)["slam"]["error_m"],
        "walls": len(off),
        "walls_off_m": [round(float(value), 3) for value in np.percentile(off, (50, 90))] if len(off) else [],
        "route": running.get("/api/route", PATIENCE_S)["round"],
    }


def long_life(running: Console, seconds: float, seed: int) -> Iterator[dict[str, Any]]:
    """Orders and patrols by turns, recorded and looked at → a reading each minute; the last has all answers."""
    soak = Soak(running, seed)
    soak.prepare_patrol()
    with contextlib.ExitStack() as stack:
        watch(running, VIEWER_COUNT, stack)
        for minute in range(1, round(seconds / EVERY) + 1):
            if (minute - 1) % (2 * TURN_MIN) == 0:
                soak.begin_recording()
            if (minute - 1) // TURN_MIN % 2:
                soak.patrol(EVERY)
            else:
                soak.run(EVERY)
            yield {**reading(running, minute), "answers": dict(soak.answers)}


def rise(values: Sequence[float]) -> tuple[float, float, float]:
    """The robust slope of values that were read each minute, and its interval of 95 %, a day."""
    found = theilslopes(values, EVERY * np.arange(len(values)) / DAY_S, 0.95)
    return float(found.slope), float(found.low_slope), float(found.high_slope)


def main(*, seconds: float = 600.0, seed: int = 0) -> object:
    with console() as running:
        while running.get("/api/health")["reasons"]:
            time.sleep(0.1)
        soak = Soak(running, seed)
        looking = threading.Thread(target=soak.look_on)
        looking.start()
        minutes = []
        for _ in range(max(round(seconds / EVERY), 1)):
            soak.run(min(EVERY, seconds))
            minutes.append(memory(running))
        soak.over.set()
        looking.join()
        rows = running.get("/api/commands/history")["commands"]
        running.post("/api/stop")
        time.sleep(0.5)
        return {
            "seconds": seconds,
            "trace_complaints": check(read_trace(running.trace), Settings().limits),
            "answers": dict(soak.answers),
            "server_errors": {key: n for key, n in soak.answers.items() if " 5" in key and not key.endswith("503")},
            "notices": dict(soak.notices.most_common()),
            "ends": dict(Counter(f"{row['source']} {row['state']}" for row in rows)),
            "remarks": dict(Counter(plain(f"{row['state']}: {row['remark']}") for row in rows).most_common()),
            "memory_mb": {
                name: [round(minute.get(name, 0.0), 1) for minute in minutes]
                for name in sorted(set().union(*minutes))
            },
            "memory_of_all_mb": [round(sum(minute.values()), 1) for minute in minutes],
            "alive": running.process.poll() is None,
        }


if __name__ == "__main__":
    run_command(main)
