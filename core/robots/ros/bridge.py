"""A ROS robot's messages → readings, and speeds → messages; the same for every link that carries them."""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from core.errors import BadInput
from core.gate import ZERO, Twist
from core.geometry import Pose, Transform, arc
from core.message import Array
from core.recording.odometry_track import heading_of
from core.recording.read_report import BadRecord
from core.recording.ros import stamp_of
from core.recording.ros_frames import FrameTree
from core.recording.ros_pictures import camera_model, describes, guessed_model, is_rectified, pixels_of
from core.recording.ros_sound import SampleForm, is_packed_sound, sound_in
from core.recording.scans import make_scan, turned_over
from core.robots.device import Base, ClockOffset, Equipment, Findings
from core.robots.device_clock import DeviceClock
from core.robots.readings import Readings
from core.robots.ros.findings import Traffic, roles_of
from core.robots.ros.navigation import RosNavigation, SendGoalMessage
from core.robots.ros.topics import RosSettings, RosTopics
from core.robots.ros.typestore import RobotTypes
from core.robots.urdf import Body, parse_body
from core.sensors import Camera, Fault, Image, Laser, Scan, Sound
from core.sensors.camera import camera_mounting, lens_faults
from core.sensors.checks import UnusableReading, are_finite, fault
from core.sensors.laser import flat
from core.sensors.microphones import load_array
from core.sensors.scan_gate import RangeUnit, checked_angles

FAILSAFE_WORDS = "Unknown whether it stops by itself; ask the robot's maker."
NO_FAILSAFE = "The robot's controller has cmd_vel_timeout = 0: it does not stop when the link is lost. Set it to 0.5."
ZERO_MESSAGES = 5  # messages that say zero, then silence: someone else may drive
ZERO_PERIOD_S = 0.02  # between them
LOCK_PERIOD_S = 0.1  # of the lock's heartbeat

UNMOVED_S = 1.5  # [s] of speeds by which a base has moved, where it takes them
MOVED_M, MOVED_RAD = 0.005, 0.01  # [m], [rad] of odometry from which it has

SAME_CLOCK_S = 10.0  # by which stamps of one clock differ at most; a longer lag looks like another clock
MOST_CLOCKS = 8
MAX_SPEED_HELD_S = 0.5  # over which a speed is carried on to the next one
SOUND_GAP_S = 0.1  # by which a block of sound may come early or late and still follow the one before
MIN_RESTART_S = 8.0  # that a computer with ROS takes to start, at least


class RosClocks:
    """Stamps on the robot's computers' clocks → the console's. Topics whose stamps agree share one clock.

    A topic stays with its clock, however late its messages come and wherever their stamps go: where it alone steps
    or leaps, the others of its clock show that it does.
    """

    def __init__(self, *, simulated: bool) -> None:
        """`simulated`: the robot's clock is a simulator's, which may be held up."""
        self._simulated = simulated
        self._clocks: deque[DeviceClock] = deque(maxlen=MOST_CLOCKS)
        self._users: dict[str, DeviceClock] = {}  # topic → the clock of its stamps
        self._newest: dict[str, float] = {}  # topic → when its newest message was measured [s]
        self.received = -math.inf  # [s] when the newest message with a stamp came

    def stamp(self, topic: str, own: float, received: float) -> float:
        """A message's own stamp [s], 0 for none, and when it came → when it was measured.

        One without a stamp on a topic that had some is as old as the one before.
        """
        if own <= 0 or not math.isfinite(own):
            return self._newest.get(topic, received)
        self.received = received
        clock = self._users[topic] = self._users.get(topic) or self._agreeing(own, received)
        self._newest[topic] = clock.stamp(own, received, topic)
        return self._newest[topic]

    def _agreeing(self, own: float, received: float) -> DeviceClock:
        for clock in self._clocks:
            if clock.offset is not None and abs(received - own - clock.offset) < SAME_CLOCK_S:
                return clock
        self._clocks.appendleft(DeviceClock(follows=self._simulated))
        return self._clocks[0]

    @property
    def offsets(self) -> tuple[ClockOffset, ...]:
        """Every clock in use, named by the topics that it stamps."""
        topics: dict[DeviceClock, list[str]] = {}
        for topic, clock in list(self._users.items()):
            topics.setdefault(clock, []).append(topic)
        return tuple(
            ClockOffset(clock=", ".join(sorted(names)), offset_s=round(offset, 4))
            for clock, names in topics.items()
            if (offset := clock.offset) is not None
        )


class RosSensors:
    """Takes the messages of the chosen topics: first to learn what the robot has, then to hand them on."""

    def __init__(self, types: RobotTypes, topics: RosTopics, send_goal: SendGoalMessage) -> None:
        """`send_goal` hands a goal to the robot's own navigation."""
        self.types, self.topics = types, topics
        self.navigation = RosNavigation(topics, send_goal)
        self.notices: list[str] = list(topics.notices)
        self.timeout: float | None = None  # [s] cmd_vel_timeout of the robot's controller; None: it does not say
        self.body: Body | None = None  # as the robot describes it
        self._said: list[str] = []  # notices that were handed on
        self._placed: set[str] = set()  # sensors whose mounting the robot says
        self._traffic = Traffic()
        self._publisher = ""  # of the message that is taken
        self._readings: Readings | None = None
        self._now: Callable[[], float] = time.monotonic  # [s], since it is attached by the clock of its readings
        self._clocks = RosClocks(simulated=topics.simulated)
        self._tree = FrameTree()
        self._base_frame = topics.base_frame
        self._lasers: dict[str, tuple[str, Laser]] = {}  # topic → frame, geometry
        self._turned: set[str] = set()  # lasers that hang upside down
        self._last: dict[str, float] = {}  # topic → stamp of its last scan
        self._view: tuple[str, int, int] | None = None  # the pictures' frame, width, height
        self._info: Any | None = None
        self._heard: set[str] = set()  # topics of which something could be used
        self._sound_end = 0.0
        self._battery_scale = 1.0  # of a reading → share; 0.01 once one was above 1, which is then in per cent
        self.place: Pose | None = None  # by its odometry; None: none came yet
        self._rolled: tuple[float, Pose] | None = None  # by speeds, of an odometry without heading: stamp [s], place
        self._faults: list[Fault] = []
        self._units: dict[str, RangeUnit] = {}  # of the ranges of each laser's topic
        self._takers: dict[str, Callable[[str, Any, float], None]] = {
            topic: taker
            for topic, taker in (
                (topics.odometry, self._take_odometry),
                (topics.image, self._take_image),
                (topics.camera_info, self._take_info),
                (topics.sound, self._take_sound),
                (topics.battery, self._take_battery),
                (topics.frames, self._take_frames),
                (topics.moving_frames, self._take_moving_frames),
                (topics.map, self._take_map),
                (topics.pose, self._take_pose),
                (topics.description, self._take_description),
                *((scan, self._take_scan) for scan in topics.scans),
            )
            if topic
        }

    @property
    def newest_only(self) -> frozenset[str]:
        """Topics of which older messages may be left out when newer ones are there."""
        return frozenset({self.topics.image, self.topics.map} - {""})

    @property
    def missing(self) -> list[str]:
        """The topics that describe the robot and of which nothing has come yet, or no mounting on /tf alone."""
        wanted = (*self.topics.scans, self.topics.image, self.topics.camera_info, self.topics.frames)
        more = (self.topics.odometry, self.topics.description)
        silent = [topic for topic in (*wanted, *more) if topic and topic not in self._heard]
        moving = "" if self.topics.frames else self.topics.moving_frames
        placed = all(self._placed_at(frame) is not None for frame, _ in self._lasers.values())
        return silent if placed or not moving else [*silent, moving]

    def attach(self, readings: Readings) -> None:
        """Hand on what comes from now on. After a loss too short for a restart its clocks are known: it may lag."""
        other, self._now = self._now != readings.now, readings.now
        if other or self._now() - self._clocks.received > MIN_RESTART_S:
            self._clocks = RosClocks(simulated=self.topics.simulated)
        self._last, self._sound_end = {}, 0.0
        self._readings = readings
        for sentence in self.notices:
            readings.note(sentence)
        self._said += self.notices
        self.notices = []

    def doubt(self, found: Fault) -> None:
        """Tell the operator of a fault that others found."""
        if self._readings is not None:
            self._readings.doubt(found)

    def detach(self) -> None:
        """Hand nothing on until `attach`."""
        self._readings = None

    def findings(self, settings: RosSettings) -> Findings:
        """Return the findings on the robot, to be shown; from any thread."""
        return Findings(
            base_frame=self._base_frame,
            roles=roles_of(self.topics, settings, self._traffic),
            placed=tuple(sorted(self._placed)),
            clocks=() if self._now is time.monotonic else self._clocks.offsets,  # before, of no clock of the robot's
            faults=tuple(self._faults),
            remarks=tuple(dict.fromkeys((*self._said, *self.notices, *(self.body.notices if self.body else ())))),
        )

    def take(self, topic: str, payload: bytes | memoryview, publisher: str = "") -> None:
        """A message as it came; what cannot be decoded or used is counted in `types.errors`.

        `publisher`: who sent it, where the wire tells.
        """
        if topic in self._takers:
            self._publisher = publisher
            received = self._now()
            content = self.types.decode(topic, self.topics.types[topic], payload)
            if content is not None:
                self._take(topic, content, received)
            else:
                self._arrived(topic, readable=False)

    def take_fields(self, topic: str, content: Any) -> None:
        """A message as it came, decoded already."""
        if topic in self._takers:
            self._take(topic, content, self._now())

    def _take(self, topic: str, content: Any, received: float) -> None:
        try:
            self._takers[topic](topic, content, received)
            self._heard.add(topic)
            self._traffic.note(topic, content)
            self._arrived(topic)
        except UnusableReading:  # which was said
            self.types.errors[topic] += 1
        except Exception:  # whatever a hostile message brings about, the next one may be fine
            self.types.errors[topic] += 1
            self._arrived(topic, readable=False)

    def _arrived(self, topic: str, *, readable: bool = True) -> None:
        if self._readings is not None:
            self._readings.arrived(topic, readable=int(readable), unreadable=int(not readable))

    def equipment(self, name: str) -> Equipment:
        """Equipment of the robot, as far as its messages say it; `notices` names what they leave out."""
        topics = self.topics
        for topic in (one for one in self.missing if one not in self._heard):
            self.notices.append(f"{topic} is there, but nothing comes on it.")
        if topics.sound and not topics.array:
            self.notices.append(
                f"Where the microphones of {topics.sound} sit is not known; the setting array says it."
            )
        lasers = tuple(self._mounted(topic) for topic in topics.scans if topic in self._lasers)
        camera = self._camera()
        if self.timeout == 0.0 and topics.cmd_vel:
            self.notices.append(NO_FAILSAFE)
        base = Base(
            failsafe=self.timeout or None,
            failsafe_words=FAILSAFE_WORDS if self.timeout is None else "",
            odometry=bool(topics.odometry),
            lock=topics.lock,
        )
        return Equipment(
            name=name,
            base=base if topics.cmd_vel else None,
            lasers=lasers,
            cameras=(camera,) if camera else (),
            microphones=(load_array(topics.array),) if topics.array and topics.sound else (),
            body=self.body,
            navigates=self.navigation.there,
        )

    def _take_frames(self, topic: str, content: Any, received: float) -> None:
        for transform in content.transforms:
            self._tree.add(transform, stamp_of(transform.header), received, fixed=True)

    def _take_moving_frames(self, topic: str, content: Any, received: float) -> None:
        """Transforms on /tf; until the robot is known, those that stay as they are count as fixed ones."""
        self.navigation.take_frames(content)
        if self._readings is None:
            for transform in content.transforms:
                self._tree.add(transform, stamp_of(transform.header), received, fixed=False)

    def _take_map(self, topic: str, content: Any, received: float) -> None:
        why_not = self.navigation.take_map(content)
        if why_not and self._readings is not None:
            self._readings.note(why_not)
        elif why_not:
            self.notices.append(why_not)

    def _take_pose(self, topic: str, content: Any, received: float) -> None:
        self.navigation.take_pose(content, self._clocks.stamp(topic, stamp_of(content.header), received))

    def _take_description(self, topic: str, content: Any, received: float) -> None:
        self.describe(str(content.data), topic)

    def describe(self, text: str, source: str) -> None:
        """Take in the URDF that the robot says of itself; a bad one, or what is left out of it, gets a notice."""
        if self.body is None:
            try:
                self.body = parse_body(text, source)
            except BadInput as why:
                self.notices.append(str(why))

    def _placed_at(self, frame: str) -> Transform | None:
        """robot_from_frame by the robot's transforms, or else by its description; None: neither says it."""
        placed = self._tree.transform(self._base_frame, frame)
        if placed is None and self.body is not None:
            placed = self.body.links.get(frame) or self.body.links.get(f"/{frame}")
        return placed

    def fault(self, code: str, sensor: str = "", *, used: bool = False, **values: object) -> None:
        """Add what a check found in a topic; each kind is said once."""
        if all((one.code, one.sensor) != (code, sensor) for one in self._faults):
            self._faults.append(fault(code, sensor, used=used, **values))
            self.notices.append(self._faults[-1].sentence)
            self.doubt(self._faults[-1])

    def _take_scan(self, topic: str, content: Any, received: float) -> None:
        stamp = self._clocks.stamp(topic, stamp_of(content.header), received)
        unit = self._units.setdefault(topic, RangeUnit(topic, self))
        try:
            ranges, limits = unit.metres(
                np.asarray(content.ranges, np.float32), (content.range_min, content.range_max)
            )
        except UnusableReading as refused:
            for one in refused.faults:
                self.fault(one.code, one.sensor)
            raise
        ends = content.angle_min, content.angle_max
        angles = checked_angles(topic, len(ranges), ends, content.angle_increment, self)
        scan = make_scan(stamp, ranges, angles, limits, content.time_increment)
        self._lasers.setdefault(topic, (content.header.frame_id.strip("/"), _laser_of(scan, content.scan_time)))
        if self._readings is None:
            return
        overtaken = scan.stamp <= self._last.get(topic, -math.inf)
        if not overtaken:
            self._last[topic] = min(scan.stamp, received)  # one that is stamped far ahead holds up none that follow
        seen = replace(turned_over(scan) if topic in self._turned else scan, laser=laser_name(topic, self.topics))
        self._readings.scan(seen, f"{self._publisher} {content.header.frame_id}", overtaken=overtaken)

    def _take_odometry(self, topic: str, content: Any, received: float) -> None:
        place, q, twist = content.pose.pose.position, content.pose.pose.orientation, content.twist.twist
        if not are_finite(place.x, place.y, twist.linear.x, twist.angular.z):
            if self._readings is not None:
                self._readings.fault("odometry.malformed", what="a value is no finite number")
            return  # it would last: in the place by speeds, and in a goal that lets the robot stand where it is
        self._base_frame = self._base_frame or content.child_frame_id.strip("/")
        stamp = self._clocks.stamp(topic, stamp_of(content.header), received)
        if 0.5 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 2.0:
            pose = Pose(float(place.x), float(place.y), float(heading_of(q.x, q.y, q.z, q.w)))
        else:
            pose = self._by_speeds(topic, float(twist.linear.x), float(twist.angular.z), stamp)
        self.place = pose
        self.navigation.take_odometry(content.header, pose, float(twist.linear.x), stamp)
        if self._readings is not None:
            named = f"{self._publisher} {content.header.frame_id} {content.child_frame_id}"
            self._readings.wheels(pose, float(twist.linear.x), float(twist.angular.z), stamp, named)

    def _by_speeds(self, topic: str, speed: float, turn_rate: float, stamp: float) -> Pose:
        """Return where the speeds [m/s], [rad/s] of an odometry without heading have led until `stamp` [s]."""
        if self._rolled is None:
            self.fault("odometry.no_heading", topic, used=True, instead="its speeds are used")
        last, pose = self._rolled or (stamp, Pose())
        elapsed = min(max(stamp - last, 0.0), MAX_SPEED_HELD_S)
        self._rolled = stamp, pose @ arc(speed * elapsed, turn_rate * elapsed)
        return self._rolled[1]

    def _take_image(self, topic: str, content: Any, received: float) -> None:
        """A picture; once the robot is known, decoded where someone takes it."""
        stamp = self._clocks.stamp(topic, stamp_of(content.header), received)
        if self._readings is not None:
            self._readings.undecoded(lambda: self._image(topic, content, stamp))
            return
        pixels = self._pixels(topic, content)
        self._view = content.header.frame_id.strip("/"), pixels.shape[1], pixels.shape[0]

    def _image(self, topic: str, content: Any, stamp: float) -> Image | None:
        try:
            return Image(stamp=stamp, pixels=self._pixels(topic, content))
        except Exception:  # whatever a hostile picture brings about, the next one may be fine
            self.types.errors[topic] += 1
            self._arrived(topic, readable=False)
            return None

    def _pixels(self, topic: str, content: Any) -> Array:
        return pixels_of(content, self.topics.types[topic])

    def _take_info(self, topic: str, content: Any, received: float) -> None:
        self._info = content

    def _take_battery(self, topic: str, content: Any, received: float) -> None:
        said = float(content.percentage)
        if not 0 <= said <= 100:
            return
        if said > 1:  # some drivers say per cent, and go on to say 1 for the last of them
            self._battery_scale = 0.01
        if self._readings is not None:
            self._readings.battery(self._battery_scale * said)

    def _take_sound(self, topic: str, content: Any, received: float) -> None:
        said, packed, own = sound_in(content, self.topics.types[topic])
        if said is None and is_packed_sound(packed):
            raise BadRecord("its sound is compressed")
        form = said or SampleForm()
        samples = form.samples_of(packed)
        stamp = self._clocks.stamp(topic, own, received)
        if abs(stamp - self._sound_end) < SOUND_GAP_S:
            stamp = self._sound_end
        self._sound_end = stamp + len(samples) / form.rate
        if self._readings is not None and len(samples):
            self._readings.sound(Sound(stamp=stamp, rate=form.rate, samples=samples))

    def _mounted(self, topic: str) -> Laser:
        """The laser of a topic, at its place on the robot."""
        frame, laser = self._lasers[topic]
        found = self._placed_at(frame)
        if found is None:
            moves = frame in self._tree.moving_frames
            self.notices.append(
                f"The mounting of {frame} is on /tf and moves; it is taken to be central."
                if moves
                else f"The robot does not say where {frame or topic} is mounted; it is taken to be central."
            )
            return replace(laser, name=laser_name(topic, self.topics))
        placed = flat(found)
        beams_end = laser.angle_min + (laser.beams - 1) * laser.angle_step
        if placed.upside_down:
            self._turned.add(topic)
        self._placed.add(laser_name(topic, self.topics))
        return replace(
            laser,
            name=laser_name(topic, self.topics),
            mounting=placed.pose,
            height=placed.height,
            angle_min=-beams_end if placed.upside_down else laser.angle_min,
            time_step=-laser.time_step if placed.upside_down else laser.time_step,
        )

    def _camera(self) -> Camera | None:
        if self._view is None:
            return None
        frame, width, height = self._view
        image, info = self.topics.image, self.topics.camera_info
        rectified = is_rectified(image)
        sent = None if self._info is None else camera_model(self._info, width, height, rectified=rectified)
        model, known = sent or guessed_model(width, height), sent is not None
        if not known:
            self.notices.append(f"{image} comes from a camera that is not calibrated; calibrate it.")
        elif not describes(info, self._info, image, frame):
            self.notices.append(
                f"{info} may be of another camera than {image}: neither is it beside it, nor of its frame. Set "
                "camera_info in *Connect*, or calibrate the camera."
            )
        if known:
            self.notices += [one.statement for one in lens_faults(image, model)]
        found = self._placed_at(frame)
        if found is None:
            self.notices.append(f"The robot does not say where {frame or self.topics.image} is mounted.")
            return Camera(model=model, rate=None, optics_known=known, mounting_known=False)
        self._placed.add(Camera.name)
        return Camera(model=model, mounting=camera_mounting(found, frame), rate=None, optics_known=known)


def laser_name(topic: str, topics: RosTopics) -> str:
    """Name of a laser on this robot: "laser" where it is the only one, else by its topic, "front_scan"."""
    return "laser" if len(topics.scans) == 1 else topic.strip("/").replace("/", "_")


def _laser_of(scan: Scan, period: float) -> Laser:
    """A scan and the time [s] between two of them → the laser, at the robot's origin."""
    is_known = math.isfinite(period) and 0.005 < period < 2
    return Laser(
        beams=len(scan.ranges),
        angle_min=scan.angle_min,
        angle_step=scan.angle_step,
        range_min=scan.range_min,
        range_max=scan.range_max,
        rate=1 / period if is_known else None,
        time_step=scan.time_step,
    )


class UnmovedBase:
    """Watches whether a base moves at all by the speeds that it is sent."""

    def __init__(self) -> None:
        self.moved = False  # it did
        self._sent_s = 0.0  # [s] for which it was sent speeds
        self._last = -math.inf  # [s] when it was sent the last ones
        self._start: Pose | None = None  # of this motion

    def watch(self, twist: Twist, place: Pose | None, now: float) -> bool:
        """Take what is sent, and where the odometry is → True where it was sent for long, and did not move.

        `now` [s]. Once it has moved that way, it is not doubted any more.
        """
        if self.moved or not twist.moves or place is None:
            self._start = None
            return False
        if self._start is None:
            self._start, self._last = place, now
        rolled = self._start.inverse() @ place
        self.moved = math.hypot(rolled.x, rolled.y) > MOVED_M or abs(rolled.heading) > MOVED_RAD
        self._sent_s += min(now - self._last, MAX_SPEED_HELD_S)
        self._last = now
        if self.moved or self._sent_s < UNMOVED_S:
            return False
        self._sent_s = 0.0
        return True


class VelocityCommands:
    """When speeds are sent: at every call while the robot is to move, then a few zeros, then nothing at all.

    With a lock, that is closed after the zeros until the next motion, and sent as a heartbeat. It is open, too, while
    the robot's own navigation was let drive.
    """

    def __init__(
        self,
        send: Callable[[Twist], None],
        send_lock: Callable[[bool], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`send` and `send_lock` put a message on the link; they raise OSError when it is lost."""
        self._send, self._send_lock, self._clock = send, send_lock, clock
        self._guard = threading.Lock()
        self._owed = 0  # zeros
        self._open = False  # the lock, for what is sent
        self._let = False  # its own navigation may drive
        self._sent = self._locked = -math.inf  # [s] when the last of each was sent

    def drive(self, twist: Twist) -> None:
        """Speeds that are asked for now; called again and again."""
        with self._guard:
            if twist.moves and twist.is_finite():
                if not self._open:
                    self._open = True
                    self._beat()
                self._owed = ZERO_MESSAGES
                self._put(twist)
            elif self._owed == ZERO_MESSAGES:
                self._put_zero()
        self.tick()

    def tick(self) -> None:
        """Send what is due; call it at least 20 times a second."""
        with self._guard:
            now = self._clock()
            if 0 < self._owed < ZERO_MESSAGES and now - self._sent >= ZERO_PERIOD_S:
                self._put_zero()
            if now - self._locked >= LOCK_PERIOD_S:
                self._beat()

    def let_drive(self, let: bool) -> None:
        """Open the lock for the robot's own navigation, or close it again; with the next `tick` at the latest."""
        with self._guard:
            if let != self._let:
                self._let, self._locked = let, -math.inf

    def stand(self) -> None:
        """Owe zeros, also where another drove, and close the lock now. Raises OSError when the link is lost."""
        with self._guard:
            self._let = self._open = False
            self._beat()
            self._owed = ZERO_MESSAGES - 1

    def restart(self) -> None:
        """The link is up again: a robot that was driven over the former one gets zeros first.

        Those that were sent may have gone into a link that was dead already, but not yet known to be.
        """
        with self._guard:
            if self._sent > -math.inf:
                self._open, self._owed = True, ZERO_MESSAGES - 1

    def finish(self) -> None:
        """Send all zeros that are owed, at once."""
        with self._guard:
            while self._owed:
                self._put_zero()

    def _put_zero(self) -> None:
        self._owed -= 1
        self._put(ZERO)
        if not self._owed:
            self._open = False
            self._beat()

    def _put(self, twist: Twist) -> None:
        self._sent = self._clock()
        self._send(twist)

    def _beat(self) -> None:
        self._locked = self._clock()
        if self._send_lock is not None:
            self._send_lock(not (self._open or self._let))
