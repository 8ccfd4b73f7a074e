"""The gate's process, with the console and the driver played by the test over the true pipes."""

import itertools
import json
import math
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from core.gate import Gate, Limits, Setpoint, check, process, read_trace
from core.gate.latch import Latch
from core.gate.packets import packet_pair, send_packet, take_packets
from core.gate.process import GateLoop
from core.gate.suspend import SleepWatch

ROOT = Path(__file__).resolve().parents[3]


class Played:
    """A running gate and what it said."""

    def __init__(self, home: Path, *arguments: str) -> None:
        self.console, their_console = packet_pair()
        self.driver, their_driver = packet_pair()
        self.trace = home / "gate.csv"
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-P", "-S", "-m", "core.gate.process"),
                *(f"--console={their_console.fileno()}", f"--driver={their_driver.fileno()}"),
                *(f"--home={home}", f"--trace={self.trace}", *arguments),
            ],
            pass_fds=(their_console.fileno(), their_driver.fileno()),
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stderr=subprocess.PIPE,
        )
        their_console.close()
        their_driver.close()
        self.status: dict[str, Any] = {}
        self.twists: list[tuple[float, dict[str, Any]]] = []
        self.seq = self.press = 0

    def tell(self, kind: str, **more: Any) -> None:
        assert send_packet(self.console, {"kind": kind, **more})

    def listen(self) -> None:
        for packet in take_packets(self.console)[0] if self.console.fileno() >= 0 else []:
            self.status = packet
        self.twists += [(time.monotonic(), twist) for twist in take_packets(self.driver)[0]]

    def until(self, happens: Callable[[], bool], seconds: float = 100.0) -> float:
        """Listen until something happens → how long that took."""
        begun = time.monotonic()
        while not happens():
            assert time.monotonic() - begun < seconds, self.status
            time.sleep(0.001)
            self.listen()
        return time.monotonic() - begun

    def drive(self, seconds: float, *, press: int | None = None, v: float = 0.2) -> None:
        """Everything as it should be, and a goal that moves."""
        press = self.press if press is None else press
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            self.tell("beat")
            send_packet(self.driver, {"contact": False, "points": []})
            self.listen()
            self.seq += 1
            order = {"seq": self.seq, "source": "goal", "press": press, "v": v, "w": 0.0}
            self.tell("set", epoch=1, nonce=self.status.get("nonce", 0), **order)
            time.sleep(0.02)

    def start_driving(self) -> None:
        self.until(lambda: bool(self.status))
        self.tell("arm", epoch=1, owner="ann")
        for self.press in range(1, 20):  # a machine that is busy elsewhere may trip it now and then
            self.drive(0.3)
            if self.status["v"] > 0.0:
                return
        raise AssertionError(self.status)

    def end(self) -> int:
        self.console.close()
        self.driver.close()
        code = self.process.wait(5)
        if self.process.stderr is not None:
            self.process.stderr.close()
        return code


@pytest.fixture
def gate(tmp_path: Path) -> Iterator[Played]:
    played = Played(tmp_path)
    yield played
    played.process.kill()
    played.end()
    assert check(read_trace(played.trace), Limits()) == []


def test_it_needs_the_standard_library_only() -> None:
    seen = subprocess.run(
        [sys.executable, "-P", "-S", "-c", "import core.gate.process, sys; print(*sys.modules)"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    roots = {name.partition(".")[0] for name in seen}
    assert roots <= {*sys.stdlib_module_names, "core", "__main__", "sitecustomize", "usercustomize"}
    assert {name for name in seen if name.startswith("core.")} <= {
        "core.gate",
        "core.errors",
        "core.sentences",
        "core.setting",
        *(n for n in seen if "core.gate." in n),
    }


def test_it_drives_and_says_so_at_twenty_hertz_or_more(gate: Played) -> None:
    gate.start_driving()
    told, begun = list[int](), time.monotonic()
    while not told or (told[-1] < 20 and time.monotonic() - begun < 10.0):  # a busy computer has slow seconds
        take_packets(gate.console)
        told.append(0)
        second = time.monotonic()
        while time.monotonic() - second < 1.0:
            told[-1] += len(take_packets(gate.console)[0])
            time.sleep(0.005)
    assert told[-1] >= 20, told
    gate.listen()
    assert len([t for t, _ in gate.twists if t > time.monotonic() - 1.0]) >= 30
    nonces = [twist["nonce"] for _, twist in gate.twists]
    assert nonces == sorted(nonces)


class Still:
    """A gate's loop that drives and whose clock does not run: what it does now, it does without a tick."""

    def __init__(self, home: Path) -> None:
        (self.ours, self.console), (self.body, self.driver) = packet_pair(), packet_pair()
        self.gate = Gate(Limits())
        self.loop = GateLoop(self.gate, Latch(home), self.console, self.driver)
        now = time.monotonic()
        self.gate.tick(now)
        self.gate.see([], now)
        self.gate.heartbeat(now)
        self.gate.arm(1, "ann", now)
        order = {"epoch": 1, "seq": 1, "source": "goal", "press": 1, "v": 0.2, "w": 0.0}
        send_packet(self.ours, {"kind": "set", "nonce": self.gate.status().nonce, **order})
        self.hear()
        self.loop._tick(time.monotonic() + 0.02)  # pyright: ignore[reportPrivateUsage]
        assert self.gate.twist.moves
        take_packets(self.body)

    def hear(self) -> None:
        self.loop._hear_console()  # pyright: ignore[reportPrivateUsage]
        self.loop._hear_driver()  # pyright: ignore[reportPrivateUsage]

    def close(self) -> None:
        for end in (self.ours, self.console, self.body, self.driver):
            end.close()


@pytest.fixture
def still(tmp_path: Path) -> Iterator[Still]:
    still = Still(tmp_path)
    yield still
    still.close()


@pytest.mark.parametrize("kind", ["stop", "halt", "disarm", "leave"])
def test_to_stand_is_told_to_the_driver_between_ticks(still: Still, kind: str) -> None:
    send_packet(still.ours, {"kind": kind})
    still.hear()
    told = [(twist["v"], twist["w"]) for twist in take_packets(still.body)[0]]
    assert told and set(told) == {(0.0, 0.0)}
    assert take_packets(still.ours)[0][-1]["v"] == 0.0


def test_at_rest_zeros_go_out_with_every_second_tick_until_a_setpoint_comes_and_what_stops_is_told_at_once(
    still: Still,
) -> None:
    def told(ticks: int) -> int:
        for _ in range(ticks):
            still.loop._tick(time.monotonic())  # pyright: ignore[reportPrivateUsage]
        return len(take_packets(still.body)[0])

    assert told(10) == 10
    send_packet(still.ours, {"kind": "stop"})
    still.hear()
    take_packets(still.body)
    assert [told(30), told(60)] == [30, 60]  # for nearly two seconds
    told(20)
    assert told(50) == 25
    order = {"epoch": 1, "seq": 2, "source": "goal", "press": 2, "v": 0.2, "w": 0.0}
    send_packet(still.ours, {"kind": "set", "nonce": 0, **order})  # it need not be obeyed
    still.hear()
    assert told(50) == 50


def test_a_console_that_is_gone_is_answered_between_ticks(still: Still) -> None:
    still.ours.close()
    still.hear()
    assert still.gate.status().reason == "the console is gone"
    assert [twist["v"] for twist in take_packets(still.body)[0]] == [0.0]


@pytest.mark.parametrize("orphaned", [True, False])
def test_a_gate_whose_parent_died_ends_though_another_holds_the_consoles_end_of_the_pipe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, orphaned: bool
) -> None:
    parents = itertools.chain([7], itertools.repeat(1 if orphaned else 7))
    monkeypatch.setattr(process, "PARENT_CHECK_S", 0.0)
    monkeypatch.setattr(process, "FAREWELL_S", 0.0)
    monkeypatch.setattr(process.os, "getppid", lambda: next(parents))
    ends = *packet_pair(), *packet_pair()
    gate = Gate(Limits())
    thread = threading.Thread(target=GateLoop(gate, Latch(tmp_path), ends[1], ends[3]).run, daemon=True)
    thread.start()
    thread.join(5.0 if orphaned else 0.3)
    assert thread.is_alive() is not orphaned
    ends[0].close()
    thread.join(5.0)
    assert not thread.is_alive() and gate.status().reason == "the gate ends"
    for end in ends[1:]:
        end.close()


def test_a_bump_is_answered_between_ticks(still: Still) -> None:
    send_packet(still.body, {"contact": True})
    still.hear()
    assert [twist["v"] for twist in take_packets(still.body)[0]] == [0.0]


def test_a_sleep_of_the_machine_ends_what_is_driven_and_what_was_ordered_before(tmp_path: Path) -> None:
    (ours, console), (body, driver) = packet_pair(), packet_pair()
    gate, slept = Gate(Limits()), [0.0]
    loop = GateLoop(gate, Latch(tmp_path), console, driver, lambda: slept[0])
    thread = threading.Thread(target=loop.run)
    thread.start()
    status: dict[str, Any] = {"nonce": 0}
    told: list[float] = []

    def drive(press: int, seconds: float, nonce: int | None = None) -> None:
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            status.update((take_packets(ours)[0] or [{}])[-1])
            told.extend(twist["v"] for twist in take_packets(body)[0])
            send_packet(ours, {"kind": "beat"})
            send_packet(body, {"contact": False, "points": []})
            order = {"epoch": 1, "seq": time.monotonic_ns(), "source": "goal", "press": press, "v": 0.2, "w": 0.0}
            send_packet(ours, {"kind": "set", "nonce": status["nonce"] if nonce is None else nonce, **order})
            time.sleep(0.02)

    send_packet(ours, {"kind": "arm", "epoch": 1, "owner": "ann"})
    press = 0
    while not any(told):  # a machine that is busy elsewhere may trip it now and then
        drive(press := press + 1, 0.3)
    nonce = status["nonce"]
    slept[0] += 10.0
    drive(press, 0.1)
    told.clear()
    drive(press, 0.2)
    assert status["reason"] == "the machine slept" and status["refused"] != "" and not any(told)
    drive(press + 1, 0.1, nonce=nonce)  # an order from before the sleep that lay in a buffer
    assert not any(told)
    for later in range(press + 2, press + 20):
        drive(later, 0.3)
        if any(told):
            break
    assert any(told)
    send_packet(ours, {"kind": "leave"})
    thread.join(5.0)
    assert not thread.is_alive()
    for end in (ours, console, body, driver):
        end.close()


def test_a_wait_for_the_processor_between_two_clocks_is_no_sleep(monkeypatch: pytest.MonkeyPatch) -> None:
    true, waits = time.monotonic, [0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    watch = SleepWatch()
    monkeypatch.setattr(time, "monotonic", lambda: (time.sleep(waits.pop(0) if waits else 0.0), true())[1])
    assert watch.woke() == 0.0 and watch.woke() == 0.0


def test_a_tick_is_due_when_an_order_expires() -> None:
    gate = Gate(Limits())
    assert gate.expires == math.inf
    gate.tick(1.0)
    gate.see([], 1.0)
    gate.heartbeat(1.0)
    gate.arm(1, "ann", 1.0)
    gate.accept(Setpoint(1, 1, "goal", 1, 0.2, 0.0, gate.status().nonce), 1.01)
    assert gate.expires == 1.0 + 0.15
    for n in range(1, 8):
        gate.tick(1.0 + 0.02 * n)
    gate.heartbeat(1.15)
    assert gate.expires == 1.01 + 0.25
    for n in range(8, 13):
        gate.tick(1.0 + 0.02 * n)
    gate.heartbeat(1.25)
    assert gate.tick(1.259).moves
    assert not gate.tick(gate.expires).moves
    assert gate.status().reason.startswith("silence")


def test_stop_reaches_the_driver_at_once(gate: Played) -> None:
    gate.start_driving()
    gate.tell("stop")
    assert gate.until(lambda: gate.twists[-1][1]["v"] == 0.0) < 0.2
    gate.drive(0.2)
    assert gate.status["v"] == 0.0
    gate.start_driving()


def test_a_console_that_is_gone_means_zero_zeros_and_the_end(gate: Played) -> None:
    gate.start_driving()
    gate.console.close()
    assert gate.until(lambda: gate.twists[-1][1]["v"] == 0.0) < 0.3
    begun = time.monotonic()
    gate.until(lambda: gate.process.poll() is not None)
    assert 1.0 < time.monotonic() - begun < 4.0
    assert gate.process.returncode == 0
    zeros = [twist for t, twist in gate.twists if t > begun]
    assert len(zeros) > 50
    assert not any(twist["v"] for twist in zeros)


def test_a_console_without_a_heartbeat_means_zero(gate: Played) -> None:
    gate.start_driving()
    begun = time.monotonic()
    gate.until(lambda: gate.twists[-1][1]["v"] == 0.0)
    assert time.monotonic() - begun < 0.5
    gate.until(lambda: gate.status["reason"] != "")
    silent = ("the console is silent", "silence: no setpoint came for too long")
    assert gate.status["reason"] in (*silent, "the gate was late")  # on a busy machine it stops for its own delay


def test_asked_to_leave_it_is_zero_and_away(gate: Played) -> None:
    gate.start_driving()
    gate.tell("leave")
    assert gate.process.wait(2) == 0
    gate.listen()
    assert gate.twists[-1][1]["v"] == 0.0


def test_told_to_terminate_it_is_zero_and_away(gate: Played) -> None:
    gate.start_driving()
    gate.process.send_signal(signal.SIGTERM)
    assert gate.process.wait(2) == 0
    gate.listen()
    assert gate.twists[-1][1]["v"] == 0.0


def test_an_interrupt_from_the_keyboard_is_the_consoles_business(gate: Played) -> None:
    gate.start_driving()
    gate.process.send_signal(signal.SIGINT)
    gate.drive(0.1)
    gate.start_driving()


def test_a_driver_that_is_gone_disarms(gate: Played) -> None:
    gate.start_driving()
    gate.driver.close()
    begun = time.monotonic()
    while gate.status["state"] != "disarmed":
        assert time.monotonic() - begun < 2.0
        for packet in take_packets(gate.console)[0]:
            gate.status = packet
    assert gate.status["reason"] == "the robot's driver is gone"


def test_nonsense_on_the_pipes_is_survived(gate: Played) -> None:
    gate.start_driving()
    for raw in (
        b"{",
        b"[]",
        b"\xff" * 100,
        b'{"kind":"arm"}',
        b'{"kind":"arm","epoch":"x","owner":1}',
        b'{"kind":[]}',
    ):
        gate.console.send(raw)
    for more in ({}, {"epoch": 1}, {"v": "fast"}, {"surprise": 1}):
        gate.tell("set", **more)
    for raw in (b'{"points":[1,[2],[3,"x"],null],"contact":1}', b'{"points":{}}', b'{"points":[[NaN,1]]}'):
        gate.driver.send(raw)
    gate.drive(0.1)
    gate.start_driving()


def test_a_halt_is_on_disk_before_it_is_told_and_outlives_the_gate(tmp_path: Path) -> None:
    first = Played(tmp_path)
    first.start_driving()
    first.tell("halt", number=7)
    first.until(lambda: first.status["state"] == "halted")
    first.until(lambda: first.status["latched"] == 7)  # this halt and no later one is on the disk
    first.process.kill()
    first.end()
    assert Latch(tmp_path).is_set
    second = Played(tmp_path)
    second.until(lambda: bool(second.status))
    assert second.status["state"] == "halted"
    second.tell("arm", epoch=1, owner="ann")
    second.drive(0.2, press=5)
    assert second.status["v"] == 0.0 and second.status["state"] == "halted"
    second.tell("reset")
    second.until(lambda: second.status["state"] == "disarmed")
    assert not Latch(tmp_path).is_set
    second.drive(0.2, press=6)
    assert second.status["v"] == 0.0
    second.tell("leave")
    assert second.end() == 0
    assert check(read_trace(second.trace), Limits()) == []


def test_a_halt_is_kept_where_the_console_ends_right_after_it_with_statuses_unread(tmp_path: Path) -> None:
    played = Played(tmp_path)
    played.until(lambda: bool(played.status))
    assert select.select([played.console], [], [], 2.0)[0], "a status, which stays unread"
    played.process.send_signal(signal.SIGSTOP)
    played.tell("halt", number=1)
    played.console.close()
    played.process.send_signal(signal.SIGCONT)
    assert played.end() == 0
    assert Latch(tmp_path).is_set


def test_killed_around_the_write_of_a_halt_it_never_forgets_one_that_it_told(tmp_path: Path) -> None:
    for trial in range(6):
        home = tmp_path / str(trial)
        home.mkdir()
        played = Played(home)
        played.until(lambda played=played: bool(played.status))
        played.tell("halt")
        if trial == 5:
            played.until(lambda played=played: played.status["state"] == "halted")
        time.sleep(0.002 * trial)
        played.process.kill()
        played.process.wait()
        played.listen()
        assert Latch(home).is_set or (played.status["state"] != "halted" and trial < 5)
        played.end()


def test_presses_of_an_earlier_gate_stay_over(tmp_path: Path) -> None:
    played = Played(tmp_path, "--spent", json.dumps([["goal", 1]]))
    played.until(lambda: bool(played.status))
    played.tell("arm", epoch=1, owner="ann")
    played.drive(0.3, press=1)
    assert played.status["v"] == 0.0
    played.start_driving()
    assert played.press > 1
    played.tell("leave")
    assert played.end() == 0


@pytest.mark.parametrize("limits", ['{"deadman": 0}', '{"max_speed": 1e9}', '{"colour": 1}', "[", '{"deadman": NaN}'])
def test_it_does_not_start_with_limits_that_are_none(tmp_path: Path, limits: str) -> None:
    played = Played(tmp_path, "--limits", limits)
    assert played.process.stderr is not None
    said = played.process.stderr.read().decode()
    assert played.end() == 1
    assert said.startswith("The gate does not start: ")
    assert "Traceback" not in said


def test_a_frozen_driver_does_not_freeze_the_gate(gate: Played) -> None:
    gate.start_driving()
    begun = time.monotonic()
    while (waited := time.monotonic() - begun) < 1.5 or (gate.status["trips"] < 1 and waited < 30.0):
        # nobody reads the driver's pipe, nobody sends scans
        gate.tell("beat")
        for packet in take_packets(gate.console)[0]:
            gate.status = packet
        gate.seq += 1
        order = {"seq": gate.seq, "source": "goal", "press": gate.press, "v": 0.2, "w": 0.0}
        gate.tell("set", epoch=1, nonce=gate.status["nonce"], **order)
        time.sleep(0.02)
    assert gate.status["v"] == 0.0
    assert gate.status["trips"] >= 1


def test_pipes_that_were_handed_over_are_not_inherited_further() -> None:
    for end in packet_pair():
        assert not os.get_inheritable(end.fileno())
        assert end.family == socket.AF_UNIX
        end.close()


def test_a_halt_that_cannot_be_lifted_says_why_for_as_long_as_it_lasts(tmp_path: Path) -> None:
    (tmp_path / "halt.json").mkdir()  # nobody can remove this latch as a file
    played = Played(tmp_path)
    played.until(lambda: bool(played.status))
    for kind in ("reset", "disarm", "stop"):
        played.tell(kind)
    played.until(lambda: "could not be lifted" in played.status["reason"])
    played.drive(0.2)
    assert played.status["state"] == "halted" and "could not be lifted" in played.status["reason"]
    played.tell("leave")
    assert played.end() == 0


def test_a_halt_is_written_once_however_often_it_is_asked_for(still: Still, tmp_path: Path) -> None:
    send_packet(still.ours, {"kind": "halt"})
    still.hear()
    written = (tmp_path / "halt.json").stat().st_ino
    for _ in range(50):
        send_packet(still.ours, {"kind": "halt"})
    still.hear()
    assert (tmp_path / "halt.json").stat().st_ino == written
    send_packet(still.ours, {"kind": "reset"})
    send_packet(still.ours, {"kind": "halt"})
    still.hear()
    assert Latch(tmp_path).is_set
