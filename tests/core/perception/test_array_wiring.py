"""The array's self-check, and how it is turned."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.geometry import wrap
from core.perception.sound.array_diagnostics import ArrayFault, check
from core.perception.sound.array_orientation import Orientation, OrientationWizard
from core.perception.sound.direction import Direction, unit
from core.perception.sound.locate import locate, sure
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound, tetrahedron
from tests.benchmarks.array_faults import campaign, figures, late
from tests.core.perception.voices import far_voice

ARRAYS = [RESPEAKER_ODAS, tetrahedron()]


def faults_of(samples: np.ndarray, array: MicrophoneArray = RESPEAKER_ODAS) -> dict[str, ArrayFault]:
    return {one.kind: one for one in check(Sound(stamp=0.0, rate=16000, samples=samples), array)}


@pytest.fixture
def samples() -> np.ndarray:
    return far_voice(RESPEAKER_ODAS, 0.6, 0.2).samples.copy()


def test_a_sound_array_has_nothing_but_its_limits(samples):
    assert set(faults_of(samples)) == {"flat"} and not faults_of(samples)["flat"].serious
    assert check(far_voice(tetrahedron(), 0.6, 0.2), tetrahedron()) == ()


def test_identical_channels_are_named_counted_from_one(samples):
    samples[:, 3] = 0.7 * samples[:, 2]
    assert "Channels 3 and 4 are identical" in faults_of(samples)["identical"].sentence


def test_a_dead_a_faint_and_a_clipped_channel_are_named(samples):
    samples[:, 1] = 0
    assert faults_of(samples)["dead"].channels == (1,)
    samples = far_voice(RESPEAKER_ODAS, 0.6).samples.copy()
    samples[:, 1] *= 0.01
    assert "100 times fainter" in faults_of(samples)["faint"].sentence
    samples = far_voice(RESPEAKER_ODAS, 0.6).samples.copy()
    samples[:, 0] = np.clip(samples[:, 0], -0.06, 0.06)
    assert faults_of(samples)["clipped"].channels == (0,)


def test_a_foreign_an_inverted_and_two_exchanged_channels_are_named(samples):
    other = far_voice(RESPEAKER_ODAS, -2.0, seed=9).samples[:, 0]
    assert faults_of(np.column_stack((samples[:, :3], other)))["foreign"].channels == (3,)
    inverted = samples * [1, 1, -1, 1]
    assert faults_of(inverted)["inverted"].channels == (2,)
    assert "exchanged" in faults_of(samples[:, [1, 0, 2, 3]])["swapped"].sentence


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (lambda one: np.column_stack((one.mean(1), one[:, :3])), "processed"),
        (lambda one: np.column_stack((late(one.mean(1), 256), one[:, :3])), "foreign"),
        (lambda one: np.column_stack((one[:, 0], late(one[:, 1], 1), one[:, 2:])), "late"),
        (lambda one: np.column_stack((late(one[:, 0], 1), late(one[:, 1], 1), one[:, 2:])), "late"),
        (lambda one: np.column_stack((one[:, :3], np.random.default_rng(1).normal(size=len(one)) * 0.05)), "foreign"),
        (lambda one: one[:, [0, 2, 1, 3]], "swapped"),
    ],
)
@pytest.mark.parametrize("azimuth", [0.6, *(pytest.param(side, marks=pytest.mark.campaign) for side in (-1.1, 2.9))])
def test_a_direction_that_the_microphones_contradict_is_not_sure_and_the_cause_is_named(change, kind, azimuth):
    sound = far_voice(RESPEAKER_ODAS, azimuth, 0.2)
    own_noise = 1e-3 * np.random.default_rng(2).normal(size=sound.samples.shape)
    right = locate(sound, RESPEAKER_ODAS, speech_from=0.5)
    assert right is not None and sure(right) and right.misfit < 1
    wrong = change(sound.samples + own_noise)
    found = locate(replace(sound, samples=wrong), RESPEAKER_ODAS, speech_from=0.5)
    told = faults_of(wrong)
    assert found is not None and (not sure(found) or told)
    words = " ".join(one.sentence for one in told.values() if one.serious)
    assert {"foreign": "shares no sound", "late": "late on channel", "processed": "processed"}.get(
        kind, "exchanged"
    ) in words


def test_an_array_that_hears_everything_above_it_is_asked_for_metres():
    sound = far_voice(RESPEAKER_ODAS, 0.6, 0.2)
    feet = MicrophoneArray(positions=RESPEAKER_ODAS.positions * 3.28)
    assert "in metres" in faults_of(sound.samples, feet)["scale"].sentence


def test_a_profile_with_two_microphones_in_one_place_and_one_in_a_line_are_told():
    positions = np.array([[-0.05, -0.05, 0], [-0.05, 0.05, 0], [0.05, 0.05, 0], [0.05, 0.05, 0]])
    array = MicrophoneArray(positions=positions)
    assert "microphones 3 and 4" in faults_of(far_voice(array, 1.0).samples, array)["same place"].sentence
    line = MicrophoneArray(positions=np.array([[0.0, 0, 0], [0.05, 0, 0], [0.1, 0, 0]]))
    assert faults_of(np.random.default_rng(0).normal(size=(8000, 3)), line)["line"].serious


def test_channels_are_those_of_the_sound_not_of_the_profile(samples):
    shifted = replace(RESPEAKER_ODAS, channels=(2, 3, 4, 5))
    six = np.column_stack((np.zeros((len(samples), 2)), samples))
    six[:, 4] = 0
    assert faults_of(six, shifted)["dead"].channels == (4,)


def clap(azimuth: float, sd: float = 0.03) -> Direction:
    return Direction(stamp=0.0, towards=unit(azimuth, 0.2), covariance=sd**2 * np.eye(2), strength=0.9)


@pytest.mark.parametrize("mirrored", [False, True])
def test_claps_from_known_sides_give_the_arrays_turn(mirrored):
    rng = np.random.default_rng(0)
    inside = []
    for _ in range(60):
        yaw, wizard = rng.uniform(-3, 3), OrientationWizard()
        for asked in wizard.asked:
            stood = asked + rng.normal(scale=math.radians(3))
            wizard.add(asked, clap(wrap((-1 if mirrored else 1) * (stood - yaw)) + rng.normal(scale=0.03)))
        told = wizard.solve()
        assert isinstance(told, Orientation) and told.mirrored is mirrored
        inside.append(abs(wrap(told.yaw - yaw)) < 2 * told.yaw_sd)
    assert np.mean(inside) > 0.88  # 0.90 to 0.99 takes 200 arrays


def test_the_wizard_says_what_to_do_and_what_is_wrong():
    wizard = OrientationWizard()
    assert "at 0°" in wizard.advice and "claps are needed" in str(wizard.solve())
    assert "clap again" in wizard.add(0.0, clap(0.0, sd=1.0))
    for number in range(3):
        assert wizard.add(0.1 * number, clap(0.1 * number)) == ""
    assert "one side" in str(wizard.solve())
    wizard.drop(2)
    wizard.add(math.pi, clap(1.0))
    wizard.add(-math.pi / 2, clap(2.0))
    assert "do not agree" in str(wizard.solve()) and "enough" in wizard.advice


@pytest.mark.parametrize("rooms", [2, pytest.param(4, marks=pytest.mark.campaign)])
def test_in_rooms_faults_mislead_seldom_and_sound_arrays_stay_sure(rooms):
    names = ["square", "ring of 6", "uneven", "triangle"]
    done = campaign(rooms=rooms, seed=3, names=names, most=2)
    faulty, whole = [one for one in done if one.fault], [one for one in done if not one.fault]
    assert len(faulty) == 8 * rooms and figures(faulty)["covered_or_not_sure"] >= 0.8  # 0.9 takes 200
    assert figures(faulty)["before"] < 0.6
    assert all(one.is_sure == one.sure_before for one in whole) and not any(one.named for one in whole)
