"""Drives that are recorded and then computed again: `python -m tests.benchmarks.computed_again [--seconds 60]`.

Five consoles, one after the other, each of which records its session from the first frame on: commands, voices, a map
that is loaded in the middle of it, a robot behind the Foxglove bridge, a serial base with a SCIP laser.
Then each file is read and everything is estimated again. Printed as JSON: fingerprints of all poses with their
covariances, of all maps, edges and directions, as they were then and as they are now.
"""

import contextlib
import hashlib
import itertools
import json
import sys
import tempfile
import time
import urllib.error
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from core.pilot.drive_record import digest_of
from core.pilot.recorded_drive import AsRecorded, Comparer, ComputedNow, robot_of
from core.recording import open_log
from core.recording.drive import DriveRecording
from core.settings import Settings
from core.snapshot import Snapshot
from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import Console
from tests.emulators.robot_process import robot_process

TYPED_COMMANDS = ("turn left", "continue 0.4 meters", "turn right", "continue 0.3 meters")
SPOKEN_WORDS = ("turn left", "come here", "hello there")
PERIOD_S = 4.0  # between two acts
SETTLE_S = 3.0
HASH_LETTERS = 16

Act = Callable[[Console, int], object]


def ask(console: Console, path: str, **body: object) -> None:
    """POST; a robot that is busy refuses."""
    with contextlib.suppress(urllib.error.HTTPError):
        console.post(path, body)


def commanded(console: Console, number: int) -> None:
    """A turn, a way."""
    ask(console, "/api/commands", text=TYPED_COMMANDS[number % len(TYPED_COMMANDS)])


def spoken_to(console: Console, number: int) -> None:
    """Somebody speaks from another place each time."""
    ask(console, "/api/sim/say", text=SPOKEN_WORDS[number % len(SPOKEN_WORDS)], x_m=1.2, y_m=0.8 - number / 8)


def on_a_map(console: Console, number: int) -> None:
    """Drive; keep the map, load it, say where the robot is."""
    match number:
        case 5:
            ask(console, "/api/maps", name="hall")
        case 7:
            ask(console, "/api/maps/hall/load")
        case 8:
            ask(console, "/api/slam/here", x_m=0.4, y_m=0.1, heading_rad=0.3)
        case _:
            commanded(console, number)


def recorded(url: str, act: Act, seconds: float, out: Path, environment: Mapping[str, str]) -> dict[str, Any]:
    """One session → its recording at `out`, how long it is, and the tracebacks in the log."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "settings.toml").write_text("[recording]\nfrom_start = true\nring_s = 0\n")
        console = Console(Path(folder), robot=url, auth=not url.startswith("sim:"), environment=environment)
        try:
            time.sleep(SETTLE_S)
            end = time.monotonic() + seconds
            for number in itertools.count():
                if time.monotonic() > end:
                    break
                act(console, number)
                time.sleep(PERIOD_S)
            done = console.answer("/api/recordings/stop")
            out.write_bytes((Path(folder) / "recordings" / f"{done['name']}.mcap").read_bytes())
            return {"seconds": round(done["seconds"], 1), "faults": console.faults()}
        finally:
            console.close()


class Fingerprint:
    """What is the same of two ways."""

    def __init__(self) -> None:
        self._poses, self._maps, self._seen = hashlib.sha256(), hashlib.sha256(), hashlib.sha256()
        self.edges = self.directions = 0
        self._view, self._voices = -1.0, set[tuple[int, float]]()

    def take(self, one: Snapshot, digest: str) -> None:
        """A snapshot; `digest` of its map where that was written."""
        pose = one.estimate.pose
        self._poses.update(np.array([pose.x, pose.y, pose.heading, *one.estimate.covariance.ravel()]).tobytes())
        self._maps.update(digest.encode())
        if one.view is not None and one.view.stamp != self._view:
            self._view = one.view.stamp
            self.edges += len(one.view.edges)
            self._seen.update(
                np.array([[*edge.top, *edge.bottom, edge.bearing] for edge in one.view.edges]).tobytes()
            )
        for voice in () if one.hearing is None else one.hearing.voices:
            self._seen.update(np.array([voice.stamp, voice.azimuth, voice.sd]).tobytes())
            self._voices.add((voice.id, voice.stamp))
        self.directions = len(self._voices)

    @property
    def report(self) -> dict[str, Any]:
        """Hashes and counts."""
        hashes = {"poses": self._poses, "maps": self._maps, "edges_and_directions": self._seen}
        return {
            **{name: one.hexdigest()[:HASH_LETTERS] for name, one in hashes.items()},
            "edges": self.edges,
            "directions": self.directions,
        }


def computed_again(path: Path) -> dict[str, Any]:
    """Estimate a recording again, and compare."""
    drive = DriveRecording(path)
    as_recorded = AsRecorded(robot_of(drive).built)
    computed, comparer = ComputedNow(drive, Settings()), Comparer()
    then, now, landmarks = Fingerprint(), Fingerprint(), (0, 0)
    for moment in drive.moments():
        old, new = as_recorded.take(moment), computed.take(moment)
        results = None if moment.record is None else moment.record.results
        assert old is not None and results is not None
        then.take(old, results.map_digest)
        now.take(new, digest_of(new.grid) if results.map_digest else "")
        landmarks = (len(old.landmarks), len(new.landmarks)) if results.map_digest else landmarks
        comparer.compare(moment, old, new, computed.recorded_from_computed)
    log = open_log(path)
    return {
        "frames": comparer.frames,
        "whole": computed.whole,
        "same": comparer.same and then.report == now.report,
        "worst_m": comparer.worst,
        "recorded": then.report,
        "computed": now.report,
        "landmarks": landmarks,
        "scans": [drive.counts.get("/scan", 0), len(getattr(log, "scans", ()))],
        "left_out": msgspec.to_builtins(drive.report)["warnings"],
    }


def main(
    *,
    seconds: float = 60.0,
    files: Sequence[Path] = (),  # recordings that are there already
    drives: Sequence[str] = (),  # some of the five, by their names
) -> object:
    report: dict[str, Any] = {path.name: computed_again(path) for path in files}
    known: dict[str, tuple[tuple[str, ...], str, Act]] = {
        "commands": ((), "sim:lab", commanded),
        "voices": ((), "sim:lab", spoken_to),
        "map": ((), "sim:floor", on_a_map),
        "foxglove": (("foxglove", "camera", "audio"), "", commanded),
        "serial and scip": (("serial", "scip"), "", commanded),
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, (wires, url, act) in known.items():
            if files or (drives and name not in drives):
                continue
            path = Path(folder) / f"{name}.mcap"
            with contextlib.ExitStack() as stack:
                robot = stack.enter_context(robot_process(*wires)) if wires else None
                there, environment = (url, {}) if robot is None else (robot.url, robot.environment)
                report[name] = recorded(there, act, seconds, path, environment)
            report[name] |= computed_again(path)
            sys.stderr.write(f"{name}: {json.dumps(report[name])}\n")  # what is done stays where a later one fails
    return report


if __name__ == "__main__":
    run_command(main)
