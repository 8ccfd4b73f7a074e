"""Engines that are optional: a sentence for everything that is not there."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import pytest

from core.errors import BadInput, BeckonError, Unavailable
from core.settings import Settings, read
from core.speech.recognition import engines
from core.speech.recognition.engines import ENGINES, open_dictation, open_engine, without_wheel
from core.speech.recognition.sherpa import Sherpa
from core.speech.settings import SpeechSettings
from core.speech.transcription.transcriber import Transcriber

ROOT = Path(__file__).parents[3]
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


@pytest.mark.parametrize("engine", ENGINES)
def test_the_factory_says_which_engine_is_active_and_why(engine, tmp_path, monkeypatch):
    monkeypatch.setattr(engines, "_class", lambda path: lambda given: (path, given))
    settings = SpeechSettings(engine=engine, model=str(tmp_path))
    active = open_engine(settings)
    spec = ENGINES[engine]
    assert active.spec is spec and active.why.startswith(f"{spec.package} reads the words: ")
    assert ("default" in active.why) == (engine == "sphinx") and active.why.endswith(".")
    assert active.recognizer == (spec.recognizer, settings if spec.brings_model else tmp_path)
    assert open_dictation(settings)[0] == spec.dictation
    assert (
        ("brings its model" in active.why)
        == ("has uncertain numbers confirmed" in active.why)
        == (engine == "sphinx")
    )


def test_the_wheels_of_the_default_engine_are_those_that_the_project_declares():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    (line,) = (one for one in declared if one.startswith("pocketsphinx"))
    assert tuple(re.findall(r"python_version == '([\d.]+)'", line)) == ENGINES["sphinx"].wheels


def test_where_an_engine_has_no_wheel_its_absence_says_how_to_build_it(monkeypatch):
    assert without_wheel(ENGINES["sphinx"], "3.13") == ""
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)
    monkeypatch.setattr(engines, "without_wheel", lambda spec: without_wheel(spec, "3.12"))
    with pytest.raises(Unavailable, match=r"pip install .* for Python 3\.12: install a C compiler and CMake"):
        open_engine(SpeechSettings())


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
