"""How well people are found in pictures: `python -m tests.benchmarks.people [--scenes 150] [--peer PYTHON]`.

Pictures of the simulated laboratory, in which the model was never taught, by the robot's camera 16 cm above the floor
and by one like a webcam. Detected: the rectangle's axis within 0.25 m of the person's. False alarms are counted in
pictures without anybody, and beside the person. `--peer` names an interpreter with OpenCV 4 (opencv-python-headless
4.10 was measured), whose HOG people detector then sees the same pictures, twice as large; OpenCV 5 has none.

Then, of pictures with two people of whom one was taught at another place in other light: how often that one is chosen
where the voice may be either's, and found, or rightly refused, where it is the one's or the other's.
"""

import json
import math
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.perception.people.appearance import PersonProfile
from core.perception.people.brightness import levelled
from core.perception.people.detector import Rectangle, find_people
from core.perception.people.enrollment import learn, person_image
from core.perception.people.parts import PeopleSettings
from core.perception.people.vertical_plane import VerticalPlanes
from core.sensors import Camera
from core.simulation.camera import SimulatedCamera
from core.simulation.world import LAB, Thing
from tests.benchmarks.command import print_row, run_command
from tests.drawn_people import ROBOTS, VIEW_HALF_RAD, WEBCAM, DrawnPerson, DrawnScene, Stage

SOUND_SD = 0.05  # [rad] of the direction of the voice
WIDE = 0.5  # [rad] to either side: the whole picture
NEAR = 0.25  # [m] of a rectangle's axis to the person's
SETTINGS = PeopleSettings()

PEER = """
import cv2, json, sys, time
hog = cv2.HOGDescriptor()
hog.setSVMDetector(cv2.HOGDescriptor_getDefaultPeopleDetector())
cv2.setNumThreads(1)
told, spent = [], 0.0
for name in json.load(sys.stdin):
    picture = cv2.imread(name)
    began = time.perf_counter()
    large = cv2.resize(picture, None, fx=2, fy=2)
    boxes, weights = hog.detectMultiScale(large, winStride=(8, 8), padding=(16, 16), scale=1.05)
    spent += time.perf_counter() - began
    told.append([[float(v) / 2 for v in box] + [float(w)] for box, w in zip(boxes, weights) if w > 0.5])
json.dump({"version": cv2.__version__, "boxes": told, "seconds": spent}, sys.stdout)
"""


@dataclass(frozen=True)
class Kind:
    name: str
    people: int
    camera: Camera
    clutter: int = 2
    nearest: float = 1.0
    reach: float = 5.5
    light: tuple[float, float] = (0.5, 1.1)


KINDS = (
    Kind("robot's camera, 2.8 m and more", 1, ROBOTS, nearest=2.8),
    Kind("robot's camera, nearer: head cut off", 1, ROBOTS, nearest=1.6, reach=2.8),
    Kind("robot's camera, nearest: only legs", 1, ROBOTS, nearest=0.7, reach=1.6),
    Kind("webcam", 1, WEBCAM, nearest=1.6),
    Kind("among many things", 1, ROBOTS, clutter=10, nearest=1.6),
    Kind("two people", 2, ROBOTS, nearest=1.6),
    Kind("low light, a tenth", 1, ROBOTS, nearest=1.6, light=(0.08, 0.12)),
    Kind("nobody", 0, ROBOTS, clutter=10),
    Kind("nobody, webcam", 0, WEBCAM, clutter=10),
)


def pictures(kind: Kind, count: int, seed: int) -> list[DrawnScene]:
    """Scenes in which whoever is there is not hidden by more than a third."""
    stage = Stage(LAB, np.random.default_rng(seed), cameras=(kind.camera,))
    found: list[DrawnScene] = []
    while len(found) < count:
        scene = stage.scene(
            kind.people, clutter=kind.clutter, light=kind.light, reach=kind.reach, nearest=kind.nearest
        )
        if all(one.shown > 0.65 for one in scene.people):
            found.append(scene)
    return found


def fits(rectangle: Rectangle, one: DrawnPerson) -> bool:
    """Whether the rectangle stands where someone does."""
    return one.distance * abs(math.sin(rectangle.bearing - one.bearing)) < NEAR


def ours(scenes: Sequence[DrawnScene], rng: np.random.Generator) -> dict[str, float]:
    """Shares found and false alarms per picture: where a voice comes from, and in the whole picture."""
    found, alarms, everywhere, anywhere, errors = 0, 0, 0, 0, list[float]()
    spent = [0.0, 0.0]
    for scene in scenes:
        boards = VerticalPlanes(levelled(scene.pixels), scene.camera)
        speaker = scene.people[0] if scene.people else None
        bearing = speaker.bearing if speaker else float(rng.uniform(-VIEW_HALF_RAD, VIEW_HALF_RAD))
        began = time.process_time()
        told = find_people(boards, bearing + rng.normal(0, SOUND_SD), 2 * SOUND_SD, SETTINGS)
        spent[0] += time.process_time() - began
        good = [one for one in told if any(fits(one, person) for person in scene.people)]
        found += speaker is not None and bool(told) and fits(told[0], speaker)
        alarms += len(told) > len(good)
        errors += [abs(one.distance / speaker.distance - 1) for one in told[:1] if speaker and fits(one, speaker)]
        began = time.process_time()
        told = find_people(boards, 0.0, WIDE, SETTINGS)
        spent[1] += time.process_time() - began
        everywhere += sum(any(fits(one, person) for one in told) for person in scene.people)
        anywhere += sum(not any(fits(one, person) for person in scene.people) for one in told)
    many = len(scenes)
    people = max(1, sum(len(scene.people) for scene in scenes))
    return {
        "found_towards_voice": found / many if scenes[0].people else math.nan,
        "false_alarms_towards_voice": alarms / many,
        "found_anywhere": everywhere / people if scenes[0].people else math.nan,
        "false_alarms_anywhere": anywhere / many,
        "distance_error_median": float(np.median(errors)) if errors else math.nan,
        "ms_towards_voice": 1e3 * spent[0] / many,
        "ms_anywhere": 1e3 * spent[1] / many,
    }


def taught(one: DrawnPerson, camera: Camera) -> PersonProfile | None:
    """That person, learnt from four gestures elsewhere; None where the clothes do not stand out there."""
    eye = SimulatedCamera(camera, LAB, np.random.default_rng(7))
    background = eye.take(LAB, 0.0, Pose()).pixels.copy()
    pictures: list[Array] = []
    for gesture, turn in (("", 0.0), ("wide", 0.0), ("wave", 0.0), ("", math.pi / 2)):
        place = Pose(3.9, 0.0, math.pi + turn)
        thing = Thing(
            id="one",
            what="person",
            pose=place,
            length=0.4,
            depth=0.4,
            height=one.height,
            look=one.look,
            gesture=gesture,
        )
        pictures.append(eye.take(LAB.with_thing(thing), 0.0, Pose()).pixels.copy())
    try:
        return learn("one", [person_image(one, background) for one in pictures])
    except BadInput:
        return None


def choices(scenes: Sequence[DrawnScene]) -> dict[str, float]:
    """Shares of the scenes with two people of whom the first is the one who was taught."""
    rows: list[tuple[bool, ...]] = []
    unlike: list[bool] = []  # whether the other was taken, of those who share neither shirt nor trousers
    for scene in scenes:
        one, other = scene.people
        who = taught(one, scene.camera) if one.look != other.look else None
        if who is None:
            continue
        boards = VerticalPlanes(levelled(scene.pixels), scene.camera)
        middle, apart = (one.bearing + other.bearing) / 2, abs(one.bearing - other.bearing) / 2
        first = find_people(boards, middle, apart + SOUND_SD, SETTINGS, who=who)[:1]
        anybody = find_people(boards, middle, apart + SOUND_SD, SETTINGS)[:1]
        called = find_people(boards, one.bearing, 2 * SOUND_SD, SETTINGS, who=who)[:1]
        strange = find_people(boards, other.bearing, 2 * SOUND_SD, SETTINGS, who=who)
        rows.append(
            (
                any(fits(rectangle, one) for rectangle in first),
                any(fits(rectangle, other) for rectangle in first),
                any(fits(rectangle, one) for rectangle in anybody),
                any(fits(rectangle, one) for rectangle in called),
                any(fits(rectangle, other) for rectangle in strange),
            )
        )
        if not any(mine == theirs for mine, theirs in zip(one.look.split("/"), other.look.split("/"), strict=True)):
            unlike.append(rows[-1][-1])
    names = ("chosen_of_two", "other_chosen_of_two", "chosen_of_two_by_chance", "found_when_calling", "other_taken")
    shares = np.mean(np.array(rows, float), axis=0).tolist()
    told = {"scenes": len(rows), **dict(zip(names, shares, strict=True))}
    return told | {"scenes_unlike": len(unlike), "other_taken_unlike": float(np.mean(unlike))}


def peers(scenes: Sequence[DrawnScene], interpreter: str) -> dict[str, float]:
    """The same of OpenCV 4's detector, which knows of no direction and no floor."""
    with tempfile.TemporaryDirectory() as folder:
        names = [str(Path(folder) / f"{number}.png") for number in range(len(scenes))]
        for name, scene in zip(names, scenes, strict=True):
            cv2.imwrite(name, levelled(scene.pixels))
        run = subprocess.run(
            [interpreter, "-c", PEER], input=json.dumps(names), capture_output=True, text=True, check=True
        )
    told = json.loads(run.stdout)
    found = alarms = 0
    for scene, boxes in zip(scenes, told["boxes"], strict=True):
        axes = [_columns(scene, one) for one in scene.people]
        middles = [box[0] + box[2] / 2 for box in boxes]
        found += sum(any(low < middle < high for middle in middles) for low, high in axes)
        alarms += sum(not any(low < middle < high for low, high in axes) for middle in middles)
    people = max(1, sum(len(scene.people) for scene in scenes))
    return {
        "found_anywhere": found / people if scenes[0].people else math.nan,
        "false_alarms_anywhere": alarms / len(scenes),
        "ms_anywhere": 1e3 * told["seconds"] / len(scenes),
    }


def _columns(scene: DrawnScene, one: DrawnPerson) -> tuple[float, float]:
    """The columns within NEAR of someone's axis."""
    places = np.array([(side * NEAR, 0.5) for side in (1.0, -1.0)])
    seen: Array = VerticalPlanes(scene.pixels, scene.camera).pixels_of(one.distance, one.bearing, places)
    return float(seen[:, 0].min()), float(seen[:, 0].max())


def main(
    *,
    scenes: int = 150,
    seed: int = 101,
    peer: str | None = None,  # an interpreter with OpenCV 4
    as_json: bool = False,
) -> None:
    cv2.setNumThreads(1)
    report: dict[str, dict[str, dict[str, float]]] = {}
    for kind in KINDS:
        drawn = pictures(kind, scenes, seed)
        rows = {"ours": ours(drawn, np.random.default_rng(seed))}
        if kind.people == 2:
            rows["of two the one who was taught"] = choices(drawn)
        if peer:
            rows["OpenCV 4 HOG"] = peers(drawn, peer)
        report[kind.name] = rows
        if not as_json:
            for who, row in rows.items():
                figures = ", ".join(f"{key} {value:.3g}" for key, value in row.items())
                print_row(f"{kind.name} · {who}: {figures}")
    if as_json:
        print_row(report)
    elif not peer:
        print_row("No --peer given: OpenCV 4's HOG people detector was not measured.")


if __name__ == "__main__":
    run_command(main)
