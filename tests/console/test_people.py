"""Teaching the robot who somebody is, by pictures from anywhere, and to whom alone it comes."""

from __future__ import annotations

import asyncio
import json
import math
import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from console.door import Door
from console.logins import Person
from console.people.album import is_name, name_of
from console.people.school import GETS_READY, LOOKS, School
from console.people.showing import WAITS
from console.problems import Problem
from core.experiments.crowd import WEBCAM
from core.geometry import Pose
from core.perception.people.colours import Enrolled
from core.sensors import Image
from core.sensors.simulated_camera import SimulatedCamera
from core.world import LAB, Thing
from tests.console.in_process import InProcessRobot
from tests.console.live import Live, Reply

PNG = {"Content-Type": "image/png"}
LATE = 6  # pictures that are on their way


def person(x: float, *, gesture: str = "", turn: float = 0.0, look: str = "green/black") -> Thing:
    pose = Pose(x, 0.0, math.pi + turn)
    return Thing(id="p", what="person", pose=pose, length=0.4, depth=0.4, height=1.75, look=look, gesture=gesture)


@pytest.fixture(scope="module")
def pictures() -> dict[str, bytes]:
    """PNG files of a room as a webcam sees it: empty, and with somebody who does this or that."""
    webcam = SimulatedCamera(WEBCAM, LAB, np.random.default_rng(0))
    people = {
        "down": person(3.6),
        "again": person(3.6),
        "out": person(3.6, gesture="wide"),
        "wave": person(3.8, gesture="wave"),
        "side": person(3.6, turn=math.pi / 2),
        "near": person(1.2),
    }
    worlds = {"empty": LAB} | {name: LAB.with_thing(one) for name, one in people.items()}
    seen = {name: webcam.take(world, 0.0, Pose()).pixels.copy() for name, world in worlds.items()}
    seen["dark"] = seen["down"] // 8
    seen["moved"] = webcam.take(worlds["down"], 0.0, Pose(heading=0.15)).pixels.copy()
    return {name: cv2.imencode(".png", pixels)[1].tobytes() for name, pixels in seen.items()}


@pytest.fixture
def school(live: Live) -> Iterator[Live]:
    """A console that knows nobody, before and after."""

    def forget() -> None:
        for one in live.ask("GET", "/api/people", token=live.viewer).json["people"]:
            live.ask("DELETE", f"/api/people/{one['id']}", token=live.operator)

    forget()
    yield live
    forget()


def begin(live: Live) -> str:
    begun = live.ask("POST", "/api/people", token=live.operator)
    assert begun.status == 201 and begun.json["next"] == "" and "without anybody" in begun.json["advice"]
    return f"/api/people/{begun.json['id']}"


def send(live: Live, path: str, raw: bytes, **headers: str) -> Reply:
    told = {**PNG, **{name.replace("_", "-"): value for name, value in headers.items()}}
    return live.ask("POST", path, raw=raw, token=live.operator, headers=told)


def test_somebody_is_learnt_from_pictures_that_are_judged_in_words(school: Live, pictures: dict[str, bytes]) -> None:
    path = begin(school)
    early = send(school, f"{path}/pictures", pictures["down"])
    assert early.status == 409 and "background" in early.json["detail"]
    assert send(school, f"{path}/background", pictures["empty"]).json["next"] == "down"

    wrong = {
        "empty": "Nobody is in the picture",
        "near": "cut off",
        "dark": "too dark",
        "moved": "background",
    }
    for name, words in wrong.items():
        told = send(school, f"{path}/pictures", pictures[name]).json
        assert not told["newest"]["good"] and words in told["newest"]["words"], name
        assert told["pictures"] == []

    told = send(school, f"{path}/pictures", pictures["down"]).json
    assert told["newest"]["good"] and told["next"] == "out"
    assert [part["name"] for part in told["newest"]["parts"]] == ["head", "torso", "feet"]
    (head, torso, feet) = (part["box_px"] for part in told["newest"]["parts"])
    assert head[1] < torso[1] < feet[1] < told["newest"]["size"][1] and len(told["newest"]["outline"]) > 8
    again = send(school, f"{path}/pictures", pictures["again"]).json["newest"]
    assert not again["good"] and "too like" in again["words"]

    short = school.ask("POST", f"{path}/finish", {"name": "Ann"}, token=school.operator)
    assert short.status == 409 and "at least 3" in short.json["detail"]
    for name in ("out", "wave", "side"):
        told = send(school, f"{path}/pictures", pictures[name]).json
        assert told["newest"]["good"], told["newest"]["words"]
    assert told["ready"] and told["next"] == "" and len(told["pictures"]) == 4
    number = told["pictures"][0]["number"]
    shown = school.ask("GET", f"{path}/pictures/{number}.jpg", token=school.operator)
    assert shown.status == 200 and shown.body.startswith(b"\xff\xd8\xff")
    assert school.ask("GET", f"{path}/pictures/{number}.jpg", token=school.viewer).status == 403
    dropped = school.ask("POST", f"{path}/pictures/{number}/drop", token=school.operator).json
    assert dropped["next"] == "down" and len(dropped["pictures"]) == 3

    assert school.ask("POST", f"{path}/finish", {"name": " \u0007 "}, token=school.operator).status == 422
    done = school.ask("POST", f"{path}/finish", {"name": "  Ann  "}, token=school.operator)
    assert done.status == 201 and done.json["name"] == "Ann"
    assert school.ask("GET", f"{path}/pictures/{number}.jpg", token=school.operator).status == 404
    told = school.ask("GET", "/api/people", token=school.viewer).json
    assert [one["name"] for one in told["people"]] == ["Ann"] and told["enrolment"] is None

    folder = school.runtime.people.album.folder
    (file,) = folder.glob(f"{done.json['id']}*")
    assert file.stat().st_size < 3000, "numbers, no pictures"


def test_pictures_from_strangers_break_nothing(school: Live, pictures: dict[str, bytes]) -> None:
    path = begin(school)
    send(school, f"{path}/background", pictures["empty"])
    send(school, f"{path}/pictures", pictures["down"])
    chunk = b"IHDR" + struct.pack(">IIBBBBB", 20000, 20000, 8, 2, 0, 0, 0)
    header = struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    hostile = {
        "nothing": b"",
        "words": b"hello",
        "announces 400 Mpx": b"\x89PNG\r\n\x1a\n" + header + b"\0\0\0\0IEND\xaeB`\x82",
        "cut off": pictures["down"][:5000],
        "damaged": pictures["down"][:200] + bytes(4000) + pictures["down"][4200:],
        "tiny": cv2.imencode(".png", np.zeros((8, 8, 3), np.uint8))[1].tobytes(),
        "a bitmap": cv2.imencode(".bmp", np.zeros((80, 80, 3), np.uint8))[1].tobytes(),
    }
    for what, raw in hostile.items():
        for where in ("pictures", "background"):
            answer = send(school, f"{path}/{where}", raw)
            assert answer.status in (400, 422), (what, where, answer.status)
            assert answer.json["detail"].endswith("."), what
    other = cv2.imencode(".png", np.full((300, 300, 3), 99, np.uint8))[1].tobytes()
    assert "different size" in send(school, f"{path}/pictures", other).json["newest"]["words"]
    assert send(school, f"{path}/pictures", pictures["down"], Content_Type="text/html").status == 415
    assert send(school, f"{path}/pictures", pictures["down"], Content_Type="application/json").status == 415
    assert send(school, f"{path}/pictures", b"\xff\xd8\xff" + bytes(20_000_001)).status == 413
    assert send(school, "/api/people/0123456789ab/pictures", pictures["down"]).status == 404
    told = school.ask("GET", "/api/people", token=school.viewer).json["enrolment"]
    assert told["background"] and len(told["pictures"]) == 1, "nothing was lost"
    assert school.ask("DELETE", path, token=school.operator).status == 204
    assert school.ask("GET", "/api/people", token=school.viewer).json["enrolment"] is None


def test_a_viewer_sees_who_is_known_and_changes_nothing(school: Live) -> None:
    path = begin(school)
    asked: list[tuple[str, str, Any]] = [
        ("POST", "/api/people", None),
        ("POST", f"{path}/capture", {"what": "background"}),
        ("POST", f"{path}/show-me", {"on": True}),
        ("POST", f"{path}/finish", {"name": "Eve"}),
        ("POST", f"{path}/rename", {"name": "Eve"}),
        ("PUT", "/api/people/chosen", {"id": None}),
        ("DELETE", path, None),
    ]
    for method, where, body in asked:
        assert school.ask(method, where, body, token=school.viewer).status == 403, where
    assert school.ask("GET", "/api/people", token=school.viewer).status == 200
    assert school.ask("PUT", "/api/people/chosen", {"id": "0123456789ab"}, token=school.operator).status == 404
    assert school.ask("PUT", "/api/people/chosen", {}, token=school.operator).status == 422


ME = Person("1", "Anna", "operator")


class Obedient:
    """Of a pilot only what hears whom to obey."""

    def __init__(self) -> None:
        self.told: list[str | None] = []

    def obey_only(self, who: Enrolled | None) -> None:
        self.told.append(None if who is None else who.name)


def school_in(
    home: Path,
    complaints: list[str],
    robot: InProcessRobot | None = None,
    newest: Callable[[], Image | None] = lambda: None,
) -> tuple[School, Obedient]:
    door = Door.__new__(Door)
    door.pilot = pilot = Obedient()  # type: ignore[assignment]

    def tell(level: str, words: str) -> None:
        if level == "warning":
            complaints.append(words)

    found = School(home, robot or InProcessRobot(), door, tell, newest)
    asyncio.run(found.open())
    return found, pilot


def test_who_is_known_and_chosen_outlasts_a_restart(tmp_path: Path, pictures: dict[str, bytes]) -> None:
    complaints: list[str] = []
    first, pilot = school_in(tmp_path, complaints)

    async def teach() -> str:
        lesson = first.begin(ME)
        await first.background(lesson, {"content": pictures["empty"]})
        taken = [first.take(lesson, {"content": pictures["down"]}) for _ in range(4)]
        told = await asyncio.gather(*taken, return_exceptions=True)
        assert [str(one) for one in told if one] == ["Too many ask for this at once; try again in a moment."]
        assert len(lesson.taken) == 1, "the same picture twice at once counts once"
        for gesture in ("out", "wave"):
            await first.take(lesson, {"content": pictures[gesture]})

        first.album.folder.write_text("a disk that cannot be written")
        with pytest.raises(Problem, match="could not be written") as unwritten:
            await first.finish(lesson, "Ann")
        assert unwritten.value.status == 503 and first.people == {}
        first.album.folder.unlink()
        ann = (await first.finish(lesson, "Ann")).id
        with pytest.raises(Problem, match="of that name"):
            await first.finish(first.begin(ME), "ann")
        await first.choose(ann)
        await first.rename(ann, "Anna")
        await first.close()
        return ann

    ann = asyncio.run(teach())
    assert pilot.told == ["Ann", "Anna"]
    again, pilot = school_in(tmp_path, complaints)
    assert again.lesson is None, "a lesson that was under way is gone"
    assert again.chosen is not None and again.chosen.name == "Anna" and complaints == []
    np.testing.assert_allclose(again.chosen.colours, first.people[ann].who.colours)
    (tmp_path / "people" / f"{ann}.json.new").write_text("left by a crash")
    asyncio.run(again.forget(ann))
    assert pilot.told == [None] and again.people == {} and "anybody" in complaints.pop()
    assert not list((tmp_path / "people").glob(f"*{ann}*")), "nothing of it is left"
    last, _ = school_in(tmp_path, complaints)
    assert last.people == {} and last.chosen is None and complaints == []


def test_a_lesson_belongs_to_one_person_whatever_they_call_themselves(tmp_path: Path) -> None:
    school, _ = school_in(tmp_path, [])
    lesson = school.begin(ME)
    with pytest.raises(Problem, match="Anna is teaching me somebody now") as busy:
        school.begin(Person("2", "Anna", "operator"))
    assert busy.value.status == 409 and school.lesson is lesson
    anew = school.begin(ME)
    with pytest.raises(Problem, match="over"):
        asyncio.run(school.background(lesson, {"content": b""}))
    assert school.lesson is anew


@pytest.mark.parametrize(
    "name", ["Zoë", "李雷", "👩\u200d🚒 Ann", "می\u200cخواهم", "../../etc/passwd", "<b>Ann</b>", "x" * 40]
)
def test_people_are_called_what_they_want(name: str) -> None:
    assert name_of(f"  {name} ") == name and is_name(name)


@pytest.mark.parametrize(
    "name", ["", " \t", "\u200d", "\u3164", "\u0301", "Ann\u202enna", "A\x00nn", "\ud800", "x" * 41]
)
def test_a_name_that_cannot_be_read_is_refused_in_words(name: str) -> None:
    with pytest.raises(Problem, match="to be seen") as refused:
        name_of(name)
    assert refused.value.status == 422


@pytest.mark.parametrize(
    "spoil",
    [
        lambda told: told | {"colours": [[2.0] * 18] * 3},
        lambda told: told | {"colours": [[0.1]]},
        lambda told: told | {"name": ""},
        lambda told: told | {"id": "ffffffffffff"},
        lambda told: {},
    ],
)
def test_a_damaged_person_is_left_aside_in_words(tmp_path: Path, spoil: Any) -> None:
    row = [1 / 18] * 18
    card = {"version": 1, "id": "0123456789ab", "name": "Ann", "learnt_s": 1.0, "by": "me", "pictures": 3}
    whole = card | {"shape": 4.0, "colours": [row, row, row]}
    (tmp_path / "people").mkdir()
    file = tmp_path / "people" / "0123456789ab.json"
    (tmp_path / "people" / "chosen.json").write_text('{"id": "0123456789ab"}')
    file.write_text(json.dumps(whole))
    complaints: list[str] = []
    assert school_in(tmp_path, complaints)[0].chosen is not None and complaints == []
    file.write_text(json.dumps(spoil(whole)))
    found, _ = school_in(tmp_path, complaints)
    assert found.people == {} and found.chosen is None and len(complaints) == 2
    assert file.exists()


class Late:
    """A simulated robot whose pictures come long after they were taken, as on a busy machine."""

    def __init__(self) -> None:
        self.robot = InProcessRobot()
        self._seen: deque[Image] = deque(maxlen=LATE)

    def newest(self) -> Image | None:
        """A moment passes whenever somebody looks."""
        for _ in range(4):
            image = self.robot.robot.read().image
            if image is not None:
                self._seen.append(image)
        return self._seen[0] if len(self._seen) == LATE else None

    @property
    def people(self) -> list[str]:
        """Who stands in the room."""
        return [thing["id"] for thing in self.robot.ask({"do": "plan"})["things"] if thing["what"] == "person"]


def test_a_simulated_person_shows_how_it_goes_however_late_the_pictures_come(tmp_path: Path) -> None:
    late = Late()
    school, _ = school_in(tmp_path, [], late.robot, late.newest)
    before = late.people

    async def shown() -> None:
        lesson = school.begin(ME)
        await school.show_me(lesson, on=True)
        await school.show_me(lesson, on=False)
        assert not lesson.showing, "whoever is called back at once has not begun"
        await school.show_me(lesson, on=True)
        waits: set[str] = set()
        async with asyncio.timeout(60.0):
            while lesson.showing:
                waits.add(lesson.waits)
                await asyncio.sleep(0.005)
        assert lesson.trouble == "" and [one.gesture for one in lesson.taken] == ["down", "out", "wave", "side"]
        assert lesson.number == 5, "no picture was of a moment before"
        assert {WAITS, LOOKS, GETS_READY} <= waits and lesson.waits == ""
        assert school.told()["stands"] and len(late.people) == len(before) + 1
        await school.finish(lesson, "Sim")
        await school.send_away()
        assert not school.told()["stands"] and late.people == before

        lesson = school.begin(ME)
        await school.show_me(lesson, on=True)
        while lesson.background is None:
            await asyncio.sleep(0.005)
        await school.cancel(lesson)
        assert late.people == before and school.lesson is None and not lesson.showing
        await school.close()

    asyncio.run(shown())
