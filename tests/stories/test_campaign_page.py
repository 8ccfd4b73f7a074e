"""The page on campaigns, top to bottom: every fenced command as it stands there, with a scheduler and its workers."""

import importlib.util
import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "static/docs/how-to/run-a-campaign-on-a-cluster.md"
PROGRAMS = {"beckon": "console", "dask": "dask"}


def fenced() -> Iterator[list[str]]:
    """Every command of the page."""
    for fence in re.findall(r"^```sh\n(.*?)^```", PAGE.read_text(), re.M | re.S):
        for line in fence.strip().splitlines():
            program, *rest = shlex.split(line)
            yield [sys.executable, "-m", PROGRAMS[program], *rest]


@pytest.mark.campaign
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs the extra cluster")
def test_every_command_of_the_page_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("BECKON_HOME", str(tmp_path / "home"))
    printed: list[str] = []
    with ExitStack() as ended:
        for command in fenced():
            if command[2] == "dask":
                server = ended.enter_context(
                    subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
                )
                ended.callback(server.terminate)
                assert server.stderr is not None
                next(line for line in server.stderr if "Scheduler at" in line or "Starting established" in line)
            else:
                told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=1800)
                assert told.returncode == 0, told.stderr
                printed.append(told.stdout)
    assert "8 runs were done before" in printed[1] and "speed-up" in printed[0]
    here, of_two = (
        json.loads((tmp_path / folder / "dead_reckoning_vs_slam.json").read_text())
        for folder in ("campaign", "campaign-of-two")
    )
    assert here == of_two and json.loads(printed[2])["workers"] == 2
    assert (tmp_path / "sweep" / "sweep.csv").read_text().count("\n") == 5
    assert "figures/camera-table.json" in printed[4] and (tmp_path / "figures" / "camera-table.json").exists()
    assert "processors; load before" in printed[5]
