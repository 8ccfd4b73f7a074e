"""The pilot's pace is noted by one thread and read by another."""

import gc
import threading
import time
from collections.abc import Iterator

import pytest

from console.robot.pilot_thread import PilotPace


@pytest.fixture
def interrupted() -> Iterator[None]:
    """Every allocation may let the other thread on, as garbage with finalizers does."""

    def pause(phase: str, _: dict[str, int]) -> None:
        if phase == "stop":
            time.sleep(1e-5)

    before = gc.get_threshold()
    gc.callbacks.append(pause)
    gc.set_threshold(1, 1000, 1000)
    yield
    gc.set_threshold(*before)
    gc.callbacks.remove(pause)


def test_the_pace_can_be_read_while_the_pilot_steps(interrupted: None) -> None:
    pace, over = PilotPace(), threading.Event()
    for step in range(400):
        pace.note(float(step), float(step), 0.001)

    def steps() -> None:
        while not over.is_set():
            pace.note(400.0, 400.0, 0.002)

    thread = threading.Thread(target=steps)
    thread.start()
    try:
        for _ in range(200):
            assert pace.measured(400.0)[1] in (1.0, 2.0)
            pace.late_ms(0.5)
    finally:
        over.set()
        thread.join()
