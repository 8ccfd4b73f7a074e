"""From a URL to a robot, or to a sentence."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from core.errors import BadInput
from core.robots.connect import SCHEMES, connect, excerpt, split
from core.simulation.settings import SimulationSettings


def test_the_simulated_robot_is_opened_with_its_settings() -> None:
    settings = SimpleNamespace(simulation=SimulationSettings(max_speed=0.2, camera=False))
    robot = connect("sim:lab", seed=3, settings=settings)
    assert robot.profile.max_speed == 0.2
    assert robot.profile.url == "sim:lab"
    robot.close()


def test_without_settings_it_has_its_defaults() -> None:
    assert connect("sim:lab").profile.max_speed == 0.3


@pytest.mark.parametrize("url", ["", "lab", "sim", "srv9://x", "SIM:lab", ":", "file:///etc/passwd"])
def test_an_unknown_kind_is_refused_with_the_known_ones(url: str) -> None:
    with pytest.raises(BadInput, match=r"known are sim:…, .*log:…"):
        connect(url)


@pytest.mark.parametrize("url", ["sim:nowhere", "log:/no/such/file.mcap", "log:"])
def test_what_cannot_be_opened_is_told_in_a_sentence(url: str) -> None:
    with pytest.raises(BadInput) as told:
        connect(url)
    assert str(told.value).endswith((".", "?"))


def test_a_driver_is_given_no_more_than_its_section() -> None:
    whole = SimpleNamespace(simulation=1, limits=2)
    assert vars(excerpt("sim:lab", whole)) == {"simulation": 1}
    assert excerpt("log:x", whole) is whole, "a recording is computed again with all of them"
    assert split("log:C:/x") == ("log", "C:/x")
    assert next(iter(SCHEMES)) == "sim", "the simulator is offered first"


def test_a_driver_beside_its_robot_file_is_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A service starts in /, an operator anywhere."""
    (tmp_path / "it.py").write_text(
        "from core.robots.driver import Base, Device, Equipment\n"
        "class It(Device):\n"
        "    def __init__(self, arguments=''): self.given = arguments\n"
        "    def open(self): return Equipment(name=self.given, base=Base(wheelbase=0.2, max_speed=0.3))\n"
        "    def run(self, readings): pass\n"
        "    def drive(self, twist): pass\n"
        "    def close(self): pass\n"
    )
    file = tmp_path / "robot.toml"
    file.write_text('url = "py:it.py:/dev//ttyUSB0"\n')
    monkeypatch.chdir("/")
    robot = connect(str(file))
    assert robot.profile.url == f"py:{tmp_path}/it.py:/dev//ttyUSB0" and robot.profile.name == "/dev//ttyUSB0"
    robot.close()


def test_a_robot_file_of_a_simulator_says_how_that_is_opened(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text('url = "sim:lab"\n')
    with pytest.raises(BadInput, match="--robot sim:lab"):
        connect(str(file))
