"""COME HERE and FOLLOW ME with each detector: `python -m tests.benchmarks.company [--runs 50] [--engine pose|drawn]`.

An ideal base, the simulated camera and laser, drawn people at random places in random clothes; the networks' answers
come one to three frames late, as from a worker. Come: it stands 0.5 ± 0.1 m from who spoke. Follow: someone walks
off at 0.2 m/s for 8 s, and at the end the person who is followed is known within 0.4 m and is nearer than 1.8 m.
Cross: the same while someone else walks through between. Hidden: a board stands between for a second. Taught and
stranger: the person who was taught is chosen of two (and the other one is not).
"""

import dataclasses
import math
import sys
import time
from collections.abc import Callable, Sequence
from typing import Annotated

import cv2
import numpy as np

from core.commands.command import Progress
from core.errors import BeckonError, Refused
from core.geometry import Pose
from core.perception.people.engines import open_detector
from core.perception.people.looking import ImmediateLook, LookAnswer, PersonDetector, PersonLook
from core.perception.people.parts import PeopleSettings
from core.simulation.world import COLOURS, Thing
from tests.benchmarks.command import print_row, run_command
from tests.core.commands.stage import STEP
from tests.core.commands.test_company import Company, ann, follow

LATE = 3  # frames


class LateLook(ImmediateLook):
    """Answers some frames after it was asked."""

    def __init__(self, detector: PersonDetector, rng: np.random.Generator) -> None:
        super().__init__(detector)
        self._rng, self._frames = rng, 0

    def answer(self) -> LookAnswer | None:
        self._frames += 1
        if self._frames < self._rng.integers(1, LATE + 1):
            return None
        self._frames = 0
        return super().answer()


class Scene(Company):
    """People on a stage, and what looks for them."""

    def __init__(self, look: PersonLook | None) -> None:
        super().__init__()
        self.look = look


def placed(scene: Scene, name: str, rng: np.random.Generator, look: str = "") -> None:
    """A person 1.2 to 3 m away, anywhere around."""
    angle, far = float(rng.uniform(-2.5, 2.5)), float(rng.uniform(1.2, 3.0))
    clothes = look or f"{COLOURS[rng.integers(len(COLOURS))]}/{COLOURS[rng.integers(len(COLOURS))]}"
    scene.stands(name, far * math.cos(angle), far * math.sin(angle), clothes)


def come(scene: Scene, rng: np.random.Generator) -> bool:
    placed(scene, "Ann", rng)
    scene.speaks("Ann", off=float(rng.normal(0, 0.05)))
    told = scene.obey("come here")
    return told.finished == "done" and abs(scene.to("Ann") - 0.5) <= 0.1


def keeps(scene: Scene, told: list[Progress]) -> bool:
    person, at = told[-1].person, scene.people["Ann"].pose
    if told[-1].finished or person is None:
        return False
    return math.dist(person.position.tolist(), (at.x, at.y)) < 0.4 and scene.to("Ann") < 1.8


def walk(scene: Scene, rng: np.random.Generator) -> bool:
    scene.stands("Ann", float(rng.uniform(1.3, 2.6)), float(rng.uniform(-0.4, 0.4)), "red/blue")
    return keeps(scene, follow(scene, 11.0, {"Ann": (0.2, float(rng.uniform(-0.05, 0.05)))}))


def cross(scene: Scene, rng: np.random.Generator) -> bool:
    scene.stands("Ann", 2.0, 0.0, "red/blue")
    scene.stands("Bob", float(rng.uniform(1.7, 2.4)), -3.0, "white/green")
    return keeps(scene, follow(scene, 11.0, {"Ann": (0.2, 0.02), "Bob": (0.0, float(rng.uniform(0.5, 0.9)))}))


def hidden(scene: Scene, rng: np.random.Generator) -> bool:
    scene.stands("Ann", float(rng.uniform(1.8, 2.4)), 0.0, "red/blue")
    scene.speaks("Ann")
    action = scene.begin("follow me")
    began = scene.stamp
    told: list[Progress] = []
    while scene.stamp < began + 10.0 and not (told and told[-1].finished):
        told.append(scene.step(action))
        passed = scene.stamp - began
        if passed > 3.0:
            one = scene.people["Ann"]
            x, y = one.pose.x + 0.2 * STEP, one.pose.y
            scene.people["Ann"] = dataclasses.replace(one, pose=Pose(x, y, 0.0))
        scene.people.pop("board", None)
        if 5.0 < passed < 6.0:
            at = scene.people["Ann"].pose
            place = Pose(at.x - 0.5, at.y, math.pi / 2)
            scene.people["board"] = Thing(id="board", what="cabinet", pose=place, length=1.4, depth=0.05, height=2.0)
    return keeps(scene, told)


def taught(scene: Scene, rng: np.random.Generator) -> bool:
    scene.who = ann()
    side = 1.0 if rng.random() < 0.5 else -1.0
    scene.stands("Ann", float(rng.uniform(2.6, 3.2)), side * 0.5, "red/blue")
    scene.stands("Bob", float(rng.uniform(2.4, 3.0)), -side * 0.4, "green/black")
    scene.speaks("Ann", sd=0.1, off=float(rng.normal(0, 0.05)))
    told, action = Progress(), scene.begin("come here")
    while told.person is None and scene.stamp < 12.0:
        told = scene.step(action)
    at = scene.people["Ann"].pose
    return told.person is not None and math.dist(told.person.position.tolist(), (at.x, at.y)) < 0.4


def stranger(scene: Scene, rng: np.random.Generator) -> bool:
    scene.who = ann()
    scene.stands("Bob", float(rng.uniform(2.4, 3.2)), float(rng.uniform(-0.4, 0.4)), "green/black")
    scene.speaks("Bob", off=float(rng.normal(0, 0.05)))
    try:
        scene.obey("come here")
    except Refused:
        return True
    return False


SCENES: dict[str, Callable[[Scene, np.random.Generator], bool]] = {
    "come": come,
    "follow": walk,
    "cross": cross,
    "hidden": hidden,
    "taught": taught,
    "stranger": stranger,
}


def main(
    *,
    runs: int = 50,
    engine: Sequence[Annotated[str, ("pose", "drawn")]] = (),
    scene: Sequence[Annotated[str, SCENES]] = (),
) -> None:
    cv2.setNumThreads(1)
    report: dict[str, dict[str, str]] = {}
    for kind in engine or ("pose", "drawn"):
        for name in scene or SCENES:
            good, why, began = 0, dict[str, int](), time.process_time()
            for number in range(runs):
                rng = np.random.default_rng(1000 + number)
                look = LateLook(open_detector(PeopleSettings(engine="pose")), rng) if kind == "pose" else None
                try:
                    good += SCENES[name](Scene(look), rng)
                except BeckonError as trouble:
                    why[str(trouble)] = why.get(str(trouble), 0) + 1
            spent = (time.process_time() - began) / runs
            report.setdefault(kind, {})[name] = f"{good} of {runs}"
            sys.stderr.write(f"{kind:6} {name:9} {good} of {runs}, {spent:.1f} s a run {why or ''}\n")
    print_row(report)


if __name__ == "__main__":
    run_command(main)
