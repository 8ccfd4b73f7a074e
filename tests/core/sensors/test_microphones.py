"""Sounds and array profiles."""

import numpy as np
import pytest

from core.errors import BadInput
from core.sensors.microphones import (
    ARRAYS,
    RESPEAKER_BOARD,
    RESPEAKER_ODAS,
    MicrophoneArray,
    Sound,
    array_of,
    load_array,
    tetrahedron,
)

SQUARE = "positions_m = [[0.1, 0, 0], [0, 0.1, 0], [-0.1, 0, 0], [0, -0.1, 0]]\n"


def test_the_two_published_frames_of_the_respeaker_are_one_board_turned_by_45_degrees():
    turn = np.radians(45)
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    turned = RESPEAKER_BOARD.positions @ matrix.T
    gaps = np.linalg.norm(turned[:, None] - RESPEAKER_ODAS.positions, axis=2).min(1)
    assert gaps.max() < 0.0005


def test_dimensions_tell_a_line_a_plane_and_a_volume():
    assert [ARRAYS[name].dimensions for name in ("respeaker-odas", "tetrahedron", "ring-6")] == [2, 3, 2]
    assert MicrophoneArray(positions=np.array([[0.0, 0, 0], [0.1, 0, 0], [0.3, 0, 0]])).dimensions == 1
    assert RESPEAKER_ODAS.normal == pytest.approx([0, 0, 1])


def test_the_nearer_microphone_leads_by_the_way_between_them():
    lags = RESPEAKER_ODAS.baselines @ [1.0, 0, 0] / RESPEAKER_ODAS.speed
    pair = RESPEAKER_ODAS.pairs.tolist().index([0, 2])
    assert lags[pair] == pytest.approx(0.064 / 343)


def test_a_profile_in_toml_says_positions_channels_and_more(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        SQUARE + 'channels = [2, 3, 4, 5]\nname = "mine"\nsample_rate_hz = 16000\nspeed_of_sound_m_s = 340.0'
    )
    array = load_array(path)
    assert array.channels == (2, 3, 4, 5) and array.name == "mine" and array.rate == 16000 and array.speed == 340
    sound = Sound(stamp=0.0, rate=16000, samples=np.arange(12.0).reshape(2, 6))
    assert array.heard(sound).tolist() == [[2, 3, 4, 5], [8, 9, 10, 11]]


def test_profiles_by_name_need_no_file():
    assert load_array("tetrahedron") is ARRAYS["tetrahedron"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "needs positions_m"),
        ("positions_m = [[0, 0]]", "rows of three"),
        ("positions_m = [[0, 0, 0]]", "2 to 256"),
        ("positions_m = 'here'", "rows of three"),
        ("positions_m = [[0, 0, nan], [1, 0, 0]]", "finite"),
        (f"positions_m = [[0, 0, 1{400 * '0'}], [1, 0, 0]]", "finite"),
        ("positions_m = [[0, 0, 0], [64, 0, 0]]", "metres"),
        ("positions_m = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]", "0 and 1 .* at one place"),
        ("positions_m = [[0, 0, 0], [0.1, 0, 0], [0.1, 0, 0]]", "1 and 2 .* at one place"),
        ("positions_m = [[0, 0, 0], [0.000032, 0, 0]]", "within 0.032 mm"),
        ("positions_m = [[5, 0, 0], [-5, 0, 0], [0, 5, 0]]", "10 m apart"),
        (SQUARE + "channels = [0, 1, 2]", "4 positions but 3 channels"),
        (SQUARE + "channels = [0, 1, 2, 2]", "different channel"),
        (SQUARE + "channels = [0, 1, 2, -1]", "different channel"),
        (SQUARE + "channels = [0, 1, 2, 1.5]", "whole"),
        (SQUARE + "channels = [0, 1, 2, true]", "whole"),
        (SQUARE + "sample_rate_hz = 100", "sample_rate_hz"),
        (SQUARE + "speed_of_sound_m_s = 0", "speed of sound"),
        (SQUARE + "gain = 3", "unknown key 'gain'"),
        (SQUARE + "name = 3", "short text"),
        ("positions_m = [[", "not valid TOML"),
        ("positions_m = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_profiles_that_cannot_be_are_refused_in_a_sentence(tmp_path, text, words):
    path = tmp_path / "array.toml"
    path.write_text(text)
    with pytest.raises(BadInput, match=words):
        load_array(path)


def test_a_profile_that_is_no_text_or_is_absent_is_refused(tmp_path):
    (tmp_path / "b.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "huge.toml").write_bytes(b"#" * 200_000)
    for name, words in (("b.toml", "not a text file"), ("none.toml", "respeaker-odas"), ("huge.toml", "too large")):
        with pytest.raises(BadInput, match=words):
            load_array(tmp_path / name)


def test_a_sound_that_does_not_fit_the_array_is_refused():
    with pytest.raises(BadInput, match="1 channel, but"):
        tetrahedron().heard(Sound(stamp=0.0, rate=16000, samples=np.zeros((10, 1))))
    with pytest.raises(BadInput, match="8000 Hz"):
        array_of({"positions_m": tetrahedron().positions.tolist(), "sample_rate_hz": 16000}).heard(
            Sound(stamp=0.0, rate=8000, samples=np.zeros((10, 4)))
        )


def test_a_part_of_a_sound_keeps_its_time():
    sound = Sound(stamp=10.0, rate=1000, samples=np.arange(1000.0)[:, None])
    part = sound.part(10.25, 10.5)
    assert part.stamp == pytest.approx(10.25) and len(part.samples) == 250 and part.samples[0, 0] == 250
    assert len(sound.part(12.0, 13.0).samples) == 0


@pytest.mark.parametrize("samples", [np.zeros(5), np.zeros((5, 0))])
def test_a_sound_has_channels(samples):
    with pytest.raises(BadInput):
        Sound(stamp=0.0, rate=16000, samples=samples)
