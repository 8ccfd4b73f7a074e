"""The Victoria Park text form: a graph of poses and trees.

`ODOMETRY i j dx dy dθ …`: increment [m, m, rad] in the robot frame of pose i; `LANDMARK i j x y …`: landmark j seen
from pose i, x forward, y left [m]. Poses and landmarks share one numbering, and the file has no time: the stamp is
the number of ODOMETRY lines so far.
"""

import math
from array import array
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings, SightingRecording
from core.recording.sightings import MAX_CURVATURE_RAD_M, MOST_ROWS, Ids, SightingSteps, are_degrees
from core.recording.source import TextLog
from core.slam.motion import Increment

STEP_NOISE = np.diag([0.01**2, 0.01**2, 0.002**2])  # of one increment: [m], [m], [rad]
TURN_NOISE = 0.05  # [rad per root rad]: steering gives a turn roughly, and tyres slip in it; 0.03 to 0.09 do as well
SIGHTING_NOISE = 0.4, 0.035  # [m], [rad]
MIN_BEND_M = 0.05  # of a move by which a bend is judged


class _Graph:
    """The lines of a file: poses, and what was seen from each."""

    def __init__(self) -> None:
        self.increments: list[Pose] = []
        self.reached: dict[int, int] = {}  # node of a pose → how many increments lead to it
        self.seen: dict[int, array[float]] = {}  # node of a pose → id, range, bearing …

    def add(self, words: list[str]) -> bool:
        """Take in one line; False: it is cut or no numbers."""
        odometry = words[0] == "ODOMETRY"
        try:
            node, other = int(words[1]), int(words[2])
            numbers = [float(word) for word in words[3 : 6 if odometry else 5]]
        except (ValueError, IndexError):
            return False
        if len(numbers) < (3 if odometry else 2) or not all(abs(value) < 1e6 for value in numbers):
            return False
        if odometry:
            self.reached.setdefault(node, len(self.increments))
            self.increments.append(Pose(*numbers))
            self.reached[other] = len(self.increments)
        else:
            x, y = numbers
            self.seen.setdefault(node, array("d")).extend((other, math.hypot(x, y), math.atan2(y, x)))
        return True

    def make_radians(self, tally: ReadReport) -> None:
        """Convert turns in degrees: a car cannot turn so much on its way."""
        ways = np.array([(math.hypot(move.x, move.y), move.heading) for move in self.increments])
        bends = ways[ways[:, 0] > MIN_BEND_M, 1] / ways[ways[:, 0] > MIN_BEND_M, 0]
        if are_degrees(bends, MAX_CURVATURE_RAD_M, "ODOMETRY", tally):
            self.increments = [Pose(move.x, move.y, math.radians(move.heading)) for move in self.increments]

    def drop_strangers(self) -> int:
        """Forget what was seen from poses that no increment leads to → how many sightings that were."""
        strangers = [node for node in self.seen if node not in self.reached]
        return sum(len(self.seen.pop(node)) // 3 for node in strangers)


def read(path: Path, ids: Ids, settings: LogSettings) -> SightingRecording:
    """One step per pose from which something was seen, stamped 1.0 after the first ODOMETRY line. Raises BadInput."""
    tally = ReadReport(path)
    text = TextLog(path, settings.largest_file)
    graph = _Graph()
    for number, line in text:
        words = line.split()
        if words and words[0] in ("ODOMETRY", "LANDMARK") and not graph.add(words):
            tally.skip("it is cut or no numbers", f"line {number}")
        if len(graph.increments) > MOST_ROWS:
            raise BadInput(f"{path.name} has more than {MOST_ROWS} steps.")
    if text.cut:
        tally.skip("the packed file is cut or damaged here")
    if not graph.increments:
        raise BadInput(f"{path.name} holds no ODOMETRY lines.")
    tally.skip("its pose is unknown", count=graph.drop_strangers())
    graph.make_radians(tally)
    by_step = {graph.reached[node]: np.array(rows).reshape(-1, 3) for node, rows in graph.seen.items()}
    moved = Increment()
    steps = SightingSteps(SIGHTING_NOISE, ids, tally)
    for k in range(len(graph.increments) + 1):
        if k:
            moved = moved.then(_increment(graph.increments[k - 1]))
        if k in by_step:
            steps.add(float(k), moved, by_step[k])
            moved = Increment()
    tally.topics = ["ODOMETRY: odometry", "LANDMARK: sightings"]
    return steps.finish(path, "Victoria Park text")


def _increment(move: Pose) -> Increment:
    """A move of one line → with its covariance; the file gives every line the same, be it straight or in a bend."""
    return Increment(move, STEP_NOISE + np.diag([0.0, 0.0, TURN_NOISE**2 * abs(move.heading)]))
