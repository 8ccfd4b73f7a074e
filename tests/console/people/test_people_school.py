"""The school itself: what lasts, whose lesson it is, and someone in the simulated room who shows how it goes."""

import asyncio
import json
from collections import deque
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.access.logins import Person
from console.control.dispatcher import CommandDispatcher
from console.http.problems import Problem
from console.people.demo import WAITS
from console.people.service import GETS_READY, LOOKS, EnrollmentService
from console.people.store import is_name, name_of
from core.errors import Unwritable
from core.perception.people.appearance import PersonProfile
from core.robots.requests import ReadPlan
from core.sensors import Image
from tests.console.in_process import InProcessRobot

ANN = "0123456789ab"
LATE = 3  # pictures that are on their way
ME = Person("1", "Anna", "operator")


class Obedient:
    """Of a pilot only what hears whom to obey."""

    def __init__(self) -> None:
        self.told: list[str | None] = []

    def obey_only(self, who: PersonProfile | None) -> None:
        self.told.append(None if who is None else who.name)


@cache
def standing() -> InProcessRobot:
    """A robot that nobody has started: time passes for it only when it is read."""
    return InProcessRobot()


def school_in(
    home: Path,
    complaints: list[str],
    robot: InProcessRobot | None = None,
    newest: Callable[[], Image | None] = lambda: None,
) -> tuple[EnrollmentService, Obedient]:
    dispatcher = CommandDispatcher.__new__(CommandDispatcher)
    dispatcher.pilot = pilot = Obedient()  # type: ignore[assignment]

    def tell(level: str, words: str) -> None:
        if level == "warning":
            complaints.append(words)

    found = EnrollmentService(home, robot or standing(), dispatcher, tell, newest)
    asyncio.run(found.open())
    return found, pilot


def card(**other: Any) -> dict[str, Any]:
    """A person's file."""
    told = {"version": 2, "id": ANN, "name": "Ann", "learnt_s": 1.0, "by": "me", "pictures": 3}
    return {**told, "looks": looks(), **other}


def looks(**other: Any) -> dict[str, Any]:
    """A person's looks as they are stored."""
    row = [4.5, 4.0, 5.0, 0.4]
    return {"colours": [[None] * 4, row, row], "proportions": [0.3, None, -1.0], "height_m": 1.72, **other}


def test_who_is_known_and_chosen_outlasts_a_restart_and_who_is_forgotten_leaves_nothing(tmp_path: Path) -> None:
    complaints: list[str] = []
    folder = tmp_path / "people"
    folder.mkdir()
    (folder / f"{ANN}.json").write_text(json.dumps(card()))
    first, pilot = school_in(tmp_path, complaints)

    async def change() -> None:
        await first.choose(ANN)
        await first.rename(ANN, "Anna")
        with pytest.raises(Problem, match="of that name"):
            await first.finish(first.begin(ME), "anna")
        await first.close()

    asyncio.run(change())
    assert pilot.told == ["Ann", "Anna"]
    again, pilot = school_in(tmp_path, complaints)
    assert again.enrollment is None, "a lesson that was under way is gone"
    assert again.chosen is not None and again.chosen.name == "Anna" and complaints == []
    assert again.chosen.looks.colours[1].tolist() == looks()["colours"][1] and again.chosen.looks.height == 1.72
    assert np.isnan(again.chosen.looks.colours[0]).all() and np.isnan(again.chosen.looks.proportions[1])
    (folder / f".{ANN}.json.12345678.new").write_text("left by a crash")
    asyncio.run(again.forget(ANN))
    assert pilot.told == [None] and again.people == {} and "anybody" in complaints.pop()
    assert not list(folder.glob(f"*{ANN}*"))
    last, _ = school_in(tmp_path, complaints)
    assert last.people == {} and last.chosen is None and complaints == []


def test_a_lesson_belongs_to_one_person_whatever_they_call_themselves(tmp_path: Path) -> None:
    school, _ = school_in(tmp_path, [])
    enrollment = school.begin(ME)
    with pytest.raises(Problem, match="Anna is teaching me someone now") as busy:
        school.begin(Person("2", "Anna", "operator"))
    assert busy.value.status == 409 and school.enrollment is enrollment
    anew = school.begin(ME)
    with pytest.raises(Problem, match="over"):
        asyncio.run(school.background(enrollment, {"content": b""}))
    assert school.enrollment is anew


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
        lambda told: told | {"looks": looks(height_m=17.2)},
        lambda told: told | {"looks": looks(height_m=-1.7)},
        lambda told: told | {"id": "ffffffffffff"},
        lambda told: {},
    ],
)
def test_a_damaged_person_is_left_aside_in_words(tmp_path: Path, spoil: Any) -> None:
    (tmp_path / "people").mkdir()
    file = tmp_path / "people" / f"{ANN}.json"
    (tmp_path / "people" / "chosen.json").write_text(json.dumps({"id": ANN}))
    file.write_text(json.dumps(card()))
    complaints: list[str] = []
    assert school_in(tmp_path, complaints)[0].chosen is not None and complaints == []
    file.write_text(json.dumps(spoil(card())))
    found, _ = school_in(tmp_path, complaints)
    assert found.people == {} and found.chosen is None and len(complaints) == 2
    assert file.exists()


class Late:
    """A simulated robot whose pictures come long after they were taken, as on a busy machine."""

    def __init__(self) -> None:
        self.robot = standing()
        self._seen: deque[Image] = deque(maxlen=LATE)

    def newest(self) -> Image | None:
        """A moment passes whenever someone looks."""
        for _ in range(4):
            image = self.robot.robot.read().image
            if image is not None:
                self._seen.append(image)
        return self._seen[0] if len(self._seen) == LATE else None

    @property
    def people(self) -> list[str]:
        """Who stands in the room."""
        return [thing.id for thing in self.robot.ask(ReadPlan()).things if thing.what == "person"]


def test_a_simulated_person_shows_how_it_goes_however_late_the_pictures_come(tmp_path: Path) -> None:
    late = Late()
    school, _ = school_in(tmp_path, [], late.robot, late.newest)
    before = late.people

    async def shown() -> None:
        enrollment = school.begin(ME)
        await school.show_demo(enrollment, on=True)
        await school.show_demo(enrollment, on=False)
        assert not enrollment.demo, "whoever is called back at once has not begun"
        await school.show_demo(enrollment, on=True)
        waits: set[str] = set()
        async with asyncio.timeout(60.0):
            while enrollment.demo:
                waits.add(enrollment.waits)
                await asyncio.sleep(0.005)
        assert enrollment.trouble == "" and [one.gesture for one in enrollment.taken] == [
            "down",
            "out",
            "wave",
            "side",
        ]
        assert enrollment.number == 5, "no picture was of a moment before"
        assert {WAITS, LOOKS, GETS_READY} <= waits and enrollment.waits == ""
        assert school.shown.stands and len(late.people) == len(before) + 1
        school.person_store.folder.write_text("a disk that cannot be written")
        with pytest.raises(Unwritable, match="could not be saved"):
            await school.finish(enrollment, "Sim")
        assert school.people == {} and school.enrollment is enrollment
        await school.cancel(enrollment)
        assert school.enrollment is None and not school.shown.stands and late.people == before
        await school.close()

    asyncio.run(shown())
