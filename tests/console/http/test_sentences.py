"""Sentences with a code: the page's catalogue has each of them, and refusals carry it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import msgspec

from console.control.lease import OTHER_DRIVES
from console.http.problems import Problem, problem_of, refused
from core.errors import Refused

REPOSITORY = Path(__file__).resolve().parents[3]
DECLARED = re.compile(r'Sentence\(\s*("[^"]+"),\s*("(?:[^"\\]|\\.)*")\s*,?\s*\)')


def test_every_code_is_declared_once_and_its_english_is_the_catalogues() -> None:
    found = [
        (json.loads(code), json.loads(english))
        for room in ("core", "console")
        for file in (REPOSITORY / room).rglob("*.py")
        for code, english in DECLARED.findall(file.read_text())
    ]
    catalogue = json.loads((REPOSITORY / "static/i18n/en.json").read_text())
    known = {key.partition(".")[2]: text for key, text in catalogue.items() if key.startswith("console.")}
    assert len(found) > 10 and len(dict(found)) == len(found)
    assert dict(found) == known


def test_a_refusal_carries_the_code_and_the_values_of_its_sentence() -> None:
    problem = problem_of(Refused(OTHER_DRIVES.of(holder="Ann")))
    assert problem.detail == "Ann drives now. Ask for control, or take over."
    body = json.loads(problem.body())
    assert (body["code"], body["values"], body["status"]) == ("lease.other_drives", {"holder": "Ann"}, 409)
    answer = json.loads(msgspec.json.encode(refused(7, problem)))
    assert (answer["code"], answer["values"], answer["detail"]) == (body["code"], body["values"], problem.detail)


def test_a_sentence_without_a_code_is_told_as_before() -> None:
    assert set(json.loads(Problem(404, "There is none.").body())) == {"type", "title", "status", "detail"}
