"""What the pilot's ears tell of a voice, whichever way the robot stands."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.commands.command import Command
from core.geometry import Pose
from core.message import Array
from core.perception.people.voice_bearing import likeliest
from core.perception.sound.direction import unit
from core.perception.sound.settings import DirectionFindingSettings
from core.pilot import Pilot
from core.pilot.sound_perception import SILENCE_DB, SoundPerception
from core.robots import Profile
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound
from core.simulation.acoustics.shoebox import diffuse_noise, plane_waves
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.estimate import Estimate
from core.snapshot import Hearing, VoiceDirection
from core.speech.practice_voice import practice_voice
from core.speech.understanding.grammar import understand
from tests.core.perception.voices import RATE, far_voice

UPRIGHT = MicrophoneArray(positions=RESPEAKER_ODAS.positions[:, [0, 2, 1]], name="upright")


def ears_with(array: MicrophoneArray) -> SoundPerception:
    return SoundPerception(Profile(name="ears", url="sim:ears", arrays=(array,)), DirectionFindingSettings())


def standing(heading: float) -> Estimate:
    return Estimate(pose=Pose(heading=heading), covariance=1e-6 * np.eye(3))


def hear(ears: SoundPerception, sound: Sound, heading: float) -> Hearing:
    """The next piece of sound, to a robot that stands."""
    stamp = sound.stamp + sound.duration
    ears.listen(sound, stamp)
    told = ears.hear(stamp, standing(heading))
    assert told is not None
    return told


def heard(array: MicrophoneArray, heading: float, azimuth: float, elevation: float) -> VoiceDirection:
    """A voice from there, seen from the robot, in frames of a 20th of a second."""
    ears, voices = ears_with(array), ()
    for piece in far_voice(array, azimuth, elevation, duration=1.5).pieces(0.05):
        voices = hear(ears, piece, heading).voices or voices
    (voice,) = voices
    return voice


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
def test_a_level_array_never_offers_its_own_direction_as_another(heading: float) -> None:
    voice = heard(RESPEAKER_ODAS, heading, -0.54, 0.5)
    assert voice.azimuth == pytest.approx(-0.54, abs=0.05)
    assert "may as well" not in voice.ambiguity and "elevation" in voice.ambiguity


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
def test_the_other_side_of_an_upright_array_is_told_from_where_the_robot_stands(heading: float) -> None:
    voice = heard(UPRIGHT, heading, 0.7, 0.1)
    other = "left" if voice.azimuth < 0 else "right"
    assert abs(voice.azimuth) == pytest.approx(0.7, abs=0.05)
    assert voice.ambiguity == f"The array is flat: the sound may as well come from 40° to the {other}."


@pytest.mark.parametrize("number", [math.nan, math.inf, 1e200])
def test_samples_that_are_no_numbers_are_no_level(number: float) -> None:
    ears = ears_with(RESPEAKER_ODAS)
    spoilt: Array = np.full((800, 4), number)
    told = hear(ears, Sound(stamp=0.0, rate=RATE, samples=spoilt), 0.0)
    assert told.level_db == SILENCE_DB and "no numbers" in ears.trouble
    told = hear(ears, Sound(stamp=0.05, rate=RATE, samples=np.full((800, 4), 0.1)), 0.0)
    assert told.level_db == pytest.approx(-20.0, abs=0.1) and ears.trouble == ""


@pytest.mark.parametrize("other_first", [True, False], ids=["ends into the words", "begins in the words"])
def test_words_are_the_caller_s_though_someone_else_talks_into_them(other_first: bool) -> None:
    words, talk = (
        plane_waves(voice[None], unit(azimuth, 0.4)[None], RESPEAKER_ODAS.positions, RATE)
        for voice, azimuth in (
            (practice_voice(np.random.default_rng(1), 0.7, RATE), 0.5),
            (practice_voice(np.random.default_rng(2), 1.2, RATE), -1.4),
        )
    )
    first, last = (words, talk) if not other_first else (talk, words)
    begin = 1.0 + len(first) / RATE - 0.25  # of the second to talk: a quarter of a second of both
    samples = 0.01 * diffuse_noise(np.random.default_rng(3), RESPEAKER_ODAS.positions, 4 * RATE, RATE)
    for sound, since in ((first, 1.0), (last, begin)):
        samples[round(since * RATE) :][: len(sound)] += sound
    ears = ears_with(RESPEAKER_ODAS)
    for piece in Sound(stamp=0.0, rate=RATE, samples=0.05 * samples).pieces(0.05):
        hear(ears, piece, 0.3)
    said = begin if other_first else 1.0
    heard = ears.heard_in(said, said + 0.7)
    assert {one.stamp for one in heard} <= {said + 0.7, said + 0.35, said / 4 + 3 * (said + 0.7) / 4}
    assert likeliest(heard)[0].azimuth == pytest.approx(0.5 + 0.3, abs=0.25)
    assert ears.heard_in(-1.0, -0.5) == ()


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        (lambda one: one, ""),
        (lambda one: one[:, [1, 0, 2, 3]], "exchanged"),
        (lambda one: np.column_stack((one.mean(1), one[:, :-1])), "processed"),
    ],
    ids=["sound", "exchanged", "processed"],
)
def test_come_here_turns_to_no_direction_that_the_microphones_contradict_and_says_why(
    change: Callable[[Array], Array], cause: str
) -> None:
    lab = SimulatedRobot("lab", seed=4, settings=SimulationSettings(camera=True))
    pilot, array = Pilot(lab.profile), lab.profile.microphones
    assert array is not None
    first = lab.read()
    whole = far_voice(array, 1.2, 0.3, stamp=first.stamp)
    quiet = 1e-3 * np.random.default_rng(2).normal(size=(round(0.7 * RATE), len(array.positions)))
    samples = np.concatenate((whole.samples, quiet))
    spoken = replace(whole, samples=change(samples))
    begin = spoken.stamp
    while begin < first.stamp + spoken.duration:
        frame = lab.read()
        pilot.step(replace(frame, sound=spoken.part(begin, frame.stamp)))
        begin = frame.stamp
    command = understand("come here")
    assert isinstance(command, Command)
    pilot.tell(1, command, "chip", "anna")
    snapshot = pilot.step(replace(lab.read(), sound=None))
    if not cause:
        assert snapshot.active_command is not None and snapshot.setpoint.w > 0
        return
    (ended,) = snapshot.endings
    assert ended.state == "refused" and not snapshot.setpoint.moves
    assert "cannot tell from where" in ended.remark and cause in ended.remark
