"""What the robot's own ears put into the history of what voices in the room said."""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from console.hearing import Ears
from console.history import History
from core.sensors.microphones import RESPEAKER_ODAS, Sound

NOTHING = {"words": "", "name": None, "heard_as": "", "reason": "Somebody spoke, but that was no command."}
TURN = {"words": "turn left", "name": "turn_left", "heard_as": "turn left", "reason": ""}


class Reads:
    """A worker that hears what it is told to, one utterance with every piece of sound."""

    def __init__(self) -> None:
        self.utterances: list[dict[str, Any]] = []

    async def begun(self) -> bool:
        return True

    async def feed(self, samples: Any, rate: int, stamp: float) -> list[dict[str, Any]]:
        return [self.utterances.pop(0) | {"begin": stamp, "end": stamp + 0.2, "final": True, "meant": ""}]


def test_talk_on_and_on_stands_in_the_history_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = Reads()
    monkeypatch.setattr("console.hearing.WordsWorker", lambda: worker)
    worker.utterances = [NOTHING, NOTHING, NOTHING, TURN, NOTHING, NOTHING]
    history = History(tmp_path, lambda _: None)
    ears = Ears(SimpleNamespace(), history, SimpleNamespace())  # type: ignore[arg-type]

    async def listen() -> None:
        for number in range(6):
            sound = Sound(stamp=0.2 * number, rate=16_000, samples=np.zeros((3200, 4)))
            ears.took(SimpleNamespace(stamp=0.2 * number, hearing=None), sound, RESPEAKER_ODAS)  # type: ignore[arg-type]
            while len(worker.utterances) > 5 - number:
                await asyncio.sleep(0)
            await asyncio.sleep(0.01)

    history.open()
    asyncio.run(listen())
    told = [deed.words for deed in reversed(history.newest_first(commands_only=True))]
    history.close()
    assert told == ["", "turn left", ""]
    assert len(ears.utterances) == 6
