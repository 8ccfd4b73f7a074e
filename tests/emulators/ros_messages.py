"""What the simulated robot senses → ROS 2 messages in CDR, as a real robot's nodes would publish them."""

import math
import struct
from typing import Any

import cv2
import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from core.geometry import Pose, Transform
from core.message import Array
from core.recording.ros_sound import RAW_AUDIO, with_sound
from core.robots.ros.topics import BATTERY, CAMERA_INFO, COMPRESSED, LASER_SCAN, ODOMETRY
from core.robots.ros.typestore import OTHERS, PARAMETER_NAMES, PARAMETER_VALUES, STRING, TF
from core.sensors import Image, Scan, Sound, Wheels
from core.simulation.robot import SimulatedRobot

DESCRIPTION = "/robot_description"


def _fixed(parent: str, child: str, origin: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{child}_joint" type="fixed">{ends}<origin {origin}/></joint>'


def _link(name: str, shape: str = "") -> str:
    return f'<link name="{name}">{shape and f"<visual><geometry><{shape}/></geometry></visual>"}</link>'


URDF = "".join(
    (
        '<robot name="emulated">',
        _link("base_footprint"),
        _link("base_link", 'cylinder radius="0.11" length="0.09"'),
        _link("left_wheel", 'mesh filename="package://emulated/meshes/wheel.dae"'),
        _link("right_wheel", 'mesh filename="package://emulated/meshes/tyre.dae"'),
        _link("laser", 'cylinder radius="0.035" length="0.04"'),
        _link("camera_optical_frame"),
        _fixed("base_footprint", "base_link", 'xyz="0 0 0.05"'),
        _fixed("base_link", "left_wheel", 'xyz="0 0.1 0"'),
        _fixed("base_link", "right_wheel", 'xyz="0 -0.1 0"'),
        _fixed("base_link", "laser", 'xyz="0.02 0 0.13"'),
        _fixed("base_link", "camera_optical_frame", 'xyz="0.08 0 0.11" rpy="-1.5707963 0 -1.5707963"'),
        "</robot>",
    )
)  # as a robot_state_publisher sends it, with meshes that only the robot has

SIMULATED_START_S = 1000.0  # of an emulated robot: a slow computer holds its clock up, as a simulator's
HEADER = "std_msgs/msg/Header"
PROFILE = SimulatedRobot("lab").profile
ODOMETRY_START = Pose(3.0, -2.0, 0.7)  # a real robot's odometry does not begin where the console connects


def ros2_types() -> Any:
    """The usual types of ROS 2 with those that the emulators need besides."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name in (PARAMETER_NAMES, PARAMETER_VALUES):
        store.register(get_types_from_msg(OTHERS[name], name))
    return with_sound(store)


class RosMessageMaker:
    """Makes the messages of one simulated robot, whose clock shows `start` [s] at the simulator's stamp 0."""

    def __init__(self, start: float, prefix: str = "") -> None:
        self.start, self.prefix = start, prefix
        self.store = ros2_types()
        self.make = self.store.types

    def header(self, stamp: float, frame: str) -> Any:
        return self.make[HEADER](stamp=self.time(stamp), frame_id=self.prefix + frame)

    def time(self, stamp: float) -> Any:
        nanoseconds = round((self.start + stamp) * 1e9)
        return self.make["builtin_interfaces/msg/Time"](sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)

    def scan(self, scan: Scan) -> bytes:
        return self.encode(
            LASER_SCAN,
            header=self.header(scan.stamp, "laser"),
            angle_min=scan.angle_min,
            angle_max=scan.angle_min + scan.angle_step * (len(scan.ranges) - 1),
            angle_increment=scan.angle_step,
            time_increment=scan.time_step,
            scan_time=0.1,
            range_min=scan.range_min,
            range_max=scan.range_max,
            ranges=np.nan_to_num(scan.ranges, nan=0.0, posinf=math.inf).astype(np.float32),
            intensities=np.zeros(0, np.float32),
        )

    def odometry(self, wheels: Wheels, stamp: float) -> bytes:
        pose = ODOMETRY_START @ wheels.odometry
        make = self.make
        vector = make["geometry_msgs/msg/Vector3"]
        place = make["geometry_msgs/msg/Pose"](
            position=make["geometry_msgs/msg/Point"](x=pose.x, y=pose.y, z=0.0), orientation=self.turn(pose.heading)
        )
        twist = make["geometry_msgs/msg/Twist"](
            linear=vector(x=wheels.speed, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=wheels.turn_rate)
        )
        return self.encode(
            ODOMETRY,
            header=self.header(stamp, "odom"),
            child_frame_id=self.prefix + "base_footprint",
            pose=make["geometry_msgs/msg/PoseWithCovariance"](pose=place, covariance=np.zeros(36)),
            twist=make["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=np.zeros(36)),
        )

    def image(self, image: Image) -> bytes:
        jpeg = cv2.imencode(".jpg", image.pixels, [cv2.IMWRITE_JPEG_QUALITY, 90])[1]
        header = self.header(image.stamp, "camera_optical_frame")
        return self.encode(COMPRESSED, header=header, format="jpeg", data=jpeg.ravel())

    def camera_info(self, stamp: float) -> bytes:
        assert PROFILE.camera is not None
        model = PROFILE.camera.model
        projection = np.zeros((3, 4))
        projection[:, :3] = model.matrix
        region = self.make["sensor_msgs/msg/RegionOfInterest"]
        return self.encode(
            CAMERA_INFO,
            header=self.header(stamp, "camera_optical_frame"),
            width=model.width,
            height=model.height,
            distortion_model="plumb_bob",
            d=model.distortion,
            k=model.matrix.ravel(),
            r=np.eye(3).ravel(),
            p=projection.ravel(),
            binning_x=0,
            binning_y=0,
            roi=region(x_offset=0, y_offset=0, height=0, width=0, do_rectify=False),
        )

    def sound(self, sound: Sound) -> bytes:
        samples = np.clip(sound.samples * 32768, -32768, 32767).astype("<i2")
        return self.encode(
            RAW_AUDIO,
            timestamp=self.time(sound.stamp),
            data=np.frombuffer(samples.tobytes(), np.uint8),
            format="pcm-s16",
            sample_rate=sound.rate,
            number_of_channels=sound.channels,
        )

    def battery(self, share: float) -> bytes:
        nothing = dict.fromkeys(("voltage", "temperature", "current", "charge", "capacity"), math.nan)
        empty = np.zeros(0, np.float32)
        return self.encode(
            BATTERY,
            header=self.header(0.0, "battery"),
            percentage=share,
            design_capacity=math.nan,
            power_supply_status=0,
            power_supply_health=0,
            power_supply_technology=0,
            present=True,
            cell_voltage=empty,
            cell_temperature=empty,
            location="",
            serial_number="",
            **nothing,
        )

    def frames(self) -> bytes:
        """/tf_static: base_footprint → base_link → laser and camera."""
        rise = Transform.of_pose(Pose(), 0.05)
        placed = [("base_footprint", "base_link", rise)]
        if PROFILE.laser:
            laser = Transform.of_pose(PROFILE.laser.mounting, PROFILE.laser.height)
            placed.append(("base_link", "laser", rise.inverse() @ laser))
        if PROFILE.camera:
            placed.append(("base_link", "camera_optical_frame", rise.inverse() @ PROFILE.camera.mounting))
        stamped = [self.transform(*one) for one in placed]
        return self.encode(TF, transforms=stamped)

    def description(self, urdf: str) -> bytes:
        return self.encode(STRING, data=urdf)

    def transform(self, parent: str, child: str, parent_from_child: Transform) -> Any:
        x, y, z = (float(number) for number in parent_from_child.translation)
        moved = self.make["geometry_msgs/msg/Transform"](
            translation=self.make["geometry_msgs/msg/Vector3"](x=x, y=y, z=z),
            rotation=self.quaternion(parent_from_child.rotation),
        )
        return self.make["geometry_msgs/msg/TransformStamped"](
            header=self.header(0.0, parent), child_frame_id=self.prefix + child, transform=moved
        )

    def quaternion(self, rotation: Array) -> Any:
        x, y, z, w = (float(number) for number in Rotation.from_matrix(rotation).as_quat())
        return self.make["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w)

    def turn(self, heading: float) -> Any:
        return self.make["geometry_msgs/msg/Quaternion"](
            x=0.0, y=0.0, z=math.sin(heading / 2), w=math.cos(heading / 2)
        )

    def encode(self, name: str, **fields: Any) -> bytes:
        return bytes(self.store.serialize_cdr(self.make[name](**fields), name))


def speeds_of(payload: bytes) -> tuple[float, float] | None:
    """A Twist or TwistStamped in CDR → v [m/s], w [rad/s]; None for bytes that are neither."""
    if len(payload) < 52 or payload[:2] != b"\x00\x01":
        return None
    numbers = struct.unpack("<6d", payload[-48:])
    return numbers[0], numbers[5]
