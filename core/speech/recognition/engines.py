"""The engines behind the protocols of recognition, and the factory that opens the active one."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.models import MODEL, MODELS, checked_folder, find
from core.speech.recognition.recognizer import Dictation, KeywordSpotter, NameOpinion, Recognizer
from core.speech.settings import SpeechSettings
from core.speech.understanding.grammar import OwnPhrases
from core.speech.understanding.own_phrases import own_phrases

SPHINX = "pocketsphinx"  # package and module


@dataclass(frozen=True)
class EngineSpec:
    """An engine. It is imported when it is opened, so the packages of the others may be absent."""

    name: str  # as the settings name it
    says: str  # what it is and can do, in a sentence
    recognizer: str  # "module:class" below core.speech; made from what `given` returns
    dictation: str  # the same
    writes_any_words: bool  # else it writes down the sentence of the grammar that fits best
    given: Callable[[SpeechSettings], tuple[Any, ...]]  # raises Unavailable where the engine is not here


@dataclass(frozen=True)
class ActiveEngine:
    """The engine that reads words now."""

    recognizer: Recognizer
    spec: EngineSpec
    why: str  # which one it is, why, and what it can do, in sentences


def open_engine(settings: SpeechSettings) -> ActiveEngine:
    """Open the engine that the settings name. Raises Unavailable or BadInput with a sentence."""
    spec = chosen(settings)
    why = f"{spec.says} {_why(settings, spec)}"
    if settings.phrases and spec.name != "whisper":
        why += " Your own phrases are not heard: they need Whisper."
    return ActiveEngine(recognizer=_class(spec.recognizer)(*spec.given(settings)), spec=spec, why=why)


def open_dictation(settings: SpeechSettings) -> Dictation:
    """Open the same engine for texts that are compared: it writes down what it hears, sure or not. Raises alike."""
    spec = chosen(settings)
    return _class(spec.dictation)(*spec.given(settings))


def open_free_dictation(settings: SpeechSettings) -> Dictation:
    """Open an engine that writes down any words: it knows nothing of commands then. Raises alike."""
    spec = chosen(settings)
    if not spec.writes_any_words:
        raise Unavailable(f"{spec.name} writes nothing but commands; for free words: {how_to_get()}")
    return open_dictation(settings)


def open_keyword_spotter(settings: SpeechSettings, recognizer: Recognizer) -> KeywordSpotter:
    """Open what spots STOP in running sound: pocketsphinx where it is installed, else the recognizer itself.

    Raises Unavailable with a sentence.
    """
    if has_sphinx() or settings.engine == "sphinx":
        return _class("sphinx.keyword_spotting:SphinxKeywordSpotter")(settings)
    return _class("whisper.keyword_spotting:WhisperKeywordSpotter")(recognizer)


def has_sphinx() -> bool:
    """Return whether pocketsphinx is installed."""
    return importlib.util.find_spec(SPHINX) is not None


def chosen(settings: SpeechSettings) -> EngineSpec:
    """Return the engine that reads the words. Raises Unavailable where there is none, BadInput."""
    if settings.engine != "auto":
        return ENGINES[settings.engine]
    if settings.model or find(MODEL) is not None:
        return ENGINES["whisper"]
    if has_sphinx():
        return ENGINES["sphinx"]
    raise Unavailable(f"Nothing here reads words. {how_to_get()}")


def how_to_get() -> str:
    """How to get the recognizer of human voices, in a sentence."""
    return f"Run: beckon models get {MODEL} ({MODELS[MODEL].megabytes} MB), then listen again."


def _why(settings: SpeechSettings, spec: EngineSpec) -> str:
    if settings.engine != "auto":
        return "[speech] engine names it."
    if spec.name == "whisper":
        return "[speech] model names its folder." if settings.model else "Its model is here."
    return f"For human voices another one is better. {how_to_get()}"


def model_folder(settings: SpeechSettings) -> Path:
    """The folder with Whisper's model: that of the settings, else what is here. Raises Unavailable, BadInput."""
    if settings.model:
        folder = Path(settings.model).expanduser()
        if not folder.is_dir():
            raise Unavailable(
                f"The model folder {folder.name[:60]!r} of [speech] model is not there; correct the path."
            )
        absent = [name for name in MODELS[MODEL].files if not (folder / name).is_file()]
        if absent:
            raise BadInput(
                f"The folder {folder.name[:60]!r} of [speech] model holds no {' and no '.join(absent)}; it must be a "
                "faster-whisper model for English alone."
            )
        return folder
    found = find(MODEL)
    if found is None:
        raise Unavailable(f"The model {MODEL} is not here. {how_to_get()}")
    return checked_folder(found, MODEL)


def _given_to_whisper(settings: SpeechSettings) -> tuple[Path, OwnPhrases, NameOpinion | None]:
    """Return the folder and phrases from which Whisper is made, and who else is asked about names: pocketsphinx where
    it is installed. Raises Unavailable, BadInput.
    """
    names = _class("sphinx.name_opinion:SphinxNameOpinion")(settings) if has_sphinx() else None
    return model_folder(settings), own_phrases(settings.phrases), names


def _whole_settings(settings: SpeechSettings) -> tuple[SpeechSettings]:
    """Return the settings of pocketsphinx, which brings its model. Raises Unavailable where it is not installed."""
    if not has_sphinx():
        raise Unavailable(f"pocketsphinx is not installed: {install_extra('speech')}. Or better: {how_to_get()}")
    return (settings,)


def _class(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(import_module(f"core.speech.{module}"), name)


ENGINES = {
    "whisper": EngineSpec(
        name="whisper",
        says="Whisper reads the words: it understands people, and compares commands with free text.",
        recognizer="whisper.recognizer:WhisperRecognizer",
        dictation="whisper.recognizer:WhisperRecognizer",
        writes_any_words=True,
        given=_given_to_whisper,
    ),
    "sphinx": EngineSpec(
        name="sphinx",
        says="pocketsphinx reads the words: it brings its model, and understands clear voices at a short distance.",
        recognizer="sphinx.recognizer:Sphinx",
        dictation="sphinx.recognizer:SphinxDictation",
        writes_any_words=False,
        given=_whole_settings,
    ),
}
"""By the name that the settings use."""
