import json
from typing import Any

import numpy as np
import pytest

from console.calibration.answers import ImportedCamera
from console.calibration.solver_worker import SolverWorker
from core.calibration.camera.facts import known_facts
from core.calibration.files.camera_files import camera_entry, ros_yaml
from core.optics import TABLE_3

FREE = ["fx", "fy", "cx", "cy"]
FACTS: dict[str, Any] = {
    "free": FREE,
    "sd": [0.5, 0.5, 0.3, 0.2],
    "covariance": np.diag([0.25, 0.25, 0.09, 0.04]).tolist(),
    "rms_px": 0.2,
    "views_used": 12,
}
BOARD: dict[str, Any] = {"inner_corners": [9, 6], "square_m": 0.03, "panel_m": None}


def text(facts: dict[str, Any], board: dict[str, Any]) -> str:
    return json.dumps({"camera": camera_entry(TABLE_3) | facts, "board": board})


def test_a_camera_that_comes_back_keeps_its_uncertainty_and_its_board() -> None:
    found = SolverWorker().read_file(text(FACTS, BOARD), None)
    assert isinstance(found, ImportedCamera)
    camera = found.document["camera"]
    assert {name: camera.get(name) for name in FACTS} == FACTS
    assert found.document.get("board") == BOARD
    assert found.report.get("sd") == dict(zip(FREE, FACTS["sd"], strict=True))


@pytest.mark.parametrize(
    ("facts", "lost"),
    [
        ({"covariance": [[1.0]]}, {"covariance"}),
        ({"covariance": np.eye(4).tolist()}, {"covariance"}),
        ({"sd": ["a", 1, 2, 3]}, {"free", "sd", "covariance"}),
        ({"free": ["fx", "speed", "cx", "cy"]}, {"free", "sd", "covariance"}),
        ({"free": [["fx"]]}, {"free", "sd", "covariance"}),
        ({"rms_px": -1, "views_used": True}, {"rms_px", "views_used"}),
        ({"views_used": 12.5}, {"views_used"}),
    ],
)
def test_what_is_not_plausible_is_not_kept(facts: dict[str, Any], lost: set[str]) -> None:
    known, _ = known_facts(text(FACTS | facts, BOARD))
    assert set(known) == set(FACTS) - lost


def test_a_board_that_is_none_is_not_kept_and_other_forms_know_nothing() -> None:
    for spoil in ({"square_m": 0}, {"inner_corners": [9.5, 6]}, {"panel_m": [1]}):
        assert known_facts(text(FACTS, BOARD | spoil))[1] is None
    assert known_facts(ros_yaml(TABLE_3)) == ({}, None)


def test_a_board_without_a_panel_and_with_counts_like_9_0_comes_back_whole() -> None:
    given = {"inner_corners": [9.0, 6], "square_m": 0.03, "remark": "on the wall"}
    assert known_facts(text(FACTS, given))[1] == BOARD
