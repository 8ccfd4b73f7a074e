"""Readings and results as ROS 2 messages in CDR: what `core.recording.ros` reads, and other programs open."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from core.geometry import Pose, Transform
from core.recording import frame_record
from core.recording.frame_record import FRAME, ROBOT, WHOLE_MAP, FrameRecord, RobotRecord
from core.recording.ros import LASER_SCAN, ODOMETRY, TF, RosParts, typestore
from core.recording.ros_pictures import CAMERA_INFO, COMPRESSED
from core.recording.ros_sound import RAW_AUDIO
from core.sensors import Camera, Image, Laser, Scan, SensorFrame, Sound, Wheels
from core.sensors.recordable import PNG_MAGIC, pack_picture, pcm_of
from core.slam.estimate import Estimate, Landmark
from core.slam.map.occupancy import OccupancyGrid

TEXT, DEGREES, BYTES = "std_msgs/msg/String", "std_msgs/msg/Int32", "std_msgs/msg/UInt8MultiArray"
MAP, POSE = "nav_msgs/msg/OccupancyGrid", "geometry_msgs/msg/PoseWithCovarianceStamped"
MARKERS, TWIST = "visualization_msgs/msg/MarkerArray", "geometry_msgs/msg/Twist"
BASE, ODOM, WORLD = "base_link", "odom", "map"  # names of the frames
ELLIPSE_SIGMA = 2.0  # standard deviations that the ellipse of a landmark shows
CYLINDER_MARKER = 3  # visualization_msgs/Marker
LATCHED_QOS = (
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline: {sec: 9223372036, nsec: 854775807}\n"
    "  lifespan: {sec: 9223372036, nsec: 854775807}\n  liveliness: 1\n"
    "  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}\n  avoid_ros_namespace_conventions: false\n"
)
LATCHED_TOPICS = frozenset({"/map", "/tf_static", "/camera/camera_info", ROBOT, WHOLE_MAP})
COMMON_TOPICS = {  # of every robot, with their types
    "/odom": ODOMETRY,
    "/tf": TF,
    "/pose": POSE,
    "/landmarks": MARKERS,
    "/map": MAP,
    "/cmd_vel": TWIST,
    "/sound_direction": DEGREES,
    FRAME: TEXT,
    ROBOT: TEXT,
    WHOLE_MAP: BYTES,
}


@dataclass(frozen=True, slots=True)
class RosMessage:
    """A message as it is written."""

    topic: str
    kind: str  # "sensor_msgs/msg/LaserScan"
    stamp: float  # [s], the robot's clock
    data: bytes  # CDR, little endian


def definition(kind: str) -> str:
    """The concatenated definition of a message type, as MCAP's `ros2msg` wants it."""
    return typestore().generate_msgdef(kind, ros_version=2)[0]


def type_hash(kind: str) -> str:
    """The RIHS01 hash of a message type."""
    return typestore().hash_rihs01(kind)


class RosEncoder(RosParts):
    """Makes the messages of one robot."""

    def __init__(self, lasers: tuple[Laser, ...] = (), cameras: tuple[Camera, ...] = ()) -> None:
        super().__init__(typestore())
        self._lasers, self._cameras = lasers, cameras

    def topics(self) -> dict[str, str]:
        """Every topic with its type, but those of sound and of words."""
        scans = {self._scan_topic(laser.name): LASER_SCAN for laser in self._lasers}
        pictures = {self._picture_topic(camera.name): COMPRESSED for camera in self._cameras}
        fixed = {one.topic: one.kind for one in self.fixed(0.0)}
        return COMMON_TOPICS | scans | pictures | fixed

    def _scan_topic(self, laser: str) -> str:
        first = not self._lasers or laser in ("", self._lasers[0].name)
        return "/scan" if first else f"/scan/{laser}"

    def _picture_topic(self, camera: str) -> str:
        first = not self._cameras or camera in ("", self._cameras[0].name)
        return f"/camera{'' if first else f'/{camera}'}/image/compressed"

    # once

    def fixed(self, stamp: float) -> Iterator[RosMessage]:
        """The mounting of the sensors and the camera's model, which do not change."""
        placed = [self._transform(stamp, BASE, _frame(laser), laser.mounting, laser.height) for laser in self._lasers]
        placed += [self._transform(stamp, BASE, camera.name, camera.mounting) for camera in self._cameras]
        if placed:
            yield self._message("/tf_static", TF, stamp, transforms=placed)
        if self._cameras:
            yield self._camera_info(stamp, self._cameras[0])

    # readings

    def readings(self, frame: SensorFrame) -> Iterator[RosMessage]:
        """Readings as they came."""
        if frame.wheels is not None:
            yield from self._wheels(frame.stamp, frame.wheels)
        if frame.scan is not None:
            yield self._scan(frame.scan)
        if frame.image is not None:
            yield self._picture(frame.image)
        if frame.sound is not None:
            yield self._sound(frame.sound)

    def _wheels(self, stamp: float, wheels: Wheels) -> Iterator[RosMessage]:
        stamp, place = stamp - wheels.age, wheels.as_read
        pose = self.make("geometry_msgs/msg/PoseWithCovariance", pose=self.planar(place), covariance=np.zeros(36))
        twist = self.make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=self.twist(wheels.speed, wheels.turn_rate),
            covariance=np.zeros(36),
        )
        header = self.header(stamp, ODOM)
        yield self._message("/odom", ODOMETRY, stamp, header=header, child_frame_id=BASE, pose=pose, twist=twist)
        yield self._message("/tf", TF, stamp, transforms=[self._transform(stamp, ODOM, BASE, place)])

    def _scan(self, scan: Scan) -> RosMessage:
        lasers, ranges = self._lasers, scan.ranges.astype(np.float32)
        return self._message(
            self._scan_topic(scan.laser),
            LASER_SCAN,
            scan.stamp,
            header=self.header(scan.stamp, scan.laser or (_frame(lasers[0]) if lasers else "laser")),
            angle_min=scan.angle_min,
            angle_max=scan.angle_min + scan.angle_step * (len(ranges) - 1),
            angle_increment=scan.angle_step,
            time_increment=scan.time_step,
            scan_time=abs(scan.time_step) * len(ranges),
            range_min=scan.range_min,
            range_max=scan.range_max,
            ranges=ranges,
            intensities=np.zeros(0, np.float32),
        )

    def _picture(self, image: Image) -> RosMessage:
        first = self._cameras[0] if self._cameras else None
        name = image.camera or (first.name if first is not None else "camera")
        packed = image.packed or pack_picture(image.pixels)
        return self._message(
            self._picture_topic(image.camera),
            COMPRESSED,
            image.stamp,
            header=self.header(image.stamp, name),
            format="png" if packed.startswith(PNG_MAGIC) else "jpeg",
            data=np.frombuffer(packed, np.uint8),
        )

    def _sound(self, sound: Sound) -> RosMessage:
        return self._message(
            "/audio",
            RAW_AUDIO,
            sound.stamp,
            timestamp=self.time(sound.stamp),
            data=np.frombuffer(np.ascontiguousarray(pcm_of(sound.samples)).tobytes(), np.uint8),
            format="pcm-s16",
            sample_rate=int(sound.rate),
            number_of_channels=sound.samples.shape[1],
        )

    def frame(self, record: FrameRecord) -> RosMessage:
        """The part of a frame that its other messages do not hold to the last bit, and what was made of it."""
        return self.text(FRAME, record.stamp, frame_record.encode(record).decode())

    def robot(self, stamp: float, record: RobotRecord) -> RosMessage:
        """The robot that is recorded."""
        return self.text(ROBOT, stamp, frame_record.encode(record).decode())

    # results

    def pose(self, stamp: float, estimate: Estimate, odometry: Pose | None) -> Iterator[RosMessage]:
        """The estimated pose with its covariance; `odometry`: where its wheels say."""
        covariance = np.zeros((6, 6))
        of = np.array([0, 1, 5])
        covariance[np.ix_(of, of)] = estimate.covariance
        pose = self.make(
            "geometry_msgs/msg/PoseWithCovariance", pose=self.planar(estimate.pose), covariance=covariance.ravel()
        )
        yield self._message("/pose", POSE, stamp, header=self.header(stamp, WORLD), pose=pose)
        if odometry is not None:
            drifted = estimate.pose @ odometry.inverse()
            yield self._message("/tf", TF, stamp, transforms=[self._transform(stamp, WORLD, ODOM, drifted)])

    def landmarks(self, stamp: float, rows: Iterable[Landmark]) -> RosMessage:
        """The corners with their ellipses of two standard deviations."""
        return self._message("/landmarks", MARKERS, stamp, markers=[self._ellipse(stamp, row) for row in rows])

    def grid(self, stamp: float, grid: OccupancyGrid) -> RosMessage:
        """The occupancy map: -1 unknown, else the chance of an obstacle in percent."""
        chance = np.rint(100.0 / (1.0 + np.exp(-grid.log_odds))).astype(np.int8)
        rows, columns = grid.log_odds.shape
        x, y = grid.origin.tolist()
        info = self.make(
            "nav_msgs/msg/MapMetaData",
            map_load_time=self.time(stamp),
            resolution=grid.resolution,
            width=columns,
            height=rows,
            origin=self.planar(Pose(x, y, 0.0)),
        )
        return self._message(
            "/map",
            MAP,
            stamp,
            header=self.header(stamp, WORLD),
            info=info,
            data=np.where(grid.log_odds == 0, np.int8(-1), chance).ravel(),
        )

    def whole_map(self, stamp: float, content: bytes) -> RosMessage:
        """Everything that the estimator goes on with: `SavedMap.to_bytes`."""
        layout = self.make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
        return self._message(WHOLE_MAP, BYTES, stamp, layout=layout, data=np.frombuffer(content, np.uint8))

    def speeds(self, stamp: float, v: float, w: float) -> RosMessage:
        """The speeds that the gate let through [m/s], [rad/s]."""
        twist = self.twist(v, w)
        return self._message("/cmd_vel", TWIST, stamp, linear=twist.linear, angular=twist.angular)

    def direction(self, stamp: float, azimuth: float) -> RosMessage:
        """The direction of a voice [rad] in the robot's frame, in whole degrees."""
        return self._message("/sound_direction", DEGREES, stamp, data=round(math.degrees(azimuth)))

    def text(self, topic: str, stamp: float, content: str | Mapping[str, object]) -> RosMessage:
        """Words, or an object as JSON."""
        words = content if isinstance(content, str) else json.dumps(content)
        return self._message(topic, TEXT, stamp, data=words)

    # pieces

    def _message(self, topic: str, kind: str, stamp: float, **fields: Any) -> RosMessage:
        raw = typestore().serialize_cdr(self.make(kind, **fields), kind)
        return RosMessage(topic, kind, stamp, bytes(raw))

    def _quaternion(self, place: Pose | Transform) -> Any:
        if isinstance(place, Pose):
            return self.turned(place.heading)
        turn = cv2.Rodrigues(place.rotation)[0].ravel()  # SciPy would take the recorder 20 MB
        angle = float(np.linalg.norm(turn))
        x, y, z = (0.5 * np.sinc(0.5 * angle / math.pi) * turn).tolist()
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=math.cos(0.5 * angle))

    def _transform(self, stamp: float, parent: str, child: str, place: Pose | Transform, height: float = 0.0) -> Any:
        """`height` [m] of a pose above its frame's floor."""
        at = (place.x, place.y, height) if isinstance(place, Pose) else place.translation.tolist()
        return self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(stamp, parent),
            child_frame_id=child,
            transform=self.make(
                "geometry_msgs/msg/Transform", translation=self.vector(*at), rotation=self._quaternion(place)
            ),
        )

    def _camera_info(self, stamp: float, camera: Camera) -> RosMessage:
        model = camera.model
        p = np.zeros((3, 4))
        p[:, :3] = model.matrix
        return self._message(
            "/camera/camera_info",
            CAMERA_INFO,
            stamp,
            header=self.header(stamp, camera.name),
            height=model.height,
            width=model.width,
            distortion_model="plumb_bob",
            d=model.distortion,
            k=model.matrix.ravel(),
            r=np.eye(3).ravel(),
            p=p.ravel(),
            binning_x=0,
            binning_y=0,
            roi=self.make(
                "sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
            ),
        )

    def _ellipse(self, stamp: float, row: Landmark) -> Any:
        values, vectors = np.linalg.eigh(row.covariance)
        across, along = (2 * ELLIPSE_SIGMA * np.sqrt(np.maximum(values, 1e-12))).tolist()
        x, y = row.position.tolist()
        return self.make(
            "visualization_msgs/msg/Marker",
            header=self.header(stamp, WORLD),
            ns="landmarks",
            id=row.id,
            type=CYLINDER_MARKER,
            action=0,
            pose=self.planar(Pose(x, y, math.atan2(vectors[1, 1], vectors[0, 1]))),
            scale=self.vector(along, across, 0.02),
            color=self.make("std_msgs/msg/ColorRGBA", r=0.0, g=0.6, b=0.7, a=0.5),
            lifetime=self.make("builtin_interfaces/msg/Duration", sec=0, nanosec=0),
            frame_locked=False,
            points=[],
            colors=[],
            texture_resource="",
            texture=self.make(
                "sensor_msgs/msg/CompressedImage", header=self.header(0.0, ""), format="", data=np.zeros(0, np.uint8)
            ),
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=self.make("visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, np.uint8)),
            mesh_use_embedded_materials=False,
        )


def _frame(laser: Laser) -> str:
    return laser.name or "laser"
