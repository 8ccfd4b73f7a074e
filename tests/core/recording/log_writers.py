"""Writes small logs in every form, so that each reader is tested on a file whose content is known."""

import math
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ROS2 = get_typestore(Stores.ROS2_JAZZY)
ROS1 = get_typestore(Stores.ROS1_NOETIC)
ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
SCAN, ODOMETRY, TF = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
START = 1_700_000_000.0  # [s]
BEAMS = 90
STEP = math.radians(2)


def ranges_of(index: int, beams: int = BEAMS) -> np.ndarray:
    """The ranges (beams,) [m] of scan `index`: every scan differs, every beam differs."""
    return (1.0 + 0.01 * np.arange(beams) + 0.001 * index).astype(np.float32)


def pose_of(time: float) -> tuple[float, float, float]:
    """Where the robot of all test logs is after `time` [s]: an arc from (1, 2) with heading 0.3."""
    heading = 0.3 + 0.2 * time
    return 1 + (math.sin(heading) - math.sin(0.3)), 2 - (math.cos(heading) - math.cos(0.3)), heading


class Types:
    """Messages of one typestore."""

    def __init__(self, store, ros1=False):
        self.store, self.ros1, self.types = store, ros1, store.types

    def header(self, stamp: float, frame: str):
        seconds = int(stamp)
        time = self.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=round((stamp - seconds) * 1e9))
        extra = {"seq": 0} if self.ros1 else {}
        return self.types["std_msgs/msg/Header"](stamp=time, frame_id=frame, **extra)

    def scan(self, stamp: float, ranges, frame="laser", step=STEP, **changes):
        fields = {
            "header": self.header(stamp, frame),
            "angle_min": -step * (len(ranges) - 1) / 2,
            "angle_max": step * (len(ranges) - 1) / 2,
            "angle_increment": step,
            "time_increment": 1e-4,
            "scan_time": 0.1,
            "range_min": 0.02,
            "range_max": 5.6,
            "ranges": np.asarray(ranges, np.float32),
            "intensities": np.zeros(0, np.float32),
        }
        return self.types[SCAN](**(fields | changes))

    def quaternion(self, heading: float, roll=0.0):
        c, s, cr, sr = math.cos(heading / 2), math.sin(heading / 2), math.cos(roll / 2), math.sin(roll / 2)
        return self.types["geometry_msgs/msg/Quaternion"](x=c * sr, y=s * sr, z=s * cr, w=c * cr)

    def odometry(self, stamp: float, pose, twist=(0.1, 0.2), child="base_link"):
        make = self.types.__getitem__
        vector = make("geometry_msgs/msg/Vector3")
        place = make("geometry_msgs/msg/Pose")(
            position=make("geometry_msgs/msg/Point")(x=pose[0], y=pose[1], z=0.0),
            orientation=self.quaternion(pose[2]),
        )
        speed = make("geometry_msgs/msg/Twist")(
            linear=vector(x=twist[0], y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=twist[1])
        )
        return make(ODOMETRY)(
            header=self.header(stamp, "odom"),
            child_frame_id=child,
            pose=make("geometry_msgs/msg/PoseWithCovariance")(pose=place, covariance=np.zeros(36)),
            twist=make("geometry_msgs/msg/TwistWithCovariance")(twist=speed, covariance=np.zeros(36)),
        )

    def tf(self, stamp: float, parent: str, child: str, pose, height=0.0, roll=0.0):
        make = self.types.__getitem__
        moved = make("geometry_msgs/msg/Transform")(
            translation=make("geometry_msgs/msg/Vector3")(x=pose[0], y=pose[1], z=height),
            rotation=self.quaternion(pose[2], roll),
        )
        stamped = make("geometry_msgs/msg/TransformStamped")(
            header=self.header(stamp, parent), child_frame_id=child, transform=moved
        )
        return make(TF)(transforms=[stamped])


two, one = Types(ROS2), Types(ROS1, ros1=True)


def robot_messages(kind: Types, scans=20, odometry="message", mounting=(0.1, -0.05, 0.2)):
    """(topic, type, stamp, message) of a robot that drives an arc: scans at 10 Hz, odometry at 20 Hz, a mounting."""
    told = []
    if mounting is not None:
        told.append(("/tf_static", TF, START, kind.tf(START, "base_link", "laser", mounting, height=0.23)))
    for index in range(2 * scans):
        time = index * 0.05
        if odometry == "message":
            told.append(("/odom", ODOMETRY, START + time, kind.odometry(START + time, pose_of(time))))
        elif odometry == "tf":
            told.append(("/tf", TF, START + time, kind.tf(START + time, "odom", "base_link", pose_of(time))))
        if index % 2 == 0:
            told.append(("/scan", SCAN, START + time, kind.scan(START + time, ranges_of(index // 2))))
    return told


def write_mcap(path: Path, messages, compression=CompressionType.ZSTD, chunk_size=4096, encoding="cdr", **options):
    """Messages (topic, type, stamp, message or bytes) → an MCAP file."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=compression, chunk_size=chunk_size, **options)
        writer.start(profile="ros2", library="test")
        channels = {}
        for topic, kind, stamp, message in messages:
            if topic not in channels:
                known = encoding == "cdr" and not isinstance(message, bytes)
                text = ROS2.generate_msgdef(kind, ros_version=2)[0].encode() if known else b""
                schema = writer.register_schema(kind, "ros2msg" if known else "", text)
                channels[topic] = writer.register_channel(topic, encoding, schema)
            content = message if isinstance(message, bytes) else bytes(ROS2.serialize_cdr(message, kind))
            nanoseconds = round(stamp * 1e9)
            writer.add_message(channels[topic], nanoseconds, content, nanoseconds)
        writer.finish()
    return path


def write_bag(path: Path, messages, compression=None):
    writer = Ros1Writer(path)
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        connections = {}
        for topic, kind, stamp, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=ROS1)
            writer.write(connections[topic], round(stamp * 1e9), ROS1.serialize_ros1(message, kind))
    return path


def write_folder(path: Path, messages, plugin=StoragePlugin.SQLITE3):
    """Messages → the folder of a ROS 2 bag."""
    with Ros2Writer(path, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for topic, kind, stamp, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=ROS2)
            writer.write(connections[topic], round(stamp * 1e9), ROS2.serialize_cdr(message, kind))
    return path


def carmen_lines(scans=10, beams=180) -> list[str]:
    """FLASER and ODOM lines of a robot on the arc, its laser 0.2 m ahead."""
    lines = ["# a comment", "PARAM robot_width 0.5"]
    for index in range(scans):
        time = index * 0.2
        x, y, heading = pose_of(time)
        ahead = (x + 0.2 * math.cos(heading), y + 0.2 * math.sin(heading), heading)
        stamp = f"{START + time:.6f} host {time:.6f}"
        ranges = " ".join(f"{value:.3f}" for value in ranges_of(index, beams))
        lines.append(f"ODOM {x:.6f} {y:.6f} {heading:.6f} 0.2 0.2 0.0 {stamp}")
        told = " ".join(f"{value:.6f}" for value in (*ahead, x, y, heading))
        lines.append(f"FLASER {beams} {ranges} {told} {stamp}")
    return lines
