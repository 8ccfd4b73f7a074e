"""Faults of microphone arrays in rooms: is a direction off by more than it says, and sure all the same?

`python -m tests.benchmarks.array_faults --faults 200`. Every array hears a voice in rooms of every reverberation, in
diffuse noise or beside a fan; then the same sound with a fault. Orders of channels that only turn or mirror an array
are no faults here: nothing in the sound shows them (`beckon calibrate array` does). Microphones in a line give no
direction at all. `before` is what the estimate said without asking whether the microphones contradict it. At the end
the misfit up to which a direction is sure is chosen on all arrays but one, and measured on that one.
"""

import itertools
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.experiments.direction_of_arrival import REVERBERATION_TIMES_S
from core.experiments.talk_in_rooms import PRE_ROLL_S, RATE_HZ, make_scene
from core.geometry import wrap
from core.message import Array
from core.perception.sound.array_diagnostics import check
from core.perception.sound.direction import Direction
from core.perception.sound.least_squares import axes_of, on_sphere
from core.perception.sound.locate import locate, sure
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound, ring, tetrahedron
from core.speech.practice_voice import practice_voice
from tests.benchmarks.command import print_row, run_command

SPEECH = 1.2  # [s]
NOISES = (("diffuse", 20.0), ("diffuse", 10.0), ("fan", 10.0))  # [dB]
PROCESSED_LATE = 0.016  # [s]
MOVED = 0.01  # [m]
WIDER = 1.2  # times the profile's distances
OTHER_RATE = 44_100 / 48_000  # of the rate that the file says
LIMITS = (1.5, 2.0, 2.5, 3.0, 4.0, 6.0)  # misfits of a declared direction that are tried
UNEVEN = MicrophoneArray(
    name="four unevenly", positions=np.array([[0.05, 0.01, 0], [-0.03, 0.04, 0], [-0.02, -0.05, 0], [0.03, -0.03, 0]])
)
ARRAYS = {
    "square": RESPEAKER_ODAS,
    "ring of 6": ring("six on a circle", 0.0463, 0.0, math.pi / 3, 6),
    "ring of 8": ring("eight on a circle", 0.0525, 0.0, math.pi / 4, 8),
    "uneven": UNEVEN,
    "tetrahedron": tetrahedron(),
    "triangle": ring("three on a circle", 0.04, 0.3, 2 * math.pi / 3, 3),
}


def late(samples: Array, by: float) -> Array:
    """One channel (N,) later by a number of samples."""
    padded = len(samples) + 64 + math.ceil(by)
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(padded) * by)
    return np.fft.irfft(np.fft.rfft(samples, padded) * turn, padded)[: len(samples)]


def compressed(samples: Array) -> Array:
    """A channel (N,) whose quiet parts are raised, as an automatic gain does."""
    level = np.sqrt(np.convolve(samples**2, np.ones(160) / 160, "same")) + 1e-4
    return samples * (level.max() / level) ** 0.6


def _late_channels(by: float, count: int) -> Callable[[Array, np.random.Generator], Array]:
    def fault(samples: Array, rng: np.random.Generator) -> Array:
        first = int(rng.integers(samples.shape[1]))
        wrong = samples.copy()
        for channel in range(first, first + count):
            at = channel % samples.shape[1]
            wrong[:, at] = late(samples[:, at], by)
        return wrong

    return fault


def _processed(
    by: float, make: Callable[[Array], Array], shifted: bool
) -> Callable[[Array, np.random.Generator], Array]:
    def fault(samples: Array, rng: np.random.Generator) -> Array:
        total = late(make(samples.mean(1)), by * RATE_HZ)
        if shifted:
            return np.column_stack((total, samples[:, :-1]))
        wrong = samples.copy()
        wrong[:, int(rng.integers(samples.shape[1]))] = total
        return wrong

    return fault


def _noise(samples: Array, rng: np.random.Generator) -> Array:
    wrong = samples.copy()
    wrong[:, int(rng.integers(samples.shape[1]))] = np.std(samples) * rng.normal(size=len(samples))
    return wrong


def _one_of(make: Callable[[Array, Array], Array]) -> Callable[[Array, np.random.Generator], Array]:
    """A fault of one channel (N,), which may hold the next one (N,), too."""

    def fault(samples: Array, rng: np.random.Generator) -> Array:
        wrong, at = samples.copy(), int(rng.integers(samples.shape[1]))
        wrong[:, at] = make(samples[:, at], samples[:, at - 1])
        return wrong

    return fault


def _stretched(samples: Array, _: np.random.Generator) -> Array:
    """All channels as if they were sampled at another rate."""
    moments = np.arange(int(len(samples) * OTHER_RATE)) / OTHER_RATE
    return np.column_stack([np.interp(moments, np.arange(len(samples)), one) for one in samples.T])


FAULTS: dict[str, Callable[[Array, np.random.Generator], Array]] = {
    "late by 0.5 samples": _late_channels(0.5, 1),
    "late by 1 sample": _late_channels(1.0, 1),
    "late by 2 samples": _late_channels(2.0, 1),
    "late by 3 samples": _late_channels(3.0, 1),
    "late by 8 samples": _late_channels(8.0, 1),
    "two late by 1 sample": _late_channels(1.0, 2),
    "dead": _one_of(lambda own, _: 0 * own),
    "five times as loud": _one_of(lambda own, _: 5 * own),
    "clipped": _one_of(lambda own, _: np.clip(own, -np.std(own), np.std(own))),
    "cross-talk": _one_of(lambda own, other: 0.6 * own + 0.4 * other),
    "another rate": _stretched,
    "processed": _processed(0.0, np.array, shifted=False),
    "processed first": _processed(0.0, np.array, shifted=True),
    "processed first, gain": _processed(0.0, compressed, shifted=True),
    "processed first, 16 ms late": _processed(PROCESSED_LATE, compressed, shifted=True),
    "noise": _noise,
}


def orders(array: MicrophoneArray) -> dict[str, tuple[int, ...]]:
    """Orders of an array's channels in which the sound differs from that of the array turned or mirrored."""
    count = len(array.positions)
    some = {
        "two swapped": (1, 0, *range(2, count)),
        "two pairs swapped": (1, 0, 3, 2, *range(4, count)),
        "order turned": (*range(1, count), 0),
    }
    apart = _distances(array.positions)
    return {
        name: order
        for name, order in some.items()
        if len(order) == count and not np.allclose(_distances(array.positions[list(order)]), apart, atol=1e-4)
    }


def _distances(positions: Array) -> Array:
    return np.linalg.norm(positions[:, None] - positions, axis=2)


@dataclass(frozen=True)
class FaultTrial:
    """One sound and what was said of it."""

    array: str
    fault: str  # "": none
    error: float  # [rad]
    sd: float  # [rad]
    is_sure: bool
    sd_before: float  # [rad]
    sure_before: bool
    misfit: float  # of what is expected
    named: tuple[str, ...]  # kinds of faults that were told

    @property
    def misleads(self) -> bool:
        """Sure, and off by more than twice its standard deviation."""
        return self.is_sure and self.error > 2 * self.sd

    @property
    def misled_before(self) -> bool:
        """The same without asking whether the microphones contradict each other."""
        return self.sure_before and self.error > 2 * self.sd_before


def before(found: Direction, array: MicrophoneArray) -> Direction:
    """The direction as it would be if nobody asked whether the microphones contradict it."""
    assert found.fit is not None
    if not found.fit.excess:
        return replace(found, fit=None)
    axes = axes_of(array)
    added = np.diag(found.fit.excess / array.axes[1][: len(axes)] ** 2)
    inflated = on_sphere(array, axes, found.towards, added) - 1e-12 * np.eye(2)
    return replace(found, covariance=np.maximum(found.covariance - inflated, 1e-6 * np.eye(2)), fit=None)


def trial(array_name: str, fault: str, samples: Array, truth: float) -> FaultTrial | None:
    """One sound → what is said of it; None where nothing is heard."""
    array, sound = ARRAYS[array_name], Sound(stamp=0.0, rate=RATE_HZ, samples=samples)
    found = locate(sound, array, speech_from=PRE_ROLL_S)
    if found is None:
        return None
    told = tuple(one.kind for one in check(sound, array, found=[found]) if one.serious)
    older = before(found, array)
    return FaultTrial(
        array=array_name,
        fault=fault,
        error=abs(wrap(found.azimuth - truth)),
        sd=found.azimuth_sd,
        is_sure=sure(found) and not told,
        sd_before=older.azimuth_sd,
        sure_before=sure(older),
        misfit=found.misfit,
        named=told,
    )


def faulty(
    name: str, samples: Array, other: tuple[str, Array], rng: np.random.Generator
) -> Iterator[tuple[str, Array]]:
    """The array's sound (N, M), and that of the `other` one that the profile does not describe → every fault's."""
    for fault, make in FAULTS.items():
        yield fault, make(samples, rng)
    for fault, order in orders(ARRAYS[name]).items():
        yield fault, samples[:, list(order)]
    yield other


def campaign(
    rooms: int, seed: int, names: Sequence[str] = tuple(ARRAYS), most: int | None = None
) -> list[FaultTrial]:
    """All arrays in so many rooms: sound, and with `most` faults drawn (all of them without)."""
    done: list[FaultTrial | None] = []
    for number in range(rooms):
        rng = np.random.default_rng([seed, number])
        voice = practice_voice(rng, SPEECH, RATE_HZ)
        wrong = list(PLACED)[number % len(PLACED)]
        both = [one for name in names for one in (ARRAYS[name], PLACED[wrong](ARRAYS[name], rng))]
        scene = make_scene(rng, REVERBERATION_TIMES_S[number % len(REVERBERATION_TIMES_S)], voice, both)
        truth = math.atan2(scene.towards[1], scene.towards[0])
        noise = NOISES[number // len(REVERBERATION_TIMES_S) % len(NOISES)]
        for place, name in enumerate(names):
            samples = scene.sound(2 * place, *noise).samples
            done.append(trial(name, "", samples, truth))
            other = wrong, scene.sound(2 * place + 1, *noise).samples
            faults = list(faulty(name, samples, other, rng))
            chosen = range(len(faults)) if most is None else rng.permutation(len(faults))[:most]
            done += [trial(name, *faults[one], truth) for one in chosen]
    return [one for one in done if one is not None]


def _one_moved(array: MicrophoneArray, rng: np.random.Generator) -> MicrophoneArray:
    positions, angle = array.positions.copy(), rng.uniform(-math.pi, math.pi)
    positions[int(rng.integers(len(positions)))] += MOVED * np.array([math.cos(angle), math.sin(angle), 0.0])
    return replace(array, positions=positions)


def _one_mirrored(array: MicrophoneArray, rng: np.random.Generator) -> MicrophoneArray:
    positions = array.positions.copy()
    positions[int(rng.integers(len(positions))), 0] *= -1
    return replace(array, positions=positions)


def _wider(array: MicrophoneArray, _: np.random.Generator) -> MicrophoneArray:
    return replace(array, positions=WIDER * array.positions)


PLACED: dict[str, Callable[[MicrophoneArray, np.random.Generator], MicrophoneArray]] = {
    "moved by 1 cm": _one_moved,
    "mirrored place": _one_mirrored,
    "wrong spacing": _wider,
}


def leave_one_out(done: Sequence[FaultTrial]) -> dict[str, tuple[float, float, float]]:
    """For every array: the limit of the misfit that the others choose, and with it the array's share of faults that
    do not mislead and of whole arrays that are sure. The limit loses least: faults that mislead, sound ones doubted.
    """

    def shares(some: Sequence[FaultTrial], limit: float) -> tuple[float, float]:
        misled = [one.misled_before and one.misfit <= limit for one in some if one.fault]
        doubted = [one.sure_before and one.misfit > limit for one in some if not one.fault]
        return 1 - float(np.mean(misled)), 1 - float(np.mean(doubted))

    found: dict[str, tuple[float, float, float]] = {}
    for name in dict.fromkeys(one.array for one in done):
        others = [one for one in done if one.array != name]
        limit = max(LIMITS, key=lambda each, others=others: sum(shares(others, each)))
        found[name] = (limit, *shares([one for one in done if one.array == name], limit))
    return found


def figures(some: Sequence[FaultTrial]) -> dict[str, float]:
    """How often directions mislead, and how often they are sure."""
    return {
        "sounds": len(some),
        "covered_or_not_sure": float(np.mean([not one.misleads for one in some])),
        "before": float(np.mean([not one.misled_before for one in some])),
        "sure": float(np.mean([one.is_sure for one in some])),
        "sure_before": float(np.mean([one.sure_before for one in some])),
        "told": float(np.mean([bool(one.named) for one in some])),
    }


def main(
    *,
    faults: int = 200,  # at least
    seed: int = 41,
) -> None:
    each = 4
    rooms = math.ceil(faults / (each * len(ARRAYS)))
    done = campaign(rooms, seed, most=each)
    rows = {"faults": [one for one in done if one.fault], "sound arrays": [one for one in done if not one.fault]}
    for name, fault in itertools.product(ARRAYS, ("", "any fault")):
        rows[f"{name}, {fault or 'sound'}"] = [
            one for one in done if one.array == name and bool(one.fault) == bool(fault)
        ]
    for fault in dict.fromkeys(one.fault for one in done if one.fault):
        rows[fault] = [one for one in done if one.fault == fault]
    for row, some in rows.items():
        if some:
            print_row(f"{row}: {json.dumps({key: round(value, 3) for key, value in figures(some).items()})}")
    for name, (limit, covered, certain) in leave_one_out(done).items():
        print_row(f"{name} left out: limit {limit}, faults {covered:.3f}, sound arrays sure {certain:.3f}")


if __name__ == "__main__":
    run_command(main)
