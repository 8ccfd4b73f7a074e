"""A robot behind its driver's loop, in threads of this process: the caller is its gate and its console."""

import logging
import select
import socket
import threading
import time
from collections.abc import Callable

from core.gate.packets import packet_pair, send_packet, take_packets
from core.gate.twist import ZERO, Twist
from core.robots import Robot
from core.robots.frame_sender import FrameReceiver, FrameSender
from core.robots.ipc_messages import LeavePacket, RestPacket, send_control
from core.robots.process import DriverLoop
from core.sensors import SensorFrame

log = logging.getLogger(__name__)

PERIOD_S = 1 / 40  # between twists while speeds are asked for, as the gate sends them
READ = 1 << 20  # bytes taken at once
LOOP_END_TIMEOUT_S = 5.0  # in which the loop ends


class DriverSession:
    """Started by making one, which takes the robot over; `close` closes the robot too."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.profile = robot, robot.profile
        self.watch: Callable[[SensorFrame], object] = lambda _: None  # is given every frame that is read
        self.asked_at = time.monotonic()  # [s] of the newest twist
        self._control, control = packet_pair()
        self._gate, gate = packet_pair()
        self._stream, stream = socket.socketpair()
        self._stream.setblocking(False)
        self._received = FrameReceiver()
        self._sender = FrameSender(stream)
        self._ends = (self._control, control, self._gate, gate, self._stream, stream)
        self._loop = DriverLoop(robot, control, gate, self._sender)
        self._thread = threading.Thread(target=self._run, name="driver-loop", daemon=True)
        self._thread.start()

    def ask(self, twist: Twist) -> None:
        """Send one twist, which holds until the next, or until the loop's watchdog finds the silence too long."""
        take_packets(self._gate)
        self.asked_at = time.monotonic()
        send_packet(self._gate, {"v": twist.v, "w": twist.w, "nonce": 0})

    def frames(
        self, seconds: float, twist: Twist | None = None, until: Callable[[SensorFrame], object] | None = None
    ) -> list[SensorFrame]:
        """Frames that are read in that time [s], or until a frame is as wanted, which is the last.

        `twist` is asked for meanwhile. `sensed` of a frame is on the clock of `asked_at`.
        """
        read: list[SensorFrame] = []
        now = time.monotonic()
        end, due = now + seconds, now
        while now < end:
            if twist is not None and now >= due:
                self.ask(twist)
                due = now + PERIOD_S
            for frame in self._newest(min(end - now, PERIOD_S)):
                read.append(frame)
                self.watch(frame)
                if until is not None and until(frame):
                    return read
            now = time.monotonic()
        return read

    def rest(self, rests: bool) -> None:
        """Let frames come less often while the robot stands; or no more."""
        send_control(self._control, RestPacket(rests))

    def drain(self) -> None:
        """Forget the frames that wait."""
        while self._newest(0.0):
            pass

    def close(self) -> None:
        """Stop the base and let go of everything."""
        self.ask(ZERO)
        send_control(self._control, LeavePacket())
        self._thread.join(LOOP_END_TIMEOUT_S)
        self.robot.close()
        self._stream.close()  # whatever waits to be sent is given up
        self._sender.close()
        for end in self._ends:
            end.close()

    def _newest(self, wait: float) -> list[SensorFrame]:
        if not select.select([self._stream], [], [], wait)[0]:
            return []
        return [
            message for message in self._received.feed(self._stream.recv(READ)) if isinstance(message, SensorFrame)
        ]

    def _run(self) -> None:
        try:
            self._loop.run()
        except Exception:
            log.exception("The driver's loop failed")
