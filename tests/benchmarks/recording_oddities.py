"""Recordings made wrong in other ways than `recording_variants`: messages, files and their forms.

`python -m tests.benchmarks.recording_oddities [--base NAME] [--only NAME]`. Each oddity takes a sound drive to a
file; they were written before anybody looked at how they are read.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
import math
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.recording_variants import BASES, Drive, sound, speeds, to_carmen, tried
from tests.core.recording.log_writers import ODOMETRY, ROS2, SCAN, TF, one, two, write_bag, write_mcap

Row = tuple[str, str, float, Any]  # topic, type, recorder's time [s], message
Oddity = Callable[[Drive, Path, np.random.Generator], Path]
FULL_SWEEP_S = 0.15


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


def messages(change: Callable[[list[Row], np.random.Generator], Iterable[Row]], **options: Any) -> Oddity:
    """Change the list of messages."""
    return lambda drive, folder, rng: write_mcap(folder / "odd.mcap", change(rows_of(drive), rng), **options)


def each(topic: str, change: Callable[[Any, int, np.random.Generator], Any]) -> Oddity:
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


def scans(change: Callable[[Any, int, np.random.Generator], dict[str, Any] | None]) -> Oddity:
    """Change fields of every scan."""

    def changed(scan: Any, number: int, rng: np.random.Generator) -> Any:
        fields = change(scan, number, rng)
        if fields is None:
            return None
        if "ranges" in fields:
            fields["ranges"] = np.ascontiguousarray(fields["ranges"], np.float32)
        return replace(scan, **fields)

    return each("/scan", changed)


def poses(change: Callable[[np.ndarray, int, np.random.Generator], Any]) -> Oddity:
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


def covariances(value: float) -> Oddity:
    """Say this for every number of the odometry's covariances."""
    filled = np.full(36, value)
    return each(
        "/odom",
        lambda told, *_: replace(
            told, pose=replace(told.pose, covariance=filled), twist=replace(told.twist, covariance=filled)
        ),
    )


def restamped(topic: str, change: Callable[[float, float], float], recorded: bool = False) -> Oddity:
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


def gap(topics: tuple[str, ...], start: float = 0.4, end: float = 0.55) -> Oddity:
    """Leave out a part of some topics."""

    def changed(rows: list[Row], _: np.random.Generator) -> Iterable[Row]:
        first, lasted = rows[0][2], rows[-1][2] - rows[0][2]
        return (row for row in rows if not (row[0] in topics and start < (row[2] - first) / lasted < end))

    return messages(changed)


def transforms(*told: Any) -> Oddity:
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


def second_laser(other_frame: bool) -> Oddity:
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


def text(change: Callable[[str], str | bytes], name: str = "odd.log") -> Oddity:
    """Change the text of a CARMEN log."""

    def made(drive: Drive, folder: Path, rng: np.random.Generator) -> Path:
        content = change(to_carmen(drive, folder / "sound.txt", rng).read_text())
        path = folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return made


def of_bytes(change: Callable[[bytes], bytes], name: str, bag: bool = False) -> Oddity:
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


def npz(change: Callable[[dict[str, Any]], dict[str, Any]]) -> Oddity:
    """Change the arrays of a scan set."""

    def made(drive: Drive, folder: Path, _: np.random.Generator) -> Path:
        heading = np.unwrap(drive.poses[:, 2])
        at = np.column_stack(
            [np.interp(drive.stamps, drive.times, v) for v in (drive.poses[:, 0], drive.poses[:, 1], heading)]
        )
        first, step = drive.angles
        beams = np.rint((np.linspace(-math.pi / 2, math.pi / 2, 181) - first) / step).astype(int)
        ranges = np.nan_to_num(drive.ranges[:, beams % drive.ranges.shape[1]], nan=0.0, posinf=82.0)
        arrays = {"t": drive.stamps - drive.stamps[0], "scan_cm": (100 * ranges).astype(np.float32), "odo_raw": at}
        path = folder / "odd.npz"
        np.savez(path, **change(arrays))
        return path

    return made


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


def quantized(metres: float, radians: float) -> Oddity:
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


def _stuck_sector() -> Oddity:
    held: dict[str, Any] = {}

    def change(scan: Any, number: int, _: np.random.Generator) -> dict[str, Any]:
        if number == 0:
            held["first"] = scan.ranges
        ranges = scan.ranges.copy()
        ranges[: len(ranges) // 2] = held["first"][: len(ranges) // 2]
        return {"ranges": ranges}

    return scans(change)


ODDITIES: dict[str, Oddity] = {
    # how beams are written
    "every other beam NaN": scans(lambda s, *_: {"ranges": np.where(np.arange(len(s.ranges)) % 2, np.nan, s.ranges)}),
    "a random half NaN": scans(lambda s, _, r: {"ranges": np.where(r.random(len(s.ranges)) < 0.5, np.nan, s.ranges)}),
    "one beam": scans(lambda s, *_: {"ranges": s.ranges[:1]}),
    "a million beams, first scan": scans(
        lambda s, n, _: {"ranges": np.resize(s.ranges, 1_000_000)} if n == 0 else {}
    ),
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
    "ranges inverted": scans(lambda s, *_: {"ranges": 1 / np.maximum(s.ranges, 0.05)}),
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
    "ranges x 1.02": scans(lambda s, *_: {"ranges": 1.02 * s.ranges}),
    "ranges x 1.2": scans(lambda s, *_: {"ranges": 1.2 * s.ranges}),
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
    "quaternions conjugate": poses(lambda p, *_: p * [1, 1, -1, -1, -1, 1]),
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
    "no byte": of_bytes(lambda b: b"", "odd.mcap"),
    # text
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
    "small letters": text(str.lower),
    "semicolons": text(lambda t: t.replace(" ", ";")),
    # scan sets
    "npz": npz(lambda a: a),
    "npz, times in ms": npz(lambda a: a | {"t": 1e3 * a["t"]}),
    "npz, beams by scans": npz(lambda a: a | {"scan_cm": a["scan_cm"].T}),
    "npz, ranges in m": npz(lambda a: a | {"scan_cm": a["scan_cm"] / 100}),
    "npz, ranges in mm": npz(lambda a: a | {"scan_cm": (10 * a["scan_cm"]).astype(np.uint16)}),
    "npz, headings in degrees": npz(lambda a: a | {"odo_raw": a["odo_raw"] * [1, 1, 180 / math.pi]}),
    "npz, heading first": npz(lambda a: a | {"odo_raw": a["odo_raw"][:, [2, 0, 1]]}),
    "npz, odometry shorter": npz(lambda a: a | {"odo_raw": a["odo_raw"][:-3]}),
    "npz, odometry in cm": npz(lambda a: a | {"odo_raw": a["odo_raw"] * [100, 100, 1]}),
    "npz, one scan": npz(lambda a: {k: v[:1] for k, v in a.items()}),
    "npz, no scan": npz(lambda a: {k: v[:0] for k, v in a.items()}),
    "npz, backwards": npz(lambda a: {k: v[::-1] for k, v in a.items()}),
    "npz, objects": npz(lambda a: a | {"scan_cm": np.array([list(row) for row in a["scan_cm"]], object)}),
    "npz, mirrored beams": npz(lambda a: a | {"scan_cm": a["scan_cm"][:, ::-1]}),
}


def main() -> None:
    """Print a row for each oddity, and how many are wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", choices=BASES, action="append")
    parser.add_argument("--only", choices=ODDITIES, action="append")
    chosen, wrong = parser.parse_args(), 0
    for base in chosen.base or ["lab", "strangers"]:
        drive = BASES[base]()
        control, truth = sound(base, "mcap", drive)
        for name in chosen.only or ODDITIES:
            with tempfile.TemporaryDirectory() as folder:
                path = ODDITIES[name](drive, Path(folder), np.random.default_rng(11))
                row = tried(path, control, truth)
            sys.stdout.write(json.dumps({"base": base, "variant": name} | row) + "\n")
            sys.stdout.flush()
            wrong += row["verdict"] == "WRONG"
    sys.stdout.write(f"{wrong} wrong and silent\n")


if __name__ == "__main__":
    main()
