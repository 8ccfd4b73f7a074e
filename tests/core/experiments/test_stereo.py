"""Distances by two cameras against the truth, and a slice of a drive in which they hold the robot."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, audio_visual, stereo
from core.experiments.audio_visual import PLACES, SENSORS, drive
from core.pipelines.slam import ChosenSensors
from core.settings import Settings


def test_distances_of_edges_by_the_pair_are_as_sure_as_they_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stereo, "VIEW_COUNT", 12)
    (views,) = stereo.plan(seed=3).batches
    edges, seen = views.work(0)
    error, sd, _ = np.array(seen).T
    assert edges > len(seen) > 0.4 * edges
    assert np.median(error) < 0.1
    assert np.mean(error <= 2 * sd) > 0.8 and np.mean(error > stereo.WRONG_SDS * sd) < 0.1


def test_every_room_has_its_row(monkeypatch: pytest.MonkeyPatch) -> None:
    given = [(0.01, 0.02, True), (0.03, 0.02, True), (0.5, 0.02, False)]
    monkeypatch.setattr(stereo, "look_around", lambda *_: (5, given))
    told: Any = EXPERIMENTS["stereo"](runs=2, workers=1)
    assert [one["room"] for one in told["rooms"]] == list(stereo.VIEW_WORLDS)
    assert "60 %" in told["text"] and "3.0 cm" in told["text"]
    for one in told["rooms"]:
        assert (one["edges"], one["with_distance"], one["median_error_m"]) == (10, 0.6, 0.03)
        assert (one["without_laser"], one["within_two_sds"], one["wrong"]) == pytest.approx((2 / 3, 2 / 3, 1 / 3))


@pytest.mark.campaign
def test_a_pair_holds_the_robot_among_glass_where_the_laser_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audio_visual, "MAX_DRIVE_S", 38.0)
    monkeypatch.setattr(
        audio_visual,
        "SENSORS",
        SENSORS | {"pair": ChosenSensors(False, 2, False), "laser + pair": ChosenSensors(True, 2, False)},
    )
    given = Settings()
    given = replace(
        given,
        simulation=replace(given.simulation, second_camera=stereo.BASELINE_M),
        edges=replace(given.edges, by_pair=True),
    )
    glass = next(place for place in PLACES if place.name == "glass")
    found: Any = drive(glass, given, 11, ("laser", "laser + camera", "pair", "laser + pair"))
    assert found["pair"].mean < 0.5 * found["laser"].mean
    assert found["laser + pair"].mean < found["laser"].mean


def test_a_room_without_a_distance_has_no_figures_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stereo, "look_around", lambda *_: (5, []))
    told: Any = EXPERIMENTS["stereo"](runs=1, workers=1)
    assert [(one["with_distance"], one["median_error_m"], one["wrong"]) for one in told["rooms"]] == [
        (0, None, None)
    ] * 3
