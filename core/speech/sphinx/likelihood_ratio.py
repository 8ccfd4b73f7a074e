"""A command against all that is none, both read from the same sound: by how much it fits better, or worse."""

import math

from core.commands.stop_moving import STOP_MOVING
from core.message import message
from core.speech.settings import SpeechSettings
from core.speech.sphinx.decoded_path import DecodedPath

MIN_WORD_S = 0.1  # of a word, as which shorter ones count: a moment is little evidence
LONG_COMMAND_WORDS, LONG_FACTOR = 5, 1.25  # so many words resemble little else: they may be so much further behind
STOPPING_FACTOR = 1.5  # the same where the words stop the robot: to miss them is worse than to stop for others
STOPS = frozenset(tuple(words.split()) for words in STOP_MOVING.words)


@message
class LikelihoodRatio:
    """Margin by which a command fits better than anything else; below 0: worse."""

    lead: float  # [nats] a second of its words, over all of the sound
    within: float  # [nats] a second of its words, within them
    beside: float  # [nats] outside its words: below 0 where something else was said there, or they echo
    weakest: float  # [nats] a second, within the word that fits worst


def compare(command: DecodedPath, other: DecodedPath) -> LikelihoodRatio:
    """Two paths through the same sound → how they compare. Without words it fits infinitely worse."""
    if not command.spans:
        return LikelihoodRatio(lead=-math.inf, within=-math.inf, beside=-math.inf, weakest=-math.inf)
    if not other.pieces:
        return LikelihoodRatio(lead=math.inf, within=math.inf, beside=math.inf, weakest=math.inf)
    spoken = command.spans[-1].end - command.spans[0].begin
    better = command.fit - other.fit
    leads = [
        command.fit_within(span.begin, span.end) - other.fit_within(span.begin, span.end) for span in command.spans
    ]
    by_word = (lead / max(span.end - span.begin, MIN_WORD_S) for lead, span in zip(leads, command.spans, strict=True))
    within = sum(leads)
    return LikelihoodRatio(lead=better / spoken, within=within / spoken, beside=better - within, weakest=min(by_word))


def headroom(command: DecodedPath, other: DecodedPath, settings: SpeechSettings) -> float:
    """[nats/s] by which a command is above the least that is accepted, of all bounds the nearest; not above 0: it is
    none. It must fit about as well as any other words; a single word must fit better.
    """
    ratio = compare(command, other)
    if len(command.spans) == 1:
        return ratio.lead
    share = (
        STOPPING_FACTOR
        if command.words in STOPS
        else LONG_FACTOR
        if len(command.spans) >= LONG_COMMAND_WORDS
        else 1.0
    )
    near = ratio.lead + share * settings.most_behind
    echoes = min(ratio.within + share * settings.echoing_behind, ratio.beside + settings.echo)
    return min(max(near, echoes), ratio.weakest + share * settings.word_behind)
