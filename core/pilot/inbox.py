"""The pilot's inbox: whatever another thread wants of it, in the order in which it came."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable


class Inbox:
    """`put` from any thread; the pilot's thread opens it at the beginning of a frame."""

    def __init__(self) -> None:
        self.between_frames = threading.Lock()  # held while a frame is worked on
        self._waiting: deque[Callable[[float], object]] = deque()

    def put(self, request: Callable[[float], object]) -> None:
        """Call this with the stamp [s] of the next frame, before anything else is made of it."""
        self._waiting.append(request)

    def open(self, stamp: float) -> None:
        """Do what was asked for until now."""
        for _ in range(len(self._waiting)):
            self._waiting.popleft()(stamp)
