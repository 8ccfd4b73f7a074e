"""The sketch of the how-to page, compiled for this computer and driven over a pseudo-terminal."""

import math
import os
import re
import shutil
import subprocess
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest

from core.gate import ZERO, Twist
from core.robots.serial_base import open_device
from core.sensors import Wheels
from tests.core.robots.links import frames, live

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "static/docs/how-to/serial-robot.md"
BOARD = ROOT / "tests/emulators/arduino_board.h"
WHEELS = """
static float speeds[2];
static unsigned long rolled_at = 0;
void motors(float l, float r) { speeds[0] = l; speeds[1] = r; }
void encoders() {
  unsigned long now = millis();
  left += speeds[0] * (now - rolled_at) / 1000; right += speeds[1] * (now - rolled_at) / 1000;
  rolled_at = now;
}
int main(int, char **arguments) {
  port = atoi(arguments[1]);
  setup();
  for (;;) { loop(); usleep(500); }
}
"""


def sketch() -> str:
    found = re.search(r"```cpp\n(.*?)```", PAGE.read_text(), re.S)
    assert found is not None
    return found[1]


def test_the_sketch_has_40_lines() -> None:
    assert len(sketch().rstrip().splitlines()) <= 40


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Path]:
    """The port on which the compiled sketch answers; its own `motors` and `encoders` are perfect wheels."""
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("there is no g++ to compile the sketch with")
    yours = re.compile(r"^void (?:motors|encoders)\(.*\) \{ /\* yours.*\n", re.M)
    code, count = yours.subn(lambda line: line[0].split("{")[0].rstrip() + ";\n", sketch())
    assert count == 2
    source, program = tmp_path / "sketch.cpp", tmp_path / "sketch"
    source.write_text(BOARD.read_text() + code + WHEELS)
    subprocess.run([compiler, "-O1", "-Wall", "-Werror", "-o", program, source], check=True)
    device, driver = os.openpty()
    tty.setraw(device)
    tty.setraw(driver)
    process = subprocess.Popen([program, str(device)], pass_fds=[device])
    yield Path(os.ttyname(driver))
    process.kill()
    process.wait()
    os.close(device)
    os.close(driver)


def last_wheels(read: list) -> Wheels:
    wheels = [frame.wheels for frame in read if frame.wheels is not None][-1]
    assert isinstance(wheels, Wheels)
    return wheels


def test_the_sketch_of_the_page_drives_and_stops_by_itself(board: Path) -> None:
    with live(open_device(f"//{board}")) as robot:
        assert robot.profile.name == "Rover"
        frames(robot, 0.2, ZERO)
        moving = last_wheels(frames(robot, 1.5, Twist(0.15, 0.6)))
        frames(robot, 1.0)  # nobody says anything
        stopped = last_wheels(frames(robot, 0.3))
    assert moving.speed == pytest.approx(0.15, abs=0.02) and moving.turn_rate == pytest.approx(0.6, abs=0.1)
    assert stopped.speed == 0 and stopped.turn_rate == 0
    assert stopped.odometry.heading == pytest.approx(0.6 * (1.5 + 0.5), abs=0.25)
    assert math.hypot(stopped.odometry.x, stopped.odometry.y) == pytest.approx(2 * 0.25 * math.sin(0.6), abs=0.06)
