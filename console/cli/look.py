"""`beckon look`: who stands in pictures."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import GrowingJson, add_command, progress, tell, write, write_json
from core.errors import BadSettings

if TYPE_CHECKING:
    from core.pipelines.look import LookedPicture, PictureQuestion


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "look", run, "who stands in pictures, and in which direction")
    parser.add_argument("pictures", nargs="*", type=Path, metavar="PICTURE", help="files, or one recording")
    parser.add_argument(
        "--every", type=float, default=1.0, metavar="S", help="of a recording: time between two of its pictures"
    )
    parser.add_argument("--ask", type=Path, metavar="FILE.json", help="a list of questions: picture, azimuth_rad, …")
    parser.add_argument("--azimuth", type=float, metavar="RAD", help="where a voice comes from, left positive")
    parser.add_argument("--azimuth-sd", type=float, default=0.05, metavar="RAD", help="how sure that is")
    parser.add_argument("--distance", type=float, metavar="M", help="what a laser measured there")
    places_of_camera = parser.add_mutually_exclusive_group()
    places_of_camera.add_argument("--fov", type=float, metavar="RAD", help="width of the picture (1.05)")
    places_of_camera.add_argument("--camera", type=Path, metavar="CAMERA.json", help="the calibrated camera")
    parser.add_argument("--draw", type=Path, metavar="DIR", help="where annotated pictures go")
    parser.add_argument("--settings", type=Path, metavar="FILE.toml")


def run(chosen: argparse.Namespace) -> int:
    """Look, and tell of each picture when it was looked at. Those that cannot be read are named; exit code 1 when
    none could be.
    """
    if (chosen.ask is None) == (not chosen.pictures):
        raise BadSettings(
            "Give pictures, or a file with questions: beckon look PICTURE… or beckon look --ask FILE.json"
        )
    from core.files import check_folder
    from core.perception.people.engines import engine_of, says
    from core.pipelines.look import look_each, look_recorded
    from core.recording.recorded_senses import is_recording
    from core.settings import load

    if chosen.draw is not None:
        check_folder(chosen.draw)
    settings = load(chosen.settings)
    engine = {"engine": engine_of(settings.people), "engine_says": says(settings.people)}
    recorded = len(chosen.pictures) == 1 and is_recording(chosen.pictures[0])
    questions = [pattern_of(chosen)] if recorded else asked(chosen)
    with progress() as shown:
        where = chosen.camera, chosen.draw
        if recorded:
            found = look_recorded(chosen.pictures[0], questions[0], settings, *where, chosen.every, shown)
        else:
            found = look_each(questions, settings.people, *where, shown)
        looked = _warned(found)
        if chosen.json and chosen.ask is None and len(questions) == 1 and not recorded:
            (one,) = answers = list(looked)
            write_json({**one, **engine})
        elif chosen.json:
            answers = _in_json(looked, engine, alone=chosen.ask is None)
        else:
            answers = [_written(one) for one in looked]
    if engine["engine"] == "drawn":
        tell(engine["engine_says"])
    return 1 if answers and all("error" in one for one in answers) else 0


def _warned(looked: Iterator[LookedPicture]) -> Iterator[LookedPicture]:
    """The same answers; each says what went wrong, and what is doubtful where it comes first."""
    doubts: set[str] = set()
    for one in looked:
        for doubt in (found["sentence"] for found in one.get("faults", ())):
            if doubt not in doubts:
                tell(doubt)
            doubts.add(doubt)
        if trouble := one.get("error") or one.get("remark"):
            tell(f"{one['picture']}: {trouble}")
        yield one


def _written(one: LookedPicture) -> LookedPicture:
    for line in sentences(one):
        write(line)
    return one


def _in_json(looked: Iterator[LookedPicture], engine: dict[str, str], *, alone: bool) -> list[LookedPicture]:
    """Print the answers as one JSON object that grows; those about pictures `alone` also by their names."""
    answers: list[LookedPicture] = []
    first = next(looked, None)  # what forbids looking at all is raised before anything is printed
    with GrowingJson("answers", named=False) as growing:
        for one in () if first is None else chain((first,), looked):
            answers.append(one)
            growing.add(one)
            growing.tail = {"processing_s": round(sum(each["processing_s"] for each in answers), 4), **engine}
            if alone:
                growing.tail["files"] = {each["picture"]: each for each in answers}
    return answers


def asked(chosen: argparse.Namespace) -> list[PictureQuestion]:
    """The questions of the command line. Raises BadInput."""
    from core.pipelines.look import questions_of, read_questions

    return read_questions(chosen.ask) if chosen.ask is not None else questions_of(chosen.pictures, pattern_of(chosen))


def pattern_of(chosen: argparse.Namespace) -> PictureQuestion:
    """The question of the command line about every picture. Raises BadInput."""
    from core.pipelines.look import PictureQuestion

    return PictureQuestion(
        picture="",
        path=Path(),
        azimuth_rad=chosen.azimuth,
        azimuth_sd_rad=chosen.azimuth_sd,
        distance_m=chosen.distance,
        fov_rad=chosen.fov,
    )


def sentences(answer: LookedPicture) -> list[str]:
    if "error" in answer:
        return []
    name, people = answer["picture"], answer["people"]
    if not people:
        return [f"{name}: I see nobody there."]
    lines: list[str] = []
    for one in people:
        azimuth, sd = math.degrees(one["azimuth_rad"]), math.degrees(one["azimuth_sd_rad"])
        side = "left" if azimuth > 0 else "right"
        where = f"{abs(azimuth):.1f}° to the {side}, ± {sd:.1f}°"
        lines.append(f"{name}: someone {where}, about {one['distance_m']:.1f} m away, K {one['k']:.2f}")
    return lines
