"""The grammar for recognizers is the one that is read: what can be heard is understood, and the other way round."""

import re

from hypothesis import given, settings
from hypothesis import strategies as st

from core.commands import VOCABULARY
from core.speech.sphinx.jsgf import command_rules, phrases, plain_grammar
from core.speech.understanding.grammar import OTHER_WORDS, Refusal, understand
from tests.core.speech.spelling import spell

RULES = command_rules()


def expression(name: str) -> str:
    """A rule as a regular expression over words that are each followed by a space."""
    body = re.sub(r"/[^/]+/", "", RULES[name])  # without how likely each way is
    tokens = re.findall(r"<\w+>|[a-z]+|[][()|+]", body)
    return "".join(
        f"(?:{expression(token[1:-1])})"
        if token[0] == "<"
        else {"[": "(?:", "]": ")?", "(": "(?:"}.get(token, f"{token} " if token.isalpha() else token)
        for token in tokens
    )


COMMAND = re.compile(expression("command"))


@settings(max_examples=300, deadline=None)
@given(st.from_regex(COMMAND, fullmatch=True))
def test_whatever_the_grammar_can_hear_is_a_command_or_refused_for_a_known_reason(words):
    words = words.strip()
    read = understand(words)
    out_of_bounds = isinstance(read, Refusal) and " takes " in read.reason
    assert words in OTHER_WORDS or not isinstance(read, Refusal) or out_of_bounds or len(words) > 120


@given(st.sampled_from(VOCABULARY), st.data())
def test_every_command_can_be_heard_with_every_number(kind, data):
    for pattern in kind.words:
        values = {
            number.name: spell(data.draw(st.floats(number.low, number.high).map(lambda v: round(v, 2))))
            for number in kind.numbers
        }
        assert COMMAND.fullmatch(pattern.format(**values) + " ")


def test_phrases_that_are_refused_for_now_can_be_heard_too_so_that_the_reason_is_told():
    for words in (*OTHER_WORDS, "come here", "follow me", "follow wall", "go back", "start"):
        assert COMMAND.fullmatch(words + " ")


def test_no_phrase_is_listed_twice():
    assert len(set(phrases())) == len(phrases())
    assert plain_grammar().count("<command> =") == 1
