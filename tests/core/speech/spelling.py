"""Numbers written out in words, for the tests to read back."""

from core.speech.understanding.numbers import DIGITS, TEEN_WORDS, TENS


def spell(value: float) -> str:
    """A number below 1000, in hundredths → its words: -1.25 → "minus one point two five"."""
    hundredths = round(abs(value) * 100)
    words = ["minus"] if value < 0 else []
    words.append(spell_whole(hundredths // 100))
    if hundredths % 100:
        words += ["point", *(DIGITS[int(digit)] for digit in f"{hundredths % 100:02d}")]
    return " ".join(words)


def spell_whole(value: int) -> str:
    if value >= 100:
        rest = f" {spell_whole(value % 100)}" if value % 100 else ""
        return f"{DIGITS[value // 100]} hundred{rest}"
    if value < 20:
        return (*DIGITS, *TEEN_WORDS)[value]
    rest = f" {DIGITS[value % 10]}" if value % 10 else ""
    return TENS[value // 10 - 2] + rest
