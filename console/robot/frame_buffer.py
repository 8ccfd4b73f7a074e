"""The buffer between the driver's frames and answers and the thread that takes them."""

from __future__ import annotations

import itertools
import threading

from core.robots.frame_sender import merged
from core.robots.ipc_messages import DriverTrouble, RobotAnswer
from core.sensors import SensorFrame

AnswerContent = bytes | DriverTrouble  # JSON of an answer


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
