"""What those who do not drive may do while someone drives: watch and stop, and never take the console away."""

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from console.access import logins as limits
from console.access.logins import Logins, Person
from console.access.open_sockets import MAX_SOCKETS, MOST_OF_ONE, RESERVED_SOCKETS, OpenSockets, TooMany
from console.control.lease import Lease
from console.speech.browser_microphone import BUSY, TAKEN, BrowserMicrophone, TalkTurn
from core.errors import Refused
from tests.console.access.test_access_guard import BODYLESS, signed_in
from tests.console.live import Live, until

DRIVER = Person("driver", "Ann", "operator")
OPERATOR = Person("operator", "Bea", "operator")
VIEWER = Person("viewer", "Vic", "viewer")


# logins


def test_a_flood_of_logins_ends_only_logins_of_its_own_role(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "MOST_LOGINS", 5)
    logins = Logins()
    driving, watching = logins.issue("operator", "operator"), logins.issue("viewer", "viewer")
    driver, watcher = logins.open(driving, "", 0.0), logins.open(watching, "", 0.0)
    assert driver is not None and watcher is not None
    flood = [logins.open(watching, "", 1.0, "", lambda person: person == watcher[1]) for _ in range(20)]
    assert logins.of_cookie(driver[0], 2.0) == driver[1]
    assert logins.of_cookie(watcher[0], 2.0) == watcher[1], "whose page is open stays signed in"
    known = [one for one in flood if one is not None and logins.of_cookie(one[0], 2.0)]
    assert known == flood[-4:]


def test_viewers_cannot_sign_the_driver_out(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "MOST_LOGINS", 10)
    cookie = signed_in(live, live.operator).partition(";")[0]
    for _ in range(25):
        signed_in(live, live.viewer)
    assert live.ask("GET", "/api/me", headers={"Cookie": cookie}).json["role"] == "operator"


# sockets


def test_viewers_at_the_drivers_address_leave_room_for_operators() -> None:
    sockets = OpenSockets()
    rooms: list[Any] = []

    def opened(person: Person) -> bool:
        room = sockets.room_for(person, lambda code, reason: None)
        try:
            room.__enter__()
        except TooMany:
            return False
        rooms.append(room)
        return True

    assert [opened(VIEWER) for _ in range(MOST_OF_ONE + 5)].count(True) == MOST_OF_ONE
    others = [Person(f"viewer {number}", "", "viewer") for number in range(MAX_SOCKETS)]
    assert [opened(one) for one in others].count(True) == MAX_SOCKETS - RESERVED_SOCKETS - MOST_OF_ONE
    assert [opened(DRIVER) for _ in range(RESERVED_SOCKETS + 1)].count(True) == RESERVED_SOCKETS
    assert sockets.people == 2 + MAX_SOCKETS - RESERVED_SOCKETS - MOST_OF_ONE, "people are counted, not their sockets"
    assert sockets.are_open(DRIVER) and not sockets.are_open(OPERATOR)
    for room in rooms:
        room.__exit__(None, None, None)


# the microphone


class Reader:
    """In the worker's place: notes whose sound it is given."""

    alive = ready = True

    def __init__(self) -> None:
        self.fed: list[float] = []
        self.speakers: list[int] = []

    async def begin(self, settings: Any, *, held: bool, speaker: int) -> None:
        self.speakers.append(speaker)

    async def feed(self, samples: Any, rate: int, stamp: float) -> list[Any]:
        self.fed.append(float(samples[0]))
        return []

    async def finish(self) -> list[Any]:
        return []


def turn(page: int, rank: Callable[[], int], said: list[tuple[str, bool]]) -> TalkTurn:
    return TalkTurn("open", lambda told, delay: None, lambda why, on: said.append((why, on)), page, rank)


def test_a_drivers_turn_takes_the_microphone_from_a_viewers() -> None:
    async def story() -> None:
        microphone, reader, lease = BrowserMicrophone(), Reader(), Lease()
        microphone._worker = reader  # type: ignore[assignment]
        lease.take(DRIVER, 0.0)
        said: dict[str, list[tuple[str, bool]]] = {person.id: [] for person in (VIEWER, OPERATOR, DRIVER)}
        turns = {
            person.id: turn(page, lambda person=person: lease.rank(person), said[person.id])
            for page, person in enumerate((VIEWER, OPERATOR, DRIVER), 1)
        }
        microphone.begin(turns["viewer"])
        await asyncio.sleep(0.01)
        turns["viewer"].add([0.1] * 100, 0.0)  # waits for more
        microphone.begin(turns["operator"])
        assert said["viewer"] == [(TAKEN, False)]
        microphone.begin(turns["driver"])
        with pytest.raises(Refused, match=BUSY):
            microphone.begin(turns["viewer"])
        with pytest.raises(Refused, match=BUSY):
            microphone.begin(turns["operator"])
        turns["driver"].add([0.3] * 2000, 0.0)
        await until(lambda: reader.fed and reader.speakers[-1] == 3)
        assert reader.fed == [pytest.approx(0.3)]
        turns["driver"].rest()
        await asyncio.sleep(0.05)
        microphone.begin(turn(4, lambda: 0, []))

    asyncio.run(story())


# what the robot sees and hears with


@pytest.fixture
def driven(live: Live) -> Iterator[str]:
    """A person drives; the cookie of another operator."""
    own = {"Cookie": signed_in(live, live.operator).partition(";")[0], "Origin": f"http://127.0.0.1:{live.port}"}
    assert live.ask("POST", "/api/lease", {"do": "take"}, headers=own).status == 200
    yield own["Cookie"]
    live.ask("POST", "/api/lease", {"do": "release"}, headers=own)


CHANGES = [  # asked in a form or of a place that is refused otherwise: nothing is changed for the tests that follow
    ("POST", "/api/calibration/sessions/1/accept", {"force": False}, {}),
    ("POST", "/api/calibration/in-use/undo", {"kind": "camera"}, {}),
    ("POST", "/api/calibration/import", None, {"Content-Type": "text/plain"}),
    ("POST", "/api/calibration/microphones/accept", None, BODYLESS),
    ("POST", "/api/calibration/microphones/undo", None, BODYLESS),
    ("POST", "/api/calibration/microphones/clap", {"azimuth_rad": 99.0}, {}),
    ("POST", "/api/hearing/check", {"show": 1}, {}),
    ("POST", "/api/voice", {"text": ""}, {}),
    ("POST", "/api/hearing", {"listen": False}, {}),
    ("PUT", "/api/people/chosen", {"id": None}, {}),
    ("POST", "/api/sim/place", {"what": "robot", "x_m": 900.0, "y_m": 0.0}, {}),
]


@pytest.mark.parametrize(("method", "path", "body", "headers"), CHANGES, ids=lambda value: str(value)[-24:])
def test_who_does_not_drive_changes_nothing_the_robot_moves_by(
    live: Live, driven: str, method: str, path: str, body: Any, headers: dict[str, str]
) -> None:
    raw = b"x" if headers.get("Content-Type") == "text/plain" else None
    asked = {"token": live.operator, "raw": raw, "headers": headers}
    refused = live.ask(method, path, body, **asked)
    assert refused.status == 409 and refused.json["detail"].endswith("drives now. Ask for control, or take over.")
    own = {"Cookie": driven, "Origin": f"http://127.0.0.1:{live.port}", **headers}
    for free in (live.ask(method, path, body, raw=raw, headers=own), released(live, own, method, path, body, asked)):
        assert "drives now" not in free.body.decode(), (free.status, free.body)


def released(live: Live, own: dict[str, str], method: str, path: str, body: Any, asked: dict[str, Any]) -> Any:
    """The same by the other operator when nobody drives."""
    told = {name: value for name, value in own.items() if name in ("Cookie", "Origin")}
    assert live.ask("POST", "/api/lease", {"do": "release"}, headers=told).status == 200
    return live.ask(method, path, body, **asked)
