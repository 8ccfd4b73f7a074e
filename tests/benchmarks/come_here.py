"""COME HERE and FOLLOW ME through the whole chain, at the simulator's speed: `python -m tests.benchmarks.come_here`.

A voice in the simulated room → echoes → four microphones → direction → (with `--words` the words, read by the
recognizer, else the command as if typed) → turn → picture → laser → plan → wheels through the gate. Success: the
robot says that it has come and stands 0.5 ± 0.1 m from the person's middle; following: after a minute of walking it
still has the person and is within 1.8 m. The error of every sense is that against the simulator's truth.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from core.commands.command import Command
from core.errors import BadInput
from core.experiments.practice_voice import practice_voice
from core.experiments.rehearsal import Rehearsal
from core.geometry import Pose, wrap
from core.perception.people.call import Call
from core.sensors.microphones import joined
from core.snapshot import Snapshot, Undertaking
from core.speech.recognizer import for_words
from core.speech.settings import SpeechSettings
from core.speech.spoken import judge
from core.speech.transcriber import Transcriber
from core.world import cast, world_named

NEAR = (0.4, 0.6)  # [m] of success
FOLLOWED = 1.8  # [m]
TALL = 0.9  # [m] what is as tall hides somebody
LISTEN = 2.6  # [s] after a voice began
READ = 8.0  # [s] in which a spoken command must be understood
CLOTHES = ("red", "blue", "green", "black", "white", "grey", "brown", "yellow")
WALK = [[1.5, 1.0], [2.6, 1.2], [2.4, 0.2], [1.0, -0.6], [0.0, -1.2], [-1.2, -0.4], [-0.6, 0.8]]  # [m] a round


class Meeting:
    """One robot, one person, one seed."""

    def __init__(self, seed: int, *, words: bool, world: str) -> None:
        self.chance = np.random.default_rng(seed)
        self.robot = Rehearsal(f"sim:{world}", seed=seed)
        self.errors: dict[str, list[float]] = {"laser_m": [], "camera_rad": [], "sound_rad": [], "fused_m": []}
        self._world = world_named(world)
        self._transcriber = Transcriber(SpeechSettings()) if words else None
        self.robot.run(2.0)

    def place(self, nearest: float = 1.0, farthest: float = 3.8, **more: Any) -> tuple[float, float]:
        """Set Ann down somewhere around the robot → where (x, y) [m]."""
        here = self.robot.truth
        while True:
            away, angle = self.chance.uniform(nearest, farthest), self.chance.uniform(-math.pi, math.pi)
            x, y = here.x + away * math.cos(angle), here.y + away * math.sin(angle)
            shirt, trousers = (str(self.chance.choice(CLOTHES)) for _ in range(2))
            wish = {"x_m": x, "y_m": y, "heading_rad": float(self.chance.uniform(-3, 3))}
            if self._behind_something(here, float(x), float(y)):
                continue
            try:
                self.robot.robot.ask(_ann(clothes=f"{shirt}/{trousers}", **wish, **more))
            except BadInput:
                continue
            return float(x), float(y)

    def _behind_something(self, here: Pose, x: float, y: float) -> bool:
        """Whether a wall or a tall thing stands between: who cannot be seen is not come to."""
        way = np.array([[x - here.x, y - here.y]])
        hits = cast(np.array([here.x, here.y]), way, self._world.surfaces(TALL))
        return bool(hits.distance[0] < 1.0)

    def command(self, words: str) -> tuple[int | None, Call | None]:
        """Ann says it → the undertaking, if it was understood, and from where it was heard."""
        if self._transcriber is None:
            voice = 8000 * practice_voice(self.chance, 1.2, 16_000)
            self.robot.robot.ask({"do": "say", "id": "Ann", "pcm": voice.clip(-32768, 32767).astype("<i2").tobytes()})
            call = self._hear(LISTEN)[1]
            return self.robot.tell(words), call
        self.robot.robot.ask({"do": "say", "id": "Ann", "text": words})
        command, call = self._hear(READ)
        if command is None or command.name != words.replace(" ", "_") or call is None:
            return None, call
        return self.robot.order(dataclasses.replace(command, call=call), "ears"), call

    def _hear(self, seconds: float) -> tuple[Command | None, Call | None]:
        """Listen for so long, or until a command was understood."""
        call: Call | None = None
        pieces = None
        array = self.robot.robot.profile.microphones
        assert array is not None
        for snapshot in self.robot.frames(seconds):
            for voice in snapshot.hearing.voices[:1] if snapshot.hearing else ():
                call = voice.call
            sound = self.robot.frame.sound
            if sound is None or self._transcriber is None:
                continue
            pieces = joined(
                pieces, type(sound)(stamp=sound.stamp, rate=sound.rate, samples=array.heard(sound)[:, :1]), 8
            )
            if pieces is None or pieces.duration < 0.2:
                continue
            for heard in self._transcriber.feed(for_words(pieces)):
                said = judge(heard)
                if said.final and said.command is not None:
                    return said.command, call
            pieces = None
        return None, call

    def measure(self, x: float, y: float) -> Callable[[Snapshot], None]:
        """Who watches the errors of every sense against where the person truly is."""

        def watch(snapshot: Snapshot) -> None:
            person, truth = snapshot.person, snapshot.truth
            if person is None or truth is None or snapshot.stamp - person.stamp > 0.05:
                return
            known: Pose = snapshot.estimate.pose
            place = known.apply(truth.inverse().apply(np.array([[x, y]])))[0]
            if person.laser is not None and "laser" in person.used:
                self.errors["laser_m"].append(float(np.hypot(*(person.laser - place))))
            if person.camera is not None and "camera" in person.used:
                ray = person.camera
                self.errors["camera_rad"].append(wrap(ray.azimuth - math.atan2(place[1] - ray.y, place[0] - ray.x)))
            self.errors["fused_m"].append(float(np.hypot(*(person.position - place))))

        return watch

    def wait(self, number: int, seconds: float, watch: Callable[[Snapshot], None]) -> Undertaking | None:
        """Until it has ended; None: it has not."""
        for snapshot in self.robot.frames(seconds):
            watch(snapshot)
            if (ended := self.robot.ended(number)) is not None:
                return ended
        return None


def _ann(**wish: Any) -> dict[str, Any]:
    return {"do": "place", "what": "person", "id": "Ann", **wish}


def come(seed: int, *, words: bool, world: str = "lab") -> dict[str, Any]:
    """One COME HERE."""
    meeting = Meeting(seed, words=words, world=world)
    x, y = meeting.place()
    truth = meeting.robot.truth
    number, call = meeting.command("come here")
    if call is not None:
        meeting.errors["sound_rad"].append(wrap(call.azimuth - math.atan2(y - truth.y, x - truth.x)))
    row: dict[str, Any] = {"seed": seed, "distance_m": truth.distance_to(x, y), "state": "not understood", "why": ""}
    if number is not None:
        ended = meeting.wait(number, 120.0, meeting.measure(x, y))
        row |= {"state": ended.state if ended else "under way", "why": ended.remark if ended else ""}
    row["apart_m"] = meeting.robot.truth.distance_to(x, y)
    row["success"] = row["state"] == "done" and NEAR[0] <= row["apart_m"] <= NEAR[1]
    return row | {"contacts": meeting.robot.contacts, "faults": meeting.robot.faults(), "errors": meeting.errors}


def follow(seed: int, *, words: bool, seconds: float = 60.0) -> dict[str, Any]:
    """One FOLLOW ME: Ann walks a round, Bob crosses it."""
    meeting = Meeting(seed, words=words, world="lab")
    robot = meeting.robot
    robot.robot.ask(_ann(x_m=1.6, y_m=0.2, clothes="red/blue"))
    number, _ = meeting.command("follow me")
    row: dict[str, Any] = {"seed": seed, "state": "not understood", "why": ""}
    if number is not None:
        robot.run(4.0)
        robot.robot.ask(_ann(x_m=1.6, y_m=0.2, path_m=WALK, speed_m_s=0.2, again=True))
        bob = {"do": "place", "what": "person", "id": "Bob", "clothes": "white/green", "x_m": 1.2, "y_m": 2.4}
        robot.robot.ask(bob | {"path_m": [[1.2, -1.6], [1.2, 2.4]], "speed_m_s": 0.4, "again": True})
        ended = meeting.wait(number, seconds, lambda _: None)
        row |= {"state": ended.state if ended else "following", "why": ended.remark if ended else ""}
    things = robot.robot.ask({"do": "plan"})["things"]
    ann = next(one for one in things if one["id"] == "Ann")
    row["apart_m"] = robot.truth.distance_to(ann["x_m"], ann["y_m"])
    row["success"] = row["state"] == "following" and row["apart_m"] < FOLLOWED
    return row | {"contacts": robot.contacts, "faults": robot.faults(), "errors": meeting.errors}


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The table's line."""
    told: dict[str, Any] = {
        "runs": len(rows),
        "success_rate": float(np.mean([row["success"] for row in rows])),
        "contacts": sum(row["contacts"] for row in rows),
        "faults": sum(len(row["faults"]) for row in rows),
        "failures": [
            {key: row[key] for key in ("seed", "state", "why", "apart_m")} for row in rows if not row["success"]
        ],
    }
    for sense in ("laser_m", "camera_rad", "sound_rad", "fused_m"):
        errors = np.abs([error for row in rows for error in row["errors"][sense]])
        if len(errors):
            told[sense] = {"median": float(np.median(errors)), "p95": float(np.quantile(errors, 0.95))}
    return told


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="COME HERE and FOLLOW ME through the whole chain.")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--command", choices=("come_here", "follow_me"), default="come_here")
    parser.add_argument("--world", choices=("lab", "floor"), default="lab", help="of come_here")
    parser.add_argument("--words", action="store_true", help="spoken by the voice and read by the recognizer")
    asked = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for seed in range(asked.seed, asked.seed + asked.runs):
        if asked.command == "come_here":
            row = come(seed, words=asked.words, world=asked.world)
        else:
            row = follow(seed, words=asked.words)
        shown = {key: value for key, value in row.items() if key != "errors"}
        sys.stderr.write(json.dumps(shown) + "\n")
        rows.append(row)
    sys.stdout.write(json.dumps(summary(rows), indent=1) + "\n")


if __name__ == "__main__":
    main()
