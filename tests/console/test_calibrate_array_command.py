"""`beckon calibrate array`: recordings from known sides give the array's turn, or a sentence."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from console.__main__ import main
from core.recording.sound_file import write_wav
from core.sensors.microphones import RESPEAKER_ODAS, Sound, load_array
from core.simulation.acoustics.shoebox import plane_waves
from core.speech.practice_voice import practice_voice

RATE = 16_000
TURNED = 0.6  # [rad]


def recorded(path: Path, azimuth: float) -> str:
    """A voice from `azimuth` [rad] of the robot, into an array that is turned."""
    rng = np.random.default_rng(3)
    dry = np.concatenate((np.zeros(RATE), 0.05 * practice_voice(rng, 0.6, RATE), np.zeros(RATE // 4)))
    angle = azimuth - TURNED
    heard = plane_waves(
        dry[None], np.array([[math.cos(angle), math.sin(angle), 0.0]]), RESPEAKER_ODAS.positions, RATE
    )
    write_wav(path, Sound(stamp=0.0, rate=RATE, samples=heard + 5e-4 * rng.normal(size=heard.shape)))
    return str(path)


def test_the_arrays_turn_comes_out_with_its_doubt_and_as_a_profile(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sides = {"front": 0.0, "left": math.pi / 2, "back": math.pi}
    files = [recorded(tmp_path / f"{name}.wav", azimuth) for name, azimuth in sides.items()]
    options = ["--array", "respeaker-odas", "--azimuths", "0,90,180", "--out", str(tmp_path / "out"), "--json"]
    assert main(["calibrate", "array", *files, *options]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["yaw_rad"] == pytest.approx(TURNED, abs=0.03) and 0 < told["sd_yaw_rad"] < 0.1
    assert not told["mirrored"] and len(told["claps"]) == 3
    profile = load_array(told["files"]["profile"])
    cosine, sine = math.cos(told["yaw_rad"]), math.sin(told["yaw_rad"])
    turned = RESPEAKER_ODAS.positions[:, :2] @ np.array([[cosine, sine], [-sine, cosine]])
    assert np.allclose(profile.positions[:, :2], turned, atol=1e-5)


def test_the_profile_that_it_starts_from_is_not_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = tmp_path / "array.toml"
    profile.write_text("positions_m = [[0, 0, 0], [0.1, 0, 0]]\n")
    options = ["--azimuths", "0", "--array", str(profile), "--out", str(tmp_path)]
    assert main(["calibrate", "array", "a.wav", *options]) == 1
    assert "would take the place of" in capsys.readouterr().err


def test_what_is_missing_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = recorded(tmp_path / "a.wav", 0.0)
    assert main(["calibrate", "array", file, "--array", "respeaker-odas"]) == 1
    assert "1 recordings but 4 azimuths" in capsys.readouterr().err
    assert main(["calibrate", "array", file, "--azimuths", "0", "--array", "respeaker-odas"]) == 1
    assert "3 claps are needed; 1 were heard" in capsys.readouterr().err
