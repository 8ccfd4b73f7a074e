"""Sound in the simulated room: what microphones on a robot hear of people, walls, fans and motors."""

import math

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from core.errors import BadInput, Refused
from core.geometry import Pose
from core.message import Array
from core.perception.sound.locate import locate
from core.sensors.microphones import RESPEAKER_ODAS, Sound, joined
from core.simulation.acoustics import reverberation
from core.simulation.acoustics.enclosure import enclosure, in_sight
from core.simulation.acoustics.reverberation import HALF_SAMPLES, HARD_WALL_SHARE, Arrivals, first_images
from core.simulation.acoustics.shoebox import SPEED_OF_SOUND_M_S, ShoeboxRoom, heard, impulse_responses
from core.simulation.microphones import RATE_HZ, Motors, Murmur, SimulatedMicrophones, SoundSource, fan_place
from core.simulation.settings import MicrophoneSettings
from core.simulation.world import FLOOR, LAB
from core.speech.practice_voice import practice_voice

BLOCK = 400
QUIET = MicrophoneSettings(murmur=-60.0, motor_noise=-60.0)
VOICE = practice_voice(np.random.default_rng(1), 1.0, RATE_HZ)
MOUTH = np.array([2.0, 1.0, 1.55])
HERE = Pose(0.3, -0.2, 0.4)


def microphones(settings: MicrophoneSettings = QUIET, seed: int = 3) -> SimulatedMicrophones:
    return SimulatedMicrophones(RESPEAKER_ODAS, settings, np.random.SeedSequence(seed))


def listen(ears: SimulatedMicrophones, seconds: float, pose: Pose = HERE, turn_rate: float = 0.0) -> Sound:
    """All that is heard while the robot stands, or turns on the spot."""
    whole: Sound | None = None
    start = ears._until / RATE_HZ  # pyright: ignore[reportPrivateUsage]
    for step in range(1, round(seconds * 40) + 1):
        there = Pose(pose.x, pose.y, pose.heading + turn_rate * step / 40)
        whole = joined(whole, ears.read(LAB, start + step / 40, there, 0.0, turn_rate, 0.1), 60.0)
    assert whole is not None
    return whole


def test_arrivals_are_the_sound_later_and_fainter() -> None:
    """The law: a way of d metres delays by d/c and divides by d, between samples as well as on them."""
    time = np.arange(4000) / RATE_HZ
    tone = np.sin(2 * np.pi * 1000 * time)
    for away in (1.0, 2.345, 7.1):
        way, ways = Arrivals(RATE_HZ, SPEED_OF_SOUND_M_S), np.full((1, 1), away)
        parts = [way.feed(tone[k : k + BLOCK], ways, ways, np.ones((1, 1))) for k in range(0, 4000, BLOCK)]
        told = np.concatenate(parts)[:, 0]
        late = away / SPEED_OF_SOUND_M_S + HALF_SAMPLES / RATE_HZ
        wanted = np.sin(2 * np.pi * 1000 * (time - late)) / away
        np.testing.assert_allclose(told[1000:], wanted[1000:], atol=4e-3 / away)


def test_a_way_that_grows_lowers_the_pitch() -> None:
    """Doppler: leaving at 3.43 m/s, a hundredth of the sound's speed."""
    way = Arrivals(RATE_HZ, SPEED_OF_SOUND_M_S)
    tone = np.sin(2 * np.pi * 1000 * np.arange(RATE_HZ) / RATE_HZ)
    step = 3.43 * BLOCK / RATE_HZ
    parts = [
        way.feed(
            tone[k : k + BLOCK], *(np.full((1, 1), 2 + (k // BLOCK + n) * step) for n in (0, 1)), np.ones((1, 1))
        )
        for k in range(0, RATE_HZ, BLOCK)
    ]
    spectrum = np.abs(np.fft.rfft(np.concatenate(parts)[2000:10_000, 0] * np.hanning(8000)))
    assert np.argmax(spectrum) * RATE_HZ / 8000 == pytest.approx(990, abs=2.1)


def test_the_pieces_are_the_image_sources_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reverberation, "IMAGE_JITTER_M", 0.0)
    monkeypatch.setattr(reverberation, "DECAY_SHARE", 1.0)
    ears = microphones().ears(HERE)
    talker = SoundSource("x", MOUTH, RATE_HZ, BLOCK, 0.25, 0)
    talker.say(VOICE)
    while not talker.ready:
        talker.prepare(LAB, ears)
    told = np.concatenate([talker.heard(ears, BLOCK, True) for _ in range(len(VOICE) // BLOCK)])
    box = enclosure(LAB, np.vstack((ears, MOUTH)), 0.25)
    responses = impulse_responses(box.room, box.inside(MOUTH), box.inside(ears), RATE_HZ)
    late = np.concatenate((np.zeros((HALF_SAMPLES, 4)), heard(VOICE, responses)))[: len(told)]
    rumble = butter(4, 300, "highpass", fs=RATE_HZ, output="sos")  # below, only the echo is softened
    for ours, theirs in zip(sosfilt(rumble, told.T), sosfilt(rumble, late.T), strict=True):
        assert np.corrcoef(ours, theirs)[0, 1] > 0.99
        assert np.std(ours) == pytest.approx(np.std(theirs), rel=0.05)


def test_every_piece_of_work_is_small() -> None:
    """An echo is worked out while the robot drives: no piece may take in more than some thousand images."""
    room = ShoeboxRoom((8.0, 6.0, 2.7), 0.6)
    source = np.array([2.0, 2.0, 1.5])
    sizes = [len(precision) for _, precision in reverberation._batches(room, source, np.random.default_rng(0))]  # pyright: ignore
    assert max(sizes) < 2 * reverberation.AT_ONCE
    assert sum(sizes) > 50_000


def test_a_change_of_the_echo_is_faded_in() -> None:
    one = reverberation.Convolver(64, BLOCK)
    assert one.feed(np.ones(BLOCK)) is None
    one.change(np.eye(1, 64))
    np.testing.assert_allclose(one.feed(np.ones(BLOCK)), 1.0)
    one.change(3 * np.eye(1, 64))
    told = one.feed(np.ones(BLOCK))
    assert told is not None
    np.testing.assert_allclose(told[:, 0], 1 + 2 * np.arange(1, BLOCK + 1) / BLOCK)
    np.testing.assert_allclose(one.feed(np.ones(BLOCK)), 3.0)


def test_the_box_around_the_robot_is_the_room() -> None:
    box = enclosure(LAB, np.array([[0.0, 0.0, 0.3]]), 0.3)
    np.testing.assert_allclose(box.room.size, (8.0, 6.0, 2.7), atol=0.5)
    np.testing.assert_allclose(box.corner, (-2.5, -2.5, 0.0), atol=0.3)


def test_walls_hide_and_furniture_does_not() -> None:
    assert in_sight(LAB, np.array([0.0, 0.0, 0.3]), np.array([4.0, 2.0, 1.5]))
    x0, y0, x1, y1 = FLOOR.bounds.x0, FLOOR.bounds.y0, FLOOR.bounds.x1, FLOOR.bounds.y1
    assert not in_sight(FLOOR, np.array([x0 + 0.3, y0 + 0.3, 0.3]), np.array([x1 - 0.3, y1 - 0.3, 1.5]))


def test_the_murmur_comes_from_everywhere_with_the_power_told() -> None:
    sound = Murmur(np.random.default_rng(0), RESPEAKER_ODAS.positions, RATE_HZ).take(4 * RATE_HZ)
    np.testing.assert_allclose(sound.std(0), 1.0, atol=0.1)
    assert np.corrcoef(sound.T)[0, 2] > 0.6  # low notes are long beside the array
    high = np.diff(sound, 2, axis=0)
    assert abs(np.corrcoef(high.T)[0, 2]) < 0.3


def test_motors_are_silent_at_rest_and_as_loud_as_they_are_fast() -> None:
    motors = Motors(np.random.default_rng(0), microphones()._spots, RATE_HZ)  # pyright: ignore[reportPrivateUsage]
    assert not motors.take(BLOCK, 0.0, 0.0).any()
    slow = np.concatenate([motors.take(BLOCK, 0.05, 0.05) for _ in range(40)])[BLOCK:]
    fast = np.concatenate([motors.take(BLOCK, 0.1, 0.1) for _ in range(40)])[BLOCK:]
    assert fast.std() == pytest.approx(2 * slow.std(), rel=0.1)
    assert fast.std() == pytest.approx(1.0, rel=0.3)


def test_a_voice_is_where_it_is_said_and_as_loud_as_it_is_far() -> None:
    levels: list[float] = []
    for away in (1.0, 2.0):
        ears = microphones(MicrophoneSettings(reverberation=0.0, murmur=-40.0))
        bearing = HERE.heading + 0.7
        mouth = np.array([HERE.x + away * math.cos(bearing), HERE.y + away * math.sin(bearing), 0.25])
        ears.say("a", mouth, VOICE, HERE, BLOCK)
        sound = listen(ears, 2.0)
        found = locate(sound, RESPEAKER_ODAS, speech_from=0.8)
        assert found is not None
        assert found.azimuth == pytest.approx(0.7, abs=0.02)
        levels.append(float(np.std(sound.samples)))
    assert levels[0] / levels[1] == pytest.approx(2.0, rel=0.1)


def test_whoever_turns_hears_the_voice_turn_the_other_way() -> None:
    ears = microphones(MicrophoneSettings(motor_noise=-60.0))
    ears.say("a", MOUTH, VOICE, HERE, BLOCK)
    sound = listen(ears, 1.5, turn_rate=0.8)
    for begin in (0.85, 1.15):
        part = sound.part(begin - 0.5, begin + 0.3)
        found = locate(part, RESPEAKER_ODAS, speech_from=max(begin, 0.82))
        assert found is not None
        heading = HERE.heading + 0.8 * found.stamp
        wanted = math.atan2(MOUTH[1] - HERE.y, MOUTH[0] - HERE.x) - heading
        assert found.azimuth == pytest.approx(wanted, abs=0.06)


def test_the_same_seed_gives_the_same_sound() -> None:
    def once(seed: int) -> Array:
        ears = microphones(MicrophoneSettings(fan_noise=-20.0), seed)
        ears.say("a", MOUTH, VOICE, HERE, BLOCK)
        return listen(ears, 1.2, turn_rate=0.3).samples

    np.testing.assert_array_equal(once(3), once(3))
    assert not np.array_equal(once(3), once(4))


def test_a_voice_in_pieces_is_the_voice_at_once() -> None:
    whole, parts = microphones(), microphones()
    whole.say("a", MOUTH, VOICE, HERE, BLOCK)
    for begin in range(0, len(VOICE), 1600):
        parts.say("a", MOUTH, VOICE[begin : begin + 1600], HERE, BLOCK, more=True)
    np.testing.assert_array_equal(listen(whole, 2.0).samples, listen(parts, 2.0).samples)


def test_too_many_too_much_and_too_near_are_refused() -> None:
    ears = microphones()
    for name in "abc":
        ears.say(name, MOUTH, VOICE, HERE, BLOCK)
    with pytest.raises(Refused, match="wait"):
        ears.say("d", MOUTH, VOICE, HERE, BLOCK)
    with pytest.raises(Refused, match="wait"):
        ears.say("a", MOUTH, np.zeros(31 * RATE_HZ), HERE, BLOCK)
    ears.hush("b")
    with pytest.raises(BadInput, match="on top"):
        ears.say("d", np.array([HERE.x, HERE.y, 0.3]), VOICE, HERE, BLOCK)
    with pytest.raises(BadInput, match="Nobody"):
        ears.hush("b")


def test_who_has_spoken_is_gone() -> None:
    ears = microphones()
    ears.say("a", MOUTH, VOICE, HERE, BLOCK)
    listen(ears, 1.0)
    assert ears.talking
    listen(ears, 2.0)
    assert not ears.talking


def test_the_fan_stands_in_the_room() -> None:
    for world in (LAB, FLOOR):
        assert world.open_air(fan_place(world)[None])


@pytest.mark.parametrize("wrong", [{"microphones": "ears"}, {"reverberation": 2.0}, {"murmur": 50.0}])
def test_impossible_ears_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(BadInput, match=next(iter(wrong))):
        MicrophoneSettings(**wrong)  # type: ignore[arg-type]


def test_sounds_that_follow_each_other_are_joined_and_a_gap_begins_anew() -> None:
    def piece(begin: float, value: float) -> Sound:
        return Sound(stamp=begin, rate=1000, samples=np.full((100, 1), value))

    both = joined(piece(0.0, 1.0), piece(0.1, 2.0), 10.0)
    assert both is not None
    assert (both.stamp, both.duration) == (0.0, 0.2)
    after_gap = joined(piece(0.0, 1.0), piece(0.2, 2.0), 10.0)
    assert after_gap is not None
    assert after_gap.stamp == 0.2
    short = joined(piece(0.0, 1.0), piece(0.1, 2.0), 0.15)
    assert short is not None
    assert (short.stamp, len(short.samples)) == (0.05, 150)
    assert joined(None, None, 1.0) is None


def test_one_hard_wall_sends_back_the_first_echo_and_the_others_what_they_did() -> None:
    size, mouth = (5.0, 4.0, 2.7), np.array([1.0, 1.5, 1.5])
    images, soft = first_images(size, mouth, 0.5)
    for wall, mirrored in (("west", -1.0), ("east", 9.0)):
        behind, pressures = first_images(size, mouth, 0.5, wall)  # type: ignore[arg-type]
        (changed,) = np.flatnonzero(pressures != soft)
        assert np.array_equal(behind, images)
        assert behind[changed] == pytest.approx([mirrored, 1.5, 1.5]) and pressures[changed] == HARD_WALL_SHARE
    assert len(first_images(size, mouth, 0.0)[0]) == 1
    assert first_images(size, mouth, 0.0, "north")[1].tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, HARD_WALL_SHARE, 0.0]
