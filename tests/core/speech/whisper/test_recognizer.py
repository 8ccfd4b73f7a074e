"""Whisper against the grammar: people are understood, talk is not obeyed, and no sound is too short."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from scipy.special import erf

from core.commands.routes import RESUME_ROUTE
from core.heap import give_back
from core.message import Array
from core.navigation.places import NamedPlace
from core.recording.sound_file import read_sound
from core.speech.recognition.decision import MORE_SAID, NO_COMMAND, OBJECTIONS, Decision, Sentence
from core.speech.recognition.endpointing import voiced
from core.speech.recognition.recognizer import Utterance, for_words
from core.speech.settings import RATE_HZ
from core.speech.synthesis import VoiceSettings, speak
from core.speech.understanding.place_names import place_phrases
from core.speech.whisper.joint_search import Found, JointSearch, ScoredText
from core.speech.whisper.keyword_spotting import WhisperKeywordSpotter
from core.speech.whisper.log_mel import filters, log_mel
from core.speech.whisper.recognizer import COMMON_BOUNDS, MIN_RIGHT_PROBABILITY, RARE_BOUNDS, WhisperRecognizer
from core.speech.whisper.transformer import Decoding, gelu
from tests.core.speech.ears import mono, padded, pieces, whisper


def utterance(samples: Array, *, cut: bool = False, rejected: tuple[str, ...] = ()) -> Utterance:
    return Utterance(sound=mono(samples), begin=0.0, end=len(samples) / RATE_HZ, cut=cut, rejected=rejected)


def clip(folder: Path, name: str) -> Array:
    return for_words(read_sound(folder / name)).samples[:, 0]


class Searched(WhisperRecognizer):
    """A recognizer whose search has found these texts."""

    def __init__(
        self, spellings: dict[str, float], free: dict[str, float], slower: dict[str, float] | None = None
    ) -> None:
        """`slower`: the spellings of a longer sound; None: the same."""
        self._own, self._fixed, self._decimals = (), {}, np.zeros(10)
        self._slower = slower
        self._found = Found(
            spellings=tuple(ScoredText(text=text, nats=nats) for text, nats in spellings.items()),
            free=tuple(ScoredText(text=text, nats=nats) for text, nats in free.items()),
        )

    def search(self, samples: Array, begun: tuple[int, ...] = ()) -> Found:
        if self._slower is None or len(samples) <= RATE_HZ:
            return self._found
        assert len(samples) == pytest.approx(1.1 * RATE_HZ)
        texts = tuple(ScoredText(text=text, nats=nats) for text, nats in self._slower.items())
        return Found(spellings=texts, free=())


def decided(
    spellings: dict[str, float], free: dict[str, float], *, cut: bool = False, rejected: str = ""
) -> Decision:
    return Searched(spellings, free).decide(
        utterance(np.ones(RATE_HZ), cut=cut, rejected=(rejected,) if rejected else ())
    )


def test_the_mel_filters_have_equal_area_and_cover_the_band():
    areas = filters().sum(1) * RATE_HZ / 400
    assert areas[10:] == pytest.approx(1.0, abs=0.25)
    assert (filters()[:, 2:-1].sum(0) > 0).all()


def test_the_spectrogram_has_three_seconds_of_silence_behind_the_sound():
    mel = log_mel(0.1 * np.sin(np.arange(RATE_HZ)))
    assert mel.shape == (80, 500)
    assert (mel[:, -300:] == mel.min()).all()


def test_the_activation_is_x_times_the_normal_distribution():
    x = np.linspace(-9, 9, 10_001).astype(np.float32)
    exact = 0.5 * x.astype(float) * (1 + erf(x.astype(float) / np.sqrt(2)))
    assert np.abs(gelu(x) - exact).max() < 5e-7


def test_a_sentence_that_is_written_again_and_again_is_given_up(monkeypatch):
    """As Whisper does it for little sound; without that it took fifteen steps."""
    reader, steps, advance = whisper(), [], Decoding.advance
    monkeypatch.setattr(Decoding, "advance", lambda self, *row: steps.append(row) or advance(self, *row))
    samples = for_words(speak("turn left", VoiceSettings(voice="en-us"))).samples[:, 0]
    found = reader.search(np.concatenate((np.zeros(RATE_HZ // 5), samples)))
    assert found.free[0].text == found.spellings[0].text == "Turn left"
    assert len(steps) <= 6


def test_spellings_of_one_meaning_count_together():
    recognizer = Searched({"turn left": -2.0, "Turn left.": -2.0, "turn right": -9.0}, {})
    best, second = recognizer.meanings(recognizer.search(np.zeros(0)))
    assert best.nats == pytest.approx(-2.0 + np.log(2)) and second.spelling == "turn right"


def test_numbers_may_be_further_behind_free_text_than_other_words():
    assert decided({"continue two meters": -6.0}, {"Continue to meters.": -3.0}).echo == "continue 2 meters"
    assert decided({"come here": -5.5}, {"come here often": -2.5}).command is None


def test_what_is_refused_is_said_back_and_what_resembles_it_is_offered():
    told = decided({"continue 5 meters": -6.0, "continue 9 meters": -8.0}, {"Continue by meters.": -1.0})
    assert told.command is None and "I heard “Continue by meters”." in told.reason
    assert told.did_you_mean == ("continue 5 meters",)


@pytest.mark.parametrize(("lead", "verdict"), [(0.5, "reject"), (1.0, "reject"), (1.1, "confirm"), (2.5, "accept")])
def test_a_small_lead_over_other_numbers_is_rejected_or_confirmed(lead, verdict):
    assert decided({"continue 2 meters": -1.0, "continue 3 meters": -1.0 - lead}, {}).verdict == verdict


@pytest.mark.parametrize(
    ("slower", "verdict"),
    [
        ({"continue 2.5 meters": -1.0, "continue 1.5 meters": -4.4}, "accept"),
        ({"continue 2.5 meters": -1.0, "continue 1.5 meters": -2.3}, "confirm"),
        ({"continue 2.5 meters": -1.0, "continue 1.5 meters": -1.9}, "reject"),
        ({"continue 2.5 meters": -1.0}, "reject"),
        ({"continue 2.5 meters": -1.0, "turn left": -4.0}, "accept"),
        ({"continue 1.5 meters": -1.0, "continue 2.5 meters": -4.4}, "reject"),
        ({}, "reject"),
    ],
)
def test_a_number_is_read_twice_and_believed_as_far_as_the_slower_speech_agrees(slower, verdict):
    heard = utterance(np.ones(RATE_HZ))
    spellings = {"continue 2.5 meters": -1.0, "continue 1.5 meters": -5.0}
    told = Searched(spellings, {}, slower).decide(heard)
    assert told.verdict == verdict
    assert told.command is None or told.echo == "continue 2.5 meters"


def test_two_readings_that_differ_move_nothing():
    slower = {"continue 2.5 meters": -1.0, "continue 1.5 meters": -6.0}
    told = Searched({"continue 1.5 meters": -1.0, "continue 2.5 meters": -1.2}, {}, slower).decide(
        utterance(np.ones(RATE_HZ))
    )
    assert told.verdict == "reject" and set(told.did_you_mean) == {"continue 2.5 meters", "continue 1.5 meters"}


@pytest.mark.parametrize(
    ("slower", "free", "goes"),
    [({"Come.": -1.0}, {"Camel.": -9.0}, True), ({}, {}, False), ({"Come.": -4.0}, {"Camel.": -1.0}, False)],
)
def test_one_word_that_moves_the_robot_must_be_heard_in_slower_speech_too(slower, free, goes):
    class Slower(Searched):
        def search(self, samples):
            if len(samples) <= RATE_HZ:
                return self._found
            return Searched(slower, free)._found

    told = Slower({"Come.": -1.0}, {"Camel.": -9.0}).decide(utterance(np.ones(RATE_HZ)))
    assert (told.command is not None) is goes and told.waits is goes


@pytest.mark.parametrize(
    ("words", "text", "goes"),
    [
        ("Turn right.", "Do not turn right.", False),
        ("Turn right.", "Turn right as rain", False),
        ("Turn right.", "- Turn right!", True),
        ("Turn right.", "Return right.", True),
        ("Come here.", "They come here.", False),
        ("Stop.", "Do not stop.", True),
    ],
)
def test_free_text_with_more_words_than_a_motion_is_against_it_and_never_against_a_stop(words, text, goes):
    told = decided({words: -3.0}, {text: -3.5})
    assert (told.command is not None) is goes
    assert goes or told.reason == OBJECTIONS[MORE_SAID](words=told.words)
    assert decided({words: -3.0}, {text: -4.5}).command is not None


def spoken(words: str, voice: str, pace: int, begin: float = 0.0) -> Utterance:
    """Words of a synthetic voice at `pace` [words/min], with when they were said, from `begin` [s]."""
    samples = padded(for_words(speak(words, VoiceSettings(voice=voice, speed=pace))).samples[:, 0])
    first, last = voiced(samples)
    return Utterance(sound=mono(samples, begin), begin=begin + first, end=begin + last)


@pytest.mark.parametrize(
    ("words", "voice", "pace", "goes"),
    [
        ("turn right handed", "en-gb-x-gbclan", 175, False),
        ("follow meticulously", "en-gb-x-gbcwmd", 245, False),
        ("turn left", "en-us+f2", 122, True),
        ("follow me", "en-gb-x-gbcwmd", 245, True),
    ],
)
def test_a_motion_that_half_the_voice_would_be_too_is_talk_however_fast_it_is_said(words, voice, pace, goes):
    told = whisper().decide(spoken(words, voice, pace))
    assert (told.command is not None) is goes
    assert goes or told.reason == OBJECTIONS[MORE_SAID](words=told.words)


def test_a_holiday_does_not_resume_a_route_until_it_is_said_again():
    recognizer = whisper()
    recognizer.learn(place_phrases([NamedPlace(name="round", x_m=0.0, y_m=0.0, route=True)]))
    try:
        begins = (100.0, 100.0, 120.0, 124.0)  # the second reads the first once more; the third comes late
        told = [recognizer.decide(spoken("go on holiday", "en-us+m2", 175, begin)) for begin in begins]
        assert [one.reason for one in told[:3]] == 3 * [OBJECTIONS[MORE_SAID](words="go on")]
        assert told[3].command is not None and told[3].command.name == RESUME_ROUTE.name
        alone = recognizer.decide(spoken("go on", "en-us+m2", 175, 200.0))
        assert alone.command is not None and alone.command.name == RESUME_ROUTE.name
    finally:
        recognizer.learn(())


def test_the_confidence_in_a_number_is_the_probability_that_it_is_right():
    """0.77 at a lead that is refused, 0.97 at 2.6 nats, and no more than 0.995 whatever the lead is."""
    told = [decided({"continue 2 meters": -1.0, "continue 3 meters": -1.0 - lead}, {}) for lead in (0.9, 2.6, 9.0)]
    assert [one.confidence for one in told] == pytest.approx([0.771, 0.971, 0.9955], abs=1e-3)
    assert [one.command is None for one in told] == [one.confidence < MIN_RIGHT_PROBABILITY for one in told]


def test_what_is_clear_is_read_only_once():
    class Once(Searched):
        def search(self, samples):
            assert len(samples) <= RATE_HZ
            return super().search(samples)

    heard = utterance(np.ones(RATE_HZ))
    assert Once({"turn left": -1.0, "turn right": -3.1}, {}).decide(heard).verdict == "accept"


def test_numbers_beyond_the_bounds_of_speech_win_and_are_refused():
    assert decided({"continue 7 meters": -1.0, "continue 5 meters": -4.0}, {}).verdict == "reject"


@pytest.mark.parametrize("words", ["continue 1.2.3 meters", "continue one point two five five meters"])
def test_a_number_with_two_points_or_three_decimals_is_not_cut(words):
    """As one "continue one point two point three meters" became 1.3, and "zero point zero zero five" 0.05."""
    told = decided({words: -1.0, "continue 1.25 meters": -4.0}, {})
    assert told.command is None and "one point, and two digits behind it at most" in told.reason
    assert decided({"continue 1.25 meters": -1.0, words: -1.5}, {}).command is None
    assert decided({"continue 1.25 meters": -1.0, words: -4.0}, {}).command is not None


def test_numbers_that_are_none_are_heard_as_such():
    reader = whisper()
    for number in ("one point two point three", "one point five five five", "zero point zero zero five"):
        for voice, pitch in (("en-us", 10), ("en-029", 10), ("en-gb-x-rp", 90)):
            sound = speak(f"continue {number} meters", VoiceSettings(voice=voice, pitch=pitch, speed=175))
            assert reader.decide(utterance(padded(for_words(sound).samples[:, 0]))).command is None


def test_a_number_without_its_whole_part_never_moves_the_robot():
    told = decided({"continue .3 meters": -0.5, "continue 4.3 meters": -6.0}, {})
    assert told.verdict == "reject" and "whole number" in told.reason
    assert decided({"continue .3 meters": -0.5, "continue 4.3 meters": -3.0}, {}).verdict == "reject"


@pytest.mark.parametrize(
    ("spellings", "echo", "verdict"),
    [
        ({"stop at 0.8 and 0.4": -2.9, "stop at 0.8 and 2.4": -3.1}, "stop at 0.8 and 2.4", "confirm"),
        ({"stop at 0.8 and 0.4": -2.9, "stop at 0.8 and 2.4": -5.3}, "stop moving", "accept"),
        ({"stop at 0.8 and 0.4": -2.9, "stop at 0.8 and 2.4": -5.6}, "stop at 0.8 and 0.4", "confirm"),
        ({"continue 2.4 meters": -2.9, "continue 0.4 meters": -3.0}, "continue 2.4 meters", "confirm"),
        ({"continue 2 meters": -2.9, "continue 22 meters": -5.3}, "", "reject"),
        ({"continue 2 meters": -2.9, "continue 12 meters": -5.3}, "continue 2 meters", "accept"),
        ({"continue 1.5 meters": -2.9, "continue 1.25 meters": -4.0}, "", "reject"),
        ({"continue 1.2 meters": -2.9, "continue 1.25 meters": -5.6}, "continue 1.2 meters", "confirm"),
        ({"continue 1.25 meters": -2.9, "continue 1.5 meters": -4.8}, "continue 1.25 meters", "accept"),
        ({"continue 0.7 meters": -2.9, "continue 0.07 meters": -4.2}, "", "reject"),
        ({"continue 1.3 meters": -2.9, "continue 1.25 meters": -4.2}, "continue 1.3 meters", "confirm"),
    ],
)
def test_a_number_is_doubted_where_words_of_another_may_not_have_been_heard(spellings, echo, verdict):
    told = decided(spellings, {})
    assert (told.command.heard_as if told.command else "", told.verdict) == (echo, verdict)


@pytest.mark.parametrize(
    ("free", "moves"),
    [
        ({"Stop at 1 and 9 3.": -3.3}, False),  # "one and minus three" among other talk
        ({"Stop at 1 and 9 3.": -4.6}, False),
        ({"Stop at 1 and 9 3.": -5.0}, True),
        ({"Stop at one and three there.": -3.3}, True),
        ({"Stop at 1.0 and 3": -3.3}, True),  # the same in other words
    ],
)
def test_numbers_with_fewer_digits_than_the_free_text_move_nothing(free, moves):
    told = decided({"Stop at 1 and 3.": -3.75, "Stop": -10.6}, free)
    assert told.stops is not moves and (told.echo == "stop at 1 and 3") is moves


@pytest.mark.parametrize(
    "free",
    [
        *("Continue two meters and a half.", "Continue 2 meters and 3/4", "Continue 2½ m"),
        *("Continue 2 meters to the left.", "Continue 2 meters backwards", "Continue 2 feet", "less than two meters"),
    ],
)
def test_a_number_without_the_rest_of_the_length_in_the_free_text_moves_nothing(free):
    assert decided({"Continue 2 meters.": -3.0}, {free: -2.5}).command is None
    assert decided({"Continue 2.5 meters.": -3.0}, {"Continue two and a half meters.": -2.5}).command is not None


@pytest.mark.parametrize("free", ["Continue second meter.", "Continue the 2nd meter", "Continue to 2 meters."])
def test_a_number_beside_another_kind_of_number_in_the_free_text_moves_nothing(free):
    told = decided({"Continue 2 meters.": -5.0}, {free: -2.5})
    assert told.command is None
    assert decided({"Continue 2 meters.": -5.0}, {"Continue to meters.": -2.5}).command is not None


def test_free_text_that_sounds_otherwise_than_a_number_is_against_it():
    heard = {"Continue 2 meters.": -5.0}
    assert decided(heard, {"Continue to meters.": -1.5}).command is not None
    assert decided(heard, {"Continue after meters.": -2.5}).command is None
    assert decided({"Continue half a meter.": -6.0}, {"Continue half a meter and half.": -3.0}).command is None


@pytest.mark.parametrize(
    ("words", "moves"), [("one centimeters", False), ("10 centimeters", True), ("0 meters", False)]
)
def test_a_length_too_short_to_be_meant_moves_nothing(words, moves):
    assert (decided({f"Continue {words}.": -2.0}, {}).command is not None) is moves


def test_a_number_below_one_that_is_little_likelier_than_one_above_only_stops():
    """As a voice from the West Midlands says "stop at 0.8 and 2.4"."""
    assert decided({"stop at 0.8 and 0.4": -4.4, "stop at 0.8 and 2.4": -6.8}, {}).stops


def test_digits_that_are_written_often_are_no_likelier_for_it():
    known = Searched({"continue 1.5 meters": -3.0, "continue 1.9 meters": -2.4}, {})
    assert known.decide(utterance(np.ones(RATE_HZ))).verdict == "reject"
    known._decimals = whisper()._decimals
    assert known.decide(utterance(np.ones(RATE_HZ))).echo == "continue 1.9 meters"
    found = known.meanings(Found(spellings=(ScoredText(text="stop at 1.25 and 2", nats=-3.0),), free=()))
    assert found[0].by_chance == 0.0


def test_zeros_behind_the_point_and_repeated_decimals_are_doubted():
    assert decided({"continue 3.2 meters": -2.4, "continue 3.0 meters": -2.4}, {}).echo == "continue 3.2 meters"
    assert decided({"continue 3.0 meters": -2.4, "continue 3.2 meters": -6.0}, {}).echo == "continue 3 meters"
    assert decided({"continue 0.77 meters": -2.4, "continue 0.7 meters": -2.9}, {}).verdict == "reject"
    twice_or_thrice = decided({"continue 0.77 meters": -2.4, "continue 0.7 meters": -6.0}, {})
    assert (twice_or_thrice.verdict, twice_or_thrice.offered) == (
        "reject",
        ("continue 0.77 meters", "continue 0.7 meters"),
    )
    assert decided({"continue 1.05 meters": -2.4, "continue 1.25 meters": -2.9}, {}).verdict == "reject"


def test_a_word_that_is_written_for_another_is_confirmed():
    told = decided({"Follow the world.": -1.5}, {"Follow the world.": -1.5, "Far over the world": -6.0})
    assert (told.echo, told.verdict) == ("follow wall", "confirm")


def test_what_a_room_makes_of_words_is_confirmed_where_nothing_else_is_nearly_as_likely():
    told = decided({"Father woe": -2.5}, {"Father Woe": -2.5, "Father Whoa": -4.4})
    assert (told.echo, told.verdict) == ("follow wall", "confirm")
    assert decided({"Father woe": -4.0}, {"Father Wolf": -3.2}).verdict == "reject"
    assert decided({"Father me": -2.5}, {"Father me": -2.5}).command is None


def test_words_that_are_rarely_said_may_be_further_behind_free_text_and_are_confirmed_there():
    known = Searched({"follow the wall": -6.0}, {"follow them world": -4.0})
    known._fixed = {"follow_wall": RARE_BOUNDS}
    assert known.decide(utterance(np.ones(RATE_HZ))).verdict == "confirm"
    assert decided({"follow the wall": -6.0}, {"follow them world": -4.0}).verdict == "reject"


def test_a_pause_of_a_route_is_as_easily_heard_as_a_stop():
    """In echoes "pause the route" is written "pass the route"; it moves nothing."""
    known = Searched({"Pause the route.": -5.0}, {"Pass the route": -2.7})
    known._own = place_phrases([NamedPlace(name="round", x_m=0.0, y_m=0.0, route=True)])
    known._search = JointSearch.__new__(JointSearch)
    known._search.begin_of = lambda *_: ()
    told = known.decide(utterance(np.ones(RATE_HZ)))
    assert told.command is not None and told.command.name == "pause_route"


def test_what_people_say_often_has_narrow_bounds():
    bounds = whisper()._fixed
    assert all(
        bounds[name].behind_free == pytest.approx(COMMON_BOUNDS.behind_free) for name in ("come_here", "follow_me")
    )
    assert bounds["turn_left"].behind_free > 2 and bounds["follow_wall"].behind_free > 2


def test_a_command_that_was_rejected_just_before_is_less_likely():
    both = {"continue 2 meters": -1.0, "continue 3 meters": -3.0}
    assert decided(both, {}).echo == "continue 2 meters"
    assert decided(both, {}, rejected="continue 2 meters").echo == "continue 3 meters"


@pytest.mark.parametrize(
    ("spellings", "free", "stops"),
    [
        ({}, "please stop it", True),
        ({"start": -5.8}, "Let's start moving.", True),
        ({"start": -1.0}, "start", False),
        ({"turn left": -1.0}, "stop", True),
        ({"stop at 2 and 1": -1.0}, "Stop at two and one.", False),
        ({"stop at 2 and 1": -30.0}, "stop at home", True),
        ({"stop at 9 and 1": -1.0}, "stop at nine and one", True),
        ({}, "nonstop flights", False),
        ({}, "Wait, wait!", True),
        ({"come here": -2.5}, "No.", True),
        ({"halt": -3.0}, "Alt.", True),
        ({"Cancel": -5.2}, "Council.", True),
        ({"Wait.": -5.8}, "8", False),
        ({}, "Wait for the bus.", False),
    ],
)
def test_the_word_stop_in_free_text_stops_unless_a_whole_place_was_understood(spellings, free, stops):
    assert decided(spellings, {free: -2.0}).stops is stops


def test_what_is_offered_for_words_keeps_their_number_and_is_stop_where_that_may_be_meant():
    heard = {"continue 3 meters": -6.5}
    assert decided(heard, {"Continue 3 inches.": -1.0}).did_you_mean == ()
    assert decided(heard, {"Continue to 3 meters.": -1.0}).did_you_mean == ("continue 3 meters",)
    assert decided({"turn left": -6.5}, {"Don't turn left.": -1.0}).did_you_mean == ()


@pytest.mark.parametrize(
    "sound", ["(wind howling)", "[Music]", " (coughs) (laughs).", "*sighs*", "♪ ♪", "...", "[ Pause ]"]
)
def test_what_is_written_for_a_noise_are_no_words(sound):
    told = decided({"stop moving": -9.0}, {sound: -2.0})
    assert told.command is None and not told.stops and told.words == "" and told.did_you_mean == ()


def test_words_beside_a_noise_and_stop_in_brackets_are_words():
    assert decided({}, {"(wind howling) sing a song": -2.0}).heard
    assert decided({}, {"(stop)": -2.0}).stops


def test_what_was_cut_off_moves_nothing():
    assert decided({"continue 2 meters": -1.0}, {}, cut=True).verdict == "reject"


@pytest.mark.parametrize(
    ("length", "kinds"),
    [
        *zip((0, 1, 160, 199, 400, 1601), ((0,), (1,), (2,), (1,), (2,), (1,)), strict=True),
        *(
            pytest.param(length, range(3), marks=pytest.mark.campaign)
            for length in (0, 1, 159, 160, 199, 200, 399, 400, 1599, 1600, 1601, 4000)
        ),
    ],
)
def test_sounds_of_every_length_are_read(length, kinds):
    noise = 0.3 * np.random.default_rng(length).normal(size=length)
    for kind in kinds:
        samples = (np.zeros(length), noise, np.ones(length))[kind]
        assert whisper().decide(utterance(samples)).command is None


@pytest.mark.campaign  # words at the end of one are read in test_word_times
def test_a_sound_longer_than_the_model_knows_is_read():
    assert (
        whisper().decide(utterance(0.01 * np.random.default_rng(0).normal(size=45 * RATE_HZ), cut=True)).command
        is None
    )


@pytest.mark.real_data
@pytest.mark.parametrize("every", [60, pytest.param(12, marks=pytest.mark.campaign)])
def test_human_digits_are_understood_and_no_other_number_is_obeyed(shared_data, every):
    folder = shared_data / "speech_human_digits"
    rows = [line.split("\t") for line in (folder / "index.tsv").read_text().splitlines()[1:]]
    right = wrong = wanted = 0
    for name, _, text in [row for row in rows if row[1].startswith("digit")][::every]:
        decision, meant = whisper().decide(utterance(clip(folder, name))), Sentence(text).spoken
        numbers = dict(getattr(meant, "numbers", {}))
        obeyed = decision.command is not None and not decision.stops
        wanted += bool(numbers)
        right += obeyed and dict(decision.command.numbers) == numbers
        wrong += obeyed and dict(decision.command.numbers) != numbers
    assert wanted >= 120 / every and right >= 0.8 * wanted and wrong == 0


@pytest.mark.real_data
@pytest.mark.parametrize(
    "name",
    [
        "goforward",
        "cards_001",
        *(
            pytest.param(name, marks=pytest.mark.campaign)
            for name in ("something", "librivox_0880", "harvard_spk1_1", "harvard_spk1_4")
        ),
    ],
)
def test_real_speech_that_is_no_command_moves_nothing(shared_data, name):
    folder = shared_data / "speech_real"
    decision = whisper().decide(utterance(clip(folder, f"{name}.flac")))
    assert decision.command is None


@pytest.mark.real_data
@pytest.mark.parametrize("most", [1, pytest.param(None, marks=pytest.mark.campaign)])
def test_without_pocketsphinx_stop_is_spotted_before_the_sentence_is_over(shared_data, most):
    spotter = WhisperKeywordSpotter(whisper())
    samples = padded(clip(shared_data / "speech_commands_tts", "flite_slt_20.flac"))  # stop at three point two and …
    told = [*islice((one for piece in pieces(samples) for one in spotter.feed(piece)), most)]
    assert told and all(one.decision.stops and not one.final for one in told)
    assert told[0].end < len(samples) / RATE_HZ - 1.5


@pytest.mark.parametrize("text", [">>", "You", " you.", "[Music]"])
def test_what_whisper_writes_for_noise_is_not_said_back(text):
    assert decided({}, {text: -1.0}).reason == NO_COMMAND


def test_after_a_rest_the_same_is_read_and_meanwhile_the_memory_is_free() -> None:
    recognizer = whisper()
    samples = 0.05 * np.random.default_rng(1).normal(size=RATE_HZ)
    before = recognizer.search(samples)
    awake = anonymous_mb()
    recognizer.rest()
    give_back()
    resting = anonymous_mb()
    assert resting < awake - 40
    after = recognizer.search(samples)
    assert after.free_text == before.free_text
    assert [one.nats for one in after.free] == [one.nats for one in before.free]


def anonymous_mb() -> float:
    """Memory of this process that is not a file's."""
    lines = Path("/proc/self/smaps_rollup").read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith("Anonymous:")) / 1024
