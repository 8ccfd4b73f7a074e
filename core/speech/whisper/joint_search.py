"""The joint beam: spellings of commands and free text, extended together, one token of every row at a time.

Commands that fall behind free text are dropped, which makes talk cheap. Rows with equal tokens are computed once.
In little sound Whisper likes to write a sentence again and again: such rows are dropped when that begins.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from core.message import Array, message
from core.speech.whisper.spellings import Spellings, State
from core.speech.whisper.tokenizer import Tokenizer
from core.speech.whisper.transformer import Decoder, Decoding

START_TOKEN, NO_TIMESTAMPS_TOKEN, END_TOKEN = 50257, 50362, 50256  # special tokens of English-only models
BLANK_TOKEN = 220  # a lone space, which nothing begins with
COMMON_TOKENS = 10_000  # in the order of frequency: only these and those of spellings are scored, but for names
GRAMMAR_ROWS, FREE_ROWS, MAX_BRANCHES = 10, 3, 4
BEHIND_FREE, BEHIND_DONE = 12.0, 9.0  # [nats] behind free text and behind a whole spelling, at which a row is dropped
FIRST_TOKENS, TOKENS_A_SECOND = 8, 6  # tokens that a sentence may have, at most
REPEATED_WORDS = 2  # words of a whole text that follow it again, from which a row says nothing new


@message
class ScoredText:
    """A whole text and its logarithmic probability [nats], given the sound."""

    text: str
    nats: float
    columns: tuple[int, ...] = ()  # of its tokens


@message
class Found:
    """The whole texts of one sound."""

    spellings: tuple[ScoredText, ...]  # of commands, the best first
    free: tuple[ScoredText, ...]  # of anything, the best first

    @property
    def free_text(self) -> str:
        """The likeliest text of all; "" where nothing was said."""
        return self.free[0].text if self.free else ""


@dataclass(frozen=True)
class _Row:
    columns: tuple[int, ...]
    nats: float
    parent: int  # the row of the step before that it continues
    state: State | None = None  # in the spellings; None: free text


class Columns:
    """The tokens that are written, and the columns of their scores."""

    def __init__(self, spellings: Spellings, tokenizer: Tokenizer, *, names: bool = False) -> None:
        """`names`: known names compete with all others, so all tokens follow behind the common ones."""
        common = {*range(COMMON_TOKENS), *spellings.tokens, START_TOKEN, NO_TIMESTAMPS_TOKEN, END_TOKEN}
        self.common = len(common)  # columns that everything but names is written with
        rare = sorted(set(range(END_TOKEN)) - common) if names else ()
        self.tokens: Array = np.array([*sorted(common), *rare])  # (V,)
        self._of = {int(token): column for column, token in enumerate(self.tokens)}
        self.start, self.no_timestamps, self.end = (
            self._of[START_TOKEN],
            self._of[NO_TIMESTAMPS_TOKEN],
            self._of[END_TOKEN],
        )
        self.begin = (self.start, self.no_timestamps)
        self.never = list(self.begin)
        self.blank = self._of[BLANK_TOKEN]
        self._spellings, self._raw = spellings, tokenizer.raw(map(int, self.tokens))
        self._known: dict[State, Array] = {}

    def columns(self, tokens: Iterable[int]) -> tuple[int, ...]:
        """Return the columns of tokens. Raises KeyError for one that is never written."""
        return tuple(self._of[token] for token in tokens)

    def text(self, columns: Iterable[int]) -> str:
        """Return what columns spell one after the other."""
        return b"".join(self._raw[column] for column in columns).decode(errors="replace").strip()

    def of(self, state: State) -> Array:
        """Return the columns of the arcs of a state of the spellings."""
        if state not in self._known:
            arcs = self._spellings.arcs(state)
            self._known[state] = np.array([self._of[int(token)] for token in arcs.tokens], dtype=np.intp)
        return self._known[state]


class JointSearch:
    """Searches over one decoder and one set of spellings."""

    def __init__(self, decoder: Decoder, spellings: Spellings, columns: Columns) -> None:
        self._decoder, self._spellings, self._columns = decoder, spellings, columns

    def search(self, heard: Array, seconds: float, begun: tuple[int, ...] = ()) -> Found:
        """Search the texts of what the encoder heard (T, width) of so many seconds of sound.

        `begun`: columns with which a spelling begins, and then all texts do; only what follows has a probability.
        """
        columns = self._columns
        beam = _Beam(self._spellings, columns, begun)
        decoding = self._decoder.begin(heard, None if begun else columns.common)
        scores = decoding.prefill((*columns.begin, *begun))
        scores[:, columns.blank] = -np.inf
        for _ in range(FIRST_TOKENS + math.ceil(TOKENS_A_SECOND * seconds)):
            scores[:, columns.never] = -np.inf
            parents, tokens = beam.extend(_logarithms(scores))
            if not parents or decoding.full:
                break
            scores = decoding.advance(parents, tokens)
        return beam.found()

    def rest(self) -> None:
        """Forget the decoder's numbers until they are needed."""
        self._decoder.rest()

    def begin_of(self, text: ScoredText, words: Iterable[str]) -> tuple[int, ...]:
        """Return the columns of that one of some words, in small letters, with which a text begins; (): with none."""
        begins = (text.columns[:count] for count in range(1, len(text.columns)))
        return next((begin for begin in begins if self._columns.text(begin).lower() in words), ())

    def text(self, columns: tuple[int, ...]) -> str:
        """Return what columns spell."""
        return self._columns.text(columns)

    def by_chance(self, texts: Iterable[ScoredText]) -> Array:
        """Return how likely [nats] texts that were found are written without any sound, (N,)."""
        columns = self._columns
        return by_chance(self._decoder, columns.begin, columns.end, [text.columns for text in texts])

    def written(self, heard: Array, begun: tuple[int, ...], texts: Sequence[tuple[int, ...]]) -> Array:
        """Return how likely [nats] texts of these columns follow in what the encoder heard (T, width), (N,)."""
        columns = self._columns
        decoding = self._decoder.begin(heard, None if begun else columns.common)
        return written(decoding, (*columns.begin, *begun), columns.end, texts)

    def attention(self, heard: Array, text: ScoredText) -> Array:
        """Attention (W, T) to what the encoder heard (T, width), while a text is written that was found in it.

        W: the text's tokens with letters or digits.
        """
        columns = self._columns
        attention = self._decoder.begin(heard).alignment((*columns.begin, *text.columns))
        before = len(columns.begin) - 1  # the token before writes the next
        words = [n + before for n, one in enumerate(text.columns) if any(map(str.isalnum, columns.text((one,))))]
        return attention[words]


def _logarithms(scores: Array) -> Array:
    """Scores (rows, V) → logarithmic probabilities (rows, V)."""
    from_best = scores - scores.max(1, keepdims=True)
    return from_best - np.log(np.exp(from_best).sum(1, keepdims=True))


class _Beam:
    """The rows of one search, and the texts that ended."""

    def __init__(self, spellings: Spellings, columns: Columns, begun: tuple[int, ...]) -> None:
        self._spellings, self._columns = spellings, columns
        state = spellings.begin
        for column in begun:
            state = spellings.arcs(state).targets[int(np.flatnonzero(columns.of(state) == column)[0])]
        self._grammar = [_Row(begun, 0.0, 0, state)]
        self._free = [_Row(begun, 0.0, 0)]
        self._rows: dict[tuple[int, ...], int] = {begun: 0}  # of the decoder
        self._spelled: list[ScoredText] = []
        self._said: list[ScoredText] = []
        self._words_said: set[tuple[str, ...]] = set()  # of those texts

    def extend(self, likely: Array) -> tuple[list[int], list[int]]:
        """Log probabilities (rows, V) of what follows → the rows that go on, as their parents and new columns."""
        free = self._extended_free(likely)
        done = max((text.nats for text in self._said), default=-math.inf)
        self._free = [row for row in free if row.nats > done and not self._repeats(row)][:FREE_ROWS]
        grammar = self._extended_grammar(likely)
        spelled = max((text.nats for text in self._spelled), default=-math.inf)
        least = max(max((row.nats for row in self._free), default=done) - BEHIND_FREE, spelled - BEHIND_DONE)
        self._grammar = [row for row in grammar if row.nats > least][:GRAMMAR_ROWS]
        going = {row.columns: row for row in (*self._grammar, *self._free)}
        self._rows = {tokens: place for place, tokens in enumerate(going)}
        return [row.parent for row in going.values()], [row.columns[-1] for row in going.values()]

    def found(self) -> Found:
        """Return the texts that ended; of free text at least what there is of it."""
        said = self._said or [self._whole(row, row.nats) for row in self._free]
        return Found(spellings=_ranked(self._spelled), free=_ranked(said))

    def _whole(self, row: _Row, nats: float) -> ScoredText:
        return ScoredText(text=self._columns.text(row.columns), nats=nats, columns=row.columns)

    def _extended_free(self, likely: Array) -> list[_Row]:
        rows: list[_Row] = []
        for row in self._free:
            place = self._rows[row.columns]
            for column in np.argpartition(likely[place], -MAX_BRANCHES)[-MAX_BRANCHES:]:
                nats = row.nats + float(likely[place, column])
                if column == self._columns.end:
                    self._said.append(self._whole(row, nats))
                    self._words_said.add(_words(self._said[-1].text))
                else:
                    rows.append(_Row((*row.columns, int(column)), nats, place))
        return sorted(rows, key=_nats)

    def _repeats(self, row: _Row) -> bool:
        """Return whether the row is a whole text, and the beginning of the same once more."""
        words = _words(self._columns.text(row.columns))
        again = (words[len(text) :] for text in self._words_said if text and words[: len(text)] == text)
        return any(
            rest == words[: len(rest)] and len(rest) >= min(REPEATED_WORDS, len(words) - len(rest)) for rest in again
        )

    def _extended_grammar(self, likely: Array) -> list[_Row]:
        rows: list[_Row] = []
        for row in self._grammar:
            assert row.state is not None
            place, arcs = self._rows[row.columns], self._spellings.arcs(row.state)
            if arcs.final:
                nats = row.nats + float(likely[place, self._columns.end])
                self._spelled.append(self._whole(row, nats))
            following = self._columns.of(row.state)
            scores = row.nats + likely[place, following]
            for arc in np.argsort(scores)[::-1][:GRAMMAR_ROWS]:
                columns = (*row.columns, int(following[arc]))
                rows.append(_Row(columns, float(scores[arc]), place, arcs.targets[arc]))
        return sorted(rows, key=_nats)


def _nats(row: _Row) -> float:
    """Sort the best first."""
    return -row.nats


def _words(text: str) -> tuple[str, ...]:
    """Its words, however they are written."""
    return tuple(word for written in text.lower().split() if (word := written.strip('.,!?"-')))


def _ranked(texts: list[ScoredText]) -> tuple[ScoredText, ...]:
    return tuple(sorted(texts, key=lambda text: -text.nats))


def by_chance(
    decoder: Decoder, begin: tuple[int, int], end: int, texts: Sequence[Sequence[int]], first: int | None = None
) -> Array:
    """Return the logarithmic probability [nats] of each text without a sound, (N,): what people often say is also
    heard where something else was said (the decoder's internal language model, Meng et al., 2021).

    `texts`: columns of the decoder, each at least one; `begin` and `end`: those around every text; `first`: how many
    columns are written at all, None: all.
    """
    return written(decoder.begin(np.zeros((1, decoder.width), np.float32), first), begin, end, texts)


def written(decoding: Decoding, begin: tuple[int, ...], end: int, texts: Sequence[Sequence[int]]) -> Array:
    """The same behind `begin` for what a decoding has heard, (N,)."""
    scores = decoding.prefill(begin)
    rows = list(range(len(texts)))
    nats = np.zeros(len(texts))
    for place in range(max(map(len, texts)) + 1):
        likely = scores - np.logaddexp.reduce(scores, axis=1, keepdims=True)
        following = [[*text, end][min(place, len(text))] for text in texts]
        going = np.array([place <= len(text) for text in texts])
        nats += np.where(going, likely[rows if place else 0, following], 0.0)
        scores = decoding.advance(rows if place else [0] * len(rows), following)
    return nats
