"""The recognizer of human voices: Whisper, scored against the grammar.

Three numbers decide about the meaning that fits best: its score, which adds up the probabilities of all its
spellings; how far the best free text is ahead of it; and how far it is ahead of the second meaning. The bounds are
narrow for words that people say often, like "come", because those are heard wherever something resembles them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from pathlib import Path

import numpy as np

from core.commands import SPECS, VOCABULARY, has_said_numbers, spec_of
from core.commands.command import CommandSpec
from core.commands.routes import PAUSE_ROUTE, START_ROUTE
from core.commands.stop_at import SAID_OF_PLACES, TO_PLACE, command_to
from core.commands.stop_moving import START, STOP_MOVING
from core.message import Array, message
from core.navigation.places import NamedPlace
from core.sensors.resampling import resampled
from core.sentences import Statement
from core.speech.recognition.decision import (
    MORE_DIGITS,
    MORE_SAID,
    MOST_OFFERED,
    NO_WHOLE_NUMBER,
    NOT_SURE,
    TOO_LONG,
    TOO_MANY_DECIMALS,
    Decision,
    Scores,
    Sentence,
    Thresholds,
    decide,
    log_odds,
    no_command,
    not_a_command,
    stop,
)
from core.speech.recognition.endpointing import voiced
from core.speech.recognition.recognizer import NameOpinion, Utterance
from core.speech.settings import RATE_HZ
from core.speech.understanding.grammar import OwnPhrases, Refusal, faithful, parse, says_stop, slips
from core.speech.understanding.numbers import number_words
from core.speech.understanding.place_names import ARTICLE, names_alike
from core.speech.whisper.joint_search import Columns, Found, JointSearch, ScoredText, by_chance
from core.speech.whisper.log_mel import log_mel
from core.speech.whisper.model_file import ModelFile
from core.speech.whisper.spellings import (
    ROUTE_SPELLINGS,
    Spellings,
    as_understood,
    count_digits,
    has_more_decimals,
    lacks_whole_part,
    misheard,
    misspelt,
    one_point,
    seldom_said,
    sound_of,
    words_of,
)
from core.speech.whisper.tokenizer import Tokenizer
from core.speech.whisper.transformer import Decoder, Encoder
from core.speech.whisper.word_times import FRAME_S, spans_of

MAX_SOUND_S = 26  # of which more is not read: only its end, where it is longer
MIN_SOUND_S = 0.1  # below which nothing was said
MAX_RIVALS = 4  # meanings of which the best is chosen
THRESHOLDS = Thresholds(reject=1.0, accept=2.0)  # [nats] before the second meaning
UNREAD_NATS = 1.0  # below the last of the second reading: the score there of a meaning that it lacks
LOG_ODDS_PER_NAT = 1.35  # [nats] of log odds that a number is right, per nat of its lead (`tests.benchmarks.voices`)
MIN_RIGHT_PROBABILITY = 0.8  # probability that a number is right, below which it is rejected
MAX_LEAD_NATS = 4.0  # beyond which a lead says no more: one number in 300 is wrong however far it is ahead
NUMBER_THRESHOLDS = Thresholds(
    reject=log_odds(MIN_RIGHT_PROBABILITY) / LOG_ODDS_PER_NAT, accept=2.0, scale=1 / LOG_ODDS_PER_NAT
)
SLOWER_PACE = 1.1  # times as long the sound lasts in the second reading of what is doubtful
OTHER_PACES = 0.87, 1.22  # times as long it lasts in two more readings of a name that fits too badly in the first two
MIN_AGREEING = 3  # of these four, in which it has to be the likeliest name
REJECTED_BEFORE_NATS = 4.0  # by which a command is less likely that was rejected just before
OFFERED_BEHIND_NATS = 6.0  # behind the best free text, down to which a meaning is offered
LEAD_IN_S = 0.2  # of what was before the voice is read: more silence there makes every text less likely
UNHEARD_WORDS_NATS = 1.5  # by which a number is likelier beside one without some of its words: they get lost
NEAR_FREE_NATS = 1.0  # behind the best meaning, down to which free text with more digits or words is against it
TO_NAMES = frozenset(
    one.split(" {name}")[0].removesuffix(" the").replace("route", spelling)
    for one in (*TO_PLACE, *START_ROUTE.words)
    for spelling in ROUTE_SPELLINGS
)
"""Words before the names of places and routes: "go to"."""
SLURRED_BEHIND_NATS = 8.0  # behind the best free text, down to which those words may be meant
OTHER_LENGTH = re.compile(
    r"(?i)\b(?:half|quarter|first|second|third|fourth|fifth|sixth|seventh|eighth|ninth|tenth|once|twice|double)s?\b"
    r"|[0-9](?:st|nd|rd|th)\b|[½¼¾]|[0-9]/[0-9]"
    r"|\b(?:feet|foot|yards?|inch(?:es)?|miles?|square|left|right|back(?:wards?)?|less|more)\b"
)
"""Words of free text that are doubted like a digit more: neither two meters and a half, nor the second meter, nor two
feet, nor two meters to the left is 2 meters ahead.
"""
DOUBLED = re.compile(r"\.([1-9])\1")  # the same decimal twice: it is also written where it was said three times
LEAST_SPOKEN_M = 0.05  # of a spoken length or place but 0: "one centimeters" is written for "one or two meters"
COMMON_CHANCE_NATS = -14.0  # of words by chance: "follow me" is above
RARE_CHANCE_NATS = -20.0  # the same for rare ones: "turn left" is near
COMMON_MARGIN_NATS = 2.0  # below its bound, down to which its score may be then
SELDOM_NATS = 1.0  # by which "3.0", "1.05", "0.77" are less likely: they are written for "3.2", "1.25", "0.7"
DECIMAL_SENTENCE = "Continue 1.{digit} meters."  # in which decimals by chance are compared
NAMES_BY_CHANCE = 0.3  # of their nats that count
USUAL_WORDS_NATS = -23.5  # of a usual name by chance: "Go to the bedroom."
UNUSUAL_SHARE = 0.6  # of the nats below that, by which rarer words may be likelier than a name
MOST_UNUSUAL_NATS = 5.0  # by which they may be, at most
UNRIVALLED_LEAD_NATS = 5.0  # by which a name that no other words compete with is ahead of them
ALIKE_NAMES_NATS = 2.5  # by which a name must be likelier than other words that sound like it
SOUND_SCALE = 40.0  # [nats] by the other engine that count as one here
MAX_FOR_NATS, MAX_AGAINST_NATS = 3.0, 4.0  # that it may add to a name, and take from it
WEIGHED_SCORE, WEIGHED_LEAD = 1.2, 1.0  # [nats] by which both bounds of a name are wider before that
CONTRADICTING_NATS = -100.0  # by the other engine, from which a name that keeps its own bounds is doubted
MIN_FIT_OF_BEST = 0.3  # [nats] by which it must keep its bounds in its best two readings; unknown places did by 0.2
DENYING_NATS = -250.0  # by the other engine, from which a name is not read again; no voice was known below -220
USUAL_NAME_NATS = -21.0  # of "Go to the garden." by chance
DECIMALS_BY_CHANCE = 0.5  # of their nats that do not count: 5 is written 3 nats more often than 9
NO_WORDS = re.compile(r"(?i:you)?[\s.,!?♪♫>]*(?:(?:\([^)]*\)|\[[^]]*\]|\*[^*]*\*|[♪♫][^♪♫]*[♪♫]?)[\s.,!?♪♫>]*)*")
"""Texts that Whisper writes for sounds that are no speech: "(wind howling)", "[Music]", "*cough*", ">>", "you"."""
STOP_MISHEARD = "start moving"
"""Free text where a machine or a room makes "stop moving" unclear; nothing that moves the robot is called so."""
NAME_STOP = frozenset(
    kind.name for kind in (*VOCABULARY, PAUSE_ROUTE) if kind is not STOP_MOVING and any(map(says_stop, kind.words))
)
"""Commands with words that stop which do something else: "stop at 1 and 2", "pause"."""
TO_PERSON = frozenset(kind.name for kind in VOCABULARY if kind.target == "person")
LONG_UTTERANCE_S = 1.2  # from which more was said in an utterance than the words of such a command
WORD_TIME_ERROR_S = 0.3  # to which the times of words are known
VOICE_DB = 10.0  # below its loudest parts, to which a voice is measured: echoes and others' talk are fainter
BEGIN_SHARE = 0.5  # of a voice's length, in which a command is less likely than in all of it
MOST_GAINED_NATS = 1.0  # by which it may be likelier there
SAID_AGAIN_S = 10.0  # after which a command that was doubted for this is new
MOST_SPANS = 2  # of the times at which they may have been said that are read

Key = tuple[str, tuple[tuple[str, float], ...], bool]
"""A command's name, or its words where they name a place; its numbers, and whether one is not whole, or is none."""


@message
class Bounds:
    """How well a meaning must fit."""

    score: float  # [nats] at least
    behind_free: float  # [nats] behind the best free text that means something else, at most


ALIKE_LETTERS = 2  # letters of a sound that differ between words that may be the same
OTHERWISE_BEHIND_NATS = 2.0  # behind the best free text that sounds otherwise, for numbers
NUMBER_BOUNDS, COMMON_BOUNDS, RARE_BOUNDS, STOP_BOUNDS, NAME_BOUNDS = (
    Bounds(score=-8, behind_free=4),
    Bounds(score=-6, behind_free=0.7),
    Bounds(score=-8, behind_free=3),
    Bounds(score=-7, behind_free=3.4),
    Bounds(score=-5, behind_free=1),
)
"""Middles of wide plateaus (`tests.benchmarks.voices`). Whisper rather writes "to", "by" or "for" than numbers."""


@message
class Meaning:
    """A command, and all spellings of it together."""

    spelling: str  # the likeliest
    nats: float  # logarithm of the sum of their probabilities
    key: Key
    by_chance: float = 0.0  # [nats] that it owes to its decimals, beside others with as many
    again: float | None = None  # [nats] in the second reading; None: there was none

    @property
    def mean(self) -> float:
        """Mean of both readings [nats]."""
        return 0.5 * (self.nats + (self.again or 0.0))

    def ahead_of(self, other: Meaning) -> float:
        """Return by how much [nats] this is likelier than the other one."""
        unheard = UNHEARD_WORDS_NATS * (_lacks_words(other.key, self.key) - _lacks_words(self.key, other.key))
        by_chance = self.by_chance - other.by_chance if _shape(self.key) == _shape(other.key) else 0.0
        ahead = self.nats - other.nats
        if self.again is not None and other.again is not None:
            again = self.again - other.again
            ahead = min(ahead, again) if self.key[1] else 0.5 * (ahead + again)
        return ahead - by_chance + unheard


@message
class OtherName:
    """Words in the place of a name that nobody has named."""

    text: str  # one way to write the whole sentence
    nats: float  # of all ways together
    by_chance: float  # [nats] of the text
    usual_alike: bool  # a usual word that sounds like the name


class WhisperRecognizer:
    """Commands, and the words of everything else."""

    def __init__(self, folder: Path, own: OwnPhrases = (), names: NameOpinion | None = None) -> None:
        """`folder` with `model.bin` and `tokenizer.json` of an English-only model; `own`: phrases of the user's;
        `names`: who else is asked which place was named.

        Raises BadInput.
        """
        self._folder, self._names = folder, names
        self._model = ModelFile(folder / "model.bin")
        self.encode = Encoder(self._model)
        self._heard = lru_cache(2)(lambda pcm: self.encode(log_mel(np.frombuffer(pcm))))  # both readings of a sound
        self._chance = _ChanceOfPhrases()
        self._doubted = "", -math.inf  # the command that half the voice would be too, and when [s] it ended
        self.learn(own)

    def learn(self, own: OwnPhrases) -> None:
        """Hear these phrases of the user's beside the vocabulary from now on, and no others. Raises BadInput."""
        tokenizer = Tokenizer(self._folder / "tokenizer.json")  # 30 MB, not needed after this
        spellings = Spellings(tokenizer.encode, _patterns(own))
        columns = Columns(spellings, tokenizer, names=any(one.place for one in own))
        decoder = Decoder(self._model, self.encode.width, columns.tokens)
        self._search = JointSearch(decoder, spellings, columns)
        phrases = _phrases(own)
        texts = [f"{words.capitalize()}." for _, words in phrases]
        nats: dict[str, float] = {}
        for (name, _), one in zip(phrases, self._chance.of(texts, decoder, columns, tokenizer), strict=True):
            nats[name] = max(nats.get(name, -math.inf), one)
        self._fixed = {name: (_bounds_of if name in SPECS else _bounds_of_name)(one) for name, one in nats.items()}
        decimals = (DECIMAL_SENTENCE.format(digit=digit) for digit in range(10))
        self._decimals = np.array(self._chance.of(decimals, decoder, columns, tokenizer))
        self._written = {
            _named(one.kind, one.place): [
                columns.columns(tokenizer.encode(text)) for text in _ways_to_write(one.place)
            ]
            for one in own
            if one.place is not None
        }
        if self._names is not None:
            self._names.learn(own)
        self._own = own

    def rest(self) -> None:
        """Give back the memory of the model: 62 MB of Whisper tiny.en, which the next utterance reads in 20 ms."""
        self._search.rest()
        self._heard.cache_clear()
        self._model.rest()

    def decide(self, utterance: Utterance) -> Decision:
        """Compare the best meaning with free text and with the second meaning."""
        begin = max(len(utterance.before) - round(LEAD_IN_S * RATE_HZ), 0)
        samples = utterance.samples[begin:][-MAX_SOUND_S * RATE_HZ :]
        found = self.search(samples)
        meanings, agreed = self._weighed(samples, found, utterance.rejected)
        objection = TOO_LONG if utterance.cut else "" if agreed else NOT_SURE
        decision = self._decided(meanings, found, objection)
        if not utterance.cut and (decision.command is None or decision.command.place):
            decision = self._to_place(decision, samples, found, utterance)
        elif objection := self._objection_to_motion(decision, samples, found, utterance):
            decision = self._decided(meanings, found, objection)
        goes = decision.command is not None and decision.command.name in NAME_STOP
        words = found.free_text
        silence = NO_WORDS.fullmatch(words) and "stop" not in words.lower()  # "[ Pause ]" is written for one
        stops = not silence and (says_stop(words) or STOP_MISHEARD in words.lower())
        if stops and not goes and not decision.stops:
            return stop(found.free_text, remark=decision.reason)
        return self._timed(decision, utterance, samples, found)

    def _timed(self, decision: Decision, utterance: Utterance, samples: Array, found: Found) -> Decision:
        """A command to a person in a long utterance with when its words were said: others may have talked in it."""
        command = decision.command
        if command is None or command.name not in TO_PERSON or utterance.end - utterance.begin < LONG_UTTERANCE_S:
            return decision
        said = self._said(command.name, samples, found)
        if said is None:
            return decision
        first = utterance.sound.stamp + (len(utterance.samples) - len(samples)) / RATE_HZ  # [s] of the samples
        begin, end = first + said[0], min(first + said[1], utterance.end)
        if begin < utterance.begin + WORD_TIME_ERROR_S:
            begin = utterance.begin
        alone = begin == utterance.begin and end > utterance.end - WORD_TIME_ERROR_S
        return decision if alone else replace(decision, said=(begin, end))

    def _said(self, name: str, samples: Array, found: Found) -> tuple[float, float] | None:
        """From when to when [s] of the samples the words of a command were said; None where that is not known.

        Who talks before or after them is not the one who gave it.
        """
        text = next((one for one in found.spellings if self._is_of(one, name)), None)
        if text is None:
            return None
        attention = self._search.attention(self.encode(log_mel(samples)), text)
        for begin, end in islice(spans_of(attention[:, : round(len(samples) / RATE_HZ / FRAME_S)]), MOST_SPANS):
            part = samples[max(round((begin - LEAD_IN_S) * RATE_HZ), 0) : round(end * RATE_HZ)]
            read = self.search(part)
            decision = self._decided(self.meanings(read), read, "")
            if decision.command is not None and decision.command.name == name:
                return begin, end
        return None

    def _is_of(self, text: ScoredText, name: str) -> bool:
        """Return whether a text is this command, in the user's own words, too."""
        key = key_of(text.text, self._own)
        return key is not None and key[0] == name

    def _weighed(self, samples: Array, found: Found, rejected: Iterable[str]) -> tuple[list[Meaning], bool]:
        """The meanings, after a second reading where it is hard to tell the best; False: the two do not agree."""
        meanings = self.meanings(found, rejected)
        best, lead = _best(meanings) if meanings else (None, 0.0)
        if best is None or (lead >= THRESHOLDS.reject and not best.key[1]) or self._fits(best, found) <= 0:
            return meanings, True
        slower = self.search(resampled(samples, RATE_HZ, SLOWER_PACE * RATE_HZ))
        again = self.meanings(slower, rejected)
        both = _read_twice(meanings, again, found, slower)
        return both, len({_best(one)[0].key for one in (meanings, again, both) if one}) == 1

    def _objection_to_motion(self, decision: Decision, samples: Array, found: Found, utterance: Utterance) -> str:
        """Why a command must not move the robot once its sound is read in other ways; "": it may.

        Without numbers, what half the voice would be too is obeyed once it is said again.
        """
        command = decision.command
        if command is None or not spec_of(command.name).moves:
            return ""
        alone = len(decision.words.split()) == 1  # talk and other languages have words like "come"
        if alone and not self._confirmed_slower(decision, samples, utterance.rejected):
            return NOT_SURE
        same = (one for one in (*found.spellings, *found.free) if self._is_of(one, command.name))
        text = max(same, key=lambda one: one.nats, default=None)
        others_may_talk = command.name in TO_PERSON and utterance.end - utterance.begin > LONG_UTTERANCE_S
        if text is None or has_said_numbers(command) or others_may_talk:
            return ""
        near = (one for one in found.free if one.nats > text.nats - NEAR_FREE_NATS)
        if any(_holds_more(one.text, text.text) and not self._is_of(one, command.name) for one in near):
            return MORE_SAID
        if not self._begins_alike(text, samples):
            return ""
        name, end = self._doubted
        if name == command.name and 0.0 < utterance.begin - end < SAID_AGAIN_S:
            return ""
        self._doubted = command.name, utterance.end
        return MORE_SAID

    def _begins_alike(self, text: ScoredText, samples: Array) -> bool:
        """Return whether the first half of the voice alone is rather written so than all of it: what follows are
        words that Whisper did not write, as "Go on" for "go on holiday". Half of "turn left" is "turn", however
        slowly it is said.
        """
        begin, end = voiced(samples, VOICE_DB)
        half = samples[: round((begin + BEGIN_SHARE * (end - begin)) * RATE_HZ)]
        if begin >= end:
            return False
        nats = self._search.written(self.encode(log_mel(half)), (), [text.columns])
        return float(nats[0]) > text.nats + MOST_GAINED_NATS

    def _confirmed_slower(self, decision: Decision, samples: Array, rejected: Iterable[str]) -> bool:
        """Return whether slower speech, by itself, is the same command."""
        found = self.search(resampled(samples, RATE_HZ, SLOWER_PACE * RATE_HZ))
        again = self._decided(self.meanings(found, rejected), found, "").command
        return again is not None and decision.command is not None and again.name == decision.command.name

    def _to_place(self, decision: Decision, samples: Array, found: Found, utterance: Utterance) -> Decision:
        """The decision about words that may go to a named place: given that they do, which place is it?

        The words before the name are the same for all, and a voice may slur them: only what follows is compared.
        Another engine's opinion may choose another name; where it knows the name, it is part of the score.
        """
        if not any(one.place for one in self._own):
            return decision
        free = found.free[0].nats if found.free else -math.inf
        near = (one for one in found.spellings if one.nats > free - SLURRED_BEHIND_NATS)
        begun = next((begin for one in near if (begin := self._search.begin_of(one, TO_NAMES))), ())
        if not begun:
            return decision
        views = [samples, resampled(samples, RATE_HZ, SLOWER_PACE * RATE_HZ)]
        readings = [_all_as_spellings(self.search(one, begun)) for one in views]
        first, second = (self.meanings(one, utterance.rejected) for one in readings)
        both = _read_twice(first, second, *readings) if first and second else []
        best, lead = _best(both) if both else (None, 0.0)
        sound: dict[str, float] = {}
        if self._names is not None and (best is None or best.key[0] not in SPECS):
            sound = self._names.weigh(utterance, best.key[0] if best else "")
            best, lead = self._better_by_sound(best, lead, sound, views, begun, utterance.rejected)
        if best is None:
            return self._unknown_place(decision, found, readings[0])
        heard = sound.get(best.key[0])
        fits = self._fits_as_name(best, readings, begun, heard, utterance)
        if best.key[0] in SPECS and decision.command is None:
            return decision
        if fits <= 0 and best.key[0] not in SPECS and (heard is None or heard > DENYING_NATS):
            paced = self._best_readings(best, readings, samples, begun, utterance.rejected)
            if paced is not None:
                best = paced[0]
                fits = self._fits_as_name(*paced, begun, heard, utterance) - MIN_FIT_OF_BEST
        if fits <= 0 or best.key[0] in SPECS:
            return self._unknown_place(decision, found, readings[0], both, fits)
        sentences = [self._sentence(one) for one in (best, *(one for one in both[:3] if one is not best))]
        scores = Scores(sentence=best.mean, over_free_text=fits, over_second_best=min(lead, THRESHOLDS.accept))
        return decide(sentences[0], scores, THRESHOLDS, others=sentences[1:])

    def _better_by_sound(
        self,
        best: Meaning | None,
        lead: float,
        sound: dict[str, float],
        views: list[Array],
        begun: tuple[int, ...],
        rejected: Iterable[str],
    ) -> tuple[Meaning | None, float]:
        """The best name and its lead [nats] → those that both engines together find, by the other one's `sound`."""
        unlikely = {key[0] for words in rejected if (key := key_of(words, self._own)) is not None}
        named = max(sound.keys() - unlikely, key=lambda key: sound[key], default="")
        if not named:
            return best, lead
        if best is not None and named == best.key[0]:
            return best, max(lead, THRESHOLDS.reject)
        written = self._written[named]
        nats = [self._search.written(self._hear(view), begun, written) for view in views]
        first, again = (float(np.logaddexp.reduce(one)) for one in nats)
        spelling = self._search.text((*begun, *written[int(np.argmax(nats[0]))]))
        other = Meaning(spelling=spelling, nats=first, again=again, key=(named, (), False))
        if best is None or other.mean - best.mean > (sound.get(best.key[0], 0.0) - sound[named]) / SOUND_SCALE:
            return other, THRESHOLDS.accept
        return best, lead

    def _best_readings(
        self, name: Meaning, readings: list[Found], samples: Array, begun: tuple[int, ...], rejected: Iterable[str]
    ) -> tuple[Meaning, list[Found]] | None:
        """A name in the two of four readings, at other paces and pitches, in which it is likeliest, and these; None
        where not most of all four take it for the likeliest name, or one rather has a usual word that sounds like it.
        """
        for pace in OTHER_PACES:
            view = resampled(samples, RATE_HZ, pace * RATE_HZ)
            readings = [*readings, _all_as_spellings(self.search(view, begun))]
        meanings = [self.meanings(read, rejected) for read in readings]
        nats = [next((one.nats for one in read if one.key == name.key), -math.inf) for read in meanings]
        if sum(read[0].key == name.key for read in meanings if read) < MIN_AGREEING:
            return None
        if any(self._prefers_usual_word(read, name, own, begun) for own, read in zip(nats, readings, strict=True)):
            return None
        first, second = sorted(range(len(readings)), key=lambda number: -nats[number])[:2]
        return replace(name, nats=nats[first], again=nats[second]), [readings[first], readings[second]]

    def _fits_as_name(
        self,
        meaning: Meaning,
        readings: list[Found],
        begun: tuple[int, ...],
        sound: float | None,
        utterance: Utterance,
    ) -> float:
        """By how much [nats] a name keeps its bounds; `sound`: how well it fits the other engine, if known there.

        Where other words are written rather, the other engine is asked about each of them that it can pronounce; a
        name only gains from that where it fits better than all of them.
        """
        score, over = meaning.mean - self._bounds(meaning).score, self._over_other_names(meaning, readings, begun)
        if sound is None:
            return min(score, over)
        heard, ahead = (sound - CONTRADICTING_NATS) / SOUND_SCALE, over + _share_of(sound)
        weighed = score + WEIGHED_SCORE + _share_of(sound)
        if over < 0 < min(weighed, heard) and self._names is not None:
            spoken = {one.text: words_of(one.text) for read in readings for one in self._other_texts(meaning, read)}
            by_words = self._names.over_words(utterance, meaning.key[0], dict.fromkeys(spoken.values()))
            shares = {text: _share_of(by_words.get(words, sound)) for text, words in spoken.items()}
            compared = self._over_other_names(meaning, readings, begun, shares)
            ahead = compared if min(by_words.values(), default=0.0) > 0 else min(compared, ahead)
        return max(min(weighed, ahead + WEIGHED_LEAD), min(score, over, heard))

    def _over_other_names(
        self,
        meaning: Meaning,
        readings: list[Found],
        begun: tuple[int, ...],
        by_sound: Mapping[str, float] | None = None,
    ) -> float:
        """By how much [nats] a name keeps its bounds beside all words that nobody has named, a mean of two readings.

        Words that nobody writes by themselves, like "Malcony", are rather a known name that was not heard well; usual
        ones that sound like it, like "bedroom", must be less likely in both readings. `by_sound`: texts → what the
        other engine says for the name against each [nats].
        """
        over: list[float] = []
        alike = math.inf
        for read, nats in zip(readings, (meaning.nats, meaning.again or 0.0), strict=True):
            least = UNRIVALLED_LEAD_NATS
            for other in self._other_names(meaning, read, begun):
                ahead = nats - other.nats + (0.0 if by_sound is None else by_sound[other.text])
                if other.usual_alike:
                    alike = min(alike, ahead - ALIKE_NAMES_NATS)
                unusual = UNUSUAL_SHARE * max(USUAL_WORDS_NATS - other.by_chance, 0.0)
                least = min(least, ahead + min(unusual, MOST_UNUSUAL_NATS))
            over.append(least)
        return min(alike, sum(over) / len(over) + NAME_BOUNDS.behind_free)

    def _prefers_usual_word(self, read: Found, name: Meaning, own: float, begun: tuple[int, ...]) -> bool:
        """Return whether a reading rather has a usual word that sounds like a name than the name, of `own` [nats]."""
        said, groups = self._in_place_of(name, read, begun)
        likelier = [
            texts[0]
            for words, texts in groups.items()
            if names_alike(words, said) and np.logaddexp.reduce([one.nats for one in texts]) > own
        ]
        return bool(likelier) and max(self._search.by_chance(likelier)) > USUAL_WORDS_NATS

    def _in_place_of(
        self, meaning: Meaning, read: Found, begun: tuple[int, ...]
    ) -> tuple[str, dict[str, list[ScoredText]]]:
        """A name, and the other words that a reading has in its place → all ways to write each."""
        before = len(self._search.text(begun))
        name = _name(meaning.spelling[before:])
        groups: dict[str, list[ScoredText]] = {}
        for one in self._other_texts(meaning, read):
            if (words := _name(one.text[before:])) != name:
                groups.setdefault(words, []).append(one)
        return name, groups

    def _other_names(self, meaning: Meaning, read: Found, begun: tuple[int, ...]) -> list[OtherName]:
        """The words that a reading has in the place of a name; the ways to write them count together."""
        name, groups = self._in_place_of(meaning, read, begun)
        usual = self._search.by_chance([texts[0] for texts in groups.values()]) if groups else ()
        return [
            OtherName(
                text=texts[0].text,
                nats=float(np.logaddexp.reduce([one.nats for one in texts])),
                by_chance=float(chance),
                usual_alike=bool(chance > USUAL_WORDS_NATS) and names_alike(words, name),
            )
            for (words, texts), chance in zip(groups.items(), usual, strict=True)
        ]

    def _unknown_place(
        self, decision: Decision, found: Found, read: Found, near: Iterable[Meaning] = (), fits: float = 0.0
    ) -> Decision:
        """The decision about words that go to no place which is known: say which words, if any of them are clear."""
        words = read.free_text.rstrip(" .,!?")
        if decision.command is None and not any(map(found.free_text.lower().startswith, TO_NAMES)):
            return decision
        if key_of(words, self._own) is not None:
            return decide(
                Sentence(as_understood(words), self._own),
                Scores(sentence=read.free[0].nats),
                THRESHOLDS,
                objection=NOT_SURE,
            )
        refused = _not_understood(words, map(self._sentence, self._near([*near], read.free[0].nats)), fits)
        return replace(refused, words=words, reason=Statement("places.no_such_sound", words=words))

    def transcribe(self, utterance: Utterance) -> str:
        """Write down all speech, in any words."""
        text = self.search(utterance.samples).free_text
        return "" if NO_WORDS.fullmatch(text) else text

    def search(self, samples: Array, begun: tuple[int, ...] = ()) -> Found:
        """Samples (N,) of full scale ±1 at 16 kHz → the likeliest commands and free texts that begin so."""
        if len(samples) < MIN_SOUND_S * RATE_HZ or not np.any(samples):
            return Found(spellings=(), free=())
        heard = samples[-MAX_SOUND_S * RATE_HZ :]
        return self._search.search(self._hear(heard), len(heard) / RATE_HZ, begun)

    def _hear(self, samples: Array) -> Array:
        """Encode samples (N,) → (T, width)."""
        return self._heard(np.asarray(samples[-MAX_SOUND_S * RATE_HZ :], float).tobytes())

    def meanings(self, found: Found, rejected: Iterable[str] = ()) -> list[Meaning]:
        """The commands of all spellings that were found, the likeliest first."""
        sums: dict[Key, Meaning] = {}
        for one in found.spellings:
            spelling = one.text
            key = key_of(spelling, self._own)
            if key is not None:
                known = sums.get(key)
                likely = one.nats - SELDOM_NATS * seldom_said(spelling)
                nats = likely if known is None else float(np.logaddexp(known.nats, likely))
                sums[key] = Meaning(spelling=known.spelling if known else spelling, nats=nats, key=key)
        unlikely = {key_of(words, self._own) for words in rejected}
        weighed = [
            replace(
                one,
                nats=one.nats - REJECTED_BEFORE_NATS * (one.key in unlikely),
                by_chance=self._owed_to_chance(one.key),
            )
            for one in sums.values()
        ]
        return sorted(weighed, key=lambda one: -one.nats)

    def _decided(self, meanings: list[Meaning], found: Found, objection: str) -> Decision:
        if not meanings:
            return _not_understood(found.free_text, (), 0.0)
        best, lead = _best(meanings)
        bounds, free = self._bounds(best), found.free[0].nats if found.free else -math.inf
        other = max((one.nats for one in self._other_texts(best, found)), default=-math.inf)
        fits = self._fits(best, found)
        if fits <= 0:
            return _not_understood(found.free_text, map(self._sentence, self._near(meanings, free)), fits)
        if bounds is not NUMBER_BOUNDS and (
            best.again is not None or other - best.nats > COMMON_BOUNDS.behind_free or misspelt(best.spelling)
        ):
            lead = min(lead, THRESHOLDS.accept)  # confirmed first
        sentences = [self._sentence(one) for one in (best, *(one for one in meanings[:3] if one is not best))]
        scores, thresholds = Scores(sentence=best.nats, over_free_text=fits, over_second_best=lead), THRESHOLDS
        if best.key[1]:  # free text says nothing more about a number that fits
            scores = Scores(sentence=best.nats, over_second_best=min(lead, MAX_LEAD_NATS))
            thresholds = NUMBER_THRESHOLDS
        objection = objection or self._objection(best, found)
        return decide(sentences[0], scores, thresholds, objection=objection, others=sentences[1:])

    def _other_texts(self, meaning: Meaning, found: Found) -> list[ScoredText]:
        """The free texts that mean something else."""
        return [one for one in found.free if key_of(one.text, self._own) != meaning.key]

    def _fits(self, meaning: Meaning, found: Found) -> float:
        """By how much [nats] a meaning keeps its bounds. Free text that sounds otherwise is against numbers."""
        bounds = self._bounds(meaning)
        sound = sound_of(meaning.spelling) if bounds is NUMBER_BOUNDS else ""
        fits = meaning.nats - bounds.score
        for one in self._other_texts(meaning, found):
            alike = bounds is not NUMBER_BOUNDS or slips(sound, sound_of(one.text)) <= ALIKE_LETTERS
            behind = bounds.behind_free if alike else OTHERWISE_BEHIND_NATS
            fits = min(fits, meaning.nats - one.nats + behind)
        return fits

    def _objection(self, best: Meaning, found: Found) -> str:
        """Why these numbers must not move the robot; "": they may."""
        if has_more_decimals(best.spelling):
            return TOO_MANY_DECIMALS
        if best.key[2] or any(0 < abs(value) < LEAST_SPOKEN_M for _, value in best.key[1]):
            return NO_WHOLE_NUMBER
        near = [one.text for one in self._other_texts(best, found) if one.nats > best.nats - NEAR_FREE_NATS]
        digits = count_digits(best.spelling)
        more = digits and any(count_digits(text) > digits or OTHER_LENGTH.search(text) for text in near)
        return MORE_DIGITS if more or any(DOUBLED.search(f"{value:.2f}") for _, value in best.key[1]) else ""

    def _owed_to_chance(self, key: Key) -> float:
        """[nats] by which its numbers with one decimal are written more often than others, as far as it counts."""
        single = [_decimals(value) // 10 for _, value in key[1] if _places(value) == 1]
        return DECIMALS_BY_CHANCE * sum(float(self._decimals[digit]) for digit in single)

    def _bounds(self, meaning: Meaning) -> Bounds:
        """How well this command must fit."""
        name, numbers, _ = meaning.key
        if name in (STOP_MOVING.name, PAUSE_ROUTE.name):
            return STOP_BOUNDS
        fixed = NUMBER_BOUNDS if numbers else self._fixed.get(name, COMMON_BOUNDS)
        return replace(fixed, behind_free=COMMON_BOUNDS.behind_free) if misheard(meaning.spelling) else fixed

    def _near(self, meanings: list[Meaning], free: float) -> list[Meaning]:
        """Those that are worth offering beside free text of that score [nats]; START changes nothing."""
        return [
            one
            for one in meanings
            if one.nats > max(free - OFFERED_BEHIND_NATS, self._bounds(one).score - COMMON_MARGIN_NATS)
            and one.key[0] != START.name
            and not one.key[2]
        ]

    def _sentence(self, meaning: Meaning) -> Sentence:
        return Sentence(as_understood(meaning.spelling), self._own)


def key_of(words: str, own: OwnPhrases = ()) -> Key | None:
    """The meaning of words, whatever the bounds of their numbers; None: no command."""
    found = parse(one_point(as_understood(words)), own).found
    if isinstance(found, Refusal):
        return None
    whole = not lacks_whole_part(words) and not has_more_decimals(words)
    return _named(found.kind, found.place), tuple(found.numbers.items()), not whole


def _share_of(sound: float) -> float:
    """Convert the other engine's nats to those that they add to a name here, or take from it."""
    return float(np.clip(sound / SOUND_SCALE, -MAX_AGAINST_NATS, MAX_FOR_NATS))


def _name(words: str) -> str:
    """The name of a place in words that go to it, in small letters without marks."""
    return " ".join(re.findall("[a-z0-9]+", re.sub("[-']", "", words.lower()))).removeprefix("the ")


def _named(kind: CommandSpec, place: NamedPlace | None) -> str:
    """The name of a command in a key: one to a place is called by its words."""
    return kind.name if place is None else command_to(place).heard_as


def _ways_to_write(place: NamedPlace) -> list[str]:
    """The ways in which Whisper may write a name behind "go to"."""
    names = dict.fromkeys((place.name, _in_capitals(place.name), place.name.lower()))
    return [f" {article}{name}{end}" for name in names for article in (ARTICLE, "") for end in (".", "")]


def _in_capitals(name: str) -> str:
    return name.title().replace("'S", "'s")


def _patterns(own: OwnPhrases) -> Iterator[str]:
    """All patterns of the user's phrases; a place's name is also written as it was given, and with capitals."""
    for phrase in own:
        yield phrase.pattern
        if phrase.place is not None:
            name = phrase.place.name
            for written in (name, _in_capitals(name)):
                yield re.sub(f"{re.escape(name.lower())}$", written, phrase.pattern)


def _holds_more(text: str, words: str) -> bool:
    """Return whether a text is these words and others beside them: "Do not turn right", of "turn right"."""
    whole, part = (" ".join(re.findall("[a-z0-9']+", one.lower())) for one in (text, words))
    return whole != part and f" {part} " in f" {whole} "


def _lacks_words(one: Key, other: Key) -> bool:
    """Return whether the commands are the same, and each number of the first that differs is the other's without some
    of its words: 0.4 or 2, and 2.4.
    """
    pairs = [(a, b) for (_, a), (_, b) in zip(one[1], other[1], strict=False) if a != b]
    same = one[0] == other[0] and len(one[1]) == len(other[1])
    return same and bool(pairs) and all(_within(number_words(a), number_words(b)) for a, b in pairs)


def _within(few: list[str], many: list[str]) -> bool:
    """Return whether all of the few words are among the many, in their order."""
    left = iter(many)
    return all(word in left for word in few)


def _decimals(value: float) -> int:
    """The digits behind the point, in hundredths."""
    return round(100 * abs(value)) % 100


def _places(value: float) -> int:
    """How many decimals a number has."""
    return 0 if _decimals(value) == 0 else 1 if _decimals(value) % 10 == 0 else 2


def _shape(key: Key) -> tuple[object, ...]:
    """The command, and how many decimals its numbers have."""
    return key[0], *(_places(value) for _, value in key[1])


def _all_as_spellings(found: Found) -> Found:
    """The texts of a search, all as spellings: a name may be written in parts, "mail box"."""
    return replace(found, spellings=tuple({one.text: one for one in (*found.free, *found.spellings)}.values()))


def _read_twice(meanings: list[Meaning], again: list[Meaning], found: Found, found_again: Found) -> list[Meaning]:
    """The meanings of two readings; one that a reading lacks is less likely there than every spelling that it has."""
    first, second = ({one.key: one for one in read} for read in (meanings, again))
    last, last_again = (min((one.nats for one in read.spellings), default=0.0) for read in (found, found_again))
    unread, unread_again = last - UNREAD_NATS, last_again - UNREAD_NATS
    both = [replace(one, again=second[one.key].nats if one.key in second else unread_again) for one in meanings]
    return both + [replace(one, nats=unread, again=one.nats) for one in again if one.key not in first]


def _best(meanings: list[Meaning]) -> tuple[Meaning, float]:
    """The meaning that is furthest ahead of all others, and how far [nats]; ∞: there is no other."""
    few = meanings[:MAX_RIVALS]
    leads = [min((one.ahead_of(other) for other in meanings if other is not one), default=math.inf) for one in few]
    lead = max(leads)
    return few[leads.index(lead)], lead


def _phrases(own: OwnPhrases) -> list[tuple[str, str]]:
    """Every command without numbers, by its name in a key, and its phrases; of a place the words said most."""
    plain = [(kind.name, words) for kind in VOCABULARY for words in kind.words]
    plain += [(one.kind.name, one.pattern) for one in own if one.place is None]
    places = {one.place.name.lower(): one for one in own if one.place is not None}
    named = [(_named(one.kind, one.place), SAID_OF_PLACES.format(name=name)) for name, one in places.items()]
    return [(name, words) for name, words in (*plain, *named) if "{" not in words]


class _ChanceOfPhrases(dict[str, float]):
    """How likely texts are written by chance [nats]; what is known of earlier vocabularies holds on."""

    def of(self, texts: Iterable[str], decoder: Decoder, columns: Columns, tokenizer: Tokenizer) -> list[float]:
        """Return the nats of each text."""
        wanted = list(texts)
        fresh = [text for text in wanted if text not in self]
        if fresh:
            written = [columns.columns(tokenizer.encode(f" {text}")) for text in fresh]
            nats = by_chance(decoder, columns.begin, columns.end, written, columns.common)
            self.update(zip(fresh, nats.tolist(), strict=True))
        return [self[text] for text in wanted]


def _bounds_of(nats: float) -> Bounds:
    """The bounds of a command of which the likeliest phrase, said often or rarely, has so many nats by chance."""
    share = min(max((COMMON_CHANCE_NATS - nats) / (COMMON_CHANCE_NATS - RARE_CHANCE_NATS), 0.0), 1.0)
    return Bounds(
        score=COMMON_BOUNDS.score + share * (RARE_BOUNDS.score - COMMON_BOUNDS.score),
        behind_free=COMMON_BOUNDS.behind_free + share * (RARE_BOUNDS.behind_free - COMMON_BOUNDS.behind_free),
    )


def _bounds_of_name(nats: float) -> Bounds:
    """The same of a place: a name that is seldom written by itself is written less surely where it was said."""
    return replace(NAME_BOUNDS, score=NAME_BOUNDS.score + NAMES_BY_CHANCE * (nats - USUAL_NAME_NATS))


def _not_understood(free_text: str, resembling: Iterable[Sentence], fits: float) -> Decision:
    """Nothing fits: say back what was heard, and offer what resembles it."""
    if NO_WORDS.fullmatch(free_text):
        return no_command()
    offered = [one.spoken for one in resembling]
    unchanged = faithful((one.heard_as for one in offered if not isinstance(one, Refusal)), free_text)
    commands = tuple(one for one in offered if not isinstance(one, Refusal) and one.heard_as in unchanged)[
        :MOST_OFFERED
    ]
    confidence = 0.5 + 0.5 * math.tanh(fits / 2)
    if not commands:
        return replace(no_command(confidence), heard=free_text)
    return Decision(
        verdict="reject",
        confidence=confidence,
        alternatives=commands,
        words=free_text,
        reason=not_a_command(free_text),
    )
