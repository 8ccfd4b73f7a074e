"""The how-tos of recordings: every command in a fence is tried, from top to bottom."""

import json
import os
import shlex
import shutil
import signal
from pathlib import Path
from typing import Any

import pytest

import console.options
import console.serve
from console.__main__ import main
from console.cli import build_parser
from console.recording.recorder import RecorderService
from core.pipelines.record import RobotRecording
from core.simulation.faulty_robot import open_robot
from tests.benchmarks.replays import repeated
from tests.console.live import Live
from tests.console.recording.drives import drive
from tests.console.test_documented_requests import FENCE, HOW_TO, printed, sent

PAGES = ("record-a-drive", "find-out-what-happened", "compare-two-settings")
LENGTH_S = 120.0  # of the recording in which the how-to seeks


def test_every_command_of_the_three_pages_does_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BECKON_HOME", str(tmp_path / "home"))
    served: list[Any] = []
    monkeypatch.setattr(console.serve, "serve", served.append)
    Path("try.toml").write_text("[matching]\ncorrects = false\n")
    lines = [
        line.strip()
        for page in PAGES
        for fence in FENCE.findall((HOW_TO / f"{page}.md").read_text())
        for line in fence.splitlines()
    ]
    commands = [line.replace("--seconds 60", "--seconds 3") for line in lines if line.startswith("beckon ")]
    for line in commands:
        chosen = build_parser().parse_args(shlex.split(line)[1:])
        assert chosen.run(chosen) in (0, None), line
        if line.startswith("beckon record"):
            shutil.copy("walk.mcap", "contact.mcap")
    assert len(commands) == 7 and len(served) == 3
    for options in served:
        console.options.check(options)
    ways = [Path(folder, "trajectory.tum").read_text().splitlines() for folder in ("before", "after")]
    assert len(ways[0]) == len(ways[1]) > 10 and all(len(row.split()) == 8 for way in ways for row in way)
    assert [line for line in lines if line.startswith("evo_ape")] == [
        "evo_ape tum before/trajectory.tum after/trajectory.tum"
    ]
    assert Path("after/report.html").exists()


def test_a_recording_without_a_page_that_is_ended_is_a_whole_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `timeout 60 beckon record` and a service manager end it."""

    def ended(recording: RobotRecording, logged: float) -> None:
        add(recording, logged)
        os.kill(os.getpid(), signal.SIGTERM)

    def unheard(*_: object) -> None:
        raise AssertionError("it would have been killed")

    add, out = RobotRecording.add, tmp_path / "walk.mcap"
    monkeypatch.setattr(RobotRecording, "add", ended)
    before = signal.signal(signal.SIGTERM, unheard)
    try:
        assert main(["record", "--robot", "sim:lab", "--out", str(out), "--json"]) == 0
        assert signal.getsignal(signal.SIGTERM) is unheard
    finally:
        signal.signal(signal.SIGTERM, before)
    assert json.loads(capsys.readouterr().out)["complete"] and [path.name for path in tmp_path.iterdir()] == [
        out.name
    ]
    out.rename(tmp_path / "walk.mcap.part")  # as one that was killed leaves it
    assert main(["record", "--robot", "sim:lab", "--out", str(out)]) == 1
    assert "walk.mcap.part is there already" in capsys.readouterr().err


@pytest.mark.campaign
def test_every_request_of_the_pages_is_answered(tmp_path: Path) -> None:
    files, (start, stop) = dict[str, bytes](), printed(PAGES[0])
    with Live(tmp_path / "records") as live:
        assert sent(live, start, files).status == 201
        live.until(lambda: live.runtime.parts[RecorderService].state.seconds > 1.0)
        assert sent(live, stop, files).json["complete"]
    drive(open_robot("lab", seed=3, settings=None), tmp_path / "short.mcap", 120, lambda *_: None)
    long = repeated(tmp_path / "short.mcap", tmp_path / "contact.mcap", LENGTH_S)
    requests = list(printed(PAGES[1]))
    with Live(tmp_path / "plays", url=f"log:{long}") as live:
        answers = [sent(live, one, files) for one in requests]
    assert len(answers) == 4 and [one.status for one in answers] == [200] * 4, [one.body[:200] for one in answers]
    assert answers[2].json["recording"]["seconds"] > 12.0
    assert files["what-happened.webp"][8:12] == b"WEBP"
