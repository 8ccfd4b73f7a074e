"""A minute with the simulated robot: whether it obeys, whether the gate holds, whether the map comes out."""

import math
from collections.abc import Iterator

from core.experiments.rehearsal import Rehearsal
from core.geometry import wrap
from core.pipelines.nav2_map import nav2_map

MAX_TURN_ERROR_RAD = math.radians(2.0)
MAX_POSITION_ERROR_M = 0.05


def self_test() -> Iterator[tuple[str, bool, str]]:
    """Name, verdict and finding of every check, one after the other."""
    rehearsal = Rehearsal("sim:lab")
    start = rehearsal.truth
    rehearsal.say("turn left")
    turned = wrap(rehearsal.truth.heading - start.heading)
    yield (
        "turn left",
        abs(wrap(turned - math.pi / 2)) < MAX_TURN_ERROR_RAD,
        f"turned {math.degrees(turned):.1f}°, 90° were asked",
    )
    rehearsal.say("turn right")
    start = rehearsal.truth
    rehearsal.say("continue 0.5 meters")
    driven = rehearsal.truth.distance_to(start.x, start.y)
    yield "continue 0.5 meters", abs(driven - 0.5) < MAX_POSITION_ERROR_M, f"drove {driven:.3f} m"
    pose, truth = rehearsal.snapshot.estimate.pose, rehearsal.truth
    error = pose.distance_to(truth.x, truth.y)
    yield "localisation", error < MAX_POSITION_ERROR_M, f"{error * 1000:.0f} mm from the truth"
    yield "landmarks", len(rehearsal.snapshot.landmarks) >= 3, f"{len(rehearsal.snapshot.landmarks)} in the map"
    _, picture = nav2_map(rehearsal.snapshot.grid)
    yield "map export", picture.startswith(b"P5"), f"{len(picture) // 1000} kB"
    faults = rehearsal.faults()
    yield "gate", not faults, faults[0] if faults else f"{len(rehearsal.trace)} rows, all within the limits"
    yield "contacts", rehearsal.contacts == 0, f"{rehearsal.contacts}"
