"""`beckon look`: who stands in pictures."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_json, tell, write, write_json
from core.errors import BadSettings

if TYPE_CHECKING:
    from core.pipelines.look import LookedPicture, LookReport, PictureQuestion


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("look", help="who stands in pictures, and in which direction")
    parser.add_argument("pictures", nargs="*", type=Path, metavar="PICTURE")
    parser.add_argument(
        "--ask", type=Path, default=None, metavar="FILE.json", help="a list of questions: picture, azimuth_rad, …"
    )
    parser.add_argument(
        "--azimuth", type=float, default=None, metavar="RAD", help="where a voice comes from, left positive"
    )
    parser.add_argument("--azimuth-sd", type=float, default=0.05, metavar="RAD", help="how sure that is")
    parser.add_argument("--distance", type=float, default=None, metavar="M", help="what a laser measured there")
    places_of_camera = parser.add_mutually_exclusive_group()
    places_of_camera.add_argument(
        "--fov", type=float, default=None, metavar="RAD", help="width of the picture (1.05)"
    )
    places_of_camera.add_argument(
        "--camera", type=Path, default=None, metavar="CAMERA.json", help="the calibrated camera"
    )
    parser.add_argument("--draw", type=Path, default=None, metavar="DIR", help="where annotated pictures go")
    parser.add_argument("--settings", type=Path, default=None, metavar="FILE.toml")
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Look and tell. Of several pictures, those that cannot be read are named; exit code 1 when none could be."""
    if (chosen.ask is None) == (not chosen.pictures):
        raise BadSettings(
            "Give pictures, or a file with questions: beckon look PICTURE… or beckon look --ask FILE.json"
        )
    from core.files import check_folder
    from core.pipelines.look import look
    from core.settings import load

    if chosen.draw is not None:
        check_folder(chosen.draw)
    report = look(asked(chosen), load(chosen.settings).people, chosen.camera, chosen.draw)
    if report["engine"] == "drawn":
        tell(report["engine_says"])
    for one in report["answers"]:
        if "error" in one:
            tell(f"{one['picture']}: {one['error']}")
    if chosen.json:
        write_json(in_json(report, alone=chosen.ask is None))
    else:
        for one in report["answers"]:
            for line in sentences(one):
                write(line)
    return 1 if report["answers"] and all("error" in one for one in report["answers"]) else 0


def asked(chosen: argparse.Namespace) -> list[PictureQuestion]:
    """The questions of the command line. Raises BadInput."""
    from core.pipelines.look import PictureQuestion, questions_of, read_questions

    if chosen.ask is not None:
        return read_questions(chosen.ask)
    pattern = PictureQuestion(
        picture=Path(),
        name="",
        azimuth=chosen.azimuth,
        azimuth_sd=chosen.azimuth_sd,
        distance=chosen.distance,
        field=chosen.fov,
    )
    return questions_of(chosen.pictures, pattern)


def in_json(report: LookReport, *, alone: bool) -> dict[str, object]:
    """The answer in JSON: of a single picture its people at the top, of several named ones also by their names."""
    answers = report["answers"]
    if not alone:
        return {**report}
    if len(answers) == 1:
        return {**answers[0], "engine": report["engine"], "engine_says": report["engine_says"]}
    return {**report, "files": {one["picture"]: one for one in answers}}


def sentences(answer: LookedPicture) -> list[str]:
    """One picture for people."""
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
