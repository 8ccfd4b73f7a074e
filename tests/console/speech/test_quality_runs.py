"""How well someone is understood here: from the setup to the page, and given up on the way."""

import asyncio
import importlib.util
from pathlib import Path
from typing import Any

import msgspec
import pytest
from msgspec.structs import replace

from console.speech.quality_runs import QualityRow, QualityRun, QualityRuns, QualitySetup, summary
from core.speech.settings import SpeechSettings
from core.speech.synthesis import can_speak
from tests.console.live import Live

needs_words = pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None or not can_speak(), reason="needs pocketsphinx and espeak-ng"
)


@pytest.fixture(autouse=True)
def nothing_runs(request: pytest.FixtureRequest) -> None:
    """What another test began is over."""
    if "live" in request.fixturenames:
        live: Live = request.getfixturevalue("live")
        for number in list(live.runtime.parts[QualityRuns].runs):
            ask(live, "POST", f"/{number}/cancel")
        live.until(lambda: all(run.state != "running" for run in live.runtime.parts[QualityRuns].runs.values()))


def ask(live: Live, method: str, path: str, body: Any = None) -> Any:
    return live.ask(method, f"/api/speech-quality{path}", body, token=live.operator)


@needs_words
def test_hearing_is_measured_from_the_page_and_kept(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    quick = SpeechSettings(garbage_words=20)  # what is understood does not matter here
    monkeypatch.setattr(live.runtime.parts[QualityRuns], "speech", quick)
    begun = ask(live, "POST", "", {"distances_m": [0.5, 11.0], "snr_db": [40.0], "phrases": 1})
    assert begun.status == 202 and begun.json["state"] == "running"
    assert ask(live, "POST", "", {"phrases": 1}).status == 409
    path = f"/{begun.json['id']}"
    live.until(lambda: ask(live, "GET", path).json["state"] != "running", 120.0)
    run = ask(live, "GET", path).json
    assert (run["state"], run["progress"], run["reports"]) == ("done", 1.0, [True, False])
    near, far = run["rows"]
    assert near["words"] == 2 and near["stoi"] > 0.6 and "OSQE" in run["summary"]
    assert "in the way" in far["refused"]
    report = ask(live, "GET", f"{path}/report/0")
    assert b"Speech quality" in report.body and "sha256-" in report.headers["content-security-policy"]
    assert ask(live, "GET", f"{path}/report/1").status == 404
    assert live.ask("DELETE", f"/api/speech-quality{path}", token=live.viewer).status == 403
    assert ask(live, "DELETE", path).status == 204
    assert ask(live, "GET", path).status == 404


@pytest.mark.campaign
@needs_words
def test_a_run_is_given_up_at_once(live: Live) -> None:
    path = f"/{ask(live, 'POST', '', {'phrases': 36}).json['id']}"
    told = ask(live, "POST", f"{path}/cancel").json
    assert told["state"] == "cancelled" and "Cancelled" in told["doing"]
    assert ask(live, "DELETE", path).status == 204


def test_what_cannot_be_measured_is_told(live: Live) -> None:
    assert ask(live, "POST", "", {"distances_m": []}).status == 422
    assert ask(live, "POST", "", {"distances_m": [0.1]}).status == 422
    assert ask(live, "GET", "/nothing").status == 404
    assert ask(live, "GET", "").json["why_not"] == ""


def test_the_score_counts_what_was_measured() -> None:
    row = QualityRow(
        distance_m=1.0,
        snr_db=30.0,
        refused="",
        commands=4,
        commands_exact=3,
        erroneous_words_robot=5,
        erroneous_words_person=2,
        words=9,
    )
    wall = QualityRow(distance_m=9.0, snr_db=30.0, refused="a wall")
    assert summary([row, wall]) == "75 % of commands whole; OSQE_D −3 over 9 words"
    assert summary([replace(row, erroneous_words_robot=2)]).endswith("OSQE_D 0 over 9 words")
    assert summary([]) == ""


async def reopened(folder: Path) -> QualityRuns:
    runs = QualityRuns(folder)
    await runs.open()
    return runs


def test_a_run_that_the_end_of_the_console_cut_off_is_not_running_afterwards(tmp_path: Path) -> None:
    kept = tmp_path / "speech_quality"
    setup = QualitySetup("lab", 0.0, 0.0, 0.0, 0.0, [1.0], [30.0], 18)
    run = QualityRun(who="me", setup=setup)
    for name, content in ((run.id, msgspec.json.encode(run)), ("broken", b"{")):
        (kept / name).mkdir(parents=True)
        (kept / name / "run.json").write_bytes(content)
    earlier = QualityRun(who="me", setup=setup, state="done", at_s=1.0)
    (kept / f"{earlier.id}.json").write_bytes(msgspec.json.encode(earlier))
    for _ in range(2):
        assert [one.state for one in asyncio.run(reopened(tmp_path)).runs.values()] == ["done", "cancelled"]
