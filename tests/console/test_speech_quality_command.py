"""`beckon speech-quality`: figures, a page, and sentences for what is missing."""

import json
from pathlib import Path

import numpy as np
import pytest

from console.__main__ import main
from core.recording.sound_file import write_wav
from core.sensors.microphones import Sound
from core.speech.practice_voice import practice_voice
from core.speech.quality.marked_text import FIGURE_17_PERSON, FIGURE_17_ROBOT


@pytest.fixture
def texts(tmp_path: Path) -> list[str]:
    """The command line of three texts."""
    told = {
        "original": "start; come; turn left\nstop moving",
        "person": "start come turn left stop moving",
        "robot": "start <b>; come; turn right; moving",
    }
    for name, text in told.items():
        (tmp_path / f"{name}.txt").write_text(text)
    return [part for name in told for part in (f"--{name}", str(tmp_path / f"{name}.txt"))]


def voice(path: Path, noise: float = 0.0) -> str:
    rng = np.random.default_rng(3)
    samples = 0.05 * practice_voice(rng, 2.0, 16_000)
    samples = samples + noise * np.random.default_rng(4).normal(size=len(samples))
    write_wav(path, Sound(stamp=0.0, rate=16_000, samples=samples[:, None]))
    return str(path)


def answer(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    return json.loads(out)


def test_three_texts_give_the_figures_of_the_contract(texts: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["speech-quality", *texts, "--json"]) == 0
    told = answer(capsys)
    assert told["erroneous_words_person"] == 0
    assert told["erroneous_words_robot"] == 3
    assert (told["osqe_d"], told["osqe_r"]) == (-3, 0.0)
    assert isinstance(told["differences"], list)


def test_the_marked_texts_of_figure_17_give_its_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "stt.txt").write_text(FIGURE_17_PERSON)
    (tmp_path / "rev_stt.txt").write_text(FIGURE_17_ROBOT)
    named = ["--person", str(tmp_path / "stt.txt"), "--robot", str(tmp_path / "rev_stt.txt")]
    assert main(["speech-quality", "--marked", *named, "--json"]) == 0
    told = answer(capsys)
    assert (told["osqe_d"], told["osqe_r"]) == (-6, 0.5)


def test_texts_and_recordings_make_a_page_that_needs_nothing_else(
    texts: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sounds = ["--orig-wav", voice(tmp_path / "orig.wav"), "--rev-wav", voice(tmp_path / "rev.wav", 0.01)]
    assert main(["speech-quality", *texts, *sounds, "--out", str(tmp_path / "out"), "--json"]) == 0
    told = answer(capsys)
    audio = told["audio"]
    assert isinstance(audio, dict)
    assert 0.5 < audio["stoi"] < 1
    page = (tmp_path / "out" / "speech_quality.html").read_text()
    assert page.count("data:image/png;base64,") == 2
    assert "http" not in page
    assert "<mark" in page
    assert "<script" not in page
    saved = json.loads((tmp_path / "out" / "speech_quality.json").read_text())
    assert saved["osqe_d"] == told["osqe_d"]


def test_without_json_it_speaks_in_sentences(texts: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["speech-quality", *texts]) == 0
    assert "OSQE_D -3, OSQE_R 0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "Give the three texts"),
        (["--original", "a.txt"], "Three texts belong together"),
        (["--orig-wav", "a.wav"], "Two recordings belong together"),
        (["--marked", "--person", "a.txt"], "both marked texts"),
        (["--original", "no.txt", "--person", "no.txt", "--robot", "no.txt"], "cannot be read"),
    ],
)
def test_what_is_missing_is_said(arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["speech-quality", *arguments]) == 1
    told = capsys.readouterr()
    assert sentence in told.err
    assert told.out == ""


def test_a_text_in_another_code_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.txt").write_bytes(b"\xff\xfe\x00stop")
    one = str(tmp_path / "a.txt")
    assert main(["speech-quality", "--original", one, "--person", one, "--robot", one]) == 1
    assert "a.txt is not a text file in UTF-8" in capsys.readouterr().err
