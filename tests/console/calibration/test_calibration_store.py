"""The calibration in use: accepted, used by the pilot, taken back, read from a file; never lost."""

import asyncio
import errno
import json
import re
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest

from console.api.reports import clock
from console.calibration.apply import calibrated, laser_in, nominal_mount
from console.calibration.calibration_store import CalibrationStore
from console.calibration.service import CalibrationService
from console.calibration.solver_worker import imported_camera
from core.calibration.files.camera_files import kalibr_yaml, ros_yaml
from core.calibration.files.mount_files import FORWARD, both_ways, matrix, static_transform, urdf_joint
from core.calibration.reports import kept as kept_form
from core.errors import Unwritable
from core.files import SEAL
from core.geometry import OPTICAL, Transform
from core.message import Array
from core.optics import TABLE_3
from core.sensors import Camera
from core.sentences import code_of
from tests.console.calibration.wizard import Wizard
from tests.console.live import Live

TEXT = {"Content-Type": "text/plain"}
NEAR = replace(TABLE_3, fx=305.0)


def active(live: Live) -> Any:
    return live.ask("GET", "/api/calibration/in-use", token=live.viewer).json


def bring(live: Live, text: str) -> int:
    return live.ask("POST", "/api/calibration/import", raw=text.encode(), headers=TEXT, token=live.operator).status


def undo(live: Live, kind: str = "camera") -> int:
    return live.ask("POST", "/api/calibration/in-use/undo", {"kind": kind}, token=live.operator).status


def camera_of_next_frame(live: Live) -> Camera:
    """The camera with which the pilot sees from its next frame on."""
    pilot, snapshot = live.runtime.pilots.thread, live.runtime.snapshot
    assert pilot is not None and snapshot is not None
    live.until(lambda: live.runtime.snapshot.stamp > snapshot.stamp + 0.05)
    return pilot.pilot._vision.camera


def seen_with(live: Live) -> float:
    """Focal length that the pilot uses now."""
    return camera_of_next_frame(live).model.fx


def mounting(live: Live) -> Array:
    """Where the pilot's camera sits on the robot [m]."""
    return camera_of_next_frame(live).mounting.translation


def notices(live: Live) -> str:
    return " ".join(told.text for told in live.runtime.notifications.shown)


def home(live: Live) -> Path:
    return live.runtime.parts[CalibrationService]._home


def test_what_is_accepted_is_used_at_once_and_after_a_restart_and_can_be_taken_back(bench: Live) -> None:
    live = bench
    assert active(live) == {"camera": None, "laser": None} and seen_with(live) == TABLE_3.fx
    assert undo(live) == 409
    wizard = Wizard(live)
    wizard.show(14)
    fx = wizard.solved()["solution"]["fx"]
    report = wizard.post("accept", {"force": True})
    assert report.status == 200 and report.json["fx"] == fx
    assert wizard.told["accepted_s"] > 0
    assert active(live)["camera"]["fx"] == fx and seen_with(live) == fx
    assert active(live)["camera"]["former"] is False  # taking it back would bring the nominal values
    document = live.ask("GET", "/api/reports/calibration/camera", token=live.viewer).body.decode()
    assert f"<td>accepted</td><td>{clock(active(live)['camera']['accepted_s'])}</td>" in document
    german = live.ask("GET", "/api/reports/calibration/camera?language=de", token=live.viewer).body.decode()
    assert re.search(r"<td>fx</td><td>Brennweite, waagrecht</td><td>\d+\.\d+</td><td>±", german)
    assert bring(live, ros_yaml(NEAR)) == 200
    assert seen_with(live) == NEAR.fx and active(live)["camera"]["former"] is True
    assert Wizard(live, "laser", "robot").told["kind"] == "laser"
    after_a_restart = CalibrationStore(home(live))
    after_a_restart.open()
    profile, reasons = calibrated(live.robot.profile, after_a_restart)
    assert profile.camera is not None and profile.camera.model.fx == NEAR.fx and reasons == {}
    assert (after_a_restart.report("camera") or {})["former"] is True
    assert undo(live) == 200 and seen_with(live) == fx and active(live)["camera"]["former"] is False
    assert undo(live) == 200 and seen_with(live) == TABLE_3.fx
    assert active(live)["camera"] is None
    assert len(list(home(live).glob("camera-taken-back-*.json"))) == 2


@pytest.mark.campaign
def test_who_accepts_while_it_is_solved_anew_gets_the_new_solution(bench: Live) -> None:
    wizard = Wizard(bench)
    wizard.show(14)
    first = wizard.solved()
    worst = quote(first["views"][0]["name"])
    for what, fewer in (("drop", 1), ("restore", 0)):
        assert wizard.post(f"views/{worst}/{what}").status == 200
        report = wizard.post("accept", {"force": True})
        assert report.status == 200, report.body
        assert report.json["views_used"] == first["solution"]["views_used"] - fewer
    assert report.json["fx"] == pytest.approx(first["solution"]["fx"])
    assert undo(bench) == 200 and undo(bench) == 200


def test_a_camera_of_another_size_is_kept_but_not_used_and_the_person_is_told(bench: Live) -> None:
    laser = {"kind": "laser", "board": {"columns": 9, "rows": 6, "square_m": 0.03}, "source": "robot"}
    refused = bench.ask("POST", "/api/calibration/sessions", laser, token=bench.operator)
    assert refused.status == 409 and "camera first" in refused.json["detail"]
    other = replace(TABLE_3, width=640, height=480, cx=320.0, cy=240.0)
    assert bring(bench, kalibr_yaml(other)) == 200
    assert seen_with(bench) == TABLE_3.fx
    assert "640x480" in notices(bench) and "320x256" in notices(bench)
    assert "640x480" in active(bench)["camera"]["not_used"]
    refused = bench.ask("POST", "/api/calibration/sessions", laser, token=bench.operator)
    assert refused.status == 409 and "another size" in refused.json["detail"]
    assert undo(bench) == 200


def test_a_mount_reaches_the_pilot_as_long_as_the_camera_is_the_one_it_was_found_through(bench: Live) -> None:
    built = bench.robot.profile
    assert built.camera is not None
    mount = Transform(rotation=nominal_mount(built).rotation, translation=np.array([0.01, 0.02, 0.07]))
    whole = kept_form(TABLE_3) | {"extrinsics": {FORWARD: matrix(mount).tolist()}}
    report = {"rotation": mount.rotation.tolist(), "translation_m": mount.translation.tolist()}
    using = bench.runtime.parts[CalibrationService].use("laser", whole, report, "operator")
    asyncio.run_coroutine_threadsafe(using, bench.loop).result(10)
    found = (laser_in(built) @ mount).translation
    assert np.allclose(mounting(bench), found) and not np.allclose(found, built.camera.mounting.translation)
    assert active(bench)["laser"]["not_used"] == ""
    assert bring(bench, ros_yaml(replace(TABLE_3, fx=TABLE_3.fx + 0.5))) == 200
    assert np.allclose(mounting(bench), found)
    assert bring(bench, ros_yaml(replace(TABLE_3, cx=TABLE_3.cx + 9))) == 200
    assert np.allclose(mounting(bench), built.camera.mounting.translation)
    assert "Calibrate the laser again" in notices(bench)
    assert "another camera calibration, 9.0 px" in active(bench)["laser"]["not_used"]
    assert undo(bench) == undo(bench) == 200
    assert np.allclose(mounting(bench), found)
    assert undo(bench, "laser") == 200
    assert np.allclose(mounting(bench), built.camera.mounting.translation)


def test_a_camera_file_with_an_odd_board_and_a_mount_file_with_an_odd_entry_do_no_harm(bench: Live) -> None:
    document = dict(kept_form(TABLE_3))
    odd = {"inner_corners": [9.0, 6.0], "square_m": 0.03}
    document["camera"] = dict(document["camera"]) | {"views_used": 3.5, "rms_px": 1}  # type: ignore[call-overload]
    assert bring(bench, json.dumps(document | {"board": odd})) == 200
    assert seen_with(bench) == TABLE_3.fx and undo(bench) == 200
    ways = {**both_ways(nominal_mount(bench.robot.profile))}
    assert bring(bench, json.dumps(dict(kept_form(TABLE_3)) | ways | {"extrinsics": [1]})) == 422
    assert active(bench)["laser"] is None


@pytest.mark.parametrize(
    "text",
    ["", "{", "words", '{"camera": {"K": [[NaN]]}}', "a: &a [1]\nb: *a", "fx: 1\n" * 100_000, "[" * 100_000],
    ids=lambda text: repr(text[:20]),
)
def test_what_is_no_camera_file_is_refused_and_changes_nothing(bench: Live, text: str) -> None:
    assert bring(bench, text) == 422
    assert active(bench)["camera"] is None


def test_a_damaged_calibration_is_not_used_and_not_touched(tmp_path: Path) -> None:
    path = tmp_path / "calibration" / "camera.json"
    path.parent.mkdir()
    path.write_text('{"camera": {"K": 1}}')
    kept = CalibrationStore(path.parent)
    kept.open()
    assert kept.camera is None and kept.report("camera") is None
    assert "camera.json cannot be used" in kept.troubles[0]
    assert path.read_text() == '{"camera": {"K": 1}}'


def document(fx: float) -> Any:
    return kept_form(replace(TABLE_3, fx=fx))


def accepted(folder: Path, *lengths: float) -> CalibrationStore:
    kept = CalibrationStore(folder)
    for fx in lengths:
        kept.put("camera", document(fx), {"fx": fx}, "someone")
    return kept


def as_restarted(folder: Path) -> float:
    """Focal length of the camera that the next console finds."""
    kept = CalibrationStore(folder)
    kept.open()
    assert kept.camera is not None
    return kept.camera.fx


def test_a_disk_that_is_full_costs_nothing_that_was_in_use(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = accepted(tmp_path, 301.0, 302.0)

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(Unwritable, match="No space left"):
        kept.put("camera", document(303.0), {"fx": 303.0}, "someone")
    assert kept.camera is not None and kept.camera.fx == as_restarted(tmp_path) == 302.0
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".json", ".json"]


def test_a_crash_while_accepting_or_taking_back_leaves_a_calibration_in_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = accepted(tmp_path, 301.0, 302.0)

    def stop(*_: object) -> None:
        raise OSError(errno.EIO, "Input/output error")

    with monkeypatch.context() as broken:
        broken.setattr(Path, "replace", stop)
        with pytest.raises(Unwritable, match="could not be saved"):
            kept.put("camera", document(303.0), {"fx": 303.0}, "someone")
        with pytest.raises(Unwritable, match="could not be taken back"):
            kept.undo("camera")
    assert kept.camera is not None and kept.camera.fx == as_restarted(tmp_path) == 302.0


def test_a_damaged_former_is_passed_over_and_the_one_before_it_is_taken_back(tmp_path: Path) -> None:
    kept = accepted(tmp_path, 301.0, 302.0, 303.0)
    damaged = sorted(tmp_path.glob("camera-2*.json"), key=lambda path: path.stem)[-1]
    damaged.write_text("{")
    kept.undo("camera")
    assert kept.camera is not None and kept.camera.fx == as_restarted(tmp_path) == 301.0
    assert damaged.read_text() == "{"
    kept.undo("camera")
    assert kept.camera is None and not (tmp_path / "camera.json").exists()


def test_a_former_of_a_clock_that_was_never_set_is_taken_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = SimpleNamespace(time=time.time, strftime=time.strftime, gmtime=lambda: time.gmtime(60.0))
    monkeypatch.setattr("console.calibration.calibration_store.time", clock)
    kept = accepted(tmp_path, 301.0, 302.0)
    kept.undo("camera")
    assert kept.camera is not None and kept.camera.fx == as_restarted(tmp_path) == 301.0


def test_the_former_of_a_clock_that_was_set_back_is_taken_back_before_one_of_a_later_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = accepted(tmp_path, 301.0, 302.0)
    clock = SimpleNamespace(time=time.time, strftime=time.strftime, gmtime=lambda: time.gmtime(60.0))
    monkeypatch.setattr("console.calibration.calibration_store.time", clock)
    kept.put("camera", document(303.0), {"fx": 303.0}, "someone")
    for former in (302.0, 301.0):
        kept.undo("camera")
        assert kept.camera is not None and kept.camera.fx == as_restarted(tmp_path) == former


def test_a_digit_that_changed_after_it_was_saved_is_told_and_not_used(tmp_path: Path) -> None:
    accepted(tmp_path, 510.0)
    path = tmp_path / "camera.json"
    path.write_text(path.read_text().replace("510.0", "910.0"))
    kept = CalibrationStore(tmp_path)
    kept.open()
    assert kept.camera is None
    (trouble,) = kept.troubles
    assert "camera.json cannot be used: It was changed after it was saved" in trouble and SEAL in trouble


def test_a_file_that_someone_wrote_by_hand_is_used_and_counts_as_not_verified(tmp_path: Path) -> None:
    accepted(tmp_path, 510.0)
    path = tmp_path / "camera.json"
    own = {key: value for key, value in json.loads(path.read_text()).items() if key != SEAL}
    path.write_text(json.dumps(own).replace("510.0", "505.0"))
    kept = CalibrationStore(tmp_path)
    kept.open()
    told = kept.report("camera")
    assert kept.camera is not None and kept.camera.fx == 505.0 and kept.troubles == []
    assert told is not None and told["verified"] is False
    path.write_text(json.dumps({**own, "accepted": None}))
    kept.open()
    told = kept.report("camera")
    assert told is not None and told["accepted_by"] is None
    kept.put("camera", document(506.0), {"fx": 506.0}, "someone")
    told = kept.report("camera")
    assert told is not None and told["verified"] is True and as_restarted(tmp_path) == 506.0


def test_an_improbable_file_by_hand_is_a_warning_at_the_start_and_in_its_report(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(json.dumps(kept_form(replace(TABLE_3, fx=600.0))))
    store = CalibrationStore(tmp_path)
    store.open()
    report = store.report("camera")
    assert report is not None and store.camera is not None
    assert [code_of(one).code for one in store.troubles] == ["camera.focal_ratio"]
    assert report["warnings"] == store.troubles


def test_a_camera_file_that_hardly_any_camera_has_is_used_with_a_warning() -> None:
    usual, odd = (imported_camera(ros_yaml(model)).report for model in (NEAR, replace(NEAR, cx=60.0)))
    assert len(usual["warnings"]) == 1 and "principal point at (60," in odd["warnings"][-1]


def test_a_mount_comes_from_a_file_in_every_form_and_belongs_to_the_camera_in_use(live: Live) -> None:
    turned = Transform(rotation=OPTICAL, translation=np.array([0.03, 0.01, 0.12]))
    while undo(live, "laser") == 200 or undo(live) == 200:
        pass
    assert bring(live, static_transform(turned)) == 422
    assert bring(live, ros_yaml(NEAR)) == 200
    for text in (static_transform(turned), urdf_joint(turned), json.dumps(both_ways(turned))):
        assert bring(live, text) == 200
        told = active(live)["laser"]
        assert told["not_used"] == ""
        assert np.allclose(told["rotation"], turned.rotation, atol=1e-9)
        assert np.allclose(told["translation_m"], turned.translation, atol=1e-9)
        assert undo(live, "laser") == 200
    assert bring(live, "<robot/>") == 422
    assert undo(live) == 200
