"""Recordings made wrong in known ways: `python -m tests.benchmarks.recording_variants`.

Each sound drive is written again and again, every time with another defect (units, signs, clocks, frozen scans, odd
messages, files and texts), and goes through `slam_log`. Right is an error of at most twice that of the sound drive in
the same form (0.03 m at least), or a sentence; wrong is what has neither. With `--files` the recordings of
shared/data/strangers are judged instead, against the truth beside them.
"""

import gzip
import io
import itertools
import math
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.pipelines.slam import slam_log
from core.recording import ScanRecording, open_log
from core.sensors import Laser
from core.sensors.checks import faults_of
from core.simulation.laser import SimulatedLaser
from core.simulation.world import world_named
from tests.benchmarks.command import print_row, run_command
from tests.core.recording.log_writers import ODOMETRY, ROS2, SCAN, TF, one, two, write_bag, write_mcap
from tests.core.slam.scan_matching.slipping_wheels import PERIOD_S, slipping_wheels

STRANGERS = Path(__file__).parents[3] / "shared" / "data" / "strangers" / "recordings"
INTEL = Path(__file__).parents[3] / "shared" / "data" / "intel-lab" / "intel.npz"
LASER = Laser(beams=181, angle_min=-math.pi / 2 * 1.33, angle_step=math.radians(1.33), time_step=0.0, rate=5.0)
BEGUN_S = 1.7e9  # Unix time
FULL_SWEEP_S = 0.15
LEAST_ERROR_M = 0.03
LOOKING_BACK = ("09_slashes_tf_only.bag", "16_recorder_died.bag.active")  # their laser of 240° sees another half …
BACKWARD_ERROR_M = 0.030  # … of the room: the error of a sound recording of that drive


@dataclass(frozen=True)
class Drive:
    """A drive as its devices tell it."""

    name: str
    stamps: np.ndarray  # (N,) [s]
    ranges: np.ndarray  # (N, B) [m]; inf: nothing there
    angles: tuple[float, float]  # of the first beam, from beam to beam [rad]
    range_max: float  # [m]
    times: np.ndarray  # (M,) [s] of the odometry
    poses: np.ndarray  # (M, 3)
    truth: np.ndarray | None = None  # (N, 3) robot poses; None: the sound drive's estimate stands for it
    ahead: float = 0.0  # [m] of the laser before the robot's middle


Making = Callable[[Drive, np.random.Generator], Drive]  # what its devices tell, in whatever form
Row = tuple[str, str, float, Any]  # topic, type, recorder's time [s], message
Writing = Callable[[Drive, Path, np.random.Generator], Path]  # into a folder, in one form


def simulated(world: str, seed: int) -> Drive:
    """A drive in a world of the simulator; its wheels slip by a few percent."""
    rng = np.random.default_rng(seed)
    laser, place, rows = SimulatedLaser(LASER, rng), world_named(world), []
    for _, _, truth, rolled in slipping_wheels(rng):
        stamp = PERIOD_S * len(rows)
        scan = laser.scan(place, stamp, np.array([stamp - 1, stamp + 1]), np.tile(truth.vector, (2, 1)))
        rows.append((stamp, scan.ranges, rolled.vector, truth.vector))
    stamps, ranges, poses, true = (np.array(column) for column in zip(*rows, strict=True))
    return Drive(
        f"sim:{world}",
        BEGUN_S + stamps,
        ranges,
        (LASER.angle_min, LASER.angle_step),
        LASER.range_max,
        BEGUN_S + stamps,
        poses,
        true,
    )


def beginning(drive: Drive, seconds: float) -> Drive:
    """The first seconds of a simulated drive."""
    count = round(seconds / PERIOD_S)
    assert drive.truth is not None and count < len(drive.stamps)
    rows = ("stamps", "ranges", "times", "poses", "truth")
    return replace(drive, **{name: getattr(drive, name)[:count] for name in rows})


def recorded(path: Path, name: str, most: int) -> Drive:
    """The first scans of a log."""
    read = open_log(path)
    assert isinstance(read, ScanRecording) and read.track is not None
    scans = read.scans[:most]
    within = read.track.times <= scans[-1].stamp + 1.0
    track = None
    if path.parent == STRANGERS:
        truth = np.genfromtxt(STRANGERS / "truth.csv", delimiter=",", names=True)
        seconds = np.array([scan.stamp for scan in scans]) - np.floor(scans[0].stamp)
        track = np.column_stack(
            [np.interp(seconds, truth["t_s"], truth[key]) for key in ("x_m", "y_m", "heading_rad")]
        )
    return Drive(
        name,
        np.array([scan.stamp for scan in scans]),
        np.array([scan.ranges for scan in scans]),
        (scans[0].angle_min, scans[0].angle_step),
        scans[0].range_max,
        read.track.times[within],
        read.track.poses[within],
        track,
        read.laser.mounting.x,
    )


BASES: dict[str, Callable[[], Drive]] = {
    "lab": lambda: simulated("lab", 3),
    "lab 28 s": lambda: beginning(simulated("lab", 3), 28.0),
    "floor": lambda: simulated("floor", 5),
    "strangers": lambda: recorded(STRANGERS / "10_short_control.mcap", "strangers", 200),
    "intel": lambda: recorded(INTEL, "intel", 100),
}


def of_poses(change: Callable[[np.ndarray], np.ndarray]) -> Making:
    return lambda drive, _: replace(drive, poses=change(drive.poses.copy()))


def of_headings(change: Callable[[np.ndarray], np.ndarray]) -> Making:
    return lambda drive, _: replace(drive, poses=np.column_stack([drive.poses[:, :2], change(drive.poses[:, 2])]))


def of_ranges(change: Callable[[np.ndarray], np.ndarray], limit: float | None = None) -> Making:
    def make(drive: Drive, _: np.random.Generator) -> Drive:
        return replace(
            drive,
            ranges=np.ascontiguousarray(change(drive.ranges)),
            range_max=drive.range_max * (1.0 if limit is None else limit),
        )

    return make


def frozen(part: slice) -> Making:
    def make(drive: Drive, _: np.random.Generator) -> Drive:
        ranges, count = drive.ranges.copy(), len(drive.ranges)
        rows = range(*slice(round((part.start or 0) * count), round((part.stop or 1) * count)).indices(count))
        ranges[rows] = ranges[rows[0]]
        return replace(drive, ranges=ranges)

    return make


def frozen_now_and_then(drive: Drive, rng: np.random.Generator) -> Drive:
    """A quarter of the time the driver repeats its last scan."""
    ranges = drive.ranges.copy()
    for number in range(1, len(ranges)):
        if rng.random() < 0.25:
            ranges[number] = ranges[number - 1]
    return replace(drive, ranges=ranges)


def frozen_in_runs(drive: Drive, rng: np.random.Generator) -> Drive:
    """Ten scans of forty are those before."""
    ranges = drive.ranges.copy()
    for start in range(30, len(ranges), 40):
        ranges[start : start + 10] = ranges[start - 1]
    return replace(drive, ranges=ranges)


def as_intensities(drive: Drive, rng: np.random.Generator) -> Drive:
    """Reflectivities 0-255 where the ranges should be."""
    shown = np.nan_to_num(drive.ranges, posinf=drive.range_max, nan=0.0)
    return replace(drive, ranges=np.round(255 / (1 + shown**2) + 10 * rng.random(shown.shape)))


def as_shares(drive: Drive, rng: np.random.Generator) -> Drive:
    """Reflectivities 0-1 where the ranges should be."""
    return replace(drive, ranges=np.round(0.1 + 0.9 * rng.random(drive.ranges.shape), 3))


def as_thousands(drive: Drive, rng: np.random.Generator) -> Drive:
    """Echo strengths of thousands, scattered."""
    return replace(drive, ranges=np.round(1000 + 3000 * rng.random(drive.ranges.shape)))


def two_after_each_other(gap_s: float) -> Making:
    """The drive, and after it another one that begins elsewhere: its second half backwards in space."""

    def make(drive: Drive, _: np.random.Generator) -> Drive:
        lasted = drive.stamps[-1] - drive.stamps[0] + gap_s
        half, middle = len(drive.stamps) // 2, len(drive.times) // 2
        other_poses = np.array(
            [(Pose(*drive.poses[middle]).inverse() @ Pose(*row)).vector for row in drive.poses[middle:].tolist()]
        )
        return replace(
            drive,
            stamps=np.concatenate([drive.stamps[:half], drive.stamps[:half] + lasted]),
            ranges=np.concatenate([drive.ranges[:half], drive.ranges[half : 2 * half]]),
            times=np.concatenate([drive.times[:middle], drive.times[: len(drive.times) - middle] + lasted]),
            poses=np.concatenate([drive.poses[:middle], other_poses]),
            truth=None,
        )

    return make


def written_twice(later: float) -> Making:
    """Every scan comes again so many periods later."""

    def make(drive: Drive, _: np.random.Generator) -> Drive:
        stamps = np.concatenate([drive.stamps, drive.stamps + later * float(np.median(np.diff(drive.stamps)))])
        order = np.argsort(stamps, kind="stable")
        return replace(drive, stamps=stamps[order], ranges=np.concatenate([drive.ranges, drive.ranges])[order])

    return make


def speeds(times: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Speed ahead and turn rate (M, 2) of poses at times."""
    headings = np.unwrap(poses[:, 2])
    x, y = np.gradient(poses[:, 0], times), np.gradient(poses[:, 1], times)
    return np.column_stack([x * np.cos(headings) + y * np.sin(headings), np.gradient(headings, times)])


def rows_of(drive: Drive, kind: Any = two) -> list[Row]:
    """The drive as messages, by time."""
    twists = speeds(drive.times, drive.poses)
    first, step = drive.angles
    rows: list[Row] = [
        ("/tf_static", TF, float(drive.stamps[0]), kind.tf(0.0, "base_link", "laser", (drive.ahead, 0.0, 0.0)))
    ]
    for t, pose, twist in zip(drive.times.tolist(), drive.poses.tolist(), twists.tolist(), strict=True):
        rows.append(("/odom", ODOMETRY, t, kind.odometry(t, pose, twist=tuple(twist))))
    for t, ranges in zip(drive.stamps.tolist(), drive.ranges, strict=True):
        ends = {"angle_min": first, "angle_max": first + step * (len(ranges) - 1), "time_increment": 0.0}
        rows.append(("/scan", SCAN, t, kind.scan(t, ranges, step=step, range_max=drive.range_max, **ends)))
    return sorted(rows, key=lambda row: row[2])


def to_mcap(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
    """Write the drive as messages; the twists are those of the sound wheels."""
    return write_mcap(folder / "drive.mcap", rows_of(drive))


def to_carmen(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
    """Write the drive as text: ROBOTLASER1 and ODOM lines."""
    twists = speeds(drive.times, drive.poses)
    header = f"PARAM robot_frontlaser_offset {drive.ahead:.4f}\n"
    lines = [
        (
            float(t),
            "ODOM " + " ".join(f"{v:.6f}" for v in (*row, *twist, 0.0)) + f" {t:.6f} host {t - drive.times[0]:.6f}",
        )
        for t, row, twist in zip(drive.times, drive.poses.tolist(), twists.tolist(), strict=True)
    ]
    first, step = drive.angles
    for t, row in zip(drive.stamps, drive.ranges, strict=True):
        beams = np.nan_to_num(row, nan=0.0, posinf=drive.range_max + 1.0)
        told = " ".join(f"{v:.4f}" for v in beams)
        head = f"RAWLASER1 0 {first:.6f} {step * (len(beams) - 1):.6f} {step:.8f} {drive.range_max:.3f} 0.01 0"
        lines.append(
            (float(t), f"{head} {len(beams)} {told} 0 {t:.6f} host {t - min(drive.stamps[0], drive.times[0]):.6f}")
        )
    lines.sort(key=lambda one: one[0])
    path = folder / "drive.log"
    path.write_text(header + "\n".join(line for _, line in lines) + "\n")
    return path


def arrays_of(drive: Drive) -> dict[str, Any]:
    """The drive as a scan set: times [s], 181 ranges [cm] of half a turn, odometry at the scans."""
    heading = np.unwrap(drive.poses[:, 2])
    at = np.column_stack(
        [np.interp(drive.stamps, drive.times, v) for v in (drive.poses[:, 0], drive.poses[:, 1], heading)]
    )
    first, step = drive.angles
    beams = np.rint((np.linspace(-math.pi / 2, math.pi / 2, 181) - first) / step).astype(int)
    ranges = np.nan_to_num(drive.ranges[:, beams % drive.ranges.shape[1]], nan=0.0, posinf=82.0)
    return {"t": drive.stamps - drive.stamps[0], "scan_cm": (100 * ranges).astype(np.float32), "odo_raw": at}


def npz(change: Callable[[dict[str, Any]], dict[str, Any]]) -> Writing:
    """Change the arrays of a scan set."""

    def made(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
        path = folder / "drive.npz"
        np.savez(path, **change(arrays_of(drive)))
        return path

    return made


WRITERS: dict[str, Writing] = {"mcap": to_mcap, "log": to_carmen, "npz": npz(lambda arrays: arrays)}


def messages(change: Callable[[list[Row], np.random.Generator], Iterable[Row]], **options: Any) -> Writing:
    return lambda drive, folder, rng: write_mcap(folder / "odd.mcap", change(rows_of(drive), rng), **options)


def each(topic: str, change: Callable[[Any, int, np.random.Generator], Any]) -> Writing:
    """Change every message of a topic; `change` gets its number, and gives a new one or None for none."""

    def changed(rows: list[Row], rng: np.random.Generator) -> Iterable[Row]:
        number = 0
        for row in rows:
            if row[0] != topic:
                yield row
                continue
            message = change(row[3], number, rng)
            number += 1
            if message is not None:
                yield (*row[:3], message)

    return messages(changed)


def scans(change: Callable[[Any, int, np.random.Generator], dict[str, Any] | None]) -> Writing:
    """Change fields of every scan."""

    def changed(scan: Any, number: int, rng: np.random.Generator) -> Any:
        fields = change(scan, number, rng)
        if fields is None:
            return None
        if "ranges" in fields:
            fields["ranges"] = np.ascontiguousarray(fields["ranges"], np.float32)
        return replace(scan, **fields)

    return each("/scan", changed)


def poses(change: Callable[[np.ndarray, int, np.random.Generator], Any]) -> Writing:
    """Change (x, y, qx, qy, qz, qw) of every odometry."""

    def changed(told: Any, number: int, rng: np.random.Generator) -> Any:
        place, turn = told.pose.pose.position, told.pose.pose.orientation
        x, y, qx, qy, qz, qw = map(
            float, change(np.array([place.x, place.y, turn.x, turn.y, turn.z, turn.w]), number, rng)
        )
        pose = replace(
            told.pose.pose, position=replace(place, x=x, y=y), orientation=replace(turn, x=qx, y=qy, z=qz, w=qw)
        )
        return replace(told, pose=replace(told.pose, pose=pose))

    return each("/odom", changed)


def twists(speed: float, turn_rate: float) -> Writing:
    """Multiply the speeds of every odometry, its places unchanged."""

    def changed(told: Any, *_: Any) -> Any:
        twist = told.twist.twist
        linear = replace(twist.linear, x=twist.linear.x * speed)
        angular = replace(twist.angular, z=twist.angular.z * turn_rate)
        return replace(told, twist=replace(told.twist, twist=replace(twist, linear=linear, angular=angular)))

    return each("/odom", changed)


def covariances(value: float) -> Writing:
    """Say this for every number of the odometry's covariances."""
    filled = np.full(36, value)
    return each(
        "/odom",
        lambda told, *_: replace(
            told, pose=replace(told.pose, covariance=filled), twist=replace(told.twist, covariance=filled)
        ),
    )


def restamped(topic: str, change: Callable[[float, float], float], recorded: bool = False) -> Writing:
    """Change the stamps of a topic ("": all): from the first one [s] and since then [s]."""

    def changed(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
        begun = rows[0][2]
        for name, kind, t, message in rows:
            if name in ("/scan", "/odom") and topic in ("", name):
                stamp = change(begun, t - begun)
                message = replace(message, header=two.header(stamp, message.header.frame_id))
                t = stamp if recorded else t
            yield name, kind, t, message

    return messages(changed)


def gap(topics: tuple[str, ...], start: float = 0.4, end: float = 0.55) -> Writing:
    """Leave out a part of some topics."""

    def changed(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
        first, lasted = rows[0][2], rows[-1][2] - rows[0][2]
        return (row for row in rows if not (row[0] in topics and start < (row[2] - first) / lasted < end))

    return messages(changed)


def transforms(*told: Any) -> Writing:
    """Say other static transforms: (parent, child, pose) each, or a message."""

    def changed(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
        first = rows[0][2]
        kept = [row for row in rows if row[0] != "/tf_static"]
        made = [one if not isinstance(one, tuple) else two.tf(0.0, *one) for one in told]
        return [*(("/tf_static", TF, first, one) for one in made), *kept]

    return messages(changed)


def quaternion_tf(scale: float) -> Any:
    """The transform of the laser, its quaternion not of length 1."""
    message = two.tf(0.0, "base_link", "laser", (0.0, 0.0, 0.0))
    (one,) = message.transforms
    turn = replace(one.transform.rotation, w=scale, z=0.0, x=0.0, y=0.0)
    return replace(message, transforms=[replace(one, transform=replace(one.transform, rotation=turn))])


def second_laser(other_frame: bool) -> Writing:
    """Every second scan is that of a laser that looks backwards."""

    def changed(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
        number = 0
        if other_frame:
            yield "/tf_static", TF, rows[0][2], two.tf(0.0, "base_link", "rear", (0.0, 0.0, math.pi))
        for row in rows:
            if row[0] != "/scan":
                yield row
                continue
            number += 1
            scan = row[3]
            if number % 2:
                yield row
                continue
            turned = np.roll(scan.ranges, len(scan.ranges) // 2)
            frame = "rear" if other_frame else "laser"
            yield (*row[:3], replace(scan, ranges=turned, header=replace(scan.header, frame_id=frame)))

    return messages(changed)


def text(change: Callable[[str], str | bytes], name: str = "odd.log") -> Writing:
    """Change the text of a CARMEN log."""

    def made(drive: Drive, folder: Path, rng: np.random.Generator) -> Path:
        content = change(to_carmen(drive, folder, rng).read_text())
        path = folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return made


def of_bytes(change: Callable[[bytes], bytes], name: str, bag: bool = False) -> Writing:
    """Change the bytes of an MCAP file, or of a bag."""

    def made(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
        if bag:
            sound = write_bag(folder / "sound.bag", rows_of(drive, one))
        else:
            sound = write_mcap(folder / "sound.mcap", rows_of(drive))
        path = folder / name
        path.write_bytes(change(sound.read_bytes()))
        return path

    return made


def zipped(content: bytes) -> bytes:
    """A zip archive with one file."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("sound.mcap", content)
    return buffer.getvalue()


def tarred(content: bytes) -> bytes:
    """A packed tar archive with one file."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as archive:
        info = tarfile.TarInfo("sound.mcap")
        info.size = len(content)
        archive.addfile(info, io.BytesIO(content))
    return buffer.getvalue()


def stamps_of_text(change: Callable[[float], float]) -> Callable[[str], str]:
    """Change the times of every line of a CARMEN log."""

    def changed(content: str) -> str:
        lines = []
        for line in content.splitlines():
            words = line.split()
            if words[0] in ("ODOM", "RAWLASER1"):
                words[-3], words[-1] = (f"{change(float(words[k])):.3f}" for k in (-3, -1))
            lines.append(" ".join(words))
        return "\n".join(lines) + "\n"

    return changed


def of_lines(change: Callable[[list[str]], list[str]]) -> Callable[[str], str]:
    """Change the words of every line of scans."""

    def changed(content: str) -> str:
        return (
            "\n".join(
                " ".join(change(line.split())) if line.startswith("RAWLASER1") else line
                for line in content.splitlines()
            )
            + "\n"
        )

    return changed


def reversed_beams(words: list[str]) -> list[str]:
    """The words of a line of scans, its beams in reverse order."""
    end = 9 + int(words[8])
    return [*words[:9], *reversed(words[9:end]), *words[end:]]


def turned_beams(words: list[str]) -> list[str]:
    """The words of a line of scans of a laser that looks to the left: its first quarter of the field is not seen."""
    end, quarter = 9 + int(words[8]), round(math.pi / 2 / float(words[4]))
    return [*words[:9], *words[9 + quarter : end], *["0"] * quarter, *words[end:]]


def _odometry_of_increments(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
    heading = drive.poses[:, 2]
    steps = np.diff(drive.poses, axis=0, prepend=drive.poses[:1])
    c, s = np.cos(heading), np.sin(heading)
    moved = np.column_stack([c * steps[:, 0] + s * steps[:, 1], -s * steps[:, 0] + c * steps[:, 1], steps[:, 2]])
    return write_mcap(folder / "odd.mcap", rows_of(replace(drive, poses=moved)))


def _seconds_swapped(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
    """Nanoseconds counted as microseconds: 0.25 s is written as .000250."""
    for name, kind, t, message in rows:
        if name in ("/scan", "/odom"):
            stamp = message.header.stamp
            header = replace(message.header, stamp=replace(stamp, nanosec=stamp.nanosec // 1000))
            message = replace(message, header=header)
        yield name, kind, t, message


def _truncated(rows: list[Row], rng: np.random.Generator) -> Iterable[Row]:
    for name, kind, t, message in rows:
        content = bytes(ROS2.serialize_cdr(message, kind))
        yield name, kind, t, content[: int(len(content) * rng.random())] if rng.random() < 0.2 else message


def _empty_topics(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
    first = rows[0][2]
    bare = two.scan(first, np.zeros(0, np.float32), step=0.01, angle_min=0.0, angle_max=0.0)
    return [
        ("/front/scan", SCAN, first, bare),
        ("/wheel/odom", ODOMETRY, first, two.odometry(first, (0, 0, 0))),
        *rows,
    ]


def quantized(metres: float, radians: float) -> Writing:
    """Round the odometry."""

    def made(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
        unit = np.array([metres, metres, radians])
        return write_mcap(folder / "odd.mcap", rows_of(replace(drive, poses=np.round(drive.poses / unit) * unit)))

    return made


def _half(scan: Any, *_: Any) -> dict[str, Any]:
    return {"ranges": scan.ranges[::2]}


def _wild(scan: Any, number: int, rng: np.random.Generator) -> dict[str, Any]:
    return {"ranges": np.roll(scan.ranges, int(rng.integers(len(scan.ranges))))}


def _swept(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
    """Scans say that they sweep 0.15 s, and are stamped at the end of it."""
    rows = [
        (
            name,
            kind,
            t,
            replace(message, time_increment=FULL_SWEEP_S / len(message.ranges)) if name == "/scan" else message,
        )
        for name, kind, t, message in rows_of(drive)
    ]
    return write_mcap(folder / "odd.mcap", rows)


def _body(scan: Any, *_: Any) -> dict[str, Any]:
    ranges, count = scan.ranges.copy(), len(scan.ranges)
    ranges[: count // 3] = 0.22
    return {"ranges": ranges}


def _stuck_sector() -> Writing:
    held: dict[str, Any] = {}

    def change(scan: Any, number: int, _: np.random.Generator) -> dict[str, Any]:
        if number == 0:
            held["first"] = scan.ranges
        ranges = scan.ranges.copy()
        ranges[: len(ranges) // 2] = held["first"][: len(ranges) // 2]
        return {"ranges": ranges}

    return scans(change)


def _written(making: Making, form: str) -> Writing:
    """Write what a drive becomes."""
    return lambda drive, folder, rng: WRITERS[form](making(drive, rng), folder, rng)


DRIVES: dict[str, Making] = {
    "x and y swapped": of_poses(lambda p: p[:, [1, 0, 2]]),
    "x negated": of_poses(lambda p: p * [-1, 1, 1]),
    "y negated": of_poses(lambda p: p * [1, -1, 1]),
    "x and y negated": of_poses(lambda p: p * [-1, -1, 1]),
    "heading negated": of_headings(lambda h: -h),
    "heading from y axis": of_headings(lambda h: h + math.pi / 2),
    "mirrored": of_poses(lambda p: p * [1, -1, -1]),
    "swapped and mirrored": of_poses(lambda p: np.column_stack([p[:, 1], p[:, 0], math.pi / 2 - p[:, 2]])),
    "heading clamped 0..180": of_headings(lambda h: np.clip((h + math.pi) % math.tau - math.pi, 0, math.pi)),
    "heading of 0..360 clamped": of_headings(lambda h: np.clip(h % math.tau, 0, math.pi)),
    "heading modulo 180": of_headings(lambda h: h % math.pi),
    "heading without sign": of_headings(lambda h: np.abs((h + math.pi) % math.tau - math.pi)),
    "heading in half turns": of_headings(lambda h: h / 2),
    "heading stands": of_headings(np.zeros_like),
    "ways x 100": of_poses(lambda p: p * [100, 100, 1]),
    "ways x 0.01": of_poses(lambda p: p * [0.01, 0.01, 1]),
    "ways x 10": of_poses(lambda p: p * [10, 10, 1]),
    "ways x 0.1": of_poses(lambda p: p * [0.1, 0.1, 1]),
    "ways x 1.3": of_poses(lambda p: p * [1.3, 1.3, 1]),
    "odometry in feet": of_poses(lambda p: p * [3.28084, 3.28084, 1]),
    "ranges in km": of_ranges(lambda r: r / 1000),
    "ranges in km, limits too": of_ranges(lambda r: r / 1000, 0.001),
    "ranges in dm": of_ranges(lambda r: r * 10),
    "ranges in dm, limits too": of_ranges(lambda r: r * 10, 10),
    "ranges in feet": of_ranges(lambda r: r * 3.28084),
    "ranges in feet, limits too": of_ranges(lambda r: r * 3.28084, 3.28084),
    "ranges in inches": of_ranges(lambda r: r * 39.37, 39.37),
    "ranges in yards": of_ranges(lambda r: r * 1.0936, 1.0936),
    "ranges in cm": of_ranges(lambda r: r * 100),
    "ranges in mm": of_ranges(lambda r: r * 1000, 1000),
    "ranges in um": of_ranges(lambda r: r * 1e6, 1e6),
    "ranges x 1.1": of_ranges(lambda r: r * 1.1),
    "ranges x 0.9": of_ranges(lambda r: r * 0.9),
    "ranges x 2": of_ranges(lambda r: r * 2, 2),
    "ranges x 0.5": of_ranges(lambda r: r / 2, 0.5),
    "ranges x 1.02": of_ranges(lambda r: r * 1.02),
    "ranges x 1.06": of_ranges(lambda r: r * 1.06),
    "ranges + 0.3 m": of_ranges(lambda r: r + 0.3),
    "ranges + 0.2 m": of_ranges(lambda r: r + 0.2),
    "ranges - 0.2 m": of_ranges(lambda r: np.where(r > 0.25, r - 0.2, np.nan)),
    "ranges inverted": of_ranges(lambda r: 1 / np.maximum(r, 0.05)),
    "6 m - ranges": of_ranges(lambda r: np.where(r < 6, 6 - r, np.nan)),
    "odometry trembles": lambda drive, rng: replace(
        drive, poses=drive.poses + rng.normal(0, 0.02, drive.poses.shape) * [1, 1, 0]
    ),
    "frozen scans": frozen(slice(0.0, 1.0)),
    "frozen from the middle": frozen(slice(0.5, 1.0)),
    "frozen for a quarter": frozen(slice(0.4, 0.65)),
    "frozen in runs": frozen_in_runs,
    "frozen now and then": frozen_now_and_then,
    "scans twice, at once": written_twice(0.1),
    "scans twice, later": written_twice(1.5),
    "places by satellite": lambda drive, rng: replace(
        drive, poses=drive.poses + rng.normal(0, 1.0, drive.poses.shape) * [0.3, 0.3, 0]
    ),
    "constant ranges": of_ranges(lambda r: np.full_like(r, 2.0)),
    "constant ranges, noisy": lambda drive, rng: replace(drive, ranges=2.0 + rng.normal(0, 0.01, drive.ranges.shape)),
    "intensities 0-255": as_intensities,
    "intensities 0-1": as_shares,
    "intensities of thousands": as_thousands,
    "reversed beams": of_ranges(lambda r: r[:, ::-1]),
    "two logs": two_after_each_other(30.0),
    "two logs at once": two_after_each_other(0.2),
    "two logs, a day apart": two_after_each_other(86400.0),
    "stamps x 1000": lambda d, _: replace(
        d, stamps=BEGUN_S + 1000 * (d.stamps - d.stamps[0]), times=BEGUN_S + 1000 * (d.times - d.times[0])
    ),
    "stamps / 1000": lambda d, _: replace(
        d, stamps=BEGUN_S + (d.stamps - d.stamps[0]) / 1000, times=BEGUN_S + (d.times - d.times[0]) / 1000
    ),
    "scans' stamps x 1.5": lambda d, _: replace(d, stamps=d.stamps[0] + 1.5 * (d.stamps - d.stamps[0])),
    "scans' stamps x 60": lambda d, _: replace(d, stamps=d.stamps[0] + 60 * (d.stamps - d.stamps[0])),
    "scans late by 1 s": lambda d, _: replace(d, stamps=d.stamps + 1.0),
}


MESSAGES: dict[str, Writing] = {
    # how beams are written
    "every other beam NaN": scans(lambda s, *_: {"ranges": np.where(np.arange(len(s.ranges)) % 2, np.nan, s.ranges)}),
    "a random half NaN": scans(lambda s, _, r: {"ranges": np.where(r.random(len(s.ranges)) < 0.5, np.nan, s.ranges)}),
    "one beam": scans(lambda s, *_: {"ranges": s.ranges[:1]}),
    "a million beams, first scan": scans(
        lambda s, n, _: {"ranges": np.resize(s.ranges, 1_000_000)} if n == 0 else {}
    ),
    "speeds in mm/s": twists(1000.0, 1.0),
    "turn rates in degrees/s": twists(1.0, 180 / math.pi),
    "speeds of the wrong sign": twists(-1.0, 1.0),
    "number of beams 1, 2, 3 …": scans(lambda s, n, _: {"ranges": s.ranges[: n + 1]}),
    "angle_min > angle_max": scans(lambda s, *_: {"angle_min": s.angle_max, "angle_max": s.angle_min}),
    "negative step, ends right": scans(
        lambda s, *_: {
            "angle_min": s.angle_max,
            "angle_max": s.angle_min,
            "angle_increment": -s.angle_increment,
            "ranges": s.ranges[::-1],
        }
    ),
    "negative step, beams not turned": scans(
        lambda s, *_: {"angle_min": s.angle_max, "angle_max": s.angle_min, "angle_increment": -s.angle_increment}
    ),
    "negative step, ends not turned": scans(lambda s, *_: {"angle_increment": -s.angle_increment}),
    "step NaN": scans(lambda s, *_: {"angle_increment": math.nan}),
    "angles all zero": scans(lambda s, *_: {"angle_min": 0.0, "angle_max": 0.0, "angle_increment": 0.0}),
    "angles doubled": scans(
        lambda s, *_: {
            "angle_min": 2 * s.angle_min,
            "angle_max": 2 * s.angle_max,
            "angle_increment": 2 * s.angle_increment,
        }
    ),
    "angles halved": scans(
        lambda s, *_: {
            "angle_min": s.angle_min / 2,
            "angle_max": s.angle_max / 2,
            "angle_increment": s.angle_increment / 2,
        }
    ),
    "angles from 0 on": scans(lambda s, *_: {"angle_min": 0.0, "angle_max": s.angle_max - s.angle_min}),
    "half the beams, same step": scans(_half),
    "half the beams, same ends": scans(lambda s, *_: {"ranges": s.ranges[::2], "angle_increment": 0.0}),
    "begins at another beam each time": scans(_wild),
    "beams moved on by one each scan": scans(lambda s, n, _: {"ranges": np.roll(s.ranges, n)}),
    "range_max 0": scans(lambda s, *_: {"range_max": 0.0}),
    "range_max NaN": scans(lambda s, *_: {"range_max": math.nan}),
    "range_max 1 m": scans(lambda s, *_: {"range_max": 1.0}),
    "range_min > range_max": scans(lambda s, *_: {"range_min": 30.0}),
    "ranges ^ 2": scans(lambda s, *_: {"ranges": s.ranges**2}),
    "ranges byte by byte turned": scans(lambda s, *_: {"ranges": np.asarray(s.ranges, np.float32).byteswap()}),
    "ranges rounded to 0.5 m": scans(lambda s, *_: {"ranges": np.round(2 * s.ranges) / 2}),
    "ranges clipped at 1 m": scans(lambda s, *_: {"ranges": np.minimum(s.ranges, 1.0)}),
    "no return is 0": scans(lambda s, *_: {"ranges": np.where(s.ranges > 3.0, 0.0, s.ranges)}),
    "no return is -1": scans(lambda s, *_: {"ranges": np.where(s.ranges > 3.0, -1.0, s.ranges)}),
    "no return is 1e30": scans(lambda s, *_: {"ranges": np.where(s.ranges > 3.0, 1e30, s.ranges)}),
    "no return is 2.9 m": scans(lambda s, *_: {"ranges": np.where(s.ranges > 2.9, 2.9, s.ranges)}),
    "the robot's own body": scans(_body),
    "a half of the beams stands": _stuck_sector(),
    "ranges and intensities exchanged": scans(
        lambda s, n, r: {
            "ranges": 100 + 50 * r.random(len(s.ranges)),
            "intensities": np.asarray(s.ranges, np.float32),
        }
    ),
    "noise of 0.3 m": scans(lambda s, _, r: {"ranges": s.ranges + r.normal(0, 0.3, len(s.ranges))}),
    "a tenth of the scans empty": scans(
        lambda s, n, _: {"ranges": np.full_like(s.ranges, np.inf)} if n % 10 == 5 else {}
    ),
    # time within and between scans
    "sweep of 0.15 s, stamped at its end": _swept,
    "time_increment negative": scans(lambda s, *_: {"time_increment": -1e-3}),
    "time_increment in ms": scans(lambda s, *_: {"time_increment": 0.1}),
    "nanoseconds as microseconds": messages(_seconds_swapped),
    "whole seconds": restamped("", lambda b, t: math.floor(b + t)),
    "all stamps 0": restamped("", lambda b, t: 0.0),
    "all stamps equal": restamped("", lambda b, t: b),
    "all stamps and recorder's times equal": restamped("", lambda b, t: b, recorded=True),
    "odometry an hour ahead": restamped("/odom", lambda b, t: b + t + 3600),
    "odometry late by 0.5 s": restamped("/odom", lambda b, t: b + t + 0.5),
    "scans late by 0.3 s": restamped("/scan", lambda b, t: b + t + 0.3),
    "odometry's clock 1 % fast": restamped("/odom", lambda b, t: b + 1.01 * t),
    "scans' clock steps 3 s": restamped("/scan", lambda b, t: b + t + 3.0 * (t > 8.0)),
    "scans' clock steps back 3 s": restamped("/scan", lambda b, t: b + t - 3.0 * (t > 8.0)),
    "odometry's clock steps 0.7 s": restamped("/odom", lambda b, t: b + t + 0.7 * (t > 8.0)),
    "scans jitter by 0.1 s": restamped("/scan", lambda b, t: b + t + 0.1 * math.sin(1000 * t)),
    "before 1970": restamped("", lambda b, t: 5.0 + t),
    # messages
    "odometry twice": messages(
        lambda rows, _: [one for row in rows for one in ([row, row] if row[0] == "/odom" else [row])]
    ),
    "everything twice": messages(lambda rows, _: [one for row in rows for one in (row, row)]),
    "empty topics beside": messages(_empty_topics),
    "a fifth of the messages cut": messages(_truncated),
    "gap of scans": gap(("/scan",)),
    "gap of odometry": gap(("/odom",)),
    "gap of both": gap(("/scan", "/odom")),
    "odometry only in the first half": gap(("/odom",), 0.5, 2.0),
    "odometry only in the second half": gap(("/odom",), -1.0, 0.5),
    "two lasers in one topic": second_laser(other_frame=True),
    "two lasers in one topic and frame": second_laser(other_frame=False),
    # frames
    "tf goes round": transforms(
        ("base_link", "laser", (0, 0, 0)), ("laser", "mast", (0, 0, 0)), ("mast", "base_link", (0, 0, 0))
    ),
    "tf of a frame on itself": transforms(("laser", "laser", (0, 0, 0))),
    "tf not normalized": transforms(quaternion_tf(2.0)),
    "tf quaternion zero": transforms(quaternion_tf(0.0)),
    "tf says turned by 30 degrees": transforms(("base_link", "laser", (0, 0, math.radians(30)))),
    "tf says turned by 180 degrees": transforms(("base_link", "laser", (0, 0, math.pi))),
    "tf in millimetres": transforms(("base_link", "laser", (100.0, 0, 0))),
    "tf says 1 m ahead": transforms(("base_link", "laser", (1.0, 0, 0))),
    "no tf": transforms(),
    # odometry
    "quaternions x 2": poses(lambda p, *_: p * [1, 1, 2, 2, 2, 2]),
    "quaternions x 0.001": poses(lambda p, *_: p * [1, 1, 1e-3, 1e-3, 1e-3, 1e-3]),
    "quaternions w first": poses(lambda p, *_: p[[0, 1, 5, 2, 3, 4]]),
    "quaternions without sign": poses(lambda p, *_: np.abs(p) * np.sign([*p[:2] + 1e-12, 1, 1, 1, 1])),
    "covariance -1": covariances(-1.0),
    "covariance NaN": covariances(math.nan),
    "covariance 1e9": covariances(1e9),
    "odometry NaN now and then": poses(lambda p, n, _: p * np.nan if n % 7 == 3 else p),
    "odometry zero now and then": poses(lambda p, n, _: np.array([0, 0, 0, 0, 0, 1.0]) if n % 20 == 10 else p),
    "odometry jumps by 1 m and back": poses(lambda p, n, _: p + np.eye(6)[0] * (n % 20 == 10)),
    "odometry of increments": _odometry_of_increments,
    "odometry rounded to 0.1 m": quantized(0.1, 1e-9),
    "odometry rounded to whole metres": quantized(1.0, 1e-9),
    "odometry rounded to 10 degrees": quantized(1e-9, math.radians(10)),
    # files
    "gz in gz": of_bytes(lambda b: gzip.compress(gzip.compress(b)), "odd.mcap.gz.gz"),
    "gz in gz, named mcap": of_bytes(lambda b: gzip.compress(gzip.compress(b)), "odd.mcap"),
    "gz cut": of_bytes(lambda b: (packed := gzip.compress(b))[: 2 * len(packed) // 3], "odd.mcap.gz"),
    "two gz parts": of_bytes(lambda b: gzip.compress(b[:5000]) + gzip.compress(b[5000:]), "odd.mcap.gz"),
    "zip": of_bytes(zipped, "odd.zip"),
    "tar.gz": of_bytes(tarred, "odd.tar.gz"),
    "mcap cut at 60 %": of_bytes(lambda b: b[: 6 * len(b) // 10], "odd.mcap"),
    "mcap with zeros in the middle": of_bytes(
        lambda b: b[: len(b) // 2] + bytes(4096) + b[len(b) // 2 + 4096 :], "odd.mcap"
    ),
    "mcap named bag": of_bytes(lambda b: b, "odd.bag"),
    "bag named mcap": of_bytes(lambda b: b, "odd.mcap", bag=True),
    "bag cut at 60 %": of_bytes(lambda b: b[: 6 * len(b) // 10], "odd.bag", bag=True),
    "bag twice": of_bytes(lambda b: b + b, "odd.bag", bag=True),
    "only the first bytes": of_bytes(lambda b: b[:8], "odd.mcap"),
    "records in random order": messages(lambda rows, rng: [rows[k] for k in rng.permutation(len(rows))]),
    "no byte": of_bytes(lambda b: b"", "odd.mcap"),
}
TEXTS: dict[str, Writing] = {
    "the log twice": text(lambda t: 2 * t),
    "records in random order": text(
        lambda t: "\n".join(np.random.default_rng(11).permutation(t.splitlines()).tolist()) + "\n"
    ),
    "CRLF": text(lambda t: t.replace("\n", "\r\n")),
    "CR alone": text(lambda t: t.replace("\n", "\r")),
    "byte order mark": text(lambda t: b"\xef\xbb\xbf" + t.encode()),
    "UTF-16": text(lambda t: t.encode("utf-16")),
    "UTF-16 without mark": text(lambda t: t.encode("utf-16-le")),
    "comments amid": text(lambda t: "".join(f"# 1 2 3\n// noted\n; later\n\n{line}\n" for line in t.splitlines())),
    "decimal commas": text(lambda t: t.replace(".", ",")),
    "exponents": text(of_lines(lambda w: [w[0], *(f"{float(v):.6e}" if "." in v else v for v in w[1:-2]), *w[-2:]])),
    "last line cut": text(lambda t: t[: -len(t.splitlines()[-1]) // 2]),
    "lines run together": text(
        lambda t: "".join(a + (" " if n % 10 == 0 else "\n") for n, a in enumerate(t.splitlines()))
    ),
    "zeros at the end": text(lambda t: t.encode() + bytes(5000)),
    "zeros in the middle": text(lambda t: t.encode()[: len(t) // 2] + bytes(5000) + t.encode()[len(t) // 2 :]),
    "stamps in milliseconds": text(stamps_of_text(lambda s: 1e3 * s)),
    "stamps in microseconds": text(stamps_of_text(lambda s: 1e6 * s)),
    "stamps in nanoseconds": text(stamps_of_text(lambda s: 1e9 * s)),
    "stamps in ms since the start": text(stamps_of_text(lambda s: 1e3 * (s % 1e5))),
    "stamps in minutes": text(stamps_of_text(lambda s: s / 60)),
    "huge count": text(of_lines(lambda w: [*w[:8], "99999999999", *w[9:]])),
    "count too large by one": text(of_lines(lambda w: [*w[:8], str(int(w[8]) + 1), *w[9:]])),
    "count too small by one": text(of_lines(lambda w: [*w[:8], str(int(w[8]) - 1), *w[9:]])),
    "negative count": text(of_lines(lambda w: [*w[:8], "-5", *w[9:]])),
    "angles in degrees": text(
        of_lines(lambda w: [*w[:2], *(f"{math.degrees(float(v)):.5f}" for v in w[2:5]), *w[5:]])
    ),
    "Windows NaN": text(of_lines(lambda w: [*w[:9], *("-1.#IND" if float(v) > 3 else v for v in w[9:-4]), *w[-4:]])),
    "scans after all odometry": text(
        lambda t: "\n".join(sorted(t.splitlines(), key=lambda line: line.split()[0])) + "\n"
    ),
    "beams from left to right": text(of_lines(reversed_beams)),
    "laser turned by 90 degrees": text(of_lines(turned_beams)),
    "clock set back by 3 s": text(stamps_of_text(lambda s: s - 3.0 if s % 1e5 > 9.0 else s)),
    "clock set back by an hour": text(stamps_of_text(lambda s: s - 3600.0 if s % 1e5 > 9.0 else s)),
    "clock set ahead by a day": text(stamps_of_text(lambda s: s + 86400.0 if s % 1e5 > 9.0 else s)),
    "small letters": text(str.lower),
    "semicolons": text(lambda t: t.replace(" ", ";")),
}
SETS: dict[str, Writing] = {
    "times in ms": npz(lambda a: a | {"t": 1e3 * a["t"]}),
    "beams by scans": npz(lambda a: a | {"scan_cm": a["scan_cm"].T}),
    "ranges in m": npz(lambda a: a | {"scan_cm": a["scan_cm"] / 100}),
    "ranges in mm": npz(lambda a: a | {"scan_cm": (10 * a["scan_cm"]).astype(np.uint16)}),
    "headings in degrees": npz(lambda a: a | {"odo_raw": a["odo_raw"] * [1, 1, 180 / math.pi]}),
    "heading first": npz(lambda a: a | {"odo_raw": a["odo_raw"][:, [2, 0, 1]]}),
    "odometry shorter": npz(lambda a: a | {"odo_raw": a["odo_raw"][:-3]}),
    "odometry in cm": npz(lambda a: a | {"odo_raw": a["odo_raw"] * [100, 100, 1]}),
    "one scan": npz(lambda a: {k: v[:1] for k, v in a.items()}),
    "no scan": npz(lambda a: {k: v[:0] for k, v in a.items()}),
    "backwards": npz(lambda a: {k: v[::-1] for k, v in a.items()}),
    "objects": npz(lambda a: a | {"scan_cm": np.array([list(row) for row in a["scan_cm"]], object)}),
    "mirrored beams": npz(lambda a: a | {"scan_cm": a["scan_cm"][:, ::-1]}),
}
VARIANTS: dict[str, dict[str, Writing]] = {
    form: {"sound": WRITERS[form]} | {name: _written(making, form) for name, making in DRIVES.items()} | own
    for form, own in (("mcap", MESSAGES), ("log", TEXTS))
} | {"npz": SETS}


def result(path: Path, truth: np.ndarray | None) -> tuple[float | None, float, list[str], list[str], np.ndarray]:
    """Error [m] to the truth, path [m], codes, other warnings, places by stamp."""
    found = slam_log(path)
    assert isinstance(found.recording, ScanRecording)
    report = found.report
    rows = np.array([(s, p.x, p.y, p.heading) for s, p in zip(found.stamps, found.poses, strict=True)])
    said = {one.sentence for one in report.faults}
    others = [one for one in report.warnings if one not in said]
    error = None if truth is None else apart(rows, truth)
    return error, found.path, [one.code for one in report.faults], others, rows


def apart(rows: np.ndarray, truth: np.ndarray) -> float:
    """Mean distance [m] of places (N, 4: stamp, x, y, heading) and true ones, from the first pose on."""
    start = Pose(*truth[0, 1:4]).inverse()
    true = np.array([(start @ Pose(*row)).vector for row in truth[:, 1:4].tolist()])
    first = Pose(*rows[0, 1:4]).inverse()
    mine = np.array([(first @ Pose(*row)).vector for row in rows[:, 1:4].tolist()])
    when = rows[:, 0] - rows[0, 0]
    at = truth[:, 0] - truth[0, 0]
    wanted = np.column_stack([np.interp(when, at, true[:, k]) for k in (0, 1)])
    return float(np.hypot(*(mine[:, :2] - wanted).T).mean())


def tried(path: Path, control: float, truth: np.ndarray | None) -> dict[str, object]:
    """Judge a log whose sound form is wrong by `control` [m]; its error is unknown without a truth."""
    try:
        error, way, codes, others, _ = result(path, truth)
    except BadInput as refused:
        return {"verdict": "refused", "codes": [one.code for one in faults_of(refused)], "said": str(refused)[:160]}
    limit = max(2 * control, LEAST_ERROR_M)
    fine = error is not None and error <= limit
    row: dict[str, object] = {
        "error": None if error is None else round(error, 3),
        "path": round(way, 2),
        "codes": codes,
        "said": others,
    }
    verdict = "right" if fine and not codes else "named" if codes or others else "right" if fine else "WRONG"
    return row | {"verdict": verdict}


def sound(base: str, form: str, drive: Drive) -> tuple[float, np.ndarray]:
    """Error [m] of the sound drive in a form, and the truth."""
    with tempfile.TemporaryDirectory() as folder:
        path = WRITERS[form](drive, Path(folder), np.random.default_rng(11))
        truth = None if drive.truth is None else np.column_stack([drive.stamps, drive.truth])
        error, _, codes, others, places = result(path, truth)
    print_row(f"# {base} {form}: control {error or 0.0:.3f} m {codes} {others}")
    return error or 0.0, places if truth is None else truth


VARIANTS_WITHOUT_TRUTH = ("two logs", "two logs at once", "two logs, a day apart")  # which begin anew somewhere


def campaign(bases: list[str], forms: list[str], only: list[str]) -> list[dict[str, object]]:
    """Every variant of every base in every form; a row is written as it is known."""
    rows: list[dict[str, object]] = []
    for base, form in itertools.product(bases, forms):
        drive = BASES[base]()
        control, truth = sound(base, form, drive)
        for name, writing in VARIANTS[form].items():
            if only and name not in only:
                continue
            with tempfile.TemporaryDirectory() as folder:
                path = writing(drive, Path(folder), np.random.default_rng(11))
                rows.append({"base": base, "form": form, "variant": name})
                rows[-1] |= tried(path, control, None if name in VARIANTS_WITHOUT_TRUTH else truth)
            print_row(rows[-1])
    return rows


def strangers_files() -> list[dict[str, object]]:
    """The recordings of strangers: against the truth, and the error of the sound one of the same length."""
    columns = np.genfromtxt(STRANGERS / "truth.csv", delimiter=",", names=True)
    truth = np.column_stack([columns[name] for name in ("t_s", "x_m", "y_m", "heading_rad")])
    controls = [result(STRANGERS / name, truth)[0] or 0.0 for name in ("00_control.mcap", "10_short_control.mcap")]
    rows: list[dict[str, object]] = []
    for path in sorted(STRANGERS.iterdir()):
        if path.name == "truth.csv":
            continue
        begins, short = _beginning(path)
        control = BACKWARD_ERROR_M if path.name in LOOKING_BACK else controls[short]
        row = tried(path, control, truth[truth[:, 0] >= begins - 1e-6])
        rows.append({"file": path.name} | row)
        print_row(rows[-1])
    return rows


def _beginning(path: Path) -> tuple[float, bool]:
    """When a recording of strangers begins [s] on the truth's clock, and whether it is short."""
    try:
        read = open_log(path)
    except BadInput:
        return 0.0, False
    assert isinstance(read, ScanRecording)
    begins = read.scans[0].stamp - BEGUN_S
    return (begins if 0 < begins < 30 else 0.0), len(read.scans) < 120


def main(
    *,
    base: Sequence[Annotated[str, BASES]] = (),
    form: Sequence[Annotated[str, VARIANTS]] = (),
    only: Sequence[str] = (),  # variants
    files: bool = False,  # the recordings of strangers
) -> None:
    some = base or list(BASES), form or list(VARIANTS), only or []
    rows = strangers_files() if files else campaign(*some)
    found = {
        verdict: sum(row["verdict"] == verdict for row in rows) for verdict in ("right", "named", "refused", "WRONG")
    }
    print_row(f"{len(rows)} variants: {found}")


if __name__ == "__main__":
    run_command(main)
