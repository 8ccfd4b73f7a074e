"""Routes in sim:floor with two people walking: `python -m tests.benchmarks.routes --routes 10 --faults 1 --seed 1`.

The console with its robot, gate and pilot in this process and in lock step, as fast as the processor can (`--share`
of it at most), camera and ears off, 0.5 m/s at most; see `stepped.py`. The map is the true floor plan, read as one of
Nav2. Each route has six random stops, always the nearest one next; a zone to keep out of and a slow one lie on the
way. Printed: the stops reached, or how the route ended; contacts, by the bumper and by truth, with what led to each
and how many came to a robot that stood; and, by truth, frames with its middle in the keep-out zone (of those near
it), and with a faster setpoint of the gate in the slow one than it allows (of those in it): null where no route led
there. With `--faults N` each fault is injected N times into a patrol, while the robot moves: its state and reason,
the gate's speed when it ended, and how far the robot went in the half second in which it brakes and in the ten
after it; a table at the end has those first that did not end as the how-to on routes states (`ENDS`). First the robot
is put into the zone to keep out of and against a wall: a check that does not see that ends the benchmark.
"""

import io
import math
import tempfile
import time
import zipfile
from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np

from console.maps.routes import RouteRun, RouteService
from core.geometry import Pose
from core.pilot import Pilot
from core.pipelines.nav2_map import map_yaml, pgm
from core.sensors import SensorFrame
from core.sentences import Statement, plain
from core.settings import Settings
from core.simulation.settings import SimulationSettings
from core.simulation.world import Thing, world_named
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.submap import SubmapSettings
from core.snapshot import Snapshot
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.place_names import NAMES
from tests.benchmarks.stepped import step_time, stepped_console
from tests.console.in_process import SteppedClock

SETTINGS = Settings(
    simulation=SimulationSettings(camera=False, microphones="none", cruise=0.5, max_speed=0.5),
    submaps=SubmapSettings(pieces=5.0),  # closures are sought at an eighth of the pace
)
CELL_M, STOP_ROOM_M, EDGE_M = 0.05, 0.4, 8.0
WALL_PIXEL, UNKNOWN_PIXEL, FREE_PIXEL = 0, 205, 254  # of a map of Nav2
STOPS, PLACES, SLOW_M_S = 6, 10, 0.1
ROUTE_S, BRAKING_S, STILL_S = 900.0, 0.5, 10.0  # of the robot's clock
PEOPLE_WAYS_M = (((2.0, 7.5), (10.0, 7.5)), ((11.7, 1.0), (11.7, 6.5)))  # [m] ways to and fro, in the corridors
WALK_M_S = 0.4
FOUND_M, KIDNAP_M = 0.3, 3.0  # off its place at most; carried at least
FINDING_S = 5.0  # that a robot may look for its place before a person helps
STOOD_M = 0.001  # that a robot which stands is moved at most
BLOCK_M = 1.5  # before the stop on which a box appears, at least
AT_THE_LAST_STOP = (plain(Statement("routes.done")), plain(Statement("routes.over")))
BEFORE_FRAMES, STOOD_FRAMES = 40, 5  # that are printed with a contact; in which a robot has not moved that stood
NEAR_M = 1.0  # beside the zone to keep out of
WALL_Y_M = -0.75  # the side of the corridor at the zone
KEEP_OUT_ZONE_M = ((5.0, -0.6), (6.0, -0.6), (6.0, -0.1), (5.0, -0.1))
SLOW_ZONE_M = ((7.5, -1.0), (9.5, -1.0), (9.5, 1.0), (7.5, 1.0))


class WatchedPilot(Pilot):
    """A pilot whose battery is what the benchmark says, and of which every frame is looked at."""

    battery: float | None = None
    look: Callable[[Snapshot], None] | None = None

    def step(self, frame: SensorFrame, **how: Any) -> Snapshot:
        snapshot = super().step(frame, **how)
        if self.look is not None:
            self.look(snapshot)
        return replace(snapshot, battery=self.battery)


class Drive:
    """A console in which routes are driven, and what is watched meanwhile."""

    def __init__(self, folder: Path, seed: int, clock: SteppedClock, share: float) -> None:
        self.live = stepped_console(folder, "sim:floor", clock, share=share, settings=SETTINGS, seed=seed)
        self.live.runtime._make_pilot = lambda: WatchedPilot(self.live.robot.profile, SETTINGS)
        self.chance = np.random.default_rng(seed)
        self.sums: Counter[str] = Counter()
        self.attended = False  # its owner gives a sign of life with every frame
        self._touching = False
        self._before: deque[dict[str, Any]] = deque(maxlen=BEFORE_FRAMES)  # a contact
        self._names = iter(NAMES)
        self.places: dict[str, tuple[float, float]] = {}

    def ask(self, method: str, path: str, body: Any = None, status: int = 200) -> Any:
        """One request that must succeed."""
        answer = self.live.ask(method, path, body, token=self.live.operator)
        assert answer.status == status, answer.body
        return answer.json if answer.body else None

    def prepare(self) -> None:
        """Load the plan as a map, name places, draw zones, let people walk."""
        live = self.live
        live.until(lambda: not live.runtime.snapshot.slam.looking_around, 60)
        self.check_looks()
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as box:
            for name, content in true_map().items():
                box.writestr(name, content)
        kind = {"Content-Type": "application/zip"}
        answer = live.ask(
            "POST", "/api/maps/import?name=plan", raw=packed.getvalue(), token=live.operator, headers=kind
        )
        assert answer.status == 201, answer.body
        self.ask("POST", "/api/maps/plan/load", {}, 202)
        live.until(lambda: live.runtime.snapshot.floor.lost, 60)
        self.ask("POST", "/api/slam/here", {"x_m": 0.0, "y_m": 0.0, "heading_rad": 0.0, "force": True}, 202)
        live.until(lambda: live.runtime.snapshot.floor.lost is None, 120)
        for name, kind_, points, speed in (
            ("hole", "keep_out", KEEP_OUT_ZONE_M, None),
            ("calm", "slow", SLOW_ZONE_M, SLOW_M_S),
        ):
            zone = {"name": name, "kind": kind_, "points_m": [list(one) for one in points], "max_speed_m_s": speed}
            self.ask("POST", "/api/zones", zone, 201)
        for spot in stops(self.chance):
            name = next(self._names)
            self.ask("POST", "/api/places", {"name": name, "x_m": spot[0], "y_m": spot[1]}, 201)
            self.places[name] = spot
        for (x, y), (to_x, to_y) in PEOPLE_WAYS_M:
            body = {"what": "person", "x_m": x, "y_m": y, "path_m": [[to_x, to_y], [x, y]], "speed_m_s": WALK_M_S}
            self.ask("POST", "/api/sim/place", {**body, "again": True}, 201)

    def look(self, snapshot: Snapshot) -> None:
        """Count what is true of one frame."""
        self.keep_owner(snapshot)
        assert snapshot.truth is not None
        at = snapshot.truth.x, snapshot.truth.y
        self.sums["frames"] += 1
        self.note(snapshot.truth)
        touching = snapshot.contact or self._before[-1]["gap_m"] < 0.0
        if touching and not self._touching:
            self.sums["contacts"] += 1
            self.sums["contacts_standing"] += self.stood
            self.print_what_led_to("contact")
        self._touching = touching
        self.sums["near_keep_out"] += within(KEEP_OUT_ZONE_M, *at, NEAR_M)
        self.sums["in_keep_out"] += within(KEEP_OUT_ZONE_M, *at)
        in_slow = within(SLOW_ZONE_M, *at)
        too_fast = in_slow and abs(self.live.robot.status().v) > SLOW_M_S + 1e-6
        self.sums["in_slow"] += in_slow
        self.sums["too_fast_in_slow"] += too_fast
        if too_fast:
            self.print_what_led_to("too fast")

    def print_what_led_to(self, what: str) -> None:
        """The last seconds of the robot, by truth and by estimate, its setpoint, the people and the nearest thing."""
        print_row({"what": what, "robot_stood": self.stood, "before": list(self._before)})

    @property
    def stood(self) -> bool:
        """True where the robot has not moved for a while: whatever touches it came to it."""
        last = list(self._before)[-STOOD_FRAMES:]
        ways = [math.dist(one["robot"][:2], last[-1]["robot"][:2]) for one in last]
        return max(ways) <= STOOD_M and all(one["gate"] == [0.0, 0.0] for one in last)

    def note(self, true: Pose) -> None:
        """Remember a frame."""
        robot = self.live.robot.robot
        world, status = robot._world, self.live.robot.status()  # type: ignore[attr-defined]
        people = [one.pose for one in self.people]
        believed = self.live.runtime.snapshot.estimate.pose
        self._before.append(
            {
                "s": round(self.live.robot.now, 2),
                "robot": [round(value, 3) for value in (true.x, true.y, true.heading)],
                "believed": [round(value, 3) for value in (believed.x, believed.y, believed.heading)],
                "gate": [round(status.v, 3), round(status.w, 3)],
                "limit": status.limit_v,
                "blocked_by": status.blocked_by,
                "gap_m": round(world.distance(true.x, true.y) - self.live.robot.profile.radius, 3),
                "people": [[round(one.x, 3), round(one.y, 3), round(one.heading, 2)] for one in people],
            }
        )

    def keep_owner(self, _: Snapshot) -> None:
        """Whoever drives is there, where somebody is to be."""
        lease = self.live.runtime.lease
        if self.attended and lease.holder is not None:
            lease.active(lease.holder, time.monotonic())

    def watch(self, watched: bool) -> None:
        """Look at every frame from now on, or at none."""
        pilot = self.live.runtime.dispatcher.pilot
        pilot.look = self.look if watched else self.keep_owner  # type: ignore[union-attr]

    def check_looks(self) -> None:
        """Show that a robot in the zone to keep out of and one that touches a wall are counted."""
        base = self.live.robot.robot._base  # type: ignore[attr-defined]
        before, (x, low), (_, high) = base.pose, KEEP_OUT_ZONE_M[0], KEEP_OUT_ZONE_M[2]
        self.watch(True)
        for y, count in (((low + high) / 2, "in_keep_out"), (WALL_Y_M + self.live.robot.profile.radius, "contacts")):
            base.carry(Pose(x + 0.5, y, 0.0))
            base.contact = count == "contacts"  # lasts only where the robot has no room
            assert self.comes_to(lambda count=count: self.sums[count], 5.0), f"{count}: the benchmark is blind"
        self.watch(False)
        base.carry(before)
        self.sums.clear()

    def comes_to(self, is_so: Callable[[], Any], seconds: float) -> bool:
        """Wait until something is the case, `seconds` of the robot at most."""
        begun = self.live.robot.now
        while not is_so():
            if self.live.robot.now > begun + seconds:
                return False
            time.sleep(0.01)
        return True

    @property
    def run(self) -> RouteRun:
        """The route under way."""
        run = self.live.runtime.parts[RouteService].run_now
        assert run is not None
        return run

    def route(self, number: int, *, loop: bool = False, unattended: bool = True) -> None:
        """Start a route of six random stops."""
        chosen = self.in_order([str(one) for one in self.chance.permutation(list(self.places))[:STOPS]])
        name = f"route {number}"
        body = {"name": name, "stops": [{"place": one} for one in chosen], "loop": loop, "replace": True}
        self.ask("POST", "/api/routes", body, 201)
        self.attended = not unattended
        self.ask("POST", f"/api/routes/route%20{number}/start", {"unattended": unattended}, 202)

    def in_order(self, names: list[str]) -> list[str]:
        """The first of these places, and always the nearest one next."""
        ordered, left = names[:1], names[1:]
        while left:
            here = self.places[ordered[-1]]
            left.sort(key=lambda name: math.dist(here, self.places[name]))
            ordered.append(left.pop(0))
        return ordered

    def put_right(self) -> None:
        """A person says where the robot is, where it has not found its place by itself, and carries it if need be."""
        self.comes_to(lambda: self.is_right, FINDING_S)
        for spot in [None, *self.places.values()]:
            if self.is_right:
                return
            if spot is not None:
                self.ask("POST", "/api/sim/place", {"what": "robot", "x_m": spot[0], "y_m": spot[1]}, 201)
                self.comes_to(lambda: False, 1.0)
            true = self.live.runtime.snapshot.truth
            here = {"x_m": true.x, "y_m": true.y, "heading_rad": math.remainder(true.heading, math.tau)}
            self.live.ask("POST", "/api/slam/here", {**here, "force": True}, token=self.live.operator)
            self.comes_to(lambda: self.is_right, 2 * FINDING_S)

    @property
    def is_right(self) -> bool:
        """True where the robot knows its place, by truth."""
        snapshot = self.live.runtime.snapshot
        off = snapshot.estimate.pose.distance_to(snapshot.truth.x, snapshot.truth.y)
        return snapshot.floor.lost is None and off < FOUND_M

    def end(self) -> None:
        """Whatever runs ends."""
        self.live.ask("POST", "/api/route/stop", {}, token=self.live.operator)

    def under_way(self) -> dict[str, object]:
        """What a route does that has not ended."""
        snapshot, run = self.live.runtime.snapshot, self.run
        under, true, to = snapshot.active_command, snapshot.truth, self.places[run.here.place]
        return {
            "tries": run.tries,
            "robot": [round(value, 2) for value in (true.x, true.y, true.heading)],
            "to": to,
            "command_s": None if under is None else round(snapshot.stamp - under.stamp),
            "remark": None if under is None else under.remark,
            "path_m": [[round(x, 2), round(y, 2)] for x, y in snapshot.path[::10].tolist()],
            "people": [[round(one.pose.x, 2), round(one.pose.y, 2)] for one in self.people],
        }

    @property
    def people(self) -> list[Thing]:
        """Those who walk."""
        world = self.live.robot.robot._world  # type: ignore[attr-defined]
        return [one for one in world.things if one.what == "person"]

    def moved_after(self) -> dict[str, float]:
        """How far [m] the robot goes while it brakes from now on, and how far after that, by truth."""
        base, robot = self.live.robot.robot._base, self.live.robot  # type: ignore[attr-defined]
        speed, begun, first = robot.status().v, robot.now, base.pose
        self.comes_to(lambda: robot.now > begun + BRAKING_S, BRAKING_S)
        braked = base.pose
        self.comes_to(lambda: False, STILL_S)
        gaps = first.distance_to(braked.x, braked.y), braked.distance_to(base.pose.x, base.pose.y)
        return {"gate_m_s": speed, "braked_m": round(gaps[0], 3), "moved_after_m": round(gaps[1], 4)}


def within(zone: tuple[tuple[float, float], ...], x: float, y: float, margin: float = 0.0) -> bool:
    """Return whether (x, y) lies in a rectangle, or at most `margin` [m] beside it."""
    (left, bottom), (right, top) = zone[0], zone[2]
    return left - margin < x < right + margin and bottom - margin < y < top + margin


def true_map() -> dict[str, bytes]:
    """The true floor plan as a map of Nav2."""
    world = world_named("floor")
    corners, obstacles = world.walls.reshape(-1, 2), world.obstacles
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    low = np.floor(low / CELL_M) * CELL_M
    columns, rows = np.ceil((high - low) / CELL_M).astype(int)
    pixels = np.full((rows, columns), UNKNOWN_PIXEL, np.uint8)

    def cell(x: float, y: float) -> tuple[int, int]:
        return int((x - low[0]) / CELL_M), int((y - low[1]) / CELL_M)

    for left, bottom, right, top in obstacles.faces.tolist():
        cv2.line(pixels, cell(left, bottom), cell(right, top), WALL_PIXEL)
    for x, y, radius in obstacles.posts.tolist():
        cv2.circle(pixels, cell(x, y), round(radius / CELL_M), WALL_PIXEL, cv2.FILLED)
    _, parts = cv2.connectedComponents((pixels != WALL_PIXEL).astype(np.uint8), connectivity=4)
    column, row = cell(0.0, 0.0)
    pixels[parts == parts[row, column]] = FREE_PIXEL  # where the robot can come
    grid = OccupancyGrid(revision=1, resolution=CELL_M, origin=low, log_odds=np.zeros((rows, columns), np.float32))
    return {"map.yaml": map_yaml(grid, "map.pgm", "trinary").encode(), "map.pgm": pgm(pixels[::-1])}


def stops(chance: np.random.Generator) -> list[tuple[float, float]]:
    """Random places with room around them, to walls and to the zone to keep out of."""
    world, found = world_named("floor"), list[tuple[float, float]]()
    while len(found) < PLACES:
        x, y = float(chance.uniform(-2.5, 12.2)), float(chance.uniform(-1.0, EDGE_M))
        apart = all(math.hypot(x - a, y - b) > 1.0 for a, b in found)
        if apart and world.free(x, y, STOP_ROOM_M) and not within(KEEP_OUT_ZONE_M, x, y, STOP_ROOM_M):
            found.append((round(x, 2), round(y, 2)))
    return found


def block(drive: Drive) -> None:
    """A box stands on the stop that is driven to."""
    run = drive.run

    def is_blocked() -> bool:
        (x, y), true = drive.places[run.here.place], drive.live.runtime.snapshot.truth
        if run.command is None or true.distance_to(x, y) <= BLOCK_M:
            return False
        box = {"what": "box", "x_m": x, "y_m": y, "size_m": 0.5, "heading_rad": 0.0, "id": "box"}
        return drive.live.ask("POST", "/api/sim/place", box, token=drive.live.operator).status == 201

    assert drive.comes_to(is_blocked, 120.0), "the box fits at no stop: somebody stands there"


def unblock(drive: Drive) -> None:
    """The box is gone."""
    drive.live.ask("POST", "/api/sim/remove", {"id": "box"}, token=drive.live.operator)


def kidnap(drive: Drive) -> None:
    """The robot is carried to another place."""
    true = drive.live.runtime.snapshot.truth
    far = [spot for spot in drive.places.values() if true.distance_to(*spot) > KIDNAP_M]
    x, y = far[int(drive.chance.integers(len(far)))]
    robot = {"what": "robot", "x_m": x, "y_m": y, "heading_rad": float(drive.chance.uniform(-3, 3))}
    drive.ask("POST", "/api/sim/place", robot, 201)


def low_battery(drive: Drive) -> None:
    drive.live.runtime.dispatcher.pilot.battery = 0.1  # type: ignore[union-attr]


def operator_gone(drive: Drive) -> None:
    """Who drives gives no sign of life any more."""
    drive.attended = False


def frozen(drive: Drive) -> None:
    """No frame of the robot arrives any more."""
    drive.live.robot.cut = True


ENDS = {  # the state in which each fault leaves a route, and how the reason begins
    "block": (
        "ended",
        (
            "I know of no way",
            "Each way",
            "Something blocks",
            "The robot gets no further",
            "The way took",
            "That place is",
        ),
    ),
    "kidnap": ("paused", ("The robot lost its place",)),
    "low battery": ("paused", ("The battery is low",)),
    "operator gone": ("paused", ("",)),
    "driver frozen": ("ended", ("",)),
    "restart": ("ended", ("The console was started again",)),
}
FAULTS: dict[str, tuple[Callable[[Drive], None], float]] = {
    "block": (block, 300.0),
    "kidnap": (kidnap, 120.0),
    "low battery": (low_battery, 200.0),
    "operator gone": (operator_gone, 20.0),
    "driver frozen": (frozen, 30.0),
}


def inject(drive: Drive, fault: str, number: int) -> dict[str, Any]:
    """One fault in the middle of a patrol."""
    act, patience = FAULTS[fault]
    drive.end()
    drive.route(900 + number, loop=fault != "block", unattended=fault != "operator gone")
    run = drive.run
    moving = drive.comes_to(lambda: abs(drive.live.robot.status().v) > 0.05, 60.0)
    act(drive)
    begun = drive.live.robot.now
    drive.comes_to(lambda: run.state not in ("driving", "waiting"), patience)
    state, reason, took = run.state, run.reason, drive.live.robot.now - begun
    result: dict[str, Any] = {
        "fault": fault,
        "was_moving": moving,
        "state": state,
        "reason": reason,
        "after_s": round(took, 1),
    }
    if state in ("driving", "waiting"):
        result |= drive.under_way()
    result |= drive.moved_after()
    result["still_stands"] = drive.run is run and run.state == state
    drive.live.robot.cut = False
    drive.live.runtime.dispatcher.pilot.battery = None  # type: ignore[union-attr]
    drive.end()
    if fault == "block":
        unblock(drive)
    drive.put_right()
    return result


def is_as_stated(row: dict[str, Any]) -> bool:
    """Return whether a fault left the route as is stated, and nothing moved after that."""
    state, begins = ENDS[row["fault"]]
    whole = row["state"] == state and row["reason"] and str(row["reason"]).startswith(begins)
    held = row["moved_after_m"] < STOOD_M and row.get("was_moving", True) and row.get("still_stands", True)
    return bool(whole and held)


def print_table(rows: list[dict[str, Any]]) -> None:
    """The faults in one table, those first that did not end as stated."""
    print_row(
        "| fault | as stated | slowest, s | moved after, mm | state and reason, how often |\n|---|---|---|---|---|"
    )
    kinds = {fault: [row for row in rows if row["fault"] == fault] for fault in ENDS}
    for fault, of in sorted(kinds.items(), key=lambda each: all(map(is_as_stated, each[1]))):
        if of:
            good, slowest = sum(map(is_as_stated, of)), max(row.get("after_s", 0.0) for row in of)
            moved = 1000.0 * max(row["moved_after_m"] for row in of)
            ends = Counter(f"{'' if is_as_stated(row) else 'MISS '}{row['state']}: {row['reason']}" for row in of)
            told = "; ".join(f"{words} ({count})" for words, count in ends.most_common())
            print_row(f"| {fault} | {good} of {len(of)} | {slowest:.0f} | {moved:.1f} | {told} |")


def restarted(folder: Path, number: int, clock: SteppedClock, share: float) -> dict[str, Any]:
    """A console that finds a route of the one before: it stands as interrupted, and nothing moves."""
    drive = Drive(folder, number, clock, share)
    with drive.live:
        drive.live.until(lambda: not drive.live.runtime.snapshot.slam.looking_around, 60)
        run = drive.run
        return {"fault": "restart", "state": run.state, "reason": run.reason, **drive.moved_after()}


def one_route(drive: Drive, number: int) -> dict[str, int]:
    """Drive a route to its end and print it → what to add to the sums."""
    drive.route(number)
    run, begun = drive.run, drive.live.robot.now
    over = drive.comes_to(lambda: run.state in ("ended", "paused"), ROUTE_S)
    stops_, took = len(run.route.stops), drive.live.robot.now - begun
    reached = run.stop - run.skipped + (run.reason in AT_THE_LAST_STOP)
    state = run.state if over else "too slow"
    row = {"route": number, "reached": reached, "of": stops_, "state": state, "reason": run.reason}
    print_row(row | {"seconds": round(took)})
    stated = reached == stops_ or bool(over and run.reason)
    drive.end()
    drive.put_right()
    return {"routes": 1, "whole": reached == stops_, "stops": stops_, "reached": reached, "stated": stated}


def main(
    *,
    routes: int = 50,
    faults: int = 10,
    kinds: Sequence[Annotated[str, FAULTS]] = tuple(FAULTS),  # of faults
    restarts: int = 10,
    seed: int = 1,
    seconds: float = 3600.0,  # after which no further one is begun
    share: float = 1.0,  # of a processor that it may take
) -> None:
    sums: Counter[str] = Counter()
    injected = list[dict[str, Any]]()
    clock = step_time()
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        drive = Drive(home, seed, clock, share)
        with drive.live:
            drive.prepare()
            end = time.perf_counter() + seconds
            drive.watch(True)
            for number in range(routes):
                if time.perf_counter() > end:
                    break
                sums.update(one_route(drive, number))
            drive.watch(False)
            for number in range(faults):
                for fault in kinds:
                    if time.perf_counter() > end:
                        break
                    injected.append(inject(drive, fault, number))
                    print_row(injected[-1])
            seen = drive.sums
            true = {
                "frames": seen["frames"],
                "contacts": seen["contacts"] if seen["frames"] else None,
                "contacts_standing": seen["contacts_standing"],
                "near_keep_out": seen["near_keep_out"],
                "in_keep_out": seen["in_keep_out"] if seen["near_keep_out"] else None,
                "in_slow": seen["in_slow"],
                "too_fast_in_slow": seen["too_fast_in_slow"] if seen["in_slow"] else None,
                "trace_faults": drive.live.robot.faults()[:3],
            }
            print_row({**sums, **true})
            if restarts:
                drive.route(999, loop=True)
                kept = (home / "route.json").read_bytes()
        for number in range(restarts):
            if time.perf_counter() > end + 60:
                break
            (home / "route.json").write_bytes(kept)
            injected.append(restarted(home, seed + number, clock, share))
            print_row(injected[-1])
    print_table(injected)


if __name__ == "__main__":
    run_command(main)
