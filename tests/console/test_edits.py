"""Map editing over REST: what is edited stays so, also after a restart, and is taken back to the bit."""

import io
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.backup import restore_backup, write_backup
from core.pipelines.nav2_map import Nav2Cells, read_nav2_map
from tests.console.live import Live

LONG_S = 60.0


def call(live: Live, method: str, path: str, body: Any = None, *, status: int = 200) -> Any:
    answer = live.ask(method, path, body, token=live.operator)
    assert answer.status == status, answer.body
    return answer.json if answer.body else None


def cells(live: Live, path: str = "/api/map") -> Nav2Cells:
    with zipfile.ZipFile(io.BytesIO(live.ask("GET", path, token=live.viewer).body)) as box:
        return read_nav2_map(box.read("map.yaml"), box.read("map.pgm"))


def at(map_: Nav2Cells, x: float, y: float) -> int:
    column, row = np.floor((np.array([x, y]) - map_.origin[:2]) / map_.resolution).astype(int)
    return int(map_.values[row, column])


SQUARE_M = [[0.3, -0.2], [0.7, -0.2], [0.7, 0.2], [0.3, 0.2]]


def settled(live: Live) -> None:
    live.until(
        lambda: not live.runtime.snapshot.slam.looking_around and live.runtime.snapshot.floor.lost is None, LONG_S
    )


def test_edits_hold_until_they_are_taken_back(live: Live) -> None:
    edit_and_take_back(live)
    call(live, "POST", "/api/map/edits/back", {"version": 0})
    call(live, "DELETE", "/api/places/bureau", status=204)
    call(live, "DELETE", "/api/maps/edited", status=204)


def edit_and_take_back(live: Live) -> None:
    settled(live)
    call(live, "POST", "/api/maps", {"name": "edited"}, status=201)
    assert at(cells(live), 0.5, 0.0) == 0
    made = call(live, "POST", "/api/map/edits", {"kind": "occupied", "points_m": SQUARE_M}, status=201)
    assert made["id"] == 1 and made["holds"] and made["by"] == "operator"
    live.until(lambda: at(cells(live), 0.5, 0.0) == 100)
    stroke = {"kind": "unknown", "points_m": [[0.4, 0.0], [0.6, 0.0]], "width_m": 0.2}
    call(live, "POST", "/api/map/edits", stroke, status=201)
    live.until(lambda: at(cells(live), 0.5, 0.0) == -1)
    blocked = live.ask("POST", "/api/commands", {"text": "stop at 0.65 and 0.15"}, token=live.operator)
    assert blocked.status in (202, 409)
    live.until(lambda: live.runtime.snapshot.active_command is None)
    told = call(live, "POST", "/api/map/edits/undo", {})
    assert told["version"] == 1 and [one["holds"] for one in told["edits"]] == [True, False]
    live.until(lambda: at(cells(live), 0.5, 0.0) == 100)
    assert call(live, "POST", "/api/map/edits/redo", {})["version"] == 2
    assert call(live, "POST", "/api/map/edits/back", {"version": 0})["version"] == 0
    live.until(lambda: at(cells(live), 0.5, 0.0) == 0)
    call(live, "POST", "/api/map/edits/undo", {}, status=409)
    call(live, "POST", "/api/map/edits/undo", {"id": 9}, status=404)
    assert call(live, "POST", "/api/map/edits/redo", {"id": 1})["version"] == 1
    live.until(lambda: at(cells(live), 0.5, 0.0) == 100)
    assert at(cells(live, "/api/maps/edited.zip"), 0.5, 0.0) == 100, "what is taken away shows the edits"
    for wrong in (
        {"kind": "free", "points_m": SQUARE_M[:2]},
        {"kind": "free", "points_m": SQUARE_M, "width_m": -1},
        {"kind": "turn", "angle_rad": 0.0},
        {"kind": "turn", "angle_rad": 9.0},
        {"kind": "odd", "points_m": SQUARE_M},
    ):
        call(live, "POST", "/api/map/edits", wrong, status=422)
    room = call(
        live, "POST", "/api/places", {"name": "bureau", "outline_m": [[-1, -1], [1, -1], [1, 1], [-1, 1]]}, status=201
    )
    assert len(room["outline_m"]) == 4 and abs(room["x_m"]) < 1 and at(cells(live), room["x_m"], room["y_m"]) == 0


@pytest.mark.campaign
def test_edits_survive_a_restart_and_a_restore(tmp_path: Path) -> None:
    home, elsewhere = tmp_path / "one", tmp_path / "two"
    home.mkdir()
    with Live(home) as live:
        edit_and_take_back(live)
    write_backup(home, tmp_path / "kept.tar")
    restore_backup(tmp_path / "kept.tar", elsewhere)
    for folder in (home, elsewhere):
        with Live(folder) as live:
            settled(live)
            assert call(live, "GET", "/api/map/edits")["edits"] == []
            call(live, "POST", "/api/maps/edited/load", {}, status=202)
            live.until(lambda live=live: at(cells(live), 0.5, 0.0) == 100, LONG_S)
            assert call(live, "GET", "/api/map/edits")["version"] == 1


@pytest.mark.campaign
def test_a_turn_moves_the_axes_with_all_places_and_is_kept_with_the_map(tmp_path: Path) -> None:
    with Live(tmp_path) as live:
        settled(live)
        call(live, "POST", "/api/places", {"name": "desk", "x_m": 1.0, "y_m": 0.0}, status=201)
        call(live, "POST", "/api/maps", {"name": "edited"}, status=201)
        before = live.runtime.snapshot.grid
        call(live, "POST", "/api/map/edits", {"kind": "turn", "angle_rad": 0.5}, status=201)
        (desk,) = live.until(lambda: (told := call(live, "GET", "/api/places")["places"])[0]["y_m"] > 0.4 and told)
        assert math.isclose(desk["x_m"], math.cos(0.5), abs_tol=0.01)
        assert abs(live.runtime.snapshot.estimate.pose.heading - 0.5) < 0.1
        assert call(live, "POST", "/api/map/edits/undo", {})["version"] == 0
        live.until(lambda: abs(call(live, "GET", "/api/places")["places"][0]["y_m"]) < 0.01)
        assert live.runtime.snapshot.grid.log_odds.shape == before.log_odds.shape
        call(live, "POST", "/api/map/edits/redo", {})
    with Live(tmp_path) as live:
        settled(live)
        call(live, "POST", "/api/maps/edited/load", {}, status=202)
        live.until(
            lambda: live.runtime.state().map.name == "edited" and call(live, "GET", "/api/map/edits")["version"] == 1
        )
        (desk,) = live.until(lambda: call(live, "GET", "/api/places")["places"])
        assert math.isclose(desk["y_m"], math.sin(0.5), abs_tol=0.02)
