"""A ROS robot that describes itself, on every link: its URDF, and after how long a silence its base stops."""

import functools
from collections.abc import Callable
from typing import Any

import pytest

from core.geometry import Pose
from core.robots.connect import live
from core.robots.device import Device
from core.robots.foxglove import open_device as open_foxglove
from core.robots.robot_file import RobotFile
from core.robots.rosbridge import open_device as open_rosbridge
from core.robots.zenoh_link import open_device as open_zenoh
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.ros_messages import URDF
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator

Settled = Callable[[Any, float | None], None]
PARAMETERS = ("ClientPublish", "ConnectionGraph", "Parameters")


def set_parameter(name: str) -> Settled:
    """Have an emulator's controller stop after so long a silence [s]; None: it has no such parameter."""

    def settle(emulator: Any, timeout: float | None) -> None:
        emulator.parameters = {"/camera.exposure": 3.0} | ({} if timeout is None else {name: timeout})

    return settle


def set_timeout(emulator: Any, timeout: float | None) -> None:
    emulator.timeout = timeout


LINKS: dict[str, tuple[Callable[[World], Any], Settled, Callable[[str], Device]]] = {
    "foxglove": (
        functools.partial(FoxgloveEmulator, capabilities=PARAMETERS),
        set_parameter("/base.cmd_vel_timeout"),
        open_foxglove,
    ),
    "rosbridge": (RosbridgeEmulator, set_parameter("/base_controller:cmd_vel_timeout"), open_rosbridge),
    "rosbridge JSON": (
        RosbridgeEmulator,
        set_parameter("/base_controller:cmd_vel_timeout"),
        lambda rest: open_rosbridge(f"{rest}?encoding=json"),
    ),
    "rosbridge ROS 1": (
        functools.partial(RosbridgeEmulator, ros1=True),
        set_parameter("/mobile/cmd_vel_timeout"),
        open_rosbridge,
    ),
    "zenoh rmw": (ZenohEmulator, set_timeout, open_zenoh),
    "zenoh bridge": (functools.partial(ZenohEmulator, bridge=True), set_timeout, open_zenoh),
}


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=[pytest.mark.campaign] if one == "zenoh bridge" else []) for one in LINKS]
)
def test_a_robot_s_description_mounts_its_sensors_and_its_parameter_says_when_it_stops(name: str) -> None:
    make, settle, open_device = LINKS[name]
    world = World()
    emulator = make(world)
    emulator.urdf = URDF
    emulator.maker.frames = functools.partial(emulator.maker.encode, "tf2_msgs/msg/TFMessage", transforms=[])
    settle(emulator, 0.3)
    emulator.start()
    world.start()
    device: Any = open_device(emulator.url.partition(":")[2])
    try:
        found = device.open()
        assert found.body is not None and len(found.body.shapes) == 2
        assert [line.partition(",")[0] for line in found.body.notices] == ["2 meshes of the robot's body"]
        assert (found.lasers[0].mounting, found.lasers[0].height) == (Pose(0.02, 0.0, 0.0), pytest.approx(0.18))
        assert found.cameras[0].mounting.translation == pytest.approx([0.08, 0.0, 0.16])
        assert found.base is not None and (found.base.failsafe, found.base.failsafe_words) == (0.3, "")
        described = {one.role: one.used for one in device.findings().roles}["description"]
        assert [one.topic for one in described] == ([] if "ROS 1" in name else ["/robot_description"])
    finally:
        device.close()
        emulator.stop()
        world.stop()


def test_a_bad_description_is_a_sentence_and_an_unknown_silence_is_said_or_taken_from_the_file() -> None:
    world = World()
    emulator = FoxgloveEmulator(world, capabilities=PARAMETERS)
    emulator.urdf = "<robot><link name='a'/><joint/></robot>"
    emulator.start()
    world.start()
    try:
        robot = live(emulator.url, RobotFile())
        assert "ask the robot's maker" in robot.profile.failsafe and robot.profile.shapes == ()
        notes = ""
        while "/robot_description" not in notes:
            notes += " ".join(robot.read().notes)
        robot.close()
        robot = live(emulator.url, RobotFile(failsafe=0.8))
        assert robot.profile.failsafe == "It stops by itself 0.8 s after the last command."
        robot.close()
    finally:
        emulator.stop()
        world.stop()


def test_a_description_that_is_a_parameter_counts_as_one_on_a_topic() -> None:
    world = World()
    emulator = FoxgloveEmulator(world, capabilities=PARAMETERS)
    emulator.parameters = {"/robot_description": URDF}
    emulator.start()
    world.start()
    device: Any = open_foxglove(emulator.url.partition(":")[2])
    try:
        body = device.open().body
        assert body is not None and len(body.shapes) == 2
    finally:
        device.close()
        emulator.stop()
        world.stop()
