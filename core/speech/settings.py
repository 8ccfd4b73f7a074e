"""Settings of word recognition."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

RATE = 16_000  # [Hz] of all sound that goes into a recognizer
PIECE = 0.2  # [s] of a room's sound, at least, that are read at once
MOST_WAITING = 8.0  # [s] of it that may wait while words are read; older sound is not heard


@dataclass(frozen=True)
class SpeechSettings:
    """Recognition of the commands; the defaults lie on plateaus of `tests.benchmarks.words`."""

    engine: Literal["sphinx", "vosk", "faster-whisper", "sherpa"] = "sphinx"
    model: str = ""  # the folder with the engine's model; sphinx brings its own
    pre_roll: float = 0.5  # [s] of sound before the speech that stay with it: noise and direction are learnt there
    pause: float = 0.2  # [s] of silence after which a short utterance is read already, in case it is over
    hangover: float = 0.45  # [s] of silence that end an utterance
    shortest: float = 0.12  # [s] of speech; what is shorter is a click
    longest: float = 10.0  # [s] of one utterance; what is longer is no command
    onset: int = 4  # frames with a voice, of the last six, that begin an utterance
    evidence: float = 5.0  # power over the noise's from which a bin of a frame counts as voice
    voice_share: float = 0.06  # of the bins that must count, for a frame with a voice
    voice_margin: float = 3.0  # times the share that the noise itself reaches
    dynamics: float = 20.0  # [dB] below the loudest moment of an utterance, down to which it goes on
    noise_memory: float = 1.0  # [s] over which the noise is averaged
    insertion: float = 0.05  # probability with which sphinx begins another word
    silence: float = 0.1  # probability of a pause between words: people make them around numbers
    most_models: int = 800  # that sphinx keeps alive at a time; without a bound, babble takes as long as it lasts
    gaussians: int = 8  # that sphinx evaluates in each codebook
    garbage_words: int = 800  # common words that compete with the commands, besides the 39 phones
    resembling_words: int = 80  # the most common words that are one phone away from a command's, which compete too
    competing_price: float = 30_000.0  # one over the probability of each competing word
    most_behind: float = 70.0  # [nats/s] by which anything but a command may fit better
    word_behind: float = 300.0  # [nats/s] the same within any one word of it
    echoing_behind: float = 40.0  # [nats/s] the same within all of its words, where more is missing outside them …
    echo: float = 100.0  # [nats] … but only so much, as walls make that are near; a word that is none is worth more
    clear_ratio: float = 27.0  # [dB] of voice over noise from which no noise is taken out: that costs consonants
    opinions: int = 2  # readings at other speeds that must agree on a command before the robot moves
    sure_lead: float = 30.0  # [nats] by which numbers must be ahead of the nearest others, to be obeyed at once
    least_lead: float = 10.0  # [nats] by which numbers on which they do not agree must be ahead, to be said back
    stop_threshold: float = 1.0  # likelihood ratio from which a word is taken for STOP; less is more easily
    stop_in_noise: float = 1e-12  # the same in the beam towards a voice that noise covers; plateau 1e-10 to 1e-15
    covered_ratio: float = 25.0  # [dB] of voice over noise below which it is covered
    stop_delay: int = 10  # frames of 10 ms that the spotter of STOP waits for a better end of the word
