"""Logs of a drive whose laser, clock or speeds are not as the log lets expect: they are read as what they are."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from core.recording import LogSettings, open_log
from tests.benchmarks.recording_variants import MESSAGES, TEXTS, WRITERS, Drive, Writing, beginning, result, simulated


@cache
def drive() -> Drive:
    return beginning(simulated("lab", 3), 28.0)


def estimated(writing: Writing, folder: Path) -> tuple[float, list[str]]:
    """Error [m] of the estimate, and all that was said."""
    truth = np.column_stack([drive().stamps, drive().truth])
    error, _, codes, others, _ = result(writing(drive(), folder, np.random.default_rng(1)), truth)
    assert error is not None
    return error, codes + others


@pytest.mark.parametrize(
    ("variant", "said"),
    [
        ("beams from left to right", "scan.mirrored"),
        ("laser turned by 90 degrees", "mount.turned"),
        ("clock set back by 3 s", "clock.set"),
        ("clock set back by an hour", "clock.set"),
        ("clock set ahead by a day", "clock.set"),
        ("speeds in mm/s", "odometry.speeds"),
        ("turn rates in degrees/s", "odometry.speeds"),
        ("speeds of the wrong sign", "odometry.speeds"),
    ],
)
def test_the_estimate_is_right_and_the_oddity_is_said(variant: str, said: str, tmp_path: Path) -> None:
    error, codes = estimated((TEXTS | MESSAGES)[variant], tmp_path)
    assert codes == [said] and error < 0.06


def test_of_a_sound_log_nothing_is_said(tmp_path: Path) -> None:
    error, codes = estimated(WRITERS["log"], tmp_path)
    assert codes == [] and error < 0.06


def test_a_heading_that_was_set_is_kept(tmp_path: Path) -> None:
    path = TEXTS["laser turned by 90 degrees"](drive(), tmp_path, np.random.default_rng(1))
    recording = open_log(path, LogSettings(mounting_heading=0.1))
    assert recording.laser.mounting.heading == pytest.approx(0.1) and not recording.report.faults


def test_a_log_that_is_there_twice_is_no_clock_that_was_set(tmp_path: Path) -> None:
    assert estimated(TEXTS["the log twice"], tmp_path)[1] == ["clock.begins_again"]
