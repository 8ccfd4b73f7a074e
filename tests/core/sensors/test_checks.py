"""The table of checks: one code, one sentence, in both languages of the page."""

import json
import string
from pathlib import Path

import pytest

from core.sensors import checks
from core.sensors.checks import CHECKS, distinct, fault

I18N = Path(__file__).parents[3] / "static" / "i18n"


def test_every_code_names_its_subject_and_stands_once():
    rows = json.loads(Path(checks.__file__).with_suffix(".json").read_text(), object_pairs_hook=list)
    codes = [code for code, _ in rows]
    assert codes and len(codes) == len(set(codes)) == len(CHECKS)
    assert all("." in code and code.replace(".", "").replace("_", "").isalpha() for code in codes)


@pytest.mark.parametrize("code", CHECKS)
def test_the_page_has_a_translation_of_the_sentence_with_the_same_values(code):
    german = json.loads((I18N / "de.json").read_text())
    assert _values(german[f"console.{code}"]) == _values(CHECKS[code].sentence)


def test_a_fault_says_its_sentence_with_the_values_and_only_the_newest_of_a_kind_is_kept():
    first = fault("scan.malformed", "/scan", what="no beam")
    newest = fault("scan.malformed", "/scan", what="1 beam")
    other = fault("scan.malformed", "/scan2", what="no beam")
    assert "/scan is malformed (no beam)" in first.sentence
    assert distinct([first, other, newest]) == (newest, other)
    with pytest.raises(KeyError):
        fault("scan.malformed", "/scan")


def _values(sentence):
    return {name for _, name, _, _ in string.Formatter().parse(sentence) if name}
