"""Spoken orders on a running console, by the clock: `python -m tests.benchmarks.spoken_in_time [--rounds 5]`.

A person in the simulated room says every command, with other numbers in every round. Told, from the end of the words
in the sound: when they are known, when the wheels move, what was read, and which were refused, and why. This includes
all that the machine is busy with beside.
"""

import base64
import json
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from core.experiments.spoken_room import length_of_words
from core.speech.recognition.recognizer import for_words, pcm
from core.speech.settings import RATE_HZ
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.running_console import Console, console

SENTENCES = ("turn left", "continue {near:.1f} meters", "stop at {x:.1f} and {y:.1f}", "turn right", "come here")
MOUTH = (1.2, 0.9)  # [m] where the person stands
MOVES = 0.01  # [m/s], [rad/s]
PATIENCE = 8.0  # [s] after the words
EVERY = 0.02  # [s] between two looks
QUIET = 2.0  # [s] between two sentences


def sentences(rounds: int, seed: int) -> Iterator[str]:
    """What is said, one after the other."""
    rng = np.random.default_rng(seed)
    for _ in range(rounds):
        for one in SENTENCES:
            yield one.format(near=rng.integers(3, 10) / 10, x=rng.integers(1, 8) / 10, y=rng.integers(1, 8) / 10)


def said(running: Console, text: str, voice: str) -> dict[str, Any]:
    """One sentence → what became of it, times [s] from the end of its words."""
    samples = pcm(for_words(speak(text, VoiceSettings(voice=voice))).samples[:, 0])
    known = {one["id"] for one in running.get("/api/hearing")["utterances"]}
    running.post("/api/sim/say", {"pcm": base64.b64encode(samples).decode(), "id": "Ann"})
    end = time.monotonic() + length_of_words(samples, RATE_HZ)
    outcome: dict[str, Any] = {"said": text, "read": "", "known": None, "moves": None, "refused": ""}
    while time.monotonic() < end + PATIENCE and outcome["moves"] is None and not outcome["refused"]:
        time.sleep(EVERY)
        now = time.monotonic() - end
        newer = [one for one in running.get("/api/hearing")["utterances"] if one["id"] not in known]
        heard = [one for one in newer if one["words"]]  # the robot's motors may be taken for a voice without words
        if heard and outcome["known"] is None:
            outcome |= {"known": round(now, 2), "read": heard[0]["words"], "refused": heard[0]["reason"]}
        newest = running.get("/api/commands/history")["commands"][0]
        if newest["state"] == "refused" and newest["words"] == outcome["read"]:
            outcome["refused"] = newest["remark"]
        speed = running.get("/api/state")["velocity"]
        if abs(speed["v_m_s"]) > MOVES or abs(speed["w_rad_s"]) > MOVES:
            outcome["moves"] = round(now, 2)
    running.post("/api/commands", {"text": "stop moving"})
    return outcome


def main(*, rounds: int = 5, seed: int = 0, voice: str = PERSONS_VOICE) -> None:
    with console() as running:
        while running.get("/api/health")["reasons"]:
            time.sleep(0.1)
        running.post("/api/sim/place", {"what": "person", "id": "Ann", "x_m": MOUTH[0], "y_m": MOUTH[1]})
        running.post("/api/commands", {"text": "stop moving"})
        running.post("/api/hearing", {"listen": True, "obey": True})
        time.sleep(QUIET)
        rows = []
        for text in sentences(rounds, seed):
            rows.append(said(running, text, voice))
            print_row(rows[-1])
            time.sleep(QUIET)
    for kind in SENTENCES:
        verb = kind.partition("{")[0].strip()
        mine = [row for row in rows if row["said"].startswith(verb)]
        figures: dict[str, Any] = {"voice_control": sum(row["moves"] is not None for row in mine), "of": len(mine)}
        for what in ("known", "moves"):
            times = [row[what] for row in mine if row[what] is not None]
            if times:
                figures[f"{what}_s"] = {"p50": float(np.median(times)), "worst": max(times)}
        print_row(f"{verb}: {json.dumps(figures)}")


if __name__ == "__main__":
    run_command(main)
