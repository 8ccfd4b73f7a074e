"""Recordings that are played: `python -m tests.benchmarks.replays --data FOLDER --drive FILE.mcap [--minutes 30]`.

`--data`: every log in it is played from its beginning to its end, as behind the page: how many of its scans came, and
what was said of what was left out; of one that cannot be played the sentence that says why.
`--drive`: a recording of Beckon's own is repeated to the wanted length; then places are sought at random, each
until its first whole picture has come, and it is played at 20 times real time. Printed as JSON.
"""

import random
import tempfile
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from mcap.reader import make_reader

from core.errors import BeckonError
from core.pilot.replayed_drive import open_robot
from core.recording import FORMS
from core.recording.mcap_writing import NS_PER_S, McapRecording
from core.recording.ros_writing import RosMessage
from core.robots.requests import Play, Seek, SetSpeed
from tests.benchmarks.command import run_command

SEEK_COUNT = 200
MAX_SPEED = 20.0
MEMORY_ROWS = 10  # of the whole way
MORE_FORMS = (".clf", ".log", ".active", ".db", ".gz", ".txt", ".dat")
NO_LOGS = ("camera", "sound", "words", "make", "camera_files", "laser", "lasers", "images", "pictures")
MAX_READS = 1_000_000


def logs_of(folder: Path) -> list[Path]:
    """Everything in a folder that may be a log: files by their forms, folders of a bag or of sightings."""
    known = {*MORE_FORMS, *(word.strip(".,") and f".{word.strip('.,')}" for word in FORMS.split() if word[0] == ".")}
    found = list[Path]()
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        if any(part in NO_LOGS for part in parts) or any(parent in found for parent in path.parents):
            continue
        holds = path.is_dir() and any((path / name).exists() for name in ("metadata.yaml", "Barcodes.dat"))
        if holds or (path.is_file() and path.suffix.lower() in known):
            found.append(path)
    return found


def played(path: Path) -> dict[str, Any]:
    """One log from its beginning to its end at the highest speed."""
    try:
        robot = open_robot(str(path), seed=0, settings=None)
    except BeckonError as refusal:
        return {"log": path.name, "refused": str(refusal)}
    with closing(robot):
        robot.ask(SetSpeed(value=MAX_SPEED))
        robot.ask(Play())
        counts, notes, ended = {"scan": 0, "image": 0, "sound": 0}, list[str](), False
        for _ in range(MAX_READS):
            frame = robot.read()
            for kind in counts:
                counts[kind] += getattr(frame, kind) is not None
            notes += frame.notes
            ended = not frame.running and frame.progress == 1.0
            if ended:
                break
        return {
            "log": path.name,
            "seconds": round(robot.profile.duration or 0.0, 1),
            "played_to_its_end": ended,
            **counts,
            "said": [note for note in notes if note != "The recording ends here."],
        }


def repeated(source: Path, target: Path, seconds: float) -> Path:
    """The same drive again and again, until it is so long."""
    other = McapRecording(target)
    with source.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        length = summary.statistics.message_end_time - summary.statistics.message_start_time + NS_PER_S // 40
        for turn in range(int(np.ceil(seconds * NS_PER_S / length))):
            for schema, channel, message in reader.iter_messages():
                kind = "" if schema is None else schema.name
                stamp, logged = message.publish_time / NS_PER_S, (message.log_time + turn * length) / NS_PER_S
                other.add([RosMessage(channel.topic, kind, stamp, message.data)], logged)
    return other.finish().path


def long_drive(path: Path) -> dict[str, Any]:
    """Seek in it, then play it at 20 times real time."""
    chance, memory = random.Random(0), psutil.Process()
    robot = open_robot(str(path), seed=0, settings=None)
    with closing(robot):
        robot.read()
        waits = list[float]()
        for _ in range(SEEK_COUNT):
            began = time.monotonic()
            robot.ask(Seek(value=chance.uniform(0.0, 0.999)))
            while robot.read().image is None:
                pass
            waits.append(1000 * (time.monotonic() - began))
        robot.ask(Seek(value=0.0))
        robot.ask(SetSpeed(value=MAX_SPEED))
        robot.ask(Play())
        megabytes, steps, began = list[float](), list[float](), time.monotonic()
        while True:
            at = time.monotonic()
            frame = robot.read()
            steps.append(1000 * (time.monotonic() - at))
            if (frame.progress or 0.0) * MEMORY_ROWS >= len(megabytes):
                megabytes.append(round(memory.memory_info().rss / 1e6, 1))
            if not frame.running:
                break
        lived = time.monotonic() - began
        return {
            "seconds": round(robot.profile.duration or 0.0),
            "megabytes_of_file": round(path.stat().st_size / 1e6, 1),
            "seek_ms": {share: round(float(np.percentile(waits, share)), 1) for share in (50, 99, 100)},
            "times_real_time_without_waiting": round((robot.profile.duration or 0.0) / lived, 1),
            "frame_ms": {share: round(float(np.percentile(steps, share)), 1) for share in (50, 99, 100)},
            "memory_mb_on_the_way": megabytes,
        }


def main(*, data: Path | None = None, drive: Path | None = None, minutes: float = 30.0) -> object:
    report: dict[str, Any] = {}
    if data is not None:
        report["logs"] = [played(path) for path in logs_of(data)]
    if drive is not None:
        with tempfile.TemporaryDirectory() as folder:
            report["long"] = long_drive(repeated(drive, Path(folder) / "long.mcap", 60 * minutes))
    return report


if __name__ == "__main__":
    run_command(main)
