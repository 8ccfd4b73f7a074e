"""The how-to pages about robots: each of their commands, in its order, on emulated robots instead of real ones."""

import shlex
from pathlib import Path

import pytest

from tests.emulators.robot_process import robot_process
from tests.stories.test_own_driver import ROOT, console, drive, fences_of, run

Parts = dict[str, str]  # a part of a URL on the page → the emulator that takes its place

PAGES: dict[str, Parts] = {
    "connect-a-ros-robot.md": {"foxglove://robot:8765": "foxglove"},
    "serial-robot.md": {"serial:///dev/ttyUSB0": "serial"},
    "hokuyo-and-srv1.md": {
        "serial:///dev/ttyUSB0": "serial",
        "scip:///dev/ttyACM0": "scip",
        "srv1://192.168.0.15:10001": "srv1",
        "lds:///dev/ttyUSB0?model=rplidar-a1": "lds",
        "camera://0": "camera",
        "audio://ReSpeaker": "audio",
    },
}
FILE = "robot.toml"  # whose topics the emulated robot does not have


@pytest.mark.campaign
@pytest.mark.parametrize("page", PAGES)
def test_every_command_of_a_page_works_in_its_order(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (ROOT / "static/docs/how-to" / page).read_text()
    lines = [line.strip() for fence in fences_of(text, "sh") for line in fence.splitlines()]
    done = 0
    for words in map(shlex.split, lines):
        assert words[0] == "beckon"
        if FILE in words:
            continue
        url = next(word for word in words if "://" in word)
        kinds = [PAGES[page][part] for part in url.split("+")]
        with robot_process(*kinds) as robot:
            for name, value in robot.environment.items():
                monkeypatch.setenv(name, value)
            here = ["console", *(robot.url if word == url else word for word in words[1:])]
            if words[1] == "run":
                with console(tmp_path, here) as client:
                    drive(client, warned=True)  # where the sensors sit is not entered, and they may say so
            else:
                assert run(tmp_path, here, answer="y\n").splitlines()[-1].startswith("All ")
        done += 1
    assert done >= 1
