"""The grammar of the commands as recognizers take it (JSGF), written out of VOCABULARY, OTHER_WORDS and the numbers.

Nothing is listed here a second time: what `understand` reads can be heard, and only that.
"""

import re
from collections.abc import Iterable

from core.commands import VOCABULARY
from core.speech.understanding.grammar import OTHER_WORDS
from core.speech.understanding.numbers import DIGITS, TEEN_WORDS, TENS

SLOT = re.compile(r"\{\w+\}")
UNITS = ("meters", "meter")  # spoken; other spellings sound the same

FAR_LIKELIHOOD = 1e-22  # of a number from ten over that of a digit: no robot is sent as far, and "one" sounds like it
FINE_LIKELIHOOD = 1e-18  # how likely a second decimal is: the end of "nine" sounds like an "eight"

ARTICLE_LIKELIHOOD = 1e-10  # how likely "the" is where the command does without it: an echo sounds like it
RARE = frozenset((*TEEN_WORDS, *TENS, "hundred"))  # words of numbers from ten

NUMBER_RULES = {
    "number": "[minus] <size>",
    "size": "<whole> [<decimals>] | <decimals>",
    "decimals": f"/1/ point <digit> | /{FINE_LIKELIHOOD:g}/ point <digit> <digit>+",
    "whole": f"/1/ <below_hundred> | /{FAR_LIKELIHOOD:g}/ <one_to_nine> hundred [<below_hundred>]",
    "below_hundred": f"/1/ <digit> | /{FAR_LIKELIHOOD:g}/ <from_ten>",
    "from_ten": f"{' | '.join(TEEN_WORDS)} | <tens> [<one_to_nine>]",
    "tens": " | ".join(TENS),
    "one_to_nine": " | ".join(DIGITS[1:]),
    "digit": " | ".join(DIGITS),
}
"""Numbers as core.speech.understanding.numbers reads them, each as likely as people say it to a robot.

The probabilities are what sphinx's score is multiplied by: a word that was said outweighs them many times.
"""


def phrases() -> tuple[str, ...]:
    """All phrases worth hearing, as JSGF: those that move the robot and those that are refused with a reason."""
    spoken = [pattern for kind in VOCABULARY for pattern in kind.words] + list(OTHER_WORDS)
    return tuple(dict.fromkeys(_as_jsgf(pattern) for pattern in spoken))


def command_rules() -> dict[str, str]:
    """Rule name → JSGF, from <command> down."""
    weighed = (f"/{ARTICLE_LIKELIHOOD if ' the ' in phrase else 1:g}/ {phrase}" for phrase in phrases())
    return {"command": " | ".join(weighed)} | NUMBER_RULES


def written(rules: dict[str, str], heard: str) -> str:
    """A whole grammar whose public rule is `heard`."""
    lines = [f"<{name}> = {body};" for name, body in rules.items()]
    return "\n".join(("#JSGF V1.0;", "grammar beckon;", f"public <heard> = {heard};", *lines, ""))


def plain_grammar() -> str:
    """The commands and nothing else: every sound is one of them, until something competes."""
    return written(command_rules(), "<command>")


def words_of(rules: Iterable[str]) -> tuple[str, ...]:
    """All words that occur in JSGF rule bodies, in order of appearance."""
    bare = (re.sub(r"<\w+>|/[\d.e+-]+/", " ", body) for body in rules)
    return tuple(dict.fromkeys(word for body in bare for word in re.findall(r"[a-z_']+", body)))


def _as_jsgf(pattern: str) -> str:
    text = SLOT.sub("<number>", pattern)
    return re.sub(rf"\b{UNITS[0]}\b", f"({' | '.join(UNITS)})", text)
