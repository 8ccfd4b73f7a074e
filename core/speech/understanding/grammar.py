"""Words → command or refusal: the one parser for all typed, clicked, sent or heard text (section 4.2, Table 2).

Only a whole utterance that matches moves the robot. Whatever contains the word STOP and is no complete, bounded
"stop at x and y" stops it. Nothing is guessed: a near miss is refused with suggestions.

Recognizers and people punctuate. A comma or a colon may end a word or a whole number, and a sentence may end with any
mark and stand in quotes. Within a number a comma says two things ("1,5"), behind STOP any mark ends the sentence,
and where the marks say that it is a question or breaks off, it moves nothing.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache

from core.commands import VOCABULARY
from core.commands.command import Command, CommandSpec, Parameter
from core.commands.continue_straight import CONTINUE
from core.commands.stop_moving import START, STOP_MOVING
from core.speech.understanding.numbers import NUMBER, read_number, write_number


def nearest(text: str, phrases: Iterable[str], most: int = 3) -> tuple[str, ...]:
    """The phrases at most a third of their letters away from the text, nearest first.

    Words in another order count as one slip: "left turn" resembles "turn left".
    """
    if len(text) > 60:
        return ()
    rated = [(min(slips(text, phrase), 1 + slips(_in_order(text), _in_order(phrase))), phrase) for phrase in phrases]
    return tuple(phrase for count, phrase in sorted(rated) if 3 * count <= max(len(phrase), 3))[:most]


def slips(a: str, b: str) -> int:
    """Letters to insert, drop, change or swap with a neighbour to get from a to b (optimal string alignment)."""
    older: list[int] = []
    old = list(range(len(b) + 1))
    for i, letter in enumerate(a, 1):
        new = [i]
        for j, other in enumerate(b, 1):
            cost = min(old[j] + 1, new[j - 1] + 1, old[j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                cost = min(cost, older[j - 2] + 1)
            new.append(cost)
        older, old = old, new
    return old[-1]


def _in_order(text: str) -> str:
    return " ".join(sorted(text.split()))


LONGEST = 120  # characters of an utterance that is read at all; the word stop is looked for in all of it

PAUSE = "(?: ?[,:])?"  # between the words of a sentence
UNITS = ("meters", "meter", "metres", "metre")  # as people spell what stands as "meters" in the vocabulary
UNIT = rf"(?:{PAUSE} |(?<=[0-9]))(?:{'|'.join(UNITS)}|m)"
ENDS = " .,;:!"  # what may stand behind a sentence
NO_COMMAND_ENDINGS = {
    "?": "That is a question. Say it as a command.",
    "..": "The sentence breaks off. Say all of it.",
}
"""Ends of a sentence that is no command, and why."""
QUOTED = re.compile(r"""(["'])(.*)\1""")
TYPESET = str.maketrans("\u00a0\u2009\u202f\u2010\u2011\u2212‘’“”", "   ---''\"\"") | {ord("…"): "..."}
"""Spaces, hyphens, the minus sign, and quotes as printers write them → as keyboards do. A dash may be neither."""
STOP_WORD = re.compile(r"(?<![^\W\d_])stop(?![^\W\d_])")

OTHER_WORDS = {
    "go back": ("I do not drive backwards. Turn round first, then continue.", ("turn left", "continue 1 meters")),
    "go to": ("Where to? Say the place in metres.", ("stop at 1 and 0.5",)),
}
"""Words of the paper (Table 2, Fig. 17) that do not move this robot: why, and what does."""


AHEAD = re.compile(r"\b(?:ahead|advance|forwards?|straight|drive \d)")
"""Words of people who mean CONTINUE."""


def compiled(pattern: str) -> re.Pattern[str]:
    """Return a pattern of words as a regular expression; "meters" may be spelt as people spell it."""
    plain = re.escape(pattern).replace(r"\ ", " ")
    source = re.sub("(?<!stop) (?!meters)", f"{PAUSE} ", plain).replace(" meters", UNIT)
    return re.compile(re.sub(r"\\\{(\w+)\\\}", lambda slot: f"(?P<{slot[1]}>{NUMBER})", source))


READ = {pattern: compiled(pattern) for kind in VOCABULARY for pattern in kind.words}
"""At once, not with the first command: that takes longer than a robot under way waits for the console."""


@dataclass(frozen=True)
class OwnPhrase:
    """Words of the user's own for a command of the vocabulary."""

    pattern: str  # "drive {distance_m} meters"
    kind: CommandSpec
    read: re.Pattern[str]


OwnPhrases = tuple[OwnPhrase, ...]


@dataclass(frozen=True)
class Refusal:
    """Words that move nothing."""

    reason: str  # a sentence
    suggestions: tuple[str, ...] = ()  # words that would be understood; never carried out by themselves


@dataclass(frozen=True)
class Parsed:
    """Words that went through the grammar once: a command without its bounds, or the reason why they are none."""

    words: str
    text: str | None  # the words, tidied; None where they are no plain utterance
    found: tuple[CommandSpec, dict[str, float]] | Refusal
    why_not: str = ""  # a sentence: why the marks behind the words make them no command

    def bounded(self, *, spoken: bool) -> Command | Refusal:
        """Return the command within the bounds of what is `spoken`, or typed."""
        verdict = self.found if isinstance(self.found, Refusal) else _bounded(*self.found, spoken)
        if self.why_not:
            offered = (verdict.heard_as,) if isinstance(verdict, Command) else verdict.suggestions
            verdict = Refusal(self.why_not, offered)
        if isinstance(verdict, Refusal) and STOP_WORD.search(_folded(self.words)):
            began = self.text is not None and _begins(_unpunctuated(self.text), "stop at")
            remark = f"“{self.words.strip()}” was not carried out: {verdict.reason}" if began else ""
            return Command(name=STOP_MOVING.name, numbers={}, heard_as=STOP_MOVING.words[0], remark=remark)
        return verdict


def parse(words: str, own: OwnPhrases = ()) -> Parsed:
    """Match words with the grammar and the user's own phrases; the bounds of their numbers are another question."""
    text, why_not = _tidy(words)
    return Parsed(words, text, _unreadable(words) if text is None else _matched(text, own), why_not)


def understand(words: str, *, spoken: bool = False, own: OwnPhrases = ()) -> Command | Refusal:
    """Parse words into a command; `spoken`: heard rather than typed, so tighter bounds hold."""
    return parse(words, own).bounded(spoken=spoken)


def say(kind: CommandSpec, numbers: dict[str, float], pattern: str | None = None) -> str:
    """A command as words that are understood as that command: "continue 1.5 meters"."""
    return (pattern or kind.words[0]).format(**{name: write_number(value) for name, value in numbers.items()})


def _folded(words: str) -> str:
    """Generously read: compatible forms of letters are one, invisible characters vanish. Only good for stopping."""
    plain = unicodedata.normalize("NFKC", words).casefold()
    return plain if plain.isascii() else "".join(c for c in plain if unicodedata.category(c) != "Cf")


def _tidy(words: str) -> tuple[str | None, str]:
    """Lower case, single spaces, no marks around the sentence; None for what is no plain utterance. And why it is no
    command by its end; "" for no reason.
    """
    text = words.strip(" \t\r\n") if len(words) <= 10 * LONGEST else words
    if len(text) > LONGEST:
        return None, ""
    text = text.translate(TYPESET)
    if not text.isascii() or not text.isprintable():
        return None, ""
    text, end = _ended(text.lower())
    quoted = QUOTED.fullmatch(text)
    if quoted:
        text, within = _ended(quoted[2])
        end = within + end
    return " ".join(text.split()), next((why for mark, why in NO_COMMAND_ENDINGS.items() if mark in end), "")


def _ended(text: str) -> tuple[str, str]:
    """A sentence without the marks behind it, and those marks."""
    whole = text.rstrip(ENDS + "?")
    return whole.lstrip(" "), text[len(whole) :].replace(" ", "")


def _unpunctuated(text: str) -> str:
    """A tidy text without the marks at the ends of its words."""
    return re.sub(" ?[,:](?= )", "", text)


def _unreadable(words: str) -> Refusal:
    if len(words) > LONGEST:
        return Refusal("That is longer than any command. Say one command at a time.", _examples())
    return Refusal("I read plain letters and digits on one line only. Type the command again.", _examples())


def _matched(text: str, own: OwnPhrases) -> tuple[CommandSpec, dict[str, float]] | Refusal:
    """A tidy text → the command that it is and the numbers in it."""
    patterns = ((kind, READ[pattern]) for kind in VOCABULARY for pattern in kind.words)
    for kind, read in (*patterns, *((phrase.kind, phrase.read) for phrase in own)):
        match = read.fullmatch(text)
        if match:
            return kind, {name: read_number(value) for name, value in match.groupdict().items()}
    if text in OTHER_WORDS:
        return Refusal(*OTHER_WORDS[text])
    return _near_miss(_unpunctuated(text))


def command_of(name: str, numbers: Mapping[str, float], *, spoken: bool = False) -> Command | Refusal:
    """Build a command that comes as a name and numbers, from a worker or a click: the bounds are those of words."""
    spec = next((spec for spec in VOCABULARY if spec.name == name), None)
    known = {number.name for number in spec.numbers} if spec else set[str]()
    needed = {number.name for number in spec.numbers if number.default is None} if spec else set[str]()
    if spec is None or not needed <= numbers.keys() <= known:
        return Refusal("There is no such command.")
    if not all(math.isfinite(value) for value in numbers.values()):
        return Refusal("A number of this command is not finite.")
    return _bounded(spec, dict(numbers), spoken)


def _bounded(kind: CommandSpec, heard: dict[str, float], spoken: bool) -> Command | Refusal:
    """A command, if every number lies within its bounds."""
    numbers = {number.name: heard.get(number.name, number.default) for number in kind.numbers}
    kept = {name: value for name, value in numbers.items() if value is not None}
    for number in kind.numbers:
        low, high = bounds(number, spoken)
        if not low <= kept[number.name] <= high:
            by_voice = " by voice" if spoken else ""
            too_far = len(kind.numbers) == 1 and kept[number.name] > high
            return Refusal(
                f"“{_pattern_as_read(kind)}” takes {number.says} from {low:g} to {high:g} {_unit(number)}{by_voice}.",
                (say(kind, {number.name: high}) if too_far else kind.example,),
            )
    return Command(name=kind.name, numbers=kept, heard_as=say(kind, heard))


def bounds(number: Parameter, spoken: bool) -> tuple[float, float]:
    """The lowest and the highest value that is accepted."""
    if not spoken or number.spoken_high is None:
        return number.low, number.high
    return max(number.low, -number.spoken_high), min(number.high, number.spoken_high)


def _near_miss(text: str) -> Refusal:
    """The reason why nothing matches, and what would."""
    if not text:
        return Refusal("Say a command.", _examples())
    begun = [(_opening(words), kind) for kind in VOCABULARY for words in kind.words if _begins(text, _opening(words))]
    if begun:
        opening, kind = max(begun, key=lambda found: len(found[0]))
        return _badly_ended(kind, opening, text)
    if AHEAD.search(text):
        return Refusal("I know no such command. Did you mean one of these?", (_filled(CONTINUE, text),))
    close = nearest(text, _phrases())
    if close and close[0] in OTHER_WORDS:
        why, instead = OTHER_WORDS[close[0]]
        return Refusal(f"Did you mean “{close[0]}”? {why}", instead)
    understood = tuple(phrase for phrase in close if phrase not in OTHER_WORDS)
    if understood:
        return Refusal("I know no such command. Did you mean one of these?", understood)
    return Refusal("I know no such command. These I know.", _examples())


def _opening(pattern: str) -> str:
    return pattern.partition("{")[0].strip()


def _begins(text: str, opening: str) -> bool:
    return text == opening or text.startswith(opening + " ")


def _badly_ended(kind: CommandSpec, opening: str, text: str) -> Refusal:
    """The right beginning with something missing or something too much."""
    if not kind.numbers or all(number.default is not None for number in kind.numbers):
        return Refusal(f"“{opening}” stands alone, with nothing before or behind it.", (kind.example,))
    fits = _filled(kind, text) if re.search(rf"{NUMBER}\)*$", text) else kind.example
    return Refusal(f"Say it whole and with nothing else, like “{fits}”; distances are in metres.", (fits,))


def _filled(kind: CommandSpec, text: str) -> str:
    """A command with the numbers of these words; its example where they are too many, too few or out of bounds."""
    numbers = re.findall(rf"(?<![a-z0-9.,]){NUMBER}(?![a-z0-9.,])", text)
    if len(numbers) != len(kind.numbers):
        return kind.example
    words = say(kind, {one.name: read_number(number) for one, number in zip(kind.numbers, numbers, strict=True)})
    return words if isinstance(understand(words), Command) else kind.example


@cache
def _examples() -> tuple[str, ...]:
    return tuple(kind.example for kind in VOCABULARY if kind is not START)  # it changes nothing: no useful example


@cache
def _phrases() -> tuple[str, ...]:
    """All that people might have meant, with the numbers of the examples."""
    return (*_examples(), "stop", "go to 1 and 0.5", *OTHER_WORDS)


def _pattern_as_read(kind: CommandSpec) -> str:
    return kind.words[0].format(**{number.name: number.says for number in kind.numbers})


def _unit(number: Parameter) -> str:
    return {"m": "metres"}.get(number.unit, number.unit)
