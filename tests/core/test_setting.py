"""A setting's declaration is all there is to know about it."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import pytest

from core.errors import BadInput
from core.setting import Meta, Section, declared_settings, thresholds_of


@dataclass(frozen=True)
class Base(Section):
    """A base.

    Watch:
        gain: the swinging
    """

    floor: float = 0.5
    gain: Annotated[float, Meta("1/s", 0.5, 10, "a gain")] = 3.0
    count: Annotated[int, Meta("", 1, 8, "how many")] = 2


@dataclass(frozen=True)
class Thing(Base):
    mode: Annotated[Literal["plain", "fancy"], Meta(meaning="how")] = "plain"
    voice: Annotated[str, Meta(choices=("high", "low"), meaning="which")] = "low"
    offset: Annotated[float | None, Meta("m", -1, 1, "where")] = None
    on: Annotated[bool, Meta(meaning="whether")] = True
    topic: Annotated[str, Meta(meaning="a name")] = ""


def test_the_declarations_of_base_and_section_are_found_in_order() -> None:
    declared = declared_settings(Thing)
    assert [(one.name, one.kind, one.default) for one in declared] == [
        ("gain", float, 3.0),
        ("count", int, 2),
        ("mode", str, "plain"),
        ("voice", str, "low"),
        ("offset", float, None),
        ("on", bool, True),
        ("topic", str, ""),
    ]
    assert [one.choices for one in declared if one.choices] == [("plain", "fancy"), ("high", "low")]
    assert [one.name for one in declared if one.optional] == ["offset"]
    assert {one.name: one.watch for one in declared if one.watch} == {"gain": "the swinging"}


def test_a_threshold_is_a_number_of_the_section_that_no_file_sets() -> None:
    @dataclass(frozen=True)
    class OtherThing(Thing):
        floor: float = 0.7

    for kind in (Thing, OtherThing):
        assert thresholds_of(kind) == {"floor"}
        assert "floor" not in {one.name for one in declared_settings(kind)}
    assert (OtherThing().floor, replace(Thing(), floor=99.0).floor) == (0.7, 99.0)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"gain": 0.4}, "gain must lie between 0.5 and 10 1/s, not 0.4."),
        ({"gain": 10.1}, "gain must lie between 0.5 and 10 1/s, not 10.1."),
        ({"gain": float("nan")}, "gain must lie between 0.5 and 10 1/s, not nan."),
        ({"gain": True}, "gain must be a number, not true."),
        ({"gain": "3"}, "gain must be a number, not 3."),
        ({"gain": None}, "gain must be a number, not None."),
        ({"gain": 10**400}, "gain must lie between 0.5 and 10 1/s, not a huge number."),
        ({"count": 9}, "count must lie between 1 and 8, not 9."),
        ({"count": 2.0}, "count must be a whole number, not 2.0."),
        ({"count": True}, "count must be a whole number, not true."),
        ({"mode": "loud"}, "mode must be one of plain, fancy, not loud."),
        ({"mode": ["plain"]}, "mode must be one of plain, fancy, not ['plain']."),
        ({"voice": "x" * 99}, f"voice must be one of high, low, not {'x' * 40}."),
        ({"offset": 2.0}, "offset must lie between -1 and 1 m, not 2.0."),
        ({"on": 1}, "on must be true or false, not 1."),
        ({"topic": 3}, "topic must be a text in quotes, not 3."),
    ],
)
def test_a_value_that_is_not_accepted_is_told_in_a_sentence(change: dict[str, object], sentence: str) -> None:
    with pytest.raises(BadInput) as told:
        replace(Thing(), **change)  # type: ignore[arg-type]
    assert str(told.value) == sentence


def test_a_setting_that_loses_its_declaration_is_a_threshold() -> None:
    @dataclass(frozen=True)
    class Bare(Base):
        gain: float = 3.0

    assert thresholds_of(Bare) == {"floor", "gain"}
    assert [one.name for one in declared_settings(Bare)] == ["count"]


def test_what_is_accepted_becomes_the_type_that_is_declared() -> None:
    fit = {one.name: one.fit for one in declared_settings(Thing)}
    assert (fit["gain"](1), type(fit["gain"](1))) == (1.0, float)
    assert fit["offset"](None) is None
    assert replace(Thing(), gain=0.5, count=8, mode="fancy", voice="high", offset=-1.0, on=False, topic="/scan")
