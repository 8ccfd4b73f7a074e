"""The chessboard over HTTP."""

import numpy as np
import pytest

from tests.console.live import Live

HELD = {
    "what": "board",
    "columns": 9,
    "rows": 6,
    "square_m": 0.03,
    "panel_m": [0.34, 0.25],
    "in_camera": {"rotation": np.eye(3).tolist(), "translation_m": [-0.12, -0.09, 0.6]},
    "seconds": 0.2,
    "holder": True,
}


def test_a_board_is_held_up_moved_and_put_away(live: Live) -> None:
    for pose in ([-0.12, -0.09, 0.6], [-0.1, -0.1, 0.7]):
        wanted = {**HELD, "in_camera": {"rotation": np.eye(3).tolist(), "translation_m": pose}}
        placed = live.ask("POST", "/api/sim/place", wanted, token=live.operator)
        assert placed.status == 201 and placed.json["id"] == "board"
    plan = live.ask("GET", "/api/sim/plan", token=live.viewer).json
    assert {"board", "board's holder"} <= {thing["id"] for thing in plan["things"]}
    assert live.ask("POST", "/api/sim/remove", {"id": "board"}, token=live.operator).status == 200
    assert live.ask("POST", "/api/sim/remove", {"id": "board"}, token=live.operator).status == 422


@pytest.mark.parametrize(
    "change",
    [
        {"columns": 2},
        {"columns": 9.5},
        {"panel_m": [0.1]},
        {"panel_m": [0.1, 0.1]},
        {"seconds": 60},
        {"holder": "yes"},
        {"in_camera": {"rotation": [[1, 0], [0, 1]], "translation_m": [0, 0, 1]}},
        {"in_camera": {"rotation": np.eye(3).tolist()}},
        {"in_camera": {"rotation": np.ones((3, 3)).tolist(), "translation_m": [0, 0, 1]}},
        {"in_camera": {"rotation": np.eye(3).tolist(), "translation_m": [0, 0.5, 1]}},
        {"in_camera": None},
        {"heading_rad": 1.0},
    ],
)
def test_a_board_that_cannot_be_is_refused_with_a_sentence(live: Live, change: dict[str, object]) -> None:
    refused = live.ask("POST", "/api/sim/place", {**HELD, **change}, token=live.operator)
    assert refused.status == 422 and refused.json["detail"]


def test_a_viewer_holds_up_nothing(live: Live) -> None:
    assert live.ask("POST", "/api/sim/place", HELD, token=live.viewer).status == 403
