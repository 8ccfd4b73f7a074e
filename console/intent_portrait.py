"""An order that waits → what every viewer gets."""

from __future__ import annotations

import math

from console import wire_intent as wire
from console.intent import Intent
from console.prospect import foresee
from core.snapshot import Snapshot

DIGITS = 3


def intent(waiting: Intent | None, snapshot: Snapshot, radius: float, now: float) -> wire.IntentState | None:
    """What waits, and what it would do as the robot stands; `radius` [m] of the robot, `now` [s] monotonic."""
    if waiting is None:
        return None
    command = waiting.command
    seen = foresee(command, snapshot, radius)
    heading = snapshot.estimate.pose.heading
    bearing = None if seen.call is None else math.remainder(seen.call.azimuth - heading, math.tau)
    return wire.IntentState(
        id=waiting.id,
        name=command.name,
        numbers=dict(command.numbers),
        heard_as=command.heard_as,
        source=waiting.source,
        who=waiting.person.name,
        begins_in_s=round(max(0.0, waiting.when.begins - now), DIGITS),
        moment_s=waiting.moment,
        unsure=waiting.unsure,
        way=[(round(x, DIGITS), round(y, DIGITS)) for x, y in seen.way.tolist()],
        goal=None if seen.goal is None else (round(seen.goal[0], DIGITS), round(seen.goal[1], DIGITS)),
        heading_rad=None if seen.heading is None else round(seen.heading, DIGITS),
        bearing_rad=None if bearing is None else round(bearing, DIGITS),
        bearing_sd_rad=None if seen.call is None else round(seen.call.sd, DIGITS),
    )
