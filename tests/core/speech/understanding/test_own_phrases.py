"""Phrases of the user's own: they mean commands, and none may sound like another command."""

from pathlib import Path

import pytest

from core.commands.command import Command
from core.errors import BadInput
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import for_words
from core.speech.settings import SpeechSettings
from core.speech.synthesis import speak
from core.speech.transcription.transcriber import Transcriber
from core.speech.understanding.grammar import Refusal, understand
from core.speech.understanding.own_phrases import own_phrases, too_close
from tests.core.speech.ears import mono, padded, whisper

PHRASES = """
come_here = ["come to papa"]
continue = ["drive {distance_m} meters"]
stop_moving = ["halt"]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "phrases.toml"
    path.write_text(PHRASES)
    return path


def refused(file: Path, text: str) -> str:
    file.write_text(text)
    with pytest.raises(BadInput) as trouble:
        own_phrases(str(file))
    return str(trouble.value)


def test_own_phrases_are_commands_with_the_bounds_of_commands(file):
    own = own_phrases(str(file))
    papa, drive = understand("Come to Papa!", own=own), understand("drive two point five metres", own=own)
    assert isinstance(papa, Command) and papa.heard_as == "come here"
    assert isinstance(drive, Command) and drive.heard_as == "continue 2.5 meters"
    assert isinstance(understand("drive 6 meters", spoken=True, own=own), Refusal)
    assert isinstance(understand("come to papa"), Refusal)


@pytest.mark.parametrize(
    ("phrase", "other"),
    [
        ('turn_left = ["turn light"]', "turn right"),
        ('follow_me = ["come ear"]', "come here"),
        ('continue = ["stop {distance_m} meters"]', "always stops"),
        ('come_here = ["over yonder"]\nfollow_me = ["over younger"]', "over yonder"),
        ('stop_moving = ["come"]', "“come” (come_here)"),
        ('come_here = ["continue two meters"]', "continue {distance_m} meters"),
        ('continue = ["go {distance_m}"]', "“come” (come_here)"),
        ('stop_at = ["continue {x_m} and {y_m} meters"]', "continue {distance_m} meters"),
    ],
)
def test_a_phrase_that_sounds_like_another_command_is_refused_with_the_pair(file, phrase, other):
    assert other in refused(file, phrase)


@pytest.mark.parametrize(
    ("phrase", "why"),
    [
        ('come_here = ["halt here"]', "may want the robot to stop"),
        ('follow_me = ["please shop"]', "may want the robot to stop"),
        ('come_here = ["anhalten bitte"]', "may want the robot to stop"),
        ('come_here = ["emergency"]', "may want the robot to stop"),
        ('resume_route = ["wait no more"]', "may want the robot to stop"),
        ('come_here = ["hey you"]', "in all talk"),
        ('come_here = ["come"]', "in all talk"),
        ('continue = ["a {distance_m}"]', "in all talk"),
        ('turn_right = ["rotate to the left"]', "says “left”"),
        ('continue = ["back up {distance_m} meters"]', "says “back”"),
        ('follow_me = ["go away from me"]', "says “away”"),
        ('stop_at = ["drive x {y_m} and y {x_m}"]', "which stop_at does not do"),
        ('continue = ["move on for {distance_m} feet"]', "counts in “feet”"),
        ('continue = ["roll for {distance_m} seconds"]', "counts in “seconds”"),
        ('come_here = ["go to the kitchen"]', "begins with “go to”"),
        ('come_hre = ["come to papa"]', "did you mean come_here"),
    ],
)
def test_a_phrase_that_may_mean_something_else_than_its_command_is_refused(file, phrase, why):
    assert why in refused(file, phrase)


def test_a_home_that_is_not_there_has_a_sentence():
    with pytest.raises(BadInput, match="cannot be read"):
        own_phrases("~nobody-of-this-name/phrases.toml")


def test_phrases_of_the_documentation_and_of_words_with_a_silent_e_are_read(file):
    file.write_text(
        'come_here = ["papa", "over here please"]\n'
        'continue = ["drive {distance_m}", "forward by {distance_m} meters"]\n'
        'turn_left = ["rotate to the left"]\nfollow_wall = ["along the wall"]\nstop_moving = ["freeze", "basta"]'
    )
    assert len(own_phrases(str(file))) == 8


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("levitate = []", "no command"),
        ('start_route = ["off we go"]', "name of a route"),
        ("come_here = 3", "list of phrases"),
        ('come_here = ["Come, papa"]', "small ones"),
        ('come_here = ["a"]', "letters"),
        ('continue = ["drive on"]', "{distance_m}"),
        ('come_here = ["to {x_m} please"]', "no number"),
        ("come_here = [" + '"oh dear me", ' * 60 + "]", "more than"),
        ("come_here = [", "TOML"),
        ("[" * 5000, "TOML"),
        ("come_here = " + "[" * 5000, "TOML"),
        ("# " + "x" * 30_000, "too long"),
    ],
)
def test_a_file_that_is_no_list_of_phrases_has_a_sentence(file, text, why):
    assert why in refused(file, text)


def test_a_file_that_is_absent_or_no_text_has_a_sentence(file):
    file.write_bytes(b"\xff\xfe\x00")
    for path in (file, file.parent, file.with_name("none.toml")):
        with pytest.raises(BadInput, match=path.name):
            own_phrases(str(path))


def test_phrases_of_one_command_may_resemble_each_other(file):
    file.write_text('follow_wall = ["follow the walls", "along the wall"]')
    assert len(own_phrases(str(file))) == 2


def test_sounds_decide_not_letters():
    assert too_close("calm ear", "come here") and too_close("write hear", "right here")
    assert not too_close("come to papa", "come here") and not too_close("halt", "come")


@pytest.mark.parametrize(
    "words", ["advance", "forward", "go forward", "move ahead", "proceed", "carry on", "straight on", "keep going"]
)
def test_a_phrase_with_one_number_is_not_near_one_with_two(file, words):
    file.write_text(f'continue = ["{words} {{distance_m}} meters"]\nstop_at = ["reach {{x_m}} and {{y_m}} meters"]')
    assert len(own_phrases(str(file))) == 2


@pytest.mark.campaign
def test_own_phrases_are_heard(file):
    whisper()  # or it says why not
    settings = SpeechSettings(engine="whisper", phrases=str(file))
    ears = Transcriber(settings, recognizer=open_engine(settings).recognizer)
    for text, echo in (("come to papa", "come here"), ("turn left", "turn left")):
        heard = ears.feed(mono(padded(0.3 * for_words(speak(text)).samples[:, 0], 0.7, 1.2)))
        assert [one.decision.echo for one in heard if one.final] == [echo]
