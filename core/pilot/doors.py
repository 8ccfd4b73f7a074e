"""Doors to the pilot's own things: what comes through any thread waits for the next frame."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable


class Doors:
    """`put` from any thread; the pilot's thread opens them between two frames."""

    def __init__(self) -> None:
        self.between_frames = threading.Lock()  # held while a frame is worked on
        self._waiting: deque[Callable[[], object]] = deque()

    def put(self, wish: Callable[[], object]) -> None:
        """Do this before the next frame."""
        self._waiting.append(wish)

    def open(self) -> None:
        """Do what was wished for, in its order."""
        for _ in range(len(self._waiting)):
            self._waiting.popleft()()
