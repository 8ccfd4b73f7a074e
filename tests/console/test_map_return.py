"""A map that was saved by one console is gone on in by the next."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.console.live import Live

LONG = 60.0  # [s]; the machine may be busy


def post(live: Live, path: str, body: Any) -> int:
    return live.ask("POST", path, body, token=live.operator).status


def test_a_saved_map_survives_the_console_and_is_gone_on_in(tmp_path: Path) -> None:
    with Live(tmp_path) as before:
        before.until(lambda: len(before.runtime.snapshot.landmarks) > 2, LONG)
        assert post(before, "/api/maps", {"name": "lab"}) == 201
    with Live(tmp_path) as after:
        told = after.ask("GET", "/api/maps", token=after.viewer).json
        assert told["current"] is None and [row["name"] for row in told["maps"]] == ["lab"]
        assert post(after, "/api/maps/lab/load", {}) == 202
        after.until(lambda: after.runtime.state().floor.lost, LONG)  # it stands and looks for its place
        assert after.runtime.state().map.name == "lab"
        assert post(after, "/api/slam/here", {"x_m": 0.05, "y_m": -0.05, "heading_rad": 0.05}) == 202
        after.until(lambda: after.runtime.state().floor.lost is None, LONG)
        after.until(lambda: len(after.runtime.snapshot.landmarks) > 2, LONG)
        assert after.runtime.snapshot.estimate.pose.distance_to(0, 0) < 0.1
        assert after.runtime.pilots.failure == ""
