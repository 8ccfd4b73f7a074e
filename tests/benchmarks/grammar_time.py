"""Reading with the grammar as an automaton beside pocketsphinx's own reading of the same JSGF:
`python -m tests.benchmarks.grammar_time [--rounds 5]`.

The same decoder reads the same synthetic sentences with one and the other in turn. Told: states, the median ratio of
processor time, and whether the words were the same.
"""

import time
from typing import Any

import numpy as np

from core.message import Array
from core.speech.recognition.recognizer import for_words
from core.speech.settings import SpeechSettings
from core.speech.sphinx.decoded_path import decoded
from core.speech.sphinx.decoder import SEARCH, garbage_words, grammar_decoder
from core.speech.sphinx.fsg import automaton
from core.speech.sphinx.garbage_model import grammar
from core.speech.sphinx.jsgf import plain_grammar
from core.speech.sphinx.recognizer import options_of
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak
from tests.benchmarks.command import run_command
from tests.core.speech.ears import padded

SENTENCES = ("turn left", "come here", "continue 0.8 meters", "stop at 1.2 and minus 0.6")
THEIRS = "theirs"


def beside(jsgf: str, sounds: list[Array], rounds: int, **options: Any) -> dict[str, Any]:
    """One grammar, read in both ways."""
    reader = grammar_decoder(jsgf, **options)
    reader.add_jsgf_string(THEIRS, jsgf)
    ratios, same = [], 0
    for samples in sounds * rounds:
        spent, words = {}, {}
        for search in (SEARCH, THEIRS):
            reader.activate_search(search)
            decoded(reader, samples)  # what went before would count
            begun = time.process_time()
            words[search] = decoded(reader, samples).words
            spent[search] = time.process_time() - begun
        ratios.append(spent[SEARCH] / spent[THEIRS])
        same += words[SEARCH] == words[THEIRS]
    return {
        "states": automaton(jsgf).states,
        "time_ratio": round(float(np.median(ratios)), 3),
        "same_words": f"{same}/{len(ratios)}",
    }


def main(*, rounds: int = 5) -> object:
    chosen = SpeechSettings()
    options = options_of(chosen)
    voice = VoiceSettings(voice=PERSONS_VOICE)
    sounds = [padded(0.3 * for_words(speak(words, voice)).samples[:, 0], 0.3, 0.3) for words in SENTENCES]
    words = garbage_words(chosen.garbage_words, chosen.resembling_words)
    garbage_model = grammar(words, chosen.competing_price)
    return {
        "commands, words only": beside(plain_grammar(), sounds, rounds, **options),
        "commands, to be compared": beside(plain_grammar(), sounds, rounds, compallsen=True, **options),
        "anything else": beside(garbage_model, sounds, rounds, compallsen=True, **options),
    }


if __name__ == "__main__":
    run_command(main)
