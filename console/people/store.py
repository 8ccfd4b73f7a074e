"""The people whom the robot knows, on disk: numbers of how they look, and never a picture."""

from __future__ import annotations

import logging
import math
import re
import unicodedata
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np

from console.http.problems import Problem
from core.files import UNFINISHED, sync_folder, write_atomic
from core.message import Array
from core.perception.people.appearance import LIMB_COUNT, TONE_COUNT, Appearance, PersonProfile
from core.perception.people.parts import PARTS

log = logging.getLogger(__name__)

CARD_VERSION = 2
MOST_BYTES = 2**16
MOST_PEOPLE = 50
MAX_LOOK_NUMBER = 20.0  # of the numbers of someone's looks
MIN_HEIGHT_M, MAX_HEIGHT_M = 0.3, 3.5  # of a person, as it was measured
MAX_NAME_CHARACTERS = 40  # characters of a name
CHOSEN = "chosen.json"
ID = re.compile(r"[0-9a-f]{12}")
JOINERS = "\u200c\u200d"  # within words of some scripts and within some emoji
FILLERS = "\u115f\u1160\u2800\u3164\uffa0"  # letters without ink


class StoredLooks(msgspec.Struct, frozen=True):
    """How a person looks, as it is stored; null: not known."""

    colours: list[list[float | None]]  # head, torso, feet: log blue, green, red, and the spread of log brightness
    proportions: list[float | None]  # log lengths of legs, arms and neck in lengths of the torso
    height_m: float | None = None

    @classmethod
    def of(cls, looks: Appearance) -> StoredLooks:
        height = None if math.isnan(looks.height) else round(looks.height, 3)
        return cls([_or_null(row) for row in looks.colours], _or_null(looks.proportions), height)

    @property
    def appearance(self) -> Appearance:
        height = math.nan if self.height_m is None else self.height_m
        return Appearance(
            colours=np.array(self.colours, float), proportions=np.array(self.proportions, float), height=height
        )


def _or_null(row: Array) -> list[float | None]:
    """Numbers (N,) as they are stored; NaN is null."""
    return [None if math.isnan(one) else one for one in np.round(row, 4).tolist()]


class PersonFile(msgspec.Struct, forbid_unknown_fields=True):
    """One person's file."""

    version: int
    id: str
    name: str
    learnt_s: float  # [s] since 1970
    by: str  # who was at the console
    pictures: int  # from how many
    looks: StoredLooks

    @property
    def who(self) -> PersonProfile:
        return PersonProfile(name=self.name, looks=self.looks.appearance, pictures=self.pictures)


class PersonChoice(msgspec.Struct):
    """To whom alone the robot comes."""

    id: str | None


class PersonStore:
    """Its methods wait for the disk: call them from a thread."""

    def __init__(self, home: Path) -> None:
        self.folder = home / "people"

    def read(self, complain: Callable[[str], None]) -> tuple[dict[str, PersonFile], str | None]:
        """All people by id, and the id of the chosen one. An unreadable file stays where it is and is reported."""
        people: dict[str, PersonFile] = {}
        for path in sorted(self.folder.glob("*.json"))[: 2 * MOST_PEOPLE]:
            if path.name == CHOSEN:
                continue
            try:
                people[path.stem] = card_in(small(path), path.stem)
            except (OSError, ValueError, msgspec.MsgspecError) as wrong:
                log.warning("A person cannot be read: %s: %s", path, wrong)
                complain("What I learnt of someone cannot be read any more; teach me again. The log names the file.")
        return people, self._choice(people, complain)

    def _choice(self, people: dict[str, PersonFile], complain: Callable[[str], None]) -> str | None:
        path = self.folder / CHOSEN
        try:
            if not path.is_file():
                return None
            chosen = msgspec.json.decode(small(path), type=PersonChoice).id
            if chosen is None or chosen in people:
                return chosen
            log.warning("The person who is chosen in %s is not known.", path)
        except (OSError, ValueError, msgspec.MsgspecError) as wrong:
            log.warning("Who is chosen cannot be read: %s: %s", path, wrong)
        complain(
            "I do not know any more to whom alone I should come, so I come to anybody. Choose again under People."
        )
        return None

    def keep(self, card: PersonFile) -> None:
        """Write one person. Raises OSError."""
        write_atomic(self.folder / f"{card.id}.json", msgspec.json.encode(card))

    def choose(self, chosen: str | None) -> None:
        """Write who is chosen. Raises OSError."""
        write_atomic(self.folder / CHOSEN, msgspec.json.encode(PersonChoice(chosen)))

    def forget(self, card_id: str) -> None:
        """For good. Raises OSError."""
        (self.folder / f"{card_id}.json").unlink(missing_ok=True)
        for left in self.folder.glob(f".{card_id}.json.*{UNFINISHED}"):  # by a crash while it was written
            left.unlink(missing_ok=True)
        if self.folder.is_dir():
            sync_folder(self.folder)


def small(path: Path) -> bytes:
    """A small file. Raises OSError, ValueError."""
    if path.stat().st_size > MOST_BYTES:
        raise ValueError("too large")
    return path.read_bytes()


def card_in(raw: bytes, card_id: str) -> PersonFile:
    """A person's file, whole and sound. Raises ValueError, MsgspecError."""
    card = msgspec.json.decode(raw, type=PersonFile)
    if card.version != CARD_VERSION or card.id != card_id or not ID.fullmatch(card.id):
        raise ValueError("of another version, or under another's name")
    if not is_name(card.name):
        raise ValueError("no name")
    looks = card.looks
    if len(looks.colours) != len(PARTS) or any(len(row) != TONE_COUNT for row in looks.colours):
        raise ValueError("colours of another form")
    if len(looks.proportions) != LIMB_COUNT:
        raise ValueError("proportions of another form")
    numbers = [one for row in (*looks.colours, looks.proportions, [looks.height_m]) for one in row if one is not None]
    if not all(math.isfinite(one) and abs(one) < MAX_LOOK_NUMBER for one in numbers) or not looks.appearance.known:
        raise ValueError("looks that are none")
    if looks.height_m is not None and not MIN_HEIGHT_M <= looks.height_m <= MAX_HEIGHT_M:
        raise ValueError("a height that no person has")
    if not (math.isfinite(card.learnt_s) and card.pictures > 0):
        raise ValueError("numbers that are none")
    return card


def name_of(given: str) -> str:
    """Return the tidy form of a name. Raises Problem 422."""
    name = unicodedata.normalize("NFC", " ".join(given.split()))
    if not is_name(name):
        raise Problem(
            422, f"A name has 1 to {MAX_NAME_CHARACTERS} letters or signs, all of them to be seen; say who you are."
        )
    return name


def is_name(name: str) -> bool:
    """Return whether a name can be shown and read as it is, without hidden or direction-changing characters."""
    seen = "".join(letter for letter in name if letter not in JOINERS)
    return 0 < len(name) <= MAX_NAME_CHARACTERS and seen.isprintable() and any(not blank(letter) for letter in seen)


def blank(letter: str) -> bool:
    """Return whether no part of it is seen by itself."""
    return letter.isspace() or unicodedata.category(letter) in ("Mn", "Me") or letter in FILLERS
