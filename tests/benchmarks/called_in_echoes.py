"""COME HERE in a room with a hard wall and a second talker: `python -m tests.benchmarks.called_in_echoes --runs 50`.

Someone calls in sim:lab or sim:floor, at a random place in sight; one wall of the room, drawn for every run, sends
back 95 % of the pressure (the others have an RT60 of 0.3 s). Bob, who stands elsewhere in the room, a metre or more
from her and as loud, talks too: half of the time he is about to end as she begins, else he begins in the second half
of her words or up to a second later. He does not hide her: the robot comes to whom it can see. Success: the robot
stands 0.5 ± 0.1 m from who called. With `--plain` there is neither. The words are read (`--typed`: they are taken as
read, with the same voices). Every run prints a row.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np

from core.errors import BadInput, Refused
from core.experiments.spoken_room import BODY, SEEN, SentenceOutcome, SpokenRoom, length_of_words
from core.experiments.table_2_trials import COME_DISTANCES_M, MAX_TRIES, PLACES, anywhere
from core.geometry import Pose, wrap
from core.robots.requests import Speak
from core.sensors import SensorFrame
from core.sensors.microphones import Sound
from core.sensors.resampling import resampled
from core.settings import Settings
from core.simulation.settings import HardWall
from core.simulation.world import world_named
from core.speech.settings import RATE_HZ
from core.speech.synthesis import drawn_voice, pcm, speak
from tests.benchmarks.carried_out import carried_out
from tests.benchmarks.command import print_row, run_command

BOB = "Bob"
TALK = (
    "the meeting begins at nine",
    "where did you put my keys",
    "it may rain this afternoon",
    "we should paint this room",
    "I have not seen him for weeks",
)
APART = 1.0  # [m] between the two
HALF = 0.25  # [m] half the width of a body with its arms
ENDS, BEGINS = (0.0, 0.4), (0.5, 1.0)  # [s] of her words before he ends; share of her words, and [s] after them


def row(seed: int, plain: bool, typed: bool, number: int) -> dict[str, Any]:
    began = time.process_time()
    chance = np.random.default_rng((seed, number))
    place = PLACES[number % len(PLACES)]
    wall = "none" if plain else str(chance.choice(get_args(HardWall)[1:]))
    settings = Settings()
    settings = replace(settings, simulation=replace(settings.simulation, hard_wall=wall))
    start, words = anywhere("come here", world_named(place), chance)
    voice = drawn_voice(chance)
    own = int(chance.integers(2**31))
    room = SpokenRoom(place, own, words=not typed, start=start, settings=settings, voice=voice)
    x, y = room.place()
    said = speak(words, voice)
    bob = None if plain else beside(room, x, y)
    if bob is not None:
        talk_between(room, chance, length_of_words(pcm(said), said.rate))
    truth, heading = room.robot.truth, room.robot.snapshot.estimate.pose.heading
    heard, why, apart = SentenceOutcome(number=None, call=None), "", math.nan
    try:
        heard = room.command(words, MAX_TRIES, pcm=at_rate_of_words(said) if typed else None)
        why = heard.why
        if heard.number is not None:
            ended = room.robot.wait(heard.number, 120.0)
            why = "it took too long" if ended is None else f"{ended.state}: {ended.remark}"
            apart = room.robot.truth.distance_to(x, y)
    except Refused as refused:
        why = str(refused)
    aim = heading + truth.bearing_to(x, y)
    return {
        "run": number,
        "world": place,
        "wall": wall,
        "voice": voice.voice,
        "understood": heard.number is not None,
        "tries": heard.tries,
        "success": COME_DISTANCES_M[0] <= apart <= COME_DISTANCES_M[1],
        "apart_m": round(apart, 3),
        "caller_m": round(truth.distance_to(x, y), 2),
        "voice_off_deg": None if heard.call is None else degrees(heard.call.azimuth - aim),
        "bob_off_deg": None if bob is None else degrees(truth.bearing_to(*bob) - truth.bearing_to(x, y)),
        "why": why,
        "wrong": list(heard.wrong),
        "contacts": room.robot.contacts,
        "took_s": round(time.process_time() - began, 1),
    }


def numbered(first: int, seed: int, plain: bool, typed: bool, number: int) -> dict[str, Any]:
    """One run, counted from `first`."""
    return row(seed, plain, typed, first + number)


def talk_between(room: SpokenRoom, chance: np.random.Generator, length: float) -> None:
    """Let Bob talk into words of that length [s], that begin when this returns."""
    talk = speak(str(chance.choice(TALK)), drawn_voice(chance))
    his = length_of_words(pcm(talk), talk.rate)
    begin = room.robot.snapshot.stamp
    request = Speak(id=BOB, pcm=pcm(talk), rate_hz=talk.rate)
    if chance.random() < 0.5:
        until = begin + max(his - float(chance.uniform(*ENDS)), 0.0)
    else:
        until, begin = begin, begin + float(chance.uniform(BEGINS[0] * length, length + BEGINS[1]))
    room.robot.when_stepped.append(partial(interrupt, room, [begin], request))
    room.robot.run(until - room.robot.snapshot.stamp)


def degrees(angle: float) -> float:
    return round(math.degrees(wrap(angle)), 1)


def at_rate_of_words(said: Sound) -> bytes:
    """A voice as 16-bit samples at the rate of the words."""
    samples = resampled(said.samples[:, 0], said.rate, RATE_HZ)
    return (samples * 32767).clip(-32768, 32767).astype("<i2").tobytes()


def beside(room: SpokenRoom, x: float, y: float) -> tuple[float, float]:
    """Put Bob somewhere in the room → where. Raises Refused where there is no place."""
    here = room.robot.truth
    for _ in range(10_000):
        away, angle = room.chance.uniform(1.0, 3.8), room.chance.uniform(-math.pi, math.pi)
        u, v = float(here.x + away * math.cos(angle)), float(here.y + away * math.sin(angle))
        if math.hypot(u - x, v - y) < APART or room.hidden(here, u, v) or hides(here, (u, v), (x, y)):
            continue
        try:
            room.put(BOB, clothes="white/green", x_m=u, y_m=v)
        except BadInput:
            continue
        return u, v
    raise Refused("There is no room for a second person.")


def hides(here: Pose, nearer: tuple[float, float], person: tuple[float, float]) -> bool:
    """Return whether someone hides more of a person from here than walls and things may."""
    near, far = here.distance_to(*nearer), here.distance_to(*person)
    if near > far:
        return False
    aside = here.bearing_to(*person) + np.arctan(BODY[:, 0] / far) - here.bearing_to(*nearer)
    return float(np.mean(np.abs([wrap(one) for one in aside]) > math.atan(HALF / near))) < SEEN


def interrupt(room: SpokenRoom, at: list[float], request: Speak, frame: SensorFrame) -> None:
    """Bob speaks when it is time; `at` [s] is emptied then."""
    if at and frame.stamp >= at[0]:
        at.clear()
        room.robot.robot.ask(request)


def main(
    *,
    runs: int = 50,
    first: int = 0,  # number of the first run
    seed: int = 0,
    workers: int | None = None,
    plain: bool = False,
    typed: bool = False,
) -> None:
    rows: Sequence[dict[str, Any]] = carried_out(partial(numbered, first, seed, plain, typed), runs, workers)
    for one in rows:
        print_row(one)
    good, understood = sum(one["success"] for one in rows), sum(one["understood"] for one in rows)
    print_row(f"{good} of {len(rows)} stand 0.5 ± 0.1 m from the caller; understood: {understood}")


if __name__ == "__main__":
    run_command(main)
