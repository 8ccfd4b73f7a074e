"""The default engine: pocketsphinx (hidden Markov models, as in the paper), asked more than once.

The same sound is read twice, as a command and as anything else, and both scores are compared: a command may fit a
little worse, because voices differ, but no word of it much worse. One grammar that holds both would not do: the
decoder drops what is behind for a moment, and with it half of the commands of an unusual voice.
What remains is read again from the sound with its noise and at other speeds. Another command, read there, rejects it;
other numbers are put to the vote, and so is a sentence that was rejected just before. A command of a single
word, which a breath may resemble, has to fit better than anything else every time.
"""

from collections.abc import Iterable, Iterator
from math import inf
from typing import Any

from core.commands import needs_confirmation
from core.commands.command import Command
from core.message import Array, message
from core.perception.sound.noise_reduction import without_noise
from core.sensors.resampling import resampled
from core.speech.recognition.decision import TOO_LONG, Decision, Scores, Sentence, Thresholds, decide, no_command
from core.speech.recognition.endpointing import over_noise, voiced
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.decoded_path import DecodedPath, decoded
from core.speech.sphinx.decoder import garbage_words, grammar_decoder
from core.speech.sphinx.garbage_model import grammar
from core.speech.sphinx.jsgf import plain_grammar
from core.speech.sphinx.leftover_speech import left_over
from core.speech.sphinx.likelihood_ratio import headroom
from core.speech.sphinx.rescoring import Vote, Words, nearest_others, vote

LEAST_BEFORE = 0.15  # [s] of noise before the speech that are left out of learning it: the speech may begin there
MOST_LEFT = 0.12  # [s] of speech outside the words, which may be the end of a consonant
VOICE_MARGIN_S = 0.25  # before and behind the voice, that are read with it
LONGEST_PAUSE = 0.7  # [s] within a sentence
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
    if left_over(utterance, said.spans, offset) > MOST_LEFT:
        return "More was said than a command."
    if said.longest_pause > LONGEST_PAUSE:
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
    samples, before = utterance.samples, len(utterance.before) - round(LEAST_BEFORE * RATE_HZ)
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
