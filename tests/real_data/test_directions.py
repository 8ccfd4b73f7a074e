"""Directions on recordings: rooms, measured lags, a ReSpeaker, and the trap of identical channels."""

import csv
import json
import math
from collections.abc import Sequence

import numpy as np
import pytest

from core.geometry import wrap
from core.perception.sound.array_diagnostics import check
from core.perception.sound.doa_stream import DoaStream
from core.perception.sound.least_squares import fit_lags
from core.perception.sound.locate import locate
from core.perception.sound.multi_source import talkers
from core.perception.sound.paper import locate_as_printed
from core.recording.sound_file import read_sound
from core.sensors.microphones import RESPEAKER_BOARD, RESPEAKER_ODAS, MicrophoneArray, Sound, tetrahedron
from tests.core.perception.lags import direction_from_lags

pytestmark = pytest.mark.real_data

SPEECHBRAIN = [[-0.05, -0.05, 0], [-0.05, 0.05, 0], [0.05, 0.05, 0], [0.05, 0.05, 0]]


def degrees_off(azimuth: float, truth_deg: float) -> float:
    return abs(math.degrees(wrap(azimuth - math.radians(truth_deg))))


@pytest.fixture(scope="module")
def rooms(shared_data):
    folder = shared_data / "doa_sim_rooms"
    with open(folder / "index.tsv", newline="") as file:
        return [(read_sound(folder / row["file"]), row) for row in csv.DictReader(file, delimiter="\t")]


def of(array: MicrophoneArray, first: int, sound: Sound) -> Sound:
    return Sound(stamp=0.0, rate=sound.rate, samples=sound.samples[:, first : first + len(array.positions)])


@pytest.mark.parametrize(("array", "first"), [(RESPEAKER_ODAS, 0), (tetrahedron(), 4)], ids=["square", "tetrahedron"])
def test_in_rooms_the_median_error_is_below_two_degrees_and_nothing_is_beyond_ten(rooms, array, first):
    errors, inside = [], []
    for sound, row in rooms:
        direction = locate(of(array, first, sound), array, speech_from=0.5)
        assert direction is not None
        errors.append(degrees_off(direction.azimuth, float(row["azimuth_deg"])))
        inside.append(errors[-1] < 2 * math.degrees(direction.azimuth_sd))
    assert np.median(errors) <= 2 and max(errors) < 10
    assert np.mean(inside) >= 0.75


def test_as_printed_the_estimator_errs_as_the_description_of_the_rooms_says(rooms):
    told = [26.5, 75.6, 34.3, 171.4, 29.0, 51.3, 2.3, 107.5]
    for (sound, row), error in zip(rooms, told, strict=True):
        direction = locate_as_printed(of(RESPEAKER_ODAS, 0, sound), RESPEAKER_ODAS)
        assert degrees_off(direction.azimuth, float(row["azimuth_deg"])) == pytest.approx(error, abs=0.5)


@pytest.mark.parametrize(
    ("array", "first"),
    [
        pytest.param(RESPEAKER_ODAS, 0, id="square"),
        pytest.param(tetrahedron(), 4, id="tetrahedron", marks=pytest.mark.campaign),
    ],
)
def test_listening_tells_the_direction_within_half_a_second_of_the_first_word(rooms, array, first):
    errors = []
    for sound, row in rooms:
        listener, own = DoaStream(array), of(array, first, sound)
        pieces = (own.part(at / 16000, (at + 320) / 16000) for at in range(0, 40000, 320))
        when, heard = next((piece.stamp + piece.duration, one) for piece in pieces for one in listener.feed(piece))
        assert 0.5 < heard.begin < 1.2 and when - heard.begin < 0.45
        errors.append(degrees_off(heard.directions[0].azimuth, float(row["azimuth_deg"])))
    assert np.median(errors) < 2 and max(errors) < 10


@pytest.fixture(scope="module")
def pyramic(shared_data):
    return json.loads((shared_data / "doa_pyramic_tdoa" / "pyramic_tdoa.json").read_text())


EVERY = pytest.mark.parametrize("every", [6, pytest.param(1, marks=pytest.mark.campaign)])


def from_lags(pyramic, geometry: str, truth: str, position_sd: float, chosen: Sequence[int] = range(48), every=1):
    """Angles to the truth and standard deviations [deg] of every so many'th measurement."""
    chosen = list(chosen)
    places = np.array(pyramic[geometry])[chosen]
    array = MicrophoneArray(positions=places, speed=pyramic["sound_speed_mps"], position_sd=position_sd)
    pairs = np.array([[0, other] for other in range(1, len(chosen))])
    told = []
    for one in pyramic["measurements"][::every]:
        arrivals = np.concatenate(([0.0], one["tdoa_s"]))[chosen]
        direction = direction_from_lags(array, pairs, arrivals[0] - arrivals[1:])
        sd = math.degrees(math.sqrt(np.trace(direction.covariance) / 2))
        told.append((math.degrees(direction.angle_to(np.array(one[truth]))), sd))
    return np.array(told).T


@EVERY
def test_measured_lags_of_48_microphones_give_the_direction_whatever_one_of_them_says(pyramic, every):
    errors, spreads = from_lags(pyramic, "mics_calibrated_m", "doa_calibrated", 0.0005, every=every)
    assert np.median(errors) <= 0.1 and errors.max() <= 0.5
    assert np.mean(errors < 2 * spreads) > 0.95 and np.median(spreads) < 0.6


def test_four_of_the_48_microphones_suffice(pyramic):
    errors, spreads = from_lags(pyramic, "mics_calibrated_m", "doa_calibrated", 0.0005, (0, 23, 31, 39))
    assert np.percentile(errors, 95) <= 1.2 and np.mean(errors < 2 * spreads) > 0.85


@EVERY
def test_a_geometry_measured_by_hand_costs_degrees_and_the_standard_deviation_says_so(pyramic, every):
    errors, spreads = from_lags(pyramic, "mics_manual_m", "doa_manual", 0.004, every=every)
    assert np.median(errors) <= 3 and 2 < np.median(spreads) < 5 and np.mean(errors < 2 * spreads) > 0.95


def test_plain_least_squares_is_thrown_by_the_wrong_lags_that_are_left(pyramic):
    array = MicrophoneArray(positions=np.array(pyramic["mics_calibrated_m"]), speed=pyramic["sound_speed_mps"])
    pairs = np.array([[0, other] for other in range(1, 48)])
    lags = -np.array(pyramic["measurements"][0]["tdoa_s"])
    lags[7] = -lags[7] + 2e-4
    truth = np.array(pyramic["measurements"][0]["doa_calibrated"])
    plain, robust = (fit_lags(array, pairs, lags, robust).towards @ truth for robust in (False, True))
    assert math.degrees(math.acos(min(1, robust))) < 0.3 < math.degrees(math.acos(min(1, plain)))


@pytest.mark.parametrize("name", ["a180e20_150cm_00", "a180e20_250cm_02", "a180e20_50cm_04"])
def test_one_talker_on_the_respeaker_is_within_two_degrees(shared_data, name):
    sound = read_sound(shared_data / "doa_respeaker_multissl" / f"{name}.flac")
    direction = locate(sound, RESPEAKER_BOARD)
    assert direction is not None and degrees_off(direction.azimuth, 180) < 2
    assert math.degrees(direction.elevation) == pytest.approx(20, abs=5)
    assert len(talkers(sound, RESPEAKER_BOARD, most=3)) == 1


@pytest.mark.parametrize("name", ["150cm_06", "250cm_08", "50cm_10"])
def test_two_talkers_on_the_respeaker_are_both_found(shared_data, name):
    sound = read_sound(shared_data / "doa_respeaker_multissl" / f"a180e20_a225e35_{name}.flac")
    found = talkers(sound, RESPEAKER_BOARD, most=3)
    assert len(found) == 2
    for truth in (180, 225):
        assert min(degrees_off(one.azimuth, truth) for one in found) < 5


def test_of_three_talkers_most_are_found(shared_data):
    hits = 0
    for name in ("150cm_12", "250cm_14", "50cm_16"):
        sound = read_sound(shared_data / "doa_respeaker_multissl" / f"a180e20_a225e35_a270e50_{name}.flac")
        found = talkers(sound, RESPEAKER_BOARD, most=3)
        hits += sum(min(degrees_off(one.azimuth, truth) for one in found) < 10 for truth in (180, 225, 270))
    assert hits >= 8


def test_the_identical_channels_are_reported_and_the_direction_is_right_all_the_same(shared_data):
    sound = read_sound(shared_data / "doa_speechbrain_multimic" / "speech_-0.98894_0_0.14834.flac")
    array = MicrophoneArray(positions=np.array(SPEECHBRAIN))
    sentences = [one.sentence for one in check(sound, array)]
    assert any("Channels 3 and 4 are identical" in one for one in sentences)
    direction = locate(sound, array)
    assert direction is not None and degrees_off(direction.azimuth, 180) < 1
