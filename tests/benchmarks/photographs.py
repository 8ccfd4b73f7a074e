"""How well real people are found: `python -m tests.benchmarks.photographs [--peer PYTHON] [--sheets DIR]`.

Photographs of ../shared/data/people_photos, whose PROVENANCE.md says where they come from. Of every kind of picture
(COCO or Penn-Fudan, with people or without), sorted by name, the first half was looked at while the search was made
(`--part dev`), the other half only measured (`--part test`, the default).

Each standing person is asked for `--rounds` times: the direction of the head, off by a normal error of 0.05 rad, in a
picture 1 rad wide, and the distance that the torso's length gives, off by 12 % (lognormal). Found: the box overlaps
the hand-made one by 0.4 (IoU). Head found: the middle of the head lies in that of the person. Directions asked on
pictures without anybody are drawn at random. Partial views are those of views.tsv. The embedded detector is asked the
same; `--peer` names an interpreter with OpenCV 4, whose HOG people detector looks at whole pictures.
"""

import csv
import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np

from core.geometry import OPTICAL, Transform
from core.message import Array
from core.models import find
from core.optics import CameraModel
from core.perception.people.appearance import Appearance, alike
from core.perception.people.body import Box, overlap
from core.perception.people.detector import Rectangle
from core.perception.people.engines import DrawnDetector
from core.perception.people.looking import LookQuestion, PersonDetector
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.detector import PoseDetector
from core.perception.people.pose.networks import LiteRtNetworks, OpenCvNetworks, has_litert
from core.sensors import Camera
from tests.benchmarks.command import print_row, run_command

PHOTOS = Path(__file__).resolve().parents[3] / "shared/data/people_photos"
FIELD = 1.0  # [rad] that a picture is taken to be wide
AZIMUTH_SD, DISTANCE_SD = 0.05, 0.12  # [rad]; share
NEAREST, FARTHEST = 1.5, 8.0  # [m] asked on pictures without anybody
FOUND = 0.4  # overlap

PEER = """
import cv2, json, sys, time
hog = cv2.HOGDescriptor()
hog.setSVMDetector(cv2.HOGDescriptor_getDefaultPeopleDetector())
cv2.setNumThreads(1)
rows = []
for name in json.load(sys.stdin):
    picture = cv2.imread(name)
    began = time.process_time()
    boxes, weights = hog.detectMultiScale(picture, winStride=(8, 8), padding=(16, 16), scale=1.05)
    spent = time.process_time() - began
    rows.append([spent, [[float(v) for v in box] for box, w in zip(boxes, weights) if float(w) > 0.5]])
json.dump({"version": cv2.__version__, "rows": rows}, sys.stdout)
"""


@dataclass(frozen=True)
class Person:
    number: str
    standing: bool
    box: Box
    head: Box
    torso: Box

    @property
    def length(self) -> float:
        """Of the torso [pixel], without its margins."""
        return (self.torso[3] - self.torso[1]) / 1.24


@dataclass(frozen=True)
class Photo:
    file: str
    people: tuple[Person, ...]
    view: Box | None = None  # what is cut out [pixel]

    @property
    def pixels(self) -> Array:
        """(H, W, 3) uint8."""
        pixels = cv2.imread(str(PHOTOS / "pictures" / self.file))
        assert pixels is not None
        if self.view is None:
            return pixels
        left, top, right, bottom = (round(edge) for edge in self.view)
        return np.ascontiguousarray(pixels[max(top, 0) : bottom, max(left, 0) : right])


@dataclass
class Score:
    """What came out of one detector for one kind of question."""

    asked: int = 0
    found: int = 0
    heads: int = 0
    empty: int = 0
    alarms: int = 0
    spent: list[float] = field(default_factory=list)  # [s] of processor time a question
    empty_spent: list[float] = field(default_factory=list)

    def row(self) -> dict[str, float]:
        share = lambda part, whole: round(part / whole, 3) if whole else math.nan  # noqa: E731
        return {
            "asked": self.asked,
            "found": share(self.found, self.asked),
            "head": share(self.heads, self.asked),
            "empty": self.empty,
            "alarms": share(self.alarms, self.empty),
            "ms": round(1e3 * float(np.mean(self.spent)), 1) if self.spent else math.nan,
            "ms_empty": round(1e3 * float(np.mean(self.empty_spent)), 1) if self.empty_spent else math.nan,
        }


def photos(part: str) -> list[Photo]:
    people: dict[str, list[Person]] = {}
    for row in _rows("people.tsv"):
        boxes = [_box(row, name) for name in ("", "head_", "torso_")]
        people.setdefault(row["file"], []).append(Person(row["person"], row["kind"] == "standing", *boxes))
    groups: dict[tuple[str, bool], list[Photo]] = {}
    for row in _rows("pictures.tsv"):
        kind = row["kind"], row["file"].startswith("Fudan")
        groups.setdefault(kind, []).append(Photo(row["file"], tuple(people.get(row["file"], ()))))
    kept: list[Photo] = []
    for group in groups.values():
        group.sort(key=lambda one: one.file)
        half = (len(group) + 1) // 2
        kept += group[:half] if part == "dev" else group[half:] if part == "test" else group
    return kept


def views(whole: Sequence[Photo], name: str) -> list[Photo]:
    """Partial views of one kind, each with its person."""
    by_file = {one.file: one for one in whole}
    cut: list[Photo] = []
    for row in _rows("views.tsv"):
        photo = by_file.get(row["file"])
        if photo is None or row["view"] != name:
            continue
        left, top, right, bottom = edges = _box(row, "")
        (person,) = [one for one in photo.people if one.number == row["person"]]
        left, top = max(left, 0.0), max(top, 0.0)
        boxes = [_moved(box, left, top) for box in (person.box, person.head, person.torso)]
        within = boxes[0][0], boxes[0][1], min(boxes[0][2], right - left), min(boxes[0][3], bottom - top)
        within = max(within[0], 0.0), max(within[1], 0.0), within[2], within[3]
        cut.append(Photo(row["file"], (Person(person.number, True, within, boxes[1], boxes[2]),), edges))
    return cut


def measured(
    photographs: Sequence[Photo],
    detector: PersonDetector,
    how: str,
    rounds: int,
    tell: Callable[[Photo, Person | None, tuple[Rectangle, ...], bool], None] = lambda *_: None,
) -> Score:
    """Ask for everybody; `how`: "distance", "direction" or "anywhere"."""
    score, rng = Score(), np.random.default_rng(20)
    for photo in photographs:
        pixels = photo.pixels
        camera = camera_of(pixels)
        if not photo.people:
            for _ in range(rounds if how != "anywhere" else 1):
                question = _nobody(pixels, camera, how, rng)
                people, spent = _looked(detector, question)
                score.empty += 1
                score.alarms += bool(people)
                score.empty_spent.append(spent)
                tell(photo, None, people, bool(people))
            continue
        everybody: tuple[Rectangle, ...] | None = None
        for person in photo.people:
            if not person.standing:
                continue
            for _ in range(rounds if how != "anywhere" else 1):
                if how == "anywhere" and everybody is not None:
                    people, spent = everybody, 0.0
                else:
                    people, spent = _looked(detector, _person_seen(pixels, camera, person, how, rng))
                    everybody = people
                    score.spent.append(spent)
                good = [one for one in people if overlap(one.box, person.box) >= FOUND]
                score.asked += 1
                score.found += bool(good)
                score.heads += any(_inside(one.parts[0].box, person.head) for one in people)
                tell(photo, person, people, bool(good))
    return score


GAINS = ((0.6, 0.6, 0.6), (1.3, 1.3, 1.3), (0.8, 1.0, 1.1), (1.1, 1.0, 0.85))  # of blue, green, red
HARDER = 4  # pictures of each person in which more than the light is changed
KNOWN = (0.8, 0.85, 0.9, 0.95)  # shares of those who are known again, of the ROC


def other_sights(pixels: Array, rng: np.random.Generator) -> Iterator[tuple[str, float, bool, Array]]:
    """The same photograph in other light, and as another camera might take it: kind, size, mirrored, pixels."""
    for gains in GAINS:
        yield "light", 1.0, False, np.clip(pixels * np.array(gains), 0, 255).astype(np.uint8)
    for number in range(HARDER):
        gain = np.exp(rng.normal(0, 0.25)) * np.exp(rng.normal(0, 0.08, 3))
        lit = 255 * np.clip((pixels / 255.0) ** np.exp(rng.normal(0, 0.15)) * gain, 0, 1)
        size = float(rng.uniform(0.5, 1.0))
        mirrored = np.ascontiguousarray(lit[:, ::-1] if number % 2 else lit, np.float32)
        small = cv2.resize(mirrored, None, fx=size, fy=size, interpolation=cv2.INTER_AREA)
        noisy = np.clip(small + rng.normal(0, 3, small.shape), 0, 255).astype(np.uint8)
        packed = cv2.imencode(".jpg", noisy, [cv2.IMWRITE_JPEG_QUALITY, 75])[1]
        sight = cv2.imdecode(packed, cv2.IMREAD_COLOR)
        assert sight is not None
        yield "harder", size, bool(number % 2), sight


def elsewhere(person: Person, width: int, size: float, *, mirrored: bool) -> Person:
    """Where a person is in the changed picture, so many pixels wide."""

    def moved(box: Box) -> Box:
        left, top, right, bottom = (edge * size for edge in box)
        return (width - right, top, width - left, bottom) if mirrored else (left, top, right, bottom)

    return Person(person.number, person.standing, moved(person.box), moved(person.head), moved(person.torso))


def sights_of(
    photographs: Sequence[Photo], detector: PersonDetector
) -> list[tuple[Photo, Appearance, dict[str, list[Appearance]]]]:
    """Everybody who is found: the looks in the photograph, and in the changed ones by their kind."""
    rng = np.random.default_rng(21)
    seen: list[tuple[Photo, Appearance, dict[str, list[Appearance]]]] = []
    for photo in photographs:
        pixels = photo.pixels
        changed = list(other_sights(pixels, rng))
        for person in photo.people:
            first = _looks(pixels, person, detector, rng) if person.standing else None
            if first is None:
                continue
            others: dict[str, list[Appearance]] = {"light": [], "harder": []}
            for kind, size, mirrored, sight in changed:
                there = elsewhere(person, sight.shape[1], size, mirrored=mirrored)
                looks = _looks(sight, there, detector, rng)
                others[kind] += [] if looks is None else [looks]
            seen.append((photo, first, others))
    return seen


def clothes(photographs: Sequence[Photo], detector: PersonDetector) -> dict[str, dict[str, float]]:
    """Whether someone is known again by the looks: taught by the photograph, seen in changed ones, and others.

    `known`: share of the sights that are taken for the person; `strangers_taken`: share of others' changed sights
    that are; `beside`: the same of strangers in the same photograph; `chosen`: how often the taught one of two in one
    photograph is the likelier one; `at_85` …: strangers taken at that share of known.
    """
    seen, report = sights_of(photographs, detector), dict[str, dict[str, float]]()
    least = PeopleSettings().alike
    for kind in ("light", "harder"):
        own = np.array([alike(who, one) for _, who, others in seen for one in others[kind]])
        rows = [
            (photo is other, alike(who, one))
            for number, (photo, who, _) in enumerate(seen)
            for at, (other, _, others) in enumerate(seen)
            if at != number
            for one in others[kind]
        ]
        beside, strangers = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
        pairs = [
            alike(who, mine) > alike(who, one)
            for number, (photo, who, my_own) in enumerate(seen)
            for at, (other, _, others) in enumerate(seen)
            if at != number and photo is other
            for mine, one in zip(my_own[kind], others[kind], strict=False)
        ]
        report[kind] = {
            "people": len(seen),
            "sights": len(own),
            "known": round(float(np.mean(own >= least)), 3),
            "pairs": len(rows),
            "strangers_taken": round(float(np.mean(strangers >= least)), 3),
            "pairs_beside": int(beside.sum()),
            "beside_taken": round(float(np.mean(strangers[beside] >= least)), 3),
            "chosen_of_two": round(float(np.mean(pairs)), 3),
        } | {
            f"strangers_at_{100 * share:.0f}": round(float(np.mean(strangers >= np.quantile(own, 1 - share))), 3)
            for share in KNOWN
        }
    return report


def _looks(pixels: Array, person: Person, detector: PersonDetector, rng: np.random.Generator) -> Appearance | None:
    """The looks of someone who is asked for by direction and distance; None: not found."""
    people = detector.look(_person_seen(pixels, camera_of(pixels), person, "distance", rng))
    return next((one.looks for one in people if overlap(one.box, person.box) >= FOUND), None)


def peers_row(photographs: Sequence[Photo], interpreter: str) -> dict[str, float]:
    """OpenCV 4's HOG, which knows of no direction."""
    names = [str(PHOTOS / "pictures" / one.file) for one in photographs]
    run = subprocess.run(
        [interpreter, "-c", PEER], input=json.dumps(names), capture_output=True, text=True, check=True
    )
    score = Score()
    for photo, (spent, boxes) in zip(photographs, json.loads(run.stdout)["rows"], strict=True):
        edges = [(x, y, x + width, y + height) for x, y, width, height in boxes]
        if not photo.people:
            score.empty += 1
            score.alarms += bool(edges)
            score.empty_spent.append(spent)
            continue
        score.spent.append(spent)
        for person in photo.people:
            if person.standing:
                score.asked += 1
                score.found += any(overlap(box, person.box) >= FOUND for box in edges)
                score.heads += any(_crowned(box, person) for box in edges)
    return score.row()


def camera_of(pixels: Array) -> Camera:
    """A level camera 1.15 m up."""
    height, width = pixels.shape[:2]
    focal = width / 2 / math.tan(FIELD / 2)
    model = CameraModel(width=width, height=height, fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2)
    return Camera(model=model, mounting=Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, 1.15])))


def detectors() -> dict[str, PersonDetector]:
    """Those that are here."""
    named: dict[str, PersonDetector] = {"embedded (drawn figures)": DrawnDetector()}
    model = find("people")
    if model is not None:
        named["pose, OpenCV"] = PoseDetector(OpenCvNetworks(model.folder))
        if has_litert():
            named["pose, LiteRT"] = PoseDetector(LiteRtNetworks(model.folder))
    return named


def _looked(detector: PersonDetector, question: LookQuestion) -> tuple[tuple[Rectangle, ...], float]:
    began = time.process_time()
    people = detector.look(question)
    return people, time.process_time() - began


def _person_seen(pixels: Array, camera: Camera, person: Person, how: str, rng: np.random.Generator) -> LookQuestion:
    column = (person.head[0] + person.head[2]) / 2
    model = camera.model
    bearing = -math.atan((column - model.cx) / model.fx) + float(rng.normal(0, AZIMUTH_SD))
    stature = person.length / 0.29
    distance = model.fy * 1.7 / stature * math.exp(float(rng.normal(0, DISTANCE_SD)))
    return _question(pixels, camera, bearing, distance, how)


def _nobody(pixels: Array, camera: Camera, how: str, rng: np.random.Generator) -> LookQuestion:
    bearing = float(rng.uniform(-0.45, 0.45))
    distance = math.exp(float(rng.uniform(math.log(NEAREST), math.log(FARTHEST))))
    return _question(pixels, camera, bearing, distance, how)


def _question(pixels: Array, camera: Camera, bearing: float, distance: float, how: str) -> LookQuestion:
    return LookQuestion(
        pixels=pixels,
        camera=camera,
        bearing=None if how == "anywhere" else bearing,
        sd=AZIMUTH_SD,
        distances=(distance,) if how == "distance" else (),
        on_floor=False,
    )


def _rows(name: str) -> list[dict[str, str]]:
    with (PHOTOS / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def _box(row: dict[str, str], prefix: str) -> Box:
    x0, y0, x1, y1 = (float(row[f"{prefix}{edge}"] or "nan") for edge in ("x0", "y0", "x1", "y1"))
    return x0, y0, x1, y1


def _moved(box: Box, left: float, top: float) -> Box:
    return box[0] - left, box[1] - top, box[2] - left, box[3] - top


def _inside(box: Box, around: Box) -> bool:
    x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    return around[0] <= x <= around[2] and around[1] <= y <= around[3]


def _crowned(box: Box, person: Person) -> bool:
    """Whether the upper 16 % of a box are around the head."""
    return _inside((box[0], box[1], box[2], box[1] + 0.16 * (box[3] - box[1])), person.head)


class ContactSheet:
    """Pictures of those who were found and those who were missed."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder, self._name = folder, name
        self._tiles: dict[str, list[Array]] = {"found": [], "missed": [], "alarms": []}

    def add(self, photo: Photo, person: Person | None, people: tuple[Rectangle, ...], good: bool) -> None:
        """Draw one answer."""
        if person is None and not good:
            return
        picture = photo.pixels.copy()
        for one in people:
            for part, colour in zip(one.parts, ((80, 200, 255), (90, 220, 90), (255, 170, 60)), strict=True):
                _outlined(picture, part.box, colour)
            _outlined(picture, one.box, (255, 255, 255))
        if person is not None:
            _outlined(picture, person.box, (60, 60, 255))
        tile = cv2.resize(picture, (240, 240 * picture.shape[0] // picture.shape[1]))[:240]
        square = np.zeros((240, 240, 3), np.uint8)
        square[: tile.shape[0]] = tile
        self._tiles["alarms" if person is None else "found" if good else "missed"].append(square)

    def write(self) -> None:
        """All that there are, ten in a row."""
        self._folder.mkdir(parents=True, exist_ok=True)
        for kind, tiles in self._tiles.items():
            blank = np.zeros((240, 240, 3), np.uint8)
            rows = [
                np.hstack([*tiles[at : at + 10], *[blank] * (10 - len(tiles[at : at + 10]))])
                for at in range(0, len(tiles), 10)
            ]
            if rows:
                cv2.imwrite(str(self._folder / f"{self._name}-{kind}.jpg"), np.vstack(rows))


def _outlined(picture: Array, box: Box, colour: tuple[int, int, int]) -> None:
    left, top, right, bottom = (round(edge) for edge in box)
    cv2.rectangle(picture, (left, top), (right, bottom), colour, 2)


def main(
    *,
    part: Annotated[str, ("dev", "test", "all")] = "test",
    rounds: int = 4,
    peer: str | None = None,  # an interpreter with OpenCV 4
    sheets: Path | None = None,  # where contact sheets go
    only: str = "",  # detectors whose names hold this
    kind: str = "",  # kinds of question whose names hold this
) -> None:
    cv2.setNumThreads(1)
    whole = photos(part)
    nobody = [one for one in whole if not one.people]
    kinds = {
        "direction and distance": (whole, "distance"),
        "direction alone": (whole, "direction"),
        "anywhere": (whole, "anywhere"),
        "bust": (views(whole, "bust"), "distance"),
        "head cut off": (views(whole, "no_head"), "distance"),
        "legs alone": (views(whole, "legs"), "distance"),
    }
    report: dict[str, dict[str, Any]] = {}
    for name, detector in detectors().items():
        if only not in name:
            continue
        for asked_how, (some, how) in kinds.items():
            if kind not in asked_how:
                continue
            sheet = ContactSheet(sheets, f"{name}-{asked_how}".replace(" ", "_")) if sheets else None
            tell = sheet.add if sheet is not None else lambda *_: None
            row = measured(some, detector, how, 1 if sheet is not None else rounds, tell).row()
            report.setdefault(name, {})[asked_how] = row
            if sheet is not None:
                sheet.write()
            sys.stderr.write(f"{name:26} {asked_how:24} {row}\n")
        if "pose" in name and kind in "clothes":
            report.setdefault(name, {})["clothes"] = clothes(whole, detector)
            sys.stderr.write(f"{name:26} clothes {report[name]['clothes']}\n")
    if peer:
        report["HOG of OpenCV 4"] = {"anywhere": peers_row(whole, peer)}
        sys.stderr.write(f"HOG of OpenCV 4 {report['HOG of OpenCV 4']}\n")
    people = sum(one.standing for photo in whole for one in photo.people)
    print_row({"part": part, "standing": people, "nobody": len(nobody), "figures": report})


if __name__ == "__main__":
    run_command(main)
