"""A minute with the simulated robot: does it obey, does the gate hold, does the map come out."""

import math
from collections.abc import Iterator

from core.experiments.rehearsal import Rehearsal
from core.geometry import wrap
from core.pipelines.nav2_map import nav2_map

TURN_WITHIN = math.radians(2.0)
STRAIGHT_WITHIN = 0.05  # [m]


def self_test() -> Iterator[tuple[str, bool, str]]:
    """Name, verdict and finding of every check, one after the other."""
    with_robot = Rehearsal("sim:lab")
    before = with_robot.truth
    with_robot.say("turn left")
    turned = wrap(with_robot.truth.heading - before.heading)
    off = abs(wrap(turned - math.pi / 2))
    yield "turn left", off < TURN_WITHIN, f"turned {math.degrees(turned):.1f}°, 90° were asked"
    with_robot.say("turn right")
    before = with_robot.truth
    with_robot.say("continue 0.5 meters")
    went = with_robot.truth.distance_to(before.x, before.y)
    yield "continue 0.5 meters", abs(went - 0.5) < STRAIGHT_WITHIN, f"drove {went:.3f} m"
    pose, truth = with_robot.snapshot.estimate.pose, with_robot.truth
    apart = pose.distance_to(truth.x, truth.y)
    yield "localisation", apart < STRAIGHT_WITHIN, f"{apart * 1000:.0f} mm from the truth"
    yield "landmarks", len(with_robot.snapshot.landmarks) >= 3, f"{len(with_robot.snapshot.landmarks)} in the map"
    _, picture = nav2_map(with_robot.snapshot.grid)
    yield "map export", picture.startswith(b"P5"), f"{len(picture) // 1000} kB"
    faults = with_robot.faults()
    yield "gate", not faults, faults[0] if faults else f"{len(with_robot.trace)} rows, all within the limits"
    yield "contacts", with_robot.contacts == 0, f"{with_robot.contacts}"
