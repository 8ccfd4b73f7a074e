"""A minute with the simulated robot: does it obey, does the gate hold, does the map come out."""

import math
from collections.abc import Iterator

from core.experiments.rehearsal import Rehearsal
from core.geometry import wrap
from core.pipelines.nav2_map import nav2_map

MAX_TURN_ERROR_RAD = math.radians(2.0)
MAX_POSITION_ERROR_M = 0.05


def self_test() -> Iterator[tuple[str, bool, str]]:
    """Name, verdict and finding of every check, one after the other."""
    with_robot = Rehearsal("sim:lab")
    before = with_robot.truth
    with_robot.say("turn left")
    turned = wrap(with_robot.truth.heading - before.heading)
    off = abs(wrap(turned - math.pi / 2))
    yield "turn left", off < MAX_TURN_ERROR_RAD, f"turned {math.degrees(turned):.1f}°, 90° were asked"
    with_robot.say("turn right")
    before = with_robot.truth
    with_robot.say("continue 0.5 meters")
    went = with_robot.truth.distance_to(before.x, before.y)
    yield "continue 0.5 meters", abs(went - 0.5) < MAX_POSITION_ERROR_M, f"drove {went:.3f} m"
    pose, truth = with_robot.snapshot.estimate.pose, with_robot.truth
    apart = pose.distance_to(truth.x, truth.y)
    yield "localisation", apart < MAX_POSITION_ERROR_M, f"{apart * 1000:.0f} mm from the truth"
    yield "landmarks", len(with_robot.snapshot.landmarks) >= 3, f"{len(with_robot.snapshot.landmarks)} in the map"
    _, picture = nav2_map(with_robot.snapshot.grid)
    yield "map export", picture.startswith(b"P5"), f"{len(picture) // 1000} kB"
    faults = with_robot.faults()
    yield "gate", not faults, faults[0] if faults else f"{len(with_robot.trace)} rows, all within the limits"
    yield "contacts", with_robot.contacts == 0, f"{with_robot.contacts}"
