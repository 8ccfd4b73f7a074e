"""Findings on a ROS robot: for every role its topics, their messages, and the others that could have it."""

import threading
import time
from collections import deque
from typing import Any, get_args

from core.robots.device import CandidateTopic, Role, TopicRole, UsedTopic
from core.robots.ros.topics import MOST_SCANS, NOTHING, RosSettings, RosTopics
from core.robots.ros.typestore import TF

RATE_MESSAGES = 30  # messages of a topic, over which its rate is measured
MIN_RATE_MESSAGES = 3  # messages that tell a rate

NAMES: dict[Role, str] = {
    "odometry": "The odometry",
    "scan": "The laser",
    "image": "The camera",
    "camera_info": "The camera's own calibration",
    "sound": "The sound of the microphones",
    "cmd_vel": "The topic of speeds",
    "battery": "The battery",
    "map": "The robot's own map",
    "pose": "The robot's own pose",
    "frames": "The topic of mountings",
    "description": "The robot's own description",
}
MISSING: dict[Role, str] = {
    "odometry": "The robot has no odometry; its motion is estimated from the scans.",
    "scan": "The robot has no laser scan; it is neither located nor are obstacles seen.",
    "image": "The robot has no camera pictures; landmarks are corners only, and no person is seen.",
    "camera_info": "The camera is not calibrated by the robot; calibrate it.",
    "sound": "The robot has no microphones; only those of browsers are heard.",
    "cmd_vel": "The robot takes no speeds; it cannot be driven.",
    "battery": "The robot does not say how full its battery is.",
    "frames": "The robot has no /tf_static; where its sensors are mounted has to be entered.",
}


class Traffic:
    """Counts the messages of every topic, and remembers their frames. Filled by one thread, read by another."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._times: dict[str, deque[float]] = {}  # topic → when the last messages came [s]
        self._frames: dict[str, str] = {}

    def note(self, topic: str, content: Any) -> None:
        """A message that could be used."""
        with self._lock:
            self._times.setdefault(topic, deque(maxlen=RATE_MESSAGES)).append(time.monotonic())
        frame = getattr(content, "child_frame_id", "") or getattr(getattr(content, "header", None), "frame_id", "")
        self._frames[topic] = str(frame).strip("/")

    def used(self, topic: str, kind: str, *, guessed: bool = False) -> UsedTopic:
        """Return the type, frame, rate and age of the messages on a topic."""
        with self._lock:
            times = tuple(self._times.get(topic, ()))
        now = time.monotonic()
        spread = times[-1] - times[0] if len(times) >= MIN_RATE_MESSAGES else 0.0
        return UsedTopic(
            topic=topic,
            type=kind,
            frame=self._frames.get(topic, ""),
            rate_hz=round((len(times) - 1) / spread, 2) if spread > 0 else None,
            age_s=round(now - times[-1], 2) if times else None,
            guessed=guessed,
        )


def roles_of(topics: RosTopics, settings: RosSettings, traffic: Traffic) -> tuple[TopicRole, ...]:
    """Every role with the topics that have it, what comes on them, and all that could have it."""
    return tuple(_role(role, topics, settings, traffic) for role in get_args(Role))


def _role(role: Role, topics: RosTopics, settings: RosSettings, traffic: Traffic) -> TopicRole:
    types = {**topics.types, topics.cmd_vel: topics.cmd_vel_type}
    chosen = topics.scans if role == "scan" else (getattr(topics, role),)
    guessed = topics.guessed and role == "cmd_vel"
    used = tuple(traffic.used(topic, types.get(topic, ""), guessed=guessed) for topic in chosen if topic)
    found = [CandidateTopic(topic=topic, type=kind) for topic, kind in topics.candidates.get(role, ())]
    if role == "frames":
        found = [CandidateTopic(topic=one.topic, type=TF) for one in used]
    known = {one.topic for one in found}
    found += [CandidateTopic(topic=one.topic, type=one.type) for one in used if one.topic not in known]
    remark = ""
    if not used and (role != "camera_info" or topics.image):
        switched_off = getattr(settings, role, "") in (NOTHING, (NOTHING,))
        remark = f"{NAMES[role]} is not used, as it was chosen." if switched_off else MISSING.get(role, "")
    most = MOST_SCANS if role == "scan" else 1
    return TopicRole(role=role, used=used, candidates=tuple(found), most=most, remark=remark)
