"""Transcripts of all speech, whether accepted as a command or not: the texts that OSQE compares (Figs. 10, 11).

A recognizer that moves a robot refuses whole sentences as soon as it is not sure. Compared with it, a text would
measure its caution; here every sound is written down as the sentence of the grammar that fits it best.
"""

from core.speech.recognition.recognizer import Utterance
from core.speech.settings import SpeechSettings
from core.speech.sphinx.decoded_path import decoded
from core.speech.sphinx.decoder import grammar_decoder
from core.speech.sphinx.jsgf import plain_grammar
from core.speech.sphinx.recognizer import options_of, views_of


class SphinxDictation:
    """Always a sentence of the grammar."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Raises Unavailable when pocketsphinx is not installed."""
        self._settings = settings or SpeechSettings()
        self._decoder = grammar_decoder(plain_grammar(), **options_of(self._settings))

    def transcribe(self, utterance: Utterance) -> str:
        """The words that fit best; "" only where nothing was said."""
        views, _ = views_of(utterance, self._settings.clear_ratio)
        return " ".join(decoded(self._decoder, views[0]).words)
