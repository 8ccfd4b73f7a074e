"""Requests cross to the driver as JSON and are checked by their types where they arrive."""

from typing import Any

import msgspec
import pytest

from core.errors import BadInput
from core.robots.requests import (
    BoardInCamera,
    CarryRobot,
    PlaceBoard,
    PlacedThing,
    PlaceThing,
    Play,
    ReadPlan,
    ReadTruth,
    RemoveThing,
    Requests,
    RobotRequest,
    Seek,
    Speak,
    answer_of,
    read_answer,
    read_request,
)
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SIMULATOR = SimulatedRobot("lab", settings=SimulationSettings(camera=False, microphones="none")).requests


@pytest.mark.parametrize(
    "request_",
    [
        PlaceThing(what="person", x_m=1.0, y_m=2.0, path_m=((1.0, 2.0), (3.0, 4.0)), again=True),
        CarryRobot(x_m=1.0, y_m=2.0),
        PlaceBoard(in_camera=BoardInCamera(UPRIGHT, (0.0, 0.0, 1.0)), panel_m=(0.3, 0.2)),
        RemoveThing(id="person 1"),
        ReadPlan(),
        Speak(pcm=b"\x00\xff\x01\x80", rate_hz=8000),
    ],
    ids=lambda request_: type(request_).__name__,
)
def test_what_arrives_is_what_was_asked(request_: RobotRequest[Any]) -> None:
    assert read_request(msgspec.json.encode(request_), SIMULATOR) == request_


@pytest.mark.parametrize(
    ("raw", "known", "sentence"),
    [
        (b'{"do": "fly"}', SIMULATOR, "understands the requests place, carry, .* and listen, nothing else"),
        (b'{"do": "seek", "value": 0.5}', SIMULATOR, "understands the requests"),
        (b'{"do": "truth"}', (Play, Seek), "understands the requests play and seek, nothing else"),
        (b'{"do": "truth"}', (Play,), "understands the request play, nothing else"),
        (b'{"do": "truth"}', (), "takes no requests"),
        (b'{"do": ["truth"]}', SIMULATOR, "Expected str, got array as do"),
        (b"{}", SIMULATOR, "missing required field do"),
        (b"[]", SIMULATOR, "Expected object, got array"),
        (b'{"do": "truth"', SIMULATOR, "truncated"),
        (b'{"do": "truth", "x_m": 1}', SIMULATOR, "unknown field x_m"),
        (b'{"do": "place", "what": "dragon", "x_m": 1, "y_m": 0}', SIMULATOR, "'dragon' as what"),
        (b'{"do": "place", "what": "box", "y_m": 0}', SIMULATOR, "missing required field x_m"),
        (b'{"do": "place", "what": "box", "x_m": true, "y_m": 0}', SIMULATOR, "Expected float, got bool as x_m"),
        (b'{"do": "place", "what": "box", "x_m": "1", "y_m": 0}', SIMULATOR, "Expected float, got str as x_m"),
        (b'{"do": "place", "what": "box", "x_m": 1e400, "y_m": 0}', SIMULATOR, "out of range as x_m"),
        (b'{"do": "place_board", "columns": 9.5}', SIMULATOR, "Expected int, got float as columns"),
        (b'{"do": "place_board", "in_camera": {"rotation": []}}', SIMULATOR, "missing required field translation_m"),
        (b'{"do": "say", "pcm": "not base64!"}', SIMULATOR, "as pcm"),
        (b'{"do": "seek", "value": "0.5"}', (Seek,), "Expected float, got str as value"),
    ],
)
def test_what_is_no_request_of_this_robot_is_refused_in_a_sentence(
    raw: bytes, known: Requests, sentence: str
) -> None:
    with pytest.raises(BadInput, match=sentence) as refused:
        read_request(raw, known)
    assert str(refused.value).endswith(".") and "`" not in str(refused.value) and "$" not in str(refused.value)


def test_an_answer_has_the_type_that_its_request_names() -> None:
    robot = SimulatedRobot("lab", settings=SimulationSettings(camera=False, microphones="none"))
    robot.ask(PlaceThing(what="person", id="Ann", x_m=1.0, y_m=1.0, clothes="red/blue"))
    robot.ask(PlaceBoard(x_m=0.8, y_m=0.1, z_m=0.2))
    plan = robot.ask(ReadPlan())
    assert read_answer(msgspec.json.encode(plan), ReadPlan()) == plan
    assert any(isinstance(thing, PlacedThing) and thing.clothes == "red/blue" for thing in plan.things)
    with pytest.raises(BadInput, match="missing required field"):
        read_answer(msgspec.json.encode(plan), ReadTruth())


@pytest.mark.parametrize("kind", SIMULATOR, ids=lambda kind: kind.__name__)
def test_every_request_of_the_simulator_names_its_answer(kind: type[RobotRequest[Any]]) -> None:
    assert issubclass(answer_of(kind), msgspec.Struct)
