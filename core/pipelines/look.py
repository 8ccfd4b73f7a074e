"""People in picture files: the work of `beckon look`."""

import math
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NotRequired, TypedDict

import cv2
import msgspec
import numpy as np
from msgspec import structs

from core.calibration.files.camera_files import read_camera
from core.calibration.files.pictures import own_names, read_colour, read_upright, size_words
from core.errors import BadInput
from core.files import folder_at, save, text_of
from core.geometry import OPTICAL, Transform
from core.message import Array
from core.optics import CameraModel
from core.perception.people.detector import Rectangle
from core.perception.people.engines import open_detector
from core.perception.people.looking import ASKED_SD_RAD, LookQuestion, PersonDetector
from core.perception.people.parts import PeopleSettings
from core.progress import UNSEEN, WorkProgress
from core.recording.read_report import ReadReport
from core.recording.recorded_senses import RecordedImage, sights
from core.sensors import Camera
from core.sensors.camera import lens_faults
from core.sensors.checks import FoundFault, found_faults
from core.settings import Settings

FIELD_OF_VIEW_RAD = 1.05  # that a picture is wide where nothing is known of its camera; a telephone's is about that
MIN_FIELD_RAD, MAX_FIELD_RAD = 0.05, 2.8  # of a field of view
MIN_DISTANCE_M, MAX_DISTANCE_M = 0.2, 100.0
EYE_HEIGHT_M = 1.15  # above the floor, for the detector that needs a height
EVERY_S = 1.0  # between the pictures of a recording
MAX_SIDE_PX = 1280  # of a picture's longer side; larger ones are shrunk before they are looked at
MIN_CONTRAST_LEVELS = 20.0  # of 255, between the dark and the bright of a picture in which people could be seen
MAX_BLACK_LEVEL = 50.0  # of 255, of the bright of a black picture
MOST_QUESTIONS, MOST_BYTES = 20_000, 8 * 2**20  # of a file with questions
COLOURS = ((80, 200, 255), (90, 220, 90), (255, 170, 60))  # of head, torso and feet, blue-green-red

Edges = tuple[float, float, float, float]


class PersonEntry(TypedDict):
    """A person in a picture; boxes are left, top, right, bottom [pixel], k1 to k3 null for what is not in it."""

    box: Edges
    head: Edges
    torso: Edges
    feet: Edges
    k1: float | None
    k2: float | None
    k3: float | None
    k: float
    azimuth_rad: float
    azimuth_sd_rad: float
    distance_m: float


class LookedPicture(TypedDict):
    """The answer to one question."""

    picture: str
    people: list[PersonEntry]  # best first
    processing_s: float  # for looking, without reading the file
    drawing: NotRequired[str]  # the annotated picture
    t_s: NotRequired[float]  # of a recorded picture, from the first one
    remark: NotRequired[str]  # why nobody could be seen in the picture
    faults: NotRequired[list[FoundFault]]  # of the camera's calibration
    error: NotRequired[str]  # why the picture was not looked at


class QuestionRow(msgspec.Struct, frozen=True, kw_only=True):
    """A row of a file with questions."""

    picture: str  # as the answer calls it
    azimuth_rad: float | None = None  # left positive, from the camera's axis; None: look anywhere
    azimuth_sd_rad: float = ASKED_SD_RAD
    distance_m: float | None = None
    fov_rad: float | None = None  # None: by the camera's calibration, else FIELD_OF_VIEW_RAD


class PictureQuestion(QuestionRow, frozen=True, kw_only=True):
    """A question about a picture file."""

    path: Path
    pixels: Array | None = None  # (H, W, 3) of a recorded picture; None: those of the file


QUESTION_KEYS = QuestionRow.__struct_fields__
OTHER_UNIT = re.compile(r"(azimuth|azimuth_sd|distance|fov)(_(rad|deg|degrees|m|mm|cm))?", re.IGNORECASE)


def look_each(
    questions: Sequence[PictureQuestion],
    settings: PeopleSettings,
    camera: Path | None = None,
    draw: Path | None = None,
    progress: WorkProgress = UNSEEN,
) -> Iterator[LookedPicture]:
    """Answer questions about picture files → each answer as soon as it is known.

    A picture that cannot be used has an error instead of people. `camera`: a calibration of all of them; `draw`: a
    folder for annotated pictures. Raises BadInput and Unavailable, before the first answer where that can be known.
    """
    model = None if camera is None else read_camera(camera)
    for question in questions:
        _check(question)
    folder = None if draw is None else folder_at(draw)
    opened = cache(lambda: open_detector(settings))  # not before a picture could be read
    for number, question in enumerate(progress.each(questions, "pictures")):
        drawing = None if folder is None else folder / f"{question.path.stem}_people_{number}.jpg"
        answer = _answered(question, model, opened, drawing)
        yield answer if camera is None else _doubted(answer, camera.name, model)


def look_recorded(
    path: Path,
    pattern: PictureQuestion,
    settings: Settings,
    camera: Path | None = None,
    draw: Path | None = None,
    every_s: float = EVERY_S,
    progress: WorkProgress = UNSEEN,
) -> Iterator[LookedPicture]:
    """The same question about one picture every `every_s` [s] of a recording → each answer as soon as it is known.

    A picture is called by its time [s] from the first one. Without `camera` the calibration in the recording counts.
    Raises BadInput where it holds no pictures.
    """
    _check(pattern)
    model = None if camera is None else read_camera(camera)
    folder, opened = None if draw is None else folder_at(draw), cache(lambda: open_detector(settings.people))
    tally, start = ReadReport(path), None
    for found in sights(path, settings.log, tally, every_s, progress):
        if not isinstance(found, RecordedImage):
            continue
        start = found.stamp if start is None else start
        at = found.stamp - start
        known = model or (found.model if pattern.fov_rad is None else None)
        asked = structs.replace(pattern, path=path, picture=f"{path.name} {at:.1f} s", pixels=found.pixels)
        drawing = None if folder is None else folder / f"{path.stem}_people_{at:07.1f}.jpg"
        answer = _doubted(_answered(asked, known, opened, drawing), (camera or path).name, known)
        yield {**answer, "t_s": round(at, 3)}
    if start is None:
        raise BadInput(" ".join((f"{path.name} holds no pictures.", *tally.report("recording").warnings[:1])))


def read_questions(path: Path) -> list[PictureQuestion]:
    """A JSON file with a list of questions → the questions; pictures are relative to the file. Raises BadInput."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise BadInput(f"{path.name} is larger than {MOST_BYTES // 2**20} MB.")
        entries = msgspec.json.decode(text_of(path.read_bytes(), path.name), type=list[dict[str, Any]])
        rows = msgspec.convert(entries, list[QuestionRow])
    except OSError as trouble:
        raise BadInput(f"{path.name} cannot be read: {trouble.strerror or trouble}.") from None
    except (msgspec.MsgspecError, RecursionError) as wrong:
        raise BadInput(f"{path.name} holds no list of questions: {str(wrong)[:120]}") from None
    for name in dict.fromkeys(key for entry in entries for key in entry if key not in QUESTION_KEYS):
        if meant := OTHER_UNIT.fullmatch(name):
            own = next(key for key in QUESTION_KEYS if key.rpartition("_")[0] == meant[1].lower())
            raise BadInput(f"{path.name} says {name}, which is not read; write {own}.")
    if len(rows) > MOST_QUESTIONS:
        raise BadInput(f"{path.name} holds {len(rows)} questions; at most {MOST_QUESTIONS} are answered in one run.")
    return [PictureQuestion(**structs.asdict(row), path=path.parent / row.picture) for row in rows]


def questions_of(files: Sequence[Path], pattern: PictureQuestion) -> list[PictureQuestion]:
    """The same question about several files."""
    return [
        structs.replace(pattern, path=path, picture=name) for path, name in zip(files, own_names(files), strict=True)
    ]


def _check(question: PictureQuestion) -> None:
    """Raises BadInput with a sentence for numbers that mean nothing."""
    bounds = (
        ("azimuth", question.azimuth_rad, -math.pi, math.pi, "rad"),
        ("sd of the azimuth", question.azimuth_sd_rad, 0.0, 1.0, "rad"),
        ("distance", question.distance_m, MIN_DISTANCE_M, MAX_DISTANCE_M, "m"),
        ("field of view", question.fov_rad, MIN_FIELD_RAD, MAX_FIELD_RAD, "rad"),
    )
    for name, value, low, high, unit in bounds:
        if value is not None and not low <= value <= high:
            raise BadInput(f"The {name} must lie between {low:.3g} and {high:.3g} {unit}, not {value:.6g}.")
    if question.distance_m is not None and question.azimuth_rad is None:
        raise BadInput("A distance needs the azimuth in which it was measured.")


def _answered(
    question: PictureQuestion, model: CameraModel | None, opened: Callable[[], PersonDetector], drawing: Path | None
) -> LookedPicture:
    answer: LookedPicture = {"picture": question.picture, "people": [], "processing_s": 0.0}
    try:
        pixels = question.pixels
        if pixels is None:
            pixels = read_upright(question.path) if model is None else read_colour(question.path)
        camera = _camera(question, model, pixels)
    except BadInput as wrong:
        return {**answer, "error": f"{str(wrong)[:1].upper()}{str(wrong)[1:]}."}
    detector = opened()
    began = time.perf_counter()
    found, factor = _found(question, camera, pixels, detector)
    answer["processing_s"] = round(time.perf_counter() - began, 4)
    answer["people"] = [_person(one, factor) for one in found]
    if remark := _contrast_remark(pixels):
        answer["remark"] = remark
    if drawing is not None:
        answer["drawing"] = save(drawing, drawn(pixels, answer["people"]))
    return answer


def _doubted(answer: LookedPicture, sensor: str, model: CameraModel | None) -> LookedPicture:
    """The same answer, with what is improbable in the calibration that it was found by."""
    faults = () if model is None else lens_faults(sensor, model)
    return {**answer, "faults": found_faults(faults)} if faults else answer


def _contrast_remark(pixels: Array) -> str:
    """A sentence where nobody could be seen in a picture (H, W, 3), or ""."""
    dark, bright = np.percentile(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), (1, 99))
    if bright - dark >= MIN_CONTRAST_LEVELS:
        return ""
    shade = "black" if bright < MAX_BLACK_LEVEL else "of one shade"
    return f"The picture is nearly {shade}: nobody could be seen in it."


def _camera(question: PictureQuestion, model: CameraModel | None, pixels: Array) -> Camera:
    """The camera of a picture, level, at the height of a table. Raises BadInput for another's calibration."""
    height, width = pixels.shape[:2]
    if model is None:
        focal = width / 2 / math.tan((question.fov_rad or FIELD_OF_VIEW_RAD) / 2)
        model = CameraModel(width=width, height=height, fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2)
    elif abs(width / model.width - height / model.height) > 0.01 * width / model.width:
        raise BadInput(f"it is {size_words(pixels)}, the camera file is for {model.width}x{model.height}")
    else:
        model = model.scaled(width / model.width)
    return Camera(model=model, mounting=Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, EYE_HEIGHT_M])))


def _found(
    question: PictureQuestion, camera: Camera, pixels: Array, detector: PersonDetector
) -> tuple[tuple[Rectangle, ...], float]:
    """Return the people who were found in the shrunk picture, and its size as a share of the picture's."""
    factor = min(1.0, MAX_SIDE_PX / max(pixels.shape[:2]))
    if factor < 1:
        pixels = cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        camera = replace(camera, model=camera.model.scaled(factor))
    asked = LookQuestion(
        pixels=pixels,
        camera=camera,
        bearing=question.azimuth_rad,
        sd=question.azimuth_sd_rad,
        distances=() if question.distance_m is None else (question.distance_m,),
        on_floor=False,
    )
    found = detector.look(asked)
    return (found if question.azimuth_rad is None else found[:1]), factor


def _person(found: Rectangle, factor: float) -> PersonEntry:
    head, torso, feet = found.parts
    sd = found.bearing_sd if found.bearing_sd is not None else 0.05 / max(found.distance, 0.1)
    return {
        "box": _edges(found.box, factor),
        "head": _edges(head.box, factor),
        "torso": _edges(torso.box, factor),
        "feet": _edges(feet.box, factor),
        "k1": _rounded(head.likelihood),
        "k2": _rounded(torso.likelihood),
        "k3": _rounded(feet.likelihood),
        "k": round(found.value, 4),
        "azimuth_rad": round(found.bearing, 5),
        "azimuth_sd_rad": round(sd, 5),
        "distance_m": round(found.distance, 3),
    }


def _rounded(likelihood: float | None) -> float | None:
    return None if likelihood is None else round(likelihood, 4)


def _edges(box: Edges, factor: float) -> Edges:
    left, top, right, bottom = (round(edge / factor, 1) for edge in box)
    return left, top, right, bottom


def drawn(pixels: Array, people: Sequence[PersonEntry]) -> bytes:
    """Draw everybody who was found into a picture (H, W, 3) → JPEG."""
    picture = pixels.copy()
    thick = max(1, round(max(picture.shape[:2]) / 500))
    for one in people:
        for box, colour in zip((one["head"], one["torso"], one["feet"]), COLOURS, strict=True):
            _outlined(picture, box, colour, thick)
        _outlined(picture, one["box"], (255, 255, 255), thick)
        left, _, _, bottom = one["box"]
        words = f"K {one['k']:.2f}  {math.degrees(one['azimuth_rad']):+.0f} deg"
        place = (round(left) + 4, max(round(bottom) - 6, 14))
        cv2.putText(picture, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.45 * thick, (255, 255, 255), thick)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].tobytes()


def _outlined(picture: Array, box: Edges, colour: tuple[int, int, int], thick: int) -> None:
    left, top, right, bottom = (round(edge) for edge in box)
    cv2.rectangle(picture, (left, top), (right, bottom), colour, thick)
