"""Names of places: what they may be, that they are understood as they stand, and none sounds like other words."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.commands.command import Command
from core.commands.stop_at import TO_PLACE
from core.errors import BadInput
from core.navigation.places import NamedPlace
from core.speech.recognition.decision import Decision
from core.speech.recognition.recognizer import Utterance, for_words
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.synthesis import VoiceSettings, speak
from core.speech.transcription.transcriber import Transcriber
from core.speech.understanding.grammar import Refusal, understand
from core.speech.understanding.place_names import check_name_apart, place_phrases, spoken_name, tidy_name
from tests.core.speech.ears import mono, padded, whisper

NAMES = ("kitchen", "Anna's office", "room 12", "coffee machine", "window", "drop-off point")
PLACES = tuple(NamedPlace(name=name, x_m=7.0 + n, y_m=-n, heading_rad=0.5 * n) for n, name in enumerate(NAMES))
OWN = place_phrases(PLACES)


def understood(words: str, *, spoken: bool = True) -> Command | Refusal:
    return understand(words, spoken=spoken, own=OWN)


@given(st.sampled_from(PLACES), st.sampled_from(TO_PLACE), st.booleans(), st.sampled_from(("", ".", "!")))
def test_a_place_is_gone_to_by_its_name_however_far_it_is(
    place: NamedPlace, pattern: str, spoken: bool, end: str
) -> None:
    command = understood(pattern.format(name=place.name).capitalize() + end, spoken=spoken)
    assert isinstance(command, Command) and command.name == "stop_at" and command.place == place.name
    assert command.numbers == {"x_m": place.x_m, "y_m": place.y_m, "heading_rad": place.heading_rad}
    again = understood(command.heard_as)
    assert isinstance(again, Command) and again.place == place.name


@pytest.mark.parametrize(
    ("words", "place"),
    [
        ("go to the cof fee machine", "coffee machine"),
        ("stop at the coffeemachine.", "coffee machine"),
        ("Go to Annas office.", "Anna's office"),
        ("go to the drop off-point", "drop-off point"),
        ("go to the dropoff point", "drop-off point"),
    ],
)
def test_a_name_is_read_however_its_parts_are_written(words: str, place: str) -> None:
    command = understood(words)
    assert isinstance(command, Command) and command.place == place


def test_a_name_with_umlauts_or_accents_is_kept_and_read_in_plain_letters() -> None:
    assert (tidy_name("Küche"), tidy_name("Café am Weiß-Eck")) == ("Kueche", "Cafe am Weiss-Eck")
    kitchen = place_phrases((NamedPlace(name=tidy_name("Küche"), x_m=1.0, y_m=2.0, heading_rad=None),))
    for words in ("go to Küche", "go to the KÜCHE", "go to Ku\u0308che", "go to kueche"):
        command = understand(words, own=kitchen)
        assert isinstance(command, Command) and command.place == "Kueche", words


@pytest.mark.parametrize("words", ["go to room twelve", "stop at the room 12"])
def test_numbers_in_names_are_read_in_digits_and_in_words(words: str) -> None:
    command = understood(words)
    assert isinstance(command, Command) and command.place == "room 12"


@given(st.sampled_from(NAMES), st.sampled_from(("please {} now", "don't {}", "{} and then jump", "{}?", "{}...")))
def test_only_a_whole_utterance_goes_to_a_place(name: str, around: str) -> None:
    for pattern in TO_PLACE:
        words = around.format(pattern.format(name=name.lower()))
        command = understood(words)
        if "stop" in words:
            assert isinstance(command, Command) and command.name == "stop_moving"
        else:
            assert isinstance(command, Refusal)


def test_an_unknown_place_is_refused_with_those_that_it_may_be() -> None:
    refused = understood("go to the kichen")
    assert isinstance(refused, Refusal) and refused.suggestions[0] in {"go to kitchen", "go to the kitchen"}
    other = understood("go to the moon")
    assert isinstance(other, Refusal) and other.suggestions
    assert all(isinstance(understood(one), Command) for one in (*refused.suggestions, *other.suggestions))
    halted = understood("stop at the kichen")
    assert isinstance(halted, Command) and halted.name == "stop_moving"


def test_without_places_the_words_mean_what_they_meant() -> None:
    command = understood("go to 1 and 2")
    assert isinstance(command, Command) and not command.place and command.numbers == {"x_m": 1.0, "y_m": 2.0}
    nowhere = understand("go to kitchen")
    assert isinstance(nowhere, Refusal) and "No place has a name yet" in nowhere.reason
    assert isinstance(understand(nowhere.suggestions[0]), Command)
    assert isinstance(understood("stop at 9 and 9"), Command)  # beyond what may be spoken: it stops


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("bus stop", "always stops"),
        ("wait", "always stops"),
        ("123", "no number"),
        ("x", "3 to 40"),
        ("кухня", "from a to z"),
        ("a" * 41, "3 to 40"),
        ("kit_chen", "from a to z"),
    ],
)
def test_a_name_that_cannot_be_said_is_refused(name: str, why: str) -> None:
    with pytest.raises(BadInput, match=why):
        tidy_name(name)


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("back", "go back"),
        ("the wall", "follow the wall"),
        ("den", "ten"),
        ("fore", "four"),
        ("kitchens", "kitchen"),
        ("windows", "window"),
        ("winter", "window"),
        ("Annas office", "Anna's office"),
    ],
)
def test_a_name_that_sounds_like_other_words_is_refused_with_the_pair(name: str, other: str) -> None:
    with pytest.raises(BadInput, match=rf".*{other}.*sound too much alike"):
        check_name_apart(tidy_name(name), NAMES)


@pytest.mark.parametrize("name", ["door", "desk", "sofa", "bathroom", "stairs", "room 13", "library", "garden"])
def test_common_names_stand_side_by_side(name: str) -> None:
    check_name_apart(tidy_name(f"the  {name}"), NAMES)
    assert spoken_name("Room 12") == "room twelve"


def test_names_are_heard_as_soon_as_they_are_learnt_and_no_longer_when_they_are_gone() -> None:
    recognizer = whisper()
    recognizer.learn(OWN)

    def hears(text: str, voice: str = "en-us") -> Decision:
        ears = Transcriber(SpeechSettings(engine="whisper"), recognizer=recognizer)
        sound = for_words(speak(text, VoiceSettings(voice=voice)))
        heard = ears.feed(mono(padded(0.3 * sound.samples[:, 0], 0.7, 1.2)))
        return next(one.decision for one in heard if one.final)

    going = hears("go to the window")
    assert going.command is not None and going.command.place == "window" and going.waits
    for voice in ("en-gb-scotland", "en-us-nyc"):
        going = hears("go to Anna's office", voice)
        assert going.command is not None and going.command.place == "Anna's office"
    assert hears("go to the chicken").command is None and hears("go to the market").command is None
    recognizer.learn(())
    assert hears("go to the window").command is None


def test_a_name_that_is_not_on_the_map_is_refused_however_near_another_one_sounds() -> None:
    """As "go to the bedroom" went to the bathroom: its word was not among those that are written."""
    recognizer = whisper()
    recognizer.learn(place_phrases([*PLACES, NamedPlace(name="bathroom", x_m=1.0, y_m=1.0)]))

    def hears(text: str, voice: str) -> Decision:
        sound = for_words(speak(text, VoiceSettings(voice=voice, speed=175))).samples[:, 0]
        samples = padded(sound)
        return recognizer.decide(Utterance(sound=mono(samples), begin=0.0, end=len(samples) / RATE_HZ))

    try:
        for voice in ("en-us", "en-gb-x-rp", "en-029"):
            told = hears("go to the bedroom", voice)
            assert told.command is None and "bedroom" in told.reason and "no place" in told.reason
            assert told.words.lower() == "go to the bedroom" and set(told.did_you_mean) <= {"go to bathroom"}
            known = hears("go to the bathroom", voice)
            assert known.command is not None and known.command.place == "bathroom" and known.waits
    finally:
        recognizer.learn(())


@pytest.mark.parametrize(
    "name",
    ["ten", "one and two", "minus one and two", "three point five and 2", "twenty and thirty", "Zero and zero"],
)
def test_a_name_that_is_read_as_metres_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match="no number and no point"):
        check_name_apart(tidy_name(name), NAMES)
