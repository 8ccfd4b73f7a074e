"""Fixtures that every room shares."""

import contextlib
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

os.environ.pop(
    "PYTHONDONTWRITEBYTECODE", None
)  # hundreds of processes start: what one has compiled, the next one uses
sys.dont_write_bytecode = False

settings.register_profile("beckon", deadline=None)  # on a busy machine an example takes as long as it takes
settings.load_profile("beckon")

REPOSITORY = Path(__file__).resolve().parent.parent
BROWSER = "browser/"
PROCESSES = (
    "console/calibration/",
    "console/robot/",
    "console/api/test_connection.py",
    "console/test_serve.py",
    "core/gate/test_gate_process.py",
)  # these start wizards' workers, drivers and gates of their own
CONSOLES = ("benchmarks/", "console/")  # these share a console
LIVE = (BROWSER, *PROCESSES, *CONSOLES)  # all of them keep real time, one after another
OFFLINE = (
    "benchmarks/test_imports.py",
    "console/access/test_logins",
    "console/access/test_strict_json.py",
    "console/control/test_lease.py",
    "console/maps/test_maps.py",
    "console/speech/test_transcription_memory.py",
    "console/test_calibrate_",
    "console/test_experiment_command.py",
    "console/test_hear_command.py",
    "console/test_settings_command.py",
    "console/test_speech_quality_command.py",
)  # except these, which only compute
WIRES = (
    "core/robots/",
    "stories/test_own_driver.py",
    "stories/test_session",
)  # real time too, but mostly waiting: any process runs any test
SHARED = ("core/robots/test_conformance.py", "core/robots/ros/test_links.py")  # but tests of one robot run together
RANKS = {"browser": 0, "consoles": 1, "processes": 2}


def room_of(file: str) -> str:
    """What goes together: pages, consoles, processes, and of the rest every file by itself."""
    file = file.removeprefix("tests/")
    if file.startswith(OFFLINE):
        return file
    rooms = (("browser", BROWSER), ("processes", PROCESSES), ("consoles", CONSOLES))
    return next((room for room, files in rooms if file.startswith(files)), file)


def keeps_time(file: str) -> bool:
    """Return whether a file's tests fail where nobody computes for them in time."""
    return file.startswith((*LIVE, *WIRES)) and not file.startswith(OFFLINE)


class Sharing(LoadScopeScheduling):
    """Pages, consoles and processes in a worker each, one test after another; the others by files.

    Tests on wires wait most of their time: each goes to whoever is free, so that none is left with a long file.
    """

    def _split_scope(self, nodeid: str) -> str:
        file, _, test = nodeid.partition("::")
        if file.removeprefix("tests/").startswith(SHARED):
            return f"{file}[{test.partition('[')[2].partition('-')[0]}"
        return nodeid if file.removeprefix("tests/").startswith(WIRES) else room_of(file)


COMPILED = REPOSITORY / "tests" / "core" / "__pycache__"
HALVES = (
    ("tests/core",),
    ("tests/console", "tests/browser", "tests/benchmarks", "tests/real_data", "tests/recipes", "tests/stories"),
)


def pytest_sessionstart(session: pytest.Session) -> None:
    """In a fresh clone every worker would compile every test: two processes do it before there are workers."""
    if session.config.getoption("numprocesses", None) and not COMPILED.exists():
        compiling = [sys.executable, "-m", "pytest", "-n", "0", "--collect-only", "-q"]
        started = [
            subprocess.Popen([*compiling, *half], cwd=REPOSITORY, stdout=subprocess.DEVNULL) for half in HALVES
        ]
        for process in started:
            process.wait()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Sharing:
    return Sharing(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What lasts longest begins first; of consoles, those that a test starts for itself, then the one they share.

    A console takes a seventh of a processor even at rest, until the last test of its folder is over.
    """
    sharing = {item.path for item in items if "shared_live" in getattr(item, "fixturenames", ())}
    items.sort(key=lambda item: (RANKS.get(room_of(file_of(item)), len(RANKS)), item.path in sharing))


def pytest_runtest_setup(item: pytest.Item) -> None:
    """What only computes takes the time that is left over by what keeps real time."""
    if "PYTEST_XDIST_WORKER" in os.environ and hasattr(os, "SCHED_IDLE"):
        policy = os.SCHED_OTHER if keeps_time(file_of(item)) else os.SCHED_IDLE
        if os.sched_getscheduler(0) != policy:
            with contextlib.suppress(PermissionError):  # some systems let nobody out of idleness
                os.sched_setscheduler(0, policy, os.sched_param(0))


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """With --durations also how long each room took: none can end before the longest of them."""
    if config.getoption("durations") is None:
        return
    seconds: Counter[str] = Counter()
    for report in (report for kind in ("passed", "failed", "") for report in terminalreporter.stats.get(kind, ())):
        room = room_of(report.nodeid.partition("::")[0])
        seconds[room if room in RANKS else "the others"] += report.duration
    terminalreporter.write_line(", ".join(f"{room} {total:.0f} s" for room, total in seconds.most_common()))


def file_of(item: pytest.Item) -> str:
    """The file of a test, as seen from this folder."""
    return item.nodeid.partition("::")[0].removeprefix("tests/")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--require-browser", action="store_true", help="fail where browser tests would skip")


@pytest.fixture(scope="session", autouse=True)
def no_pilot_comes_first() -> Iterator[None]:
    """One in the tests' own process would run before the console and the gate that are there with it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("console.robot.pilot_thread.stay_first", lambda _: False)
        yield


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings beside the repository; tests that need it skip where it is absent."""
    folder = REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"The real recordings are not here: {folder.name}/ is expected beside the repository in shared/.")
    return folder
