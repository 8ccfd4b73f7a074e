"""Talk that begins or ends like a motion, and the motions: `python -m tests.benchmarks.motions_in_talk`.

"Go on holiday", "turn right as rain", "they come here": by all English voices of espeak-ng, and flite's, at 0.7, 1
and 1.4 times their pace; every fourth sentence in the echoes of `tests.benchmarks.place_names`. Each voice says all
motions without numbers and as many sentences of talk, drawn. Told for each pace: how many motions move the robot, and
how many are only doubted because more may have been said; of talk how much moves it, and how much only this doubt
holds back. `--every N` takes every Nth sentence. Every motion from talk is listed; with `--misses` every doubted one.
"""

from collections import Counter

import numpy as np

from core.commands import spec_of
from core.navigation.places import NamedPlace
from core.speech.recognition.decision import MORE_SAID, OBJECTIONS
from core.speech.recognition.endpointing import voiced
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import SpeechSettings
from core.speech.understanding.place_names import place_phrases
from core.speech.whisper.recognizer import WhisperRecognizer
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.place_names import ALL_VOICES, echoed, spoken
from tests.core.speech.ears import mono

RELATIVE_PACES = (0.7, 1.0, 1.4)
SENTENCES_PER_ECHO = 4
WORDS_BEHIND = {
    "turn left": "handed, over food, wing, behind the church in town, hand gloves, alone, at the lights, or not",
    "turn right": "handed, wing, now I am busy, away, angle, about noon, as rain, side up, before dinner",
    "come here": "often, after dinner, and there, today and tomorrow, every summer, by bus, for lunch, yesterday",
    "follow me": "on the internet, around the world, online, as a rule, if you dare, to the end of the story",
    "follow the wall": "paper, street journal, flower, of fame, and the fence, clock, painting",
    "go on": "holiday, strike, tour, without me, forever, television, and on, record, home, a diet, vacation, stage",
}
WORDS_BEFORE = {
    "turn left": "no, it is my, she took a, do not, nobody will",
    "turn right": "in, take a, do not, the next",
    "come here": "they, why did he, how, people, do not",
    "follow me": "nobody will, do you, they, please do not",
    "follow the wall": "they, ivy will, do not",
    "go on": "let the show, life must, shall we, the lights, please do not",
}
MOTION_PHRASES = (*WORDS_BEHIND, "go on with the route")
TALK_SENTENCES = (
    *(f"{motion} {words}" for motion, all_words in WORDS_BEHIND.items() for words in all_words.split(", ")),
    *(f"{words} {motion}" for motion, all_words in WORDS_BEFORE.items() for words in all_words.split(", ")),
)


def main(*, every: int = 1, misses: bool = False) -> None:
    recognizer = open_engine(SpeechSettings(engine="whisper")).recognizer
    assert isinstance(recognizer, WhisperRecognizer)
    phrases = place_phrases([NamedPlace(name="round", x_m=0.0, y_m=0.0, route=True)])
    recognizer.learn(tuple(one for one in phrases if one.place is None))
    chance, number = np.random.default_rng(0), 0
    for pace in RELATIVE_PACES:
        found: Counter[str] = Counter()
        for voice in ALL_VOICES:
            talk = chance.choice(TALK_SENTENCES, len(MOTION_PHRASES), replace=False).tolist()
            for words in (*MOTION_PHRASES, *talk):
                number += 1
                if number % every:
                    continue
                kind = "motions" if words in MOTION_PHRASES else "talk"
                samples = spoken(words, voice, number, pace)
                samples = samples if number // every % SENTENCES_PER_ECHO else echoed(samples, number)
                begin, end = voiced(samples)
                decision = recognizer.decide(Utterance(sound=mono(samples), begin=begin, end=end))
                doubted = decision.reason == OBJECTIONS[MORE_SAID](words=decision.words)
                moves = decision.command is not None and spec_of(decision.command.name).moves
                found[kind] += 1
                found[f"{kind} that move"] += moves
                found[f"{kind} doubted"] += doubted
                if (moves and kind == "talk") or (misses and doubted):
                    print_row(f"  {voice} {pace}: “{words}” → {decision.echo}")
        print_row({"pace": pace, **found})


if __name__ == "__main__":
    run_command(main)
