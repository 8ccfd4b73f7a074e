"""Count wrong words to judge how well speech survives the robot (section 5.1, eq. 41-42).

One original text was spoken. The person's path turned it into one text, the robot's hearing into another:
OSQE_D = NErW_person - NErW_robot, OSQE_R = NErW_person / NErW_robot. Where the robot made no error the ratio has no
value; the bounded one, (1 + NErW_person) / (1 + NErW_robot), always has.
"""

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from core.errors import BadInput
from core.message import message
from core.speech.quality.word_alignment import Pair, align, phrases_of

FEWEST_WORDS = 50  # of the original, below which nothing is concluded


# The interval around the figures.
BOOTSTRAP_DRAWS = 2000  # of the bootstrap over phrases
INTERVAL_COVERAGE = 0.95
BOOTSTRAP_SEED = 0


class OsqeFigures(TypedDict):
    """The two figures of the paper, and the one that is always defined, as JSON."""

    erroneous_words_person: int  # NErW_person
    erroneous_words_robot: int  # NErW_robot
    osqe_d: int  # OSQE_D (eq. 41)
    osqe_r: float | None  # OSQE_R (eq. 42); None: no value
    reason: str  # why there is no ratio; "" when there is one
    osqe_r_bounded: float  # (1 + NErW_person) / (1 + NErW_robot)


def score(person: int, robot: int) -> OsqeFigures:
    """Numbers of erroneous words → OSQE_D and OSQE_R. Raises BadInput for negative numbers."""
    if person < 0 or robot < 0:
        raise BadInput("A number of erroneous words cannot be negative.")
    reason = ""
    if robot == 0:
        reason = (
            "Neither path made an error; a ratio of nothing to nothing has no value."
            if person == 0
            else "The robot made no error; the ratio has no value."
        )
    return {
        "erroneous_words_person": person,
        "erroneous_words_robot": robot,
        "osqe_d": person - robot,
        "osqe_r": person / robot if robot else None,
        "reason": reason,
        "osqe_r_bounded": (1 + person) / (1 + robot),
    }


@message
class SpeechPath:
    """The words that one path made of the original."""

    pairs: tuple[Pair, ...]
    words: int  # of the original
    phrases: int  # of the original

    def count(self, kind: str) -> int:
        """Return the number of pairs of that kind."""
        return sum(pair.kind == kind for pair in self.pairs)

    @property
    def errors(self) -> int:
        """NErW = substituted + deleted + inserted."""
        return sum(pair.kind != "same" for pair in self.pairs)

    @property
    def errors_of_phrases(self) -> list[int]:
        """NErW of every phrase of the original."""
        counts = [0] * self.phrases
        for pair in self.pairs:
            counts[pair.phrase] += pair.kind != "same"
        return counts

    @property
    def exact(self) -> list[bool]:
        """Which phrases arrived word for word."""
        return [count == 0 for count in self.errors_of_phrases]


@message
class SpeechQuality:
    """One original and what both paths made of it."""

    person: SpeechPath
    robot: SpeechPath
    phrases: tuple[str, ...]  # of the original, as compared
    score: OsqeFigures
    difference_interval: tuple[float, float]  # of OSQE_D, over resampled phrases
    bounded_interval: tuple[float, float]  # of the bounded ratio

    @property
    def verdict(self) -> str:
        """The conclusion, in one sentence."""
        if self.person.words < FEWEST_WORDS:
            return f"{self.person.words} words are too few to judge by; let at least {FEWEST_WORDS} be spoken."
        low, high = self.difference_interval
        if low > 0:
            return "The robot hears better than the person's own path."
        if high < 0:
            return "The robot hears worse than the person's own path."
        return "No difference between the robot and the person's own path could be measured."


def compare(original: str, person: str, robot: str) -> SpeechQuality:
    """Three texts → the two paths, their figures and intervals. Raises BadInput when the original says nothing."""
    phrases = phrases_of(original)
    if not phrases:
        raise BadInput("The original text has no words; give the text that was spoken.")
    ours, theirs = _path(phrases, person), _path(phrases, robot)
    of_difference, of_ratio = _intervals(ours, theirs)
    return SpeechQuality(
        person=ours,
        robot=theirs,
        phrases=tuple(" ".join(phrase) for phrase in phrases),
        score=score(ours.errors, theirs.errors),
        difference_interval=of_difference,
        bounded_interval=of_ratio,
    )


def _path(phrases: Sequence[Sequence[str]], text: str) -> SpeechPath:
    heard = [word for phrase in phrases_of(text) for word in phrase]
    return SpeechPath(pairs=align(phrases, heard), words=sum(map(len, phrases)), phrases=len(phrases))


def _intervals(person: SpeechPath, robot: SpeechPath) -> tuple[tuple[float, float], tuple[float, float]]:
    """Percentiles of OSQE_D and of the bounded ratio over resampled phrases (Efron's bootstrap)."""
    rng = np.random.default_rng(BOOTSTRAP_SEED)
    errors = np.array([person.errors_of_phrases, robot.errors_of_phrases], float)
    weights = rng.multinomial(person.phrases, np.full(person.phrases, 1 / person.phrases), BOOTSTRAP_DRAWS)
    of_person, of_robot = errors @ weights.T
    tails = 50 * (1 - INTERVAL_COVERAGE)
    low, high = np.percentile(of_person - of_robot, (tails, 100 - tails)).tolist()
    least, most = np.percentile((1 + of_person) / (1 + of_robot), (tails, 100 - tails)).tolist()
    return (low, high), (least, most)


class PathFigures(TypedDict):
    """The errors of one path, as JSON."""

    substitutions: int
    deletions: int
    insertions: int
    word_error_rate: float
    commands_exact: int


class PhraseFigures(TypedDict):
    """A phrase of the original and whether it arrived word for word, as JSON."""

    text: str
    person_exact: bool
    robot_exact: bool


class WordDifference(TypedDict):
    """A word that one path changed, as JSON."""

    path: str  # "person" | "robot"
    word: int  # from 0, along the path
    phrase: int  # of the original, from 0
    kind: str
    original: str | None
    heard: str | None


class QualityFigures(OsqeFigures):
    """All figures of a comparison, as JSON."""

    words: int
    phrases: int
    osqe_d_interval_95: list[float]
    osqe_r_bounded_interval_95: list[float]
    verdict: str
    person: PathFigures
    robot: PathFigures
    commands: list[PhraseFigures]
    differences: list[WordDifference]


def as_json(quality: SpeechQuality) -> QualityFigures:
    """All figures with the names of the file forms."""
    return {
        "words": quality.person.words,
        "phrases": len(quality.phrases),
        **quality.score,
        "osqe_d_interval_95": list(quality.difference_interval),
        "osqe_r_bounded_interval_95": list(quality.bounded_interval),
        "verdict": quality.verdict,
        "person": _path_json(quality.person),
        "robot": _path_json(quality.robot),
        "commands": [
            {"text": text, "person_exact": by_person, "robot_exact": by_robot}
            for text, by_person, by_robot in zip(
                quality.phrases, quality.person.exact, quality.robot.exact, strict=True
            )
        ],
        "differences": [
            {
                "path": name,
                "word": number,
                "phrase": pair.phrase,
                "kind": pair.kind,
                "original": pair.original or None,
                "heard": pair.heard or None,
            }
            for name, path in (("person", quality.person), ("robot", quality.robot))
            for number, pair in enumerate(path.pairs)
            if pair.kind != "same"
        ],
    }


def _path_json(path: SpeechPath) -> PathFigures:
    return {
        "substitutions": path.count("substituted"),
        "deletions": path.count("deleted"),
        "insertions": path.count("inserted"),
        "word_error_rate": path.errors / path.words,
        "commands_exact": sum(path.exact),
    }
