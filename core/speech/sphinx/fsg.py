"""A grammar as an automaton with few states, for pocketsphinx: it looks at all of them for every frame.

Its own reading of JSGF expands every mention of a rule: 3141 states for the commands, 1860 for what competes
with them. The same sentences, as likely, need 163 and 4: states are one where the same words lead to them, or from
them (Mohri, "Finite-state transducers in language and speech processing", 1997). That halves the time of a reading.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Mapping
from functools import lru_cache

from core.message import message

TOKEN = re.compile(r"<\w+>|/[\d.e+-]+/|[\w']+|[|()\[\]+]")
RULE = re.compile(r"^(?:public )?<(\w+)> = (.*);$", re.MULTILINE)
HALF = math.log(0.5)  # of what may be repeated: to go on, or not
NATS_DECIMALS = 9  # decimals to which log-probabilities [nats] are compared
START_STATE, FINAL_STATE = 0, 1


@message
class FsgArc:
    """One word, or none, from one state to another."""

    source: int
    target: int
    nats: float  # log-probability
    word: str  # "": none


@message
class Automaton:
    """Chains of words with probabilities, from the state `start` to the state `final`."""

    start: int
    final: int
    arcs: tuple[FsgArc, ...]

    @property
    def states(self) -> int:
        """The number of states."""
        return len({state for arc in self.arcs for state in (arc.source, arc.target)})


@message
class FsgItem:
    """A part of a sequence: a word, a <rule>, or alternatives; once, or once and more."""

    what: str | Choice
    repeated: bool


Choice = list[tuple[float, list[FsgItem]]]  # weights and the sequences that they weigh


@lru_cache(maxsize=4)
def automaton(jsgf: str) -> Automaton:
    """A grammar in JSGF: words, rules, weights, groups, options and repetitions; no rule within itself.

    Alternatives are as likely as their weights say, 1 where none stands; what is optional is left out with weight 1.
    """
    written = _Written(dict(RULE.findall(jsgf)))
    written.put_rule("heard", START_STATE, FINAL_STATE, 0.0)
    return _numbered(_reduced(_without_detours(written.arcs)))


class _Written:
    """The arcs of a grammar as it is written."""

    def __init__(self, rules: Mapping[str, str]) -> None:
        self.arcs: list[FsgArc] = []
        self._rules = rules
        self._states = FINAL_STATE + 1

    def put_rule(self, name: str, begin: int, end: int, nats: float) -> None:
        """Add what a rule stands for between two states; all of it as likely as `nats` says."""
        tokens = TOKEN.findall(self._rules[name])
        self._put(choice_of(tokens), begin, end, nats)
        assert not tokens, f"the rule <{name}> has a bracket too many"

    def _new(self) -> int:
        self._states += 1
        return self._states - 1

    def _put(self, choice: Choice, begin: int, end: int, nats: float) -> None:
        whole = sum(weight for weight, _ in choice)
        for weight, items in choice:
            share = nats + math.log(weight / whole)
            if not items:
                self._arc(begin, end, share)
                continue
            states = [begin, *(self._new() for _ in items[1:]), end]
            for item, source, target in zip(items, states, states[1:], strict=False):
                self._put_item(item, source, target, share)
                share = 0.0

    def _put_item(self, item: FsgItem, begin: int, end: int, nats: float) -> None:
        if item.repeated:
            first, last = self._new(), self._new()
            self._arc(begin, first, nats)
            self._arc(last, first, HALF)
            self._arc(last, end, HALF)
            begin, end, nats = first, last, 0.0
        if not isinstance(item.what, str):
            self._put(item.what, begin, end, nats)
        elif item.what.startswith("<"):
            self.put_rule(item.what[1:-1], begin, end, nats)
        else:
            self._arc(begin, end, nats, item.what)

    def _arc(self, source: int, target: int, nats: float, word: str = "") -> None:
        self.arcs.append(FsgArc(source=source, target=target, nats=nats, word=word))


def choice_of(tokens: list[str], *, optional: bool = False) -> Choice:
    """Alternatives up to the bracket that closes them, or to the end; their tokens are taken out."""
    choice: Choice = [(1.0, [])] if optional else []
    while True:
        weight = float(tokens.pop(0)[1:-1]) if tokens[0].startswith("/") else 1.0
        choice.append((weight, _sequence(tokens)))
        if not tokens or tokens.pop(0) != "|":
            return choice


def _sequence(tokens: list[str]) -> list[FsgItem]:
    items: list[FsgItem] = []
    while tokens and tokens[0] not in "|)]":
        token = tokens.pop(0)
        what = choice_of(tokens, optional=token == "[") if token in "([" else token
        repeated = tokens[:1] == ["+"]
        del tokens[:repeated]
        items.append(FsgItem(what=what, repeated=repeated))
    return items


def _without_detours(arcs: list[FsgArc]) -> list[FsgArc]:
    """The same chains, where no arc without a word follows another: sphinx takes one of them at a time."""
    spoken = [arc for arc in arcs if arc.word]
    silent: dict[int, list[FsgArc]] = defaultdict(list)
    for arc in arcs:
        if not arc.word:
            silent[arc.source].append(arc)
    departures = {arc.source for arc in spoken} | {FINAL_STATE}
    kept: list[FsgArc] = []
    for state in {START_STATE} | {arc.target for arc in spoken}:
        ways = _reached(state, silent)
        kept += [
            FsgArc(source=state, target=target, nats=nats, word="")
            for target, nats in ways.items()
            if target in departures and target != state
        ]
    return kept + spoken


def _reached(state: int, silent: Mapping[int, list[FsgArc]]) -> dict[int, float]:
    """All states that are reached from one without a word, itself too → the best log-probability [nats]."""
    best, waiting = {state: 0.0}, [state]
    while waiting:
        here = waiting.pop()
        for arc in silent.get(here, ()):
            nats = best[here] + arc.nats
            if nats > best.get(arc.target, -math.inf):
                best[arc.target] = nats
                waiting.append(arc.target)
    return best


def _reduced(arcs: list[FsgArc]) -> list[FsgArc]:
    """States that the same arcs leave, or that the same arcs enter, are one."""
    while True:
        fewer = _merged(_merged(arcs, leaving=True), leaving=False)
        if len(fewer) == len(arcs):
            return arcs
        arcs = fewer


def _merged(arcs: list[FsgArc], *, leaving: bool) -> list[FsgArc]:
    """States whose arcs on one side are the same, put together; START and FINAL stay what they are.

    Where the same arcs leave, the same words must have led there: of several words before a state, pocketsphinx takes
    the end of one only for what the next word's beginning is coloured by.
    """
    before = _words_before(arcs) if leaving else {}
    sides: dict[int, set[tuple[int, float, str]]] = defaultdict(set)
    for arc in arcs:
        own, other = (arc.source, arc.target) if leaving else (arc.target, arc.source)
        sides[own].add((other, round(arc.nats, NATS_DECIMALS), arc.word))
    alike: dict[tuple[frozenset[str], frozenset[tuple[int, float, str]]], int] = {}
    same = {
        state: alike.setdefault((before.get(state, frozenset()), frozenset(side)), state)
        for state, side in sides.items()
        if state > FINAL_STATE
    }
    merged = {}
    for arc in arcs:
        source, target = same.get(arc.source, arc.source), same.get(arc.target, arc.target)
        one = FsgArc(source=source, target=target, nats=arc.nats, word=arc.word)
        merged[source, target, round(arc.nats, NATS_DECIMALS), arc.word] = one
    return list(merged.values())


def _words_before(arcs: list[FsgArc]) -> dict[int, frozenset[str]]:
    """State → the words that may have been said last before it."""
    last: dict[int, set[str]] = defaultdict(set)
    for arc in arcs:
        if arc.word:
            last[arc.target].add(arc.word)
    through = {(arc.source, arc.target) for arc in arcs if not arc.word}
    found = {state: set(words) for state, words in last.items()}
    for source, target in through:
        found.setdefault(target, set()).update(last[source])
    return {state: frozenset(words) for state, words in found.items()}


def _numbered(arcs: list[FsgArc]) -> Automaton:
    """States counted from 0 without a gap."""
    names: dict[int, int] = {}
    numbered = tuple(
        FsgArc(
            source=names.setdefault(arc.source, len(names)),
            target=names.setdefault(arc.target, len(names)),
            nats=arc.nats,
            word=arc.word,
        )
        for arc in arcs
    )
    return Automaton(start=names[START_STATE], final=names[FINAL_STATE], arcs=numbered)
