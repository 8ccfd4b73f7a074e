"""Settings of word recognition."""

from dataclasses import dataclass
from typing import Annotated, Literal

from core.setting import Meta, Section

RATE_HZ = 16_000  # of all sound that goes into a recognizer
PIECE_S = 0.2  # of a room's sound, at least, that are read at once
VOICE_PIECE_S = 0.05  # the same while someone speaks, and shortly after: they wait for an answer
MAX_WAITING_S = 8.0  # of it that may wait while words are read; older sound is not heard


@dataclass(frozen=True)
class SpeechSettings(Section):
    """Recognition of the commands; the defaults lie on plateaus of `tests.benchmarks.words`.

    Watch:
        engine: words and delay in Speech quality
        model: `beckon doctor`, which says whether the folder is taken; words and delay in Speech quality
        phrases: `beckon understand "your words"`
        hangover: delay of the reply; raise it for sentences cut in two
        complete_hangover: delay of the motion; raise it for numbers cut off
        unfinished_hangover: numbers cut off (then raise it)
        longest: long sentences that are not read (then raise it)
        opinions: commands that nobody gave (then raise it), refused ones (then lower it)
        stop_threshold: STOP that is missed (then lower it), or heard where nobody said it (then raise it)
    """

    pre_roll: float = 0.5  # [s] sound kept from before the speech: noise and direction are learnt there
    pause: float = 0.1  # [s] silence after which an utterance is read already, in case it is over
    long_pause: float = 0.15  # [s] the same for a longer one than 1.2 s, which takes longer to read in vain
    shortest: float = 0.12  # [s] speech that is shorter is a click
    onset: int = 4  # [frames] frames with a voice, of six, that begin an utterance
    evidence: float = 5.0  # power over the noise's from which a bin counts as voice
    voice_share: float = 0.06  # share of the bins that count in a frame with a voice
    voice_margin: float = 3.0  # factor over the share that the noise itself reaches
    dynamics: float = 20.0  # [dB] level below its loudest moment down to which an utterance goes on
    noise_memory: float = 1.0  # [s] time over which the noise is averaged
    insertion: float = 0.05  # probability with which sphinx begins another word
    silence: float = 0.1  # probability of a pause between words: people make pauses around numbers
    most_models: int = 800  # phone models that sphinx keeps alive at a time; more take longer in babble
    gaussians: int = 8  # Gaussians that sphinx evaluates in each codebook
    garbage_words: int = 800  # common words that compete with the commands, besides the 39 phones
    resembling_words: int = 80  # common words one phone away from a command's word, which compete too
    competing_price: float = 30000.0  # one over the probability of each competing word
    most_behind: float = 70.0  # [nats/s] score by which anything but a command may fit better, at most
    word_behind: float = 300.0  # [nats/s] the same within any one word of the command
    echoing_behind: float = 40.0  # [nats/s] the same within all of its words, where more is missing outside them
    echo: float = 100.0  # [nats] score that may be missing outside its words: echoes cost less than another word
    clear_ratio: float = 27.0  # [dB] voice over noise from which no noise is taken out: that costs consonants
    sure_lead: float = 30.0  # [nats] lead of numbers over the nearest others from which they are obeyed at once
    least_lead: float = 10.0  # [nats] lead of numbers from which they are said back where readings disagree
    stop_in_noise: float = 1e-12  # `stop_threshold` in the beam towards a covered voice; plateau 1e-15 to 1e-10
    covered_ratio: float = 25.0  # [dB] voice over noise of a covered voice, at most
    stop_delay: int = 10  # [frames] frames of 10 ms for which the spotter of STOP waits for a better end of the word
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
    hangover: Annotated[float, Meta("s", 0.1, 3, "silence that ends an utterance", common=True)] = 0.45
    complete_hangover: Annotated[
        float, Meta("s", 0.1, 3, "the same where what was said so far is a whole command that cannot go on")
    ] = 0.3
    unfinished_hangover: Annotated[
        float,
        Meta("s", 0.1, 3, "the same where what was said so far is no whole command: people pause before numbers"),
    ] = 0.8
    longest: Annotated[float, Meta("s", 1, 30, "an utterance that is longer is no command")] = 10.0
    opinions: Annotated[
        int,
        Meta("", 0, 3, "readings at other speeds that must agree on a command before the robot moves", common=True),
    ] = 2
    stop_threshold: Annotated[
        float, Meta("", 1e-300, 1e10, "likelihood ratio of STOP, at least; a lower one stops more easily")
    ] = 1.0
