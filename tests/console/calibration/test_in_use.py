"""The calibration in use: accepted, used by the pilot, taken back, read from a file; never lost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from core.calibration.camera_files import kalibr_yaml, ros_yaml
from core.optics import TABLE_3
from tests.console.calibration.wizard import Wizard
from tests.console.live import Live

TEXT = {"Content-Type": "text/plain"}
NEAR = replace(TABLE_3, fx=305.0)


@pytest.fixture
def live(tmp_path: Path) -> Iterator[Live]:
    with Live(tmp_path) as live:
        yield live


def in_use(live: Live) -> dict[str, object]:
    return live.ask("GET", "/api/calibration/in-use", token=live.viewer).json


def bring(live: Live, text: str) -> int:
    return live.ask("POST", "/api/calibration/import", raw=text.encode(), headers=TEXT, token=live.operator).status


def undo(live: Live, kind: str = "camera") -> int:
    return live.ask("POST", "/api/calibration/in-use/undo", {"kind": kind}, token=live.operator).status


def seen_with(live: Live) -> float:
    """Focal length that the pilot uses now."""
    pilot = live.runtime._pilot
    assert pilot is not None
    return pilot.pilot._eyes.camera.model.fx


def notices(live: Live) -> str:
    return " ".join(told.text for told in live.runtime.board.shown)


def test_what_is_accepted_is_used_at_once_and_after_a_restart_and_can_be_taken_back(
    live: Live, tmp_path: Path
) -> None:
    assert in_use(live) == {"camera": None, "laser": None} and seen_with(live) == TABLE_3.fx
    assert undo(live) == 409
    wizard = Wizard(live)
    wizard.show(14)
    fx = wizard.solved()["solution"]["fx"]
    report = wizard.post("accept", {"anyway": True})
    assert report.status == 200 and report.json["fx"] == fx
    assert wizard.told["accepted_s"] > 0
    assert in_use(live)["camera"]["fx"] == fx and seen_with(live) == fx
    assert bring(live, ros_yaml(NEAR)) == 200
    assert seen_with(live) == NEAR.fx
    assert Wizard(live, "laser", "robot").told["kind"] == "laser"
    with Live(tmp_path) as next_one:
        assert seen_with(next_one) == NEAR.fx
    assert undo(live) == 200 and seen_with(live) == fx
    assert undo(live) == 200 and seen_with(live) == TABLE_3.fx
    assert in_use(live)["camera"] is None
    kept = list((tmp_path / "calibration").glob("camera-taken-back-*.json"))
    assert len(kept) == 2


def test_a_camera_of_another_size_is_kept_but_not_used_and_the_person_is_told(live: Live) -> None:
    other = replace(TABLE_3, width=640, height=480, cx=320.0, cy=240.0)
    assert bring(live, kalibr_yaml(other)) == 200
    assert seen_with(live) == TABLE_3.fx
    assert "640x480" in notices(live) and "320x256" in notices(live)
    laser = {"kind": "laser", "board": {"columns": 9, "rows": 6, "square_m": 0.03}, "source": "robot"}
    refused = live.ask("POST", "/api/calibration/sessions", laser, token=live.operator)
    assert refused.status == 409 and "another size" in refused.json["detail"]


def test_a_laser_without_a_calibrated_camera_is_refused_in_words(live: Live) -> None:
    laser = {"kind": "laser", "board": {"columns": 9, "rows": 6, "square_m": 0.03}, "source": "robot"}
    refused = live.ask("POST", "/api/calibration/sessions", laser, token=live.operator)
    assert refused.status == 409 and "camera first" in refused.json["detail"]


@pytest.mark.parametrize(
    "text",
    ["", "{", "words", '{"camera": {"K": [[NaN]]}}', "a: &a [1]\nb: *a", "fx: 1\n" * 100_000, "[" * 100_000],
    ids=lambda text: repr(text[:20]),
)
def test_what_is_no_camera_file_is_refused_and_changes_nothing(shared_live: Live, text: str) -> None:
    assert bring(shared_live, text) == 422
    assert in_use(shared_live)["camera"] is None


def test_a_damaged_calibration_is_not_used_and_not_touched(tmp_path: Path) -> None:
    path = tmp_path / "calibration" / "camera.json"
    path.parent.mkdir()
    path.write_text('{"camera": {"K": 1}}')
    with Live(tmp_path) as live:
        assert in_use(live)["camera"] is None and seen_with(live) == TABLE_3.fx
        assert "camera.json cannot be used" in notices(live)
    assert path.read_text() == '{"camera": {"K": 1}}'
