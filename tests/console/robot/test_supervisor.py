"""Driver and gate in their processes: obeyed, watched, replaced, and ended without leaving anything behind."""

import asyncio
import contextlib
import errno
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from console.control.notices import Notifications
from console.control.stop import latched
from console.robot.supervisor import RobotSupervisor
from core.errors import BadInput, Refused, Unavailable
from core.gate import Limits, Setpoint, check, read_trace
from core.gate.latch import Latch
from core.robots.connect import SCHEMES
from core.robots.ipc_messages import OpenRequest
from core.robots.process import sole_driver
from core.robots.requests import ReadTruth
from tests.console.tiny_process import TinyProcess
from tests.console.tiny_robot import TINY, Break, Fly, ReadTwist, Sleep, Touch
from tests.core.gate.bench import motion_after

ROOT = Path(__file__).resolve().parents[3]


class Operator:
    """Beats and drives from a thread, as a console does, until told to stop."""

    def __init__(self, robot: RobotSupervisor, *, source: str = "goal") -> None:
        self.robot, self.source = robot, source
        self.press = 1
        self.v = 0.1
        self.beats = True
        self.epoch = 1
        self._seq = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.is_set():
            if self.beats:
                self.robot.beat()
            self.robot.next_frame(0.02)
            self._seq += 1
            nonce = self.robot.status().nonce
            self.robot.send(Setpoint(self.epoch, self._seq, self.source, self.press, self.v, 0.0, nonce))  # type: ignore[arg-type]

    def get_going(self) -> None:
        """Until it drives; a machine that is busy elsewhere may trip it now and then, so press again."""
        for _ in range(20):
            ends = time.monotonic() + 0.5
            while time.monotonic() < ends:
                if self.robot.status().v >= 0.09:
                    return
                time.sleep(0.005)
            self.press += 1
        raise AssertionError(self.robot.status())

    def leave(self) -> None:
        self._over.set()
        self._thread.join()


def until(happens: Callable[[], bool], seconds: float = 100.0) -> float:
    """Wait for it → how long it took."""
    begun = time.monotonic()
    while not happens():
        assert time.monotonic() - begun < seconds
        time.sleep(0.002)
    return time.monotonic() - begun


def runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.fixture(autouse=True)
def scheme(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SCHEMES, "tiny", TINY)


@pytest.fixture
def tiny(tmp_path: Path) -> Iterator[TinyProcess]:
    robot = TinyProcess("tiny:", home=tmp_path, gate_trace=tmp_path / "gate.csv")
    robot.start()
    until(lambda: robot.status().nonce > 0)
    yield robot
    pids = robot.pids.values()
    robot.close()
    assert not any(runs(pid) for pid in pids)
    assert check(read_trace(tmp_path / "gate.csv"), Limits()) == []


@pytest.fixture
def driven(tiny: TinyProcess) -> Iterator[Operator]:
    tiny.arm(1, "ann")
    operator = Operator(tiny)
    operator.get_going()
    yield operator
    operator.leave()


def wheels(robot: RobotSupervisor) -> float:
    """The speed that the base itself was told [m/s]."""
    return robot.ask(ReadTwist()).v


def test_the_simulated_laboratory_comes_and_obeys(tmp_path: Path) -> None:
    robot = RobotSupervisor("sim:lab", home=tmp_path, gate_trace=tmp_path / "gate.csv")
    robot.start()
    assert (robot.profile.kind, robot.profile.url) == ("SIM", "sim:lab")
    robot.arm(1, "ann")
    operator = Operator(robot)
    operator.get_going()
    before = robot.ask(ReadTruth())

    def has_moved() -> bool:
        operator.get_going()
        after = robot.ask(ReadTruth())
        return math.hypot(after.x_m - before.x_m, after.y_m - before.y_m) > 0.02

    until(has_moved)
    operator.leave()
    frame = robot.next_frame(2.0)
    assert frame is not None and frame.wheels is not None and frame.truth is not None
    assert not any(array.flags.writeable for array in (frame.scan and frame.scan.ranges,) if array is not None)
    robot.close()
    assert check(read_trace(tmp_path / "gate.csv"), Limits()) == []


def test_frames_come_in_real_time_with_the_gates_nonces(tiny: TinyProcess) -> None:
    errors: list[float] = []
    while not errors or (min(errors) > 0.25 and len(errors) < 5):  # a busy machine holds a round up, no five of them
        first, begun = tiny.next_frame(2.0), time.monotonic()
        assert first is not None
        last, scans, nonces = first, 0, []
        while time.monotonic() - begun < 1.0 or (scans < 5 and time.monotonic() - begun < 5.0):
            frame = tiny.next_frame(0.5)
            assert frame is not None
            scans += frame.scan is not None
            nonces.append(frame.nonce)
            last = frame
        errors.append(abs(last.stamp - first.stamp - (time.monotonic() - begun)))
        assert scans >= 5
        assert nonces == sorted(nonces) and nonces[-1] > nonces[len(nonces) // 2] > 0
    assert min(errors) < 0.25


def test_a_slow_pilot_gets_the_newest_frame_and_misses_no_scan(tiny: TinyProcess) -> None:
    tiny.next_frame(2.0)
    time.sleep(0.4)
    frame = tiny.next_frame(0.0)
    assert frame is not None and frame.scan is not None
    newer = tiny.next_frame(1.0)
    assert newer is not None and newer.stamp - frame.stamp < 0.2


def test_nobody_beats_but_the_console_itself(tiny: TinyProcess, driven: Operator) -> None:
    for _ in range(5):  # on a busy machine the gate may stop for being late itself
        driven.beats = True
        driven.get_going()
        driven.beats = False
        until(lambda: tiny.status().v == 0.0, 1.0)
        if tiny.status().reason != "the gate was late":
            break
    assert tiny.status().reason == "the console is silent"
    assert wheels(tiny) == 0.0


def test_stop_stands_and_the_same_goal_does_not_go_on(tiny: TinyProcess, driven: Operator) -> None:
    tiny.stop()
    until(lambda: tiny.status().v == 0.0, 1.0)
    until(lambda: wheels(tiny) == 0.0, 1.0)
    time.sleep(0.2)
    assert tiny.status().v == 0.0
    driven.press += 1
    driven.get_going()


def test_a_speed_that_is_no_number_stops(tiny: TinyProcess, driven: Operator) -> None:
    driven.v = math.nan
    until(lambda: tiny.status().v == 0.0, 1.0)
    assert tiny.status().reason == "a speed that is not a number"


def test_a_bump_is_heard_by_the_gate(tiny: TinyProcess, driven: Operator) -> None:
    tiny.ask(Touch(value=True))
    until(lambda: tiny.status().v == 0.0, 1.0)
    assert "bumper" in tiny.status().reason


def test_requests_are_answered_refused_or_given_up(tiny: TinyProcess) -> None:
    assert tiny.ask(ReadTwist()).v == 0.0
    with pytest.raises(Refused, match="does not do that"):
        tiny.ask(Fly())
    with pytest.raises(BadInput, match="understands the requests twist, touch, sleep, raise and fly, nothing else"):
        tiny.ask(ReadTruth())
    with pytest.raises(BadInput, match="Expected float, got null as value"):
        tiny.ask(Sleep(value=math.nan))
    with pytest.raises(Unavailable, match="driver failed at this request"):
        tiny.ask(Break())
    with pytest.raises(Unavailable, match="did not answer within"):
        tiny.ask(Sleep(value=0.3), timeout=0.1)
    with pytest.raises(Unavailable, match="cannot be asked"):
        tiny.ask(Fly(luggage="x" * 1_000_000))
    time.sleep(0.3)
    assert tiny.ask(ReadTwist()).v == 0.0


def test_a_driver_that_is_busy_keeps_neither_gate_nor_base_moving(tiny: TinyProcess, driven: Operator) -> None:
    with pytest.raises(Unavailable):
        tiny.ask(Sleep(value=1.0), timeout=0.01)
    until(lambda: tiny.status().v == 0.0, 0.8)
    until(lambda: tiny.link()[0] == "stale", 1.0)
    until(lambda: tiny.link()[0] == "live", 2.0)


@pytest.mark.parametrize(
    ("url", "kind", "sentence"),
    [
        ("sim:nowhere", BadInput, "no such simulated world"),
        ("log:/no/such/file.mcap", BadInput, "file.mcap"),
        ("tiny:refuse", Unavailable, "The tiny robot is not at home."),
        ("tiny:break", Unavailable, "The robot's driver failed (ZeroDivisionError)."),
    ],
)
def test_a_robot_that_does_not_come_says_why(tmp_path: Path, url: str, kind: type[Exception], sentence: str) -> None:
    robot = TinyProcess(url, home=tmp_path)
    with pytest.raises(kind) as told:
        robot.start()
    assert sentence in str(told.value)
    robot.close()


def test_an_unknown_robot_is_refused_before_anything_starts(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="known are sim:…"):
        RobotSupervisor("flying:carpet", home=tmp_path)


def test_a_slow_start_can_be_given_up(tmp_path: Path) -> None:
    robot = TinyProcess("tiny:slow", home=tmp_path)
    failure: list[BaseException] = []

    def start() -> None:
        try:
            robot.start()
        except Unavailable as trouble:
            failure.append(trouble)

    thread = threading.Thread(target=start)
    thread.start()
    time.sleep(0.5)
    assert robot.link()[0] == "connecting"
    robot.close()
    thread.join(2.0)
    assert not thread.is_alive() and failure


def test_a_recording_may_take_as_long_to_read_as_it_likes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.robot.driver_process.START_TIMEOUT_S", 0.2)
    (tmp_path / "walk.jsonl").write_text('{"t": 3.0, "ranges": [1, 2, 3]}\n')
    robot = RobotSupervisor(f"log:{tmp_path / 'walk.jsonl'}", home=tmp_path)
    said: list[str] = []

    def start() -> None:
        try:
            robot.start()
        except Unavailable as trouble:
            said.append(str(trouble))

    thread = threading.Thread(target=start)
    thread.start()
    until(lambda: "driver" in robot.pids)
    os.kill(robot.pids["driver"], signal.SIGSTOP)  # it reads and reads
    time.sleep(1.0)
    assert thread.is_alive()
    robot.close()
    thread.join(2.0)
    assert said == ["The robot was let go before it was ready."]


def test_closing_is_prompt_and_leaves_nothing(tmp_path: Path) -> None:
    def descriptors() -> int:
        return len(os.listdir("/proc/self/fd"))

    before, threads = descriptors(), threading.active_count()
    for _ in range(2):
        robot = TinyProcess("tiny:", home=tmp_path)
        robot.start()
        robot.arm(1, "ann")
        operator = Operator(robot)
        operator.get_going()
        operator.leave()
        pids = list(robot.pids.values())
        begun = time.monotonic()
        robot.close()
        robot.close()
        assert time.monotonic() - begun < 5.0
        assert not any(Path(f"/proc/{pid}").exists() for pid in pids)
        robot.next_frame(0.0)
        assert robot.next_frame(1.0) is None
        robot.stop()
    assert descriptors() == before
    assert threading.active_count() == threads


def test_a_dead_gate_stops_the_base_and_a_new_one_is_disarmed(tiny: TinyProcess, driven: Operator) -> None:
    x, lost = tiny.ask(ReadTwist()).x, tiny.pids["gate"]
    os.kill(lost, signal.SIGKILL)
    until(lambda: wheels(tiny) == 0.0, 1.0)
    until(lambda: tiny.pids.get("gate") not in (lost, None) and tiny.status().nonce > 0)
    assert tiny.status().state == "disarmed"
    assert tiny.ask(ReadTwist()).x >= x  # the driver lives on with its robot where it was
    tiny.arm(1, "ann")
    until(lambda: tiny.status().state == "armed")
    time.sleep(0.3)
    assert tiny.status().v == 0.0  # the goal from before does not resume
    driven.press += 1
    driven.get_going()


def test_a_frozen_gate_is_replaced_and_the_base_stands_by_itself(tiny: TinyProcess, driven: Operator) -> None:
    frozen = tiny.pids["gate"]
    os.kill(frozen, signal.SIGSTOP)
    assert until(lambda: wheels(tiny) == 0.0, 2.0) < 1.5
    until(lambda: tiny.pids.get("gate") not in (frozen, None) and tiny.trouble == "")
    assert not runs(frozen)
    assert tiny.status().state == "disarmed"


def test_a_stop_that_a_frozen_gate_cannot_hear_ends_the_gate(tiny: TinyProcess, driven: Operator) -> None:
    frozen = tiny.pids["gate"]
    os.kill(frozen, signal.SIGSTOP)
    while tiny._send({"kind": "beat"}):  # pyright: ignore[reportPrivateUsage]
        pass
    tiny.halt()
    until(lambda: wheels(tiny) == 0.0, 1.0)
    until(lambda: tiny.pids.get("gate") not in (frozen, None) and tiny.status().nonce > 0)
    assert tiny.status().state == "halted"
    tiny.reset()
    until(lambda: tiny.status().state == "disarmed")


@pytest.mark.parametrize("fate", [signal.SIGSTOP, signal.SIGKILL])
def test_a_halt_that_the_gate_never_read_holds_for_the_next_one(
    tiny: TinyProcess, driven: Operator, tmp_path: Path, fate: signal.Signals
) -> None:
    told: list[str] = []
    tiny.alarm = told.append
    lost = tiny.pids["gate"]
    os.kill(lost, signal.SIGSTOP)
    tiny.halt()  # there is room in its pipe: it is sent
    os.kill(lost, fate)
    until(lambda: tiny.pids.get("gate") not in (lost, None) and tiny.trouble == "")
    assert Latch(tmp_path).is_set
    until(lambda: tiny.status().nonce > 0)
    assert tiny.status().state == "halted"
    assert len(told) == 1 and "gate" in told[0]
    tiny.arm(1, "ann")
    driven.press += 1
    time.sleep(0.3)
    assert tiny.status().state == "halted" and wheels(tiny) == 0.0
    assert tiny.reset()
    until(lambda: tiny.status().state == "disarmed")
    assert not Latch(tmp_path).is_set


def test_a_halt_that_no_gate_read_outlives_the_console(tmp_path: Path) -> None:
    robot = TinyProcess("tiny:", home=tmp_path)
    robot.start()
    os.kill(robot.pids["gate"], signal.SIGSTOP)
    robot.halt()
    robot.close()
    assert Latch(tmp_path).is_set


def test_a_halt_that_cannot_be_saved_still_holds_for_the_next_gate(tmp_path: Path) -> None:
    (tmp_path / "halt.new").mkdir()  # in the way of the latch
    robot = TinyProcess("tiny:", home=tmp_path)
    robot.start()
    until(lambda: robot.status().nonce > 0)
    assert robot.status().state == "disarmed"
    robot.halt()
    until(lambda: "a restart may forget it" in robot.status().reason)
    robot.disarm()
    time.sleep(0.1)
    assert "a restart may forget it" in robot.status().reason
    lost = robot.pids["gate"]
    os.kill(lost, signal.SIGKILL)
    until(lambda: robot.pids.get("gate") not in (lost, None) and robot.status().nonce > 0)
    assert robot.status().state == "halted"
    robot.close()
    assert not robot.reset()


def test_a_dead_driver_is_replaced_and_the_gate_with_it(tiny: TinyProcess, driven: Operator) -> None:
    before = tiny.pids
    os.kill(before["driver"], signal.SIGKILL)
    until(lambda: tiny.link()[0] == "lost")
    assert "driver" in tiny.status().reason
    until(lambda: tiny.link()[0] == "live")
    assert not set(tiny.pids.values()) & set(before.values())
    assert tiny.status().state == "disarmed"


@pytest.mark.parametrize("url", ["tiny:crash=0.1", "tiny:exit=0.1"])
def test_three_crashes_in_a_minute_are_the_last(tmp_path: Path, url: str) -> None:
    robot = TinyProcess(url, home=tmp_path)
    robot.start()
    until(lambda: "third time" in robot.trouble, 20.0)
    assert robot.link()[0] == "lost"
    assert robot.status().state == "disarmed"
    assert "third time" in robot.status().reason
    assert ("(RuntimeError)" in robot.trouble) is (url == "tiny:crash=0.1")
    time.sleep(0.3)
    assert robot.pids == {}
    with pytest.raises(Unavailable):
        robot.ask(ReadTwist())
    robot.stop()
    robot.halt()
    assert not robot.halt_is_latched()
    robot.latch_halt()
    assert robot.halt_is_latched() and Latch(tmp_path).is_set
    robot.close()


def test_a_halt_is_called_latched_when_it_is_on_disk_and_until_it_is_reset(tiny: TinyProcess, tmp_path: Path) -> None:
    for _ in range(3):
        assert not tiny.halt_is_latched()
        tiny.halt()
        until(tiny.halt_is_latched)
        assert Latch(tmp_path).is_set
        tiny.halt()  # another, while the first holds
        until(tiny.halt_is_latched)
        assert tiny.reset()
        assert not tiny.halt_is_latched()
        tiny.halt()  # before anybody has heard of the reset
        until(tiny.halt_is_latched)
        assert Latch(tmp_path).is_set and tiny.status().state == "halted"
        tiny.reset()
        until(lambda: tiny.status().state == "disarmed")


def test_a_halt_that_a_frozen_gate_has_not_latched_is_latched_by_the_console(
    tiny: TinyProcess, tmp_path: Path
) -> None:
    os.kill(tiny.pids["gate"], signal.SIGSTOP)
    tiny.halt()
    assert asyncio.run(latched(tiny, Notifications())) == ""
    assert Latch(tmp_path).is_set and tiny.halt_is_latched()


def test_a_halt_that_nobody_can_latch_says_so(tmp_path: Path) -> None:
    (tmp_path / "halt.new").mkdir()  # in the way of the latch
    robot = TinyProcess("tiny:", home=tmp_path)
    robot.start()
    robot.halt()
    board = Notifications()
    assert "may forget it. The halt could not be saved: Is a directory." in asyncio.run(latched(robot, board))
    assert not robot.halt_is_latched() and board.shown
    robot.close()


class Sleeping(TinyProcess):
    """On a machine whose sleep is told by the test."""

    slept = 0.0

    def asleep(self) -> float:  # type: ignore[override]
        return self.slept


def test_a_sleep_of_the_machine_stops_and_what_is_replaced_after_it_is_not_counted(tmp_path: Path) -> None:
    robot = Sleeping("tiny:", home=tmp_path)
    told: list[str] = []
    robot.alarm = told.append
    with contextlib.ExitStack() as held:
        held.callback(robot.close)
        robot.start()
        robot.arm(1, "ann")
        operator = Operator(robot)
        held.callback(operator.leave)
        for _ in range(4):
            operator.get_going()
            robot.slept += 10.0
            until(lambda: robot.status().v == 0.0, 1.0)
            assert "slept for 10 s" in told[-1]
            lost = robot.pids["gate"]
            os.kill(lost, signal.SIGKILL)
            until(lambda lost=lost: robot.pids.get("gate") not in (lost, None) and robot.status().nonce > 0)
            assert robot.trouble == "" and robot.status().state == "disarmed"
            robot.arm(1, "ann")
            operator.press += 1


@pytest.mark.parametrize(
    "lack", [OSError(errno.EMFILE, "Too many open files"), MemoryError()], ids=["file", "memory"]
)
def test_a_gate_that_cannot_be_started_is_tried_again_until_it_can(
    tiny: TinyProcess, monkeypatch: pytest.MonkeyPatch, lack: Exception
) -> None:
    monkeypatch.setattr("console.robot.supervisor.RETRY_S", 0.05)
    told: list[str] = []
    tiny.alarm = told.append
    lost, tries = tiny.pids["gate"], []

    def fail(*_: object, **__: object) -> None:
        tries.append(1)
        raise lack

    with monkeypatch.context() as scarce:
        scarce.setattr("console.robot.supervisor.GateProcess", fail)
        os.kill(lost, signal.SIGKILL)
        until(lambda: len(tries) > 5)
        assert tiny.link()[0] == "lost" and "could not be started" in tiny.trouble
        assert "tried again" in tiny.trouble and "could not be started" in tiny.status().reason
        assert len(told) == 2  # that the gate ended, and that it cannot be started: not again with every try
    until(lambda: tiny.trouble == "" and tiny.status().nonce > 0)
    assert tiny.pids["gate"] != lost and tiny.link()[0] == "live"


def test_a_supervision_that_fails_ends_both_processes_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = TinyProcess("tiny:", home=tmp_path)
    robot.start()
    robot.arm(1, "ann")
    operator = Operator(robot)
    operator.get_going()
    pids = robot.pids.values()

    def fail() -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(robot, "_hear_driver", fail)
    until(lambda: robot.trouble != "")
    assert "restart the console" in robot.trouble and robot.link()[0] == "lost"
    until(lambda: not any(runs(pid) for pid in pids))
    operator.leave()
    robot.close()


def test_a_halt_outlives_the_console(tmp_path: Path) -> None:
    for expected in ("disarmed", "halted"):
        robot = TinyProcess("tiny:", home=tmp_path)
        robot.start()
        until(lambda robot=robot: robot.status().nonce > 0)
        assert robot.status().state == expected
        robot.halt()
        until(lambda robot=robot: robot.status().state == "halted")
        robot.close()


def test_ctrl_c_does_not_reach_them(tiny: TinyProcess, driven: Operator) -> None:
    before = tiny.pids
    for pid in before.values():
        assert os.getpgid(pid) != os.getpgid(0)
        os.kill(pid, signal.SIGINT)
    time.sleep(0.2)
    driven.get_going()
    assert tiny.trouble == "" and tiny.pids == before


class Console:
    """A console in a process of its own that drives until it is killed."""

    def __init__(self, home: Path, url: str = "tiny:", source: str = "goal") -> None:
        self.home = home
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.console.driving_console", url, str(home), source],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.pids = json.loads(self.process.stdout.readline())
        assert self.process.stdout.readline() == "driving\n"

    def kill(self, number: int) -> float:
        """Send a signal → when [s]."""
        now = time.monotonic()
        self.process.send_signal(number)
        return now

    def last_motion(self) -> float:
        """When the trace moved last [s]."""
        rows = read_trace(self.home / "gate.csv")
        assert check(rows, Limits()) == []
        zero = next(i for i in range(len(rows) - 1, -1, -1) if rows[i].v or rows[i].w) + 1
        return rows[zero].t_mono_ns * 1e-9

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()
        until(lambda: not any(runs(pid) for pid in self.pids.values()))


def test_a_killed_console_means_zero_and_both_processes_end(tmp_path: Path) -> None:
    console = Console(tmp_path)
    killed = console.kill(signal.SIGKILL)
    time.sleep(0.5)
    assert console.last_motion() - killed < 0.4
    console.end()


def test_another_console_waits_for_the_driver_of_a_killed_one(tmp_path: Path) -> None:
    """A laser that serves one client does not answer while that one still lives."""
    console = Console(tmp_path)
    console.kill(signal.SIGKILL)
    robot = TinyProcess("tiny:", home=tmp_path)
    robot.start()
    assert not runs(console.pids["driver"])
    robot.close()
    console.end()


def test_a_driver_that_does_not_go_is_waited_for_in_vain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.process.PREDECESSOR_TIMEOUT_S", 0.2)
    opening = OpenRequest("serial:/dev/null", 0, None, tmp_path / "driver.lock")
    with sole_driver(opening):
        began = time.monotonic()
        with sole_driver(opening):
            assert time.monotonic() - began >= 0.2
        with sole_driver(replace(opening, url="sim:lab")):
            pass
    with sole_driver(replace(opening, lock=tmp_path / "missing" / "driver.lock")):
        pass


def test_a_frozen_console_means_zero_and_nothing_moves_when_it_wakes(tmp_path: Path) -> None:
    console = Console(tmp_path, source="jog")
    frozen = console.kill(signal.SIGSTOP)
    time.sleep(1.3)
    assert console.last_motion() - frozen < 0.5
    woken = console.kill(signal.SIGCONT)
    time.sleep(0.7)
    assert motion_after(read_trace(tmp_path / "gate.csv"), woken) == []
    assert all(runs(pid) for pid in console.pids.values())
    console.end()
