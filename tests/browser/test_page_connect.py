"""The Connect page against an emulated ROS robot: topics are chosen, looked at again, and written to a robot file."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from core.gate import ZERO, Twist
from core.robots.connect import connect
from core.robots.robot_file import load_robot_file
from tests.browser.visit import PHONE, Visit
from tests.console.live import Live
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.ros_messages import URDF
from tests.emulators.world import World

Open = Callable[..., Visit]


class Near:
    def __init__(self, live: Live, home: Path, emulator: FoxgloveEmulator) -> None:
        root = f"http://127.0.0.1:{live.port}/connect#t="
        self.driving, self.watching, self.home = root + live.operator, root + live.viewer, home
        self.emulator = emulator


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Near]:
    world, home = World(), tmp_path_factory.mktemp("connect")
    emulator = FoxgloveEmulator(world, capabilities=("ClientPublish", "ConnectionGraph", "Parameters"))
    emulator.parameters, emulator.urdf = {"/base.cmd_vel_timeout": 0.4}, URDF
    emulator.start()
    world.start()
    with Live(home, url=emulator.url) as live:
        yield Near(live, home, emulator)
    world.stop()
    emulator.stop()


@pytest.mark.campaign
def test_topics_are_chosen_heard_and_written_and_nothing_is_overwritten_unasked(visit: Open, console: Near) -> None:
    here = visit()
    page = here.page
    battery = page.get_by_label("Battery")
    expect(battery).to_have_value("/battery_state")
    expect(here.find("connect-sensors")).to_contain_text("mounting from /tf_static")
    expect(here.find("connect-timing")).to_contain_text("turn the robot on the spot")
    expect(here.find("connect-robot")).to_contain_text("It stops by itself 0.4 s after the last command.")
    expect(page.get_by_label("Its own description")).to_have_value("/robot_description")
    expect(here.find("connect-parts")).to_contain_text("2 meshes of the robot's body")
    expect(here.find("connect-parts")).to_contain_text("LaserScan · frame laser")
    expect(here.find("connect-parts")).to_contain_text("Hz")
    expect(here.find("connect-timing")).to_contain_text("arrives; 10 Hz expected")

    battery.select_option("not used")
    expect(here.button("Write robot file")).to_be_disabled()
    here.button("Look again").click()
    expect(here.find("connect-parts")).to_contain_text("The battery is not used")
    page.get_by_label("Laser: x in m").fill("0.1")
    page.get_by_label("Body: Radius in m").fill("0,2")
    page.get_by_label("Name of the robot").fill("Marvin")
    here.button("Write robot file").click()
    expect(here.find(".connect-command")).to_contain_text("beckon run --robot")
    file = load_robot_file(console.home / "robots" / "marvin.toml")
    assert file.robot["battery"] == "none" and file.robot["scan"] == "/scan"
    assert (file.lasers["laser"].x, file.radius, file.wheelbase) == (0.1, 0.2, None)

    page.get_by_label("Body: Radius in m").fill("0.3")
    here.button("Write robot file").click()
    expect(page.get_by_text("There is a marvin.toml already. Replace it?")).to_be_visible()
    here.button("Keep it").click()
    assert load_robot_file(console.home / "robots" / "marvin.toml") == file
    here.button("Write robot file").click()
    here.button("Replace it").click()
    here.until(lambda: load_robot_file(console.home / "robots" / "marvin.toml").radius == 0.3, "it is replaced")

    again = connect(str(console.home / "robots" / "marvin.toml"))  # a second start
    assert (again.profile.name, again.profile.radius, again.profile.laser.mounting.x) == ("Marvin", 0.3, 0.1)  # type: ignore[union-attr]
    again.drive(ZERO)
    before = len(console.emulator.received)
    here.until(lambda: again.drive(Twist(0.02, 0.0)) or len(console.emulator.received) > before, "it drives")
    again.close()


def test_why_a_recording_is_not_opened_beside_a_real_robot_stays_to_be_read(visit: Open, console: Near) -> None:
    here = visit()
    expect(here.page.get_by_label("Battery")).to_be_visible()
    here.page.get_by_label("URL of a robot").fill("log:walk.mcap")
    here.button("Open").click()
    expect(here.find(".connect-status")).to_contain_text("beckon run --port 0 --robot log:walk.mcap")
    here.page.wait_for_timeout(2500)  # what the console is connected to is read every 2 s
    expect(here.find(".connect-status")).to_contain_text("drives a real robot")
    here.complaints[:] = [each for each in here.complaints if "409" not in each]  # the browser notes the refusal


def test_who_watches_sees_all_and_changes_nothing_on_a_phone_too(visit: Open, console: Near) -> None:
    here = visit(size=PHONE, theme="light", watching=True)
    expect(here.page.get_by_label("Odometry")).to_be_disabled()
    expect(here.button("Write robot file")).to_be_disabled()
    expect(here.button("Look")).to_be_disabled()
    width = "document.querySelector('main').scrollWidth <= document.querySelector('main').clientWidth"
    assert here.page.evaluate(width)
