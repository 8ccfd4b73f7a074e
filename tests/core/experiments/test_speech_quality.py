"""The experiment `speech-quality`: Fig. 17, and figures that fall with noise and distance."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, speech_quality
from core.experiments.speech_quality import Setting, measure, spoken


@pytest.mark.parametrize("sweep", ["noise", "distance"])
def test_the_recordings_get_worse_with_noise_and_distance(sweep: str) -> None:
    said, _ = spoken(np.random.default_rng(0), speech_quality.TEXT[:2])
    places = [
        Setting(sweep=sweep, ratio=ratio, distance=distance)
        for ratio, distance in {
            "noise": ((30, 1.0), (10, 1.0), (0, 1.0)),
            "distance": ((30, 0.3), (30, 1.0), (30, 4.0)),
        }[sweep]
    ]
    told = [measure(None, said, "", place, 0) for place in places]
    assert all(quality is None for quality, _ in told)
    left = [similarity.estoi or 0 for _, similarity in told]
    assert left[0] > left[1] > left[2]


def test_without_words_figure_17_and_the_recordings_remain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speech_quality, "can_speak", lambda: False)
    monkeypatch.setattr(speech_quality, "SETTINGS", speech_quality.SETTINGS[6:8])
    told = EXPERIMENTS["speech-quality"](runs=1, seed=1, out=tmp_path)
    assert (told["figure_17"]["osqe_d"], told["figure_17"]["osqe_r"]) == (-6, 0.5)
    assert "pip install" in told["words_missing"]
    assert len(told["sweep"]) == 2
    assert all(Path(file).stat().st_size for file in told["files"].values())


@pytest.mark.campaign
def test_the_robot_hears_worse_in_more_noise() -> None:
    told = EXPERIMENTS["speech-quality"](seed=0)
    noisy = [row["osqe_d"] for row in told["sweep"] if row["sweep"] == "noise"]
    assert noisy[0] > noisy[-1]
    assert all(after <= before + 2 for before, after in pairwise(noisy))
