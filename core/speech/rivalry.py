"""A command against all that is none, both read from the same sound: by how much it fits better, or worse."""

from __future__ import annotations

import math

from core.commands.stand import STOP_MOVING
from core.message import message
from core.speech.path import Path
from core.speech.settings import SpeechSettings

SHORTEST = 0.1  # [s] of a word, as which shorter ones count: a moment tells little
LONG, FURTHER = 5, 1.25  # so many words are resembled by little else: they may be so many times further behind
STOPPING = 1.5  # the same where the words stop the robot: to miss them is worse than to stop for others
STOPS = frozenset(tuple(words.split()) for words in STOP_MOVING.words)


@message
class Rivalry:
    """By how much a command fits better than anything else; below 0: worse."""

    lead: float  # [nats] a second of its words, over all of the sound
    within: float  # [nats] a second of its words, within them
    beside: float  # [nats] beside its words: below 0 where something else was said there, or they echo
    weakest: float  # [nats] a second, within the word that fits worst


def compare(command: Path, other: Path) -> Rivalry:
    """Two paths through the same sound → how they compare. Without words it fits infinitely worse."""
    if not command.spans:
        return Rivalry(lead=-math.inf, within=-math.inf, beside=-math.inf, weakest=-math.inf)
    if not other.pieces:
        return Rivalry(lead=math.inf, within=math.inf, beside=math.inf, weakest=math.inf)
    spoken = command.spans[-1].end - command.spans[0].begin
    better = command.fit - other.fit
    leads = [
        command.fit_within(span.begin, span.end) - other.fit_within(span.begin, span.end) for span in command.spans
    ]
    by_word = (lead / max(span.end - span.begin, SHORTEST) for lead, span in zip(leads, command.spans, strict=True))
    within = sum(leads)
    return Rivalry(lead=better / spoken, within=within / spoken, beside=better - within, weakest=min(by_word))


def holds(command: Path, other: Path, settings: SpeechSettings) -> bool:
    """Whether a command fits about as well as anything that is none; one of a single word: better."""
    rivalry = compare(command, other)
    if len(command.spans) == 1:
        return rivalry.lead > 0
    share = STOPPING if command.words in STOPS else FURTHER if len(command.spans) >= LONG else 1.0
    near = rivalry.lead > -share * settings.most_behind
    echoes = rivalry.within > -share * settings.echoing_behind and rivalry.beside > -settings.echo
    return (near or echoes) and rivalry.weakest > -share * settings.word_behind
