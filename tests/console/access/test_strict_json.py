"""JSON from strangers, and the sentences it is refused with."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from console.access.strict_json import read_json
from core.errors import BadInput

plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**15), 10**15)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(plain)
def test_whatever_is_ordinary_json_comes_back(value: object) -> None:
    assert read_json(json.dumps(value).encode()) == value
    assert read_json(json.dumps(value, ensure_ascii=False).encode()) == value


@pytest.mark.parametrize(
    "raw",
    [
        b"",
        b"{",
        b"nonsense",
        b'{"v": NaN}',
        b'{"v": Infinity}',
        b'{"v": -Infinity}',
        b'{"v": 1e999}',
        b'{"v": -1e999}',
        b'{"v": 1, "v": 2}',
        b'{"a": {"v": 1, "v": 1}}',
        b'"\\ud800"',
        b'{"\\udfff": 1}',
        b'{"v": "\\ud83d"}',
        b"\xff\xfe{\x00}\x00",
        '{"v": 1}'.encode("utf-16"),
        '{"v": 1}'.encode("utf-32"),
        b"\xef\xbb\xbf{}",
        b'{"v": "\xff"}',
        b'{"v": "\xed\xa0\x80"}',
        b'{"v": ' + b"9" * 5000 + b"}",
        b"[" * 100_000,
        b'{"a":' * 50_000 + b"1" + b"}" * 50_000,
        b"{'v': 1}",
        b'{"v": 01}',
        b'{"v": 1,}',
        b'{"v": "a\nb"}',
    ],
    ids=lambda raw: repr(raw[:24]),
)
def test_what_is_no_plain_json_is_refused_with_a_sentence(raw: bytes) -> None:
    with pytest.raises(BadInput) as refused:
        read_json(raw)
    assert str(refused.value).endswith(".")


def test_a_pair_of_surrogates_is_one_character() -> None:
    assert read_json(b'"\\ud83d\\ude00"') == "\U0001f600"


def test_text_with_half_a_character_is_refused_too() -> None:
    with pytest.raises(BadInput, match="half a character"):
        read_json('"\ud800"')
