"""A running driver, its profile, and the buffer where its frames and answers wait for the thread that takes them."""

import contextlib
import itertools
import logging
import math
import pickle
import socket
import threading
import time
from collections.abc import Callable
from typing import Any

import msgspec

from console.workers.child_process import ChildProcess
from core.errors import Unavailable
from core.gate.packets import packet_pair
from core.robots import Profile
from core.robots.frame_sender import FrameReceiver, merged
from core.robots.ipc_messages import (
    AskPacket,
    DriverHello,
    DriverTrouble,
    GatePacket,
    LeavePacket,
    OpenRequest,
    RestPacket,
    RobotAnswer,
    send_control,
)
from core.robots.requests import RobotRequest
from core.sensors import SensorFrame

log = logging.getLogger(__name__)

START_TIMEOUT_S = 30.0  # that a robot may take to be opened; a recording may take as long as its driver reads
READ = 1 << 20  # bytes taken at once
AnswerContent = bytes | DriverTrouble  # JSON of an answer


class DriverProcess:
    """Started by making one; `hello` waits until the robot is there."""

    def __init__(self, module: str, opening: OpenRequest) -> None:
        self.ready = False  # the robot is there
        self._rests = False  # its frames may come less often
        self.stream, their_stream = socket.socketpair()
        self._control, their_control = packet_pair()
        self._gate_end, their_gate_end = packet_pair()
        self._inbox = FrameReceiver()
        self._patience = math.inf if opening.url.startswith("log:") else START_TIMEOUT_S
        self._control.send(pickle.dumps(opening))
        with their_stream, their_control, their_gate_end:
            theirs = {"stream": their_stream, "control": their_control, "gate": their_gate_end}
            arguments = [f"--{name}={end.fileno()}" for name, end in theirs.items()]
            self.child = ChildProcess(module, arguments, list(theirs.values()))

    def hello(self, given_up: Callable[[], bool]) -> Profile:
        """Wait for the robot → its profile. Raises BadInput or Unavailable with the driver's sentence."""
        deadline = time.monotonic() + self._patience
        self.stream.settimeout(0.1)
        while time.monotonic() < deadline and not given_up():
            try:
                raw = self.stream.recv(READ)
            except TimeoutError:
                continue
            except OSError:
                break  # closed meanwhile: given up
            if not raw:
                raise Unavailable("The robot's driver ended before the robot was ready.")
            for message in self._inbox.feed(raw):
                if isinstance(message, DriverTrouble):
                    if message.details:
                        log.error("The robot could not be opened: %s\n%s", message.sentence, message.details)
                    raise message.error
                if isinstance(message, DriverHello):
                    self.stream.setblocking(False)
                    self.ready = True
                    return message.profile
        if given_up():
            raise Unavailable("The robot was let go before it was ready.")
        raise Unavailable(f"The robot was not ready within {START_TIMEOUT_S:g} s.")

    def read(self) -> list[Any] | None:
        """The messages that have come, without waiting; None when the driver is gone."""
        try:
            raw = self.stream.recv(READ)
        except BlockingIOError:
            return []
        except OSError:
            return None
        return self._inbox.feed(raw) if raw else None

    def gate_end(self) -> socket.socket:
        """The end of a pipe to the driver for a gate: at first that of the beginning, then each time a new one."""
        if self._gate_end.fileno() < 0:
            self._gate_end, their_end = packet_pair()
            with their_end, contextlib.suppress(OSError):
                socket.send_fds(self._control, [msgspec.json.encode(GatePacket())], [their_end.fileno()])
        return self._gate_end

    def ask(self, ref: int, request: RobotRequest[Any]) -> bool:
        """Send a request → whether it is on its way; the answer comes with `read`."""
        return send_control(self._control, AskPacket(ref, msgspec.Raw(msgspec.json.encode(request))))

    def rest(self, rests: bool) -> None:
        """Tell it whether its frames may come less often, where that has changed."""
        if rests != self._rests and send_control(self._control, RestPacket(rests)):
            self._rests = rests

    def end(self, patience: float) -> None:
        """Let it go, by force after `patience` [s]."""
        send_control(self._control, LeavePacket())
        self.child.end(patience)
        for end in (self.stream, self._control, self._gate_end):
            end.close()


class FrameBuffer:
    """One newest frame, and the answers to the questions that are open."""

    def __init__(self) -> None:
        self._frame: SensorFrame | None = None
        self._answers: dict[int, AnswerContent | None] = {}
        self._refs = itertools.count(1)
        self._arrival = threading.Condition()
        self._shut = False

    def put_frame(self, frame: SensorFrame) -> None:
        """A frame has come; one that nobody took is merged into it."""
        with self._arrival:
            self._frame = frame if self._frame is None else merged(self._frame, frame)
            self._arrival.notify_all()

    def put_answer(self, answer: RobotAnswer) -> None:
        """An answer has come; nobody waits for it any more when it is late."""
        with self._arrival:
            if answer.ref in self._answers:
                self._answers[answer.ref] = answer.result
                self._arrival.notify_all()

    def take_frame(self, timeout: float) -> SensorFrame | None:
        """The newest frame that nobody took yet, waited for `timeout` [s] at most."""
        with self._arrival:
            self._arrival.wait_for(lambda: self._frame is not None or self._shut, timeout)
            frame, self._frame = self._frame, None
        return frame

    def open_question(self) -> int:
        """A number under which an answer may come."""
        with self._arrival:
            ref = next(self._refs)
            self._answers[ref] = None
        return ref

    def take_answer(self, ref: int, timeout: float) -> AnswerContent | None:
        """The answer under this number, waited for `timeout` [s] at most; the question is closed then."""
        with self._arrival:
            self._arrival.wait_for(lambda: self._answers[ref] is not None or self._shut, timeout)
            return self._answers.pop(ref)

    def shut(self) -> None:
        """Nothing more will come: let everybody go who waits."""
        with self._arrival:
            self._shut = True
            self._arrival.notify_all()
