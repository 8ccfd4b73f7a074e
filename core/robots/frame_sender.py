"""The way of frames from the driver to the console: the driver never waits, the newest frame wins."""

import pickle
import socket
import struct
import threading
from collections import deque
from dataclasses import replace
from typing import Any

from core.sensors import SensorFrame
from core.sensors.checks import distinct
from core.sensors.microphones import joined

LENGTH = struct.Struct("<Q")
MAX_SOUND_S = 3.0  # that may wait unsent
MIN_STANDING_RATE_HZ = 16.0  # of frames that are often enough while the robot stands
RESTING_RATE_HZ = 10.0  # of frames that are often enough while it stands and nobody looks
MAX_WAITING_ANSWERS = 64  # that may wait; more are dropped


def merged(older: SensorFrame, newer: SensorFrame) -> SensorFrame:
    """Two frames → one: the newer, with the older's scan, picture and contact where the newer has none.

    The sound of both is one sound, so that no word is lost, and their faults and notes are all there. Wheels count
    from the robot's start, so a frame that is left out loses nothing.
    """
    return replace(
        newer,
        scan=newer.scan or older.scan,
        image=newer.image or older.image,
        sound=joined(older.sound, newer.sound, MAX_SOUND_S),
        contact=newer.contact or older.contact,
        faults=distinct((*older.faults, *newer.faults)),
        notes=tuple(dict.fromkeys((*older.notes, *newer.notes))),
    )


def resting_rate(rate: float) -> float:
    """The robot's rate [Hz] → that of its frames to the console while it stands: two as one, where often enough."""
    return rate / 2 if rate / 2 >= MIN_STANDING_RATE_HZ else rate


class FrameSender:
    """Sends from a thread of its own: every answer, and of the frames the newest, merged with what waits unsent."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._answers: deque[Any] = deque(maxlen=MAX_WAITING_ANSWERS)
        self._frame: SensorFrame | None = None
        self._merged = 0  # frames that it is made of
        self._waits = False  # it goes with the next
        self._wake = threading.Condition()
        self._over = False
        self.gone = False  # nothing is sent any more: the other end does not listen, or the thread has failed
        self._thread = threading.Thread(target=self._run, name="frame-sender", daemon=True)
        self._thread.start()

    def put_frame(self, frame: SensorFrame, *, may_wait_for: int = 0) -> None:
        """Send this frame as soon as the pipe takes it, or as one with so many that come after it, at most."""
        with self._wake:
            self._merged = 1 if self._frame is None else self._merged + 1
            self._waits = self._merged <= may_wait_for
            self._frame = frame if self._frame is None else merged(self._frame, frame)
            if not self._waits:
                self._wake.notify()

    def put(self, message: object) -> None:
        """Send this before the next frame."""
        with self._wake:
            self._answers.append(message)
            self._wake.notify()

    def close(self, patience: float = 0.5) -> None:
        """Send what waits, for `patience` [s] at most, and end."""
        with self._wake:
            self._over, self._waits = True, False
            self._wake.notify()
        self._thread.join(patience)

    @property
    def _is_due(self) -> bool:
        return self._frame is not None and not self._waits

    def _run(self) -> None:
        try:
            self._send()
        finally:
            self.gone = True

    def _send(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._answers or self._is_due or self._over)
                if self._answers:
                    message: object = self._answers.popleft()
                elif self._frame is not None:
                    message, self._frame = self._frame, None
                else:
                    return
            try:
                raw = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
                self._end.sendall(LENGTH.pack(len(raw)) + raw)
            except OSError:
                return


class FrameReceiver:
    """The other end: bytes as they come → whole messages. Only for pipes between one's own processes."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, raw: bytes) -> list[Any]:
        """More bytes → the messages that are complete now."""
        self._bytes += raw
        messages: list[Any] = []
        while len(self._bytes) >= LENGTH.size:
            (length,) = LENGTH.unpack_from(self._bytes)
            if len(self._bytes) < LENGTH.size + length:
                break
            messages.append(pickle.loads(memoryview(self._bytes)[LENGTH.size : LENGTH.size + length]))
            del self._bytes[: LENGTH.size + length]
        return messages
