"""Whether words that are read ten seconds late move the robot: `python -m tests.benchmarks.frozen_reader`.

A running console with two busy loops beside it. "Turn left" is said at a page's microphone and in the room by turns;
the processes that read words are stopped before and go on ten seconds later. A motion is any row of the gate's diary
that moves. First the same is said without the freeze, to see that it would move the robot.
"""

import base64
import contextlib
import itertools
import json
import threading
import time
from typing import Any

import psutil
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from console.messages.audio import AUDIO_HEADER, AUDIO_KIND, AUDIO_RATE
from core.gate.trace import read_trace
from core.speech.recognition.recognizer import for_words, pcm
from core.speech.synthesis import VoiceSettings, speak
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.gate_timing import busy
from tests.benchmarks.running_console import Console, console

FROZEN = 10.0  # [s]
AFTER = 6.0  # [s] for words that are read now to become a motion
WORDS = "turn left"
QUIET = bytes(2 * AUDIO_RATE // 2)


class Page:
    """A control socket that shows every half second that it is alive, and a microphone."""

    def __init__(self, running: Console) -> None:
        origin: Any = f"http://127.0.0.1:{running.port}"
        url = f"ws://127.0.0.1:{running.port}/ws"
        self._control = connect(url, origin=origin, compression=None, max_size=None)
        self._sound = connect(f"{url}/audio", origin=origin, compression=None)
        self._begun = time.monotonic()
        threading.Thread(target=self._live, daemon=True).start()
        for line in (self._control, self._sound):
            threading.Thread(target=self._read, args=(line,), daemon=True).start()

    def _live(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while True:
                self._control.send(json.dumps({"kind": "echo", "t": 0.0}))
                time.sleep(0.5)

    def _read(self, line: Connection) -> None:
        with contextlib.suppress(ConnectionClosed):
            for _ in line:
                pass

    def say(self, samples: bytes) -> None:
        """As fast as one speaks, with the button held."""
        self._sound.send(json.dumps({"kind": "listen", "mode": "held"}))
        sound, step = QUIET + samples + QUIET, 2 * AUDIO_RATE // 20
        due = time.monotonic()
        for number, at in enumerate(range(0, len(sound) - 1, step)):
            clock = 1000 * (due - self._begun)
            self._sound.send(AUDIO_HEADER.pack(AUDIO_KIND, number, clock) + sound[at : at + step])
            due += 0.05
            time.sleep(max(0.0, due - time.monotonic()))
        self._sound.send(json.dumps({"kind": "rest"}))


def readers(running: Console) -> list[psutil.Process]:
    """The processes that read words."""
    found: list[psutil.Process] = []
    for one in psutil.Process(running.process.pid).children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):
            if "--worker=words" in one.cmdline():
                found.append(one)
    return found


def trial(running: Console, page: Page, samples: bytes, source: str, frozen: float) -> bool:
    """Whether the robot moves after the words."""
    running.post("/api/stop")
    time.sleep(2.5)
    stopped = readers(running) if frozen else []
    for one in stopped:
        one.suspend()
    begun = len(read_trace(running.trace))
    if source == "page":
        page.say(samples)
    else:
        running.post("/api/sim/say", {"pcm": base64.b64encode(samples).decode(), "id": "Ann"})
        time.sleep(len(samples) / 2 / AUDIO_RATE)
    time.sleep(frozen)
    for one in stopped:
        one.resume()
    time.sleep(AFTER)
    return any(row.v or row.w for row in read_trace(running.trace)[begun:])


def main(*, trials: int = 20, loops: int = 2) -> None:
    samples = pcm(for_words(speak(WORDS, VoiceSettings())).samples[:, 0])
    with console() as running, busy(loops):
        while running.get("/api/health")["reasons"] or running.get("/api/state")["slam"]["looking_around"]:
            time.sleep(0.2)
        running.post("/api/sim/place", {"what": "person", "id": "Ann", "x_m": 1.2, "y_m": 0.9})
        page = Page(running)
        running.post("/api/hearing", {"listen": True, "obey": True})
        while len(readers(running)) < 2 or running.get("/api/state")["ears"]["starting"]:
            time.sleep(0.2)
        for frozen, count in ((0.0, 4), (FROZEN, trials)):
            moved = 0
            for number, source in zip(range(count), itertools.cycle(("page", "room")), strict=False):
                moves = trial(running, page, samples, source, frozen)
                newest = running.get("/api/commands/history?limit=1")["commands"][0]
                told = {"frozen_s": frozen, "trial": number, "source": source, "moved": moves}
                told |= {"newest": newest["heard_as"] or newest["words"], "remark": newest["remark"]}
                print_row(told)
                moved += moves
            print_row(f"reader frozen for {frozen:g} s: {moved} of {count} moved")


if __name__ == "__main__":
    run_command(main)
