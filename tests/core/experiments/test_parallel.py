"""The experiment of what runs in parallel: its steps, and the law that is fitted."""

from typing import Any

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, parallel
from core.experiments.parallel import ParallelStep, serial_share, table


def squares(seed: int) -> list[int]:
    return [seed + number for number in range(3)]


def square(number: int) -> int:
    return number**2


@pytest.mark.parametrize("share", [0.0, 0.2, 1.0])
def test_the_serial_share_is_that_of_amdahl_s_law(share: float) -> None:
    gains = {str(count): 1 / (share + (1 - share) / count) for count in (1, 2, 4, 8)}
    assert serial_share(gains) == pytest.approx(share)
    assert serial_share({"1": 1.0}) is None


def test_every_step_is_measured_and_its_answers_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        parallel,
        "STEPS",
        (
            ParallelStep(
                "calibration",
                "find the board",
                lambda _: [np.zeros((256, 320), np.uint8)],
                parallel.board_corners,
                "",
            ),
            ParallelStep("hearing", "square", squares, square, "a number does not wait for another"),
        ),
    )
    told: Any = EXPERIMENTS["parallel"](runs=2, workers=1)
    step = told["steps"][1]
    assert (step["parts"], step["identical"]) == (3, True) and list(step["workers"]) == ["1"]
    assert step["workers"]["1"]["speed_up"] == step["workers"]["1"]["speed_up_by_work"] == 1.0
    assert "a number does not wait" in told["text"] and f"{told['processors']} processors" in told["text"]
    told["steps"][1]["identical"] = False
    assert "THE ANSWERS DIFFER" in "\n".join(table(told))


@pytest.mark.campaign
def test_every_room_of_the_chapter_has_a_step_with_parts_and_answers_repeat() -> None:
    assert {step.room for step in parallel.STEPS} == {"calibration", "localization", "hearing"}
    voice = parallel.sounds(3)[0]
    assert parallel.azimuth(voice) == parallel.azimuth(voice) is not None
