"""A whole session per driver: the console in processes of its own drives an emulated robot over a real wire.

`python -m tests.benchmarks.real_sessions [NAME …]`: the motion commands and FOLLOW WALL by REST, the way and the map
scored against the emulator's truth, and where there are microphones COME HERE by a voice in the room; the simulator
itself beside them under the same bounds. The machine's load stands in every line: sessions are real time.
"""

import csv
import io
import math
import os
import sys
import threading
import time
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import Any

import cv2
import msgspec
import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.robots.requests import FloorPlan
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.running_console import Console, console
from tests.emulators.robot_process import SPEAKER, RobotProcess, robot_process

TURN, WAY, PLACE = math.radians(5), 0.06, 0.12  # [rad], [m], [m] that a command may be off
DRIFT, WALLS, BESIDE = (
    0.08,
    0.05,
    0.90,
)  # [m] RMS of the way; [m] of a wall off its place; share of cells within twice
MARKS = 0.10  # [m] of a landmark from the nearest true corner or edge, median
COMING = 0.15  # [m] that COME HERE may be off its half metre
AT = (1.6, 0.9)  # [m] where the person stands, as seen from the start
LISTENING, COMING_IN = 4.0, 60.0  # [s]
SAMPLE = 0.2  # [s] between looks at pose and truth


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    words: str
    state: str
    error: float  # [m] or [rad]
    bound: float
    seconds: float

    @property
    def good(self) -> bool:
        """True when it was done within its bound."""
        return self.state == "done" and self.error <= self.bound


@dataclass
class Session:
    """A running console and the truth about its robot."""

    running: Console
    where: Callable[[], Pose]
    plan: Callable[[], FloorPlan]
    robot: RobotProcess | None  # None: the simulator itself
    errors: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])  # [m], [rad] along the way


SUBJECTS: dict[str, tuple[str, ...]] = {
    "sim": (),
    "foxglove": ("foxglove",),
    "zenoh": ("zenoh",),
    "rosbridge": ("rosbridge",),
    "serial+scip": ("serial", "scip"),
    "serial+lds": ("serial", "lds"),
    "srv1+scip+camera+audio": ("srv1", "scip", "camera", "audio"),
}


def motions(here: Session, follow: float = 20.0) -> Iterator[Row]:
    """TURN LEFT and RIGHT, CONTINUE, STOP AT, FOLLOW WALL and STOP MOVING by REST."""
    yield _turned(here, "turn left", math.pi / 2)
    yield _turned(here, "turn right", -math.pi / 2)
    yield _went(here, "continue 0.5 meters", 0.5)
    yield _reached(here, 1.0, 0.4)
    yield _followed(here, follow)


def _turned(here: Session, words: str, angle: float) -> Row:
    before = here.where()
    state, seconds = obey(here.running, words)
    return Row(words, state, abs(wrap(here.where().heading - before.heading - angle)), TURN, seconds)


def _went(here: Session, words: str, way: float) -> Row:
    before = here.where()
    state, seconds = obey(here.running, words)
    step = before.inverse() @ here.where()
    return Row(words, state, math.hypot(step.x - way, step.y), WAY, seconds)


def _reached(here: Session, x: float, y: float) -> Row:
    words = f"stop at {x} and {y}"
    state, seconds = obey(here.running, words)
    return Row(words, state, here.where().distance_to(x, y), PLACE, seconds)


def _followed(here: Session, seconds: float) -> Row:
    """Follow the wall for a while, then STOP → the way that is missing of 4 cm/s over that time."""
    here.running.answer("/api/commands", {"text": "follow wall"})
    way, last, end = 0.0, here.where(), time.monotonic() + seconds
    while time.monotonic() < end:
        here.running.get("/api/state")  # a sign of life
        time.sleep(0.25)
        place = here.where()
        way, last = way + place.distance_to(last.x, last.y), place
    here.running.answer("/api/commands", {"text": "stop moving"})
    time.sleep(0.5)
    stands = here.where()
    time.sleep(0.5)
    rolled = here.where().distance_to(stands.x, stands.y)
    state = "done" if rolled < 0.005 else f"rolled {rolled:.3f} m after STOP"
    return Row("follow wall, stop moving", state, max(0.0, 0.04 * seconds - way), 0.0, seconds)


def obey(running: Console, words: str, patience: float = 60.0) -> tuple[str, float]:
    """A command by REST → how it ended, and after how many seconds."""
    began = time.monotonic()
    entry = running.answer("/api/commands", {"text": words})
    while time.monotonic() - began < patience:
        newest = running.get("/api/commands/history?limit=5")["commands"]
        state, remark = next(
            ((one["state"], one["remark"]) for one in newest if one["id"] == entry["id"]), ("gone", "")
        )
        if state not in ("running", "accepted"):
            time.sleep(0.3)
            return state if state == "done" else f"{state}: {remark}", time.monotonic() - began
        time.sleep(0.1)
    return "no end", patience


def come_here(here: Session) -> Row:
    """A person in the room says it → how far from half a metre before them the robot ends."""
    assert here.robot is not None
    here.running.answer("/api/commands", {"text": "stop moving"})
    here.running.answer("/api/hearing", {"listen": True, "obey": True})
    x, y = AT
    here.robot.ask("place", x=x, y=y)
    time.sleep(LISTENING)
    known = here.running.get("/api/commands/history?limit=1")["commands"][0]["id"]
    began = time.monotonic()
    here.robot.ask("say", text="come here")
    state = "nothing was obeyed"
    while time.monotonic() - began < COMING_IN:
        time.sleep(0.2)
        newest = here.running.get("/api/commands/history?limit=1")["commands"][0]
        if newest["id"] > known and newest["state"] not in ("running", "accepted", "waiting"):
            done = newest["state"] == "done" and newest["name"] == "come_here"
            state = "done" if done else f"{newest['name']} {newest['state']}: {newest['remark']}"
            break
    else:
        heard = here.running.get("/api/hearing")["utterances"]
        state += "".join(f"; {one['words']!r} {one['reason']}" for one in heard[-2:])
    time.sleep(0.5)
    apart = here.where().distance_to(x, y)
    return Row(f"come here ({SPEAKER} speaks)", state, abs(apart - 0.5), COMING, time.monotonic() - began)


@contextmanager
def watched(here: Session) -> Iterator[None]:
    """The console's pose beside the true one, all the time."""
    over = threading.Event()

    def watch() -> None:
        while not over.wait(SAMPLE):
            told, true = here.running.get("/api/state").get("pose"), here.where()
            if told is None:
                continue  # a fault of the console, which is counted by its log
            apart = math.hypot(told["x_m"] - true.x, told["y_m"] - true.y)
            here.errors.append((apart, abs(wrap(told["heading_rad"] - true.heading))))

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    yield
    over.set()
    thread.join()


def scores(here: Session) -> Iterator[Row]:
    """The way, the occupancy grid and the landmarks against the truth."""
    apart = np.array([error for error, _ in here.errors])
    plan = here.plan()
    off = to_surfaces(occupied_cells(here.running), plan)
    within = float(np.mean(off < 2 * WALLS)) if len(off) else 0.0
    marks = to_surfaces(landmarks(here.running), plan)
    yield Row("way, RMS", "done", float(np.sqrt(np.mean(apart**2))), DRIFT, 0.0)
    yield Row("way, at the end", "done", float(np.median(apart[-5:])), DRIFT, 0.0)
    yield Row(f"walls, median of {len(off)}", "done" if len(off) > 100 else "no map", _median(off), WALLS, 0.0)
    yield Row(f"walls beyond {2 * WALLS} m, share", "done", 1 - within, 1 - BESIDE, 0.0)
    yield Row(f"landmarks, median of {len(marks)}", "done" if len(marks) else "none", _median(marks), MARKS, 0.0)


def _median(values: Array) -> float:
    return float(np.median(values)) if len(values) else math.inf


def occupied_cells(running: Console) -> Array:
    """(N, 2) [m], centres of occupied cells of the console's map."""
    with zipfile.ZipFile(io.BytesIO(running.download("/api/map"))) as packed:
        names = packed.namelist()
        pgm, text = (packed.read(next(name for name in names if name.endswith(end))) for end in (".pgm", ".yaml"))
    entries = dict(line.split(": ", 1) for line in text.decode().splitlines() if ": " in line)
    resolution = float(entries["resolution"])
    x0, y0 = (float(number) for number in entries["origin"].strip("[]").split(",")[:2])
    pixels = cv2.imdecode(np.frombuffer(pgm, np.uint8), cv2.IMREAD_GRAYSCALE)
    rows, columns = np.nonzero(pixels == 0)
    return np.column_stack((x0 + (columns + 0.5) * resolution, y0 + (len(pixels) - rows - 0.5) * resolution))


def landmarks(running: Console) -> Array:
    """(N, 2) [m], the console's landmarks."""
    rows = csv.DictReader(running.download("/api/landmarks.csv").decode().splitlines())
    return np.array([(float(row["x_m"]), float(row["y_m"])) for row in rows]).reshape(-1, 2)


def to_surfaces(points: Array, plan: FloorPlan) -> Array:
    """(N,) [m], from every point (N, 2) to the nearest true surface."""
    begins, ends = np.array(plan.segments)[:, :2], np.array(plan.segments)[:, 2:4]
    along = ends - begins
    share = ((points[:, None] - begins) * along).sum(2) / np.maximum((along**2).sum(1), 1e-12)
    nearest = begins + np.clip(share, 0, 1)[..., None] * along
    distances = np.linalg.norm(points[:, None] - nearest, axis=2).min(1, initial=math.inf)
    for x, y, radius, *_ in plan.circles:
        distances = np.minimum(distances, np.abs(np.hypot(*(points - (x, y)).T) - radius))
    return distances


def truth_of(running: Console) -> Callable[[], Pose]:
    """The simulator's own truth, asked of the console."""

    def where() -> Pose:
        told: Any = running.get("/api/sim/truth")
        return Pose(told["x_m"], told["y_m"], told["heading_rad"])

    return where


@contextmanager
def session(name: str) -> Iterator[Session]:
    """A console and its robot; the simulated robot itself where there are no wires."""
    kinds = SUBJECTS[name]
    with robot_process(*kinds) if kinds else nullcontext() as robot:
        url, environment = (robot.url, robot.environment) if robot else ("sim:lab", {})
        with console(auth=bool(robot), robot=url, environment=environment) as running:
            time.sleep(3.0)  # the robot looks around
            if robot is not None:
                yield Session(running, robot.truth, robot.plan, robot)
            else:
                plan = lambda: msgspec.convert(running.get("/api/sim/plan"), FloorPlan)  # noqa: E731
                yield Session(running, truth_of(running), plan, None)


def run(name: str, follow: float = 20.0) -> Iterator[Row]:
    """One subject's session, line by line."""
    with session(name) as here:
        with watched(here):
            yield from motions(here, follow)
        yield from scores(here)
        if "audio" in SUBJECTS[name]:
            yield come_here(here)
        faults = here.running.faults()
        sys.stderr.writelines(fault[:60] + fault[-600:] for fault in faults)
        yield Row("faults in the console's log", "done", float(len(faults)), 0.0, 0.0)


def main(names: Sequence[str] = tuple(SUBJECTS)) -> None:
    for name in names:
        for row in run(name):
            unit = "°" if row.bound == TURN else "m"
            error = math.degrees(row.error) if unit == "°" else row.error
            verdict = "ok" if row.good else "MISSED"
            print_row(
                f"{name:22} {row.words:28} {row.state:8} {error:7.3f} {unit}  {row.seconds:5.1f} s  {verdict}"
                f"  load {os.getloadavg()[0]:.1f}"
            )


if __name__ == "__main__":
    run_command(main)
