"""The experiment `speech-quality`: Fig. 17, and figures that fall with noise and distance."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.errors import Unavailable
from core.experiments import EXPERIMENTS, speech_quality
from core.experiments.speech_loop import lag_of, run_loop, save_loop, track_of
from core.experiments.speech_quality import (
    FIGURE_17_PHRASES,
    Setting,
    SpokenPhraseFigures,
    figure_17,
    measure,
    remarks,
    responses_at,
    spoken,
    voice_figures,
)
from core.models import MODEL, find
from core.recording.sound_file import read_sound
from core.speech.recognition.engines import open_free_dictation
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import SpeechSettings
from core.speech.synthesis import NATURAL_WORDS_MIN, can_speak


@pytest.mark.parametrize("sweep", ["noise", "distance"])
def test_the_recordings_get_worse_with_noise_and_distance(sweep: str) -> None:
    said = spoken(np.random.default_rng(0), speech_quality.TEXT[:6])
    places = [
        Setting(sweep=sweep, ratio=ratio, distance=distance)
        for ratio, distance in {
            "noise": ((30, 1.0), (10, 1.0), (0, 1.0)),
            "distance": ((30, 0.3), (30, 1.0), (30, 4.0)),
        }[sweep]
    ]
    told = [measure(None, said, "", responses_at(place), place.ratio, 0) for place in places]
    assert all(quality is None for quality, _ in told)
    left = [similarity.figures["estoi"] or 0 for _, similarity in told]
    assert left[0] > left[1] > left[2]


def test_without_words_figure_17_and_the_recordings_remain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speech_quality, "can_speak", lambda: False)
    monkeypatch.setattr(speech_quality, "SETTINGS", speech_quality.SETTINGS[6:8])
    one_less = speech_quality.FIGURE_17_ROBOT.replace("=moving=", "moving")
    monkeypatch.setattr(speech_quality, "FIGURE_17_ROBOT", one_less)
    told: Any = EXPERIMENTS["speech-quality"](runs=1, seed=1, out=tmp_path)
    assert (told["figure_17"]["osqe_d"], told["figure_17"]["osqe_r"]) == (-5, 6 / 11)
    assert "pip install" in told["words_missing"]
    assert len(told["sweep"]) == 2
    assert all(Path(file).stat().st_size for file in told["files"].values())


@pytest.mark.campaign
def test_the_robot_hears_worse_in_more_noise() -> None:
    told: Any = EXPERIMENTS["speech-quality"](seed=0)
    noisy = [row["osqe_d"] for row in told["sweep"] if row["sweep"] == "noise"]
    assert noisy[0] > noisy[-1]
    assert all(after <= before + 2 for before, after in pairwise(noisy))


def test_every_phrase_has_a_voice_of_its_own_and_the_best_and_the_worst_are_named() -> None:
    one, again = (spoken(np.random.default_rng(5), speech_quality.TEXT) for _ in range(2))
    assert [(said.voice, said.pace) for said in one] == [(said.voice, said.pace) for said in again]
    if can_speak():
        assert len({said.voice for said in one}) > 3
        assert all(
            said.pace + 0.5 >= 0.85 * NATURAL_WORDS_MIN and said.pace - 0.5 <= 1.15 * NATURAL_WORDS_MIN
            for said in one
        )
    told: list[SpokenPhraseFigures] = [
        {
            "text": text,
            "voice": voice,
            "pace_words_min": 175,
            "erroneous_words_person": 0,
            "erroneous_words_robot": wrong,
        }
        for text, voice, wrong in (("turn left", "a", 1), ("come here", "b", 4), ("follow me", "a", 0))
    ]
    figures = voice_figures(told, 3)
    assert figures["a"] == {"phrases": 2, "words": 12, "robot_right_rate": 1 - 1 / 12}
    assert figures["b"]["robot_right_rate"] == pytest.approx(1 / 3)
    assert [line[:13] for line in remarks(figures)[-2:]] == ["best voice a:", "worst voice b"]


def test_the_loop_keeps_its_recordings_and_texts_under_the_papers_names(tmp_path: Path) -> None:
    said = spoken(np.random.default_rng(3), ("turn left", "come here"))
    track = track_of(("turn left", "come here"), [one.dry for one in said])
    late = np.concatenate((np.zeros(3000), 0.3 * track.samples, np.zeros(8000)))
    assert lag_of(track, late) == pytest.approx(3000, abs=2)
    result = run_loop(Echo(), track, track.samples, late, lag_of(track, late))
    assert result.quality.score["erroneous_words_person"] == 0 == result.quality.score["erroneous_words_robot"]
    save_loop(tmp_path, result)
    assert (tmp_path / "stt.txt").read_text() == (tmp_path / "rev_stt.txt").read_text() == "turn left; come here\n"
    assert read_sound(tmp_path / "rev.wav").duration > read_sound(tmp_path / "orig.wav").duration


class Echo:
    """Knows the sentences by their order."""

    def __init__(self) -> None:
        self._texts = iter(("turn left", "come here") * 2)

    def transcribe(self, utterance: Utterance) -> str:
        assert utterance.sound.samples.std() > 1e-4
        return next(self._texts)


@pytest.mark.campaign
def test_the_sentences_of_figure_17_are_spoken_and_read_by_a_recognizer_of_any_words() -> None:
    if not can_speak() or find(MODEL) is None:
        pytest.skip("needs the extra voice and beckon models get whisper-tiny.en")
    result = figure_17(open_free_dictation(SpeechSettings()), 0, FIGURE_17_PHRASES[:3])
    assert result.quality.person.phrases == 3
    assert result.quality.person.errors < result.quality.person.words
    with pytest.raises(Unavailable, match="nothing but commands"):
        open_free_dictation(SpeechSettings(engine="sphinx"))
