"""Several talkers, listening while sound comes in, and voices followed over time."""

import math

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import wrap
from core.perception.sound.direction import Direction, unit
from core.perception.sound.doa_stream import DoaStream, HeardDirections
from core.perception.sound.locate import sure
from core.perception.sound.multi_source import talkers
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.tracking import BEARING_WALK_RAD, VoiceTracker
from core.perception.sound.voice_activity import VoiceActivityDetector
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound, tetrahedron
from core.simulation.acoustics.shoebox import diffuse_noise, pink_noise, plane_waves
from core.simulation.microphones import Motors
from core.speech.practice_voice import practice_voice
from tests.core.perception.voices import PRE_ROLL, RATE, far_voice


def together(array: MicrophoneArray, azimuths: tuple[float, ...], duration: float = 3.0) -> Sound:
    """Voices from several azimuths at once, after half a second of faint noise."""
    rng = np.random.default_rng(3)
    silence = np.zeros(int(PRE_ROLL * RATE))
    voices = np.stack([np.concatenate((silence, practice_voice(rng, duration, RATE))) for _ in azimuths])
    samples = plane_waves(voices, np.array([unit(one, 0.2) for one in azimuths]), array.positions, RATE)
    return Sound(stamp=0.0, rate=RATE, samples=samples + 0.03 * rng.normal(size=samples.shape))


def pieces(sound: Sound, length: float = 0.02) -> list[Sound]:
    """The sound as a sound card delivers it."""
    step = int(length * sound.rate)
    return [
        Sound(stamp=sound.stamp + at / sound.rate, rate=sound.rate, samples=sound.samples[at : at + step])
        for at in range(0, len(sound.samples), step)
    ]


def listened(listener: DoaStream, sound: Sound) -> list[tuple[float, HeardDirections]]:
    """Everything told, with the time of the sound at which it was."""
    return [(piece.stamp + piece.duration, told) for piece in pieces(sound) for told in listener.feed(piece)]


def conversation(fan: float = 0.0) -> Sound:
    """2 s of noise, a voice from 1.0 for 1.2 s, silence, a voice from -1.5 for 1.2 s, silence."""
    rng = np.random.default_rng(5)
    voices = np.zeros((2, 8 * RATE))
    for number, begin in enumerate((2.0, 5.0)):
        voice = practice_voice(rng, 1.2, RATE)
        voices[number, int(begin * RATE) :][: len(voice)] = voice
    towards = np.array([unit(1.0, 0.2), unit(-1.5, 0.2)])
    samples = plane_waves(voices, towards, RESPEAKER_ODAS.positions, RATE)
    blowing = plane_waves(pink_noise(rng, 1, 8 * RATE, RATE), unit(2.6)[None], RESPEAKER_ODAS.positions, RATE)
    noise = 0.03 * rng.normal(size=samples.shape) + fan * blowing
    return Sound(stamp=50.0, rate=RATE, samples=0.05 * (samples + noise))


@pytest.mark.parametrize("array", [RESPEAKER_ODAS, tetrahedron()], ids=lambda a: a.name)
def test_two_talkers_at_once_are_both_found(array):
    found = talkers(together(array, (0.3, 1.6)), array, speech_from=PRE_ROLL)
    assert len(found) == 2
    for truth in (0.3, 1.6):
        assert min(abs(wrap(one.azimuth - truth)) for one in found) < math.radians(5)


@pytest.mark.parametrize("array", [RESPEAKER_ODAS, tetrahedron()], ids=lambda a: a.name)
def test_one_talker_is_not_taken_for_two(array):
    found = talkers(far_voice(array, 0.3, 0.2, duration=2.0), array, speech_from=PRE_ROLL, most=3)
    assert len(found) == 1 and found[0].azimuth == pytest.approx(0.3, abs=0.02)


def test_nobody_is_found_in_silence():
    assert talkers(Sound(stamp=0.0, rate=RATE, samples=np.zeros((RATE, 4))), RESPEAKER_ODAS) == ()


@pytest.mark.parametrize("fan", [0.0, 0.3])
def test_each_utterance_is_told_early_and_at_its_end_beside_a_fan_too(fan):
    told = listened(DoaStream(RESPEAKER_ODAS), conversation(fan))
    assert {round(one.begin) for _, one in told} == {52, 55}
    for begin, azimuth in ((52.0, 1.0), (55.0, -1.5)):
        own = [(when, one) for when, one in told if abs(one.begin - begin) < 0.3]
        first, last = own[0], own[-1]
        assert first[0] < begin + 0.5 and first[1].end is None
        assert last[1].end == pytest.approx(begin + 1.2, abs=0.25)
        for _, one in (first, last):
            assert one.directions and abs(wrap(one.directions[0].azimuth - azimuth)) < math.radians(4)
            assert begin < one.directions[0].stamp < begin + 1.5


def test_pieces_of_any_length_say_the_same():
    sound = conversation()
    ends = []
    for length in (0.01, 0.064, 0.5):
        listener = DoaStream(RESPEAKER_ODAS)
        told = [one for piece in pieces(sound, length) for one in listener.feed(piece) if one.end is not None]
        ends.append([(one.end, one.directions[0].azimuth) for one in told])
    for other in ends[1:]:
        assert np.array(other) == pytest.approx(np.array(ends[0]), abs=0.06)


def test_a_gap_in_the_sound_begins_anew():
    listener = DoaStream(RESPEAKER_ODAS)
    sound = conversation()
    for piece in pieces(sound.part(50.0, 52.6)):
        listener.feed(piece)
    assert listener.speaking
    listener.feed(sound.part(54.0, 54.1))
    assert not listener.speaking


def test_a_fan_that_is_switched_on_becomes_noise_in_the_end():
    rng = np.random.default_rng(0)
    blowing = plane_waves(pink_noise(rng, 1, 14 * RATE, RATE), unit(1.0)[None], RESPEAKER_ODAS.positions, RATE)
    blowing[: 2 * RATE] *= 0.001
    listener = DoaStream(RESPEAKER_ODAS)
    told = listened(listener, Sound(stamp=0.0, rate=RATE, samples=0.05 * blowing))
    assert not listener.speaking
    assert max(when for when, _ in told) < 2.0 + DirectionFindingSettings().longest + 0.5


def test_noise_with_the_robots_motors_in_it_is_not_asked_about_the_microphones():
    """Two microphones as far from either motor share it as two channels do that hear each other."""
    rng = np.random.default_rng(0)
    voice = far_voice(RESPEAKER_ODAS, 0.6, 0.2)
    samples = np.concatenate((np.zeros((2 * RATE, 4)), voice.samples))
    samples += 0.003 * diffuse_noise(rng, RESPEAKER_ODAS.positions, len(samples), RATE)
    samples[:, 0] = 0.5 * (samples[:, 0] + samples[:, 2])
    sound = Sound(stamp=0.0, rate=RATE, samples=samples)
    for moving in (True, False):
        listener = DoaStream(RESPEAKER_ODAS)
        heard = [one for piece in pieces(sound) for one in listener.feed(piece, moving=moving)]
        sharing = {one.fit.sharing for each in heard for one in each.directions if one.fit is not None}
        assert sharing == ({()} if moving else {(0, 2)})


@pytest.mark.parametrize("height", [0.0, 0.25])
def test_two_motors_are_no_channels_that_hear_each_other(height):
    positions = RESPEAKER_ODAS.positions + np.array([0.0, 0.0, height])
    voice = far_voice(RESPEAKER_ODAS, 0.6, 0.2)
    samples = np.concatenate((np.zeros((3 * RATE, 4)), voice.samples))
    motors = Motors(np.random.default_rng(0), positions, RATE).take(len(samples), 0.1, 0.1)
    sound = Sound(stamp=0.0, rate=RATE, samples=samples + 0.3 * np.std(voice.samples) / np.std(motors) * motors)
    listener = DoaStream(RESPEAKER_ODAS)
    heard = [one for piece in pieces(sound) for one in listener.feed(piece, moving=True)]
    found = [one for each in heard for one in each.directions if one.stamp > 3.0 + PRE_ROLL]
    assert min(abs(one.azimuth - 0.6) for one in found if sure(one)) < 0.1


def test_the_listener_refuses_sound_that_does_not_fit():
    with pytest.raises(BadInput):
        DoaStream(RESPEAKER_ODAS).feed(Sound(stamp=0.0, rate=RATE, samples=np.zeros((100, 2))))


def test_an_utterance_begins_with_three_frames_of_five_and_ends_after_half_a_second():
    activity = VoiceActivityDetector(DirectionFindingSettings())
    changes = [activity.step(share, 0.01 * n) for n, share in enumerate([0, 0.1, 0, 0.1, 0.1] + [0] * 60)]
    assert changes[4] == "begins" and changes.index("ends") == pytest.approx(54, abs=1)
    assert activity.begin is None and activity.last_active == pytest.approx(0.04)
    lonely = VoiceActivityDetector(DirectionFindingSettings())
    assert not any(lonely.step(share, 0.01 * n) for n, share in enumerate([0.1, 0, 0, 0, 0] * 10))


def direction(azimuth: float, sd: float = 0.05, elevation: float = 0.2) -> Direction:
    return Direction(stamp=0.0, towards=unit(azimuth, elevation), covariance=sd**2 * np.eye(2), strength=0.9)


def test_a_voice_is_born_kept_and_dropped():
    tracker = VoiceTracker()
    assert tracker.update([direction(0.5, 0.15)], 0.0) == ()
    (voice,) = tracker.update([direction(0.55, 0.15)], 0.5)
    assert voice.hits == 2 and 0.5 < voice.bearing < 0.55
    assert len(tracker.update([], 3.0)) == 1
    assert tracker.update([], 4.0) == ()


def test_a_sure_voice_is_told_at_once_and_grows_unsure_in_silence():
    tracker = VoiceTracker()
    (voice,) = tracker.update([direction(0.5)], 0.0)
    (later,) = tracker.update([], 1.0)
    assert later.bearing == pytest.approx(voice.bearing) and later.bearing_sd > 3 * voice.bearing_sd


def test_a_robot_that_turns_keeps_the_bearing():
    tracker = VoiceTracker()
    for number in range(8):
        heading = 0.3 * number
        (voice,) = tracker.update([direction(1.0 - heading)], 0.5 * number, heading)
    assert voice.bearing == pytest.approx(1.0, abs=1e-6) and voice.id == 1


def test_two_talkers_who_take_turns_keep_their_names():
    tracker = VoiceTracker()
    rng = np.random.default_rng(0)
    for number in range(12):
        where = (0.0, 1.2)[number % 2] + rng.normal(scale=0.04)
        tracker.update([direction(where)], 0.3 * number)
    voices = {voice.id: voice.bearing for voice in tracker.voices}
    assert len(voices) == 2 and voices[1] == pytest.approx(0.0, abs=0.1) and voices[2] == pytest.approx(1.2, abs=0.1)


def test_one_stray_direction_is_no_voice():
    tracker = VoiceTracker()
    for number in range(5):
        heard = [direction(0.0, 0.1)] + ([direction(2.5, 0.2)] if number == 2 else [])
        tracker.update(heard, 0.2 * number)
    assert [voice.id for voice in tracker.voices] == [1]


def test_a_walking_talker_is_followed_within_the_standard_deviation():
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(40):
        tracker, truth = VoiceTracker(), rng.uniform(-3, 3)
        for number in range(12):
            truth += rng.normal(scale=BEARING_WALK_RAD * math.sqrt(0.3))
            voices = tracker.update([direction(truth + rng.normal(scale=0.08), 0.08)], 0.3 * number)
            if number > 3 and voices:
                ratios.append(abs(wrap(voices[0].bearing - truth)) / voices[0].bearing_sd)
    assert len(ratios) > 250 and 0.88 < np.mean(np.array(ratios) < 2) <= 0.99


def test_voices_that_meet_become_one_and_time_that_runs_back_begins_anew():
    tracker = VoiceTracker()
    for number in range(6):
        tracker.update([direction(0.0), direction(0.8 - 0.16 * number)], 0.3 * number)
    assert [voice.id for voice in tracker.voices] == [1]
    assert tracker.update([], 0.0) == ()
