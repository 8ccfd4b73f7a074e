"""The driver's own process: `python -m core.robots.process`. It opens one robot and lives at its pace.

From the console: what to open, requests, and the pipe to a new gate when the old one is gone. From the gate: twists
and nonces. To the console: the profile first, then frames. To the gate: what is near, and that the robot is alive.
Whatever fails, the base stops: without a gate at once, without twists after 0.3 s. A simulated robot's time runs
only as fast as gate and console keep up with it.
"""

import argparse
import contextlib
import fcntl
import logging
import math
import os
import pickle
import selectors
import signal
import socket
import sys
import time
import traceback
from collections.abc import Generator
from dataclasses import replace

import msgspec

from core.errors import BeckonError
from core.gate import ZERO, Twist
from core.gate.limits import is_number
from core.gate.packets import LARGEST, packet_socket, send_packet, take_packets
from core.gate.scheduling import stand_back
from core.heap import give_back
from core.robots import Robot
from core.robots.connect import connect
from core.robots.frame_sender import RESTING_RATE_HZ, FrameSender, resting_rate
from core.robots.ipc_messages import (
    AskPacket,
    DriverHello,
    DriverTrouble,
    LeavePacket,
    OpenRequest,
    RestPacket,
    RobotAnswer,
    read_control,
)
from core.robots.nearness import NearField
from core.robots.requests import read_request
from core.sensors import SensorFrame
from core.sensors.recordable import recordable
from core.sentences import plain

TWIST_TIMEOUT_S = 0.3  # watchdog over the gate: without a twist for so long the base is stopped
MAX_SLOWDOWN_FACTOR = 40.0  # by which a simulated robot lives slower while gate or console do not come to their work
REST_AHEAD_S = 0.05  # that a simulated robot may live on further while nothing is under way
MAX_BEHIND_S = 0.1  # that may be caught up; more is given up, and said when it goes on
PREDECESSOR_TIMEOUT_S = 6.0  # that the driver of a killed console may still live: its gate says zero for a while
PACE_WINDOW_S = 10.0  # over which the pace is measured
CALM_WINDOWS = 6  # windows without a delay after which the computer keeps up again: a busy one is quick now and then


class DriverLoop:
    """One robot between its gate and its console."""

    def __init__(self, robot: Robot, control: socket.socket, gate: socket.socket, frame_sender: FrameSender) -> None:
        self._robot, self._frame_sender = robot, frame_sender
        self._profile = robot.profile
        self._control, self._gate = control, gate
        self._nonce = 0
        self._twist, self._twist_at = ZERO, 0.0
        self._near_field = NearField(robot.profile.lasers)
        self._pace = DriverPace(1 / self._profile.rate)
        self._stamp, self._stepped = 0.0, 0.0  # [s] of the newest frame by the robot's clock, and in real time
        self._until = math.inf  # [s] by the robot's clock to which a simulated one may go on
        self._rests = False  # the console has said that frames may come less often
        self._sleeps = False  # a simulated robot leaves out a turn: the frame of it comes with the next
        self._over = False
        self._parent = os.getppid()
        self._selector = selectors.DefaultSelector()
        self._selector.register(control, selectors.EVENT_READ, self._hear_console)
        self._selector.register(gate, selectors.EVENT_READ, self._hear_gate)
        self._has_gate = self._has_console = True

    def run(self) -> None:
        """Until both the console and the gate are gone, or the console says so."""
        take_packets(self._gate)  # twists from before this robot was awake
        self._pace.start(time.monotonic())
        with self._selector:
            while not self._over:
                wait = self._due - time.monotonic()
                for key, _ in self._selector.select(max(0.0, wait)):
                    key.data()
                if time.monotonic() >= self._due:
                    self._step()
        self._robot.drive(ZERO)

    @property
    def _due(self) -> float:
        """Real time [s] of the next frame: a simulated robot waits for a gate and a console that are behind."""
        period = 1 / self._profile.rate
        if self._stamp + period <= self._until + (REST_AHEAD_S if self._rests and not self._twist.moves else 0.0):
            return self._pace.due + (period if self._sleeps else 0.0)
        return max(self._pace.due, self._stepped + MAX_SLOWDOWN_FACTOR * period)

    def _step(self) -> None:
        now = time.monotonic()
        if self._twist.moves and now - self._twist_at > TWIST_TIMEOUT_S:
            self._drive(ZERO, now)
        nonce = self._nonce
        frame = replace(self._robot.read(), sensed=time.monotonic())
        self._stamp, self._stepped = frame.stamp, frame.sensed
        may_wait_for = self._may_wait_for(frame)
        self._sleeps = may_wait_for > 0 and self._rests and self._profile.simulated and not self._sleeps
        self._tell_gate(frame)
        self._pace.step(time.monotonic())
        frame = replace(recordable(frame), nonce=nonce, pace=self._pace.share)
        self._frame_sender.put_frame(frame, may_wait_for=may_wait_for)
        if self._frame_sender.gone or os.getppid() != self._parent:
            self._has_console = False
        self._over = self._over or not (self._has_gate or self._has_console)

    def _may_wait_for(self, frame: SensorFrame) -> int:
        """How many frames more may go as one with this: none, unless the robot stands and nothing new was seen.

        Nor if frames are so slow already. A picture may wait where nobody looks, if the next comes later than that.
        """
        rate = self._profile.rate
        stands = frame.wheels is not None and not (frame.wheels.moves or self._twist.moves)
        if frame.scan is not None or frame.contact or not (stands and self._profile.drives):
            return 0
        rates = [camera.rate or rate for camera in self._profile.cameras]
        if frame.image is not None and not (self._rests and sum(rates) <= RESTING_RATE_HZ):
            return 0
        least = RESTING_RATE_HZ if self._rests else resting_rate(rate)
        return max(int(rate / least) - 1, 0)

    def _tell_gate(self, frame: SensorFrame) -> None:
        packet: dict[str, object] = {"contact": bool(frame.contact), "trouble": bool(frame.trouble)}
        if self._profile.simulated:
            packet["stamp"] = frame.stamp + (1 / self._profile.rate if self._sleeps else 0.0)
        near = self._near_field.see(frame, moving=self._twist.moves)
        if near is not None:
            packet |= near._asdict()
        elif self._near_field.untimely is not None:
            packet["age"] = self._near_field.untimely
        if self._has_gate and frame.running:
            send_packet(self._gate, packet)

    def _hear_gate(self) -> None:
        packets, there = take_packets(self._gate)
        if packets:
            v, w, nonce = packets[-1].get("v"), packets[-1].get("w"), packets[-1].get("nonce")
            self._nonce = nonce if isinstance(nonce, int) else 0
            until = packets[-1].get("until")
            self._until = float(until) if is_number(until) else math.inf
            fit = is_number(v) and is_number(w)
            self._drive(Twist(float(v), float(w)) if fit else ZERO, time.monotonic())  # type: ignore[arg-type]
        if not there:
            self._selector.unregister(self._gate)
            self._gate.close()
            self._has_gate, self._until = False, math.inf
            self._drive(ZERO, time.monotonic())

    def _drive(self, twist: Twist, now: float) -> None:
        self._twist, self._twist_at = twist, now
        self._sleeps = self._sleeps and not twist.moves
        self._robot.drive(twist)

    def _hear_console(self) -> None:
        try:
            raw, descriptors, _, _ = socket.recv_fds(self._control, LARGEST, 1)
        except BlockingIOError:
            return
        except OSError:
            raw, descriptors = b"", []
        if descriptors:
            self._take_gate(descriptors[0])
        if not raw:
            self._selector.unregister(self._control)
            self._has_console = False
            return
        match read_control(raw):
            case LeavePacket():
                self._over = True
            case RestPacket(rests):
                self._rests = rests
            case AskPacket(ref, request):
                self._frame_sender.put(RobotAnswer(ref, self._answer(bytes(request))))
            case _:
                pass

    def _take_gate(self, descriptor: int) -> None:
        """A new gate in place of the old one."""
        if self._has_gate:
            self._selector.unregister(self._gate)
            self._gate.close()
        self._drive(ZERO, time.monotonic())
        self._gate = packet_socket(descriptor)
        self._selector.register(self._gate, selectors.EVENT_READ, self._hear_gate)
        self._has_gate, self._until = True, math.inf

    def _answer(self, raw: bytes) -> bytes | DriverTrouble:
        try:
            return msgspec.json.encode(self._robot.ask(read_request(raw, self._robot.requests)), enc_hook=plain)
        except BeckonError as refusal:
            return DriverTrouble.of(refusal)
        except Exception:
            details = traceback.format_exc()
            return DriverTrouble("Unavailable", "The robot's driver failed at this request.", details)


class DriverPace:
    """Real time: when the next frame is due, and whether the robot keeps up."""

    def __init__(self, period: float) -> None:
        self.due = 0.0
        self.share = 1.0  # of real time at which the robot's clock ran when it was last too slow; 1: it keeps up
        self._period = period  # [s]
        self._given_up = 0.0  # [s] in this window
        self._since = 0.0  # [s] begin of this window
        self._calm_windows = 0  # windows without a delay

    def start(self, now: float) -> None:
        """Set the first frame due now."""
        self.due = self._since = now

    def step(self, now: float) -> None:
        """A frame was made."""
        self.due += self._period
        if now - self.due > MAX_BEHIND_S:
            self._given_up += now - self.due
            self.due = now
        window = now - self._since
        if window < PACE_WINDOW_S:
            return
        slow = self._given_up > 0.1 * window
        self._calm_windows = 0 if slow else self._calm_windows + 1
        if slow:
            self.share = 1 - self._given_up / window
        elif self._calm_windows >= CALM_WINDOWS:
            self.share = 1.0
        self._given_up, self._since = 0.0, now


@contextlib.contextmanager
def sole_driver(opening: OpenRequest) -> Generator[None]:
    """Be the one driver of this data folder's robot, as soon as that of a console that was killed has let go of it.

    A laser on Ethernet serves one client, and two readers of a serial port take each other's bytes. A predecessor
    that stays longer than its gate can is left to the wire, which says what is in the way.
    """
    if opening.lock is None or opening.url.startswith(("sim:", "log:")):
        yield
        return
    end = time.monotonic() + PREDECESSOR_TIMEOUT_S
    with contextlib.ExitStack() as held:
        with contextlib.suppress(OSError):  # no file can be written, or locked, there: others say so
            file = held.enter_context(opening.lock.open("ab"))
            while time.monotonic() < end:
                with contextlib.suppress(BlockingIOError):
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                time.sleep(0.02)
        yield


def main(arguments: list[str] | None = None) -> None:
    """Run the driver on the descriptors that the console passed on."""
    parser = argparse.ArgumentParser(prog="core.robots.process")
    for name in ("control", "gate", "stream"):
        parser.add_argument(f"--{name}", type=int, required=True, help="descriptor of a pipe")
    given = parser.parse_args(arguments)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    control, gate = packet_socket(given.control), packet_socket(given.gate)
    frame_sender = FrameSender(socket.socket(fileno=given.stream))
    code = 1
    try:
        control.setblocking(True)
        opening: OpenRequest = pickle.loads(control.recv(LARGEST))
        control.setblocking(False)
        if opening.url.startswith("log:"):
            stand_back()  # nothing moves, and reading a long recording takes a whole processor
        with sole_driver(opening):
            robot = connect(opening.url, seed=opening.seed, settings=opening.settings)
            try:
                give_back()  # painting a simulated room takes 12 MB more than it has then
                frame_sender.put(DriverHello(robot.profile))
                DriverLoop(robot, control, gate, frame_sender).run()
            finally:
                robot.drive(ZERO)
                robot.close()
        code = 0
    except BeckonError as refusal:
        frame_sender.put(DriverTrouble.of(refusal))
    except Exception as fault:
        sentence = f"The robot's driver failed ({type(fault).__name__})."
        frame_sender.put(DriverTrouble("Unavailable", sentence, traceback.format_exc()))
    frame_sender.close()
    logging.shutdown()
    os._exit(code)  # everything is closed; the interpreter's own farewell would take longer than an operator waits


if __name__ == "__main__":
    main()
