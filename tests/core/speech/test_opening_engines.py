"""Engines that are optional: a sentence for everything that is not there."""

from __future__ import annotations

import sys

import pytest

from core.errors import BadInput, BeckonError, Unavailable
from core.settings import Settings, read
from core.speech.recognition.engines import ENGINES, open_engine
from core.speech.recognition.sherpa import Sherpa
from core.speech.settings import SpeechSettings
from core.speech.transcription.transcriber import Transcriber

OPTIONAL = [name for name in ENGINES if name != "sphinx"]
PACKAGES = {"vosk": "vosk", "faster-whisper": "faster_whisper", "sherpa": "sherpa_onnx"}


@pytest.mark.parametrize("engine", OPTIONAL)
def test_without_a_model_an_engine_says_where_to_write_its_folder(engine):
    with pytest.raises(Unavailable, match=r"\[speech\] model"):
        open_engine(SpeechSettings(engine=engine))


@pytest.mark.parametrize("engine", OPTIONAL)
def test_a_model_folder_that_is_not_there_is_named(engine, tmp_path):
    with pytest.raises(Unavailable, match="'absent' of"):
        open_engine(SpeechSettings(engine=engine, model=str(tmp_path / "absent")))


@pytest.mark.parametrize("engine", OPTIONAL)
def test_an_absent_package_is_told_with_the_command_that_installs_it(engine, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, PACKAGES[engine], None)
    with pytest.raises(Unavailable, match="pip install"):
        open_engine(SpeechSettings(engine=engine, model=str(tmp_path)))


def test_an_empty_folder_is_no_model(tmp_path, monkeypatch):
    for engine in OPTIONAL:
        with pytest.raises(BeckonError) as told:
            open_engine(SpeechSettings(engine=engine, model=str(tmp_path)))
        assert str(told.value).endswith((".", ")."))
    monkeypatch.setitem(sys.modules, "sherpa_onnx", sys)
    with pytest.raises(BadInput, match="encoder"):
        Sherpa(tmp_path)


def test_without_pocketsphinx_hearing_words_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)
    with pytest.raises(Unavailable, match="pip install"):
        Transcriber(SpeechSettings())


def test_the_engine_is_chosen_by_the_settings_and_unknown_ones_are_refused():
    assert Settings().speech.engine == "sphinx"
    chosen = read('[speech]\nengine = "vosk"\nmodel = "/models/vosk-small"\n').speech
    assert (chosen.engine, chosen.model) == ("vosk", "/models/vosk-small")
    with pytest.raises(BadInput, match="faster-whisper"):
        read('[speech]\nengine = "cloud"\n')
