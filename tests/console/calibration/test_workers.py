"""Workers that may be killed."""

import asyncio
import os
import signal
import socket
import threading
import time
from collections.abc import Awaitable, Callable
from importlib import import_module
from inspect import getmembers_static
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from console.calibration.solver_worker import SolverWorker
from console.people.worker import PeopleWorker
from console.workers import process
from console.workers.child_process import ChildProcess
from console.workers.job import JobRequest, JobResult, answer_decoder, decoder, job, packed, plain
from console.workers.process import WORKERS, JobTable
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, Unavailable
from core.gate.scheduling import CONSOLE_RANK, come_first
from core.geometry import Transform
from core.optics import CameraModel
from core.sensors import Image
from tests.console.calibration.wizard import boards, png
from tests.core.gate.ranks import apart, permitted


def working(work: Callable[[Worker], Awaitable[None]]) -> None:
    """Do something with a worker, which is gone afterwards."""

    async def run() -> None:
        worker = Worker("solver")
        try:
            await work(worker)
        finally:
            worker.kill()

    asyncio.run(run())


def test_a_worker_is_modest_and_does_what_it_is_asked() -> None:
    async def work(worker: Worker) -> None:
        straight = await worker.ask(SolverWorker.picture(boards()[0], None), budget=2.0)
        assert straight.startswith(b"\xff\xd8")
        with pytest.raises(BadInput, match="no JPEG or PNG"):
            await worker.ask(SolverWorker.picture(b"GIF89a", None), budget=2.0)
        limits = Path(f"/proc/{worker.pid}/limits").read_text()
        assert f"Max address space         {2**30}" in limits
        assert "Max core file size        0 " in limits
        assert os.getpriority(os.PRIO_PROCESS, worker.pid or 0) > os.getpriority(os.PRIO_PROCESS, 0)
        assert int(Path(f"/proc/{worker.pid}/oom_score_adj").read_text()) > 0

    working(work)


class Sleeper:
    def __init__(self) -> None:
        self.rests = 0
        self.rested = threading.Event()

    def rest(self) -> None:
        self.rests += 1
        self.rested.set()

    @job
    def tell(self) -> int:
        """How often have you rested?"""
        return self.rests


def test_a_worker_of_which_nothing_is_asked_rests_once_and_then_does_what_comes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(process, "REST_S", 0.05)
    ours, theirs = socket.socketpair()
    sleeper = Sleeper()
    with theirs:
        thread = threading.Thread(target=process.work, args=(JobTable(sleeper), theirs))
        thread.start()
        with ours:
            assert process.receive(ours)
            assert sleeper.rested.wait(5.0)
            ours.sendall(packed(JobRequest(Sleeper.tell(), 1.0)))
            answer = answer_decoder(Sleeper.tell).decode(process.receive(ours) or b"")
        thread.join(5.0)
    assert answer == JobResult(1) and not thread.is_alive()


def test_a_worker_of_a_console_that_comes_first_stands_back() -> None:
    async def work(worker: Worker) -> None:
        await worker.ready()
        assert os.sched_getscheduler(worker.pid or 0) == os.SCHED_OTHER

    def first() -> None:
        assert come_first(CONSOLE_RANK)
        working(work)

    if not permitted():
        pytest.skip("Nothing may run before other programs here: that takes Linux and root, or a limit rtprio of 3.")
    apart(first)


def test_a_worker_that_hangs_or_was_killed_is_given_up_and_started_anew() -> None:
    job = SolverWorker.picture(boards()[0], None)

    async def work(worker: Worker) -> None:
        await worker.ready()
        first = worker.pid
        os.kill(first or 0, signal.SIGSTOP)
        hanging = asyncio.create_task(worker.ask(job, budget=2.0))
        await asyncio.sleep(0.05)
        os.kill(first or 0, signal.SIGKILL)
        with pytest.raises(WorkerLost, match="nothing else was lost") as lost:
            await hanging
        assert lost.value.killed
        assert await worker.ask(job, budget=2.0)
        assert worker.pid != first and worker.starts == 2
        os.kill(worker.pid or 0, signal.SIGSTOP)
        began = time.monotonic()
        with pytest.raises(WorkerLost, match="too long") as stopped:
            await worker.ask(job, budget=0.05)
        assert time.monotonic() - began < 10.0 and not worker.alive and stopped.value.killed

    working(work)


def test_a_worker_that_does_not_die_at_once_holds_nobody_up(monkeypatch: pytest.MonkeyPatch) -> None:
    async def work(worker: Worker) -> None:
        await worker.ready()
        pid, end = worker.pid, ChildProcess.end
        ended: list[float] = []
        may_die = threading.Event()

        def slowly(child: ChildProcess, patience: float) -> None:
            may_die.wait(10)
            end(child, patience)
            ended.append(patience)

        monkeypatch.setattr(ChildProcess, "end", slowly)
        worker.kill()
        assert not worker.alive and not ended
        may_die.set()
        await worker.gone()
        assert ended and not Path(f"/proc/{pid}").exists()

    working(work)


def test_a_job_has_so_much_processor_time_and_no_more() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (1000, 1500), np.uint8)
    camera = CameraModel(width=1500, height=1000, fx=3e3, fy=3e3, cx=1500, cy=1000)

    async def work(worker: Worker) -> None:
        with pytest.raises(WorkerLost, match="too long"):
            await worker.ask(SolverWorker.picture(png(noise), camera), budget=0.03)

    working(work)


class Liar:
    """Its job's worker answers something else than it says."""

    @job
    def picture(self, content: bytes, camera: None) -> int: ...


def test_an_answer_of_another_shape_is_not_believed() -> None:
    async def work(worker: Worker) -> None:
        with pytest.raises(WorkerLost, match="talks nonsense") as lost:
            await worker.ask(Liar.picture(boards()[0], None), budget=2.0)
        assert not lost.value.killed and not worker.alive
        assert (await worker.ask(SolverWorker.picture(boards()[0], None), budget=2.0)).startswith(b"\xff\xd8")

    working(work)


NO_ARRAYS: list[Any] = [
    ("O", (1,), bytes(8)),  # objects
    ("<c8", (1,), bytes(8)),  # complex
    ("<f16", (1,), bytes(16)),
    ("<f1", (1,), bytes(1)),
    ("<f8", (2,), bytes(8)),  # more than there is
    ("<f8", (-1,), bytes(8)),
    ("<f8", (1,), bytes(7)),
    ("|u1", (1,) * 5, bytes(1)),
    ("|u1", (2**62, 2**62), b""),
    ("|u1", (1,), "a"),
    ("|u1", (1,)),
    None,
    [[1.0]],
]


@pytest.mark.parametrize("given", NO_ARRAYS)
def test_an_array_that_is_none_is_not_believed(given: Any) -> None:
    raw = msgspec.msgpack.encode({"rotation": given, "translation": ("<f8", (3,), bytes(24))})
    with pytest.raises(msgspec.MsgspecError):
        decoder(Transform).decode(raw)


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int16, ">i4", np.int64, np.float32, ">f8"])
def test_arrays_cross_with_their_kind_and_shape_and_nobody_can_write_them(kind: Any) -> None:
    for given in (np.arange(24).reshape(2, 3, 4)[:, ::2].astype(kind), np.zeros((0, 3), kind)):
        raw = msgspec.msgpack.encode(Image(stamp=1.0, pixels=given), enc_hook=plain)
        found = decoder(Image).decode(raw).pixels
        assert found.dtype == np.dtype(kind).newbyteorder("<") and np.array_equal(found, given)
        assert not found.flags.writeable


def test_a_job_of_another_worker_is_refused_and_the_worker_stays(caplog: pytest.LogCaptureFixture) -> None:
    async def work(worker: Worker) -> None:
        with pytest.raises(Unavailable, match="nothing was lost"):
            await worker.ask(PeopleWorker.learn("Ann", []), budget=2.0)
        assert worker.alive and worker.starts == 1

    working(work)
    assert "'learn'" in caplog.text


def test_every_worker_has_jobs_whose_arguments_and_answers_can_be_decoded() -> None:
    for place in WORKERS.values():
        module, _, name = place.partition(":")
        worker = getattr(import_module(module), name)
        JobTable(worker())
        kinds = [each.kind for _, each in getmembers_static(worker) if isinstance(each, job)]
        assert kinds, place
        for kind in kinds:
            answer_decoder(kind)
