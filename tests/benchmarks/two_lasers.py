"""One laser or two, with odometry or without: `python -m tests.benchmarks.two_lasers`.

A simulated robot turns to the left, goes half a metre, turns to the right and goes to a place; told are the error of
its pose at the end, the worst on the way, and whether the commands were done.
"""

import itertools
import math

from core.geometry import wrap
from tests.benchmarks.command import print_row, run_command
from tests.core.pilot.test_missing_sensors import EquippedRobot, Session

WORDS = ("turn left", "continue 0.5 meters", "turn right", "stop at 0.8 and 0.3")


def driven(lasers: int, *, odometry: bool, seed: int) -> str:
    """One drive → its line."""
    session = Session(EquippedRobot(lasers, odometry=odometry, camera=False, microphones=False, seed=seed))
    session.run(1.0)
    ends, places, headings = list[str](), list[float](), list[float]()
    for words in WORDS:
        ends.append(session.obey(words, 20.0)[0])
        session.run(0.5)
        assert session.snapshot is not None
        here, truth = session.snapshot.estimate.pose, session.truth
        places.append(1000 * truth.distance_to(here.x, here.y))
        headings.append(abs(math.degrees(wrap(here.heading - truth.heading))))
    ended = "all done" if set(ends) == {"done"} else ", ".join(ends)
    return f"{max(places):6.1f} mm {max(headings):5.2f}°   {places[-1]:6.1f} mm {headings[-1]:5.2f}°   {ended}"


def main() -> None:
    """Print a table."""
    print_row("odometry  lasers  seed   worst after a command   at the end")
    for odometry, lasers, seed in itertools.product((True, False), (1, 2), range(2)):
        print_row(f"{odometry!s:8} {lasers:7} {seed:5}   {driven(lasers, odometry=odometry, seed=seed)}")


if __name__ == "__main__":
    run_command(main)
