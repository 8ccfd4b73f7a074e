"""Robots that are put together: files, joined devices, drivers of one's own."""

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.calibration.files.camera_files import ros_yaml
from core.errors import BadInput
from core.geometry import Pose
from core.optics import TABLE_3, CameraModel
from core.robots.connect import connect, parts_of, with_options
from core.robots.device import Base, Equipment
from core.robots.live import LiveRobot
from core.robots.robot_file import RobotFile, load_robot_file, profile_of
from core.sensors import Camera, Laser
from core.sensors.microphones import tetrahedron
from core.sentences import code_of
from tests.reference.pages import robot_file_page

DRIVER = """
import threading
import numpy as np
from core.robots.device import Base, Device, Equipment
from core.sensors import Laser, Scan


class Mine(Device):
    def __init__(self, arguments):
        self.arguments, self.over = arguments, threading.Event()

    def open(self):
        return Equipment(name=f"mine at {self.arguments}", base=Base(max_speed=0.4), lasers=(Laser(name="top"),))

    def run(self, readings):
        while not self.over.wait(0.01):
            readings.scan(Scan(stamp=readings.now(), ranges=np.ones(3), angle_min=0.0, angle_step=0.1))

    def close(self):
        self.over.set()
"""
WHOLE = Equipment(
    name="whole",
    base=Base(wheelbase=0.3, max_speed=0.5, cruise=0.2, failsafe=0.5),
    lasers=(Laser(name="front"), Laser(name="rear")),
    cameras=(Camera(),),
)


def written(folder: Path, text: str) -> Path:
    path = folder / "robot.toml"
    path.write_text(text)
    return path


def test_a_driver_of_ones_own_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "my_robot.py").write_text(DRIVER)
    robot = connect(f"py:{tmp_path}/my_robot.py:/dev/ttyUSB7")
    assert robot.profile.name == "mine at /dev/ttyUSB7" and robot.profile.max_speed == 0.4
    assert [laser.name for laser in robot.profile.lasers] == ["top"]
    robot.close()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (None, "There is no driver"),
        ("x = (", "cannot be used: SyntaxError"),
        ("import no_such_package", "cannot be used: ModuleNotFoundError"),
        ("class Other: ...", "declares 0 kinds of Device"),
        ("from core.robots.device import Device\nclass Half(Device): ...", "abstract methods? '?open"),
    ],
)
def test_a_driver_that_cannot_be_used_is_a_sentence(tmp_path: Path, text: str | None, sentence: str) -> None:
    if text is not None:
        (tmp_path / "broken_robot.py").write_text(text)
    with pytest.raises(BadInput, match=sentence):
        connect(f"py:{tmp_path}/broken_robot.py:")


def test_a_file_names_the_url_and_describes_the_robot(tmp_path: Path) -> None:
    (tmp_path / "my_robot.py").write_text(DRIVER)
    file = written(
        tmp_path,
        f"""
url = "py:{tmp_path}/my_robot.py:x"
name = "Marvin"
wheelbase = 0.23
cruise = 2.0
[lasers.top]
x = 0.1
heading_deg = 90
height = 0.3
""",
    )
    robot = connect(str(file))
    profile = robot.profile
    assert (profile.name, profile.wheelbase, profile.kind) == ("Marvin", 0.23, "LIVE")
    assert profile.cruise == profile.max_speed == 0.4  # never faster than the base can
    assert profile.laser is not None and profile.laser.height == 0.3
    assert profile.laser.mounting == Pose(0.1, 0.0, math.pi / 2)
    robot.close()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("wheelbase = -1", "robot.toml, wheelbase: expected `float` >= 0.01 m, got -1"),
        ("wheelbas = 1", "unknown field `wheelbas`; did you mean wheelbase"),
        ("wheelbase = 34", "expected `float` <= 10.0 m, got 34"),
        ("radius = 0.00009", "radius: expected `float` >= 0.01 m"),
        ("max_speed = 0.0001", "max_speed: expected `float` >= 0.01 m/s"),
        ("[lasers.front]\nheihgt = 1", r"lasers\.front: .*`heihgt`; did you mean height"),
        ("[cameras.c]\nx = 0\nz = -1", r"cameras\.c, z: expected `float` >= 0.0 m, got -1"),
        ("lasers = 3", "lasers: expected `object`, got `int`"),
        ('[lasers.front]\nx = "left"', r"robot.toml, lasers\.front, x: expected `float"),
        ("url = ", "not valid TOML"),
        ("url = " + "[" * 5000, "not valid TOML"),
        ("radius = 1" + "0" * 5000, "not valid TOML"),
        ("name = 'x'", "needs a line url"),
        (f"name = '{'x' * 101}'", "at most 100 letters"),
        ("radius = 0.2\nwheelbase = 2.3", "in metres"),
        ("[lasers.front]\nheading_deg = 180", r"lasers\.front: heading_deg would not count without x"),
        ("[cameras.c]\ny = 0.1\npitch_deg = 5", r"cameras\.c: y, pitch_deg would not count without x"),
        ("[microphones.m]\nlink = 'l'\nheading_deg = 45", "so heading_deg would not count"),
        ("[lasers.front]\nlink = 'l'\nx = 0.1", "so x would not count"),
    ],
)
def test_a_mistake_in_a_file_is_named(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        connect(str(written(tmp_path, text)))


def test_a_file_that_is_not_there_is_a_sentence() -> None:
    with pytest.raises(BadInput, match="cannot be read"):
        load_robot_file(Path("no/such/robot.toml"))


def test_what_the_robot_does_not_have_cannot_be_described() -> None:
    file = RobotFile(lasers={"left": next(iter(load_of("[lasers.left]\nx = 0").lasers.values()))})
    with pytest.raises(BadInput, match=r"the laser left, but .* no such one; there is front, rear"):
        profile_of((WHOLE,), file, "x:")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[lasers.front]\nx = 8", r"puts front 8 m from the middle of a robot of 0\.\d+ m radius; write its place"),
        ("[lasers.front]\nx = 0\ny = -9", "puts front 9 m"),
        ("[lasers.front]\nrange_min = 5\nrange_max = 4", "would measure from 5 to 4 m"),
    ],
)
def test_a_place_far_outside_the_robot_and_a_laser_without_reach_are_refused(text: str, sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        profile_of((WHOLE,), load_of(text), "x:")
    assert profile_of((WHOLE,), load_of("radius = 7\n[lasers.front]\nx = 8"), "x:").lasers[0].mounting.x == 8


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("wheelbase = 5.5", "wheels"),
        ("radius = 3\nwheelbase = 2", "much"),
        ("radius = 0.3\nwheelbase = 0.05", "wheels"),
        ("radius = 0.2\nmax_speed = 4.9", "much"),
        ("max_turn_rate = 19", "much"),
        ("failsafe = 50", "much"),
        ("cruise = 3", "cruise"),
        ("[lasers.front]\nx = 1.2", "outside"),
        ("[lasers.front]\nheight = 9", "height"),
        ("[lasers.front]\nheight = 0.0002", "height"),
        ("[lasers.front]\nx = 0.1\nheading_deg = 1.5708", "radians"),
        ("[lasers.front]\ntime_offset = -0.9", "much"),
        ("[cameras.camera]\nx = 0\npitch_deg = 180", "much"),
    ],
)
def test_what_is_improbable_is_a_notice_of_the_robot(text: str, code: str) -> None:
    notices = profile_of((WHOLE,), load_of(f"radius = 0.2\n{text}" if "radius" not in text else text), "x:").notices
    assert [code_of(sentence).code for sentence in notices] == [f"robot_file.{code}"]


def test_a_usual_robot_has_no_notice_of_its_file() -> None:
    text = "radius = 0.2\nmax_speed = 0.8\n[lasers.front]\nx = 0.1\nheading_deg = 1.5\nheight = 0.17\n"
    text += "[cameras.camera]\nx = 0.1\npitch_deg = 45\nyaw_deg = -90"
    assert profile_of((WHOLE,), load_of(text), "x:").notices == ()


@pytest.mark.parametrize("places", [2, 3, 4, 6])
def test_an_angle_in_radians_is_suspected_as_people_write_it(places: int) -> None:
    step = 15 if places == 2 else 5
    angles = {degrees: f"{math.radians(degrees):.{places}f}" for degrees in range(step, 361, step)}
    for degrees, angle in angles.items():
        if angle.endswith("0"):
            continue  # in the file it has fewer decimals
        file = load_of(f"radius = 0.2\n[lasers.front]\nx = 0.1\nheading_deg = {angle}")
        (notice,) = profile_of((WHOLE,), file, "x:").notices
        assert f"write {degrees}." in notice


def test_small_angles_that_were_measured_in_degrees_are_hardly_suspected() -> None:
    measured = np.round(np.random.default_rng(7).uniform(-6.3, 6.3, 400), 2).tolist()
    suspected = 0
    for angle in (*measured, 1.5, 2.5, 0.8, 3.1):
        file = load_of(f"radius = 0.2\n[lasers.front]\nx = 0.1\nheading_deg = {angle}")
        suspected += len(profile_of((WHOLE,), file, "x:").notices)
    assert suspected < 0.06 * len(measured)


def test_an_array_that_is_wider_than_its_robot_is_a_notice(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("positions_m = [[1.2, 0, 0], [0, 1.2, 0], [-1.2, 0, 0]]")
    whole = replace(WHOLE, microphones=(tetrahedron(),))
    file = load_of("radius = 0.2\n[microphones.tetrahedron]\nprofile = 'mine.toml'")
    (notice,) = profile_of((whole,), file, "x:", tmp_path).notices
    assert "2.4 m apart on a robot of 0.4 m" in notice


@pytest.mark.parametrize(
    ("change", "codes"),
    [
        ({}, []),
        ({"fy": 260.0}, ["focal_ratio"]),
        ({"fy": 1040.0}, ["focal_ratio"]),
        ({"cx": 40.0}, ["principal_point"]),
        ({"fx": 12000.0, "fy": 12000.0}, ["view"]),
        ({"fx": 86.0, "fy": 86.0}, ["view"]),
    ],
)
def test_a_calibration_that_hardly_any_camera_has_is_a_notice(
    tmp_path: Path, change: dict[str, float], codes: list[str]
) -> None:
    model = CameraModel(**{"width": 640, "height": 480, "fx": 520.0, "fy": 520.0, "cx": 322.0, "cy": 236.0} | change)
    (tmp_path / "camera.yaml").write_text(ros_yaml(model))
    file = load_of("radius = 0.2\n[cameras.camera]\ncalibration = 'camera.yaml'")
    notices = profile_of((WHOLE,), file, "x:", tmp_path).notices
    assert [code_of(sentence).code for sentence in notices] == [f"camera.{code}" for code in codes]


def load_of(text: str) -> RobotFile:
    import tomllib

    import msgspec

    return msgspec.convert(tomllib.loads(text), RobotFile)


def test_a_camera_looks_where_its_angles_say() -> None:
    file = load_of("[cameras.camera]\nx = 0.1\nz = 0.5\nyaw_deg = 90\npitch_deg = 30")
    camera = profile_of((WHOLE,), file, "x:").camera
    assert camera is not None and camera.model == TABLE_3
    axis = camera.mounting.rotation[:, 2]
    assert np.allclose(axis, [0.0, math.cos(math.radians(30)), -0.5])
    assert np.allclose(camera.mounting.translation, [0.1, 0.0, 0.5])


def test_a_joined_url_is_taken_apart_at_schemes_only() -> None:
    url = "serial:///dev/ttyUSB0?name=a+b+lds:///dev/ttyUSB1?model=LD06+camera://0"
    assert parts_of(url) == ["serial:///dev/ttyUSB0?name=a+b", "lds:///dev/ttyUSB1?model=LD06", "camera://0"]


def test_the_drivers_own_table_is_the_query_of_its_url() -> None:
    rest = with_options("//host:1?scan=/a", {"scan": "/b", "lock": "/stop", "scans": ["/x", "/y"], "tls": True})
    assert rest == "//host:1?scan=/a&lock=%2Fstop&scans=%2Fx%2C%2Fy&tls=1"


def test_a_whole_robot_cannot_be_joined_with_devices() -> None:
    with pytest.raises(BadInput, match="whole robot"):
        connect("sim:lab+py:x.py:")


def test_only_the_first_base_drives(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}_robot.py").write_text(DRIVER.replace("max_speed=0.4", f"max_speed=0.{len(name)}"))
    robot = connect(f"py:{tmp_path}/one_robot.py:+py:{tmp_path}/two_robot.py:")
    assert isinstance(robot, LiveRobot) and robot.profile.max_speed == 0.3
    assert [laser.name for laser in robot.profile.lasers] == ["top", "top-2"]
    scans: set[str] = set()
    end = time.monotonic() + 5
    while len(scans) < 2 and time.monotonic() < end:
        scan = robot.read().scan
        scans |= {scan.laser} if scan is not None else set()
    assert scans == {"top", "top-2"}
    robot.close()


def test_every_entry_of_the_file_declares_what_it_means_and_every_number_its_unit() -> None:
    rows = [line.split("|")[1:-1] for line in robot_file_page().splitlines() if line.startswith("| `")]
    assert len(rows) >= 29
    for _, _, values, unit, meaning in ([cell.strip() for cell in row] for row in rows):
        assert meaning and bool(unit) is (values != "text")
