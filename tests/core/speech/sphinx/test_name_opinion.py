"""Names of places by their sound: what pocketsphinx thinks of those that Whisper finds."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from core.message import Array
from core.models import MODEL, find
from core.navigation.places import NamedPlace
from core.speech.recognition.recognizer import Utterance, for_words
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.name_opinion import SphinxNameOpinion, pronunciations
from core.speech.synthesis import VoiceSettings, can_speak, speak
from core.speech.understanding.grammar import OwnPhrases
from core.speech.understanding.place_names import place_phrases
from core.speech.whisper.joint_search import Found, JointSearch, ScoredText
from core.speech.whisper.recognizer import OTHER_PACES, Meaning, WhisperRecognizer
from tests.core.speech.ears import mono, padded, whisper

PLACE_NAMES = ("kitchen", "window", "workshop", "meeting room", "Xqzkvr")
DICTIONARY_LINES = (
    "white W AY T\nboard B AO R D\nsophie S OW F IY\nlamp L AE M P\nlamp(2) L AA M P\nnight N AY T\n's EH S\n"
)


@pytest.mark.parametrize(
    ("word", "ways"),
    [
        ("lamp", (("L", "AE", "M", "P"), ("L", "AA", "M", "P"))),
        ("whiteboard", (("W", "AY", "T", "B", "AO", "R", "D"),)),
        ("white-board", (("W", "AY", "T", "B", "AO", "R", "D"),)),
        ("sophie's", (("S", "OW", "F", "IY", "Z"),)),
        ("nightshade", None),
        ("12", None),
    ],
)
def test_a_word_is_said_as_the_dictionary_has_it_or_its_parts(
    tmp_path: Path, word: str, ways: tuple[tuple[str, ...], ...] | None
) -> None:
    (file := tmp_path / "words.dict").write_text(DICTIONARY_LINES)
    assert pronunciations([word], file).get(word) == ways


@pytest.mark.parametrize("names", [(), ("Xqzkvr",)])
def test_without_names_that_can_be_said_there_is_no_opinion(names: tuple[str, ...]) -> None:
    pytest.importorskip("pocketsphinx", reason="This needs pocketsphinx: pip install pocketsphinx")
    opinion = SphinxNameOpinion(SpeechSettings())
    opinion.learn(place_phrases(NamedPlace(name=name, x_m=0.0, y_m=0.0) for name in names))
    assert opinion.weigh(said("nothing", np.zeros(RATE_HZ)), "go to xqzkvr") == {}


@pytest.mark.skipif(not can_speak(), reason="Nothing here speaks: install the extra voice.")
@pytest.mark.parametrize("name", ["kitchen", "workshop", "meeting room"])
def test_the_name_that_was_said_fits_best(name: str) -> None:
    fits = learnt().weigh(spoken(f"go to the {name}"), "go to window")
    assert max(fits, key=lambda key: fits[key]) == f"go to {name}"
    assert fits[f"go to {name}"] > 0 > fits["go to window"]


@pytest.mark.skipif(not can_speak(), reason="Nothing here speaks: install the extra voice.")
def test_a_name_that_is_not_known_fits_worse_than_any_sounds() -> None:
    fits = learnt().weigh(spoken("go to the laboratory"))
    assert fits.keys() <= {f"go to {name}" for name in PLACE_NAMES}
    assert fits
    assert max(fits.values()) < 0


@pytest.mark.skipif(not can_speak(), reason="Nothing here speaks: install the extra voice.")
@pytest.mark.parametrize(("spoken_words", "ahead"), [("go to the kitchen", True), ("go to the chicken", False)])
def test_a_name_is_told_from_other_words(spoken_words: str, ahead: bool) -> None:
    over = learnt().over_words(spoken(spoken_words), "go to kitchen", ["go to the chicken", "go to the xqzkvr"])
    assert over.keys() == {"go to the chicken"}
    assert (over["go to the chicken"] > 0) is ahead


@pytest.mark.skipif(not can_speak(), reason="Nothing here speaks: install the extra voice.")
def test_words_that_were_told_from_a_name_are_no_names() -> None:
    opinion, sound = learnt(), spoken("go to the kitchen")
    before = opinion.weigh(sound, "go to workshop")
    opinion.over_words(sound, "go to kitchen", ["go to the violin", "go to the kitten"])
    assert opinion.weigh(sound, "go to workshop") == before


@pytest.mark.skipif(not can_speak(), reason="Nothing here speaks: install the extra voice.")
def test_a_name_that_was_not_said_is_followed_to_its_end() -> None:
    """Given up on the way it would be as unlikely as can be: -400 nats at one speed or both."""
    assert -240 < learnt().weigh(spoken("go to the laboratory"), "go to window")["go to window"] < 0


def test_a_name_that_nobody_can_pronounce_is_left_out() -> None:
    assert learnt().weigh(said("", np.zeros(RATE_HZ)), "go to xqzkvr").keys().isdisjoint({"go to xqzkvr"})


class Fixed:
    """An opinion that is always the same."""

    def __init__(self, fits: dict[str, float], over: dict[str, float] | None = None) -> None:
        self._fits, self._over = fits, over or {}

    def learn(self, own: OwnPhrases) -> None: ...

    def weigh(self, utterance: Utterance, also: str = "") -> dict[str, float]:
        return dict(self._fits)

    def over_words(self, utterance: Utterance, key: str, texts: Iterable[str]) -> dict[str, float]:
        return {text: self._over[text] for text in texts if text in self._over}


@pytest.mark.skipif(not can_speak(), reason="Nothing here speaks: install the extra voice.")
def test_a_name_whose_sound_does_not_fit_is_refused() -> None:
    whisper()
    found = find(MODEL)
    assert found is not None
    fits: dict[str, float] = {}
    recognizer = WhisperRecognizer(found.folder, phrases(), Fixed(fits))
    sound = spoken("go to the kitchen")
    for now, place in (({}, "kitchen"), ({"go to kitchen": 90.0}, "kitchen"), ({"go to kitchen": -390.0}, None)):
        fits.clear()
        fits.update(now)
        command = recognizer.decide(sound).command
        assert (None if command is None else command.place) == place


class Written(WhisperRecognizer):
    """A recognizer that reads usual words beside a name."""

    def __init__(self, names: Fixed) -> None:
        self._own, self._fixed, self._names, self._search = phrases(), {}, names, JointSearch.__new__(JointSearch)
        self._search.text = lambda columns: "Go to"
        self._search.by_chance = lambda texts: np.zeros(len(list(texts)))

    def keeps_bounds(self, name: Meaning, readings: list[Found], sound: float) -> bool:
        return self._fits_as_name(name, readings, (), sound, said("", np.zeros(RATE_HZ))) > 0


@pytest.mark.parametrize(
    ("over", "sound", "fits"),
    [
        ({}, -10.0, False),
        ({"go to the wind": 90.0}, -10.0, True),
        ({"go to the wind": -90.0}, 120.0, False),
        ({}, 120.0, True),
        ({"go to the wind": 90.0, "go to the winds": -5.0}, -10.0, False),
        ({"go to the wind": 90.0}, -110.0, False),
        ({"go to the winds": 90.0}, -10.0, False),
    ],
)
def test_a_name_is_heard_beside_usual_words_like_it_that_sound_otherwise(
    over: dict[str, float], sound: float, fits: bool
) -> None:
    texts = tuple(
        ScoredText(text=text, nats=nats)
        for text, nats in (("Go to the window.", -1.5), ("Go to the wind.", -2.5), ("Go to the winds.", -9.0))
    )
    name = Meaning(spelling="Go to the window.", nats=-1.5, again=-1.5, key=("go to window", (), False))
    readings = [Found(spellings=(), free=texts)] * 2
    assert Written(Fixed({}, over)).keeps_bounds(name, readings, sound) is fits


class Paced(Written):
    """A recognizer that finds these texts, each with its nats, by how many times as long a second of sound lasts."""

    def __init__(self, texts: dict[float, dict[str, float]]) -> None:
        super().__init__(Fixed({}))
        self._texts = texts

    def search(self, samples: Array, begun: tuple[int, ...] = ()) -> Found:
        texts = self._texts[round(len(samples) / RATE_HZ, 2)]
        found = tuple(ScoredText(text=text, nats=nats) for text, nats in texts.items())
        return Found(spellings=found, free=found)

    def best_readings(self, name: Meaning) -> tuple[Meaning, list[Found]] | None:
        first = [self.search(np.ones(round(pace * RATE_HZ))) for pace in (1.0, 1.1)]
        return self._best_readings(name, first, np.ones(RATE_HZ), (), ())


TO_WINDOW, TO_KITCHEN, TO_DOOR, TO_WIND = (
    f"Go to the {name}." for name in ("window", "kitchen", "green door", "wind")
)


@pytest.mark.parametrize(
    ("further", "nats"),
    [
        (({TO_WINDOW: -0.5}, {TO_WINDOW: -1.5, TO_DOOR: -3.0}), (-0.5, -1.5)),
        (({TO_WINDOW: -4.0}, {TO_WINDOW: -9.0}), (-4.0, -6.0)),
        (({TO_WINDOW: -0.5}, {TO_DOOR: -1.0}), (-0.5, -6.0)),
        (({TO_WINDOW: -0.5, TO_KITCHEN: -0.4}, {TO_WINDOW: -1.5}), (-0.5, -1.5)),
        (({TO_WINDOW: -0.5, TO_KITCHEN: -0.4}, {TO_WINDOW: -1.5, TO_KITCHEN: -1.0}), None),
        (({TO_WINDOW: -0.5}, {TO_WINDOW: -4.0, TO_WIND: -5.0}), (-0.5, -4.0)),
        (({TO_WINDOW: -0.5}, {TO_WINDOW: -4.0, TO_WIND: -3.0}), None),
    ],
)
def test_a_name_that_fits_badly_is_read_at_other_paces_and_most_have_to_agree(
    further: tuple[dict[str, float], ...], nats: tuple[float, float] | None
) -> None:
    texts = dict(zip((1.0, 1.1, *OTHER_PACES), ({TO_WINDOW: -6.0}, {TO_WINDOW: -7.0}, *further), strict=True))
    name = Meaning(spelling=TO_WINDOW, nats=-6.0, again=-7.0, key=("go to window", (), False))
    best = Paced(texts).best_readings(name)
    if best is None or nats is None:
        assert best is nats
        return
    assert (best[0].nats, best[0].again) == nats
    assert [next(one.nats for one in read.free if one.text == TO_WINDOW) for read in best[1]] == list(nats)


@cache
def learnt() -> SphinxNameOpinion:
    pytest.importorskip("pocketsphinx", reason="This needs pocketsphinx: pip install pocketsphinx")
    opinion = SphinxNameOpinion(SpeechSettings())
    opinion.learn(phrases())
    return opinion


def phrases() -> OwnPhrases:
    return place_phrases(NamedPlace(name=name, x_m=0.0, y_m=0.0) for name in PLACE_NAMES)


def spoken(words: str) -> Utterance:
    return said(words, padded(for_words(speak(words, VoiceSettings())).samples[:, 0]))


def said(_words: str, samples: Array) -> Utterance:
    sound = mono(samples)
    return Utterance(sound=sound, begin=sound.stamp + 0.3, end=sound.stamp + len(samples) / RATE_HZ)
