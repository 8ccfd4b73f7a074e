"""The camera's mount read from files: static transform commands, URDF joints and 4x4 matrices as JSON."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np
import scipy

from core.calibration.files.camera_files import read_json
from core.calibration.files.mount_files import BACK, FORWARD, matrix, rigid
from core.calibration.files.scan_files import number_in
from core.errors import BadInput
from core.geometry import Transform

PUBLISHER = "static_transform_publisher"
LASERS, CAMERAS = ("laser", "lidar", "scan"), ("cam", "optical")  # parts of the frames' names
PAIRS = ((FORWARD, BACK), ("laser_from_camera", "camera_from_laser"))
MIN_DOUBTED_COSINE = 0.7  # of the angle between two axes, from which on they count as alike
LOOKS_UP = (
    "By this mount the camera looks up or down: it may be that of the camera's body, not of its optical frame "
    "(z ahead, x to the right)."
)
ON_ITS_SIDE = (
    "By this mount the camera is turned on its side: it may be the one from camera to laser, written as the other "
    "way round, or a transposed matrix."
)
AGREEMENT_TOLERANCE = 1e-6  # [rad, m] within which both directions of one file have to agree


def holds_mount(text: str) -> bool:
    """Return whether a file holds a mount, rather than a camera alone. Raises BadInput for JSON that is none."""
    if text.lstrip()[:1] != "{":
        return text.lstrip()[:1] == "<" or PUBLISHER in text
    document = read_json(text)
    names = {name for pair in PAIRS for name in pair} | {"rotation", "extrinsics"}
    return not names.isdisjoint(document)


def parse_mount(text: str) -> Transform:
    """The text of a mount's file in any of the forms → laser_from_camera. Raises BadInput."""
    begin = text.lstrip()[:1]
    if begin == "{":
        return mount_from_json(read_json(text))
    return mount_from_urdf(text) if begin == "<" else mount_from_command(text)


def mount_doubts(laser_from_camera: Transform) -> list[str]:
    """List what speaks against a mount: a camera beside a laser looks about level, and is seldom on its side."""
    if abs(laser_from_camera.rotation[2, 2]) > MIN_DOUBTED_COSINE:
        return [LOOKS_UP]
    return [ON_ITS_SIDE] if abs(laser_from_camera.rotation[2, 1]) < MIN_DOUBTED_COSINE else []


def mount_from_json(document: dict[str, Any]) -> Transform:
    """Our own file, its mount alone, 4x4 matrices in one or both directions, or what `calibrate laser --json` prints.

    Raises BadInput.
    """
    inner = document.get("extrinsics")
    entry: dict[str, Any] = inner if isinstance(inner, dict) else document
    for forward, back in PAIRS:
        ways = [rigid(entry[forward])] if forward in entry else []
        ways += [rigid(entry[back]).inverse()] if back in entry else []
        if len(ways) == 2 and not np.allclose(matrix(ways[0]), matrix(ways[1]), atol=AGREEMENT_TOLERANCE):
            raise BadInput(f"'{forward}' and '{back}' contradict each other: one has to be the inverse of the other.")
        if ways:
            return ways[0]
    if "rotation" in entry and "translation_m" in entry:
        return _assembled(entry["rotation"], entry["translation_m"])
    raise BadInput("It holds no mount: expected a 4x4 matrix under 'laser_from_camera' or 'camera_from_laser'.")


def mount_from_urdf(text: str) -> Transform:
    """A fixed URDF joint between laser and camera, alone or in a whole robot. Raises BadInput."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise BadInput("A URDF with its own entities is not read.")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as wrong:
        raise BadInput(f"It is not valid XML ({wrong}).") from None
    joints = [each for each in root.iter("joint") if _link(each, "parent") and _link(each, "child")]
    fitting = [each for each in joints if _between(_link(each, "parent"), _link(each, "child"))]
    if len(joints) != 1 and len(fitting) != 1:
        raise BadInput(f"{len(fitting)} of its {len(joints)} joints join laser and camera; exactly one has to.")
    joint = fitting[0] if fitting else joints[0]
    if joint.get("type") != "fixed":
        raise BadInput("The joint between laser and camera has to be fixed.")
    origin = joint.find("origin")
    given = {} if origin is None else origin.attrib
    shift, turn = (_numbers(given.get("xyz", "0 0 0").split(), 3), _numbers(given.get("rpy", "0 0 0").split(), 3))
    return _directed(_placed(shift, _turned(*turn)), _link(joint, "parent"), _link(joint, "child"))


def mount_from_command(text: str) -> Transform:
    """A static_transform_publisher command of ROS 2 or ROS 1, with named or positional arguments. Raises BadInput."""
    try:
        words = shlex.split(text.replace("\\\n", " "), comments=True)
    except ValueError as wrong:
        raise BadInput(f"It is not a command line ({wrong}).") from None
    starts = [number for number, word in enumerate(words) if word.endswith(PUBLISHER)]
    if len(starts) != 1:
        raise BadInput(f"It holds no mount: expected one {PUBLISHER} command, a URDF joint or JSON.")
    given = words[starts[0] + 1 :]
    return _named(given) if any(word.startswith("--") for word in given) else _positional(given)


def _named(given: Sequence[str]) -> Transform:
    """--x 0.1 or --x=0.1; what is not given is 0."""
    words = [part for word in given for part in (word.split("=", 1) if word.startswith("--") else [word])]
    names, values = words[::2], words[1::2]
    if len(names) != len(values) or not all(name.startswith("--") for name in names):
        raise BadInput("Every argument of the command needs a name, as in --x 0.1, and a value.")
    arguments = dict(zip(names, values, strict=True))
    parent, child = arguments.pop("--frame-id", ""), arguments.pop("--child-frame-id", "")
    numbers = dict(zip(arguments, _numbers(list(arguments.values()), len(arguments)), strict=True))
    shift = [numbers.pop(name, 0.0) for name in ("--x", "--y", "--z")]
    if any(name in numbers for name in ("--qx", "--qy", "--qz", "--qw")):
        rest = (("--qx", 0.0), ("--qy", 0.0), ("--qz", 0.0), ("--qw", 1.0))
        turn = _quaternion([numbers.pop(name, default) for name, default in rest])
    else:
        turn = _turned(*(numbers.pop(name, 0.0) for name in ("--roll", "--pitch", "--yaw")))
    if numbers:
        raise BadInput(f"The argument {next(iter(numbers))[:30]} is not read in this place.")
    return _directed(_placed(shift, turn), parent, child)


def _positional(given: Sequence[str]) -> Transform:
    """x y z yaw pitch roll, or x y z qx qy qz qw; then parent and child, and in ROS 1 the period [ms]."""
    count = next((number for number, word in enumerate(given) if number_in(word) is None), 0)
    after = given[count + 2 :]
    if count not in (6, 7) or len(given) < count + 2 or len(after) > 1 or None in map(number_in, after):
        raise BadInput("Expected x y z yaw pitch roll (or x y z qx qy qz qw), then the frames of laser and camera.")
    numbers = _numbers(given[:count], count)
    turn = _quaternion(numbers[3:]) if count == 7 else _turned(*reversed(numbers[3:]))
    return _directed(_placed(numbers[:3], turn), given[count], given[count + 1])


def _directed(parent_from_child: Transform, parent: str, child: str) -> Transform:
    """The pose of the child in its parent → laser_from_camera, directed by the names of the frames."""
    way = _between(parent, child)
    if not way:
        raise BadInput(
            f"It places '{child[:40]}' in '{parent[:40]}'. The mount is between laser and camera: "
            "one frame's name has to contain laser, lidar or scan, the other's cam or optical."
        )
    camera = child if way > 0 else parent
    if camera.endswith("_link"):
        raise BadInput(f"'{camera[:40]}' is the camera's body; the mount is that of its optical frame.")
    return parent_from_child if way > 0 else parent_from_child.inverse()


def _between(parent: str, child: str) -> int:
    """1: the camera in the laser's frame; -1: the laser in the camera's; 0: neither."""
    kinds = [
        "laser"
        if any(part in name.lower() for part in LASERS)
        else "camera"
        if any(part in name.lower() for part in CAMERAS)
        else ""
        for name in (parent, child)
    ]
    return {("laser", "camera"): 1, ("camera", "laser"): -1}.get((kinds[0], kinds[1]), 0)


def _link(joint: ElementTree.Element, which: str) -> str:
    found = joint.find(which)
    return "" if found is None else found.get("link", "")


def _turned(roll: float, pitch: float, yaw: float) -> scipy.spatial.transform.Rotation:
    """About fixed axes: first roll about x, then pitch about y, then yaw about z [rad]. Raises BadInput."""
    largest = max((roll, pitch, yaw), key=abs)
    if abs(largest) > np.pi * 2:
        raise BadInput(f"An angle of {largest:g} is more than a full turn in radians: it is degrees. Write radians.")
    return scipy.spatial.transform.Rotation.from_euler("xyz", [roll, pitch, yaw])


def _quaternion(numbers: Sequence[float]) -> scipy.spatial.transform.Rotation:
    if abs(float(np.linalg.norm(numbers)) - 1) > 1e-3:
        raise BadInput("The mount's quaternion has to be of length 1.")
    return scipy.spatial.transform.Rotation.from_quat(numbers)


def _placed(shift: Sequence[float], turn: scipy.spatial.transform.Rotation) -> Transform:
    """The transform. Raises BadInput where it is no mount's."""
    return rigid(matrix(Transform(rotation=turn.as_matrix(), translation=np.array(shift))))


def _assembled(rotation: Any, translation: Any) -> Transform:
    try:
        whole = np.eye(4)
        whole[:3, :3], whole[:3, 3] = np.array(rotation, dtype=float), np.array(translation, dtype=float)
    except (ValueError, TypeError):
        raise BadInput("The mount's rotation has to be 3x3 and its translation 3 numbers.") from None
    return rigid(whole.tolist())


def _numbers(words: Sequence[str], count: int) -> list[float]:
    numbers = [number for word in words if (number := number_in(word)) is not None and np.isfinite(number)]
    if not len(numbers) == len(words) == count:
        raise BadInput(f"Expected {count} finite numbers, not '{' '.join(words)[:60]}'.")
    return numbers
