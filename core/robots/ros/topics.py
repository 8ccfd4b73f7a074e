"""Which of a robot's topics are its laser, its odometry, its camera … : a guess that the operator can overrule."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from core.errors import BadInput, Unavailable
from core.message import message
from core.recording.robot_names import NOT_SEEN, OTHER_ODOMETRY, is_seen, robot_of, robots_in
from core.recording.ros import LASER_SCAN, ODOMETRY, TF, ros2_name
from core.recording.ros_pictures import CAMERA_INFO, COMPRESSED, IMAGE
from core.recording.ros_sound import AUDIO_DATA, AUDIO_STAMPED, RAW_AUDIO
from core.robots.ros.typestore import GOAL, STRING, TWIST, TWIST_STAMPED
from core.sensors.microphones import load_array

BATTERY = "sensor_msgs/msg/BatteryState"
GRID, POSE = "nav_msgs/msg/OccupancyGrid", "geometry_msgs/msg/PoseWithCovarianceStamped"

TYPES = {
    "scan": (LASER_SCAN,),
    "odometry": (ODOMETRY,),
    "image": (COMPRESSED, IMAGE),
    "camera_info": (CAMERA_INFO,),
    "sound": (RAW_AUDIO, AUDIO_STAMPED, AUDIO_DATA),
    "battery": (BATTERY,),
    "map": (GRID,),
    "pose": (POSE,),
    "goal": (GOAL,),
    "description": (STRING,),
    "cmd_vel": (TWIST_STAMPED, TWIST),
}
"""Message types that a topic may carry for each role; the first is preferred."""

DESCRIPTION = "/robot_description"
CLOCK = "/clock"  # of a simulator
MOST_SCANS = 2
NOTHING = "none"  # a setting's value for "do not use any"
NAME = re.compile(r"/?[A-Za-z_][\w/.-]{0,200}")

GOALS = ("goal_pose", "move_base_simple/goal")  # of Nav2, of the navigation of ROS 1
OTHER_POSE = re.compile(r"initial|odom|ekf|imu|gps|visual|slam_toolbox/")
SECOND_RATE = re.compile(r"filter|throttle|merged|matched|multi|virtual|raw_?scan|cloud|debug|test")


@message
class RosSettings:
    """Topics of a robot that are not to be guessed; "" is guessed, "none" is not used."""

    namespace: str = ""  # only topics in here: "/robot1"
    scan: tuple[str, ...] = ()  # one or two lasers
    odometry: str = ""
    image: str = ""
    camera_info: str = ""
    sound: str = ""
    array: str = ""  # profile of the microphones: its name or file; "": their places are not known
    battery: str = ""
    map: str = ""
    pose: str = ""
    goal: str = ""  # where the robot's own navigation takes goals
    cmd_vel: str = ""
    cmd_vel_type: str = ""  # "Twist" or "TwistStamped"
    lock: str = ""  # a std_msgs/Bool of twist_mux, closed while nothing is asked for; "" is none
    base_frame: str = ""
    description: str = ""  # where the robot's URDF comes

    @staticmethod
    def of(fields: Mapping[str, Any]) -> RosSettings:
        """Keys of robot.toml's [robot] or of the URL → settings. Raises BadInput for what is none."""
        known = [field.name for field in dataclasses.fields(RosSettings)]  # type: ignore[arg-type]
        values: dict[str, Any] = {}
        for key, value in fields.items():
            if key not in known:
                raise BadInput(f"A ROS robot has no setting {key[:40]!r}; known are {', '.join(known)}.")
            values[key] = _names(key, value) if key == "scan" else _name(key, value)
        if values.get("cmd_vel_type", "") not in ("", "Twist", "TwistStamped"):
            raise BadInput("cmd_vel_type is Twist or TwistStamped.")
        if array := values.get("array"):
            load_array(array)
        return RosSettings(**values)


@message
class RosTopics:
    """Topics that are read from a robot and written to it; "" is nothing. To be shown before it is used."""

    scans: tuple[str, ...] = ()
    odometry: str = ""
    image: str = ""
    camera_info: str = ""
    sound: str = ""
    array: str = ""  # profile of its microphones
    battery: str = ""
    map: str = ""
    pose: str = ""
    frames: str = ""  # /tf_static
    description: str = ""  # /robot_description
    moving_frames: str = ""  # /tf, for where the robot is on its own map
    goal: str = ""
    cmd_vel: str = "/cmd_vel"
    cmd_vel_type: str = TWIST
    guessed: bool = False  # the type of the speeds: nothing on the robot says it
    simulated: bool = False  # a simulator gives the time
    lock: str = ""
    base_frame: str = ""
    types: Mapping[str, str]  # topic → its type, of all that are read
    candidates: Mapping[str, tuple[tuple[str, str], ...]]  # role → topic, type
    notices: tuple[str, ...] = ()  # sentences about what could not be decided

    @property
    def read(self) -> tuple[str, ...]:
        """The topics that sensors are read from."""
        single = (self.odometry, self.image, self.camera_info, self.sound, self.battery)
        whole = (self.frames, self.description, self.map, self.pose, self.moving_frames)
        return (*self.scans, *filter(None, (*single, *whole)))


def choose_topics(
    found: Iterable[tuple[str, str]], settings: RosSettings, listeners: Collection[str] | None = None
) -> RosTopics:
    """The robot's topics, each with its type in the form of ROS 1 or 2 → which of them are used, and for what.

    `listeners`: the topics that a node of the robot subscribes to; None: the link does not tell. Raises
    Unavailable for a topic that the settings name and the robot does not have.
    """
    return _Chooser(found, settings, listeners).topics()


class _Chooser:
    """The topics by their type, and one choice after the other."""

    def __init__(
        self, found: Iterable[tuple[str, str]], settings: RosSettings, listeners: Collection[str] | None
    ) -> None:
        self._settings, self._listeners = settings, listeners
        self._space = f"/{settings.namespace.strip('/')}/" if settings.namespace else "/"
        self._types: dict[str, list[str]] = {}  # topic → types
        self._ros1 = False
        for topic, kind in found:
            self._ros1 = self._ros1 or kind.count("/") == 1
            self._types.setdefault(topic, []).append(ros2_name(kind))
        self._chosen: dict[str, str] = {}
        self._notices: list[str] = []
        self._odometry = ""
        self._robots: tuple[str, ...] = ()
        self._robot: str | None = None  # of several; None: there is one
        if not settings.namespace:
            self._choose_robot()

    def _choose_robot(self) -> None:
        """Find out whether several robots are there; only the topics of one are used, and nothing is driven then."""
        speeds = [topic for topic in (*self._of("cmd_vel"), *(self._listeners or ())) if "vel" in topic]
        self._robots = robots_in(self._of("odometry"), [*self._of("scan"), *set(speeds)])
        if not self._robots:
            return
        named = self._settings.cmd_vel or self._settings.odometry
        robot = robot_of(named, "", self._robots) if named else self._robots[0]
        self._robot = self._robots[0] if robot is None else robot
        if not self._settings.cmd_vel:
            names = ", ".join(name or "one without a namespace" for name in self._robots[:6])
            first = next(name for name in self._robots if name)
            self._notices.append(
                f"There are several robots here ({names}), so nothing is driven. Choose one: set namespace in "
                f"*Connect*, or add ?namespace={first} to the address."
            )

    def _home(self) -> str:
        """The namespace of the robot's own topics, between slashes: that of its odometry, with its lasers in it."""
        if self._settings.namespace or self._robot is not None:
            return self._space if self._settings.namespace or not self._robot else f"/{self._robot}/"
        space = f"{self._odometry.rpartition('/')[0]}/"
        within = all(topic.startswith(space) for topic in self._chosen)
        return space if self._odometry and within else self._space

    def topics(self) -> RosTopics:
        scans = self._scans()
        self._odometry = self._one("odometry", OTHER_ODOMETRY)
        image = self._one("image", NOT_SEEN)
        cmd_vel, cmd_vel_type, guessed = self._commands()
        own_map, own_pose = self._one("map", NOT_SEEN), self._one("pose", OTHER_POSE)
        near_image = self._settings.camera_info or _nearest(image, self._of("camera_info")) if image else NOTHING
        return RosTopics(
            scans=scans,
            odometry=self._odometry,
            image=image,
            camera_info=self._named("camera_info", near_image) if near_image else "",
            sound=self._one("sound", SECOND_RATE),
            array=self._settings.array,
            battery=self._one("battery", SECOND_RATE),
            map=own_map,
            pose=own_pose,
            frames=self._frames("tf_static"),
            description=self._description(),
            moving_frames=self._frames("tf"),
            goal=self._goal(navigates=bool(own_map or own_pose)),
            cmd_vel=cmd_vel,
            cmd_vel_type=cmd_vel_type,
            guessed=guessed,
            simulated=CLOCK in self._types,
            lock="" if self._settings.lock == NOTHING else _absolute(self._settings.lock, self._space),
            base_frame=self._settings.base_frame,
            types=self._chosen,
            candidates={role: self._candidates(role) for role in TYPES},
            notices=tuple(self._notices),
        )

    def _of(self, role: str) -> list[str]:
        kinds = TYPES[role]
        return [
            topic
            for topic, types in self._types.items()
            if topic.startswith(self._space)
            and (self._robot is None or robot_of(topic, "", self._robots) == self._robot)
            and any(kind in kinds for kind in types)
            and (role != "description" or topic.endswith(DESCRIPTION))  # of all the texts that a robot sends
        ]

    def _candidates(self, role: str) -> tuple[tuple[str, str], ...]:
        """All topics that could have a role, each with its type; "" where the robot does not say it."""
        typed = [
            (topic, next(kind for kind in TYPES[role] if kind in self._types[topic])) for topic in self._of(role)
        ]
        silent = set(self._listeners or ()) - set(self._types) if role == "cmd_vel" else set[str]()
        return (*sorted(typed), *((topic, "") for topic in sorted(silent) if "vel" in topic))

    def _take(self, role: str, topic: str) -> str:
        self._chosen[topic] = next(kind for kind in TYPES[role] if kind in self._types[topic])
        return topic

    def _named(self, role: str, name: str) -> str:
        if name == NOTHING:
            return ""
        topic = _absolute(name, self._space)
        if not any(kind in TYPES[role] for kind in self._types.get(topic, [])):
            kinds = " or ".join(kind.rpartition("/")[2] for kind in TYPES[role])
            has = ", ".join(sorted(self._of(role))[:8]) or "none"
            raise Unavailable(f"The robot has no topic {topic} of type {kinds}; of this type it has {has}.")
        return self._take(role, topic)

    def _one(self, role: str, avoided: re.Pattern[str]) -> str:
        """The one topic that is best for a role, or ""."""
        name = getattr(self._settings, role)
        if name:
            return self._named(role, name)
        strict = role in ("map", "pose")
        fitting = [topic for topic in self._of(role) if not (strict and avoided.search(topic))]
        ranked = sorted(fitting, key=self._rank(role, avoided))
        if not ranked or (role == "image" and not is_seen(ranked[0])):
            return ""
        if len(ranked) > 1:
            self._notices.append(f"Of {', '.join(ranked[:6])} the robot's {role} is taken from {ranked[0]}.")
        return self._take(role, ranked[0])

    def _rank(self, role: str, avoided: re.Pattern[str]) -> Callable[[str], tuple[Any, ...]]:
        kinds = TYPES[role]

        def rank(topic: str) -> tuple[Any, ...]:
            kind = min(kinds.index(kind) for kind in self._types[topic] if kind in kinds)
            return bool(avoided.search(topic)), kind, topic.count("/"), len(topic), topic

        return rank

    def _scans(self) -> tuple[str, ...]:
        """Up to two lasers; what only repeats another one under a longer name is none of its own."""
        if self._settings.scan:
            return tuple(filter(None, (self._named("scan", name) for name in self._settings.scan)))
        lasers: list[str] = []
        for topic in sorted(self._of("scan"), key=self._rank("scan", SECOND_RATE)):
            again = any(topic.startswith(laser) for laser in lasers)
            if len(lasers) < MOST_SCANS and not again and not (lasers and SECOND_RATE.search(topic)):
                lasers.append(topic)
        if len(lasers) < len(self._of("scan")):
            self._notices.append(f"The robot's lasers are taken to be {' and '.join(lasers)}.")
        return tuple(self._take("scan", topic) for topic in lasers)

    def _commands(self) -> tuple[str, str, bool]:
        """Topic and type of the speeds; True: the type is guessed."""
        topic = self._command_topic()
        types = [kind for kind in TYPES["cmd_vel"] if kind in self._types.get(topic, [])]
        if self._settings.cmd_vel_type:
            return topic, TWIST_STAMPED if self._settings.cmd_vel_type == "TwistStamped" else TWIST, False
        if len(types) > 1:
            self._notices.append(f"{topic} is both Twist and TwistStamped; set cmd_vel_type to choose.")
        elif topic and not types:
            self._notices.append(f"The robot does not say what {topic} carries; it is sent as Twist.")
        return topic, types[0] if types else TWIST, bool(topic) and len(types) != 1

    def _command_topic(self) -> str:
        if self._settings.cmd_vel:
            return "" if self._settings.cmd_vel == NOTHING else _absolute(self._settings.cmd_vel, self._space)
        possible = [topic for topic in self._of("cmd_vel") if "cmd_vel" in topic or "cmd" in topic.rpartition("/")[2]]
        if self._listeners is not None:
            possible = [topic for topic in possible if topic in self._listeners]
        if self._robot is not None:
            return ""  # of which robot is not said
        if not possible:
            return f"{self._home()}cmd_vel"
        best = min(possible, key=lambda topic: (not topic.endswith("/cmd_vel"), topic.count("/"), len(topic), topic))
        if len(possible) > 1:
            self._notices.append(f"Speeds are sent to {best}; the robot also has {', '.join(sorted(possible)[:6])}.")
        return best

    def _goal(self, *, navigates: bool) -> str:
        """Choose the topic for goals.

        A robot with a map or a pose on one has the usual topic, also where the link hides it.
        """
        if self._settings.goal:
            return "" if self._settings.goal == NOTHING else _absolute(self._settings.goal, self._space)
        known = [topic for topic in self._of("goal") if topic.endswith(GOALS)]
        if known:
            return min(known, key=lambda topic: (topic.count("/"), topic))
        return f"{self._home()}{GOALS[1] if self._ros1 else GOALS[0]}" if navigates else ""

    def _description(self) -> str:
        if self._settings.description:
            return self._named("description", self._settings.description)
        beside = [DESCRIPTION] if STRING in self._types.get(DESCRIPTION, []) else []
        found = min(self._of("description"), key=lambda topic: (topic.count("/"), topic), default="")
        return self._take("description", found or beside[0]) if found or beside else ""

    def _frames(self, name: str) -> str:
        for topic in (f"{self._home()}{name}", f"{self._space}{name}", f"/{name}"):
            if TF in (types := self._types.get(topic, [])) or "tf/msg/tfMessage" in types:
                self._chosen[topic] = TF
                return topic
        return ""


def _nearest(image: str, infos: list[str]) -> str:
    parts = image.split("/")

    def rank(topic: str) -> tuple[int, int, str]:
        shared = 0
        for one, other in zip(parts, topic.split("/"), strict=False):
            if one != other:
                break
            shared += 1
        return -shared, len(topic), topic

    return min(infos, key=rank, default="")


def _absolute(name: str, space: str) -> str:
    return name if name.startswith("/") or not name else space + name


def _name(key: str, value: Any) -> str:
    if not isinstance(value, str) or (value and not NAME.fullmatch(value)):
        raise BadInput(f"{key} is the name of a topic or a frame, such as /front/scan.")
    return value


def _names(key: str, value: Any) -> tuple[str, ...]:
    names = value.split(",") if isinstance(value, str) else value
    if not isinstance(names, list | tuple) or not 1 <= len(names) <= MOST_SCANS:
        raise BadInput(f"{key} is the name of a topic, or a list of two.")
    return tuple(_name(key, name) for name in names)
