"""Campaigns: the same answers on any workers, kept as they end, resumed after a kill, refused for other runs."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.experiments.campaign import Campaign
from core.experiments.plan import ExperimentPlan, RunBatch
from core.experiments.result import SPEED, as_text
from core.experiments.workers import difference, versions
from core.install import install_extra
from core.message import Array, message

REPOSITORY = Path(__file__).parents[3]


@message
class Drawn:
    """An answer with everything that JSON could lose."""

    mean: float
    rows: dict[str, Array]
    missing: float


def drawn(seed: int, folder: Path | None, number: int) -> Drawn:
    """Random numbers of a run; where a folder is given, a mark there that it was carried out."""
    if folder is not None:
        (folder / f"run-{number}-{os.getpid()}").touch()
    rng = np.random.default_rng((seed, number))
    return Drawn(mean=float(rng.normal()) / 3, rows={"a": rng.normal(size=(2, 3))}, missing=float("nan"))


def summed(out: Path | None, done: list[Drawn]) -> Any:
    total = 0.0
    for one in done:
        total += one.mean + float(one.rows["a"].sum())
    return {"seed": 0, "total": total, "runs": len(done), "files": {}}


def planned(count: int = 9, seed: int = 0, folder: Path | None = None, work: Any = drawn) -> ExperimentPlan:
    return ExperimentPlan((RunBatch(partial(work, seed, folder), count, Drawn),), summed)


def figures(result: Any) -> dict[str, Any]:
    """A result without how the campaign went."""
    return {key: one for key, one in result.items() if key not in ("files", *SPEED)}


def carried_out(folder: Path) -> list[int]:
    return sorted(int(path.name.split("-")[1]) for path in folder.glob("run-*"))


def interrupted(seed: int, folder: Path | None, number: int) -> Drawn:
    if number == 4:
        raise KeyboardInterrupt
    return drawn(seed, folder, number)


def rows_in(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_an_interrupted_campaign_keeps_its_runs_and_goes_on_with_those_that_lack(tmp_path: Path) -> None:
    told: list[str] = []
    campaign = Campaign("drawn-ones", out=tmp_path / "new", tell=told.append, workers=1)
    whole = replace(campaign, out=None).carry_out(planned())
    with pytest.raises(KeyboardInterrupt):
        campaign.carry_out(planned(work=interrupted))
    path = tmp_path / "new" / "drawn_ones_runs.jsonl"
    assert told[-1] == f"Ended after 4 of 9 runs; their figures are in {path}."
    heading, *rows = rows_in(path)
    assert (heading["experiment"], heading["runs"], heading["NumPy"]) == ("drawn-ones", 9, np.__version__)
    assert [(row["number"], row["done"], row["of"]) for row in rows] == [(n, n + 1, 9) for n in range(4)]
    path.write_text(path.read_text().replace(heading["options"], checksum_of(planned(folder=tmp_path))))
    with path.open("a") as file:
        file.write('{"number": 7, "do')  # a line that the kill cut off
    resumed = replace(campaign, resume=True).carry_out(planned(folder=tmp_path))
    assert carried_out(tmp_path) == [4, 5, 6, 7, 8]
    assert resumed["resumed_runs"] == 4 and figures(resumed) == figures(whole)
    assert "Resumed: 4 of 9 runs were done." in told
    again = replace(campaign, resume=True).carry_out(planned(folder=tmp_path))
    assert len(carried_out(tmp_path)) == 5 and figures(again) == figures(whole)
    assert again["resumed_runs"] == 9 and "no run was left" in as_text(again)
    assert [row["number"] for row in rows_in(path)[1:]] == list(range(9))


def test_a_result_for_people_has_its_rows_in_its_own_table_alone() -> None:
    told = as_text({"text": "room  edges\nlab     618", "runs": 2, "rooms": [{"room": "lab", "edges": 618}]})
    assert told.splitlines() == ["room  edges", "lab     618", "", f"{'runs':34}2"]


def checksum_of(plan: ExperimentPlan) -> str:
    from core.experiments.campaign import checksum

    return checksum(plan.batches)


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        ({"count": 8}, r"holds other runs \(runs: 9, now 8\)"),
        ({"seed": 1}, "holds other options or settings"),
        ({"work": interrupted}, "holds other options or settings"),
    ],
)
def test_the_file_of_other_runs_is_refused_and_stays(tmp_path: Path, other: Any, sentence: str) -> None:
    campaign = Campaign("drawn", out=tmp_path, workers=1, resume=True)
    campaign.carry_out(planned())
    before = (tmp_path / "drawn_runs.jsonl").read_bytes()
    with pytest.raises(BadInput, match=sentence):
        campaign.carry_out(planned(**other))
    with pytest.raises(BadInput, match="experiment: drawn, now other"):
        (tmp_path / "drawn_runs.jsonl").rename(tmp_path / "other_runs.jsonl")
        replace(campaign, experiment="other").carry_out(planned())
    assert (tmp_path / "other_runs.jsonl").read_bytes() == before
    changed = before.replace(versions()["Beckon"].encode(), b"0.0.1+other")
    (tmp_path / "drawn_runs.jsonl").write_bytes(changed)
    with pytest.raises(BadInput, match=r"Beckon: 0\.0\.1\+other, now"):
        campaign.carry_out(planned())


def killing(seed: int, folder: Path | None, number: int) -> Drawn:
    """Kill the process of run 3, the first time."""
    assert folder is not None
    mark = folder / "killed"
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return drawn(seed, folder, number)


def killing_always(seed: int, folder: Path | None, number: int) -> Drawn:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def test_on_two_processes_of_which_one_is_killed_the_answers_are_those_of_one(tmp_path: Path) -> None:
    alone = Campaign("drawn", workers=1).carry_out(planned())
    beside = Campaign("drawn", out=tmp_path, workers=2).carry_out(planned(folder=tmp_path, work=killing))
    assert (tmp_path / "killed").exists() and set(carried_out(tmp_path)) == set(range(9))
    assert figures(beside) == figures(alone) and beside["workers"] == 2
    assert sorted(row["number"] for row in rows_in(tmp_path / "drawn_runs.jsonl")[1:]) == list(range(9))
    assert "speed-up" in as_text(beside)


@pytest.mark.campaign
def test_runs_that_always_kill_their_process_end_the_campaign_with_a_sentence() -> None:
    with pytest.raises(Unavailable, match="fewer --workers"):
        Campaign("drawn", workers=2).carry_out(planned(work=killing_always))


def test_two_campaigns_do_not_write_one_file(tmp_path: Path) -> None:
    campaign = Campaign("drawn", out=tmp_path, workers=1)

    def within(out: Path | None, done: list[Drawn]) -> Any:
        return {"files": {}}

    def second(number: int) -> Drawn:
        campaign.carry_out(planned())
        raise AssertionError

    with pytest.raises(Unavailable, match="Another campaign writes"):
        campaign.carry_out(ExperimentPlan((RunBatch(second, 1, Drawn),), within))


def test_progress_says_runs_done_rate_and_time_to_go() -> None:
    told: list[str] = []
    Campaign("drawn", progress=told.append, workers=1).carry_out(planned(20))
    assert len(told) == 10 and told[-1].startswith("20 of 20 runs, ") and told[-1].endswith(" 0 s to go")


def test_a_worker_of_other_versions_is_named_with_what_to_do() -> None:
    ours = versions()
    assert difference(ours, (ours, True)) is None
    told = difference(ours, ({**ours, "NumPy": "1.0"}, True))
    assert told == f"has NumPy 1.0, and here it is {np.__version__}; install the same version on both."
    assert "one thread" in str(difference(ours, (ours, False)))
    assert "install the same Beckon" in str(difference(ours, ModuleNotFoundError("No module named 'core'")))


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(Unavailable) as refused:
        Campaign("drawn", cluster="tcp://127.0.0.1:1").carry_out(planned())
    assert install_extra("cluster") in str(refused.value)


@pytest.mark.skipif(sys.platform != "linux", reason="the allocator of glibc")
def test_a_worker_of_dask_does_not_fetch_the_memory_of_each_array_from_the_system_anew() -> None:
    faults = "resource.getrusage(resource.RUSAGE_SELF).ru_minflt"
    lines = [
        "import resource, numpy",
        "from core.experiments.workers import keep_freed_memory",
        "keep_freed_memory()",
        f"before = {faults}",
        "for _ in range(100): numpy.ones(2**17)",
        f"print({faults} - before)",
    ]
    environment = {**os.environ, "MALLOC_TRIM_THRESHOLD_": "65536"}  # as dask's nanny sets it
    said = subprocess.run([sys.executable, "-c", "\n".join(lines)], env=environment, capture_output=True, check=True)
    assert int(said.stdout) < 100 * 2**20 / 4096 / 4, "fewer than a quarter of the pages"
