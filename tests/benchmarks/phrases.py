"""Numbers, words that stop, and talk, in one table: `python -m tests.benchmarks.phrases --data FOLDER`.

FOLDER holds strangers/words/phr.tsv (ways to write numbers, and what each may do) and the sounds of
`tests.benchmarks.voices`. To 300 phrases it is filled up with drawn numbers. Spoken phrases take turns with voices of
espeak-ng on which no threshold was chosen; odd numbers (two in a row, ordinals, other units, words that sound like
one) by four of them each. Words that stop stand beside clauses of the documentation and real talk.

`--speakers FOLDER…` reads recordings of other people or synthesizers instead: index.tsv with the columns file, kind
(the speaker) and text. Told for every speaker: right, refused, WRONG, and how often numbers are right by the
confidence in them. `--spoken N` takes every Nth spoken phrase; 0: none. Every wrong motion is listed.
"""

import itertools
import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from core.commands.command import Command
from core.commands.stop_moving import AROUND_STOP, STOP_MOVING, STOP_PHRASES
from core.message import Array
from core.speech.recognition.decision import Decision, Sentence, log_odds
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import for_words
from core.speech.settings import SpeechSettings
from core.speech.synthesis import ACCENTS, NATURAL_WORDS_MIN, VoiceSettings, speak
from core.speech.understanding.grammar import Refusal, says_stop, understand
from tests.benchmarks.accents import drawn_sentences
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.voices import (
    REFUSED,
    RIGHT,
    STOPPED,
    WRONG,
    Decide,
    HeardNumber,
    as_cut,
    outcome_of_all,
    reliability,
    talk,
)
from tests.benchmarks.word_hearing import padded
from tests.benchmarks.word_scenes import clips_of

NUMBER_PHRASES, STOP_WORDS = 300, 60  # of each at least
UNUSED_VOICES = tuple((accent, pitch) for accent in ACCENTS for pitch in (10, 90))
"""Accents in pitches (50 is natural) on which nothing was chosen."""
SPEAKABLE = re.compile(r"[A-Za-z ]*(?:[0-9]+(?:\.[0-9]+)?[A-Za-z ]*)?")
"""A phrase whose marks are heard: with one number in digits at most."""
ODD_NUMBERS = (
    *("two three", "three two", "two uh three", "two no three", "two sorry three", "two to three", "two or three"),
    *("to", "for", "won", "ate", "tree", "free", "sex", "fife"),
    *("half two", "minus two", "twice two", "two square", "less than two", "not two"),
    *("one point five five five", "one point two point three"),
)
"""Words before "meters" that are no number, or another one than the first or last of them."""
SAME_SOUND = {
    **dict.fromkeys(("to", "too"), "continue(2)"),
    **dict.fromkeys(("for", "fore"), "continue(4)"),
    "won": "continue(1)",
    **dict.fromkeys(("tree", "free"), "continue(3)"),
    "fife": "continue(5)",
}
"""Words that nobody can tell from a number by their sound → what they may be: those that a dictionary gives the same
phones, those for one over the radio, and those with f or t for its th, as accents of London and Dublin have it.
"""
ODD_LENGTHS = ("second meter", "third meter", "two feet", "two miles", "two meters back", "two meters three")
ODD_VOICES = 4  # for each of them
DRAWN_SEED = 900


def allowed(rule: str) -> set[str]:
    """The commands that a rule of phr.tsv lets a phrase be; it may always be refused."""
    return {one for one in rule.split("/") if one != "reject"}


def rule_of(command: Command) -> str:
    """A command as the rules name it: "continue(1.5)"."""
    numbers = ",".join(f"{value:g}" for value in command.numbers.values())
    return f"{command.name}({numbers})" if numbers else command.name


def number_phrases(data: Path) -> Iterator[tuple[str, set[str]]]:
    """(phrase, the commands that it may be), of the file and then drawn ones, without an end."""
    for line in (data / "strangers" / "words" / "phr.tsv").read_text().splitlines():
        phrase, rule = line.split("\t")[:2]
        yield phrase, allowed(rule)
    for seed in itertools.count(DRAWN_SEED):
        for phrase, _ in drawn_sentences(seed):
            meant = understand(phrase)
            assert isinstance(meant, Command)
            yield phrase, {rule_of(meant)}


def judged(found: Iterable[Command | None], may: set[str]) -> str:
    """Return what became of a phrase: the gravest of all that was understood."""
    moved = [one for one in found if one is not None]
    if not moved:
        return REFUSED if may else RIGHT
    if any(one.name != STOP_MOVING.name and rule_of(one) not in may for one in moved):
        return WRONG
    return STOPPED if any(one.name == STOP_MOVING.name for one in moved) else RIGHT


def stop_words() -> list[str]:
    """Return STOP, the declared phrases, and as many with words around them as are needed."""
    alone = ["stop", "stop moving", *STOP_PHRASES]
    around = [
        f"{before} {phrase}" for before, phrase in zip(itertools.cycle(AROUND_STOP), STOP_PHRASES, strict=False)
    ]
    return [*alone, *around[: max(STOP_WORDS - len(alone), 0)]]


def as_typed(words: str) -> Command | None:
    read = understand(words)
    return None if isinstance(read, Refusal) else read


def row(name: str, found: Counter[str]) -> None:
    """Write a row of the table."""
    print_row(f"{name:42}{found.total():6}" + "".join(f"{found[one]:9}" for one in (RIGHT, REFUSED, STOPPED, WRONG)))


def offers_that_change(phrases: Iterable[tuple[str, set[str]]]) -> list[str]:
    """Phrases whose offers have other numbers than they may have."""
    changed: list[str] = []
    for words, may in phrases:
        read = understand(words)
        for offer in read.suggestions if isinstance(read, Refusal) and any("(" in one for one in may) else ():
            meant = as_typed(offer)
            if meant is not None and meant.numbers and rule_of(meant) not in may:
                changed.append(f"{words} → {offer}")
    return changed


def typed(data: Path) -> None:
    """The rows of typed words."""
    phrases = list(itertools.islice(number_phrases(data), NUMBER_PHRASES))
    found: Counter[str] = Counter()
    for words, may in phrases:
        command = as_typed(words)
        result = judged([command], may)
        found[result] += 1
        if result == WRONG and command is not None:
            print_row(f"  {WRONG} “{words}” → {command.heard_as}")
    row("numbers, typed", found)
    for changed in offers_that_change(phrases):
        print_row(f"  the offer changes the number: {changed}")
    stops = Counter(
        STOPPED if (it := as_typed(one)) and it.name == STOP_MOVING.name else WRONG for one in stop_words()
    )
    row("words that stop, typed", stops)
    clauses = list(documentation())
    stopping = [one for one in clauses if says_stop(one)]
    plain = [one for one in stopping if "stop" not in one.lower()]
    row(
        "clauses of the documentation, typed",
        Counter({REFUSED: len(clauses) - len(stopping), STOPPED: len(stopping)}),
    )
    print_row(f"  stopped without the word stop: {plain}")


def documentation() -> Iterator[str]:
    """The clauses of the pages in static/docs."""
    for page in sorted(Path("static/docs").rglob("*.md")):
        for clause in re.split(r"[.;:!?()|\n]+", page.read_text()):
            if words := clause.strip(" #*`>-_"):
                yield words


def odd_numbers() -> Iterator[tuple[str, set[str]]]:
    """(phrase, the commands that it may be), each for as many voices as are to say it."""
    for words in (*(f"{number} meters" for number in ODD_NUMBERS), *ODD_LENGTHS):
        yield from ODD_VOICES * [(f"continue {words}", set())]


def as_it_sounds(words: str, may: set[str]) -> set[str]:
    number = words.removeprefix("continue ").removesuffix(" meters")
    return {*may, SAME_SOUND[number]} if number in SAME_SOUND else may


def of_synthesis(data: Path, decide: Decide, every: int) -> None:
    """The rows of spoken words."""
    phrases = ((words, may) for words, may in number_phrases(data) if SPEAKABLE.fullmatch(words))
    numbers = list(itertools.islice(phrases, NUMBER_PHRASES))
    stops = [(words, {STOP_MOVING.name}) for words in stop_words()]
    for name, rows in (
        ("numbers, spoken", numbers),
        ("odd numbers, spoken", list(odd_numbers())),
        ("words that stop, spoken", stops),
    ):
        found: Counter[str] = Counter()
        unsaid = 0
        for number, (words, may) in enumerate(rows[::every]):
            voice, pitch = UNUSED_VOICES[number % len(UNUSED_VOICES)]
            sound = speak(words, VoiceSettings(voice=voice, pitch=pitch, speed=NATURAL_WORDS_MIN))
            decisions = decide(padded(for_words(sound).samples[:, 0], number))
            result = judged((one.command for one in decisions), as_it_sounds(words, may))
            found[result] += 1
            unsaid += result == WRONG and not said_back(decisions)
            if result == WRONG or (result != STOPPED and may == {STOP_MOVING.name}):
                print_row(f"  {result} {voice}, pitch {pitch} “{words}” → {told(decisions)}")
        row(name, found)
        print_row(f"  wrong without being said back: {unsaid}")


def said_back(decisions: Iterable[Decision]) -> bool:
    """Return whether all that moves the robot is said back, and waits, before it does."""
    return all(one.waits for one in decisions if one.command is not None and not one.stops)


def told(decisions: list[Decision]) -> str:
    """What was understood, and how it was taken."""
    return ", ".join(f"{one.echo} ({one.verdict} {one.confidence:.2f})" for one in decisions) or "nothing"


def of_speakers(folder: Path, decide: Decide) -> None:
    """Recordings of a folder, those of one speaker together, and how often their numbers are right."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    unsaid = 0
    heard: list[HeardNumber] = []
    before = ""
    for number, (speaker, clip) in enumerate(clips_of(folder)):
        if before not in (speaker, ""):
            row(f"{folder.name}, {before}", counts[before])
        before = speaker
        decisions = decide(padded(clip.samples, number))
        result = outcome_of_all(clip.text, decisions)
        counts[speaker][result] += 1
        unsaid += result == WRONG and not said_back(decisions)
        if result == WRONG:
            print_row(f"  {result} {speaker} “{clip.text}” → {told(decisions)}")
        meant = Sentence(clip.text).meaning
        for one in decisions:
            if meant[1] and Sentence(one.words).meaning[1]:
                heard.append(HeardNumber(speaker, log_odds(one.confidence), Sentence(one.words).meaning == meant))
    row(f"{folder.name}, {before}", counts[before])
    row(f"{folder.name}, all", sum(counts.values(), Counter()))
    print_row(f"  wrong without being said back: {unsaid}; by the confidence: {json.dumps(as_given(heard))}")
    if len(counts) > 1:
        print_row(f"  by a fit to all other speakers: {json.dumps(reliability(heard))}")


def as_given(heard: list[HeardNumber]) -> dict[str, tuple[int, float]]:
    """How many numbers have a confidence, and the share of them that is right."""
    given = np.array([1 / (1 + np.exp(-one.log_odds)) for one in heard])
    right = np.array([one.right for one in heard], dtype=float)
    table: dict[str, tuple[int, float]] = {}
    for low, high in itertools.pairwise((0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.01)):
        within: Array = (given >= low) & (given < high)
        if within.any():
            table[f"{low:g} to {min(high, 1):g}"] = (int(within.sum()), round(float(right[within].mean()), 3))
    return table


def main(*, data: Path, engine: str = "whisper", spoken: int = 1, speakers: Sequence[Path] = ()) -> None:

    print_row(f"{'':42}{'of':>6}" + "".join(f"{one:>9}" for one in (RIGHT, REFUSED, STOPPED, WRONG)))
    if not speakers:
        typed(data)
    if not (speakers or spoken):
        return
    settings = SpeechSettings(engine=engine)
    recognizer = open_engine(settings).recognizer
    decide = as_cut(recognizer, settings)
    for folder in speakers:
        of_speakers(folder, decide)
    if not speakers:
        of_synthesis(data, decide, spoken)
        print_row(f"  talk, {json.dumps(talk(recognizer, settings, data))}")


if __name__ == "__main__":
    run_command(main)
