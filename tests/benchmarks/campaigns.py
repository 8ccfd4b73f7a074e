"""One campaign on every kind of worker: `python -m tests.benchmarks.campaigns [NAME …] [--runs N] [--kills]`.

Each experiment is carried out as its user does it: on one process, on two workers, and by a dask cluster of two
worker processes (needs the extra `cluster`). Figures: keys of the JSON that differ (but times), seconds, speed-up.
With `--kills` also: a worker is SIGKILLed in the middle, on this computer and in the cluster (there first a worker
process, which its nanny starts again, then the other's whole computer, nanny and worker); and the whole campaign is
SIGKILLed in the middle and goes on with `--resume`.
"""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import psutil

from core.experiments.result import SPEED
from core.library_threads import ONE_THREAD
from tests.benchmarks.command import run_command
from tests.emulators.zenoh_robot import free_port

WAIT_TIMEOUT_S = 1400.0
LOOK_PERIOD_S = 0.1
EXPERIMENT_NAMES = ("direction-of-arrival", "table-2", "dead-reckoning-vs-slam")
TIME_KEYS = ("real_time_factor",)  # of a result, which differ from run to run
ASKED_RUNS = {
    "table-2": 2,
    "dead-reckoning-vs-slam": 40,
}  # where another number than the experiment's own is asked for


class CampaignProcess:
    """`beckon experiment NAME`, under way."""

    def __init__(self, folder: Path, name: str, runs: int | None, *options: str) -> None:
        self.out, self._runs = folder, folder / f"{name.replace('-', '_')}_runs.jsonl"
        counted = [] if runs is None else ["--runs", str(runs)]
        command = [sys.executable, "-m", "console", "experiment", name, *counted, "--out", str(folder), "--json"]
        self._answer = (folder.parent / f"{folder.name}.json").open("w+")
        self._began = time.monotonic()
        self.process = subprocess.Popen([*command, *options], stdout=self._answer, stderr=subprocess.DEVNULL)

    @property
    def numbers(self) -> list[int]:
        """Which runs are done, in the order of their ends."""
        with contextlib.suppress(FileNotFoundError):
            whole = [line for line in self._runs.read_text().splitlines(keepends=True)[1:] if line.endswith("\n")]
            return [json.loads(line)["number"] for line in whole]
        return []

    def until_done(self, runs: int) -> None:
        """Wait until so many are."""
        end = time.monotonic() + WAIT_TIMEOUT_S
        while len(self.numbers) < runs:
            if self.process.poll() is not None or time.monotonic() > end:
                raise TimeoutError(f"{len(self.numbers)} of {runs} runs, ended with {self.process.poll()}")
            time.sleep(LOOK_PERIOD_S)

    def end(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Wait for its end → the result without how it went, and how it went."""
        code = self.process.wait(WAIT_TIMEOUT_S)
        wall = time.monotonic() - self._began
        self._answer.seek(0)
        result = json.loads(self._answer.read()) if code == 0 else {}
        went = {key: result.get(key) for key in SPEED} | {"exit": code, "wall_s": round(wall, 1)}
        return {key: one for key, one in result.items() if key not in ("files", *SPEED)}, went

    def kill(self) -> int:
        """SIGKILL this process alone; its workers have to notice → how many are left after 5 s."""
        left = psutil.Process(self.process.pid).children(recursive=True)
        self.process.kill()
        self.process.wait()
        return len(psutil.wait_procs(left, 5.0)[1])

    def a_worker(self) -> psutil.Process:
        return next(
            one
            for one in psutil.Process(self.process.pid).children()
            if any("spawn_main" in part for part in one.cmdline())
        )


@contextlib.contextmanager
def dask_cluster(folder: Path) -> Iterator[tuple[str, list[psutil.Process]]]:
    """A scheduler and two worker processes of one thread, each under its own nanny → address, nannies."""
    address = f"tcp://127.0.0.1:{free_port()}"
    own = {**os.environ, **ONE_THREAD}
    log = (folder / "dask.log").open("ab")
    common: dict[str, Any] = {"stdout": log, "stderr": log, "env": own, "cwd": folder}
    host = ["--host", "127.0.0.1", "--no-dashboard"]
    dask = [sys.executable, "-m", "dask"]
    begun = [
        subprocess.Popen([*dask, "scheduler", *host, "--port", address.rpartition(":")[2]], **common),
        *(subprocess.Popen([*dask, "worker", address, *host, "--nthreads", "1"], **common) for _ in range(2)),
    ]
    try:
        from distributed import Client

        with Client(address, timeout=60, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=120)
        yield address, [psutil.Process(one.pid) for one in begun[1:]]
    finally:
        for one in reversed(begun):
            one.terminate()
        for one in begun:
            with contextlib.suppress(subprocess.TimeoutExpired):
                one.wait(20)
            one.kill()


def measure(name: str, runs: int | None, folder: Path, kills: bool) -> dict[str, Any]:
    """All ways of one experiment."""
    rows: dict[str, Any] = {}
    first: list[dict[str, Any]] = []

    def carried_out(way: str, *options: str, disturbed: Callable[[CampaignProcess], dict[str, Any]] | None = None):
        one = CampaignProcess(folder / way, name, runs, *options)
        more = {} if disturbed is None else disturbed(one)
        result, went = one.end()
        first.append(result)
        numbers = one.numbers
        rows[way] = (
            went
            | more
            | {
                "differs": differences(first[0], result) if result else None,
                "runs_done": len(numbers),
                "each_once": sorted(numbers) == list(range(len(numbers))),
                "load_average": round(os.getloadavg()[0], 1),
            }
        )
        say(name, way, rows[way])
        return len(numbers)

    count = carried_out("one-process", "--workers", "1")
    carried_out("two-workers", "--workers", "2")
    with dask_cluster(folder) as (address, _):
        carried_out("cluster-of-two", "--cluster", address)
    if not kills:
        return rows

    def worker_killed(one: CampaignProcess) -> dict[str, Any]:
        one.until_done(count // 3)
        one.a_worker().kill()
        return {"killed_after_runs": len(one.numbers)}

    carried_out("worker-killed", "--workers", "2", disturbed=worker_killed)
    with dask_cluster(folder) as (address, nannies):

        def cluster_killed(one: CampaignProcess) -> dict[str, Any]:
            one.until_done(count // 3)
            nannies[0].children()[0].kill()
            first_at = len(one.numbers)
            one.until_done(2 * count // 3)
            for process in (nannies[1], *nannies[1].children(recursive=True)):
                process.kill()
            return {"killed_after_runs": [first_at, len(one.numbers)]}

        carried_out("cluster-killed", "--cluster", address, disturbed=cluster_killed)
    whole = CampaignProcess(folder / "resumed", name, runs, "--workers", "2")
    whole.until_done(count // 2)
    left = whole.kill()
    before = whole.numbers

    def resumed(one: CampaignProcess) -> dict[str, Any]:
        one.process.wait(WAIT_TIMEOUT_S)
        again = one.numbers[len(before) :]
        return {
            "killed_after_runs": len(before),
            "workers_left_after_5_s": left,
            "kept": one.numbers[: len(before)] == before,
            "run_again": sorted(set(again) & set(before)),
            "then_run": len(again),
        }

    carried_out("resumed", "--workers", "2", "--resume", disturbed=resumed)
    return rows


def differences(first: Any, other: Any, key: str = "") -> list[str]:
    """Keys whose values are not the same to the last digit; without times."""
    if isinstance(first, dict) and isinstance(other, dict):
        keys = [one for one in {**first, **other} if one not in TIME_KEYS]
        return [at for one in keys for at in differences(first.get(one), other.get(one), f"{key}.{one}")]
    if isinstance(first, list) and isinstance(other, list) and len(first) == len(other):
        return [
            at for n, pair in enumerate(zip(first, other, strict=True)) for at in differences(*pair, f"{key}[{n}]")
        ]
    return [] if json.dumps(first) == json.dumps(other) else [key]


def say(name: str, way: str, row: dict[str, Any]) -> None:
    """A line as soon as it is known."""
    sys.stderr.write(f"{name} {way} {json.dumps(row)}\n")
    sys.stderr.flush()


def main(names: Sequence[str] = EXPERIMENT_NAMES, *, runs: int | None = None, kills: bool = False) -> object:
    found: dict[str, Any] = {}
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            found[name] = measure(name, runs or ASKED_RUNS.get(name), Path(folder), kills)
    return found


if __name__ == "__main__":
    run_command(main)
