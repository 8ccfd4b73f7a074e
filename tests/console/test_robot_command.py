"""`beckon robots` and `beckon robot`: the table, the checks, a driver to begin with."""

import io
import json
import os
import re
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from console.__main__ import main
from console.cli.doctor import missing_packages
from core.install import install_extra, requirements
from core.robots.connect import SCHEMES, Scheme
from core.robots.driver_template import DRIVER, sources
from tests.emulators.toy_robot import ToyRobot

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("SENSOR_START_S", "MIN_MEASURING_S"):
        monkeypatch.setattr(f"core.robots.conformance.{name}", 1.0)
    for name in ("TURN_RAD", "AHEAD_M", "AFTER_S"):
        monkeypatch.setattr(f"core.robots.conformance.{name}", 0.01)
    monkeypatch.setattr("core.robots.conformance.FRAME_SHARE", 0.2)  # of a busy computer


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rows(capsys: pytest.CaptureFixture[str]) -> dict[str, dict[str, object]]:
    assert main(["robots", "--json"]) == 0
    return {row["scheme"]: row for row in json.loads(capsys.readouterr().out)["schemes"]}


def test_every_scheme_is_listed_with_what_it_can(capsys: pytest.CaptureFixture[str]) -> None:
    found = rows(capsys)
    assert set(found) >= {*SCHEMES, "py"}
    for name, scheme in SCHEMES.items():
        assert (found[name]["example"], found[name]["has"]) == (scheme.example, scheme.has)
    assert main(["robots"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[:3] == ["sim:lab", "simulated", "robot"]


def test_a_missing_extra_is_named_with_the_command_that_installs_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(SCHEMES, "wheels", Scheme("none", "wheels://", "robot", "drives", extra="vosk"))
    monkeypatch.setattr("console.cli.robots.missing_packages", lambda extra: [f"{extra}-package"])
    row = rows(capsys)["wheels"]
    assert (row["extra"], row["installed"], row["missing"]) == ("vosk", False, ["vosk-package"])
    assert main(["robots"]) == 0
    assert install_extra("vosk") in capsys.readouterr().out


def test_an_extra_is_installed_when_all_its_packages_are() -> None:
    assert any(line.startswith("pytest>=") for line in requirements("test"))
    assert not any(line.startswith("pytest>=") for line in requirements())
    assert "pytest" not in missing_packages("test")
    assert missing_packages("no-such-extra") == []


def test_a_missing_package_of_an_extra_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = ["numpy>=1.26", 'no-such-package>=1; extra == "odd"', 'numpy; extra == "odd"']
    monkeypatch.setattr("core.install.requires", lambda _: lines)
    assert requirements() == lines[:1]
    assert missing_packages("odd") == ["no-such-package"]


def test_what_packages_bring_is_listed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint(name="rover", value="rover.driver:open_device", group="beckon.robots")
    monkeypatch.setattr("console.cli.robots.brought", lambda: {"rover": point})
    assert rows(capsys)["rover"]["package"] == "rover.driver:open_device"


def test_a_new_driver_and_its_test_work_at_once(folder: Path) -> None:
    assert main(["robot", "new", "my_robot"]) == 0
    assert len((folder / "my_robot.py").read_text().splitlines()) <= 40
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_my_robot.py"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout[-2000:]


def test_a_new_driver_is_written_as_the_formatter_would(folder: Path) -> None:
    assert DRIVER.count("TODO") >= 5
    for name, text in sources("my_robot").items():
        (folder / name).write_text(text)
    config = ["--config", str(REPOSITORY / "pyproject.toml")]
    for tool in (["check", "--ignore", "D,FIX"], ["format", "--check"]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *tool, *config, "."],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("My-Robot", "small letters"),
        ("../up", "small letters"),
        ("json", "another Python module"),
        ("__main__", "small letters"),
        ("there", "there already"),
    ],
)
def test_a_driver_that_cannot_be_written_is_a_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str], name: str, sentence: str
) -> None:
    (folder / "test_there.py").write_text("mine")
    assert main(["robot", "new", name]) == 1
    assert sentence in capsys.readouterr().err
    assert [path.name for path in folder.iterdir()] == ["test_there.py"]


def test_out_and_json_say_where_the_files_are(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "new", "rover", "--out", "drivers", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert Path(answer["files"]["driver"]).read_text() == sources("rover")["rover.py"]
    assert Path(answer["files"]["test"]).exists() and answer["url"] == "py:drivers/rover.py:"


@pytest.mark.usefixtures("quick")
def test_a_check_prints_a_table_and_its_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "new", "my_robot"]) == 0
    (folder / "robot.toml").write_text('url = "py:my_robot.py:"\nname = "Marvin"\n')
    capsys.readouterr()
    assert main(["robot", "check", "robot.toml", "--json", "--drive", "--yes"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["passed"] and {"connect", "frames", "laser rate", "stop", "silence", "close"} <= {
        check["name"] for check in answer["checks"] if check["passed"] and check["unit"]
    }
    assert main(["robot", "check", "py:my_robot.py:"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:2] == ["connect", "passed"]
    left_out = sum("not checked" in line for line in lines)
    assert left_out >= 4 and lines[-1] == f"All 6 checks passed. {left_out} were not made."
    assert any(line.startswith("drive ") and "--drive" in line for line in lines)


@pytest.mark.usefixtures("quick")
def test_what_failed_is_exit_code_1_and_says_what_to_do(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = sources("slow_robot")["slow_robot.py"].replace("rate=10.0", "rate=40.0")
    (folder / "slow_robot.py").write_text(source)
    assert main(["robot", "check", "py:slow_robot.py:"]) == 1
    printed = capsys.readouterr().out
    assert re.search(r"laser rate +FAILED", printed) and "under [lasers.laser] of robot.toml" in printed
    assert printed.splitlines()[-1] == "1 of 6 checks failed."


def test_a_robot_that_is_not_there_is_a_failed_check(capsys: pytest.CaptureFixture[str]) -> None:
    robot = ToyRobot()
    robot.start()
    robot.stop()
    assert main(["robot", "check", robot.url, "--json"]) == 1
    (check,) = json.loads(capsys.readouterr().out)["checks"]
    assert check["name"] == "connect" and "cannot be reached" in check["advice"]


@pytest.mark.parametrize("answer", ["", "n\n", "maybe\n"])
def test_without_a_yes_nothing_is_moved(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, answer: str
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(answer))
    robot = ToyRobot()
    robot.start()
    assert main(["robot", "check", robot.url, "--drive"]) == 1
    error = capsys.readouterr().err
    assert "2 cm/s" in error and "Nothing was moved" in error and not robot.heard
    robot.stop()


@pytest.mark.usefixtures("quick")
def test_someone_is_asked_to_pull_the_cable(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = ToyRobot()
    robot.start()
    hands = [robot.stop, robot.start]

    class Person:
        def readline(self) -> str:
            hands.pop(0)()
            return "\n"

    monkeypatch.setattr("sys.stdin", Person())
    assert main(["robot", "check", robot.url, "--interactive", "--json"]) == 0
    said = capsys.readouterr()
    passed = {check["name"] for check in json.loads(said.out)["checks"] if check["passed"]}
    assert {"loss noticed", "reconnect"} <= passed
    assert said.err.index("Pull") < said.err.index("Plug")
    robot.stop()


@pytest.mark.parametrize("robot", ["nothing:", "no_such.toml", "py:no_such.py:"])
def test_a_url_that_names_no_robot_is_a_sentence(capsys: pytest.CaptureFixture[str], robot: str) -> None:
    assert main(["robot", "check", robot]) == 1
    assert capsys.readouterr().err.startswith("beckon: ")
