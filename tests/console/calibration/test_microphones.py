"""The microphones on the bench: the self-check and the wizard of their orientation, as the page asks for them."""

import asyncio
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.calibration.microphones import MicrophoneCalibration, MicrophoneRecorder
from console.http.problems import Problem
from core.errors import Refused
from core.perception.sound.array_orientation import Clap
from core.sensors.microphones import Sound
from tests.console.in_process import InProcessRobot
from tests.console.live import Live, until


def ask(live: Live, path: str, body: Any = None) -> Any:
    return live.ask("POST", f"/api/{path}", body, token=live.operator)


def measured(live: Live, path: str, body: Any) -> Any:
    """Something that takes a while, begun and waited for."""
    live.until(lambda: not live.runtime.parts[MicrophoneCalibration].busy, 60.0)
    begun = live.ask("POST", f"/api/{path}", body, token=live.operator)
    assert begun.status == 202 and begun.json["busy"]
    assert live.ask("POST", f"/api/{path}", body, token=live.operator).status == 409
    live.until(lambda: not live.runtime.parts[MicrophoneCalibration].busy, 60.0)


def test_the_self_check_says_what_the_array_cannot_know(live: Live) -> None:
    measured(live, "hearing/check", {"show": True})
    told = live.ask("GET", "/api/hearing/check", token=live.viewer).json
    assert told["well"] and told["trouble"] == ""
    assert [fault["kind"] for fault in told["faults"]] == ["flat"]
    assert live.ask("POST", "/api/hearing/check", {"show": True}, token=live.viewer).status == 403


def test_nobody_speaks_for_a_check_while_the_robot_moves_because_no_stop_would_be_heard(live: Live) -> None:
    def check() -> None:
        live.runtime.parts[MicrophoneCalibration].moves = True
        with pytest.raises(Problem, match="let it stand"):
            live.runtime.parts[MicrophoneCalibration].check(show=True)

    live.on_loop(check)
    assert not live.runtime.parts[MicrophoneCalibration].busy


def test_a_clap_from_a_known_side_is_heard_there(live: Live) -> None:
    live.on_loop(live.runtime.dispatcher.setpoint_sender.stop)
    live.until(lambda: not live.runtime.parts[MicrophoneCalibration].moves)
    ask(live, "calibration/microphones/again")
    measured(live, "calibration/microphones/clap", {"azimuth_rad": 0.0, "show": True})
    told = live.ask("GET", "/api/calibration/microphones", token=live.viewer).json
    assert told["verdict"] == ""
    (one,) = told["claps"]
    assert one["heard_rad"] == pytest.approx(0.0, abs=0.15) and 0 < one["sd_rad"] < 0.2
    assert told["missing"] and told["solution"] is None and "90°" in told["advice"]
    refused = ask(live, "calibration/microphones/accept")
    assert refused.status == 409 and "claps are needed" in refused.json["detail"]
    assert ask(live, "calibration/microphones/claps/3/drop").status == 404
    assert ask(live, "calibration/microphones/claps/0/drop").json["claps"] == []


def bench(folder: Path, robot: InProcessRobot, changes: list[int]) -> MicrophoneCalibration:
    return MicrophoneCalibration(folder, robot, lambda: changes.append(1))  # type: ignore[arg-type]


def test_what_was_accepted_is_used_and_stays(tmp_path: Path) -> None:
    robot, changes = InProcessRobot(), list[int]()
    one = bench(tmp_path, robot, changes)
    with pytest.raises(Refused, match="claps are needed"):
        asyncio.run(one.accept("me"))
    for asked in one.wizard.asked:
        assert one.wizard.take(Clap(asked=asked, heard=asked - 0.5, sd=0.03)) == ""
    assert one.state.solution is not None and one.state.solution.yaw_rad == pytest.approx(0.5)
    asyncio.run(one.accept("me"))
    again = bench(tmp_path, robot, changes)
    asyncio.run(again.open())
    array = again.calibrated(robot.profile).microphones
    assert array is not None and array.mounting.heading == pytest.approx(0.5)
    asyncio.run(again.undo())
    assert again.calibrated(robot.profile) is robot.profile and changes == [1, 1]
    (tmp_path / "calibration" / "microphones.json").write_text(json.dumps({"yaw": "north"}))
    asyncio.run(again.open())
    assert again.active is None


def test_who_lets_the_robot_listen_while_it_is_measured_is_heard_afterwards(live: Live) -> None:
    microphones = live.runtime.parts[MicrophoneCalibration]
    asked: list[Any] = []

    async def answer(request: Any) -> Any:
        asked.append(request)

    async def measured() -> None:
        recorder = MicrophoneRecorder(answer)
        recording = asyncio.create_task(recorder.record(0.1, lambda: microphones.listening))
        await until(lambda: asked)
        assert (await asyncio.to_thread(ask, live, "hearing", {"listen": True})).status == 200
        recorder.took(Sound(stamp=0.0, rate=16_000, samples=np.zeros((1600, 1), np.float32)))
        await recording

    live.on_loop(lambda: vars(microphones).update(busy=True, listening=False))
    try:
        asyncio.run(measured())
    finally:
        microphones.busy = False
    assert [request.on for request in asked] == [True]


def test_microphones_from_which_nothing_comes_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.calibration.microphones.RECORDING_TIMEOUT_S", 0.0)

    async def silent(_: dict[str, Any]) -> dict[str, Any]:
        return {}

    with pytest.raises(Exception, match="No sound comes"):
        asyncio.run(MicrophoneRecorder(silent).record(0.05, lambda: True))
