"""ROS messages, whatever file they come from → a recording of scans with odometry."""

from __future__ import annotations

import functools
import math
from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.recording.clocks import (
    RecorderClock,
    StampedStream,
    evenly_spread,
    in_seconds,
    on_one_clock,
    settled_stamps,
)
from core.recording.json_scan import read_json_scan
from core.recording.laser_sense import with_laser_as_driven
from core.recording.odometry_checks import believable_track
from core.recording.odometry_track import OdometryTrack, heading_of
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings, ScanRecording, logged_stamp, stamped
from core.recording.robot_names import OTHER_ODOMETRY, robot_of, robots_in
from core.recording.ros_frames import FrameTree
from core.recording.ros_pictures import CAMERA_INFO, COMPRESSED, IMAGE, RosPictures
from core.recording.ros_sound import AUDIO_DATA, AUDIO_INFO, AUDIO_STAMPED, RAW_AUDIO, RosSounds, with_sound
from core.recording.scans import in_time_order, make_scan, scan_recording, turned_over
from core.sensors import Scan
from core.sensors.checks import refusal
from core.sensors.laser import MAX_STAMP_S, Placed
from core.sensors.scan_gate import RangeUnit, checked_angles

LASER_SCAN, ODOMETRY, TF = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
SAME_AS = {"tf/msg/tfMessage": TF}
MAX_MOUNT_M = 5.0  # from the middle of a robot to its laser
MIN_QUATERNION = 0.25  # squared length of one that says a heading
TIMED = frozenset({LASER_SCAN, ODOMETRY, TF})
SEEN = frozenset({IMAGE, COMPRESSED, CAMERA_INFO})
HEARD = frozenset({RAW_AUDIO, AUDIO_DATA, AUDIO_STAMPED, AUDIO_INFO})


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


@dataclass(frozen=True)
class _ChosenOdometry:
    label: str = ""  # for the report
    name: str = ""
    base: str = ""  # the robot's own frame
    rows: Array = field(default_factory=lambda: np.zeros((0, 7)))  # as of _OdometryTopic


def _is_of_wheels(name: str, topic: _OdometryTopic) -> bool:
    headings = np.array(topic.rows).reshape(-1, 7)[:, 4]
    return not OTHER_ODOMETRY.search(name) and bool(np.mean(np.isfinite(headings)) > 0.5)


class RosMessages:
    """Takes messages one by one, keeps what matters, and makes the recording at the end."""

    def __init__(self, settings: LogSettings, tally: ReadReport, *, whole: bool = False):
        """`whole`: keep the pictures of the first camera and the sound, too."""
        self._pictures = RosPictures() if whole else None
        self._sounds = RosSounds(*settings.sound) if whole else None
        self._settings = settings
        self._tally = tally
        self._scans: dict[str, _ScanTopic] = {}
        self._units: dict[str, RangeUnit] = {}  # by topic
        self._odometry: dict[str, _OdometryTopic] = {}
        self._tree = FrameTree()
        self._others: dict[str, tuple[str, int]] = {}  # topic → type, how many
        self._clock, self._files = RecorderClock(), tally.files
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
        if kind in TIMED and not envelope.topic.endswith("tf_static"):
            if self._tally.files != self._files:
                self._files = self._tally.files
                self._clock.begin_file()
            envelope = replace(envelope, logged=self._clock.corrected(envelope.topic, envelope.logged))
        if envelope.encoding == "json":
            known = self._take_json
        elif kind in (LASER_SCAN, ODOMETRY, TF) and envelope.encoding in ("cdr", "ros1"):
            known = {LASER_SCAN: self._take_scan, ODOMETRY: self._take_odometry, TF: self._take_tf}[kind]
        elif self._pictures is not None and kind in SEEN:
            known = self._take_picture
        elif self._sounds is not None and kind in HEARD:
            known = self._take_sound
        else:
            self._count_other(envelope)
            return
        with self._tally.reading(envelope.topic):
            self._tally.read += known(envelope, kind)

    def _take_scan(self, envelope: Envelope, kind: str) -> bool:
        message = decode(envelope, kind)
        name = envelope.topic
        unit = self._units.setdefault(name, RangeUnit(name, self._tally))
        ranges, (low, high) = unit.metres(message.ranges, (message.range_min, message.range_max))
        ends = message.angle_min, message.angle_max
        angles = checked_angles(name, len(ranges), ends, message.angle_increment, self._tally)
        limits = low, self._settings.range_max or high
        scan = make_scan(stamp_of(message.header), ranges, angles, limits, message.time_increment)
        return self._keep(envelope, scan, message.header.frame_id)

    def _take_json(self, envelope: Envelope, kind: str) -> bool:
        name = envelope.topic
        unit = self._units.setdefault(name, RangeUnit(name, self._tally))
        read = read_json_scan(envelope.content, self._settings.range_max, unit)
        if read is None:
            self._count_other(replace(envelope, kind=kind or "JSON"))
            return False
        scan, time = read
        return self._keep(envelope, stamped(scan, time if abs(time) <= MAX_STAMP_S else math.nan), "")

    def _keep(self, envelope: Envelope, scan: Scan, frame: str) -> bool:
        topic = self._scans.setdefault(envelope.topic, _ScanTopic(frame.strip("/")))
        last = topic.scans[-1] if topic.scans else None
        if last is not None and last.stamp == scan.stamp and np.array_equal(last.ranges, scan.ranges, equal_nan=True):
            self._tally.drop("it is written twice", count=1)
            return False
        topic.scans.append(scan)
        topic.logged.append(envelope.logged)
        self._held += 500 + scan.ranges.nbytes
        return True

    def _take_odometry(self, envelope: Envelope, kind: str) -> bool:
        message = decode(envelope, kind)
        topic = self._odometry.setdefault(envelope.topic, _OdometryTopic(message.child_frame_id.strip("/")))
        place, q = message.pose.pose.position, message.pose.pose.orientation
        turned = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w
        heading = float(heading_of(q.x, q.y, q.z, q.w)) if turned > MIN_QUATERNION else math.nan
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

    def _take_sound(self, envelope: Envelope, kind: str) -> bool:
        assert self._sounds is not None
        return self._sounds.take(envelope.topic, decode(envelope, kind), kind, envelope.logged)

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
        if self._clock.is_unordered:
            self._forget_order()
        for jump in () if self._clock.is_unordered else self._clock.jumps_s:
            self._tally.fault("clock.recorder_set", used=True, jump=f"{jump:+.0f}")
        robots = robots_in(self._odometry, self._scans, self._tree.moving_frames)  # none where it is one
        name, topic = self._chosen_scans(path, robots)
        odometry = self._chosen_odometry(path, name, topic.frame, robots)
        stream = StampedStream(name, np.array([logged_stamp(scan) for scan in topic.scans]), np.array(topic.logged))
        in_seconds(stream, odometry.rows[:, :2], self._tally)
        laser, good = settled_stamps(stream, self._tally)
        self._tally.drop("its stamp lies far from those of the others", count=int((~good).sum()))
        track, laser_shift = self._track(odometry, laser)
        stamps = evenly_spread(laser.own[good] + laser_shift, self._tally, name)
        kept = [scan for scan, keep in zip(topic.scans, good, strict=True) if keep]
        scans = [
            scan if stamp == logged_stamp(scan) else stamped(scan, float(stamp))
            for scan, stamp in zip(kept, stamps, strict=True)
        ]
        scans = in_time_order(scans, self._tally)
        if not scans:
            raise BadInput(f"{path.name} holds no scan with a usable time.")
        self._tally.topics.insert(0, f"{name}: laser")
        placed = self._mounting(odometry, topic.frame, name)
        if placed.upside_down:
            scans = [turned_over(scan) for scan in scans]
        self._compare_with_declared()
        seen, camera = (), None
        if self._pictures is not None:
            seen, camera = self._pictures.finish(
                scans[0].stamp, scans[-1].stamp, self._tally, lambda frame: self._tree.transform(odometry.base, frame)
            )
        heard = () if self._sounds is None else self._sounds.finish(self._tally)
        recording = scan_recording(path, scans, track, self._tally, form, self._settings, placed.pose, placed.height)
        known = self._settings.mounting_heading is not None or self._tree.mounting(odometry.base, topic.frame)
        recording = with_laser_as_driven(recording, sense=False, heading=not known)
        return replace(recording, pictures=seen, camera=camera, sounds=heard)

    def _forget_order(self) -> None:
        """The messages lie in no order: their own stamps are all there is."""
        for topic in self._scans.values():
            topic.scans.sort(key=logged_stamp)
            topic.logged[:] = array("d", map(logged_stamp, topic.scans))
        for topic in self._odometry.values():
            rows = np.array(topic.rows).reshape(-1, 7)
            rows = rows[np.argsort(rows[:, 0], kind="stable")]
            rows[:, 1] = rows[:, 0]
            topic.rows = array("d", rows.ravel())

    def _mounting(self, odometry: _ChosenOdometry, frame: str, name: str) -> Placed:
        """How the laser is mounted; where the log does not say it, at the origin, and that is said.

        A laser alone, without odometry or frames, is the robot itself.
        """
        base, alone = odometry.base, not len(odometry.rows) and not self._tree.frames
        placed = self._tree.mounting(base, frame)
        given = self._settings.mounting_heading is not None
        if placed is None or (given and not placed.level):
            if not given and not alone and not (frame and frame == base):
                self._tally.fault("mount.unknown", frame or name, used=True)
            return Placed()
        if math.hypot(placed.pose.x, placed.pose.y) > MAX_MOUNT_M:
            far = f"{math.hypot(placed.pose.x, placed.pose.y):.0f}"
            self._tally.fault("mount.too_far", frame, used=True, far=far)
            return replace(placed, pose=Pose(heading=placed.pose.heading), height=Placed().height)
        if not placed.level:
            raise refusal("mount.not_level", frame, tilt=f"{math.degrees(placed.tilt):.0f}")
        return placed

    def _chosen_scans(self, path: Path, robots: tuple[str, ...]) -> tuple[str, _ScanTopic]:
        wanted = self._settings.scan_topic
        if wanted:
            for name, topic in self._scans.items():
                if name.strip("/") == wanted.strip("/"):
                    return name, topic
            raise BadInput(f"{path.name} holds no laser scans on {wanted}. {self._contents()}")
        if not self._scans:
            reasons = f" What could not be read: {self._tally.reasons()}." if self._tally.skipped else ""
            raise BadInput(f"{path.name} holds no laser scans (sensor_msgs/LaserScan). {self._contents()}{reasons}")

        def fitness(name: str) -> tuple[bool, int]:
            placed = self._tree.mounting("", self._scans[name].frame)
            return placed is None or placed.level, len(self._scans[name].scans)

        name = max(self._scans, key=fitness)
        others = sorted(set(self._scans) - {name})
        if robots:
            self._tally.fault("robots.several", name, used=True, robots=", ".join(robots[:5]))
        elif others:
            self._tally.warn(
                f"Of several lasers {name} is used; {', '.join(others[:5])} is not. "
                "Set log.scan_topic to change that."
            )
        return name, self._scans[name]

    def _chosen_odometry(self, path: Path, scans: str, frame: str, robots: tuple[str, ...]) -> _ChosenOdometry:
        """The odometry of the robot that has the laser `scans`, and the name of its own frame."""
        wanted, base = self._settings.odometry_topic.strip("/"), self._settings.base_frame.strip("/")
        if wanted == "none":
            return _ChosenOdometry(base=base)
        found = {name: topic for name, topic in self._odometry.items() if not wanted or name.strip("/") == wanted}
        robot = robot_of(scans, frame, robots)
        ours = {
            name: topic for name, topic in found.items() if wanted or self._is_of(robot, name, topic.frame, robots)
        }
        if ours:
            name = max(ours, key=lambda name: (_is_of_wheels(name, ours[name]), len(ours[name].rows)))
            if len(ours) > 1:
                others = ", ".join(sorted(set(ours) - {name})[:5])
                self._tally.fault("odometry.several", name, used=True, others=others)
            rows = np.array(ours[name].rows).reshape(-1, 7)
            return _ChosenOdometry(f"{name}: odometry", name, base or ours[name].frame, rows)
        if wanted and wanted not in ("tf", "/tf"):
            raise BadInput(f"{path.name} holds no odometry on {self._settings.odometry_topic}. {self._contents()}")
        belongs = functools.partial(self._is_of, robot, "", robots=robots)
        pair, rows = self._tree.moving(self._settings.odometry_frame.strip("/"), base, belongs)
        if not len(rows):
            if found or robots:
                self._tally.fault("robots.other_odometry", scans, robots=", ".join(robots[:5]))
            elif self._tree.moving_frames:
                self._tally.fault("odometry.unknown", others=", ".join(sorted(self._tree.moving_frames)[:5]))
            return _ChosenOdometry(base=base)
        label = f"tf {pair[0]} → {pair[1]}"
        return _ChosenOdometry(f"{label}: odometry", label, base or pair[1], np.pad(rows, ((0, 0), (0, 2))))

    @staticmethod
    def _is_of(robot: str | None, topic: str, frame: str, robots: tuple[str, ...]) -> bool:
        """Return whether a topic or a frame belongs to this one of the robots; where there is one, all do."""
        return not robots or robot_of(topic, frame, robots) == robot

    def _track(self, odometry: _ChosenOdometry, laser: StampedStream) -> tuple[OdometryTrack | None, float]:
        """The odometry on one clock with the laser, and the time [s] to add to the laser's stamps for that."""
        if not len(odometry.rows):
            return None, 0.0
        rows = odometry.rows
        wheels, good = settled_stamps(StampedStream(odometry.name, rows[:, 0], rows[:, 1]), self._tally)
        laser_shift, wheels_shift = on_one_clock(laser, wheels, self._tally)
        twists = rows[good, 5:] if np.any(rows[:, 5:]) else None
        track = believable_track(odometry.name, wheels.own[good] + wheels_shift, rows[good, 2:5], twists, self._tally)
        if track is not None:
            self._tally.topics.append(odometry.label)
        return track, laser_shift

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
def typestore(ros1: bool = False) -> Typestore:
    """The types of ROS 2 Jazzy, or of ROS 1 Noetic, and those of sound, of which Foxglove plays RawAudio."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    if ros1:  # which knows everything but tf
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
    return with_sound(store)


def decode(envelope: Envelope, kind: str) -> Any:
    """A message's bytes → its fields. Raises whatever the decoder raises on damaged bytes."""
    if envelope.encoding == "ros1":
        return typestore(True).deserialize_ros1(envelope.content, kind)
    return typestore().deserialize_cdr(envelope.content, kind)


class RosParts:
    """Makes messages of a collection of types, and the parts that many of them have."""

    def __init__(self, store: Typestore, *, ros1: bool = False) -> None:
        self._types, self._ros1 = store.types, ros1

    def make(self, kind: str, **fields: Any) -> Any:
        """A message of this type."""
        return self._types[kind](**fields)

    def time(self, stamp: float) -> Any:
        """A time [s]."""
        seconds, nanoseconds = divmod(round(stamp * 1e9), 1_000_000_000)
        return self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)

    def header(self, stamp: float, frame: str) -> Any:
        """A header with this stamp [s]."""
        number = {"seq": 0} if self._ros1 else {}
        return self.make("std_msgs/msg/Header", stamp=self.time(stamp), frame_id=frame, **number)

    def vector(self, x: float, y: float, z: float) -> Any:
        """A vector of three numbers."""
        return self.make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))

    def turned(self, heading: float) -> Any:
        """A heading [rad] as a quaternion."""
        z, w = math.sin(heading / 2), math.cos(heading / 2)
        return self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=z, w=w)

    def planar(self, pose: Pose) -> Any:
        """A pose on the floor."""
        position = self.make("geometry_msgs/msg/Point", x=pose.x, y=pose.y, z=0.0)
        return self.make("geometry_msgs/msg/Pose", position=position, orientation=self.turned(pose.heading))

    def twist(self, v: float, w: float) -> Any:
        """Speeds [m/s], [rad/s]."""
        linear, angular = self.vector(v, 0.0, 0.0), self.vector(0.0, 0.0, w)
        return self.make("geometry_msgs/msg/Twist", linear=linear, angular=angular)


def stamp_of(header: Any) -> float:
    """A message's header → its stamp [s]."""
    return seconds_of(header.stamp)


def seconds_of(time: Any) -> float:
    """A time of ROS → [s]."""
    return float(time.sec + time.nanosec * 1e-9)
