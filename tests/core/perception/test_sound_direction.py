"""One talker: where, how sure, in noise, beside a fan, on flat arrays and others."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import wrap
from core.message import Array
from core.perception.sound.direction import MAX_AZIMUTH_SD_RAD, Direction, sphere, tangents, unit
from core.perception.sound.locate import locate, sure
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import cell_weights, noise_of, over_noise, quiet_frames, spectra
from core.perception.sound.srp import Correlation, slopes, steered_power
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound, ring, tetrahedron
from core.simulation.acoustics.shoebox import ShoeboxRoom, plane_waves
from tests.core.perception.voices import PRE_ROLL, RATE, far_voice, voice_in_room

EXACT = {"position_sd": 0.0}
SQUARE, TETRAHEDRON = replace(RESPEAKER_ODAS, **EXACT), replace(tetrahedron(), **EXACT)


def found(sound: Sound, array: MicrophoneArray) -> Direction:
    direction = locate(sound, array, speech_from=PRE_ROLL)
    assert direction is not None
    return direction


@pytest.mark.parametrize(
    "array", [SQUARE, TETRAHEDRON, ring("six", 0.046, 0.1, math.pi / 3, 6)], ids=lambda a: a.name
)
@pytest.mark.parametrize("azimuth", [-3.0, -1.2, 0.0, 0.7, 2.2])
def test_a_voice_in_the_open_is_found_to_a_fraction_of_a_degree(array, azimuth):
    direction = found(far_voice(array, azimuth, 0.3), array)
    assert abs(wrap(direction.azimuth - azimuth)) < math.radians(0.6)
    assert direction.elevation == pytest.approx(0.3, abs=0.06)
    assert sure(direction) and direction.strength > 0.8


def test_only_a_volume_tells_above_from_below():
    below = found(far_voice(TETRAHEDRON, 1.0, -0.5), TETRAHEDRON)
    assert below.elevation == pytest.approx(-0.5, abs=0.03) and below.mirror is None and below.ambiguity == ""
    flat = found(far_voice(SQUARE, 1.0, -0.5), SQUARE)
    assert flat.elevation == pytest.approx(0.5, abs=0.05) and "° or −" in flat.ambiguity
    assert flat.mirror is not None and flat.mirror[2] == pytest.approx(-flat.towards[2])


def test_a_flat_array_on_edge_says_which_other_azimuth_it_may_be():
    upright = MicrophoneArray(positions=SQUARE.positions[:, [0, 2, 1]], name="upright")
    direction = found(far_voice(upright, 0.4, 0.1), upright)
    assert direction.mirror is not None and "may as well come from" in direction.ambiguity
    assert min(direction.angle_to(unit(0.4, 0.1)), math.acos(direction.mirror @ unit(0.4, 0.1))) < 0.05


def heard(azimuth: float, elevation: float, mirror: Array | None, sd: float = 0.02) -> Direction:
    """A direction [rad] that a flat array cannot tell from `mirror` (3,)."""
    return Direction(
        stamp=0.0, towards=unit(azimuth, elevation), covariance=sd**2 * np.eye(2), strength=1.0, mirror=mirror
    )


@pytest.mark.parametrize("azimuth", [-3.1, -0.54, 0.0, 0.54, 2.0])
@pytest.mark.parametrize("tilt", [0.0, 0.05])
def test_a_direction_and_its_mirror_on_one_side_are_not_two_sides(azimuth: float, tilt: float) -> None:
    """An array that lies level, or all but level, leans the vectors apart and not the azimuths."""
    normal = unit(azimuth, math.pi / 2 - tilt)
    for elevation in (0.0, 0.3, 0.7):
        towards = unit(azimuth, elevation)
        told = heard(azimuth, elevation, towards - 2 * (towards @ normal) * normal).ambiguity
        assert "may as well" not in told
        assert ("elevation" in told) == (elevation > 0.0 or tilt > 0.0)
    assert heard(azimuth, 0.3, unit(azimuth, -0.3), sd=0.7).ambiguity == ""


@pytest.mark.parametrize(
    ("azimuth", "other", "words"),
    [
        (0.54, -0.54, "from 31° to the right."),
        (-0.54, 0.54, "from 31° to the left."),
        (2.0, 0.0, "from straight ahead."),
        (1.0, math.pi, "from behind."),
    ],
)
def test_another_side_is_told_as_people_say_it(azimuth: float, other: float, words: str) -> None:
    assert heard(azimuth, 0.1, unit(other, 0.1)).ambiguity.endswith(words)
    assert heard(azimuth, 0.1, unit(azimuth + 0.01, 0.1)).ambiguity == ""  # within its own doubt


def test_a_mirror_turns_with_its_direction() -> None:
    turned = heard(0.54, 0.2, unit(-0.54, 0.2)).turned(1.0)
    assert turned.azimuth == pytest.approx(1.54)
    assert turned.mirror is not None and np.allclose(turned.mirror, unit(0.46, 0.2))
    assert turned.turned(-1.0).ambiguity == heard(0.54, 0.2, unit(-0.54, 0.2)).ambiguity


def test_directions_turn_with_the_array():
    turn = 0.8
    matrix = np.array([[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]])
    turned = replace(TETRAHEDRON, positions=TETRAHEDRON.positions @ matrix.T)
    sound = far_voice(TETRAHEDRON, 0.5, 0.2)
    gap = found(sound, turned).azimuth - found(sound, TETRAHEDRON).azimuth
    assert gap == pytest.approx(turn, abs=1e-3)


@pytest.mark.parametrize("array", [SQUARE, TETRAHEDRON], ids=lambda a: a.name)
@pytest.mark.parametrize("ratio", [10.0, 0.0, -5.0])
def test_a_fan_does_not_win_over_a_voice(array, ratio):
    direction = found(far_voice(array, 1.0, 0.3, ratio=ratio, fan=-1.5, duration=1.5), array)
    assert abs(wrap(direction.azimuth - 1.0)) < math.radians(5)


def test_a_fan_alone_is_no_voice():
    sound = far_voice(SQUARE, 1.0, fan=-1.5, ratio=-80.0)
    direction = locate(sound, SQUARE, speech_from=PRE_ROLL)
    assert direction is None or not sure(direction)


@pytest.mark.parametrize(
    "array", [SQUARE, pytest.param(TETRAHEDRON, marks=pytest.mark.campaign)], ids=lambda a: a.name
)
def test_in_rooms_errors_are_small_and_the_standard_deviation_holds(array):
    rng = np.random.default_rng(4)
    errors, ratios = [], []
    for number in range(10):
        azimuth, far = rng.uniform(-math.pi, math.pi), rng.uniform(1.0, 2.0)
        centre = np.array([3.5, 2.8, 0.6])
        mouth = centre + np.array([far * math.cos(azimuth), far * math.sin(azimuth), 0.9])
        room = ShoeboxRoom((7, 5.5, 2.8), (0.2, 0.3)[number % 2])
        direction = found(voice_in_room(array, room, centre, mouth, seed=number, ratio=10.0), array)
        errors.append(abs(wrap(direction.azimuth - azimuth)))
        ratios.append(errors[-1] / direction.azimuth_sd)
    assert np.median(errors) < math.radians(2) and np.max(errors) < math.radians(12)
    assert np.mean(np.array(ratios) < 2) >= 0.85


def test_the_first_third_of_a_second_suffices():
    sound = far_voice(SQUARE, -0.6, 0.3, ratio=10.0).part(0.0, PRE_ROLL + 0.35)
    assert abs(wrap(found(sound, SQUARE).azimuth + 0.6)) < math.radians(2)


def test_nobody_need_say_when_the_speech_begins():
    direction = locate(far_voice(SQUARE, 2.0, 0.2), SQUARE)
    assert direction is not None and direction.azimuth == pytest.approx(2.0, abs=0.02)


def test_a_direction_is_stamped_when_it_was_heard():
    assert PRE_ROLL < found(far_voice(SQUARE, 0.0), SQUARE).stamp < PRE_ROLL + 1.0
    late = far_voice(SQUARE, 0.0, stamp=100.0)
    direction = locate(late, SQUARE, speech_from=100.0 + PRE_ROLL)
    assert direction is not None and 100 + PRE_ROLL < direction.stamp < 101.5


def test_silence_and_too_little_sound_have_no_direction():
    assert locate(Sound(stamp=0.0, rate=RATE, samples=np.zeros((RATE, 4))), SQUARE) is None
    with pytest.raises(BadInput, match="too short"):
        locate(Sound(stamp=0.0, rate=RATE, samples=np.zeros((100, 4))), SQUARE)
    broken = np.zeros((RATE, 4))
    broken[5] = np.nan
    with pytest.raises(BadInput, match="no numbers"):
        locate(Sound(stamp=0.0, rate=RATE, samples=broken), SQUARE)


def test_microphones_in_a_line_are_refused():
    line = MicrophoneArray(positions=np.array([[0.0, 0, 0], [0.05, 0, 0], [0.1, 0, 0]]))
    with pytest.raises(BadInput, match="in a line"):
        locate(Sound(stamp=0.0, rate=RATE, samples=np.random.default_rng(0).normal(size=(RATE, 3))), line)


def test_places_that_are_not_exactly_known_widen_the_standard_deviation():
    sound = far_voice(SQUARE, 0.5)
    exact, rough = found(sound, SQUARE), found(sound, replace(SQUARE, position_sd=0.002))
    assert rough.azimuth_sd > exact.azimuth_sd + math.radians(2)


def test_a_flat_arrays_elevation_is_least_sure_near_the_horizon():
    spreads = [found(far_voice(SQUARE, 0.5, up), SQUARE).elevation_sd for up in (0.05, 0.4, 0.9)]
    assert spreads[0] > spreads[1] > spreads[2]


def test_eight_kilohertz_and_forty_eight_are_heard_as_well():
    for rate in (8000, 48000):
        rng = np.random.default_rng(0)
        voice = np.concatenate((np.zeros(rate // 2), rng.normal(size=rate)))
        samples = plane_waves(voice[None], unit(0.9, 0.2)[None], SQUARE.positions, rate)
        sound = Sound(stamp=0.0, rate=rate, samples=samples + 0.01 * rng.normal(size=samples.shape))
        assert found(sound, SQUARE).azimuth == pytest.approx(0.9, abs=0.02)


def test_whitened_noise_has_power_one_and_no_cell_of_it_is_fresh():
    settings = DirectionFindingSettings()
    rng = np.random.default_rng(0)
    seen = spectra(rng.normal(size=(2 * RATE, 4)) @ rng.normal(size=(4, 4)), RATE, settings)
    noise = noise_of(seen, np.ones(len(seen.times), bool), settings)
    power = over_noise(seen, noise)
    assert power.mean() == pytest.approx(1.0, abs=0.25)
    assert np.mean(cell_weights(power, seen, settings) > 0) < 0.005


def test_an_echo_is_not_fresh_but_a_louder_word_is():
    settings = DirectionFindingSettings()
    seen = spectra(np.random.default_rng(0).normal(size=(RATE, 2)), RATE, settings)
    power = np.ones((len(seen.frequencies), len(seen.times)))
    power[:, 20:40] = 1000 * np.exp(-np.arange(20) * 0.16)  # dies as a room of 0.7 s
    power[:, 60] = 1000
    fresh = cell_weights(power, seen, settings)
    assert fresh[:, 20].min() > 0.9 and fresh[:, 21:40].max() == 0 and fresh[:, 60].min() > 0.8


def test_quiet_frames_are_those_before_the_speech_or_else_the_faintest():
    settings = DirectionFindingSettings()
    sound = far_voice(SQUARE, 0.0)
    seen = spectra(sound.samples, RATE, settings)
    before = quiet_frames(seen, settings, PRE_ROLL)
    assert seen.times[before].max() <= PRE_ROLL
    guessed = quiet_frames(seen, settings)
    assert np.mean(before[guessed]) > 0.7


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_slopes_of_steered_power_are_its_finite_differences(dimensions):
    rng = np.random.default_rng(dimensions)
    correlation = Correlation(
        values=rng.normal(size=(40, 6)) + 1j * rng.normal(size=(40, 6)),
        omega=2 * np.pi * np.linspace(500, 4000, 40),
        size=512,
        rate=RATE,
    )
    slant, at, step = rng.normal(scale=1e-4, size=(6, dimensions)), rng.normal(size=dimensions) * 0.3, 1e-5
    gradient, hessian = slopes(correlation, slant, at)
    for axis in range(dimensions):
        aside = np.eye(dimensions)[axis] * step
        change = steered_power(correlation, slant, at + aside) - steered_power(correlation, slant, at - aside)
        assert gradient.sum(0)[axis] == pytest.approx(change / (2 * step), rel=1e-4, abs=1e-4)
        bend = slopes(correlation, slant, at + aside)[0].sum(0) - slopes(correlation, slant, at - aside)[0].sum(0)
        assert hessian[axis] == pytest.approx(bend / (2 * step), rel=1e-3, abs=1e-3)


def test_tangents_are_left_and_up():
    left, up = tangents(unit(0.7, 0.3))
    assert left == pytest.approx(unit(0.7 + math.pi / 2)) and up == pytest.approx(unit(0.7, 0.3 + math.pi / 2))


def test_straight_above_the_azimuth_is_unknown():
    above = Direction(stamp=0.0, towards=np.array([0.0, 0, 1]), covariance=0.01 * np.eye(2), strength=1.0)
    assert above.azimuth_sd == pytest.approx(MAX_AZIMUTH_SD_RAD) and above.elevation == pytest.approx(math.pi / 2)


def test_the_grid_covers_the_sphere_evenly():
    points = sphere(1000)
    near = np.sort(points @ points.T, axis=1)[:, -2]
    assert np.degrees(np.arccos(near)).max() < 1.25 * np.degrees(np.arccos(near)).min() + 1.5
    assert np.abs(points.mean(0)).max() < 1e-3
