"""The engines behind the protocols of recognition, what each can do, and the factory that opens the active one."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from core.errors import BadInput, Unavailable
from core.speech.recognition.recognizer import Dictation, KeywordSpotter, Recognizer
from core.speech.settings import SpeechSettings


@dataclass(frozen=True)
class EngineSpec:
    """An engine and what it can do. It is imported when it is opened, so the packages of the others may be absent."""

    package: str  # as pip installs it
    recognizer: str  # "module:class" below core.speech
    dictation: str  # the same
    wheels: tuple[str, ...]  # Python versions for which its package and what it needs come ready-made
    brings_model: bool = False  # otherwise the user supplies a folder
    rejects: bool = False  # compares commands with free text, so that other speech is no command; else: the grammar
    confirms: bool = False  # compares a command with the nearest other one, so that uncertain numbers are confirmed

    @property
    def sentence(self) -> str:
        """Its abilities in a sentence: "It …"."""
        able = [
            "brings its model" if self.brings_model else "needs a model folder",
            "compares commands with free text" if self.rejects else "writes free text, which the grammar rejects",
            "has uncertain numbers confirmed" if self.confirms else "has no uncertain numbers confirmed",
        ]
        return f"It {', '.join(able[:-1])} and {able[-1]}."


ENGINES: dict[str, EngineSpec] = {
    "sphinx": EngineSpec(
        package="pocketsphinx",
        recognizer="sphinx.recognizer:Sphinx",
        dictation="sphinx.dictation:SphinxDictation",
        wheels=("3.11", "3.13"),
        brings_model=True,
        rejects=True,
        confirms=True,
    ),
    "vosk": EngineSpec(
        package="vosk",
        recognizer="recognition.vosk:Vosk",
        dictation="recognition.vosk:Vosk",
        wheels=("3.11", "3.12", "3.13", "3.14"),
    ),
    "faster-whisper": EngineSpec(
        package="faster-whisper",
        recognizer="recognition.faster_whisper:FasterWhisper",
        dictation="recognition.faster_whisper:FasterWhisper",
        wheels=("3.11", "3.12", "3.13", "3.14"),
    ),
    "sherpa": EngineSpec(
        package="sherpa-onnx",
        recognizer="recognition.sherpa:Sherpa",
        dictation="recognition.sherpa:Sherpa",
        wheels=("3.11", "3.12", "3.13", "3.14"),
    ),
}
"""By the name that the settings use."""
DEFAULT = SpeechSettings().engine
HERE = f"{sys.version_info.major}.{sys.version_info.minor}"


@dataclass(frozen=True)
class ActiveEngine:
    """The engine that reads words now."""

    recognizer: Recognizer
    spec: EngineSpec
    why: str  # which one it is, why, and what it can do, in sentences


def open_engine(settings: SpeechSettings) -> ActiveEngine:
    """Open the engine that the settings name. Raises Unavailable or BadInput with a sentence."""
    spec = _spec(settings)
    return ActiveEngine(
        recognizer=_opened(spec, spec.recognizer, settings), spec=spec, why=f"{why(settings)} {spec.sentence}"
    )


def open_dictation(settings: SpeechSettings) -> Dictation:
    """Open the same engine for texts that are compared: it writes down what it hears, sure or not. Raises alike."""
    spec = _spec(settings)
    return _opened(spec, spec.dictation, settings)


def open_keyword_spotter(settings: SpeechSettings) -> KeywordSpotter:
    """Open what spots STOP in running sound. It is pocketsphinx for every engine: none of the others spots keywords.

    Raises Unavailable with a sentence.
    """
    return _class("sphinx.keyword_spotting:SphinxKeywordSpotter")(settings)


def why(settings: SpeechSettings) -> str:
    """Which engine reads the words and why, in a sentence. Raises BadInput where there is none of that name."""
    spec = _spec(settings)
    if settings.engine == DEFAULT:
        return f"{spec.package} reads the words: it is the default; [speech] engine chooses another."
    return f"{spec.package} reads the words: [speech] engine names it; {ENGINES[DEFAULT].package} spots STOP."


def _spec(settings: SpeechSettings) -> EngineSpec:
    if settings.engine not in ENGINES:
        raise BadInput(f"There is no engine {settings.engine[:40]!r}; there are {', '.join(ENGINES)}.")
    return ENGINES[settings.engine]


def _opened(spec: EngineSpec, path: str, settings: SpeechSettings) -> Any:
    given = settings if spec.brings_model else folder_of(settings)
    try:
        return _class(path)(given)
    except Unavailable as absent:
        raise Unavailable(f"{str(absent).removesuffix('.')}.{without_wheel(spec)}") from None


def without_wheel(spec: EngineSpec, python: str = HERE) -> str:
    """How to install the package where it has to be built from source, in a sentence; "" where it is ready-made."""
    if python in spec.wheels:
        return ""
    ready = " or ".join(spec.wheels)
    return (
        f" There is no ready-made package for Python {python}: install a C compiler and CMake first, or run Beckon "
        f"on Python {ready}."
    )


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


def _class(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(import_module(f"core.speech.{module}"), name)
