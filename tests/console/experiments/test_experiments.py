"""Experiments from the page: listed as declared, run one at a time, cancelled with all processes, kept."""

import asyncio
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from console.experiments.runs import Catalogue, ExperimentRuns, counted
from console.http.problems import problem_of
from console.run_store import RunStore, StoredRun
from console.workers.worker import WorkerLost
from core.experiments import EXPERIMENTS
from core.experiments.plan import figure_at
from tests.console.live import Live, until

CHEAPEST = "dead-reckoning-vs-slam"


@pytest.fixture(autouse=True)
def nothing_runs(request: pytest.FixtureRequest) -> Iterator[None]:
    """Afterwards nothing of it is left."""
    live: Live | None = request.getfixturevalue("live") if "live" in request.fixturenames else None
    yield
    for number in list(live.runtime.parts[ExperimentRuns].runs) if live else []:
        ask(live, "POST", f"/runs/{number}/cancel")


def ask(live: Live, method: str, path: str, body: Any = None) -> Any:
    return live.ask(method, f"/api/experiments{path}", body, token=live.operator)


@pytest.fixture
def listed(live: Live) -> list[dict[str, Any]]:
    """What there is, once it was read: every algorithm is imported for that."""
    return live.until(lambda: ask(live, "GET", "").json["experiments"], 120.0)


def test_a_reader_that_is_lost_is_told_once_and_then_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def work() -> None:
        catalogue = Catalogue()
        monkeypatch.setattr("console.workers.worker.START_TIMEOUT_S", 0.0)
        with pytest.raises(WorkerLost, match="took too long") as lost:
            while catalogue.known is None:
                await asyncio.sleep(0.01)
        assert problem_of(lost.value).status == 503 and catalogue.known is None
        await catalogue.close()

    asyncio.run(work())


def processes_of(number: str) -> list[str]:
    """Command lines of the processes that work for a run."""
    found: list[str] = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = entry.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        found += [line] if number in line else []
    return found


@pytest.mark.campaign
def test_an_experiment_is_run_from_the_page_and_its_files_are_those_of_the_command_line(
    live: Live, listed: list[dict[str, Any]]
) -> None:
    assert [one["name"] for one in listed] == sorted(EXPERIMENTS)
    assert all(one["title"] and one["runs"] >= 1 for one in listed)
    begun = ask(live, "POST", "/runs", {"experiment": CHEAPEST, "runs": 1, "seed": 7})
    assert begun.status == 202 and begun.json["state"] == "running"
    path = f"/runs/{begun.json['id']}"
    assert ask(live, "POST", "/runs", {"experiment": CHEAPEST}).status == 409
    live.until(lambda: ask(live, "GET", path).json["state"] != "running", 120.0)
    run = ask(live, "GET", path).json
    assert (run["state"], run["reason"], run["progress"]) == ("done", "", 1.0)
    chapter = {row["name"]: (row["chapter"], row["ours"]) for row in run["compared"]}
    printed, ours = chapter["EKF-SLAM, worst average error"]
    assert printed == 0.08 and 0.0 < ours < 0.5
    assert "ekf_slam" in run["text"]
    files = {one["name"]: one for one in run["files"]}
    assert {"figure_16.svg", "result.json", "dead_reckoning_vs_slam.json"} <= files.keys()
    assert run["files"][0]["figure"]
    figure = ask(live, "GET", f"{path}/files/figure_16.svg")
    assert figure.headers["content-type"] == "image/svg+xml" and b"<svg" in figure.body
    assert "sandbox" in figure.headers["content-security-policy"]
    assert ask(live, "GET", f"{path}/files/..%2frun.json").status == 404
    again = ExperimentRuns(live.runtime.parts[ExperimentRuns]._folder.parent)
    asyncio.run(again.open())
    assert again.find(run["id"]).shown.compared == live.runtime.parts[ExperimentRuns].find(run["id"]).compared
    assert ask(live, "DELETE", path).status == 204 and ask(live, "GET", path).status == 404
    assert not (live.runtime.parts[ExperimentRuns]._folder / run["id"]).exists()


@pytest.mark.usefixtures("listed")
def test_a_cancelled_experiment_leaves_no_process(live: Live) -> None:
    number = ask(live, "POST", "/runs", {"experiment": CHEAPEST, "runs": 10_000}).json["id"]
    live.until(lambda: processes_of(number), 60.0)
    answer = ask(live, "POST", f"/runs/{number}/cancel")
    assert answer.json["state"] == "cancelled" and "Cancelled" in answer.json["doing"]
    assert processes_of(number) == []


@pytest.mark.usefixtures("listed")
def test_viewers_watch_and_nonsense_is_refused_in_words(live: Live) -> None:
    def refused(body: dict[str, Any]) -> tuple[int, str]:
        answer = ask(live, "POST", "/runs", body)
        return answer.status, answer.json["detail"]

    viewed = live.ask("POST", "/api/experiments/runs", {"experiment": CHEAPEST}, token=live.viewer)
    assert viewed.status == 403 and live.ask("GET", "/api/experiments", token=live.viewer).status == 200
    assert refused({"experiment": "figure-99"}) == (
        404,
        "There is no such experiment; GET /api/experiments lists them.",
    )
    for wrong in ({"runs": 0}, {"runs": 10**9}, {"seed": -1}, {"out": "/tmp"}):
        assert refused({"experiment": CHEAPEST, **wrong})[0] == 422
    assert ask(live, "GET", "/runs/none").status == 404


def test_what_a_line_counts_is_the_progress() -> None:
    assert counted("12 of 40 runs…") == 0.3
    assert counted("run 7 of 4") == 1.0
    assert counted("Tour of the laboratory") is None and counted("0 of 0") is None


def test_a_figure_is_found_by_its_keys_and_nothing_else_is() -> None:
    result = {"table": [{"value": 1.5}], "name": "x", "flag": True}
    assert figure_at(result, "table.0.value") == 1.5
    for keys in ("table.1.value", "table.x", "name", "flag", "table.0.value.more", ""):
        assert figure_at(result, keys) is None, keys


def test_a_leashed_program_ends_with_its_console() -> None:
    ours, theirs = os.pipe()
    child = subprocess.Popen(
        [sys.executable, "-m", "console.workers.leashed", "http.server", "0"],
        stdin=ours,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    os.close(ours)
    os.close(theirs)
    assert child.wait(20) == -9


def test_a_run_that_breaks_has_failed_and_was_not_cancelled(tmp_path: Path) -> None:
    async def broken(_: StoredRun) -> None:
        raise KeyError("no such row")

    async def story() -> StoredRun:
        runs = RunStore(tmp_path, StoredRun, 5, "busy")
        run = runs.start(StoredRun(who="Ann"), broken)
        await until(lambda: not runs.running)
        return run

    run = asyncio.run(story())
    assert (run.state, run.doing) == ("failed", "") and "the log says more" in run.reason
