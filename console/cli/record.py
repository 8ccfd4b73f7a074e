"""`beckon record`: a robot's readings into one MCAP, without a page; the robot is not driven."""

from __future__ import annotations

import argparse
import signal
import time
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, add_out_file, answer, progress
from core.errors import BadInput

if TYPE_CHECKING:
    from core.recording.mcap_writing import RecordedFile
    from core.robots import Robot

ENDING, PART = ".mcap", ".part"  # as `core.recording.mcap_writing` has it, which takes a moment to import
REPORT_PERIOD_S = 1.0  # [s] between two reports of progress


def add(subcommands: Any) -> None:
    parser = add_command(
        subcommands, "record", run, "record a robot's readings into an MCAP file, without a page; nothing is driven"
    )
    parser.add_argument("--robot", default="sim:lab", metavar="URL|robot.toml", help="see beckon robots")
    add_out_file(parser, "FILE.mcap", "the file to write", required=True)
    parser.add_argument("--seconds", type=float, metavar="N", help="how long (default: until interrupted)")
    parser.add_argument("--settings", type=Path, metavar="FILE.toml")


def run(chosen: argparse.Namespace) -> int:
    """Record until the time is over, or the program is interrupted."""
    if chosen.out.suffix != ENDING:
        raise BadInput("--out takes a file whose name ends in .mcap.")
    for there in (chosen.out, chosen.out.with_name(chosen.out.name + PART)):
        if there.exists():
            raise BadInput(f"{there} is there already; give another name, or remove it.")
    if chosen.seconds is not None and not 0 < chosen.seconds < 1e7:
        raise BadInput("--seconds takes a number above 0.")
    from core.robots.connect import connect  # robots take a second to import: only here
    from core.settings import load

    with closing(connect(chosen.robot, settings=load(chosen.settings))) as robot, progress() as say:
        written = record(robot, chosen.out, chosen.seconds, say)
    facts = {"path": str(written.path), "seconds": written.seconds, "bytes": written.bytes}
    topics = [f"{count:8} {topic}" for topic, count in written.messages.items()]
    whole = f"{written.path}: {written.seconds:.1f} s, {written.bytes / 1e6:.1f} MB"
    return answer(chosen, {**facts, "messages": dict(written.messages), "complete": True}, *topics, whole)


def record(robot: Robot, out: Path, seconds: float | None, say: Any) -> RecordedFile:
    """Write what the robot senses. Raises Unwritable; an interruption (Ctrl+C, SIGTERM) finishes the file."""
    from core.pipelines.record import RobotRecording

    recording, period = RobotRecording(robot, out), 1 / robot.profile.rate
    began = due = time.monotonic()
    unix_from_monotonic = time.time() - began  # a clock that is set meanwhile tears no gap
    reported = began - REPORT_PERIOD_S
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        while seconds is None or time.monotonic() - began < seconds:
            recording.add(unix_from_monotonic + time.monotonic())
            if time.monotonic() - reported >= REPORT_PERIOD_S:
                reported = time.monotonic()
                rest = "" if seconds is None else f" of {seconds:.0f}"
                say(f"recorded {recording.file.seconds:.0f}{rest} s, {recording.file.written.bytes / 1e6:.1f} MB")
            due = max(due + period, time.monotonic() - period)
            time.sleep(max(0.0, due - time.monotonic()))
    except KeyboardInterrupt:
        pass
    finally:
        written = recording.file.finish()
        signal.signal(signal.SIGTERM, before)
    return written
