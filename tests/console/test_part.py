"""Parts: what the runtime does with every capability, whichever it is."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from console.calibration.microphones import MicrophoneCalibration
from console.calibration.service import CalibrationService
from console.capabilities import CAPABILITIES
from console.control.pending_commands import PendingCommands
from console.maps.service import MapService
from console.part import Part, Parts
from console.people.service import EnrollmentService
from console.speech.room_transcription import RoomTranscriber
from core.sensors import SensorFrame
from tests.console.live import Live


class Recorded(Part):
    """Writes down what the runtime does with it."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def __getattribute__(self, name: str) -> Any:
        if name in vars(Part):
            self.calls.append(name)
        return super().__getattribute__(name)


class Numbered(Part):
    def __init__(self, number: int) -> None:
        self.number = number

    def calibrated(self, profile: Any) -> Any:
        return [*profile, self.number]


def test_the_robot_is_seen_through_every_part_in_their_order() -> None:
    parts = Parts()
    for number in range(3):
        parts.add(Numbered(number))
    assert parts.calibrated(cast(Any, [])) == [0, 1, 2]
    assert parts[Numbered].number == 0
    with pytest.raises(KeyError):
        parts[Recorded]


def test_a_part_is_opened_run_fed_and_closed_without_a_line_in_the_runtime(tmp_path: Path) -> None:
    live = Live(tmp_path)
    part = live.runtime.parts.add(Recorded())
    with live:
        live.until(lambda: {"open", "run", "on_snapshot", "tick", "calibrated", "equip"} <= set(part.calls))
        assert "close" not in part.calls
    assert part.calls[-1] == "close" and part.calls.index("open") < part.calls.index("on_snapshot")


def test_maps_see_a_snapshot_before_people_and_people_before_what_waits_and_that_before_words(tmp_path: Path) -> None:
    kinds = [type(part) for part in Live(tmp_path).runtime.parts]
    assert len(kinds) >= len(CAPABILITIES) and len(set(kinds)) == len(kinds)
    order = (
        CalibrationService,
        MicrophoneCalibration,
        MapService,
        EnrollmentService,
        PendingCommands,
        RoomTranscriber,
    )
    assert sorted(order, key=kinds.index) == list(order)


def test_a_part_that_overrides_nothing_does_nothing() -> None:
    part, profile = Part(), cast(Any, SimpleNamespace())
    part.on_snapshot(cast(Any, None), SensorFrame(stamp=0.0))
    part.tick(0.0)
    assert part.calibrated(profile) is profile and part.leave_out("why") == []
    asyncio.run(part.open())
    asyncio.run(part.close())
