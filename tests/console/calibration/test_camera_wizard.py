"""The camera's wizard over REST and over the socket: begin, show, solve, accept, take away."""

import asyncio
import io
import json
import os
import shutil
import signal
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import quote

import msgspec
import pytest

from console.broadcast import Broadcaster
from console.calibration.camera_worker import CameraWorker
from console.calibration.service import MOST_EXPORTS, MOST_PICTURES, CalibrationService
from console.calibration.session_store import SessionStore
from console.calibration.session_worker import SessionWorker
from console.messages.calibration import CalibrationBoard
from core.calibration.files.camera_files import parse_camera
from core.errors import Refused
from core.optics import TABLE_3
from tests.console.calibration.wizard import JPEG, Wizard, blurred, boards, with_a_thumb
from tests.console.in_process import InProcessRobot
from tests.console.live import Live, hear, say


@pytest.fixture(scope="module")
def walked(bench: Live) -> Wizard:
    """A session with fourteen views and its solution."""
    wizard = Wizard(bench)
    kinds = wizard.show(14)
    assert kinds.count("counted") >= 10
    wizard.solved()
    return wizard


def test_a_session_of_pictures_finds_the_camera_that_took_them(walked: Wizard) -> None:
    told = walked.solved()
    solution = told["solution"]
    assert abs(solution["fx"] - TABLE_3.fx) < 5 * solution["sd"]["fx"] < 0.02 * TABLE_3.fx
    assert told["progress"]["views"] == len([view for view in told["views"] if not view["dropped"]])
    assert 50 < len(solution["residuals"]) <= 800
    assert told["uncertainty"]["rows"] * told["uncertainty"]["columns"] == 165
    fits = [view["rms_px"] for view in told["views"]]
    assert fits == sorted(fits, reverse=True)
    walked.live.until(lambda: "correction" in walked.told["solution"])


def test_a_picture_that_is_no_use_is_refused_in_words(walked: Wizard) -> None:
    views = walked.told["progress"]["views"]
    verdict = walked.send(blurred(), "shaky.png").json
    assert verdict["kind"] == "refused" and "lurred" in verdict["words"]
    assert verdict["number"] == walked.told["verdict"]["number"]
    assert walked.send(boards()[0], "again.png").json["kind"] == "same"
    assert walked.told["progress"]["views"] == views


def test_four_corners_by_hand_count_a_picture_in_which_no_board_is_found() -> None:
    worker = CameraWorker()
    worker.open(CalibrationBoard(9, 6, 0.03), b"null", None)
    covered, found = with_a_thumb()
    corners = [(float(u), float(v)) for u, v in found[[45, 0, 53, 8]]]
    verdicts = [worker.take_upload(covered, "a", given).verdict for given in ([], corners)]
    assert [one.kind for one in verdicts if one is not None] == ["nothing", "counted"]


def test_a_wrong_board_size_is_noticed() -> None:
    worker = CameraWorker()
    worker.open(CalibrationBoard(10, 7, 0.03), b"null", None)
    verdicts = [worker.take_upload(content, "a", []).verdict for content in boards()[:3]]
    words = " ".join(verdict.words for verdict in verdicts if verdict is not None)
    assert "9x6 inner corners, not 10x7" in words and "squares instead of inner corners" in words


def test_a_view_can_be_left_out_and_taken_back(walked: Wizard) -> None:
    before = walked.solved()
    worst = before["views"][0]["name"]
    assert walked.post(f"views/{quote(worst)}/drop").status == 200
    without = walked.solved()
    assert next(view for view in without["views"] if view["name"] == worst)["dropped"]
    assert without["solution"]["fx"] != before["solution"]["fx"]
    assert walked.post(f"views/{quote(worst)}/restore").status == 200
    assert walked.solved()["solution"]["fx"] == pytest.approx(before["solution"]["fx"])
    assert walked.post("views/nobody/drop").status == 422


def test_another_suggestion_is_another(walked: Wizard) -> None:
    first = walked.told["advice"]
    assert first["words"].endswith(".") and len(first["corners"]) == 54
    assert walked.post("skip").json["advice"]["outline"] != first["outline"]


def test_the_solution_leaves_in_every_form(walked: Wizard) -> None:
    fx = walked.solved()["solution"]["fx"]
    ask = walked.live.ask
    for form in ("ros", "opencv", "kalibr", "json"):
        answer = ask("GET", f"{walked.base}/export/{form}", token=walked.live.viewer)
        assert answer.status == 200 and "attachment" in answer.headers["content-disposition"]
        assert parse_camera(answer.body.decode()).fx == pytest.approx(fx)
    packed = zipfile.ZipFile(io.BytesIO(ask("GET", f"{walked.base}/export/all", token=walked.live.viewer).body))
    names = packed.namelist()
    assert {"session.json", "camera.json", "camera.yaml"} <= set(names)
    assert sum(name.startswith("views/") for name in names) == len(walked.told["views"])
    missing = ask("GET", f"{walked.base}/export/urdf", token=walked.live.viewer)
    assert missing.status == 404 and "ros" in missing.json["detail"]


def test_views_are_shown_small_whole_and_straight(walked: Wizard) -> None:
    name = quote(walked.told["views"][0]["name"])
    sizes: list[int] = []
    for how in ("", "?full=1", "?corrected=1"):
        answer = walked.live.ask("GET", f"{walked.base}/views/{name}.jpg{how}", token=walked.live.viewer)
        assert answer.status == 200 and answer.headers["content-type"] == "image/jpeg"
        assert answer.body.startswith(b"\xff\xd8")
        sizes.append(len(answer.body))
    assert sizes[0] < sizes[1]
    assert walked.live.ask("GET", f"{walked.base}/views/nobody.jpg", token=walked.live.viewer).status == 404


def test_many_who_ask_for_whole_pictures_or_zips_are_sent_away_before_anything_is_read(
    walked: Wizard, monkeypatch: pytest.MonkeyPatch
) -> None:
    live, name = walked.live, quote(walked.told["views"][0]["name"])
    bench = live.runtime.parts[CalibrationService]
    reads: list[str] = []
    read = SessionStore.read

    def counting(folder: SessionStore, file: str) -> bytes:
        reads.append(file)
        return read(folder, file)

    monkeypatch.setattr(SessionStore, "read", counting)
    paths = [(f"{walked.base}/views/{name}.jpg?full=1", bench.picture_turns, MOST_PICTURES)]
    paths.append((f"{walked.base}/export/all", bench.export_turns, MOST_EXPORTS))
    with ThreadPoolExecutor(12) as viewers:
        for path, turns, most in paths:
            asyncio.run_coroutine_threadsafe(turns._turn.acquire(), live.loop).result(10)
            asked = [viewers.submit(live.ask, "GET", path, token=live.viewer) for _ in range(12)]
            live.until(lambda asked=asked, most=most: sum(each.done() for each in asked) == 12 - most)
            assert not reads and all(each.result().status == 429 for each in asked if each.done())
            live.on_loop(turns._turn.release)
            assert sorted(each.result().status for each in asked) == [200] * most + [429] * (12 - most)
            reads.clear()
    assert not list(bench.sessions[walked.id].folder.path.glob("tmp*"))


@pytest.mark.campaign
def test_a_session_survives_the_death_of_its_worker(walked: Wizard) -> None:
    before = walked.solved()
    worker = walked.worker
    assert worker is not None
    os.kill(worker, signal.SIGKILL)
    assert walked.told["progress"] == before["progress"]
    assert walked.send(boards()[1]).json["kind"] == "same"
    after = walked.solved()
    assert walked.worker not in (None, worker)
    assert after["views"] == before["views"] and after["progress"]["p95_px"] == before["progress"]["p95_px"]


def test_the_socket_tells_a_session_as_it_changes(walked: Wizard) -> None:
    with walked.live.open(token=walked.live.viewer) as line:
        say(line, kind="want", calibration=walked.id)
        first = hear(line, "calibration")["session"]
        assert first["id"] == walked.id and first["solution"]["fx"]
        walked.send(boards()[0])
        hear(line, "calibration", true=lambda told: told["session"]["verdict"]["kind"] == "same")
        say(line, kind="want", calibration=None, camera=False)
        say(line, kind="want", calibration="nobody")
        say(line, kind="want", calibration=7)
        hear(line, "answer", true=lambda told: told["status"] == 422)


@pytest.mark.campaign
def test_the_webcams_pictures_are_taken_when_still(bench: Live) -> None:
    wizard = Wizard(bench, source="webcam")
    kinds = [
        wizard.send(boards()[0], kind=JPEG, more=f"&live=1&stamp_s={number / 8}").json["kind"] for number in range(6)
    ]
    assert kinds[0] == "moving" and kinds[-1] == "counted"
    assert wizard.told["verdict"]["stamp_s"] == 5 / 8 and wizard.told["progress"]["views"] == 1
    assert wizard.send(bytes(2_000_001), kind=JPEG, more="&live=1").status == 413
    too_few = wizard.post("solve")
    assert too_few.status == 409 and "more views" in too_few.json["detail"]
    refused = wizard.post("accept", {"force": True})
    assert refused.status == 409 and "more views" in refused.json["detail"]


def test_a_deleted_session_is_gone(bench: Live) -> None:
    wizard = Wizard(bench)
    assert bench.ask("DELETE", wizard.base, token=bench.operator).status == 204
    assert bench.ask("GET", wizard.base, token=bench.operator).status == 404
    listed = bench.ask("GET", "/api/calibration/sessions", token=bench.viewer).json["sessions"]
    assert wizard.id not in [row["id"] for row in listed]


@pytest.mark.campaign
def test_sessions_outlast_the_console(walked: Wizard, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.calibration.session.SOLVE_PATIENCE_S", 300.0)  # workers stand back on a busy machine
    before = walked.solved()
    shutil.copytree(
        walked.live.runtime.parts[CalibrationService].sessions[walked.id].folder.path,
        tmp_path / "calibration" / walked.id,
    )
    damaged = tmp_path / "calibration" / "abc" / "session.json"
    damaged.parent.mkdir()
    damaged.write_text('{"version": 1, "card"')
    absurd = json.loads((tmp_path / "calibration" / walked.id / "session.json").read_text())
    absurd["card"] |= {"id": "bcd", "camera": dict.fromkeys(("width", "height", "fx", "fy", "cx", "cy"), 0)}
    (tmp_path / "calibration" / "bcd").mkdir()
    (tmp_path / "calibration" / "bcd" / "session.json").write_text(json.dumps(absurd))

    async def next_console() -> None:
        told: list[str] = []
        bench = CalibrationService(
            tmp_path, InProcessRobot(), Broadcaster(), lambda _, words: told.append(words), lambda: None
        )
        await bench.open()
        session = bench.find(walked.id)
        again = msgspec.to_builtins(session.shown)
        assert again["views"] == before["views"] and again["solution"]["fx"] == before["solution"]["fx"]
        assert len(bench.sessions) == 1 and damaged.exists()
        report = await bench.accept(session, force=False, who="operator")
        assert report["fx"] == pytest.approx(before["solution"]["fx"]) and bench.active.camera is not None
        await session.act(SessionWorker.drop(before["views"][0]["name"]))
        assert session.solving_task is not None
        await session.solving_task
        assert session.shown.solution is not None and session.shown.solving is None
        assert session.shown.solution["views_used"] == before["solution"]["views_used"] - 1
        with pytest.raises(Refused, match="all these views already"):
            await session.solve_now()
        for view in session.shown.views[:-3]:
            if not view.dropped:
                await session.act(SessionWorker.drop(view.name))
        with pytest.raises(Refused, match="other views"):
            await bench.accept(session, force=True, who="operator")
        assert told == []
        saves = [asyncio.create_task(session.save()) for _ in range(3)]
        await bench.delete(session)
        await asyncio.gather(*saves, session.save())
        assert not session.folder.path.exists()
        await bench.close()

    asyncio.run(next_console())
