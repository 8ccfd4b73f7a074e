"""Cut, damaged and hostile logs: what can be read is read, the rest is told in a sentence."""

import gzip
import io
import itertools
import json
import os
import sqlite3
import struct
import time
import tracemalloc
import zipfile

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType
from rosbags.rosbag1 import Writer as Ros1Writer

from core.errors import BadInput
from core.recording import LogSettings, open_log
from core.recording.drive import is_drive
from tests.core.recording.log_writers import (
    START,
    carmen_lines,
    one,
    ranges_of,
    robot_messages,
    two,
    write_bag,
    write_folder,
    write_mcap,
)

MAGIC = b"\x89MCAP0\r\n"


def archive_of(**arrays) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def scan_set() -> bytes:
    poses = np.column_stack([np.arange(8) * 0.1, np.zeros((8, 2))])
    return archive_of(
        t=START + np.arange(8.0), odo_raw=poses, scan_cm=np.tile(np.arange(210, 390, dtype=np.uint16), (8, 1))
    )


def frozen_runs() -> bytes:
    rows = np.array([[run, k, 1, 2.0, 0.1] for run in range(2) for k in (8, 16)], float)
    return archive_of(v_noisy=np.full((2, 16), 0.1), steer_noisy=np.zeros((2, 16)), obs=rows, still_obs=rows)


def corridor() -> bytes:
    rows = np.array([[k, 3, 2.0, 0.1] for k in range(9)], float)
    return archive_of(odo=np.full((10, 3), 0.01), odo_cov=np.full((10, 6), 1e-4), obs=rows)


VICTORIA = "".join(f"ODOMETRY {n} {n + 1} 0.1 0 0.01\nLANDMARK {n + 1} 900 {5 - 0.1 * n} 1\n" for n in range(20))
JSON_LINES = "".join(json.dumps({"t": 0.1 * n, "ranges": ranges_of(n, 20).tolist()}) + "\n" for n in range(20))


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A good file of every form: (name, bytes)."""
    folder = tmp_path_factory.mktemp("good")
    mcap = write_mcap(folder / "zstd.mcap", robot_messages(two))
    plain = write_mcap(folder / "plain.mcap", robot_messages(two), CompressionType.NONE)
    bag = write_bag(folder / "plain.bag", robot_messages(one))
    packed = write_bag(folder / "packed.bag", robot_messages(one), Ros1Writer.CompressionFormat.LZ4)
    base = next(write_folder(folder / "folder", robot_messages(two)).glob("*.db3"))
    return {
        "zstd.mcap": mcap.read_bytes(),
        "plain.mcap": plain.read_bytes(),
        "plain.bag": bag.read_bytes(),
        "packed.bag": packed.read_bytes(),
        "base.db3": base.read_bytes(),
        "carmen.log": "\n".join(carmen_lines()).encode(),
        "carmen.log.gz": gzip.compress("\n".join(carmen_lines()).encode()),
        "scans.jsonl": JSON_LINES.encode(),
        "victoria.txt": VICTORIA.encode(),
        "intel.npz": scan_set(),
        "runs.npz": frozen_runs(),
        "corridor.npz": corridor(),
    }


FORMS = [
    "zstd.mcap", "plain.mcap", "plain.bag", "packed.bag", "base.db3", "carmen.log", "carmen.log.gz", "scans.jsonl",
    "victoria.txt", "intel.npz", "runs.npz", "corridor.npz",
]  # fmt: skip


def mutated(content: bytes, rng: np.random.Generator) -> bytes:
    """Cut, flipped, overwritten, repeated or grown."""
    bytes_ = bytearray(content)
    kind = rng.integers(6)
    at = int(rng.integers(len(bytes_)))
    if kind == 0:
        return bytes(bytes_[:at])
    if kind == 1:
        for place in rng.integers(0, len(bytes_), 8):
            bytes_[place] ^= 1 << int(rng.integers(8))
    elif kind == 2:
        bytes_[at : at + 8] = b"\xff" * 8
    elif kind == 3:
        bytes_[at : at + 40] = rng.bytes(40)
    elif kind == 4:
        bytes_[at:at] = bytes_[at // 2 : at]
    else:
        bytes_[at : at + 4] = struct.pack("<I", int(rng.integers(1 << 32)))
    return bytes(bytes_)


@pytest.mark.parametrize("form", FORMS)
def test_sixty_mutations_of_every_form_are_read_or_refused_in_a_sentence(form, good, tmp_path):
    rng = np.random.default_rng(FORMS.index(form))
    read = 0
    path = tmp_path / form
    with np.errstate(all="ignore"):
        for _ in range(60):
            path.write_bytes(mutated(good[form], rng))
            began = time.process_time()
            try:
                recording = open_log(path)
            except BadInput as refusal:
                assert str(refusal).endswith((".", "?"))
            else:
                read += 1
                stamps = [item.stamp for item in recording]
                assert all(a < b for a, b in itertools.pairwise(stamps)) and np.isfinite(stamps).all()
            assert time.process_time() - began < 2.0
    assert read > 1


@pytest.mark.parametrize("form", ["zstd.mcap", "plain.mcap", "plain.bag"])
def test_a_log_cut_in_the_middle_gives_its_first_half(form, good, tmp_path):
    path = tmp_path / form
    path.write_bytes(good[form][: int(len(good[form]) * 0.5)])
    recording = open_log(path)
    assert 5 <= len(recording) <= 19
    assert recording.report.skipped >= 1
    assert "records skipped" in recording.report.warnings[0]


def test_reading_goes_on_behind_a_damaged_place_of_an_mcap(tmp_path):
    path = write_mcap(tmp_path / "log.mcap", robot_messages(two, scans=60), chunk_size=2048)
    content = bytearray(path.read_bytes())
    content[2000:2500] = bytes(500)
    path.write_bytes(content)
    recording = open_log(path)
    assert 50 <= len(recording) < 60
    assert recording.scans[-1].stamp == pytest.approx(START + 5.9, abs=1e-6)
    assert any("The file says it holds 181 messages" in sentence for sentence in recording.report.warnings)


def test_reading_goes_on_behind_a_damaged_place_of_a_bag(tmp_path):
    path = write_bag(tmp_path / "log.bag", robot_messages(one, scans=60))
    content = bytearray(path.read_bytes())
    place = content.index(b"op=\x02", len(content) // 3)
    content[place - 10 : place + 4] = bytes(14)
    path.write_bytes(content)
    recording = open_log(path)
    assert len(recording) >= 15 and recording.report.skipped >= 1


def test_a_lying_index_of_a_bag_costs_no_message(tmp_path):
    """The length of the index record behind the first chunk reaches into the second chunk."""
    writer = Ros1Writer(tmp_path / "log.bag")
    writer.chunk_threshold = 20_000
    with writer:
        store = one.store
        connection = writer.add_connection("/scan", "sensor_msgs/msg/LaserScan", typestore=store)
        for n in range(100):
            stamp = START + 0.1 * n
            message = store.serialize_ros1(one.scan(stamp, ranges_of(n)), "sensor_msgs/msg/LaserScan")
            writer.write(connection, round(stamp * 1e9), message)
    path = tmp_path / "log.bag"
    content = bytearray(path.read_bytes())
    header = content.index(b"op=\x04") - 4
    while True:  # back to the start of that header
        header -= 1
        (size,) = struct.unpack_from("<I", content, header)
        if size < 100 and header + 4 + size > content.index(b"op=\x04"):
            break
    (length,) = struct.unpack_from("<I", content, header + 4 + size)
    struct.pack_into("<I", content, header + 4 + size, length + 2224)
    path.write_bytes(content)
    recording = open_log(path)
    assert len(recording) == 100
    assert "All 100 messages" in recording.report.warnings[-1]


def test_a_failed_checksum_is_told(tmp_path):
    path = write_mcap(tmp_path / "log.mcap", robot_messages(two), CompressionType.NONE)
    content = bytearray(path.read_bytes())
    place = content.index(np.float32(1.5).tobytes())
    content[place : place + 4] = np.float32(4.5).tobytes()
    path.write_bytes(content)
    assert "checksum" in " ".join(open_log(path).report.warnings)


def bomb(declared: int, true: int) -> bytes:
    """An MCAP of one chunk that unpacks to `true` bytes and says `declared`."""
    packed = zstandard.compress(bytes(true))
    chunk = struct.pack("<QQQI", 0, 0, declared, 0) + b"\x04\0\0\0zstd" + struct.pack("<Q", len(packed)) + packed
    return MAGIC + struct.pack("<BQ", 6, len(chunk)) + chunk


@pytest.mark.parametrize("declared", [1 << 27, 1000])
def test_a_decompression_bomb_stays_small(declared, tmp_path):
    path = tmp_path / "bomb.mcap"
    path.write_bytes(bomb(declared, 1 << 27))
    tracemalloc.start()
    try:
        with pytest.raises(BadInput, match="no laser scans"):
            open_log(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_an_archive_that_promises_too_much_is_refused(tmp_path):
    path = tmp_path / "log.npz"
    header = b"\x93NUMPY\x01\x00" + struct.pack("<H", 118)
    text = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("t", "scan_cm"):
            archive.writestr(f"{name}.npy", header + text.ljust(117) + b"\n" + bytes(80))
    with pytest.raises(BadInput, match=r"t in log\.npz is damaged"):
        open_log(path)


def test_an_archive_with_objects_inside_is_refused(tmp_path):
    path = tmp_path / "log.npz"
    path.write_bytes(archive_of(t=np.array([{}, {}], object), scan_cm=np.ones((2, 3))))
    with pytest.raises(BadInput, match="damaged"):
        open_log(path)


def test_a_database_that_would_never_end_is_stopped(tmp_path):
    path = tmp_path / "log.db3"
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE topics (id, name, type, serialization_format)")
    base.execute(
        "CREATE VIEW messages AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x FROM n) "
        "SELECT x AS topic_id, x AS timestamp, x AS data FROM n"
    )
    base.commit()
    base.close()
    with pytest.raises(BadInput, match="not a ROS 2 bag"):
        open_log(path)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("empty.mcap", b"", "is empty"),
        ("none.mcap", b"hello", "not an MCAP file"),
        ("old.bag", b"#ROSBAG V1.2\n", "from before version 2.0"),
        ("text.db3", b"hello", "no SQLite database"),
        ("text.npz", b"hello", "not a NumPy archive"),
        ("text.log", b"hello\n", "no known form of log"),
        ("sound.wav", b"RIFF\0\0\n{\n{\n", "no known form of log"),
        ("bare.mcap", MAGIC, "no laser scans"),
        ("line.jsonl", b"{" + b" " * 10_000_000, "no scans"),
        ("deep.jsonl", b'{"ranges":' + b"[" * 100_000, "no scans"),
    ],
)
def test_files_that_are_no_logs_are_refused_in_a_sentence(name, content, words, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadInput, match=words):
        open_log(tmp_path / name)


def test_folders_missing_files_and_strange_paths_are_refused_in_a_sentence(tmp_path):
    for path in (tmp_path, tmp_path / "absent.mcap", "nul\0byte", "x" * 5000, tmp_path / "absent#7"):
        with pytest.raises(BadInput, match=r"[.?]$"):
            open_log(path)


def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert not is_drive(tmp_path / "pipe")
    with pytest.raises(BadInput, match="not a file"):
        open_log(tmp_path / "pipe")


def test_limits_are_kept_and_told(tmp_path):
    path = write_mcap(tmp_path / "log.mcap", robot_messages(two))
    with pytest.raises(BadInput, match="largest_file_mb"):
        open_log(path, LogSettings(largest_file_mb=1e-4))
    recording = open_log(path, LogSettings(most_readings_mb=0.004))
    assert len(recording) < 20 and "log.most_readings_mb" in recording.report.warnings[0]
    with pytest.raises(BadInput, match="more than is read"):
        open_log(path, LogSettings(largest_block_mb=1e-4))
