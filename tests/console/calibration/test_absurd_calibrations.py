"""No calibration, however absurd, takes the pilot away for longer than its next start."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.calibration.calibration_store import CalibrationStore
from console.calibration.service import CalibrationService
from core.calibration.files.camera_files import ros_yaml
from core.calibration.files.mount_files import both_ways
from core.calibration.reports import kept as kept_form
from core.geometry import OPTICAL, Transform
from core.optics import TABLE_3
from core.pilot import Pilot
from core.sensors import SensorFrame
from core.snapshot import Snapshot
from tests.console.live import Live

TEXT = {"Content-Type": "text/plain"}
REFUSED: list[dict[str, float]] = [{"k1": -1.0}, {"k1": 1e9}, {"fx": 1e7, "fy": 1e7}]
STRANGE: list[dict[str, float]] = [{"k1": 5.0}, {"fx": 1.0, "fy": 1.0}]  # no lens either, but the way back is there
UP = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]) @ OPTICAL


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Live]:
    with Live(tmp_path) as live:
        keep_warm(live)
        yield live


def keep_warm(live: Live) -> None:
    """The worker that reads files is not ended between two of them, which would take a second each time."""
    live.runtime.parts[CalibrationService].tick = lambda now: None  # type: ignore[method-assign]


def bring(live: Live, text: str) -> int:
    return live.ask("POST", "/api/calibration/import", raw=text.encode(), headers=TEXT, token=live.operator).status


def sees_on(live: Live) -> bool:
    """Whether the pilot works on frames that come from now on, for long enough to have looked at a picture."""
    stamp = live.runtime.snapshot.stamp
    live.until(lambda: live.runtime.snapshot.stamp > stamp + 0.3 or live.runtime.pilots.failure)
    return live.ask("GET", "/api/health").status == 200


@pytest.mark.campaign
def test_absurd_cameras_are_refused_or_used_and_the_console_stays_well(lab: Live) -> None:
    for change in [*REFUSED, *STRANGE]:
        text = ros_yaml(replace(TABLE_3, **change), crop=False)
        assert bring(lab, text) == (200 if change in STRANGE else 422), change
        assert sees_on(lab), change


def test_absurd_mounts_are_refused_or_left_out_and_the_console_stays_well(lab: Live) -> None:
    assert bring(lab, ros_yaml(replace(TABLE_3, fx=7000.0, fy=7000.0, k1=0.0, k2=0.0))) == 200
    away = Transform(rotation=OPTICAL, translation=np.array([1e9, 0.0, 0.0]))
    assert bring(lab, json.dumps(both_ways(away))) == 422
    upwards = Transform(rotation=UP, translation=np.array([0.0, 0.0, 0.1]))
    assert bring(lab, json.dumps(both_ways(upwards))) == 200
    told = lab.ask("GET", "/api/calibration/in-use", token=lab.viewer).json["laser"]
    assert "looks across the floor" in told["not_used"]
    assert sees_on(lab)


def test_an_absurd_camera_that_lies_on_the_disk_is_named_and_not_used(tmp_path: Path) -> None:
    folder = tmp_path / "calibration"
    CalibrationStore(folder).put("camera", kept_form(TABLE_3), {}, "someone")
    file = folder / "camera.json"
    document = json.loads(file.read_text())
    document["camera"]["dist"][0] = -1.0
    file.write_text(json.dumps(document))
    with Live(tmp_path) as live:
        assert sees_on(live)
        assert any("camera.json" in notice.text for notice in live.runtime.notifications.shown)
    assert file.exists()


class Squeamish(Pilot):
    """The real pilot, which fails at the first picture of a camera with a focal length of its dislike."""

    dislikes = 305.0

    def step(self, frame: SensorFrame, *, deaf: bool = False) -> Snapshot:
        camera: Any = self._vision.camera
        if camera.model.fx == self.dislikes:
            raise MemoryError
        return super().step(frame, deaf=deaf)


def test_a_pilot_that_fails_with_a_calibration_starts_again_without_it_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "console.control.pilot_supervisor.RESTART_PAUSE_S", 0.5
    )  # a reading every 10 ms sees it, on a busy machine too
    live = Live(tmp_path, make_pilot=lambda: Squeamish(live.robot.profile))
    with live:
        keep_warm(live)
        for _ in range(4):  # as often as anybody likes: never "stays off"
            assert bring(live, ros_yaml(replace(TABLE_3, fx=Squeamish.dislikes))) == 200
            live.until(lambda: live.runtime.pilots.failure)
            live.until(lambda: live.ask("GET", "/api/health").status == 200)
            assert sees_on(live)
        told = live.ask("GET", "/api/calibration/in-use", token=live.viewer).json["camera"]
        assert "failed" in told["not_used"]
        assert any("camera.json" in notice.text for notice in live.runtime.notifications.shown)
    again = Live(tmp_path, make_pilot=lambda: Squeamish(again.robot.profile))
    with again:
        again.until(lambda: any("camera.json" in notice.text for notice in again.runtime.notifications.shown))
        again.until(lambda: again.ask("GET", "/api/health").status == 200)
        assert sees_on(again)


def test_a_pilot_that_cannot_even_be_made_is_told_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("console.control.pilot_supervisor.RESTART_PAUSE_S", 0.1)
    broken = [True, False, True]  # at the start of the console, then when it starts again after a failure

    def make() -> Pilot:
        if broken.pop():
            raise MemoryError
        return Pilot(live.robot.profile)

    live = Live(tmp_path, make_pilot=make)
    with live:
        assert sees_on(live)
        live.on_loop(lambda: live.runtime.pilots.bury("test"))
        live.until(lambda: not broken and live.runtime.pilots.failure)
        broken.append(False)
        live.until(lambda: live.ask("GET", "/api/health").status == 200)
        assert sees_on(live)
