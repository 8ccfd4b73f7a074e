"""Names of robots in topics and frames: what belongs to one robot where several are on one network or in one file."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable

BASES = ("base_footprint", "base_link", "base", "base_frame", "robot")
ODOMETRIES = ("odom", "odometry", "odom_combined", "wheel_odom")
OTHER_ODOMETRY = re.compile(r"visual|vo(?![a-z])|rf2o|icp|gps|imu|global|ground_truth|rtabmap|laser")
"""Topics with a pose that is not that of the wheels."""


def robots_in(topics: Iterable[str], frames: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the names of the robots that have `topics` of odometry or speeds, or `frames`; () where it is one.

    Two namespaces are two robots where the same topic, or the same frame of a robot, stands in both; sensors of one
    robot that have namespaces of their own (/front/scan, /rear/scan) have no odometry and no speeds in them.
    """
    spaces: dict[str, set[str]] = defaultdict(set)
    for topic in topics:
        space, _, leaf = topic.strip("/").rpartition("/")
        spaces[leaf].add(space)
    for frame in frames:
        if known := known_frame(frame, (*BASES, *ODOMETRIES)):
            spaces[f"frame {known}"].add(frame.strip("/")[: -len(known)].strip("/_"))
    found = {space for named in spaces.values() if len(named) > 1 for space in named}
    return tuple(sorted(found)) if len(found) > 1 else ()


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
