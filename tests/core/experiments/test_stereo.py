"""Distances by two cameras against the truth, and a slice of a drive in which they hold the robot."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, audio_visual, stereo


def test_distances_of_edges_by_the_pair_are_as_sure_as_they_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stereo, "VIEW_COUNT", 12)
    _, views = stereo.plan(seed=3).batches
    edges, seen = views.work(0)
    error, sd = np.abs(seen).T
    assert edges > len(seen) > 0.4 * edges
    assert np.median(error) < 0.1
    assert np.mean(error <= 2 * sd) > 0.8 and np.mean(error > stereo.WRONG_SDS * sd) < 0.1


@pytest.mark.campaign
def test_a_pair_holds_the_robot_among_glass_where_one_camera_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audio_visual, "MAX_DRIVE_S", 38.0)
    drives, _ = stereo.plan(runs=1, seed=11).batches
    assert stereo.IN[1].name == "glass"
    found: Any = drives.work(1)
    assert found["pair"].mean < 0.5 * found["laser"].mean


def test_the_result_has_every_row_and_the_shares_of_the_distances(monkeypatch: pytest.MonkeyPatch) -> None:
    one = audio_visual.RowErrors(mean=0.2, early=0.1, final=0.3, nees=3.0, apart=0.0)
    monkeypatch.setattr(audio_visual, "drive", lambda *_: {"path": 5.0} | dict.fromkeys(stereo.ROWS, one))
    monkeypatch.setattr(stereo, "look_around", lambda *_: (5, [(0.01, 0.02), (-0.03, 0.02), (0.5, 0.02)]))
    told: Any = EXPERIMENTS["stereo"](runs=1, workers=1)
    assert [place["place"] for place in told["places"]] == [place.name for place in stereo.IN]
    assert list(told["places"][0]["rows"]) == list(stereo.ROWS)
    assert (told["edges"], told["with_distance"], told["median_error_m"]) == (15, 0.6, 0.03)
    assert (told["within_two_sds"], told["wrong"]) == pytest.approx((2 / 3, 1 / 3))
