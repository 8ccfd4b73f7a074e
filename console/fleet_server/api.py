"""The fleet over HTTP: who is there, STOP ALL, Halt all, pictures."""

import time
from typing import Annotated, Any

import msgspec
from fastapi import Path, Response

from console.access.roles import needs
from console.api import Who, base, router, sends_file
from console.fleet.bus import RobotFacts, StopKind
from console.fleet.router import FleetStop
from console.fleet.table import FleetRobot, Need, Presence
from console.fleet_server.runtime import FleetRuntime
from console.http.problems import Problem
from core.sentences import Statement

fleet = router("fleet")

Fleet = Annotated[Any, base(lambda runtime: runtime)]  # a FleetRuntime
RobotName = Annotated[str, Path(min_length=1, max_length=40)]


class FleetRow(RobotFacts, frozen=True, kw_only=True):
    """A robot, as the fleet knows it."""

    name: str
    link: Presence
    age_s: float | None  # of its newest report; null: it has said nothing since the fleet runs
    since_s: float  # for which the link has been so
    need: Need  # why it needs help; "": it does not
    role: str | None  # of who asks, at this robot; null: none
    url: str  # of its console, through the fleet


class StoppedRobot(msgspec.Struct, frozen=True):
    """A robot's answer to a stop of all."""

    name: str
    acknowledged: bool  # its own gate lets nothing through
    ms: float | None  # from the press to its answer at the fleet; null: none yet
    gate_ms: float | None = None  # of these, at the robot
    link: Presence = "gone"
    reason: str = ""


class FleetStopState(msgspec.Struct, frozen=True):
    """A stop of all, and who has answered."""

    robots: list[StoppedRobot]
    all: bool  # every robot has acknowledged
    kind: StopKind
    by: str
    at_s: float  # Unix time
    asking: bool  # who has not answered is asked again


class HaltState(msgspec.Struct, frozen=True):
    """All are halted, and every robot that comes."""

    by: str
    since_s: float  # Unix time


class FleetState(msgspec.Struct, frozen=True):
    """All robots, who needs help first."""

    robots: list[FleetRow]
    stop: FleetStopState | None  # the newest
    halt: HaltState | None
    trouble: str  # why no robot can join, or what of the fleet has failed; "" when all is well
    time_s: float  # Unix time


class ResetFleetHalt(msgspec.Struct, frozen=True):
    """Robots that come are halted no more; each that is halted is reset at its own console."""

    halted: bool = False


def row_of(robot: FleetRobot, role: str | None, now: float) -> FleetRow:
    """A robot at `now` [s] on the monotonic clock."""
    report = robot.report
    common: dict[str, Any] = {
        "name": robot.name,
        "link": robot.link,
        "since_s": round(now - robot.since, 1),
        "need": robot.need,
        "role": role,
        "url": f"/robots/{robot.name}/",
    }
    if report is None:
        return FleetRow(**common, age_s=None)
    same = {name: getattr(report, name) for name in RobotFacts.__struct_fields__}
    return FleetRow(**common, age_s=round(now - robot.heard_at, 2), **same)


def stop_state(stop: FleetStop, runtime: FleetRuntime) -> FleetStopState:
    """A stop of all; who has not answered stands first."""
    rows: list[StoppedRobot] = []
    for name, one in stop.robots.items():
        known, answer = runtime.router.table.robots.get(name), one.answer
        ms = None if one.ms is None else round(one.ms, 1)
        row = StoppedRobot(
            name,
            one.acknowledged,
            ms,
            answer and answer.ms,
            "gone" if known is None else known.link,
            answer.reason if answer else "",
        )
        rows.append(row)
    rows.sort(key=lambda row: (row.acknowledged, row.name.casefold()))
    return FleetStopState(rows, stop.all, stop.kind, stop.by, stop.wall, not stop.over and not stop.all)


@fleet.get("/fleet")
@needs("viewer")
async def state(runtime: Fleet, who: Who) -> FleetState:
    """All robots, who needs help first; the newest stop of all."""
    now, router = time.monotonic(), runtime.router
    router.table.tick(now)
    rows = [row_of(robot, runtime.role_at(who, robot.name), now) for robot in router.table.sorted()]
    stop = None if router.stop is None else stop_state(router.stop, runtime)
    halt = None if router.halt is None else HaltState(router.halt.by, router.halt.since_s)
    return FleetState(rows, stop, halt, runtime.failure or str.__str__(router.trouble), time.time())


@fleet.post("/fleet/stop")
@needs("viewer", reads_body=False)
async def stop_all(runtime: Fleet, who: Who) -> FleetStopState:
    """STOP ALL: every robot stands by its own gate; anyone signed in. Answers within about a second."""
    return await stopped(runtime, who, "stop")


@fleet.post("/fleet/halt")
@needs("viewer", reads_body=False)
async def halt_all(runtime: Fleet, who: Who) -> FleetStopState:
    """The same, latched at every robot, and at each that comes until it is reset here."""
    return await stopped(runtime, who, "halt")


@fleet.post("/fleet/halt/reset")
@needs("operator", reads_body=False)
async def reset_halt(runtime: Fleet, who: Who) -> ResetFleetHalt:
    """Halt no robot any more that comes; each robot is reset at its own console. Never moves."""
    await runtime.router.reset_halt()
    runtime.history.add("halt_reset", who, source="fleet")
    return ResetFleetHalt()


@fleet.get("/fleet/robots/{name}/picture", **sends_file("image/jpeg", errors=[404]))
@needs("viewer")
async def picture(name: RobotName, runtime: Fleet, who: Who) -> Response:
    """The newest picture of a robot, small. The robot sends one when it is asked, and none otherwise."""
    if runtime.role_at(who, name) is None:
        raise Problem(403, Statement("fleet.not_let_in", name=name))
    found = await runtime.router.picture(name)
    if found is None:
        raise Problem(404, Statement("fleet.no_picture", name=name))
    return Response(found, media_type="image/jpeg")


async def stopped(runtime: FleetRuntime, who: Any, kind: StopKind) -> FleetStopState:
    runtime.history.add(kind, who, source="fleet")
    return stop_state(await runtime.router.stop_all(kind, who.name), runtime)
