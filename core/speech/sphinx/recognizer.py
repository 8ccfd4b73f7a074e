"""The default engine: pocketsphinx (hidden Markov models, as in the paper), asked more than once.

The same sound is read twice, as a command and as anything else, and both scores are compared: a command may fit a
little worse, because voices differ, but no word of it much worse. One grammar that holds both would not do: the
decoder drops what is behind for a moment, and with it half of the commands of an unusual voice.
What remains is read again from the sound with its noise and at other speeds. Another command, read there, rejects it;
other numbers are put to the vote, and so is a sentence that was rejected just before. A command of a single
word, which a breath may resemble, has to fit better than anything else every time.
"""

import math
from collections.abc import Iterable, Iterator
from math import inf
from typing import Any

import numpy as np

from core.commands import needs_confirmation
from core.commands.command import Command
from core.commands.stop_moving import STOP_MOVING
from core.message import Array, message
from core.perception.sound.noise_reduction import without_noise
from core.sensors.resampling import resampled
from core.speech.recognition.decision import TOO_LONG, Decision, Scores, Sentence, Thresholds, decide, no_command
from core.speech.recognition.endpointing import FRAME_SAMPLES, HOP_SAMPLES, levels, over_noise, voiced
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.decoded_path import DecodedPath, WordSpan, decoded
from core.speech.sphinx.decoder import garbage_words, grammar_decoder
from core.speech.sphinx.garbage_model import grammar
from core.speech.sphinx.jsgf import plain_grammar
from core.speech.sphinx.rescoring import Vote, Words, nearest_others, vote

MIN_NOISE_S = 0.15  # of noise before the speech that are left out of learning it: the speech may begin there
MAX_SPEECH_LEFT_S = 0.12  # of speech outside the words, which may be the end of a consonant
VOICE_MARGIN_S = 0.25  # before and behind the voice, that are read with it
MAX_PAUSE_S = 0.7  # within a sentence
VOTING_VIEWS = 2  # views in which sentences are weighed: a third costs time and changes little
MAX_OTHERS = 2  # other sentences that are weighed against a rejected one
SPEEDS = ((20, 19), (10, 9), (18, 19))
"""At how much slower or faster speeds it is read again: like a deeper or a higher voice."""

LEAD_SCALE = 10.0  # [nats] of a lead that make its odds e times better


class Candidates(dict[Words, Sentence]):
    """The sentences that one utterance may be, by their words; each is parsed once."""

    def __init__(self, rejected: Iterable[str]) -> None:
        """`rejected`: the words of commands that were rejected just before."""
        super().__init__()
        self._rejected = {Sentence(words).meaning for words in rejected}

    def unlikely(self, words: Words) -> bool:
        """Return whether a command of that meaning was rejected just before."""
        return self[words].meaning in self._rejected

    def __missing__(self, words: Words) -> Sentence:
        """Parse words that were not read before."""
        self[words] = sentence = Sentence(" ".join(words))
        return sentence


@message
class Ranking:
    """The sentence that fits best, and how far it is ahead."""

    best: DecodedPath
    lead: float = inf  # [nats] before the nearest other sentence; ∞: there is none, -∞: it may be another command
    others: tuple[Words, ...] = ()  # that fit nearly as well, the best first


class Sphinx:
    """Sentences of the grammar, or none."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Makes its decoders, in about a second. Raises Unavailable when pocketsphinx is not installed."""
        self._settings = chosen = settings or SpeechSettings()
        self._thresholds = Thresholds(reject=chosen.least_lead, accept=chosen.sure_lead, scale=LEAD_SCALE)
        options = options_of(chosen)
        # For comparison the scores of both grammars must count from the same best model of every frame: from that of
        # all models, where else only those are evaluated that a grammar is about to use.
        fair = options | {"compallsen": True}
        words = garbage_words(chosen.garbage_words, chosen.resembling_words)
        self._commands = grammar_decoder(plain_grammar(), **fair)
        self._others = grammar_decoder(grammar(words, chosen.competing_price), **fair)
        self._quick = grammar_decoder(plain_grammar(), **options)  # where only the words count

    def decide(self, utterance: Utterance) -> Decision:
        """A sentence of the grammar against everything else, then against the same command with other numbers."""
        views, offset = views_of(utterance, self._settings.clear_ratio)
        said = decoded(self._commands, views[0])
        if not said.words:
            return no_command()
        sentences = Candidates(utterance.rejected)
        margin = headroom(said, decoded(self._others, views[0]), self._settings)
        objection = _objection(utterance, offset, said)
        ranking = Ranking(best=said) if margin <= 0 or objection else self._ranked(said, views, sentences)
        scores = Scores(sentence=ranking.best.fit, over_free_text=margin, over_second_best=ranking.lead)
        others = [sentences[words] for words in ranking.others]
        return decide(sentences[ranking.best.words], scores, self._thresholds, objection=objection, others=others)

    def _faster_and_slower(self, samples: Array) -> Iterator[Array]:
        """The samples (N,) as deeper and higher voices would say them."""
        for up, down in SPEEDS[: self._settings.opinions]:
            yield resampled(samples, down, up)

    def _ranked(self, said: DecodedPath, views: list[Array], sentences: Candidates) -> Ranking:
        """Choose the sentence that explains all views best, at other speeds too. `said` is what was read from the
        first view.
        """
        views = [*views, *self._faster_and_slower(views[0])]
        if len(said.words) == 1:
            return Ranking(best=said, lead=inf if all(self._stands(said, view) for view in views[1:]) else -inf)
        if sentences.unlikely(said.words) and (
            others := nearest_others(self._quick, said.words, views[0], MAX_OTHERS)
        ):
            return self._elected(said, [said.words, *others], views, sentences)
        meaning = sentences[said.words].meaning
        for view in views[1:]:
            words = decoded(self._quick, view).words
            read = sentences[words].meaning
            if read[0] != meaning[0]:
                return Ranking(best=said, lead=-inf, others=(words,) if words else ())
            if read != meaning:
                return self._elected(said, [said.words, words], views, sentences)
        return self._ahead(said, views, sentences[said.words])

    def _elected(self, said: DecodedPath, found: list[Words], views: list[Array], sentences: Candidates) -> Ranking:
        """The sentence that the first views together take for what was said. Its lead ends where sentences are
        accepted: views that differ never make it sure, unless the others do not fit at all.
        """
        unlikely = [words for words in found if sentences.unlikely(words)]
        first, second, *more = vote(self._quick, found, views[:VOTING_VIEWS], unlikely)
        lead = _lead(first, second)
        return Ranking(
            best=said if first.path.words == said.words else first.path,
            lead=lead if lead == inf else min(lead, self._thresholds.accept),
            others=tuple(one.path.words for one in (second, *more) if one.path.words),
        )

    def _ahead(self, said: DecodedPath, views: list[Array], sentence: Sentence) -> Ranking:
        """A sentence that all views read alike, and by how much no other digit fits as well, but never so little that
        it is rejected; not measured for commands that are delayed anyway.
        """
        if not isinstance(sentence.typed, Command) or needs_confirmation(sentence.typed):
            return Ranking(best=said)
        others = nearest_others(self._quick, said.words, views[0])
        if not others:
            return Ranking(best=said)
        first, second = vote(self._quick, [said.words, *others], views)
        lead = _lead(first, second) if first.path.words == said.words else -inf
        return Ranking(best=said, lead=max(lead, self._thresholds.reject), others=tuple(others))

    def _stands(self, said: DecodedPath, view: Array) -> bool:
        """Return whether a single word is also read from another view of the sound, and is accepted there."""
        again = decoded(self._commands, view)
        return again.words == said.words and headroom(again, decoded(self._others, view), self._settings) > 0


def _objection(utterance: Utterance, offset: float, said: DecodedPath) -> str:
    """The reason why the words are not a command, whichever numbers they have; "" for no reason."""
    if utterance.cut:
        return TOO_LONG
    if left_over(utterance, said.spans, offset) > MAX_SPEECH_LEFT_S:
        return "More was said than a command."
    if said.longest_pause > MAX_PAUSE_S:
        return "There was a long pause within the sentence."
    return ""


def _lead(first: Vote, second: Vote) -> float:
    """[nats] of the one sentence before the other; -∞ where neither fits."""
    return first.fit - second.fit if first.fit > -inf else -inf


def options_of(settings: SpeechSettings) -> dict[str, Any]:
    """Translate the settings into options of pocketsphinx."""
    return {
        "bestpath": False,
        "wip": settings.insertion,
        "silprob": settings.silence,
        "topn": settings.gaussians,
        "maxhmmpf": settings.most_models,
        "cmn": "batch",
    }


def views_of(utterance: Utterance, clear_ratio: float) -> tuple[list[Array], float]:
    """The utterance's sound, as it is read first and as it may be read too; and when [s] they begin in it.

    In noise, voice less than `clear_ratio` [dB] over it, they are the sound without that noise and the sound as it
    is, else only that.
    """
    samples, before = utterance.samples, len(utterance.before) - round(MIN_NOISE_S * RATE_HZ)
    noisy = over_noise(samples, samples[: max(before, 0)]) < 10 ** (clear_ratio / 10)
    views = [without_noise(samples, RATE_HZ, before), samples] if noisy else [samples]
    first, last = _around_voice(views[0])
    return [view[first:last] for view in views], first / RATE_HZ


def _around_voice(samples: Array) -> tuple[int, int]:
    """Samples (N,) → from where to where the voice and a little around it reach.

    Far voices in the pauses before and behind would be heard as words.
    """
    begin, end = voiced(samples)
    if begin >= end:
        return 0, len(samples)
    return max(round((begin - VOICE_MARGIN_S) * RATE_HZ), 0), min(
        round((end + VOICE_MARGIN_S) * RATE_HZ), len(samples)
    )


BELOW_DB = 14.0  # under the loudest word, down to which sound counts as speech
ABOVE_SDS = 3.0  # standard deviations over the noise before the speech, from which it does
WORD_MARGIN_S = 0.1  # by which the bounds of a word may be wrong
NOISE_EDGE_S = 0.15  # at the end of the noise before the speech, that are not taken for noise


def left_over(utterance: Utterance, spans: tuple[WordSpan, ...], offset: float = 0.0) -> float:
    """[s] of the utterance that sound like speech and belong to no word; the words' times count from `offset` [s].

    A decoder likes to take speech that fits nowhere for silence: "follow my instructions" becomes "follow me" and a
    long pause. What is as loud as the words but lies outside of them gives that away.
    """
    if len(utterance.samples) < FRAME_SAMPLES or not spans:
        return 0.0
    level = levels(utterance.samples)
    times = (FRAME_SAMPLES / 2 + HOP_SAMPLES * np.arange(len(level))) / RATE_HZ - offset
    within, beside = np.zeros(len(level), bool), np.zeros(len(level), bool)
    for span in spans:
        within |= (times >= span.begin) & (times <= span.end)
        beside |= (times >= span.begin - WORD_MARGIN_S) & (times <= span.end + WORD_MARGIN_S)
    if not within.any() or beside.all():
        return 0.0
    least = max(float(np.quantile(level[within], 0.9)) - BELOW_DB, _noise_reaches(level, times + offset, utterance))
    return float(np.count_nonzero(level[~beside] > least)) * HOP_SAMPLES / RATE_HZ


def _noise_reaches(level: Array, times: Array, utterance: Utterance) -> float:
    """[dB] that the noise before the speech seldom exceeds."""
    before = level[times < utterance.begin - utterance.sound.stamp - NOISE_EDGE_S]
    return float(before.mean() + ABOVE_SDS * before.std()) if len(before) else -np.inf


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


class SphinxDictation:
    """All speech as sentences of the grammar, accepted as commands or not: the texts of OSQE (Figs. 10, 11).

    A recognizer that moves a robot refuses what it is not sure of; that would measure its caution.
    """

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Raises Unavailable when pocketsphinx is not installed."""
        self._settings = settings or SpeechSettings()
        self._decoder = grammar_decoder(plain_grammar(), **options_of(self._settings))

    def transcribe(self, utterance: Utterance) -> str:
        """The words that fit best; "" only where nothing was said."""
        views, _ = views_of(utterance, self._settings.clear_ratio)
        return " ".join(decoded(self._decoder, views[0]).words)
