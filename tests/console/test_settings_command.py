"""`beckon settings` prints what the declarations say: for people, as JSON, and as a schema for editors."""

import json
from typing import Any

import jsonschema_rs
import pytest

from console.__main__ import build_parser, main
from console.cli.settings import schema
from core.setting import declared_settings
from core.settings import FORMER, Settings, read, section_kinds


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["settings", *words]) == 0
    return capsys.readouterr().out


def test_what_is_printed_is_a_settings_file_with_the_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys)
    names = [line.split(" =")[0].lstrip("# ") for line in text.splitlines() if " =" in line]
    kinds = section_kinds()
    assert len(names) == sum(len(declared_settings(kind)) for kind in kinds.values())
    again = read(text)
    assert again.steering == Settings().steering
    assert again.speech == Settings().speech
    assert again.edges.bearing_sd == pytest.approx(Settings().edges.bearing_sd, rel=1e-5)


def test_a_line_has_bounds_unit_and_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    lines = printed(capsys, "simulation").splitlines()
    (cruise,) = (line for line in lines if line.startswith("cruise"))
    assert cruise.split() == [
        "cruise",
        "=",
        "0.1",
        "#",
        "0.01",
        "to",
        "1",
        "m/s;",
        "speed",
        "of",
        "commands",
        "(section",
        "6.2)",
    ]
    (noise,) = (line for line in lines if line.startswith("wheel_noise"))
    assert "# encoder, paper, none; " in noise


def test_json_has_bounds_choices_and_units(capsys: pytest.CaptureFixture[str]) -> None:
    rows = {row["name"]: row for row in json.loads(printed(capsys, "motion", "--json"))["motion"]}
    assert rows["wheelbase"] | {"meaning": "", "watch": ""} == {
        "name": "wheelbase",
        "default": "0.1",
        "unit": "m",
        "low": 0.02,
        "high": 5,
        "choices": [],
        "meaning": "",
        "watch": "",
    }
    assert (rows["model"]["choices"], rows["model"]["low"]) == (["encoder", "paper"], None)


def test_an_unknown_section_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["settings", "steerin", "--schema"]) == 1
    assert "There is no section 'steerin'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("document", "fits"),
    [
        ({}, True),
        ({"steering": {"lookahead": 1}}, True),
        ({"steering": {"lookahead": 1.01}}, False),
        ({"steering": {"lookahead": 0.049}}, False),
        ({"steering": {"lookahed": 0.3}}, False),
        ({"steerin": {}}, False),
        ({"corners": {"points": 6.5}}, False),
        ({"ekf": {"mode": "paper"}}, True),
        ({"ekf": {"mode": "Paper"}}, False),
        ({"simulation": {"camera": False}}, True),
        ({"simulation": {"camera": 0}}, False),
        ({"simulation": {"microphones": "none"}}, True),
        ({"log": {"mounting_x": -0.1}}, True),
        ({"floor": {"size": 5.0}}, True),
        ({"floor": {"size": 0.0}}, False),
    ],
)
def test_the_schema_accepts_what_is_accepted(document: dict[str, Any], fits: bool) -> None:
    whole = schema(section_kinds())
    assert jsonschema_rs.validator_for(whole).is_valid(document) is fits


def test_the_schema_has_every_section_under_all_its_names(capsys: pytest.CaptureFixture[str]) -> None:
    whole = json.loads(printed(capsys, "--schema"))
    assert set(whole["properties"]) == set(section_kinds()) | set(FORMER)
    lookahead = whole["definitions"]["steering"]["properties"]["lookahead"]
    assert (lookahead["minimum"], lookahead["maximum"], lookahead["default"]) == (0.05, 1, 0.22)
    assert lookahead["description"].startswith("[m] ")


def test_the_schema_of_one_section_holds_that_section(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(json.loads(printed(capsys, "voice", "--schema"))["properties"]) == ["voice"]
    assert build_parser().parse_args(["settings", "voice", "--schema"]).schema
