"""The present state of the console and the robot."""

import msgspec
from fastapi import Response

from console.access.roles import needs
from console.api import Behind, router
from console.control.link_monitor import HANGS
from console.http.problems import Problem
from console.messages import state as messages
from console.runtime import Runtime

state = router("state", 503)


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
