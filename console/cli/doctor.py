"""`beckon doctor`: the installed and the missing parts, and the command that installs each."""

import argparse
import re
import shutil
import socket
import sys
import threading
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from console.cli.answer import add_command, answer, tell
from console.data_folder import home_folder
from core.errors import Unavailable, Unwritable
from core.files import check_folder
from core.gate.scheduling import CONSOLE_RANK, come_first
from core.install import install_extra, install_packages, requirements
from core.message import message
from core.models import MODEL, MODELS, find

DEFAULT_PORT = 8420
PACKAGE = re.compile(r"[A-Za-z0-9._-]+")
PYTHONS = re.compile(r"python_version\s*==\s*['\"]([0-9.]+)['\"]")  # the only condition that Beckon sets
HERE = f"{sys.version_info.major}.{sys.version_info.minor}"
OTHER_OPENCV = ("opencv-python", "opencv-contrib-python", "opencv-contrib-python-headless")
WELL = "All that is needed is here."
MISSING = "Something that is needed is missing; see the arrows above."
FAILED = "The self-test found something that is not as it should be; the lines marked FAILED say what."


@message
class CheckResult:
    name: str
    good: bool
    found: str
    needed: bool = True  # False: Beckon runs without it
    remedy: str = ""
    tested: bool = False  # rather than looked for

    @property
    def mark(self) -> str:
        if self.good:
            return "ok"
        return "FAILED" if self.tested else "MISSING" if self.needed else "absent"

    @property
    def advice(self) -> str:
        return "" if self.good else self.remedy


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "doctor", run, "what is installed, what is missing, what to do")
    parser.add_argument("--self-test", action="store_true", help="drive the simulated robot for a minute and measure")
    parser.add_argument(
        "--profile",
        nargs="?",
        const="",
        metavar="DRIVE.mcap",
        help="measure where the time of the robot's steps goes, in a drive that Beckon recorded, or in the simulator",
    )


def run(chosen: argparse.Namespace) -> int:
    """Exit code 1 when something needed is missing or the self-test fails."""
    if chosen.profile is not None:
        return profile(chosen)
    findings = [*examine()]
    if chosen.self_test:
        from console.cli.self_test import self_test  # the whole robot: only when it is asked for

        tell("The self-test drives the simulated robot; this takes about a minute.")
        findings += [CheckResult(name=name, good=good, found=found, tested=True) for name, good, found in self_test()]
    bad = [one for one in findings if one.needed and not one.good]
    lines = list[str]()
    for one in findings:
        lines.append(f"{one.mark:8}{one.name:26}{one.found}")
        if one.advice:
            lines.append(f"        → {one.advice}")
    for sentence, tested in ((MISSING, False), (FAILED, True)):
        if any(one.tested is tested for one in bad):
            lines.append(sentence)
    rows = [
        {"name": one.name, "ok": one.good, "needed": one.needed, "found": one.found, "remedy": one.advice}
        for one in findings
    ]
    answer(chosen, {"ok": not bad, "findings": rows}, *lines, *([] if bad else [WELL]))
    return 1 if bad else 0


def profile(chosen: argparse.Namespace) -> int:
    """Tell where the time of the steps goes. Raises BadInput for a file that is no drive of ours."""
    from console.cli.step_profile import lines_of, recorded_profile, simulated_profile  # the whole robot
    from core.settings import Settings

    found = recorded_profile(Path(chosen.profile), Settings()) if chosen.profile else simulated_profile()
    return answer(chosen, {**asdict(found), "rooms": dict(found.rooms)}, *lines_of(found))


def examine() -> list[CheckResult]:
    return [
        python(),
        *map(package, needed()),
        human_voices(),
        words(),
        people(),
        one_opencv(),
        voice(),
        microphones(),
        figures(),
        pipe(),
        precedence(),
        port(),
        home(),
        browser(),
    ]


def missing_packages(extra: str) -> list[str]:
    names = [name[0] for line in requirements(extra) if (name := PACKAGE.match(line))]
    return [name for name in names if not package(name).good]


def needed(python: str = HERE) -> list[str]:
    """The packages that Beckon needs on this Python ("3.11")."""
    wanted = (line for line in requirements() if python in PYTHONS.findall(line) or not PYTHONS.search(line))
    return [name[0] for line in wanted if (name := PACKAGE.match(line))]


def python() -> CheckResult:
    running = ".".join(map(str, sys.version_info[:3]))
    return CheckResult(
        name="Python", good=sys.version_info >= (3, 11), found=running, remedy="install Python 3.11 or newer"
    )


def package(name: str) -> CheckResult:
    try:
        return CheckResult(name=name, good=True, found=version(name))
    except PackageNotFoundError:
        return CheckResult(name=name, good=False, found="not installed", remedy=install_packages(name))


def optional(name: str, *, good: bool, here: str, without: str, remedy: str) -> CheckResult:
    """One of the parts that Beckon runs without: what is found when it is `here`, and what is so `without` it."""
    return CheckResult(name=name, good=good, needed=False, found=here if good else without, remedy=remedy)


def human_voices() -> CheckResult:
    """Check the model of the recognizer that understands people."""
    without = "people are understood less well" if package("pocketsphinx").good else "nobody is understood"
    return optional(
        "words (Whisper)",
        good=find(MODEL) is not None,
        here=MODEL,
        without=f"its model is not here: {without}",
        remedy=f"beckon models get {MODEL} ({MODELS[MODEL].megabytes} MB)",
    )


def words(python: str = HERE) -> CheckResult:
    """Check the recognizer that spots STOP and needs no model, and say what is without it."""
    there = package("pocketsphinx")
    without = "Whisper spots STOP too, later" if human_voices().good else "the robot hears where, not what"
    without, remedy = f"not installed: {without}", install_extra("speech")
    ready = [one for line in requirements() if line.startswith("pocketsphinx") for one in PYTHONS.findall(line)]
    if ready and python not in ready:
        without += f" (there is no ready-made package for Python {python})"
        remedy += f" with a C compiler and CMake, or run Beckon on Python {' or '.join(ready)}"
    return optional("words (pocketsphinx)", good=there.good, here=there.found, without=without, remedy=remedy)


def people() -> CheckResult:
    return optional(
        "people (networks)",
        good=find("people") is not None,
        here="see real people",
        without="not here: only the simulator's drawn figures are seen",
        remedy=f"beckon models get people ({MODELS['people'].megabytes} MB)",
    )


def one_opencv() -> CheckResult:
    """Check that no other package brings the same `cv2` over Beckon's."""
    others = [name for name in OTHER_OPENCV if package(name).good]
    return optional(
        "one OpenCV",
        good=not others,
        here="yes",
        without=f"{' and '.join(others)} too: whichever was installed last is used",
        remedy=f"{sys.executable} -m pip uninstall {' '.join(others)}, then "
        f"{install_packages('--force-reinstall', '--no-deps', 'opencv-python-headless')}",
    )


def voice() -> CheckResult:
    from core.speech.synthesis import can_speak  # loads a library: only when it is asked for

    return optional(
        "voice (espeak-ng)",
        good=can_speak(),
        here="speaks",
        without="not installed: text is not spoken",
        remedy=f"{install_extra('voice')} · Debian: apt install espeak-ng",
    )


def microphones() -> CheckResult:
    """Check whether a robot with audio://, the microphones of this computer, can be heard."""
    from core.robots.usb_audio import imported  # a driver: only when it is asked for

    try:
        here, remedy = f"sounddevice {imported().__version__}", ""
    except Unavailable as why:
        here, remedy = "", str(why)
    without = "not usable; only robots with audio: need it"
    return optional("microphones (audio:)", good=bool(here), here=here, without=without, remedy=remedy)


def figures() -> CheckResult:
    there = package("matplotlib")
    return optional(
        "figures (matplotlib)",
        good=there.good,
        here=there.found,
        without="not installed: experiments write their numbers, but no figures",
        remedy=install_extra("figures"),
    )


def pipe() -> CheckResult:
    return optional(
        "message pipes",
        good=hasattr(socket, "SOCK_SEQPACKET") and sys.platform == "linux",
        here="SOCK_SEQPACKET",
        without="datagrams: a dead console is noticed by its silence only",
        remedy="run the robot's side on Linux",
    )


def precedence() -> CheckResult:
    """Check that a machine that is busy with something else still steers in time."""
    found: list[bool] = []
    asking = threading.Thread(target=lambda: found.append(come_first(CONSOLE_RANK)))  # no other thread keeps it
    asking.start()
    asking.join()
    return optional(
        "precedence",
        good=found == [True],
        here="before other programs",
        without="like other programs: while they take all, it stops",
        remedy="Linux: allow real-time priority, in /etc/security/limits.conf: YOU - rtprio 5",
    )


def port() -> CheckResult:
    free = True
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", DEFAULT_PORT))
        except OSError:
            free = False
    remedy = "another console may be running; or choose one: beckon --port 0"
    return optional(f"port {DEFAULT_PORT}", good=free, here="free", without="in use", remedy=remedy)


def home() -> CheckResult:
    folder, remedy = home_folder(), "set BECKON_HOME to a folder that you may write to"
    try:
        check_folder(folder)
    except Unwritable as trouble:
        return CheckResult(name="data folder", good=False, found=str(trouble), remedy=remedy)
    return CheckResult(name="data folder", good=True, found=str(folder))


def browser() -> CheckResult:
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    where = next((found for found in map(shutil.which, names) if found), None)
    return optional(
        "Chromium (tests only)",
        good=where is not None,
        here=str(where),
        without="not found",
        remedy="Debian: apt install chromium · elsewhere: playwright install chromium",
    )
