"""A slice of what eyes and ears add: some seconds of one place; the table and the figure from given figures."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, audio_visual, audio_visual_recorded
from core.experiments.audio_visual import PLACES, SENSORS, drive, seen_by, table
from core.settings import Settings, as_printed
from core.simulation.world import world_named

CORRIDOR = next(place for place in PLACES if place.name == "corridor")


@pytest.mark.campaign
def test_edges_hold_the_robot_in_a_corridor_without_corners(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audio_visual, "MAX_DRIVE_S", 7.0)
    found: dict[str, Any] = drive(CORRIDOR, Settings(), 1, ("laser", "laser + camera"))
    assert found["path"] > 0.8
    assert found["laser + camera"].mean < 0.5 * found["laser"].mean
    assert found["laser + camera"].nees < 6


def test_every_place_says_why_the_laser_is_weak_and_can_be_driven() -> None:
    assert sum(bool(place.weak) for place in PLACES) >= 4
    for place in PLACES:
        world = world_named(place.world)
        for x, y in place.goals:
            assert world.free(x, y, 0.15), (place.name, x, y)
        assert world.open_air(np.array([[*place.speaker, 1.55]])), place.name


def test_glass_lets_the_laser_through_and_stops_the_robot() -> None:
    glass = world_named("glass")
    assert len(glass.laser_surfaces(0.12).faces) < len(glass.surfaces(0.12).faces)
    assert len(glass.obstacles.faces) == len(glass.walls)
    lab = world_named("lab")
    assert len(lab.laser_surfaces(0.12).faces) == len(lab.surfaces(0.12).faces)


def test_as_printed_there_are_corners_alone() -> None:
    printed = as_printed(Settings())
    assert not (printed.edges.on_walls or printed.edge_landmarks.used or printed.voice_landmarks.used)


def test_the_table_has_every_place_and_every_row(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    one = audio_visual.RowErrors(mean=0.2, early=0.1, final=0.3, nees=3.0, apart=0.0)
    half = replace(one, mean=0.1)

    def given(*_: object) -> dict[str, Any]:
        return {"path": 5.0} | {name: half if "camera" in name else one for name in SENSORS}

    monkeypatch.setattr(audio_visual, "drive", given)
    result = EXPERIMENTS["audio-visual"](runs=1, workers=1, out=tmp_path)
    assert [each["place"] for each in result["places"]] == [place.name for place in PLACES]
    assert result["places"][0]["rows"]["laser + camera"]["of_laser"] == pytest.approx(0.5)
    assert all(name in result["text"] for name in SENSORS)
    assert (tmp_path / "audio_visual.json").exists()
    assert table(result["places"], 1, 0) == result["text"]


def test_a_row_without_the_laser_gets_no_scan() -> None:
    from core.simulation.robot import SimulatedRobot

    robot = SimulatedRobot("lab", settings=Settings().simulation)
    frames = [robot.read() for _ in range(8)]
    scan = next(frame for frame in frames if frame.scan is not None)
    assert seen_by(scan, SENSORS["camera"], 9.0).scan is None
    short = seen_by(scan, SENSORS["laser"], 3.0).scan
    assert short is not None and np.nanmax(short.ranges) <= 3.0


def test_a_recorded_drive_is_estimated_with_every_choice_of_sensors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audio_visual, "MAX_DRIVE_S", 3.2)
    monkeypatch.setattr(audio_visual, "REST_BEFORE_S", 1.0)
    found = audio_visual_recorded.recorded_drive((CORRIDOR,), Settings(), 1, 1, 0)
    assert set(found["errors"]) == set(SENSORS)
    assert 0.2 < found["megabytes"] < 5
    assert all(0 <= one["mean_m"] <= one["worst_m"] < 0.2 for one in found["errors"].values())
    monkeypatch.setattr(audio_visual_recorded, "recorded_drive", lambda *_: found)
    told: Any = EXPERIMENTS["audio-visual-recorded"](runs=2, workers=1)
    assert [one["place"] for one in told["places"]] == ["lab", "corridor", "bare corridor", "glass"]
    assert told["places"][0]["rows"]["laser"]["of_laser"] == 1.0
    assert "bare corridor" in told["text"] and "100 %" in told["text"]
