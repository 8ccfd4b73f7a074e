"""Settings of word recognition."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from core.setting import Meta, Section

RATE_HZ = 16_000  # of all sound that goes into a recognizer
PIECE_S = 0.2  # of a room's sound, at least, that are read at once
VOICE_PIECE = 0.05  # [s] the same while someone speaks, and shortly after: they wait for an answer
MOST_WAITING = 8.0  # [s] of it that may wait while words are read; older sound is not heard


@dataclass(frozen=True)
class SpeechSettings(Section):
    """Recognition of the commands; the defaults lie on plateaus of `tests.benchmarks.words`."""

    engine: Annotated[
        Literal["auto", "whisper", "sphinx"],
        Meta(
            meaning="recognizer; auto: Whisper where its model is here, else pocketsphinx where it is installed",
            common=True,
        ),
    ] = "auto"
    model: Annotated[
        str, Meta(meaning="folder with an English faster-whisper model; empty: the one that was fetched or installed")
    ] = ""
    phrases: Annotated[str, Meta(meaning="file phrases.toml with your own words for commands; empty: none")] = ""
    pre_roll: Annotated[
        float, Meta("s", 0.05, 2, "sound kept from before the speech: noise and direction are learnt there")
    ] = 0.5
    pause: Annotated[
        float, Meta("s", 0.05, 2, "silence after which an utterance is read already, in case it is over")
    ] = 0.1
    long_pause: Annotated[
        float, Meta("s", 0.05, 2, "the same for a longer one than 1.2 s, which takes longer to read in vain")
    ] = 0.15
    hangover: Annotated[float, Meta("s", 0.1, 3, "silence that ends an utterance", common=True)] = 0.45
    complete_hangover: Annotated[
        float, Meta("s", 0.1, 3, "the same where what was said so far is a whole command that cannot go on")
    ] = 0.3
    unfinished_hangover: Annotated[
        float,
        Meta("s", 0.1, 3, "the same where what was said so far is no whole command: people pause before numbers"),
    ] = 0.8
    shortest: Annotated[float, Meta("s", 0.01, 1, "speech that is shorter is a click")] = 0.12
    longest: Annotated[float, Meta("s", 1, 30, "an utterance that is longer is no command")] = 10.0
    onset: Annotated[int, Meta("frames", 1, 6, "frames with a voice, of six, that begin an utterance")] = 4
    evidence: Annotated[float, Meta("", 1, 100, "power over the noise's from which a bin counts as voice")] = 5.0
    voice_share: Annotated[float, Meta("", 0.001, 1, "share of the bins that count in a frame with a voice")] = 0.06
    voice_margin: Annotated[float, Meta("", 1, 20, "factor over the share that the noise itself reaches")] = 3.0
    dynamics: Annotated[
        float, Meta("dB", 3, 80, "level below its loudest moment down to which an utterance goes on")
    ] = 20.0
    noise_memory: Annotated[float, Meta("s", 0.05, 30, "time over which the noise is averaged")] = 1.0
    insertion: Annotated[float, Meta("", 1e-6, 1, "probability with which sphinx begins another word")] = 0.05
    silence: Annotated[
        float, Meta("", 1e-6, 1, "probability of a pause between words: people make pauses around numbers")
    ] = 0.1
    most_models: Annotated[
        int, Meta("", 50, 30000, "phone models that sphinx keeps alive at a time; more take longer in babble")
    ] = 800
    gaussians: Annotated[int, Meta("", 1, 128, "Gaussians that sphinx evaluates in each codebook")] = 8
    garbage_words: Annotated[
        int, Meta("", 0, 20000, "common words that compete with the commands, besides the 39 phones")
    ] = 800
    resembling_words: Annotated[
        int, Meta("", 0, 2000, "common words one phone away from a command's word, which compete too")
    ] = 80
    competing_price: Annotated[float, Meta("", 1, 1e9, "one over the probability of each competing word")] = 30_000.0
    most_behind: Annotated[
        float, Meta("nats/s", 0, 1e4, "score by which anything but a command may fit better, at most")
    ] = 70.0
    word_behind: Annotated[float, Meta("nats/s", 0, 1e4, "the same within any one word of the command")] = 300.0
    echoing_behind: Annotated[
        float, Meta("nats/s", 0, 1e4, "the same within all of its words, where more is missing outside them")
    ] = 40.0
    echo: Annotated[
        float, Meta("nats", 0, 1e4, "score that may be missing outside its words: echoes cost less than another word")
    ] = 100.0
    clear_ratio: Annotated[
        float, Meta("dB", -20, 100, "voice over noise from which no noise is taken out: that costs consonants")
    ] = 27.0
    opinions: Annotated[
        int,
        Meta("", 0, 3, "readings at other speeds that must agree on a command before the robot moves", common=True),
    ] = 2
    sure_lead: Annotated[
        float, Meta("nats", 0, 1000, "lead of numbers over the nearest others from which they are obeyed at once")
    ] = 30.0
    least_lead: Annotated[
        float, Meta("nats", 0, 1000, "lead of numbers from which they are said back where readings disagree")
    ] = 10.0
    stop_threshold: Annotated[
        float, Meta("", 1e-300, 1e10, "likelihood ratio of STOP, at least; a lower one stops more easily")
    ] = 1.0
    stop_in_noise: Annotated[
        float, Meta("", 1e-300, 1e10, "the same in the beam towards a voice covered by noise; plateau 1e-15 to 1e-10")
    ] = 1e-12
    covered_ratio: Annotated[float, Meta("dB", -20, 100, "voice over noise of a covered voice, at most")] = 25.0
    stop_delay: Annotated[
        int,
        Meta("frames", 1, 100, "frames of 10 ms for which the spotter of STOP waits for a better end of the word"),
    ] = 10
