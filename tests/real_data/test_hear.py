"""`beckon hear` on the rooms and the board: the same figures as the estimator by itself."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from core.geometry import wrap
from core.perception.sound.utterances import directions
from core.recording.sound_file import read_sound
from core.sensors.microphones import RESPEAKER_BOARD, RESPEAKER_ODAS, MicrophoneArray, tetrahedron

pytestmark = pytest.mark.real_data


@pytest.mark.parametrize(("array", "first"), [(RESPEAKER_ODAS, 0), (tetrahedron(), 4)], ids=["square", "tetrahedron"])
def test_talkers_in_rooms_are_found_without_being_told_when_they_begin(
    shared_data: Path, array: MicrophoneArray, first: int
) -> None:
    folder = shared_data / "doa_sim_rooms"
    placed = MicrophoneArray(positions=array.positions, channels=tuple(range(first, first + 4)))
    errors: list[float] = []
    for row in csv.DictReader((folder / "index.tsv").open(), delimiter="\t"):
        (one,) = directions(read_sound(folder / row["file"]), placed)
        errors.append(abs(math.degrees(wrap(one.azimuth - math.radians(float(row["azimuth_deg"]))))))
    assert np.median(errors) < 2
    assert max(errors) < 5


def test_who_speaks_all_the_time_is_found_too(shared_data: Path) -> None:
    sound = read_sound(shared_data / "doa_respeaker_multissl" / "a180e20_150cm_00.flac")
    for one in directions(sound, RESPEAKER_BOARD):
        assert abs(math.degrees(wrap(one.azimuth - math.pi))) < 2
