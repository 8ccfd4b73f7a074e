"""Numbers as people say and type them: "two point five", "minus one", "one hundred", "1.5", ".5", "-1".

Only whole, unmistakable numbers: no homophones ("to", "for", "oh"), no foreign digits, no exponents; halves and
a comma before decimals only where a unit follows.
"""

import re

DIGITS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
TEEN_WORDS = (
    "ten",
    "eleven",
    "twelve",
    "thirteen",
    "fourteen",
    "fifteen",
    "sixteen",
    "seventeen",
    "eighteen",
    "nineteen",
)
TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")

VALUES = {word: value for value, word in enumerate(DIGITS + TEEN_WORDS)} | {
    word: 10 * (place + 2) for place, word in enumerate(TENS)
}

WHOLE_WORDS = {str(value): word for word, value in VALUES.items()} | {
    str(VALUES[tens] + value): f"{tens} {DIGITS[value]}" for tens in TENS for value in range(1, 10)
}
"""A number up to 99 in digits → the same in words."""

_DIGIT = "(?:" + "|".join(DIGITS) + ")"
_ONE_TO_NINE = "(?:" + "|".join(DIGITS[1:]) + ")"
_BELOW_100 = f"(?:(?:{'|'.join(TENS)})(?:[ -]{_ONE_TO_NINE})?|{'|'.join(TEEN_WORDS)}|{_DIGIT})"
_WHOLE = f"(?:{_ONE_TO_NINE} hundred(?: {_BELOW_100})?|{_BELOW_100})"
_SPOKEN = f"(?:{_WHOLE}(?: point(?: {_DIGIT})+)?|point(?: {_DIGIT})+)"
_TYPED = r"(?:[0-9]{1,9}(?:\.[0-9]{1,9})?|\.[0-9]{1,9})"

NUMBER = f"(?:minus (?:{_TYPED}|{_SPOKEN})|-?{_TYPED}|{_SPOKEN})"
"""Regular expression of one number, for lower-case text with single spaces."""

DECIMAL_COMMA = "[0-9]{1,9},[0-9]{1,2}"  # with three digits behind it "1,500" may be a thousand and a half
HALF, AND_A_HALF = "half a", " and a half"
_HALVES = f"(?:[0-9]{{1,9}}|{_BELOW_100}){AND_A_HALF}"
AMOUNT = f"(?:{_HALVES}|{DECIMAL_COMMA}|{HALF}n?|an?|{NUMBER})"
"""Regular expression of how many units a length has: a number, "half a", "two and a half", "1,5"."""


def read_amount(words: str) -> float:
    """Convert text that matched AMOUNT to its value. "two and a half" → 2.5."""
    if words in ("a", "an"):
        return 1.0
    if words in (HALF, f"{HALF}n"):
        return 0.5
    whole, half, _ = words.partition(AND_A_HALF)
    return read_number(whole.replace(",", ".")) + (0.5 if half else 0.0)


def read_number(words: str) -> float:
    """Convert text that matched NUMBER to its value. "minus two point five" → -2.5."""
    positive = re.sub("^(?:minus |-)", "", words)
    sign = -1.0 if positive != words else 1.0
    size = float(positive) if re.fullmatch(_TYPED, positive) else _read_spoken(positive)
    return sign * size if size else 0.0


def write_number(value: float) -> str:
    """Value → the shortest digits that NUMBER reads back: 1.5 → "1.5", 2.0 → "2"."""
    text = f"{value:.9f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def number_words(value: float) -> list[str]:
    """Value → the words in which it is said: -0.25 → minus, point, two, five. No zero is said before the point."""
    whole, _, decimals = write_number(abs(value)).partition(".")
    said = WHOLE_WORDS.get(whole, " ".join(DIGITS[int(digit)] for digit in whole)).split()
    behind = ["point", *(DIGITS[int(digit)] for digit in decimals)] if decimals else []
    return ["minus"] * (value < 0) + said * (value == 0 or abs(value) >= 1) + behind


def _read_spoken(words: str) -> float:
    whole, _, decimals = words.partition("point")
    value = 0
    for word in re.split("[ -]", whole.strip()):
        if word == "hundred":
            value *= 100
        elif word:
            value += VALUES[word]
    fraction = "".join(str(VALUES[word]) for word in decimals.split())
    return float(f"{value}.{fraction or 0}")
