"""Words → command or refusal: the one parser for all typed, clicked, sent or heard text (section 4.2, Table 2).

Only a whole utterance that matches moves the robot. Whatever contains the word STOP and is no complete, bounded
"stop at x and y" stops it, and so does a phrase of STOP_PHRASES by itself. Nothing is guessed: a near miss is refused
with suggestions, which never change a number or its unit; after what may mean STOP, that is the suggestion.

Recognizers and people punctuate. A comma or a colon may end a word or a whole number, and a sentence may end with any
mark and stand in quotes. Within a number a comma says two things ("1,5"), behind STOP any mark ends the sentence,
and where the marks say that it is a question or breaks off, it moves nothing.
"""

import math
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache

from core.commands import SPECS, VOCABULARY
from core.commands.command import Command, CommandSpec, Parameter
from core.commands.continue_straight import CONTINUE
from core.commands.routes import START_ROUTE
from core.commands.stop_at import STOP_AT, TO_PLACE, command_to
from core.commands.stop_moving import AROUND_STOP, START, STOP_MOVING, STOP_PHRASES
from core.navigation.places import NamedPlace
from core.sentences import Statement
from core.speech.understanding.numbers import AMOUNT, NUMBER, VALUES, read_amount, write_number


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


MAX_CHARACTERS = 120  # characters of an utterance that is read at all; the word stop is looked for in all of it

PAUSE = "(?: ?[,:])?"  # between the words of a sentence
UNITS = ("meters", "meter", "metres", "metre")  # as people spell what stands as "meters" in the vocabulary
BEFORE_UNIT = "(?:(?: ?,)? |(?<=[0-9]))"  # no colon: "2: meters" may be a time
UNIT = rf"{BEFORE_UNIT}(?:{'|'.join(UNITS)}|m)"
HUNDREDTHS = ("centimeters", "centimeter", "centimetres", "centimetre")
IN_HUNDREDTHS = rf"{BEFORE_UNIT}(?:{'|'.join(HUNDREDTHS)})"
LENGTH = rf"{AMOUNT}(?:{UNIT}|{IN_HUNDREDTHS})"
"""Regular expression of a distance: "2 meters", "two and a half meters", "50 centimeters"."""
LENGTH_UNIT = re.compile(rf"(?:{UNIT}|({IN_HUNDREDTHS}| ?cm))$")
ENDS = " .,;:!"  # what may stand behind a sentence
NO_COMMAND_ENDINGS = {"?": Statement("words.question"), "..": Statement("words.breaks_off")}
"""Ends of a sentence that is no command, and why."""
QUOTED = re.compile(r"""(["'])(.*)\1""")
GERMAN = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"})
TYPESET = str.maketrans("\u00a0\u2009\u202f\u2010\u2011\u2212‘’“”", "   ---''\"\"") | {ord("…"): "..."}
"""Spaces, hyphens, the minus sign, and quotes as printers write them → as keyboards do. A dash may be neither."""
STOP_WORD = re.compile(r"(?<![^\W\d_])(?:(?:s+t(?:o|ooo+)p+)+|s([-._ ])t\1o\1p)(?![^\W\d_])")
"""STOP, stopp, stooop, stopstop, S.T.O.P."""

OTHER_WORDS = {
    "go back": (Statement("words.not_backwards"), ("turn left", "continue 1 meters")),
    "go to": (Statement("words.where_to"), ("stop at 1 and 0.5",)),
}
"""Words of the paper (Table 2, Fig. 17) that do not move this robot: why, and what does."""


TO_SOMEWHERE = re.compile(r"(?:go to|stop at) \w")
MOST_PLACES_OFFERED = 5
AHEAD = re.compile(
    r"\b(?:ahead|advance|forwards?|straight|drive)\b|^(?:go|move|travel) (?:[0-9.]+ ?m|\S+ met(?:er|re)s?)$"
)
"""Words of people who mean CONTINUE."""
OTHER_LENGTHS = "cm|mm|km|(centi|milli|kilo)met(er|re)s?|feet|foot|ft|inch(es)?|yards?|miles?|steps?"
OTHER_UNITS = "seconds?|minutes?|degrees?|percent"
NUMBER_WORDS = "hundred|thousand|niner|half|quarters?|thirds?|dozen|couple|few|several|minus|negative"
MENTIONS_NUMBER = re.compile(
    rf"[0-9]|\b(?:{'|'.join(VALUES)}|{NUMBER_WORDS}|{OTHER_LENGTHS}|{OTHER_UNITS}|an? m(et(er|re)s?)?)\b"
)
"""Return whether words speak of how many, or how far."""
OFFERED_LENGTH = re.compile(
    rf"(?<![\w.,/'-])(?:{LENGTH}|{AMOUNT} ?cm|(?!an? |half ){AMOUNT})(?![\w/'%°-]|[.,]\w| and a half| hundred)"
)
"""A number in words that are no command, with its unit, if any; nothing stands against it that may change it."""
AROUND_NUMBERS = frozenset(
    re.split(
        " ",
        "ahead advance and at continue drive for forward forwards go move on please robot stop straight the to x y",
    )
)
"""Words around a number that do not change it."""
STOP_OFFERED = STOP_MOVING.words[-1]
NOT_WORDS = frozenset(("cannot", "dont", "never", "no", "nor", "not", "without"))
"""Words with which people take something back."""


def compiled(pattern: str) -> re.Pattern[str]:
    """Return a pattern of words as a regular expression; "meters" may be spelt as people spell it.

    A lone distance may also be a half or in centimeters.
    """
    plain = re.escape(pattern).replace(r"\ ", " ")
    source = re.sub("(?<!stop) (?!meters)", f"{PAUSE} ", plain)
    if plain.count(r"\{") == 1:
        source = re.sub(r"\\\{(\w+)\\\} meters", rf"(?P<\1>{LENGTH})", source)
    source = source.replace(" meters", UNIT)
    return re.compile(re.sub(r"\\\{(\w+)\\\}", lambda slot: f"(?P<{slot[1]}>{NUMBER})", source))


def read_length(words: str) -> float:
    """Convert a LENGTH to metres, and a lone number to itself. "50 centimeters" → 0.5."""
    unit = LENGTH_UNIT.search(words)
    if unit is None:
        return read_amount(words)
    return read_amount(words[: unit.start()]) / (100 if unit[1] else 1)


READ = {pattern: compiled(pattern) for kind in VOCABULARY for pattern in kind.words}
"""At once, not with the first command: that takes longer than a robot under way waits for the console."""


@dataclass(frozen=True)
class OwnPhrase:
    """Words of the user's own for a command of the vocabulary."""

    pattern: str  # "drive {distance_m} meters"
    kind: CommandSpec
    read: re.Pattern[str]
    place: NamedPlace | None = None  # that these words name


OwnPhrases = tuple[OwnPhrase, ...]


@dataclass(frozen=True)
class Refusal:
    """Words that move nothing."""

    reason: str  # a sentence
    suggestions: tuple[str, ...] = ()  # words that would be understood; never carried out by themselves


@dataclass(frozen=True)
class MatchedWords:
    """The command that words are, before its bounds."""

    kind: CommandSpec
    numbers: dict[str, float]  # that stand in the words
    place: NamedPlace | None = None  # that they name

    def bounded(self, *, spoken: bool) -> Command | Refusal:
        """Return the command, if every number lies within its bounds."""
        return _bounded(self.kind, self.numbers, spoken) if self.place is None else command_to(self.place)


@dataclass(frozen=True)
class Parsed:
    """Words that went through the grammar once: a command without its bounds, or the reason why they are none."""

    words: str
    text: str | None  # the words, tidied; None where they are no plain utterance
    found: MatchedWords | Refusal
    why_not: str = ""  # a sentence: why the marks behind the words make them no command

    def bounded(self, *, spoken: bool) -> Command | Refusal:
        """Return the command within the bounds of what is `spoken`, or typed."""
        verdict = self.found if isinstance(self.found, Refusal) else self.found.bounded(spoken=spoken)
        if self.why_not:
            offered = (verdict.heard_as,) if isinstance(verdict, Command) else verdict.suggestions
            verdict = Refusal(self.why_not, offered)
        if isinstance(verdict, Refusal) and says_stop(self.words):
            remark = self._why_only_stopped(verdict)
            return Command(name=STOP_MOVING.name, numbers={}, heard_as=STOP_MOVING.words[0], remark=remark)
        if isinstance(verdict, Refusal):
            return replace(verdict, suggestions=faithful(verdict.suggestions, self.words))
        return verdict

    def _why_only_stopped(self, verdict: Refusal) -> str:
        """Why words that begin as "stop at x and y" go nowhere; "" for words that begin as others do."""
        if self.text is None:
            return ""
        said = _unpunctuated(self.text)
        if not _begins(said, "stop at") or _begins(said, "stop at once"):
            return ""
        words = self.words.strip()
        if self.why_not or MENTIONS_NUMBER.search(self.text):
            return f"“{words}” was not carried out: {verdict.reason}"
        ways = dict.fromkeys((STOP_AT.example, *verdict.suggestions[:1]))  # a point, and a place if there is one
        return Statement("words.stopped_nowhere", words=words, ways=", ".join(f"“{way}”" for way in ways))


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


def says_stop(words: str) -> bool:
    """Return whether words stop the robot: the word stop is in them, or they are a phrase that does, and no more."""
    folded = _folded(words)
    alone = _letters(folded) if len(folded) <= MAX_CHARACTERS else ""
    return STOP_WORD.search(folded) is not None or STOP_UTTERANCE.fullmatch(alone) is not None


def _letters(folded: str) -> str:
    """Words without marks: "don't move!" → "dont move"."""
    return " ".join(re.findall(r"[^\W_]+", re.sub("['’]", "", folded)))


STOP_UTTERANCE = re.compile(
    "(?:(?:{0}) )*(?:{1})(?: (?:{0}|{1}))*".format("|".join(AROUND_STOP), "|".join(map(_letters, STOP_PHRASES)))
)
STOP_LIKE = tuple(word for word in ("stop", *STOP_PHRASES) if " " not in word and len(word) > 3)
"""Words that are near to one of these may be one, misspelt."""


def may_mean_stop(words: str) -> bool:
    """Return whether who said these words may have wanted the robot to stop: then nothing else is offered."""
    said = _letters(_folded(words[:MAX_CHARACTERS])).split()
    text = f" {' '.join(said)} "
    few = said if len(said) <= 3 else []
    return (
        not NOT_WORDS.isdisjoint(said)
        or any(f" {_letters(phrase)} " in text for phrase in STOP_PHRASES)
        or any(word.startswith("stop") for word in said)
        or any(nearest(word, STOP_LIKE) for word in few if len(word) > 2)
    )


def faithful(offers: Iterable[str], words: str) -> tuple[str, ...]:
    """Those of the offers that change nothing in the words: no number, no unit, and no STOP into a motion."""
    if may_mean_stop(words):
        return (STOP_OFFERED,)
    text = _tidy(words)[0] or ""
    if not MENTIONS_NUMBER.search(text) and not any(map(str.isnumeric, words)):
        return tuple(offers)
    lengths = _lengths(text)
    return tuple(one for one in offers if one in STOP_MOVING.words or (lengths and _numbers(one) == lengths))


def _numbers(words: str) -> list[float]:
    found = parse(words).found
    return [] if isinstance(found, Refusal) else list(found.numbers.values())


def _lengths(text: str) -> list[float] | None:
    """The numbers of these words, of distances in metres; None where anything around them may change one."""
    around = re.findall(r"[^\s(),:]+", OFFERED_LENGTH.sub(" ", text))
    if any(word not in AROUND_NUMBERS and not _misspells(word) for word in around):
        return None
    return [read_length(found[0]) for found in OFFERED_LENGTH.finditer(text)]


def _misspells(word: str) -> bool:
    """Return whether a long word is one that may stand around numbers, misspelt."""
    return len(word) > 4 and bool(nearest(word, (one for one in AROUND_NUMBERS if len(one) > 4)))


def plain_letters(words: str) -> str:
    """Letters with marks as letters from a to z: "Küche" → "Kueche", "café" → "cafe"; what else there is stays."""
    if words.isascii():
        return words
    spelt = unicodedata.normalize("NFC", words).translate(GERMAN)
    return "".join(c for c in unicodedata.normalize("NFD", spelt) if unicodedata.category(c) != "Mn")


def _tidy(words: str) -> tuple[str | None, str]:
    """Lower case, single spaces, no marks around the sentence; None for what is no plain utterance. And why it is no
    command by its end; "" for no reason.
    """
    text = words.strip(" \t\r\n") if len(words) <= 10 * MAX_CHARACTERS else words
    if len(text) > MAX_CHARACTERS:
        return None, ""
    text = plain_letters(text.translate(TYPESET))
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
    if len(words) > MAX_CHARACTERS:
        return Refusal(Statement("words.too_long"), _examples())
    return Refusal(Statement("words.plain_letters"), _examples())


def _matched(text: str, own: OwnPhrases) -> MatchedWords | Refusal:
    """A tidy text → the command that it is and the numbers in it."""
    patterns = ((kind, READ[pattern], None) for kind in VOCABULARY for pattern in kind.words)
    for kind, read, place in (*patterns, *((phrase.kind, phrase.read, phrase.place) for phrase in own)):
        match = read.fullmatch(text)
        if match:
            return MatchedWords(kind, {name: read_length(value) for name, value in match.groupdict().items()}, place)
    if STOP_UTTERANCE.fullmatch(_letters(text)):
        return MatchedWords(STOP_MOVING, {})
    if text in OTHER_WORDS:
        return Refusal(*OTHER_WORDS[text])
    plain = _unpunctuated(text)
    return _other_place(plain, own) or _near_miss(plain)


def _other_place(text: str, own: OwnPhrases) -> Refusal | None:
    """The answer to words that go to a place which nobody has named; None where they go nowhere, or to numbers."""
    known = [phrase.pattern for phrase in own if phrase.place is not None and not phrase.place.route]
    if not TO_SOMEWHERE.match(text) or MENTIONS_NUMBER.search(text):
        return None
    if not known:
        fits = STOP_AT.example
        return Refusal(Statement("places.none", example=fits), (fits,)) if text.startswith("go to ") else None
    close = nearest(text, known)
    if close:
        return Refusal(Statement("places.other"), close)
    return Refusal(Statement("places.others"), tuple(known[: len(TO_PLACE) * MOST_PLACES_OFFERED : len(TO_PLACE)]))


def command_of(name: str, numbers: Mapping[str, float], *, spoken: bool = False) -> Command | Refusal:
    """Build a command that comes as a name and numbers, from a worker or a click: the bounds are those of words.

    What needs the name of a place, too (the start of a route), is refused: see `command_to`.
    """
    spec = SPECS.get(name) if name != START_ROUTE.name else None
    known = {number.name for number in spec.numbers} if spec else set[str]()
    needed = {number.name for number in spec.numbers if number.default is None} if spec else set[str]()
    if spec is None or not needed <= numbers.keys() <= known:
        return Refusal(Statement("words.none"))
    if not all(math.isfinite(value) for value in numbers.values()):
        return Refusal(Statement("words.not_finite"))
    return _bounded(spec, dict(numbers), spoken)


def _bounded(kind: CommandSpec, heard: dict[str, float], spoken: bool) -> Command | Refusal:
    """A command, if every number lies within its bounds."""
    numbers = {number.name: heard.get(number.name, number.default) for number in kind.numbers}
    kept = {name: value for name, value in numbers.items() if value is not None}
    for number in kind.numbers:
        low, high = bounds(number, spoken)
        if not low <= kept[number.name] <= high:
            takes = Statement("words.bounds_spoken" if spoken else "words.bounds")
            words, unit = kind.words[0].format(**{number.name: number.says for number in kind.numbers}), _unit(number)
            return Refusal(takes(words=words, what=number.says, low=f"{low:g}", high=f"{high:g}", unit=unit))
    return Command(name=kind.name, numbers=kept, heard_as=say(kind, heard))


def bounds(number: Parameter, spoken: bool) -> tuple[float, float]:
    """The lowest and the highest value that is accepted."""
    if not spoken or number.spoken_high is None:
        return number.low, number.high
    return max(number.low, -number.spoken_high), min(number.high, number.spoken_high)


def _near_miss(text: str) -> Refusal:
    """The reason why nothing matches, and what would."""
    if not text:
        return Refusal(Statement("words.say_one"), _examples())
    begun = [(_opening(words), kind) for kind in VOCABULARY for words in kind.words if _begins(text, _opening(words))]
    if begun:
        opening, kind = max(begun, key=lambda found: len(found[0]))
        return _badly_ended(kind, opening, text)
    if AHEAD.search(text):
        return _to_be_whole(CONTINUE, text)
    close = nearest(text, _phrases(text))
    if close and close[0] in OTHER_WORDS:
        why, instead = OTHER_WORDS[close[0]]
        return Refusal(Statement("words.did_you_mean", words=close[0], why=why), instead)
    understood = faithful((phrase for phrase in close if phrase not in OTHER_WORDS), text)
    if understood:
        return Refusal(Statement("words.unknown_like"), understood)
    return Refusal(Statement("words.unknown"), _examples())


def _opening(pattern: str) -> str:
    return pattern.partition("{")[0].strip()


def _begins(text: str, opening: str) -> bool:
    return text == opening or text.startswith(opening + " ")


def _badly_ended(kind: CommandSpec, opening: str, text: str) -> Refusal:
    """The right beginning with something missing or something too much."""
    if not kind.numbers or all(number.default is not None for number in kind.numbers):
        return Refusal(Statement("words.alone", words=opening), (kind.example,))
    return _to_be_whole(kind, text)


def _to_be_whole(kind: CommandSpec, text: str) -> Refusal:
    fits = _filled(kind, text)
    return Refusal(Statement("words.whole", example=fits), (fits,))


def _filled(kind: CommandSpec, text: str) -> str:
    """A command with the numbers of these words; its example where they do not fit."""
    lengths = _lengths(text)
    if not lengths or len(lengths) != len(kind.numbers):
        return kind.example
    words = say(kind, {one.name: length for one, length in zip(kind.numbers, lengths, strict=True)})
    return words if isinstance(understand(words), Command) else kind.example


@cache
def _examples() -> tuple[str, ...]:
    """STOP first: it is never the wrong one."""
    kinds = sorted(VOCABULARY, key=lambda kind: kind is not STOP_MOVING)
    return tuple(kind.example for kind in kinds if kind is not START)  # it changes nothing: no useful example


def _phrases(text: str) -> tuple[str, ...]:
    """All that people might have meant, with the numbers of the text, or those of the examples."""
    filled = tuple(_filled(kind, text) if kind.numbers else kind.example for kind in VOCABULARY if kind is not START)
    return (*filled, *STOP_MOVING.words[1:], "go to 1 and 0.5", *OTHER_WORDS)


def _unit(number: Parameter) -> str:
    return {"m": "metres"}.get(number.unit, number.unit)
