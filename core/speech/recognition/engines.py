"""The engines that can read an utterance, and the one that the settings name."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from core.errors import BadInput, Unavailable
from core.speech.recognition.recognizer import Engine
from core.speech.settings import SpeechSettings

ENGINES: dict[str, Callable[[SpeechSettings], Engine]] = {
    "sphinx": lambda settings: _named("sphinx.recognizer", "Sphinx")(settings),
    "vosk": lambda settings: _named("recognition.vosk", "Vosk")(folder_of(settings)),
    "faster-whisper": lambda settings: _named("recognition.faster_whisper", "FasterWhisper")(folder_of(settings)),
    "sherpa": lambda settings: _named("recognition.sherpa", "Sherpa")(folder_of(settings)),
}
"""Engine → how it is opened. Each is imported when it is asked for, so the packages of the others may be absent."""


def open_engine(settings: SpeechSettings) -> Engine:
    """The engine that the settings name. Raises Unavailable or BadInput with a sentence."""
    if settings.engine not in ENGINES:
        raise BadInput(f"There is no engine {settings.engine[:40]!r}; there are {', '.join(ENGINES)}.")
    return ENGINES[settings.engine](settings)


def open_writer(settings: SpeechSettings) -> Engine:
    """The engine for texts that are compared: it writes down what it hears, sure or not. Raises as `open_engine`."""
    if settings.engine != "sphinx":
        return open_engine(settings)
    return _named("sphinx.dictation", "Dictation")(settings)


def folder_of(settings: SpeechSettings) -> Path:
    """The folder with the engine's model. Raises Unavailable when none was given or it is not there."""
    if not settings.model:
        raise Unavailable(
            f"The engine {settings.engine} needs a model that you supply: download one, and write its folder into "
            'the settings, [speech] model = "/path/to/the/folder".'
        )
    folder = Path(settings.model).expanduser()
    if not folder.is_dir():
        raise Unavailable(f"The model folder {folder.name[:60]!r} of [speech] model is not there; correct the path.")
    return folder


def package(name: str, install: str) -> Any:
    """An optional package. Raises Unavailable with the command that installs it."""
    try:
        return import_module(name)
    except (ImportError, OSError) as trouble:
        raise Unavailable(f"This engine needs the package {install}: pip install {install} ({trouble}).") from None


def _named(module: str, name: str) -> Any:
    return getattr(import_module(f"core.speech.{module}"), name)
