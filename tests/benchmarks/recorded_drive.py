"""A recorded drive with viewers and speech, and who can read it: `python -m tests.benchmarks.recorded_drive`.

Two consoles on the simulator, one after the other: one without recorder and ring, one that records the same drive.
Printed as JSON: messages per topic as the recorder counted them and as each reader found them, the file's size, the
recorder's share of a core, the pilot's step and lateness with and without. `--python` is an interpreter with
mcap-ros2-support and evo, `--node` a folder with @mcap/core, @foxglove/rosmsg, @foxglove/rosmsg2-serialization and
fzstd; readers that are not given are left out.
"""

import contextlib
import itertools
import json
import os
import subprocess
import tempfile
import threading
import time
import urllib.error
from collections import Counter
from pathlib import Path
from typing import Any

import psutil
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from websockets.sync.client import connect

from core.recording import open_log
from core.recording.mcap_writing import CHUNK_BYTES
from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import Console

DRIVE = ("turn left", "continue 0.4 meters", "turn left", "continue 0.4 meters", "turn right", "turn right")
SAYING = ("turn left", "hello there", "come here", "stop")
SAY_PERIOD_S, COMMAND_PERIOD_S = 12.0, 3.0
SETTLE_S = 10.0  # after the start
VIEWERS = 3

READ_BY_ROS2_SUPPORT = """
import collections, json, sys
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
counts = collections.Counter()
with open(sys.argv[1], "rb") as file:
    for _, channel, _, _ in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
        counts[channel.topic] += 1
print(json.dumps(counts))
"""
READ_BY_EVO = """
import json, sys
from evo.tools import file_interface
from rosbags.highlevel import AnyReader
from pathlib import Path
with AnyReader([Path(sys.argv[1])]) as bag:
    found = file_interface.read_bag_trajectory(bag.readers[0], sys.argv[2])
print(json.dumps({"poses": found.num_poses, "path_m": found.path_length, "sound": bool(found.check()[0])}))
"""
READ_BY_NODE = """
const { McapIndexedReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { decompress } = require("fzstd");
const fs = require("fs");
(async () => {
  const file = fs.openSync(process.argv[2], "r");
  const readable = {
    size: async () => BigInt(fs.fstatSync(file).size),
    read: async (offset, size) => {
      const bytes = new Uint8Array(Number(size));
      fs.readSync(file, bytes, 0, Number(size), Number(offset));
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({
    readable, decompressHandlers: { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) },
  });
  const decoders = new Map();
  for (const [id, channel] of reader.channelsById) {
    const text = new TextDecoder().decode(reader.schemasById.get(channel.schemaId).data);
    decoders.set(id, new MessageReader(parse(text, { ros2: true })));
  }
  const counts = {};
  for await (const message of reader.readMessages()) {
    decoders.get(message.channelId).readMessage(message.data);
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
  }
  console.log(JSON.stringify(counts));
})();
"""


def drive(console: Console, seconds: float) -> dict[str, Any]:
    """Viewers, commands and voices for some time → the pilot's times at the end of it."""
    over = threading.Event()
    viewers = [threading.Thread(target=_watch, args=(console.port, over), daemon=True) for _ in range(VIEWERS)]
    for viewer in viewers:
        viewer.start()
    commands, sayings = itertools.cycle(DRIVE), itertools.cycle(SAYING)
    end = time.monotonic() + seconds
    said = 0.0
    while time.monotonic() < end:
        _try(console, "/api/commands", {"text": next(commands)})
        if time.monotonic() - said > SAY_PERIOD_S:
            said = time.monotonic()
            _try(console, "/api/sim/say", {"text": next(sayings), "x_m": 1.0, "y_m": 1.0})
        time.sleep(COMMAND_PERIOD_S)
    health = console.get("/api/health")
    over.set()
    return {name: health[name] for name in ("pilot_step_ms", "pilot_late_ms")}


def _watch(port: int, over: threading.Event) -> None:
    with connect(f"ws://127.0.0.1:{port}/ws", origin=f"http://127.0.0.1:{port}", max_size=None) as socket:  # type: ignore[arg-type]
        while not over.is_set():
            socket.recv(timeout=10)


def _try(console: Console, path: str, body: dict[str, object]) -> None:
    with contextlib.suppress(urllib.error.HTTPError):  # refused: the robot is busy
        console.post(path, body)


def recorder_of(console: Console) -> psutil.Process:
    for one in psutil.Process(console.process.pid).children(recursive=True):
        if "--worker=recorder" in one.cmdline():
            return one
    raise LookupError("there is no recorder")


def measured_without(seconds: float) -> dict[str, Any]:
    """The drive with neither recorder nor ring."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "settings.toml").write_text("[recording]\nring_s = 0\n")
        console = Console(Path(folder))
        try:
            time.sleep(SETTLE_S)
            return drive(console, seconds)
        finally:
            console.close()


def measured_with(seconds: float, out: Path) -> dict[str, Any]:
    """The drive while it is recorded → what the recorder says, and costs; the file is `out`."""
    with tempfile.TemporaryDirectory() as folder:
        console = Console(Path(folder))
        try:
            time.sleep(SETTLE_S)
            console.answer("/api/recordings/start", {"name": "drive"})
            recorder = recorder_of(console)
            spent, began = sum(recorder.cpu_times()[:2]), time.monotonic()
            times = drive(console, seconds)
            share = (sum(recorder.cpu_times()[:2]) - spent) / (time.monotonic() - began)
            memory = recorder.memory_info().rss
            done = console.answer("/api/recordings/stop")
            out.write_bytes((Path(folder) / "recordings" / "drive.mcap").read_bytes())
            found = {**times, "recorder_core_percent": round(100 * share, 1), "recorder_mb": round(memory / 1e6)}
            return {**found, "faults": console.faults(), "answer": done}
        finally:
            console.close()


def by_mcap(path: Path) -> dict[str, int]:
    """Count by the index, every chunk's checksum verified."""
    counts: Counter[str] = Counter()
    with path.open("rb") as file:
        for _, channel, _ in make_reader(file, validate_crcs=True).iter_messages():
            counts[channel.topic] += 1
    return dict(counts)


def by_rosbags(path: Path) -> dict[str, int]:
    """Count what AnyReader decodes."""
    counts: Counter[str] = Counter()
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
            counts[connection.topic] += 1
    return dict(counts)


def doctor(path: Path) -> list[str]:
    """What is wrong with a file: the order of times, sizes of chunks, schemas, index and statistics."""
    wrong: list[str] = []
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        if header.profile != "ros2":
            wrong.append("profile")
        if summary is None or summary.statistics is None:
            return [*wrong, "no summary"]
        if any(not summary.schemas[one.schema_id].data for one in summary.channels.values()):
            wrong.append("a channel without schema")
        chunks = sorted(summary.chunk_indexes, key=lambda one: one.chunk_start_offset)
        if any(one.uncompressed_size > 16 * CHUNK_BYTES or one.compression != "zstd" for one in chunks):
            wrong.append("a chunk that is too large, or not packed")
        if any(one.message_end_time - one.message_start_time > 2e9 for one in chunks):
            wrong.append("a chunk of more than two seconds")
        last, sequences = 0, dict[int, int]()
        for _, channel, message in reader.iter_messages(log_time_order=False):
            if message.log_time < last:
                wrong.append(f"{channel.topic} goes back in time")
            if message.sequence != sequences.get(channel.id, 0):
                wrong.append(f"{channel.topic} lacks a number")
            last, sequences[channel.id] = message.log_time, message.sequence + 1
    if {number: count for number, count in summary.statistics.channel_message_counts.items() if count} != sequences:
        wrong.append("the statistics")
    return wrong[:20]


def told_by(command: list[str], **more: Any) -> Any:
    """Run a reader → its JSON, or the end of what it complained of."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, **more)
    return json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else done.stderr[-400:]


def readings(path: Path, python: str | None, node: Path | None) -> dict[str, Any]:
    """Messages per topic by every reader."""
    found: dict[str, Any] = {"mcap": by_mcap(path), "rosbags": by_rosbags(path)}
    if python:
        found["mcap-ros2-support"] = told_by([python, "-c", READ_BY_ROS2_SUPPORT, str(path)])
        found["evo"] = {topic: told_by([python, "-c", READ_BY_EVO, str(path), topic]) for topic in ("/pose", "/odom")}
    if node:
        found["node"] = told_by(
            ["node", "-e", READ_BY_NODE, "--", "x", str(path.resolve())],
            cwd=node,
            env={**os.environ, "NODE_PATH": str(node / "node_modules")},
        )
    log = open_log(path)
    found["beckon"] = {"scans": len(log), "warnings": list(log.report.warnings)}
    return found


def compared(counts: dict[str, int], found: dict[str, Any]) -> dict[str, bool]:
    """Say which readers found what the recorder counted."""
    return {name: one == counts for name, one in found.items() if name not in ("evo", "beckon")}


def main(
    *,
    seconds: float = 600.0,
    without: float = 120.0,  # seconds of the drive without a recorder
    out: Path = Path("drive.mcap"),
    python: str | None = None,
    node: Path | None = None,
) -> object:
    bare = measured_without(without) if without > 0 else None
    recorded = measured_with(seconds, out)
    counts = recorded.pop("answer")["messages"]
    found = readings(out, python, node)
    return {
        "without": bare,
        "recorded": recorded,
        "megabytes": round(out.stat().st_size / 1e6, 1),
        "doctor": doctor(out),
        "counts": counts,
        "equal": compared(counts, found),
        "found": {name: found[name] for name in ("evo", "beckon") if name in found},
    }


if __name__ == "__main__":
    run_command(main)
