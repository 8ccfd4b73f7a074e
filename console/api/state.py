"""The present state of the console and the robot, and its figures for a monitoring system."""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import msgspec
from fastapi import APIRouter, Request, Response

from console.access.guard import ON_THIS_MACHINE
from console.access.roles import needs
from console.api import Behind, problems, router, sends_file
from console.api.typed_route import TypedRoute
from console.control.link_monitor import HANGS
from console.http.problems import Problem
from console.messages import state as messages
from console.runtime import Runtime

state = router("state", 503)
TEXT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
FORWARDED_HEADERS = ("forwarded", "x-forwarded-for", "x-forwarded-proto")  # a proxy speaks for another machine
MEMORY = Path("/proc/self/statm")
MS_PER_S = 1000.0

metrics = APIRouter(tags=["state"], responses=problems(401), route_class=TypedRoute)

Labels = dict[str, str]


class Percentiles(msgspec.Struct, frozen=True):
    """How long something takes, usually and at worst [ms]."""

    p50: float | None
    p99: float | None


class HealthReport(msgspec.Struct, frozen=True, kw_only=True):
    """Health of the console, and what is wrong."""

    ok: bool
    reasons: list[str]
    scene: str  # "ok", or why there is none
    pilot_late_ms: Percentiles
    pilot_step_ms: Percentiles


@state.get("/state")
@needs("viewer")
async def newest(behind: Behind) -> messages.State:
    """The newest Snapshot, as the socket sends it; before the first one 503 with `robot`, its url, link and age_s."""
    now = behind.state()
    if now is None:
        link, age = behind.robot.link()
        robot = {"url": behind.robot.profile.url, "link": link, "age_s": round(age, 3)}
        raise Problem(503, "No frame of the robot has arrived yet.", more={"robot": robot})
    return now


@state.get("/health")
@needs("public")
async def health(behind: Behind, response: Response) -> HealthReport:
    """200 when all is well, 503 with the reasons when it is not."""
    reasons = troubles(behind)
    pace = behind.pace
    response.status_code = 503 if reasons else 200
    return HealthReport(
        ok=not reasons,
        reasons=reasons,
        scene=behind.scene.why_not or "ok",
        pilot_late_ms=Percentiles(pace.late_ms(0.5), pace.late_ms(0.99)),
        pilot_step_ms=Percentiles(pace.step_ms(0.5), pace.step_ms(0.99)),
    )


def troubles(behind: Runtime) -> list[str]:
    """Why the console is not well, in sentences; empty when it is."""
    link, age = behind.robot.link()
    sentences: list[str] = []
    if link != "live":
        sentences.append(behind.robot.trouble or f"The robot's link is {link}; its newest frame is {age:.1f} s old.")
    sentences += filter(None, (behind.failure, behind.folder.trouble))
    if behind.pilots.trouble:
        sentences.append(behind.pilots.trouble)
    elif behind.pilots.hangs:
        sentences.append(HANGS)
    elif behind.snapshot is None:
        sentences.append("No frame of the robot has been worked on yet.")
    return sentences


@dataclass(frozen=True)
class Metric:
    """A family of figures, each with its labels; a figure that is not known now is left out."""

    name: str
    kind: str  # "gauge" or "counter"
    about: str
    figures: tuple[tuple[Labels, float | None], ...]

    @property
    def lines(self) -> Iterator[str]:
        yield f"# HELP beckon_{self.name} {self.about}"
        yield f"# TYPE beckon_{self.name} {self.kind}"
        for labels, figure in self.figures:
            if figure is not None:
                text = ",".join(f'{name}="{quoted(value)}"' for name, value in labels.items())
                yield f"beckon_{self.name}{f'{{{text}}}' if text else ''} {figure:.9g}"


@metrics.get("/metrics", **sends_file("text/plain"))
@needs("public")
async def read_metrics(behind: Behind, request: Request) -> Response:
    """Figures in Prometheus' text form, for people who are signed in and for programs on this machine."""
    client = request.client
    near = client is not None and client.host in ON_THIS_MACHINE
    proxied = any(name in request.headers for name in FORWARDED_HEADERS)
    if request.scope["person"] is None and (proxied or not near):
        raise Problem(401, "Sign in first: send a key that beckon token add makes.")
    lines = [line for metric in figures_of(behind) for line in metric.lines]
    return Response("\n".join(lines) + "\n", media_type=TEXT_TYPE)


def figures_of(behind: Runtime) -> Iterable[Metric]:
    link, age = behind.robot.link()
    gate, pace = behind.robot.status(), behind.pace
    snapshot = behind.snapshot
    sensors = () if snapshot is None else snapshot.sensors
    return (
        gauge("healthy", "1 while GET /api/health answers 200.", float(not troubles(behind))),
        gauge("robot_live", "1 while the robot's frames arrive in time.", float(link == "live")),
        gauge("frame_age_seconds", "Age of the robot's newest frame.", age),
        Metric(
            "sensor_age_seconds",
            "gauge",
            "Time since the newest reading of a sensor.",
            tuple(({"sensor": one.name or one.kind, "kind": one.kind}, one.age) for one in sensors),
        ),
        quantiles("pilot_late_seconds", "Lateness of the pilot's steps.", pace.late_ms),
        quantiles("pilot_step_seconds", "Duration of the pilot's steps.", pace.step_ms),
        Metric("gate_trips_total", "counter", "How often the gate stopped the robot by itself.", (({}, gate.trips),)),
        Metric("gate_state", "gauge", "1 for the state in which the gate is.", (({"state": gate.state}, 1.0),)),
        gauge("speed_metres_per_second", "Speed that the gate lets through.", gate.v),
        gauge("viewers", "People who have a page open.", behind.sockets.people),
        gauge("operator_present", "1 while an operator drives.", float(behind.lease.holder is not None)),
        gauge("disk_free_bytes", "Free space where the data folder lies.", behind.folder.free_bytes),
        gauge("memory_bytes", "Resident memory of the console's own process.", resident_bytes()),
    )


def gauge(name: str, about: str, figure: float | None) -> Metric:
    return Metric(name, "gauge", about, (({}, figure),))


def quantiles(name: str, about: str, ms: Callable[[float], float | None]) -> Metric:
    """Median and 99th percentile."""
    found = ((part, ms(part)) for part in (0.5, 0.99))
    rows = (({"quantile": f"{part:g}"}, None if late is None else late / MS_PER_S) for part, late in found)
    return Metric(name, "gauge", about, tuple(rows))


def resident_bytes() -> float | None:
    """Memory of this process; None where the system does not say."""
    try:
        return int(MEMORY.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return None


def quoted(value: str) -> str:
    """A label's value in the text form."""
    return value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
