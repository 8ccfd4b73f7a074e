"""ROS messages, whatever file they come from → a recording of scans with odometry."""

from __future__ import annotations

import functools
from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from core.errors import BadInput
from core.message import Array
from core.recording.json_scan import read_json_scan
from core.recording.odometry_track import OdometryTrack, heading_of
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording, logged_stamp, stamped
from core.recording.ros_frames import FrameTree, Placed
from core.recording.ros_pictures import CAMERA_INFO, COMPRESSED, IMAGE, RosPictures
from core.recording.scans import in_time_order, make_scan, scan_recording, settle_stamps
from core.sensors import Scan

LASER_SCAN, ODOMETRY, TF = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
SAME_AS = {"tf/msg/tfMessage": TF}


@dataclass(frozen=True)
class Envelope:
    """A message as it lies in a file."""

    topic: str
    kind: str  # "sensor_msgs/msg/LaserScan"
    encoding: str  # "cdr" | "ros1" | "json"
    logged: float  # [s] by the recorder's clock
    content: bytes


@dataclass
class _ScanTopic:
    frame: str = ""
    scans: list[Scan] = field(default_factory=list[Scan])
    logged: list[float] = field(default_factory=list[float])


@dataclass
class _OdometryTopic:
    frame: str = ""
    rows: array[float] = field(default_factory=lambda: array("d"))  # own stamp, logged, x, y, heading, v, w …


class RosMessages:
    """Takes messages one by one, keeps what matters, and makes the recording at the end."""

    def __init__(self, settings: LogSettings, tally: ReadReport, *, pictures: bool = False):
        """`pictures`: keep those of the first camera, too."""
        self._pictures = RosPictures() if pictures else None
        self._settings = settings
        self._tally = tally
        self._scans: dict[str, _ScanTopic] = {}
        self._odometry: dict[str, _OdometryTopic] = {}
        self._tree = FrameTree()
        self._others: dict[str, tuple[str, int]] = {}  # topic → type, how many
        self._held = 0  # [bytes]
        self._passed = 0

    def take_all(self, envelopes: Iterable[Envelope]) -> None:
        """Read every message, or as many as memory is allowed for."""
        for envelope in envelopes:
            self._passed += 1
            if self._held > self._settings.most_readings:
                self._tally.warn(
                    f"The log is longer than {self._settings.most_readings_mb:g} MB of readings; only the "
                    f"first part is used. Cut it into parts, or raise log.most_readings_mb in the settings."
                )
                return
            self._take(envelope)

    def _take(self, envelope: Envelope) -> None:
        kind = ros2_name(envelope.kind)
        kind = SAME_AS.get(kind, kind)
        if envelope.encoding == "json":
            known = self._take_json
        elif kind in (LASER_SCAN, ODOMETRY, TF) and envelope.encoding in ("cdr", "ros1"):
            known = {LASER_SCAN: self._take_scan, ODOMETRY: self._take_odometry, TF: self._take_tf}[kind]
        elif self._pictures is not None and kind in (IMAGE, COMPRESSED, CAMERA_INFO):
            known = self._take_picture
        else:
            self._count_other(envelope)
            return
        try:
            self._tally.read += known(envelope, kind)
        except (BadRecord, BadInput) as problem:
            self._tally.skip(str(problem), f"a message of {envelope.topic}")
        except Exception:  # whatever a decoder raises on hostile bytes, the next message may be fine
            self._tally.skip("it cannot be decoded", f"a message of {envelope.topic}")

    def _take_scan(self, envelope: Envelope, kind: str) -> bool:
        message = decode(envelope, kind)
        scan = make_scan(
            stamp_of(message.header),
            message.ranges,
            (message.angle_min, message.angle_increment),
            (message.range_min, self._settings.range_max or message.range_max),
            message.time_increment,
        )
        return self._keep(envelope, scan, message.header.frame_id)

    def _take_json(self, envelope: Envelope, kind: str) -> bool:
        scan = read_json_scan(envelope.content, self._settings.range_max)
        if scan is None:
            self._count_other(replace(envelope, kind=kind or "JSON"))
            return False
        return self._keep(envelope, scan, "")

    def _keep(self, envelope: Envelope, scan: Scan, frame: str) -> bool:
        topic = self._scans.setdefault(envelope.topic, _ScanTopic(frame.strip("/")))
        topic.scans.append(scan)
        topic.logged.append(envelope.logged)
        self._held += 500 + scan.ranges.nbytes
        return True

    def _take_odometry(self, envelope: Envelope, kind: str) -> bool:
        message = decode(envelope, kind)
        topic = self._odometry.setdefault(envelope.topic, _OdometryTopic(message.child_frame_id.strip("/")))
        place, q = message.pose.pose.position, message.pose.pose.orientation
        heading = float(heading_of(q.x, q.y, q.z, q.w))
        twist = message.twist.twist
        topic.rows.extend(
            (stamp_of(message.header), envelope.logged, place.x, place.y, heading, twist.linear.x, twist.angular.z)
        )
        self._held += 56
        return True

    def _take_picture(self, envelope: Envelope, kind: str) -> bool:
        assert self._pictures is not None
        content = decode(envelope, kind)
        return self._pictures.take(envelope.topic, content, kind, stamp_of(content.header) or envelope.logged)

    def _take_tf(self, envelope: Envelope, kind: str) -> bool:
        fixed = envelope.topic.endswith("tf_static")
        for transform in decode(envelope, kind).transforms:
            self._held += self._tree.add(transform, stamp_of(transform.header), envelope.logged, fixed)
        return True

    def _count_other(self, envelope: Envelope) -> None:
        kind, count = self._others.get(envelope.topic, (envelope.kind, 0))
        if count or len(self._others) < 1000:
            self._others[envelope.topic] = kind, count + 1

    def finish(self, path: Path, form: str) -> ScanRecording:
        """All that was taken → the recording. Raises BadInput when it holds no scans."""
        name, topic = self._chosen_scans(path)
        own, logged = np.array([logged_stamp(scan) for scan in topic.scans]), np.array(topic.logged)
        stamps, good = settle_stamps(own, logged)
        self._tally.drop("its stamp lies far from those of the others", count=int((~good).sum()))
        kept = [
            scan if stamp == before else stamped(scan, float(stamp))
            for scan, before, stamp, keep in zip(topic.scans, own, stamps, good, strict=True)
            if keep
        ]
        scans = in_time_order(kept, self._tally)
        if not scans:
            raise BadInput(f"{path.name} holds no scan with a usable time.")
        track, base = self._chosen_odometry(path)
        placed = self._tree.mounting(base, topic.frame)
        if placed is None:
            placed = Placed()
            if topic.frame and self._tree.frames and topic.frame != base:
                self._tally.warn(
                    f"The log does not say how {topic.frame} is mounted on the robot; it is taken to stand at the "
                    "robot's origin. Set log.mounting_x, mounting_y and mounting_heading to change that."
                )
        if placed.upside_down:
            scans = [turned_over(scan) for scan in scans]
        self._tally.topics.insert(0, f"{name}: laser")
        self._compare_with_declared()
        mounting, height = placed.pose, placed.height
        seen, camera = (), None
        if self._pictures is not None:
            seen, camera = self._pictures.finish(scans[0].stamp, scans[-1].stamp, self._tally)
        recording = scan_recording(path, scans, track, self._tally, form, self._settings, mounting, height)
        return replace(recording, pictures=seen, camera=camera)

    def _chosen_scans(self, path: Path) -> tuple[str, _ScanTopic]:
        wanted = self._settings.scan_topic
        if wanted:
            for name, topic in self._scans.items():
                if name.strip("/") == wanted.strip("/"):
                    return name, topic
            raise BadInput(f"{path.name} holds no laser scans on {wanted}. {self._contents()}")
        if not self._scans:
            reasons = f" What could not be read: {self._tally.reasons()}." if self._tally.skipped else ""
            raise BadInput(f"{path.name} holds no laser scans (sensor_msgs/LaserScan). {self._contents()}{reasons}")
        name = max(self._scans, key=lambda name: len(self._scans[name].scans))
        if len(self._scans) > 1:
            others = ", ".join(sorted(set(self._scans) - {name})[:5])
            self._tally.warn(f"Of several lasers {name} is used; {others} is not. Set log.scan_topic to change that.")
        return name, self._scans[name]

    def _chosen_odometry(self, path: Path) -> tuple[OdometryTrack | None, str]:
        """The track (None: scans only) and the name of the robot's own frame."""
        wanted, base = self._settings.odometry_topic.strip("/"), self._settings.base_frame.strip("/")
        found = {name: topic for name, topic in self._odometry.items() if not wanted or name.strip("/") == wanted}
        if wanted == "none":
            return None, base
        if found:
            name = max(found, key=lambda name: len(found[name].rows))
            rows = np.array(found[name].rows).reshape(-1, 7)
            stamps, good = settle_stamps(rows[:, 0], rows[:, 1])
            rows[:, 0] = stamps
            rows = rows[good]
            twists = rows[:, 5:] if np.any(rows[:, 5:]) else None
            track = OdometryTrack.of(rows[:, 0], rows[:, 2:5], twists)
            if track is not None:
                self._tally.topics.append(f"{name}: odometry")
                return track, base or found[name].frame
        if wanted and wanted not in ("tf", "/tf"):
            raise BadInput(f"{path.name} holds no odometry on {self._settings.odometry_topic}. {self._contents()}")
        pair, rows = self._tree.moving(self._settings.odometry_frame.strip("/"), base)
        stamps, good = settle_stamps(rows[:, 0], rows[:, 1])
        rows[:, 0] = stamps
        track = OdometryTrack.of(rows[good, 0], rows[good, 2:])
        if track is not None:
            self._tally.topics.append(f"tf {pair[0]} → {pair[1]}: odometry")
        return track, base or pair[1]

    def _compare_with_declared(self) -> None:
        declared = self._tally.declared
        if declared is not None and self._passed < declared:
            self._tally.warn(f"The file says it holds {declared} messages; {self._passed} could be read.")
        elif declared is not None and self._tally.skipped:
            self._tally.warn(f"All {declared} messages the file says it holds were found all the same.")

    def _contents(self) -> str:
        if not self._others and not self._scans and not self._odometry:
            return "It holds no messages that can be read."
        topics = [f"{topic} ({count} × {kind or 'of unknown type'})" for topic, (kind, count) in self._others.items()]
        topics += [f"{topic} ({len(found.scans)} × LaserScan)" for topic, found in self._scans.items()]
        topics += [f"{topic} ({len(found.rows) // 7} × Odometry)" for topic, found in self._odometry.items()]
        return "It holds " + ", ".join(text[:100] for text in topics[:8]) + (" and more." if len(topics) > 8 else ".")


def ros2_name(kind: str) -> str:
    """Type names of ROS 1 and ROS 2 → the form of ROS 2: "sensor_msgs/msg/LaserScan"."""
    package, _, name = kind.rpartition("/")
    return kind if not package or "/" in package else f"{package}/msg/{name}"


@functools.cache
def _typestore(ros1: bool) -> Typestore:
    if not ros1:
        return get_typestore(Stores.ROS2_JAZZY)
    store = get_typestore(Stores.ROS1_NOETIC)  # which knows everything but tf
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
    return store


def decode(envelope: Envelope, kind: str) -> Any:
    """A message's bytes → its fields. Raises whatever the decoder raises on damaged bytes."""
    if envelope.encoding == "ros1":
        return _typestore(True).deserialize_ros1(envelope.content, kind)
    return _typestore(False).deserialize_cdr(envelope.content, kind)


def stamp_of(header: Any) -> float:
    """A message's header → its stamp [s]."""
    return float(header.stamp.sec + header.stamp.nanosec * 1e-9)


def turned_over(scan: Scan) -> Scan:
    """A scan of a laser that hangs upside down → the same as seen from above, again right to left."""
    beams = len(scan.ranges)
    ranges: Array = scan.ranges[::-1]
    return replace(
        scan,
        stamp=scan.stamp + scan.time_step * (beams - 1),
        ranges=ranges,
        angle_min=-(scan.angle_min + scan.angle_step * (beams - 1)),
        time_step=-scan.time_step,
    )
