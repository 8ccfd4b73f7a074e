"""The worker that looks for people: the newest question is answered, and what is wrong is said once."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from console.people.look_service import LookService
from console.people.look_worker import LookWorker, PeopleSeen
from console.people.store import StoredLooks
from console.workers.job import LENGTH, Job, JobResult, answer_decoder, packed
from console.workers.worker import Worker
from core.perception.people.looking import LookAnswer, LookQuestion
from core.perception.people.parts import PeopleSettings
from core.sensors import SensorFrame
from core.snapshot import Hearing, Snapshot, VoiceDirection
from tests.console.live import until
from tests.console.robot.test_setpoint_sender import wanting
from tests.core.perception.onnx_files import onnx_file
from tests.core.perception.stick_figures import white_body
from tests.core.perception.test_own_models import sorted_out
from tests.core.perception.test_pose import PHOTO, asked, sticks


def question(stamp: float) -> LookQuestion:
    return LookQuestion(pixels=np.full((480, 640, 3), 128, np.uint8), camera=PHOTO, stamp=stamp, on_floor=True)


async def answered(service: LookService, seconds: float = 20.0) -> LookAnswer:
    async with asyncio.timeout(seconds):
        while (answer := service.answer()) is None:
            await asyncio.sleep(0.01)
    return answer


def runs() -> bool:
    """True while this process has a worker that looks for people."""
    for child in psutil.Process().children():
        with contextlib.suppress(psutil.NoSuchProcess):  # it ended a moment ago
            if "--worker=look" in child.cmdline():
                return True
    return False


def with_voice() -> Snapshot:
    voice = VoiceDirection(
        id=1,
        stamp=0.0,
        age=0.0,
        azimuth=0.0,
        azimuth_world=0.0,
        sd=0.1,
        sd_heard=0.1,
        elevation=None,
        strength=1.0,
        heard_at=np.zeros(2),
    )
    return replace(wanting(0, 0.0), hearing=Hearing(listening=True, speaking=True, level_db=-30.0, voices=(voice,)))


def during(service: LookService, work: Callable[[], Awaitable[None]]) -> None:
    """Do this while the service runs."""

    async def whole() -> None:
        running = asyncio.create_task(service.run())
        await asyncio.sleep(0)
        try:
            await work()
        finally:
            running.cancel()
            await service.close()

    asyncio.run(whole())


def test_the_newest_question_is_answered_by_a_process_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "own.onnx").write_bytes(onnx_file((1, 3, 320, 320), [sorted_out(57)]))
    said: list[str] = []
    service = LookService(PeopleSettings(model=str(tmp_path / "own.onnx"), farthest=12.0), said.append)
    assert service.for_pilot is service

    async def work() -> None:
        for stamp in (1.0, 2.0, 3.0):
            service.ask(question(stamp))
        answer = await answered(service)
        assert answer.stamp == 3.0
        assert len(answer.found) == 1 and answer.found[0].value > 0.8
        assert service.answer() is None
        assert service.seconds is not None

    during(service, work)
    assert said == []


def test_a_model_that_cannot_be_used_is_named_once(tmp_path: Path) -> None:
    said: list[str] = []
    service = LookService(PeopleSettings(model=str(tmp_path / "absent.onnx")), said.append)

    async def work() -> None:
        service.ask(question(1.0))
        async with asyncio.timeout(20.0):
            while not said:
                await asyncio.sleep(0.02)
        service.ask(question(2.0))
        await asyncio.sleep(0.1)

    during(service, work)
    assert len(said) == 1 and "no such file" in said[0]


def test_a_voice_starts_the_process_and_a_picture_opens_the_networks(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "own.onnx").write_bytes(onnx_file((1, 3, 320, 320), [sorted_out(57)]))
    asked: list[str] = []
    ask = Worker.ask

    async def noted(worker: Worker, job: Job[Any], *, budget: float) -> Any:
        asked.append(type(job).__name__)
        return await ask(worker, job, budget=budget)

    monkeypatch.setattr(Worker, "ask", noted)
    service = LookService(PeopleSettings(model=str(tmp_path / "own.onnx"), farthest=12.0), lambda _: None)

    async def work() -> None:
        service.on_snapshot(with_voice(), SensorFrame(stamp=0.0))
        await until(runs)
        assert asked == []
        service.ask(question(1.0))
        await answered(service)
        assert asked == ["open", "look"]

    during(service, work)


def test_a_worker_that_nobody_needs_gives_its_memory_back(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("console.people.look_service.MAX_IDLE_S", 0.3)
    (tmp_path / "own.onnx").write_bytes(onnx_file((1, 3, 320, 320), [sorted_out(57)]))
    service = LookService(PeopleSettings(model=str(tmp_path / "own.onnx"), farthest=12.0), lambda _: None)

    async def work() -> None:
        for stamp in (1.0, 2.0):
            service.ask(question(stamp))
            assert (await answered(service)).stamp == stamp
            await until(lambda: not runs())

    during(service, work)


def test_the_embedded_detector_needs_no_worker(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("BECKON_HOME", str(tmp_path))
    service = LookService(PeopleSettings(engine="drawn"), lambda _: None)
    assert service.for_pilot is None and "drawn figures" in service.says


def test_a_person_with_looks_and_gaps_crosses_unchanged() -> None:
    (found,) = sticks().look(asked(white_body(640, 480, 320.0, 60.0, 330.0), 0.0, 2.9))
    raw = packed(JobResult(PeopleSeen((found,), 0.1)))[LENGTH.size :]
    told = answer_decoder(LookWorker.look).decode(raw)
    assert isinstance(told, JobResult) and isinstance(told.result, PeopleSeen)
    (back,) = told.result.people
    assert (back.value, back.bearing, back.box, back.centre) == (found.value, found.bearing, found.box, found.centre)
    assert back.looks is not None and found.looks is not None
    assert np.array_equal(back.looks.colours, found.looks.colours, equal_nan=True)
    assert np.array_equal(back.looks.proportions, found.looks.proportions, equal_nan=True)
    assert StoredLooks.of(back.looks).appearance.proportions == pytest.approx(
        found.looks.proportions, nan_ok=True, abs=1e-4
    )
