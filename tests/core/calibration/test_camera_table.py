import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.stats import chi2

from core.calibration.projection import PARAMETERS
from core.experiments import EXPERIMENTS, camera_table
from core.experiments.camera_table import PRINTED_SDS_3
from core.install import install_extra
from core.optics import TABLE_3

run = EXPERIMENTS["camera-table"]


@pytest.mark.campaign
@pytest.mark.parametrize("runs", [1, 3])
def test_table_3_comes_out_again_with_its_figures(tmp_path: Path, runs: int) -> None:
    told: Any = run(runs=runs, seed=1, out=tmp_path)
    rows = told["table"]
    assert [row["paper_value"] for row in rows][:2] == [TABLE_3.fx, TABLE_3.fy]
    for row, printed in zip(rows, PRINTED_SDS_3, strict=True):
        assert abs(row["value"] - row["paper_value"]) < 2 * printed
        assert row["standard_dev"] < 1.5 * printed
    low, high = chi2.ppf((0.001, 0.999), 8 * runs) / runs  # sds stated half as large give four times as much
    assert low < told["nees_mean"] < high
    assert "f_u (pixels)" in told["text"]
    for name in ("figure_13", "figure_14", "figure_15"):
        image = cv2.imread(told["files"][name])
        assert image is not None and image.std() > 10


def test_without_matplotlib_the_table_is_made_and_the_extra_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    told: Any = run(runs=1, out=tmp_path)
    assert len(told["table"]) == 8 and set(told["files"]) == {"runs"}
    assert install_extra("figures") in told["not_drawn"]


@pytest.mark.campaign
def test_forty_calibrations_stay_within_the_papers_column() -> None:
    told: Any = run(runs=40)
    assert 0.90 <= told["within_two_sds_pooled"] <= 0.99
    assert told["f_u_within_printed_share"] >= 0.95
    names = list(told["mean_three_sds"].values())
    assert all(mean <= printed for mean, printed in zip(names, PRINTED_SDS_3, strict=True))


def test_a_calibration_that_frees_k3_is_judged_by_it_too(monkeypatch: pytest.MonkeyPatch) -> None:
    found = SimpleNamespace(
        model=replace(TABLE_3, k3=TABLE_3.k3 + 0.01), sds=dict.fromkeys(PARAMETERS, 1.0), free=PARAMETERS
    )
    found.covariance = np.eye(len(PARAMETERS))
    monkeypatch.setattr(camera_table, "_calibrated", lambda *_: (found, SimpleNamespace(shown=20)))
    assert camera_table.plan(runs=1).batches[0].work(0)["nees"] == pytest.approx(1e-4)
