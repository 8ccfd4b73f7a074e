"""Names of places by all English voices of espeak-ng, and flite's: `python -m tests.benchmarks.place_names`.

Thirty rooms and things are learnt at once. Each voice says "go to the NAME" (`--stop-at`: "stop at the NAME"), quiet
and in echoes (direct sound 6 dB over a tail that falls by 60 dB in 0.4 s), goes to places without a name, steers the
three routes that are known, and says what only resembles that. Nothing was chosen on the absent names, which are on
no map. `--kinds NAME…` takes only such kinds of sentences. Ten names on which nothing was chosen are known beside
them. A name that begins with whose it is (*Anna's office*) is said without *the*; the same with it, as nobody says
it, stands in a row of its own. Printed for each: right, refused, stopped (or paused), wrong; every wrong motion is
listed, with `--misses` every miss. `--every N` takes every Nth sentence, `--into FILE` keeps every result as it is
ready and goes on with those that it holds; `--talk FOLDER` also reads the near misses of speech_commands_tts and the
talk of speech_real in FOLDER, with the names and without them. `--room`: instead of quiet and echoes, in the
simulator's room as the robot hears it, by its array of four 2 m away (RT60 0.3 s, which the simulator has).
"""

import json
import re
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

import numpy as np

from core.commands import spec_of
from core.commands.routes import PAUSE_ROUTE, RESUME_ROUTE, START_ROUTE
from core.commands.stop_at import STOP_AT as STOP_AT_COMMAND
from core.message import Array
from core.navigation.places import NamedPlace
from core.recording.sound_file import read_sound
from core.speech.recognition.decision import Decision
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import for_words
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.synthesis import ENGLISH_VOICES
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.understanding.place_names import check_name_apart, place_phrases
from core.speech.whisper.recognizer import WhisperRecognizer
from tests.benchmarks.accents import said
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.noisy_voices import decisions
from tests.benchmarks.voices import REFUSED, RIGHT, STOPPED, WRONG, utterance
from tests.benchmarks.word_hearing import padded
from tests.benchmarks.word_scenes import ARRAY, Clip, Condition, real, scene, synthetic

NAMES = (
    *("kitchen", "window", "sofa", "Anna's office", "meeting room", "printer", "elevator", "front door", "bathroom"),
    *("library", "workshop", "garden", "reception", "hallway", "coffee machine", "fridge", "bookshelf", "piano"),
    *("fireplace", "charging station", "balcony", "garage", "server rack", "whiteboard", "lab bench", "closet"),
    *("stairs", "terrace", "mailbox", "room 12"),
)
NEW_NAMES = (
    *(
        "Sophie's studio",
        "Grandpa's chair",
        "crew cafeteria",
        "drop-off point",
        "walk-in freezer",
        "night-shift desk",
    ),
    *("room 317", "bay 9", "children's playground", "loading dock"),
)
"""Names on which nothing was chosen."""
WHOSE = re.compile(r"[A-Z][a-z]+'s ")  # a name that begins with a person's is said without an article
UNNAMED = ("museum", "cinema", "bedroom", "chicken", "winter", "harbour", "pencil", "airport", "market", "river")
ABSENT_NAMES = (
    *("attic", "cellar", "classroom", "canteen", "cupboard", "desk", "dishwasher", "dresser", "escalator", "lamp"),
    *("laboratory", "locker", "nursery", "oven", "pantry", "patio", "porch", "radiator", "restroom", "sandbox"),
    *("stage", "studio", "toaster", "wardrobe", "courtyard", "staircase", "greenhouse", "driveway", "side door"),
    *("conference room", "vending machine", "washing machine", "room 15", "Peter's office", "bay 4", "lecture hall"),
    *("ticket counter", "cash desk", "boiler room", "tea kitchen", "window seat", "sewing machine"),
)
ROUTE_NAMES = ("round", "evening patrol", "night watch")
STEERING = {
    **{f"start the route {name}": (START_ROUTE.name, name) for name in ROUTE_NAMES},
    **{words: (kind.name, "") for kind in (PAUSE_ROUTE, RESUME_ROUTE) for words in kind.words},
}
ROUTE_TALK = (
    *("pause for a moment please", "do not pause", "a pause in the music", "he paused the film", "the paws of a cat"),
    *(
        "go on holiday",
        "let us go on later",
        "it goes on and on",
        "go on and tell me more",
        "going on with the story",
    ),
    *(
        "start the engine",
        "start the route",
        "start the route home",
        "the route of the round trip",
        "start around ten",
    ),
)
GO_TO, STOP_AT = "go to the {}", "stop at the {}"
TAIL_S, TAIL_DB = 0.4, -6.0
ROOM = Condition("room RT60 0.3", rt60=0.3)
FLITE_VOICES = ("kal16", "awb", "rms", "slt") if which("flite") else ()
ALL_VOICES = (*ENGLISH_VOICES, *FLITE_VOICES)


def places() -> tuple[NamedPlace, ...]:
    """The forty places, each apart from all others, and the routes."""
    known: list[NamedPlace] = []
    for number, name in enumerate((*NAMES, *NEW_NAMES)):
        check_name_apart(name, [one.name for one in known])
        known.append(NamedPlace(name=name, x_m=0.5 * number, y_m=-1.0))
    return *known, *(NamedPlace(name=name, x_m=0.0, y_m=0.0, route=True) for name in ROUTE_NAMES)


def echoed(samples: Array, seed: int) -> Array:
    """Samples (N,) as they sound in a room."""
    chance = np.random.default_rng(seed)
    length = round(TAIL_S * RATE_HZ)
    tail = chance.normal(size=length) * 10 ** (-3.0 * np.arange(length) / length)
    tail *= 10 ** (TAIL_DB / 20) / np.sqrt(np.sum(tail**2))
    tail[0] = 1.0
    heard = np.convolve(samples, tail)[: len(samples)]
    return heard * np.abs(samples).max() / np.abs(heard).max()


Wanted = tuple[str, str] | None
"""The command that was said, and its place; None: no command."""


Heard = Callable[[WhisperRecognizer], list[Decision]]
"""What a recognizer decides about a sentence."""


def sentences(every: int, to: str, kinds: list[str], room: bool) -> Iterator[tuple[str, str, str, Wanted, Heard]]:
    """(voice, kind, words, the command, its reading) of every Nth sentence of every voice, quiet and in echoes.

    `kinds`: those that are taken; none: all; `room`: as the robot hears it in the simulator's room instead.
    """
    said_of_all: list[tuple[str, str, Wanted]] = [
        *(("named", _said(to, name), (STOP_AT_COMMAND.name, name)) for name in NAMES),
        *(("new names", _said(to, name), (STOP_AT_COMMAND.name, name)) for name in NEW_NAMES),
        *(("with the", to.format(name), (STOP_AT_COMMAND.name, name)) for name in NAMES if WHOSE.match(name)),
        *(("unnamed", to.format(name), None) for name in UNNAMED),
        *(("absent", _said(to, name), None) for name in ABSENT_NAMES),
        *(("routes", words, wanted) for words, wanted in STEERING.items()),
        *(("talk of routes", words, None) for words in ROUTE_TALK),
    ]
    number = 0
    for voice in ALL_VOICES:
        for kind, words, wanted in said_of_all:
            number += 1
            if number % every or (kinds and kind not in kinds):
                continue
            sound = partial(spoken, words, voice, number)
            if room:
                yield voice, f"{kind}, room", words, wanted, partial(_in_the_room, sound, number)
                continue
            yield voice, f"{kind}, quiet", words, wanted, partial(_alone, sound)
            yield voice, f"{kind}, echoes", words, wanted, partial(_alone, partial(_in_echoes, sound, number))


def spoken(words: str, voice: str, seed: int, pace: float = 1.0) -> Array:
    """A sentence at 16 kHz (N,), with faint noise around it."""
    if voice not in FLITE_VOICES:
        return said(words, voice, seed, pace)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "said.wav"
        stretch = f"duration_stretch={1 / pace:.3f}"
        subprocess.run(["flite", "-voice", voice, "--setf", stretch, "-t", words, "-o", str(path)], check=True)
        return padded(for_words(read_sound(path)).samples[:, 0], seed)


def _alone(sound: Callable[[], Array], recognizer: WhisperRecognizer) -> list[Decision]:
    return [recognizer.decide(utterance(sound()))]


def _in_the_room(sound: Callable[[], Array], seed: int, recognizer: WhisperRecognizer) -> list[Decision]:
    whole = scene(Clip("", "", sound()), ROOM, [], seed)
    return decisions(ArrayTranscriber(ARRAY, SpeechSettings(engine="whisper"), recognizer=recognizer), whole)


def _in_echoes(sound: Callable[[], Array], seed: int) -> Array:
    return echoed(sound(), seed)


def _said(to: str, name: str) -> str:
    """The words that go to a place."""
    return (to.replace("the ", "") if WHOSE.match(name) else to).format(name)


def outcome_of_all(wanted: Wanted, decided: list[Decision]) -> str:
    """What became of a sentence that may have been cut: the gravest, then the best."""
    found = {outcome(wanted, one) for one in decided} or {REFUSED if wanted else RIGHT}
    return next(one for one in (WRONG, STOPPED, RIGHT, REFUSED) if one in found)


def outcome(wanted: Wanted, decision: Decision) -> str:
    """What became of a sentence."""
    command = decision.command
    if command is None:
        return REFUSED if wanted else RIGHT
    if wanted == (command.name, command.place):
        return RIGHT
    return STOPPED if not spec_of(command.name).moves else WRONG


def main(
    *,
    every: int = 1,
    misses: bool = False,
    kinds: Sequence[str] = (),
    stop_at: bool = False,
    into: Path | None = None,  # a file of results
    talk: Path | None = None,
    room: bool = False,
) -> None:
    recognizer = open_engine(SpeechSettings(engine="whisper")).recognizer
    assert isinstance(recognizer, WhisperRecognizer)
    if talk:
        clips = [*synthetic(talk, "near-miss"), *(clip for _, clip in real(talk))][::every]
        for names in (False, True):
            recognizer.learn(place_phrases(places()) if names else ())
            found = Counter(outcome(None, recognizer.decide(utterance(clip.samples))) for clip in clips)
            print_row({"talk": "with names" if names else "without names", **found})
    recognizer.learn(place_phrases(places()))
    known: list[dict[str, str]] = []
    if into and into.exists():
        known = [json.loads(line) for line in into.read_text().splitlines()]
    done = {(one["voice"], one["kind"], one["words"]): one for one in known}
    results: dict[str, Counter[str]] = {}
    for voice, kind, words, wanted, heard in sentences(every, STOP_AT if stop_at else GO_TO, kinds, room):
        told = done.get((voice, kind, words))
        if told is None:
            decided = heard(recognizer)
            told = {"voice": voice, "kind": kind, "words": words, "result": outcome_of_all(wanted, decided)}
            told["heard"] = " | ".join(one.echo for one in decided)
            if into:
                with into.open("a") as file:
                    file.write(json.dumps(told) + "\n")
        result = told["result"]
        results.setdefault(kind, Counter())[result] += 1
        if result == WRONG or (misses and result != RIGHT):
            print_row(f"  {result} {voice} {kind}: “{words}” → {told['heard']}")
    for kind, found in results.items():
        print_row({"sentences": kind, "of": found.total(), **found})


if __name__ == "__main__":
    run_command(main)
