"""Table 2: every command many times, from random places, spoken in the simulated room and obeyed by the whole robot.

A person stands somewhere near and says the command with a synthetic voice, drawn for every run from all English ones
at their natural pace ± 15 %; the sound goes through the room to the
robot's microphones, is located and read, and what was understood moves the robot. What goes far, or to a place or a
person, is said back and waits a moment, in which who meant something else says STOP. Who is not understood says it
again, three times at the most.
"""

from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Literal, TypedDict

import msgspec
import numpy as np

from core.commands.stop_moving import STOP_MOVING
from core.errors import Refused, Unavailable
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, as_csv, best_and_worst, grouped, stored
from core.experiments.spoken_room import SENSES, SentenceOutcome, SpokenRoom
from core.experiments.table_2_trials import MAX_TRIES, PRECONDITIONS, TRIALS, TrialOutcome
from core.settings import Settings
from core.simulation.world import world_named
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import Recognizer
from core.speech.settings import SpeechSettings
from core.speech.synthesis import NO_VOICE, can_speak, drawn_voice

READING_SHARE = 0.2  # of a sound's duration: so long its reading takes, on every computer alike

ABOUT = About(
    title="Table 2: every command, spoken and obeyed",
    reproduces="Table 2: every command by synthetic voices through microphones, direction, recognizer and wheels. "
    "The chapter names the commands and prints no rates.",
    runs=50,
    seed=5,
    counts="runs of every command",
    base_s=3.0,
    run_s=190.0,
    swept=(*(f"commands.{name}.success_rate" for name in TRIALS), "wrong_motions", "contacts"),
)
Delay = Literal["endpoint_s", "read_s", "delay_s", "wheels_s"]
DELAYS: tuple[Delay, ...] = ("endpoint_s", "read_s", "delay_s", "wheels_s")  # from the end of the words to the wheels


class TrialRow(TypedDict):
    """One run of one command, as JSON."""

    command: str
    run: int
    world: str
    words: str
    voice: str  # of espeak-ng
    pace_words_min: int
    understood: bool
    tries: int
    success: bool
    figure: float | None  # in the command's unit
    why: str
    wrong: list[str]  # commands that were understood instead, and begun
    rescued: list[str]  # those that only the speaker's STOP kept from beginning
    contacts: int
    faults: list[str]
    endpoint_s: float | None  # None, also below: it was not understood
    read_s: float | None
    delay_s: float | None
    wheels_s: float | None
    errors: dict[str, list[float]]  # by sense


class FailedTrial(TypedDict):
    """A run that failed, as JSON."""

    run: int
    world: str
    words: str
    why: str
    figure: float | None


class CommandFigures(TypedDict):
    """The table's row of one command, as JSON."""

    definition: str  # of success
    runs: int
    success_rate: float
    understood_rate: float
    understood_at_once_rate: float
    success_rate_of_understood: float | None
    unit: str
    median: float | None
    worst: float | None
    contacts: int
    failures: list[FailedTrial]


class VoiceFigures(TypedDict):
    """The runs of one voice, as JSON."""

    runs: int
    success_rate: float
    understood_rate: float


class SpreadFigures(TypedDict):
    """The middle and the 95th percentile."""

    p50: float
    p95: float


class Table2(ExperimentResult):
    """The result, as JSON."""

    runs: int
    said_at_most: int
    commands: dict[str, CommandFigures]
    contacts: int
    voices: dict[str, VoiceFigures]
    best_voice: str
    worst_voice: str
    wrong_motions: int  # every motion that was not asked for, were there no rescue by STOP
    saved_by_rescue: int  # of them
    wrong: list[str]
    preconditions: list[str]
    faults: list[str]
    delays: dict[str, SpreadFigures | None]
    errors: dict[str, SpreadFigures | None]


def trial(name: str, number: int, seed: int, *, words: bool = True, settings: Settings | None = None) -> TrialRow:
    """One run of one command → its row; without `words` the command is typed with a voice without words."""
    kind = TRIALS[name]
    place = kind.places[number % len(kind.places)]
    chance = np.random.default_rng(np.random.SeedSequence((seed, number, tuple(TRIALS).index(name))))
    start, said = kind.start(world_named(place), chance)
    recognizer = _recognizer() if words else None
    own, voice = int(chance.integers(2**31)), drawn_voice(chance)
    room = SpokenRoom(
        place,
        own,
        words=words,
        start=start,
        settings=settings,
        recognizer=recognizer,
        voice=voice,
        reading_share=READING_SHARE,
    )
    try:
        heard, outcome = kind.obey(room, said)
    except Refused as refused:
        heard, outcome = (
            SentenceOutcome(number=None, call=None, why=str(refused)),
            TrialOutcome(success=False, why=str(refused)),
        )
    robot = room.robot
    return {
        "command": name,
        "run": number,
        "world": place,
        "words": said,
        "voice": voice.voice if words else "",
        "pace_words_min": voice.speed,
        "understood": heard.number is not None,
        "tries": heard.tries,
        "success": outcome.success,
        "figure": outcome.figure,
        "why": outcome.why,
        "wrong": list(heard.wrong),
        "rescued": list(heard.rescued),
        "contacts": robot.contacts,
        "faults": robot.faults(),
        "endpoint_s": heard.understood - heard.ended - heard.read if heard.number is not None else None,
        "read_s": heard.read if heard.number is not None else None,
        "delay_s": heard.begun - heard.understood if heard.number is not None else None,
        "wheels_s": _first_motion(name, room, heard),
        "errors": room.errors,
    }


def _first_motion(name: str, room: SpokenRoom, heard: SentenceOutcome) -> float | None:
    """Time from the begin of the command to the first wheel setpoint [s]."""
    if heard.number is None or name == STOP_MOVING.name:
        return None
    rows = [row.t_mono_ns / 1e9 for row in room.robot.trace if row.event == "" and (row.v or row.w)]
    return next((stamp - heard.begun for stamp in rows if stamp >= heard.begun), None)


@cache
def _recognizer() -> Recognizer:
    """One for all runs of a process. Raises Unavailable."""
    return open_engine(SpeechSettings()).recognizer


def trial_of(seed: int, runs: int, settings: Settings | None, index: int) -> TrialRow:
    """One of `runs` of every command, command by command."""
    return trial(tuple(TRIALS)[index // runs], index % runs, seed, settings=settings)


def summary(name: str, rows: Sequence[TrialRow]) -> CommandFigures:
    """The table's row of one command."""
    kind = TRIALS[name]
    figures = [row["figure"] for row in rows if row["understood"] and row["figure"] is not None]
    understood = [row for row in rows if row["understood"]]
    return {
        "definition": kind.definition,
        "runs": len(rows),
        "success_rate": float(np.mean([row["success"] for row in rows])),
        "understood_rate": len(understood) / len(rows),
        "understood_at_once_rate": sum(row["tries"] == 1 for row in understood) / len(rows),
        "success_rate_of_understood": float(np.mean([row["success"] for row in understood])) if understood else None,
        "unit": kind.unit,
        "median": float(np.median(figures)) if figures else None,
        "worst": max(figures) if figures else None,
        "contacts": sum(row["contacts"] for row in rows),
        "failures": [msgspec.convert(row, FailedTrial) for row in rows if not row["success"]],
    }


def plan(*, runs: int | None = None, seed: int = 0, settings: Settings | None = None) -> ExperimentPlan:
    """Plan `runs` (50) of every command, with JSON and CSV. Raises Unavailable where nothing can speak."""
    if not can_speak():
        raise Unavailable(NO_VOICE)
    count = runs or ABOUT.runs
    batch = RunBatch(partial(trial_of, seed, count, settings), count * len(TRIALS), TrialRow)
    return ExperimentPlan((batch,), partial(_result, seed, count))


def _result(seed: int, count: int, out: Path | None, rows: list[TrialRow]) -> Table2:
    voices = voice_figures(rows)
    best, worst = best_and_worst({name: one["success_rate"] for name, one in voices.items()})
    saved = sum(len(row["rescued"]) for row in rows)
    commands = {name: summary(name, [row for row in rows if row["command"] == name]) for name in TRIALS}
    result: Table2 = {
        "runs": count,
        "seed": seed,
        "said_at_most": MAX_TRIES,
        "commands": commands,
        "contacts": sum(row["contacts"] for row in rows),
        "voices": voices,
        "best_voice": best,
        "worst_voice": worst,
        "wrong_motions": sum(len(row["wrong"]) for row in rows) + saved,
        "saved_by_rescue": saved,
        "wrong": [word for row in rows for word in row["wrong"] + row["rescued"]],
        "preconditions": list(PRECONDITIONS),
        "faults": [fault for row in rows for fault in row["faults"]],
        "delays": {name: _spread([row[name] for row in rows]) for name in DELAYS},
        "errors": {sense: _spread([abs(e) for row in rows for e in row["errors"][sense]]) for sense in SENSES},
        "text": "",
        "files": {},
    }
    result["text"] = "\n".join((table(commands), *remarks(result)))
    plain = [{key: value for key, value in row.items() if key != "errors"} for row in rows]
    return stored(result, out, "table_2", {"csv": ("table_2.csv", as_csv(plain))})


def voice_figures(rows: Sequence[TrialRow]) -> dict[str, VoiceFigures]:
    """Success of every voice that was drawn."""
    return {
        name: {
            "runs": len(some),
            "success_rate": float(np.mean([row["success"] for row in some])),
            "understood_rate": float(np.mean([row["understood"] for row in some])),
        }
        for name, some in sorted(grouped(rows, lambda row: row["voice"]).items())
    }


def remarks(result: Table2) -> list[str]:
    """Return the lines under the table: voices, wrong motions, and all that makes it easier."""

    def in_words(name: str) -> str:
        one = result["voices"][name]
        return f"{name} {100 * one['success_rate']:.0f} % of {one['runs']}"

    whole = result["wrong_motions"]
    return [
        "",
        *(f"voice {in_words(name)}" for name in result["voices"]),
        f"best voice: {in_words(result['best_voice'])}; worst voice: {in_words(result['worst_voice'])}",
        f"motions not asked for: {whole}; the speaker's STOP saves {result['saved_by_rescue']} of them",
        *(f"given: {one}" for one in result["preconditions"]),
    ]


def table(commands: Mapping[str, CommandFigures]) -> str:
    """The outcome table."""
    lines = [
        f"{'command':12} {'runs':>4} {'success':>8} {'understood':>10} {'median':>10} {'worst':>10}  success means"
    ]
    for name, row in commands.items():
        median, worst = (
            "-" if figure is None else f"{figure:.3g} {row['unit']}" for figure in (row["median"], row["worst"])
        )
        lines.append(
            f"{name:12} {row['runs']:4} {100 * row['success_rate']:6.0f} % {100 * row['understood_rate']:8.0f} % "
            f"{median:>10} {worst:>10}  {row['definition']}"
        )
    return "\n".join(lines)


def _spread(values: Sequence[float | None]) -> SpreadFigures | None:
    known = [value for value in values if value is not None]
    if not known:
        return None
    return {"p50": float(np.median(known)), "p95": float(np.quantile(known, 0.95))}
