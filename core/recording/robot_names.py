"""Names of robots in topics and frames: what belongs to one robot where several are on one network or in one file."""

import re
from collections import defaultdict
from collections.abc import Iterable
from itertools import combinations

BASES = ("base_footprint", "base_link", "base", "base_frame", "robot")
ODOMETRIES = ("odom", "odometry", "odom_combined", "wheel_odom")
OTHER_ODOMETRY = re.compile(r"visual|vo(?![a-z])|rf2o|icp|gps|imu|global|ground_truth|rtabmap|laser")
"""Topics with a pose that is not that of the wheels."""
NOT_SEEN = re.compile(
    r"depth|disparity|infra|(?<![a-z])ir\d?(?![a-z])|mask|debug|thermal|costmap|confidence|rect|overlay"
)
"""Topics whose pictures, or maps, are not what a camera sees as it is; *rect* is only the second choice."""


def robots_in(odometry: Iterable[str], others: Iterable[str], frames: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the names of the robots that topics of `odometry`, of lasers and speeds, or `frames` belong to.

    () where it is one. Two namespaces are two robots where both have the same topic of odometry or the same frame of
    a robot, or two other topics alike. Sensors and sources of speeds of one robot have namespaces, too (/front/scan
    and /rear/scan, /joy/cmd_vel and /nav/cmd_vel), and what a controller has once more stands beside what has none.
    """
    leaves: dict[str, dict[str, float]] = defaultdict(dict)  # namespace → leaf → what it counts
    for weight, topics in ((2.0, odometry), (1.0, others)):
        for topic in topics:
            space, _, leaf = topic.strip("/").rpartition("/")
            leaves[space][leaf] = weight
    for frame in frames:
        if known := known_frame(frame, (*BASES, *ODOMETRIES)):
            leaves[frame.strip("/")[: -len(known)].strip("/_")][f"frame {known}"] = 2.0
    found: set[str] = set()
    for one, other in combinations(leaves, 2):
        alike = sum(weight for leaf, weight in leaves[one].items() if leaf in leaves[other])
        if alike >= (2.0 if one and other else 4.0):
            found |= {one, other}
    return tuple(sorted(found))


def is_seen(topic: str) -> bool:
    """Return whether the pictures of a topic are what a camera sees, perhaps rectified."""
    return NOT_SEEN.search(topic.replace("rect", "")) is None


def robot_of(topic: str, frame: str, robots: Iterable[str]) -> str | None:
    """Return which of the robots a topic or its frame belongs to; None: to none of them by its name."""
    topic, frame = topic.strip("/"), frame.strip("/")
    fits = [
        robot
        for robot in robots
        if robot and (topic.startswith(f"{robot}/") or frame.startswith((f"{robot}/", f"{robot}_")))
    ]
    return max(fits, key=len, default="" if "" in robots else None)


def known_frame(frame: str, names: tuple[str, ...]) -> str:
    """Return which of `names` a frame is, perhaps after the robot's name (robot1/odom, robot1_odom), or ""."""
    last = frame.strip("/").rpartition("/")[2]
    fits = [name for name in names if last == name or last.endswith(f"_{name}")]
    return max(fits, key=len, default="")
