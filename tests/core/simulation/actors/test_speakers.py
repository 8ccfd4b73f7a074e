"""The requests `say` and `listen` of the simulated robot, and its pilot that hears where."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.geometry import wrap
from core.pilot import Pilot
from core.robots.frame_sender import merged
from core.robots.requests import PlaceThing, SetListening, Speak, SpokenSound
from core.sensors import SensorFrame
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.snapshot import Hearing, Snapshot
from core.speech.practice_voice import practice_voice

PCM = (8000 * practice_voice(np.random.default_rng(2), 1.2, 16_000)).clip(-32768, 32767).astype("<i2").tobytes()


def robot(**changes: Any) -> SimulatedRobot:
    return SimulatedRobot("lab", seed=4, settings=SimulationSettings(camera=False, **changes))


def say(one: SimulatedRobot, **wish: Any) -> SpokenSound:
    return one.ask(Speak(**({"pcm": PCM, "x_m": 2.0, "y_m": 1.0} | wish)))


def frames(one: SimulatedRobot, seconds: float) -> list[SensorFrame]:
    return [one.read() for _ in range(round(seconds * 40))]


def test_nobody_listens_until_someone_speaks_or_asks_to() -> None:
    one = robot()
    assert all(frame.sound is None for frame in frames(one, 0.3))
    one.ask(SetListening(on=True))
    assert all(frame.sound is not None for frame in frames(one, 0.3))
    one.ask(SetListening(on=False))
    assert one.read().sound is None
    say(one)
    assert one.read().sound is not None


def test_the_sound_of_the_frames_has_no_gap() -> None:
    one = robot()
    say(one)
    told = [frame.sound for frame in frames(one, 1.0)]
    for before, after in pairwise(told):
        assert before is not None
        assert after is not None
        assert after.stamp == pytest.approx(before.stamp + before.duration)


def test_listening_changes_nothing_else_of_the_robot() -> None:
    """The ears draw from their own chance."""
    deaf, hearing = robot(microphones="none"), robot()
    say(hearing)
    for one in (deaf, hearing):
        one.drive(Twist(0.1, 0.2))
    for a, b in zip(frames(deaf, 0.5), frames(hearing, 0.5), strict=True):
        assert a.truth == b.truth
        assert (a.scan is None) == (b.scan is None)
        if a.scan is not None and b.scan is not None:
            np.testing.assert_array_equal(a.scan.ranges, b.scan.ranges)


def test_frames_that_are_merged_lose_no_sound() -> None:
    one = robot()
    say(one)
    first, second = frames(one, 0.05)
    both = merged(first, second).sound
    assert both is not None
    assert both.duration == pytest.approx(0.05)


def test_a_person_in_the_room_speaks_by_name() -> None:
    one = robot()
    one.ask(PlaceThing(what="person", id="Ann", x_m=2.0, y_m=1.0))
    told = one.ask(Speak(pcm=PCM, id="Ann"))
    assert (told.id, told.x_m, told.y_m) == ("Ann", 2.0, 1.0)
    assert told.seconds == pytest.approx(1.2, abs=0.01)


def test_a_quiet_recording_is_as_loud_as_a_voice() -> None:
    levels: list[float] = []
    for gain in (1.0, 0.1):
        one = robot(murmur=-60.0)
        say(one, pcm=(gain * np.frombuffer(PCM, "<i2")).astype("<i2").tobytes())
        sound = np.concatenate([frame.sound.samples for frame in frames(one, 2.0) if frame.sound is not None])
        levels.append(float(np.std(sound)))
    assert levels[1] == pytest.approx(levels[0], rel=0.02)


@pytest.mark.parametrize(
    ("wish", "sentence"),
    [
        ({"x_m": 90.0}, "Nobody can speak from there"),
        ({"x_m": None}, "x_m must be a number"),
        ({"z_m": 9.0}, "z_m must lie"),
        ({"pcm": b"abc"}, "even number of bytes"),
        ({"pcm": b"\0" * 2_000_000}, "at most 15 s"),
        ({"pcm": None}, "text, or pcm"),
        ({"rate_hz": 100}, "rate_hz"),
        ({"id": ""}, "id must be"),
        ({"pcm": None, "text": "turn left", "voice": "klingon"}, "voice must be one of"),
    ],
)
def test_impossible_wishes_are_refused(wish: dict[str, Any], sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        say(robot(), **wish)


def test_a_deaf_robot_says_so() -> None:
    with pytest.raises(Unavailable, match="no microphones"):
        say(robot(microphones="none"))


def pilot_hears(one: SimulatedRobot, seconds: float, twist: Twist = ZERO) -> list[Snapshot]:
    pilot = Pilot(one.profile)
    told: list[Snapshot] = []
    for _ in range(round(seconds * 40)):
        one.drive(twist)
        told.append(pilot.step(one.read()))
    return told


def hearing(snapshot: Snapshot) -> Hearing:
    assert snapshot.hearing is not None
    return snapshot.hearing


def test_the_pilot_hears_where_the_voice_is_in_the_world() -> None:
    one = robot()
    say(one)
    told = pilot_hears(one, 2.3)
    assert not hearing(told[10]).voices
    voice = hearing(told[-1]).voices[0]
    wanted = math.atan2(1.0, 2.0)
    assert abs(wrap(voice.azimuth_world - wanted)) < max(3 * voice.sd, math.radians(4))
    assert voice.sd_heard < math.radians(6)
    assert voice.sd >= voice.sd_heard
    assert any(hearing(snapshot).speaking for snapshot in told)
    assert (hearing(told[-1]).level_db or 0) < -20


def test_a_bearing_stays_where_it_is_while_the_robot_turns() -> None:
    one = robot(motor_noise=-60.0)
    say(one)
    told = pilot_hears(one, 3.0, Twist(0.0, 0.6))
    voice = hearing(told[-1]).voices[0]
    assert abs(wrap(voice.azimuth_world - math.atan2(1.0, 2.0))) < math.radians(8)
    turned = told[-1].estimate.pose.heading
    assert abs(turned) > 0.5
    assert wrap(voice.azimuth_world - turned - voice.azimuth) == pytest.approx(0.0, abs=1e-9)


def test_a_robot_without_microphones_hears_nothing_and_says_nothing_of_it() -> None:
    assert pilot_hears(robot(microphones="none"), 0.1)[-1].hearing is None
